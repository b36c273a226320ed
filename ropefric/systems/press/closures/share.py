"""Drivers of equal surface speed and belts of equal stiffness share the work of the rollers they press together."""

from ropefric.systems.press.closures.closure import Closure, Statement
from ropefric.systems.press.closures.creep import creep_statements
from ropefric.systems.press.machine import Press

__all__ = ["CLOSURE"]


def _statements(press: Press) -> tuple[Statement, ...]:
    return creep_statements(
        press,
        axial_stiffness_N={belt.name: 1.0 for belt in press.belts},
        overspeed={roller.name: 0.0 for roller in press.rollers if roller.role == "driver"},
    )


CLOSURE = Closure(
    name="share",
    rule="each belt gains the same tension from where the belts meet to its driver: T9 - T4 = T10 - T14",
    basis="steady creep with equal surface speed of the drivers and equal EA of the belts",
    statements=_statements,
)
