"""From the bounds of many cases to the one number that a plan asks of an effect."""

import math
from collections.abc import Callable
from typing import TypeVar

import numpy as np

from ropefric.errors import RopefricError
from ropefric.friction.condition import FloatArray

__all__ = ["worst_case"]

P = TypeVar("P")


def worst_case(
    bound: Callable[[P], FloatArray],
    *,
    rounding: float,
    possible: Callable[[P], bool] = lambda problem: True,  # noqa: ARG005  (every problem)
) -> Callable[[P], float]:
    """Return an `influence`: the largest bound of all cases, `inf` where there is none.

    Parameters
    ----------
    bound : callable
        `bound(problem)` returns a bound of |Δ ln answer| for each case.
    rounding : float
        Relative and absolute error of computing it, which is added.
    possible : callable
        `possible(problem)` returns whether the problem has an answer with all effects in; where it has none,
        nothing may be left out.

    Examples
    --------
    >>> influence = worst_case(lambda problem: np.array([0.1, problem]), rounding=0.0)
    >>> influence(0.2), influence(float("nan"))
    (0.2, inf)
    """

    def influence(problem: P) -> float:
        if not possible(problem):
            return math.inf
        try:
            # Where a corner overflows or has no number, what it gives is no bound.
            with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
                worst = float(np.max(bound(problem)))
        except RopefricError:
            return math.inf
        if math.isnan(worst):
            return math.inf
        return worst * (1.0 + rounding) + (rounding if worst > 0.0 else 0.0)

    return influence
