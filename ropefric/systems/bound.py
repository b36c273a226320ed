"""From the bounds of many cases to the one number that a plan asks of an effect."""

import math
from collections.abc import Callable
from typing import TypeVar

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import RopefricError

P = TypeVar("P")


def worst_case(
    bound: Callable[[P], FloatArray],
    *,
    rounding: float,
    possible: Callable[[P], bool] = lambda problem: True,  # noqa: ARG005  (every problem)
) -> Callable[[P], float]:
    """Return an `influence`: the largest bound of all cases, `inf` where there is none."""

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
