"""The rope on a wheel as a system for scenes."""

import numpy as np

from ropefric.systems.effect import Method, System
from ropefric.systems.hoist.contact import HoistModel, Lift, solve_lift
from ropefric.systems.hoist.effects import EFFECTS, bare
from ropefric.systems.hoist.problem import HoistProblem

__all__ = ["SYSTEM"]

_CLOSED_FORM = Method(
    name="closed form",
    error=1e-12,
    why="the wrap integral and the end tension's root are exact to rounding; a coarser rule would save microseconds",
)


def _method(model: HoistModel, budget: float) -> Method:  # noqa: ARG001  (the signature of `System.method`)
    return _CLOSED_FORM


def _solve(model: HoistModel, method: Method) -> Lift:  # noqa: ARG001  (the signature of `System.solve`)
    return solve_lift(model)


def _distance(answer: Lift, reference: Lift) -> float:
    return float(np.max(np.abs(np.expm1(answer.log_lift - reference.log_lift))))


SYSTEM: System[HoistProblem, HoistModel, Lift] = System(
    name="hoist", effects=EFFECTS, bare=bare, method=_method, solve=_solve, distance=_distance
)
"""A rope on a wheel."""
