"""Machines whose solution costs next to nothing: how much effects matter is found by solving every subset of them."""

import math
from collections.abc import Callable, Iterable
from functools import lru_cache
from itertools import combinations
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import RopefricError
from ropefric.registry import Registry
from ropefric.systems.effect import Effect, Method, Model, System

_ROUNDING = 1e-12

Row = tuple[str, str, str, Callable[[Any], tuple[str, ...]]]
"""An effect: its name, what it adds, what stands instead, what it needs."""


def law_rows(wheel: str, rope: str, needs: Callable[[Any], tuple[str, ...]]) -> tuple[Row, Row]:
    """Return the effects of what a law is told of a contact on a wheel, by the names of the wheel and of the rope."""
    wrapped = (
        "a coefficient that depends on wrap and tension",
        "its average at the reference wrap and tension",
    )
    sized = f"a coefficient that depends on the {wheel}'s radius over the {rope}'s"
    return (
        ("wrap-dependence", *wrapped, needs),
        ("size", sized, "the coefficient at the reference wheel and rope", needs),
    )


def largest_changes(
    names: Iterable[str], logs: Callable[[frozenset[str]], FloatArray], *, rounding: float = _ROUNDING
) -> dict[str, float]:
    """Return how much each effect changes any of the numbers at most, whatever others are simulated.

    `logs(effects)` returns their logarithms. From leaving out one effect after the other, what several change is at
    most the sum of what each does. A number that is there with an effect and not without it, or the other way round,
    has no bound, nor has anything where a subset of the effects has no answer.
    """
    worst = dict.fromkeys(names, 0.0)
    subsets = [frozenset(some) for k in range(len(worst) + 1) for some in combinations(worst, k)]
    try:
        with np.errstate(all="ignore"):
            found = {some: logs(some) for some in subsets}
    except RopefricError:
        return dict.fromkeys(worst, math.inf)
    for subset in subsets:
        for one in subset:
            worst[one] = max(worst[one], log_change(found[subset], found[subset - {one}]))
    return {one: most and most * (1.0 + rounding) + rounding for one, most in worst.items()}


def closed_form_system(
    name: str,
    title: str,
    solve: Callable[[Any], Any],
    rows: tuple[Row, ...],
    method: Method,
) -> System[Any, Any, Any]:
    """Return the system of a machine whose answers have `logs`, the logarithms of their numbers."""

    @lru_cache(maxsize=2)
    def changes(problem: Any) -> dict[str, float]:
        names = [one for one, _, _, needs in rows if not needs(problem)]
        return largest_changes(names, lambda effects: solve(Model(problem=problem, effects=effects)).logs)

    def effect(
        one: str, adds: str, instead: str, needs: Callable[[Any], tuple[str, ...]]
    ) -> Effect[Any, Any]:
        return Effect(
            name=one,
            adds=adds,
            instead=instead,
            needs=needs,
            influence=lambda problem: changes(problem)[one],
            cost=0.05,
        )

    return System(
        name=name,
        effects=Registry(title, [effect(*row) for row in rows]),
        bare=lambda problem: Model(problem=problem),
        method=lambda model, budget: method,  # noqa: ARG005
        solve=lambda model, method: solve(model),  # noqa: ARG005
        distance=lambda answer, reference: float(np.expm1(log_change(answer.logs, reference.logs))),
        solved_whole=True,
    )


def log_change(logs: FloatArray, others: FloatArray) -> float:
    """Return the largest |difference|; inf where only one of two is a number."""
    same = (logs == others) | (np.isnan(logs) & np.isnan(others))
    with np.errstate(invalid="ignore"):
        apart = np.where(same, 0.0, np.abs(logs - others))
    return float(np.max(np.where(np.isnan(apart), math.inf, apart)))
