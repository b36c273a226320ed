"""The ways of running the virtual rig, one a file."""

from ropefric.registry import Registry
from ropefric.rig.protocols import breakaway, held, stick_slip
from ropefric.rig.protocols.protocol import RigProtocol

__all__ = ["RIG_PROTOCOLS"]

RIG_PROTOCOLS: Registry[RigProtocol] = Registry(
    "rig protocol", [breakaway.PROTOCOL, stick_slip.PROTOCOL, held.PROTOCOL]
)
"""Every protocol by name: `RIG_PROTOCOLS["held"].measures_lift` is False."""
