"""Which effects a scene needs for the accuracy wanted, which method is enough, and why: what each is worth."""

import math
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import accumulate
from statistics import median
from typing import Any, Literal, NamedTuple, TypeVar

from ropefric.errors import InputError, RopefricError
from ropefric.scenes.kind import finite
from ropefric.scenes.scene import Scene, placed
from ropefric.systems.effect import Effect, Method, System, assemble

P = TypeVar("P")
M = TypeVar("M")
A = TypeVar("A")

_METHOD_SHARE = 0.1
"""What the method may err by at least, of the accuracy: no effects are left out for the sake of the last tenth."""

Fate = Literal["simulated", "left out", "not applicable"]


class Decision(NamedTuple):
    """What became of one effect and why; what it turned out to be worth, and its share of the time, if measured."""

    name: str
    fate: Fate
    bound: float
    why: str
    missing: tuple[str, ...] = ()
    adds: str = ""
    instead: str = ""
    worth: float = math.nan
    time_share: float = math.nan


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """What is simulated, how, and how far that can be from simulating everything."""

    decisions: tuple[Decision, ...]
    method: Method
    accuracy: float
    error_bound: float

    @property
    def simulated(self) -> tuple[str, ...]:
        """Return the names of the effects in the model."""
        return tuple(decision.name for decision in self.decisions if decision.fate == "simulated")

    @property
    def left_out(self) -> tuple[str, ...]:
        """Return the names of the effects that could have been simulated and are not."""
        return tuple(decision.name for decision in self.decisions if decision.fate == "left out")

    @property
    def keeps_accuracy(self) -> bool:
        """Return whether the error bound is within the accuracy wanted; a list of effects may break it."""
        return self.error_bound <= self.accuracy


def make_plan(
    system: System[P, M, A],
    problem: P,
    *,
    accuracy: float,
    effects: str | tuple[str, ...],
    all_bounds: bool = False,
) -> tuple[Plan, M]:
    """Return the plan for a problem, and the model assembled to it.

    With "auto" the effects with the smallest bounds are left out as long as all bounds together, and the method's
    error, stay within the accuracy; none where to solve it whole is quicker than that. Bounds are of
    |Δ ln answer|, so they add up.
    """
    every = list(system.effects.values())
    missing = {effect.name: effect.needs(problem) for effect in every}
    simulated = {name for name, keys in missing.items() if not keys}
    applicable = [effect for effect in every if effect.name in simulated]
    chosen = effects == "auto" and not system.solved_whole
    if isinstance(effects, tuple):
        simulated = {system.effects[name].name for name in effects}
        _refuse_impossible({name: missing[name] for name in effects if missing[name]})
    bounds = {
        effect.name: effect.influence(problem)
        for effect in applicable
        if all_bounds or chosen or effect.name not in simulated
    }
    if chosen:
        simulated -= _left_out(applicable, bounds, accuracy)
    total = sum(bound for name, bound in bounds.items() if name not in simulated)
    model = assemble(system, problem, simulated)
    left_out_error = _relative(total)
    # What the method errs by counts on top of an answer that may be off by what was left out already.
    budget = max(accuracy - left_out_error, _METHOD_SHARE * accuracy) / (1.0 + min(left_out_error, 1.0))
    method = system.method(model, budget)
    error_bound = left_out_error
    if left_out_error < math.inf:
        error_bound += method.error * (1.0 + left_out_error)
    spared = -1.0 if chosen else accuracy
    decisions = tuple(
        _decide(one, missing[one.name], bounds, is_in=one.name in simulated, effects=effects, spared=spared)
        for one in every
    )
    return Plan(decisions=decisions, method=method, accuracy=accuracy, error_bound=error_bound), model


def _left_out(applicable: list[Effect[Any, Any]], bounds: dict[str, float], accuracy: float) -> set[str]:
    """Return what can be left out: the smallest influence first, the dearer of two equal ones first."""
    order = sorted(applicable, key=lambda one: (bounds[one.name], -one.cost))
    spent = accumulate(bounds[one.name] for one in order)
    budget = math.log1p((1.0 - _METHOD_SHARE) * accuracy)
    return {one.name for one, sum_so_far in zip(order, spent, strict=True) if sum_so_far <= budget}


def _refuse_impossible(missing: dict[str, tuple[str, ...]]) -> None:
    for name, keys in missing.items():
        lacking = " and ".join(keys)
        raise InputError(
            f"the effect {name} cannot be simulated without {lacking}",
            code="RF502",
            key="effects",
            fix=f"add {lacking}, or take {name} off the list",
        )


