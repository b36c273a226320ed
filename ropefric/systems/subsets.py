"""How much effects matter where a solution costs next to nothing: every subset of them is solved."""

import math
from collections.abc import Callable
from functools import lru_cache
from itertools import combinations
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import RopefricError

_ROUNDING = 1e-12


def subset_bounds(
    numbers: Callable[[Any, frozenset[str]], FloatArray], applicable: Callable[[Any], tuple[str, ...]]
) -> Callable[[str], Callable[[Any], float]]:
    """Return `influence_of(name)`: the largest change an effect makes in any number, whatever else is simulated.

    `numbers(problem, effects)` returns the logarithms of an answer's numbers, `applicable(problem)` the effects that
    can change them at all. From leaving out one effect after the other, what several change is at most the sum of what
    each does. A number that is there with an effect and not without it, or the other way round, has no bound.
    """

    @lru_cache(maxsize=2)
    def changes(problem: Any) -> dict[str, float]:
        names = applicable(problem)
        subsets = [frozenset(some) for k in range(len(names) + 1) for some in combinations(names, k)]
        try:
            with np.errstate(all="ignore"):
                found = {subset: numbers(problem, subset) for subset in subsets}
        except RopefricError:
            return dict.fromkeys(names, math.inf)
        worst = dict.fromkeys(names, 0.0)
        for subset in subsets:
            for name in subset:
                change = log_change(found[subset], found[subset - {name}])
                worst[name] = max(worst[name], change)
        return {name: one and one * (1.0 + _ROUNDING) + _ROUNDING for name, one in worst.items()}

    return lambda name: lambda problem: changes(problem).get(name, 0.0)


def log_change(logs: FloatArray, others: FloatArray) -> float:
    """Return the largest |difference|; inf where only one of two is a number."""
    same = (logs == others) | (np.isnan(logs) & np.isnan(others))
    with np.errstate(invalid="ignore"):
        apart = np.where(same, 0.0, np.abs(logs - others))
    return float(np.max(np.where(np.isnan(apart), math.inf, apart)))
