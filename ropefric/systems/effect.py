"""What an effect of a machine is: something its mechanics may be put together with or without, and its worth."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import combinations
from types import MappingProxyType
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import RopefricError
from ropefric.registry import Registry
from ropefric.systems.friction import TOLD, share_of_law

P = TypeVar("P")
"""A problem: everything a scene says about its parts."""


_SOMETHING = np.finfo(np.float64).tiny
"""Bound of what changes a number, if nothing else is known of it."""


def unknown(problem: object) -> float:  # noqa: ARG001
    """Return that nothing is known of what an effect is worth."""
    return math.inf


class Effect(NamedTuple):
    """Something physical that a model may contain or not: all that the planner knows of it.

    It is applied by its name: the mechanics bring in what it is about where the model has it, `Model.part`.

    Attributes
    ----------
    name : str
        Its name in scenes.
    adds : str
        What it brings into the model, in words.
    instead : str
        What stands in its place when it is left out.
    detail : callable or None
        `detail(problem)` returns what more is to be said of that, in words, where it is left out.
    needs : callable
        `needs(problem)` returns the scene keys that are missing for it; empty where it can be simulated.
    influence : callable
        `influence(problem)` returns an upper bound of |ln(with it / without it)| of every number of the answer,
        whatever other effects are simulated; `inf` where none is known. Called only where nothing is missing.
    each : callable or None
        `each(problem, answer)` returns such a bound for each of many cases, shape (n,) or (1,), in a part of the time of
        solving them, from the answer to them without it; without an answer what is known before, which is no more than
        that, and zero only where it changes nothing. An effect that has none is simulated in every sweep.
    cost : float
        Time that it adds to each case, roughly [s]. An effect that costs none is not left out to save time.

    Examples
    --------
    >>> weight = Effect(name="weight", adds="its weight", instead="no weight", influence=lambda problem: 0.02)
    >>> "weight" in Model(problem=None, effects=frozenset({weight.name})).effects
    True
    """

    name: str
    adds: str
    instead: str
    detail: Callable[[Any], str] | None = None
    influence: Callable[[Any], float] = unknown
    each: Callable[[Any, Any], FloatArray] | None = None
    cost: float = 0.0
    needs: Callable[[Any], tuple[str, ...]] = lambda problem: ()  # noqa: ARG005  (needs nothing)


class Method(NamedTuple):
    """How a model is solved."""

    name: str
    error: float
    why: str
    settings: Mapping[str, float] = MappingProxyType({})


def _distance(answer: Any, reference: Any, whole: Any) -> float:  # noqa: ARG001  (logarithms need no scale)
    return float(np.expm1(log_change(answer.logs, reference.logs)))


class System(NamedTuple):
    """A kind of machine: its model, the effects it may have, how it is solved, and how far two answers are apart.

    `distance(answer, reference, whole)` is a share of the numbers with all effects in, which bounds are of, too.
    Answers that say nothing else have `logs`, of all their numbers.
    """

    name: str
    effects: Registry[Effect]
    model: Callable[..., Any]
    method: Callable[[Any, float], Method]
    solve: Callable[[Any, Method], Any]
    distance: Callable[[Any, Any, Any], float] = _distance


@dataclass(frozen=True, kw_only=True, eq=False)  # no slots: a generic notes its type on what it makes
class Model(Generic[P]):
    """A problem with the effects that are simulated."""

    problem: P
    effects: frozenset[str] = frozenset()

    def part(self, effect: str, value: FloatArray | None) -> FloatArray:
        """Return what an effect brings in where it is simulated; zeros where it is not, or nothing is given."""
        if value is None or effect not in self.effects:
            return np.zeros(self.problem.n)  # type: ignore[attr-defined]
        return value


def assemble(system: System, problem: Any, simulated: Iterable[str]) -> Any:
    """Return the model of a problem with the named effects in it and no others."""
    return system.model(problem=problem, effects=frozenset(system.effects[name].name for name in simulated))


def missing(keys: Mapping[str, str]) -> Callable[[Any], tuple[str, ...]]:
    """Return the `needs` of an effect: fields of the problem that may be None, and how scenes call them."""
    return lambda problem: tuple(key for name, key in keys.items() if getattr(problem, name) is None)


def applicable(effects: Mapping[str, Effect], problem: Any) -> dict[str, Effect]:
    """Return the effects for which a problem says all they need, by name and in their order."""
    return {name: one for name, one in effects.items() if not one.needs(problem)}


def rounded_up(bound: float, rounding: float) -> float:
    """Return a bound with what rounding may have taken off it; inf where it is no number."""
    if math.isnan(bound):
        return math.inf
    return bound * (1.0 + rounding) + rounding * (bound > 0.0)


def largest_changes(
    names: Iterable[str], logs: Callable[[frozenset[str]], FloatArray], *, rounding: float = 1e-12
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
    for subset, one in ((some, one) for some in subsets for one in some):
        worst[one] = max(worst[one], log_change(found[subset], found[subset - {one}]))
    return {one: rounded_up(most, rounding) for one, most in worst.items()}


def log_change(logs: FloatArray, others: FloatArray) -> float:
    """Return the largest |difference|; inf where only one of two is a number."""
    same = (logs == others) | (np.isnan(logs) & np.isnan(others))
    with np.errstate(invalid="ignore"):
        apart = np.where(same, 0.0, np.abs(logs - others))
    return float(np.max(np.where(np.isnan(apart), math.inf, apart)))


def with_bounds(effects: Registry[Effect], changes: Callable[[Any], Mapping[str, float]]) -> Registry[Effect]:
    """Return effects of which those without an `influence` of their own have the changes of a problem by name."""

    def bounded(one: Effect) -> Effect:
        own = one.influence is unknown
        return one._replace(influence=lambda problem: changes(problem)[one.name]) if own else one

    return Registry(effects.kind, map(bounded, effects.values()))


def closed_form_system(
    name: str, effects: Registry[Effect], solve: Callable[[Any], Any], *, error: float, why: str
) -> System:
    """Return the system of a machine whose answers cost next to nothing and have `logs`, of all their numbers.

    What an effect is worth that has no `influence` of its own is found by solving all subsets of effects.
    """

    @lru_cache(maxsize=2)
    def changes(problem: Any) -> dict[str, float]:
        known = applicable(effects, problem)
        return largest_changes(known, lambda some: solve(Model(problem=problem, effects=some)).logs)

    method = Method(name="closed form", error=error, why=why)
    return System(
        name=name,
        effects=with_bounds(effects, changes),
        model=Model,
        method=lambda model, budget: method,  # noqa: ARG005
        solve=lambda model, method: solve(model),  # noqa: ARG005
    )


def law_bound(
    name: str,
    bound: Callable[[Any, Any], FloatArray],
    problem: Any,
    answer: Any = None,
    *,
    told: Mapping[str, object] = TOLD,
) -> FloatArray:
    """Return an upper bound of what an effect of the law changes in any number: its share of that of all of them.

    `bound(problem, answer)` is that of all of them, with what else the law is told left out; `told` has their names.
    """
    simulated = frozenset() if answer is None else answer.model.effects
    share = share_of_law(name, problem.friction.law, told, simulated)
    if not share:
        return np.zeros(1)
    with np.errstate(invalid="ignore", over="ignore"):
        most = bound(problem, answer)
    known = share * np.where(np.isnan(most), np.inf, most)
    return np.maximum(known, _SOMETHING) if answer is None else known


def law_effects(
    wheel: str,
    rope: str,
    needs: Callable[[Any], tuple[str, ...]],
    cost: float = 0.0,
    bound: Callable[[Any, Any], FloatArray] | None = None,
) -> tuple[Effect, ...]:
    """Return the effects of what a law is told of a contact on a wheel, by the names of the wheel and of the rope.

    `bound` is that of `law_bound`, if one is known.
    """
    words = {
        "wrap-dependence": (
            "a coefficient that depends on wrap and tension",
            "its average at the reference wrap and tension",
        ),
        "size": (
            f"a coefficient that depends on the {wheel}'s radius over the {rope}'s",
            "the coefficient at the reference wheel and rope",
        ),
    }
    each = {name: None if bound is None else partial(law_bound, name, bound) for name in words}
    return tuple(Effect(name, *said, needs=needs, cost=cost, each=each[name]) for name, said in words.items())
