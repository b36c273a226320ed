"""Belts that part leave with equal tensions."""

from ropefric.systems.press.closures.closure import Closure, Statement
from ropefric.systems.press.closures.meeting import leaving_span, partings
from ropefric.systems.press.machine import Press

__all__ = ["CLOSURE"]


def _statements(press: Press) -> tuple[Statement, ...]:
    return tuple(
        Statement(
            coefficients={leaving_span(press, roller, first): 1.0, leaving_span(press, roller, second): -1.0}
        )
        for roller, first, second in partings(press)
    )


CLOSURE = Closure(
    name="equal",
    rule="belts leave the roller where they part with the same tension: T9 = T10",
    basis="an even split, whatever the drivers do",
    statements=_statements,
)
