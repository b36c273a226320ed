"""Drivers of known speeds and belts of known stiffness: the split follows from steady creep."""

from ropefric.errors import InputError, Problem
from ropefric.systems.press.closures.closure import Closure, Statement
from ropefric.systems.press.closures.creep import creep_statements
from ropefric.systems.press.machine import Press

__all__ = ["CLOSURE"]


def _statements(press: Press) -> tuple[Statement, ...]:
    stiffness = {belt.name: belt.axial_stiffness_N for belt in press.belts}
    overspeed = {roller.name: roller.overspeed for roller in press.rollers if roller.role == "driver"}
    missing = [f"belts.{name}.axial_stiffness_N" for name, value in stiffness.items() if value is None]
    missing += [f"rollers.{name}.overspeed" for name, value in overspeed.items() if value is None]
    if missing:
        raise InputError(
            f"the closure 'speed-ratio' needs {', '.join(missing)}",
            code="RF521",
            key=missing[0],
            fix="give EA of every belt and (V - v)/v of every driver, or choose the closure 'share'",
            problems=[
                Problem(code="RF521", key=key, message=f"the closure 'speed-ratio' needs {key}")
                for key in missing
            ],
        )
    return creep_statements(
        press,
        axial_stiffness_N={name: value for name, value in stiffness.items() if value is not None},
        overspeed={name: value for name, value in overspeed.items() if value is not None},
    )


CLOSURE = Closure(
    name="speed-ratio",
    rule="(T9 - T4)/EA_upper - (T10 - T14)/EA_lower = (V1 - V10)/v",
    basis="steady creep with known EA of the belts and known surface speeds of the drivers",
    statements=_statements,
)
