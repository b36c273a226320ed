"""Ways of measuring, one file each."""

from ropefric.registry import Registry
from ropefric.traces.protocols import breakaway, held, stick_slip
from ropefric.traces.protocols.protocol import Protocol

PROTOCOLS: Registry[Protocol] = Registry("protocol", [breakaway.PROTOCOL, stick_slip.PROTOCOL, held.PROTOCOL])
"""Every protocol by name."""
