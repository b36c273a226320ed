"""Every closure by name; one file declares one closure."""

from ropefric.registry import Registry
from ropefric.systems.press.closures import equal, equal_torque, share, speed_ratio
from ropefric.systems.press.closures.closure import Closure

__all__ = ["CLOSURES"]

CLOSURES: Registry[Closure] = Registry(
    "closure", [share.CLOSURE, equal.CLOSURE, equal_torque.CLOSURE, speed_ratio.CLOSURE]
)
"""The closures; the first is the default."""
