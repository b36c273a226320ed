"""Machines whose solution costs next to nothing: how much effects matter is found by solving every subset of them."""

import math
from collections.abc import Callable
from functools import lru_cache
from itertools import combinations
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import RopefricError
from ropefric.registry import Registry
from ropefric.systems.effect import Effect, Method, Model, System
from ropefric.systems.friction import TOLD

_ROUNDING = 1e-12

Solve = Callable[[Model[Any]], Any]
"""Returns an answer that has `logs`, the logarithms of its numbers."""
Needs = Callable[[Any], tuple[str, ...]]


def closed_form_system(
    name: str, title: str, solve: Solve, rows: tuple[tuple[str, str, str, Needs], ...], method: Method
) -> System[Any, Any, Any]:
    """Return a system of effects given as name, what each adds, what stands instead, what it needs.

    An effect is worth at most the largest change it makes in any number, whatever else is simulated: from leaving out
    one effect after the other, what several change is at most the sum of what each does. A number that is there with
    an effect and not without it, or the other way round, has no bound.
    """

    @lru_cache(maxsize=2)
    def changes(problem: Any) -> dict[str, float]:
        # A law of one coefficient depends on nothing.
        alike = problem.friction is None or not problem.friction.law.effects
        names = [one for one, _, _, needs in rows if not needs(problem) and not (alike and one in TOLD)]
        subsets = [frozenset(some) for k in range(len(names) + 1) for some in combinations(names, k)]
        try:
            with np.errstate(all="ignore"):
                found = {some: solve(Model(problem=problem, effects=some)).logs for some in subsets}
        except RopefricError:
            return dict.fromkeys(names, math.inf)
        worst = dict.fromkeys(names, 0.0)
        for subset in subsets:
            for one in subset:
                worst[one] = max(worst[one], _log_change(found[subset], found[subset - {one}]))
        return {one: most and most * (1.0 + _ROUNDING) + _ROUNDING for one, most in worst.items()}

    def effect(one: str, adds: str, instead: str, needs: Needs) -> Effect[Any, Any]:
        return Effect(
            name=one,
            adds=adds,
            instead=instead,
            needs=needs,
            influence=lambda problem: changes(problem).get(one, 0.0),
            cost=0.05,
        )

    return System(
        name=name,
        effects=Registry(title, [effect(*row) for row in rows]),
        bare=lambda problem: Model(problem=problem),
        method=lambda model, budget: method,  # noqa: ARG005
        solve=lambda model, method: solve(model),  # noqa: ARG005
        distance=lambda answer, reference: float(np.expm1(_log_change(answer.logs, reference.logs))),
    )


def _log_change(logs: FloatArray, others: FloatArray) -> float:
    """Return the largest |difference|; inf where only one of two is a number."""
    same = (logs == others) | (np.isnan(logs) & np.isnan(others))
    with np.errstate(invalid="ignore"):
        apart = np.where(same, 0.0, np.abs(logs - others))
    return float(np.max(np.where(np.isnan(apart), math.inf, apart)))
