"""Effects: parts of a machine's mechanics that can be included or left out."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.registry import Registry

P = TypeVar("P")
"""A problem: everything a scene says about its parts."""


class Effect(NamedTuple):
    """Something physical that a model may contain or not: all that the planner knows of it.

    It is applied by its name: the mechanics bring in what it is about where the model has it, `Model.part`.

    Attributes
    ----------
    name : str
        Its name in scenes.
    adds : str
        The part of the model that it adds, in words.
    instead : str
        Its replacement when it is left out.
    bound : callable or None
        `bound(problem, answer)` returns an upper bound of |ln(with it / without it)| of every number of each of n cases,
        shape (n,) or (1,), from the answer to them without it, in a part of the time of solving them; without an answer
        a smaller or equal value. An effect that has none is simulated wherever a scene gives
        its data: so are all but those of which leaving out saves time that a benchmark can see.
    cost : float
        Time that it adds to each case, roughly [s].
    needs : callable
        `needs(problem)` returns the scene keys that are missing for it; empty where it can be simulated.

    Examples
    --------
    >>> weight = Effect(name="weight", adds="its weight", instead="no weight")
    >>> "weight" in Model(problem=None, effects=frozenset({weight.name})).effects
    True
    """

    name: str
    adds: str
    instead: str
    bound: Callable[[Any, Any], FloatArray] | None = None
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

    `distance(answer, reference, whole)` is the largest change of any number, as a share of it with all effects in.
    Answers of a system that says nothing else have `logs`, of all their numbers.
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


def stiff_law(problem: Any) -> tuple[str, ...]:
    """Return what stands against the stiffness of a rope as an effect: a law that has it already."""
    twice = problem.friction is not None and "bending-stiffness" in problem.friction.law.effects
    return ("friction.law (bending has the stiffness in it already)",) if twice else ()


def applicable(effects: Mapping[str, Effect], problem: Any) -> dict[str, Effect]:
    """Return the effects for which a problem says all they need, by name and in their order."""
    return {name: one for name, one in effects.items() if not one.needs(problem)}


def log_change(logs: FloatArray, others: FloatArray) -> float:
    """Return the largest |difference|; inf where only one of two is a number."""
    same = (logs == others) | (np.isnan(logs) & np.isnan(others))
    with np.errstate(invalid="ignore"):
        apart = np.where(same, 0.0, np.abs(logs - others))
    return float(np.max(np.where(np.isnan(apart), math.inf, apart)))


def closed_form_system(
    name: str, effects: Registry[Effect], solve: Callable[[Any], Any], *, error: float, why: str
) -> System:
    """Return the system of a machine whose answers cost next to nothing and have `logs`, of all their numbers."""
    method = Method(name="closed form", error=error, why=why)
    return System(
        name=name,
        effects=effects,
        model=Model,
        method=lambda model, budget: method,  # noqa: ARG005
        solve=lambda model, method: solve(model),  # noqa: ARG005
    )


def law_effects(
    wheel: str,
    rope: str,
    needs: Callable[[Any], tuple[str, ...]] = lambda problem: (),  # noqa: ARG005  (needs nothing)
    *,
    tension: str = "",
) -> tuple[Effect, ...]:
    """Return the effects of a law's regressors on a wheel, by the names of the wheel and of the rope.

    Where the tension is an effect by itself, `tension` names it; else it goes with the wrap.
    """
    words = {
        "wrap-dependence": ("wrap and tension", "its average at the reference wrap and tension"),
        "size": (
            f"the {wheel}'s radius over the {rope}'s",
            "the coefficient at the reference wheel and rope",
        ),
    }
    if tension:
        whole = f"how far the {rope} wraps", "its average at the reference wrap, over the whole wrap"
        words |= {"wrap-dependence": whole}
        words |= {"end-tension": (tension, "the coefficient at the reference end tension")}
    return tuple(
        Effect(name, f"a coefficient that depends on {what}", instead, needs=needs)
        for name, (what, instead) in words.items()
    )
