"""What an effect of a system is: something the mechanics may be assembled with, or done without, and its bound."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, Generic, TypeVar

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import RopefricError
from ropefric.registry import Registry

P = TypeVar("P")
"""A problem: everything a scene says about its parts."""
M = TypeVar("M")
"""A model: the mechanics put together for one problem, ready to be solved."""
A = TypeVar("A")
"""An answer."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Effect(Generic[P, M]):
    """Something physical that a model may contain or not.

    Attributes
    ----------
    name : str
        Its name in scenes.
    adds : str
        What it brings into the model, in words.
    instead : str
        What stands in its place when it is left out.
    needs : callable
        `needs(problem)` returns the scene keys that are missing for it; empty where it can be simulated.
    influence : callable
        `influence(problem)` returns an upper bound of |ln(answer with it / answer without it)|, whatever other
        effects are simulated; `inf` where no bound is known. Called only where nothing is missing.
    apply : callable or None
        `apply(model, problem)` returns the model with the effect in it. Called only where it is simulated. Without
        it the name is added to `model.effects`, which the mechanics look into.
    cost : float
        Time it adds to a solution, as a share of solving without it; for deciding which of two to leave out.

    Examples
    --------
    >>> heavier = Effect(name="weight", adds="its weight", instead="no weight", cost=0.1,
    ...     influence=lambda problem: 0.02, apply=lambda model, problem: model + problem)
    >>> heavier.apply(1.0, 0.5)
    1.5
    """

    name: str
    adds: str
    instead: str
    influence: Callable[[P], float]
    cost: float
    needs: Callable[[P], tuple[str, ...]] = lambda problem: ()  # noqa: ARG005  (needs nothing)
    apply: Callable[[M, P], M] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Method:
    """How a model is solved."""

    name: str
    settings: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    error: float
    why: str


@dataclass(frozen=True, slots=True, kw_only=True)
class System(Generic[P, M, A]):
    """A kind of machine: its bare model, the effects it may have, how it is solved.

    `solved_whole`: simulating everything is quicker than to find out what could be left out.
    """

    name: str
    effects: Registry[Effect[P, M]]
    bare: Callable[[P], M]
    method: Callable[[M, float], Method]
    solve: Callable[[M, Method], A]
    distance: Callable[[A, A], float]
    solved_whole: bool = False


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


def assemble(system: System[P, M, A], problem: P, simulated: Iterable[str]) -> M:
    """Return the model of a problem with the named effects in it and no others."""
    wanted = {system.effects[name].name for name in simulated}
    model: Any = system.bare(problem)
    for effect in system.effects.values():
        if effect.name in wanted and effect.apply is not None:
            model = effect.apply(model, problem)
        elif effect.name in wanted:
            model = replace(model, effects=model.effects | {effect.name})
    return model  # type: ignore[no-any-return]


def missing(keys: Mapping[str, str]) -> Callable[[Any], tuple[str, ...]]:
    """Return the `needs` of an effect: fields of the problem that may be None, and how scenes call them."""
    return lambda problem: tuple(key for name, key in keys.items() if getattr(problem, name) is None)


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
