"""The drivers pull with equal torque."""

from itertools import pairwise

from ropefric.systems.press.closures.closure import Closure, Statement
from ropefric.systems.press.closures.meeting import arriving_span, leaving_span
from ropefric.systems.press.machine import Press

__all__ = ["CLOSURE"]


def _statements(press: Press) -> tuple[Statement, ...]:
    belt_of = {name: belt.name for belt in press.belts for name in belt.loop}
    drivers = [roller for roller in press.rollers if roller.role == "driver"]
    stated = []
    for first, second in pairwise(drivers):
        terms: dict[str, float] = {}
        for driver, sign in ((first, 1.0), (second, -1.0)):
            lever = sign * driver.radius_m / first.radius_m
            for name, factor in (
                (arriving_span(press, driver.name, belt_of[driver.name]), lever),
                (leaving_span(press, driver.name, belt_of[driver.name]), -lever),
            ):
                terms[name] = terms.get(name, 0.0) + factor
        stated.append(Statement(coefficients=terms))
    return tuple(stated)


CLOSURE = Closure(
    name="equal-torque",
    rule="every driver turns its belt with the same torque: R1 (T9 - T1) = R10 (T10 - T11)",
    basis="drives that hold the torque, such as inverters sharing their load",
    statements=_statements,
)