def _decide(
    effect: Effect[Any, Any],
    missing: tuple[str, ...],
    bounds: dict[str, float],
    *,
    is_in: bool,
    effects: str | tuple[str, ...],
    spared: float,
) -> Decision:
    """Return what became of an effect; `spared` is the bound below which it is in because that costs no time."""
    bound = _relative(bounds.get(effect.name, math.nan))
    fate: Fate = "simulated" if is_in else "left out"
    worth = f"worth {'up to' if is_in else 'at most'} {bound:.2g} of the answer"
    if bound in {0.0, math.inf}:
        worth = "no bound is known" if bound else "cannot change the answer"
    if missing:
        fate, why = "not applicable", f"the scene does not give {' and '.join(missing)}"
    elif not is_in:
        why = f"{worth}; {effect.instead}"
    elif effects != "auto":
        why = "all effects are asked for" if effects == "all" else "asked for by name"
    elif bound > spared:
        why = worth
    else:
        why = f"{'' if math.isnan(bound) else worth + '; '}leaving it out would save no time"
    return Decision(effect.name, fate, bound, why, missing, effect.adds, effect.instead)


def _relative(log_change: float) -> float:
    return math.inf if log_change > 700.0 else math.expm1(log_change)


def method_tree(method: Method) -> dict[str, Any]:
    """Return how a model was solved as a JSON tree."""
    settings = dict(method.settings)
    return {"name": method.name, "settings": settings, "error": finite(method.error), "why": method.why}


_REPEATS = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class Explanation:
    """A plan, with what its effects are and what they are worth.

    Attributes
    ----------
    system : str
        Name of the system.
    plan : Plan
        With the bounds of all effects, and what they turned out to be worth if that was measured.
    planned_s, all_s : float
        Median time of solving as planned and with all effects [s]; NaN where it was not measured.
    difference : float
        Relative difference of the planned answer to that with all effects; NaN where it was not measured.
    """

    system: str
    plan: Plan
    planned_s: float = math.nan
    all_s: float = math.nan
    difference: float = math.nan

    @property
    def is_measured(self) -> bool:
        """Return whether the effects were solved with and without, and the clock read."""
        return not math.isnan(self.planned_s)

    def to_dict(self) -> dict[str, Any]:
        """Return the explanation as a JSON tree; what is not known is null."""
        measured = {"planned_s": self.planned_s, "all_effects_s": self.all_s, "difference": self.difference}
        return {
            "system": self.system,
            "accuracy": self.plan.accuracy,
            "error_bound": finite(self.plan.error_bound),
            "method": method_tree(self.plan.method),
            "effects": [
                one._asdict()
                | {name: finite(getattr(one, name)) for name in ("bound", "worth", "time_share")}
                | {"simulated": one.fate == "simulated", "missing": list(one.missing)}
                for one in self.plan.decisions
            ],
            "measured": {name: finite(one) for name, one in measured.items()} if self.is_measured else None,
        }


def explain_scene(
    scene: Scene, *, measure: bool = False, clock: Callable[[], float] = time.perf_counter
) -> Explanation:
    """Return why a scene is solved the way it is."""
    system = scene.kind.system
    try:
        plan, _ = make_plan(
            system, scene.problem, accuracy=scene.accuracy, effects=scene.effects, all_bounds=True
        )
        told = Explanation(system=scene.kind.name, plan=plan)
        return _measured(scene, told, clock) if measure else told
    except RopefricError as error:
        raise placed(error, scene.document) from error


def _measured(scene: Scene, told: Explanation, clock: Callable[[], float]) -> Explanation:
    system, plan = scene.kind.system, told.plan
    simulated = set(plan.simulated)

    def solved(names: set[str]) -> tuple[Any, float]:
        def once() -> Any:
            return system.solve(assemble(system, scene.problem, names), plan.method)

        answer = once()
        times = []
        for _ in range(_REPEATS):
            start = clock()
            once()
            times.append(clock() - start)
        return answer, median(times)

    planned, planned_s = solved(simulated)
    decisions = []
    for one in plan.decisions:
        found = one
        # A model may have no answer without an effect that another one in it relies on.
        with suppress(RopefricError):
            if one.fate == "simulated":
                other, other_s = solved(simulated - {one.name})
                share = max(0.0, 1.0 - other_s / planned_s) if planned_s > 0.0 else math.nan
                found = one._replace(worth=system.distance(other, planned), time_share=share)
            elif one.fate == "left out":
                found = one._replace(worth=system.distance(planned, solved(simulated | {one.name})[0]))
        decisions.append(found)
    everything, all_s = solved(simulated | set(plan.left_out))
    return replace(
        told,
        plan=replace(plan, decisions=tuple(decisions)),
        planned_s=planned_s,
        all_s=all_s,
        difference=system.distance(planned, everything),
    )
