"""Which effects a scene needs for the accuracy wanted, which method is enough, and why: what each is worth."""

import math
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Decision:
    """What became of one effect, and why."""

    name: str
    fate: Fate
    bound: float
    why: str
    missing: tuple[str, ...] = ()


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
    error, stay within the accuracy. Bounds are of |Δ ln answer|, so they add up.
    """
    wanted = effects if isinstance(effects, tuple) else None
    missing = {effect.name: effect.needs(problem) for effect in system.effects.values()}
    if wanted is not None:
        _refuse_impossible(system, wanted, missing)
    applicable = [effect for effect in system.effects.values() if not missing[effect.name]]
    everything = {effect.name for effect in applicable}
    named = {"all": everything, "auto": set()}.get(str(effects), set(wanted or ()))
    bounds = {
        effect.name: effect.influence(problem)
        for effect in applicable
        if all_bounds or effect.name not in named
    }
    simulated = everything - _left_out(applicable, bounds, accuracy) if effects == "auto" else named
    total = sum(bounds[name] for name in bounds if name not in simulated)
    model = assemble(system, problem, simulated)
    left_out_error = math.expm1(total) if total < 700.0 else math.inf
    # What the method errs by counts on top of an answer that may be off by what was left out already.
    budget = max(accuracy - left_out_error, _METHOD_SHARE * accuracy) / (1.0 + min(left_out_error, 1.0))
    method = system.method(model, budget)
    error_bound = math.inf
    if math.isfinite(left_out_error):
        error_bound = left_out_error + method.error * (1.0 + left_out_error)
    decisions = tuple(
        _decide(effect, missing[effect.name], simulated, bounds, named=effects)
        for effect in system.effects.values()
    )
    return Plan(decisions=decisions, method=method, accuracy=accuracy, error_bound=error_bound), model


def _left_out(applicable: list[Effect[Any, Any]], bounds: dict[str, float], accuracy: float) -> set[str]:
    """Return what can be left out: the smallest influence first, the dearer of two equal ones first."""
    budget = math.log1p((1.0 - _METHOD_SHARE) * accuracy)
    spent, names = 0.0, set()
    for effect in sorted(applicable, key=lambda one: (bounds[one.name], -one.cost)):
        if spent + bounds[effect.name] > budget:
            break
        spent += bounds[effect.name]
        names.add(effect.name)
    return names


def _refuse_impossible(
    system: System[Any, Any, Any], wanted: tuple[str, ...], missing: dict[str, tuple[str, ...]]
) -> None:
    for name in wanted:
        lacking = missing[system.effects[name].name]
        if lacking:
            raise InputError(
                f"the effect {name} cannot be simulated without {' and '.join(lacking)}",
                code="RF502",
                key="effects",
                fix=f"add {' and '.join(lacking)}, or take {name} off the list",
            )


def _decide(
    effect: Effect[Any, Any],
    missing: tuple[str, ...],
    simulated: set[str],
    bounds: dict[str, float],
    *,
    named: str | tuple[str, ...],
) -> Decision:
    fate: Fate = "simulated" if effect.name in simulated else "left out"
    log_bound = bounds.get(effect.name, math.nan)
    bound = math.expm1(log_bound) if not log_bound > 700.0 else math.inf
    if missing:
        fate, why = "not applicable", f"the scene does not give {' and '.join(missing)}"
    elif fate == "left out":
        reason = "cannot change the answer" if bound == 0.0 else f"worth at most {bound:.2g} of the answer"
        why = f"{reason}; {effect.instead}"
    elif named != "auto":
        why = "all effects are asked for" if named == "all" else "asked for by name"
    else:
        why = "no bound is known" if math.isinf(bound) else f"worth up to {bound:.2g} of the answer"
    return Decision(name=effect.name, fate=fate, bound=bound, why=why, missing=missing)


def method_tree(method: Method) -> dict[str, Any]:
    """Return how a model was solved as a JSON tree."""
    settings = dict(method.settings)
    return {"name": method.name, "settings": settings, "error": finite(method.error), "why": method.why}


_REPEATS = 5


class EffectWorth(NamedTuple):
    """What one effect turned out to be worth, and its share of the time."""

    worth: float = math.nan
    time_share: float = math.nan


@dataclass(frozen=True, slots=True, kw_only=True)
class Explanation:
    """A plan, with what its effects are and what they are worth.

    Attributes
    ----------
    system : str
        Name of the system.
    plan : Plan
        With the bounds of all effects.
    effects : tuple of Effect
        In the order of the plan's decisions.
    worth : tuple of EffectWorth, or None
        In the same order; None where it was not measured.
    planned_s, all_s : float
        Median time of solving as planned and with all effects [s]; NaN where it was not measured.
    difference : float
        Relative difference of the planned answer to that with all effects; NaN where it was not measured.
    """

    system: str
    plan: Plan
    effects: tuple[Effect[Any, Any], ...]
    worth: tuple[EffectWorth, ...] | None = None
    planned_s: float = math.nan
    all_s: float = math.nan
    difference: float = math.nan

    def to_dict(self) -> dict[str, Any]:
        """Return the explanation as a JSON tree; what is not known is null."""
        worth = self.worth or (EffectWorth(),) * len(self.effects)
        measured = {"planned_s": self.planned_s, "all_effects_s": self.all_s, "difference": self.difference}
        return {
            "system": self.system,
            "accuracy": self.plan.accuracy,
            "error_bound": finite(self.plan.error_bound),
            "method": method_tree(self.plan.method),
            "effects": [
                _effect_tree(decision, effect, found)
                for decision, effect, found in zip(self.plan.decisions, self.effects, worth, strict=True)
            ],
            "measured": None if self.worth is None else {name: finite(one) for name, one in measured.items()},
        }


def _effect_tree(decision: Decision, effect: Effect[Any, Any], worth: EffectWorth) -> dict[str, Any]:
    return asdict(decision) | {
        "simulated": decision.fate == "simulated",
        "bound": finite(decision.bound),
        "missing": list(decision.missing),
        "adds": effect.adds,
        "instead": effect.instead,
        "worth": finite(worth.worth),
        "time_share": finite(worth.time_share),
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
        told = Explanation(system=scene.kind.name, plan=plan, effects=tuple(system.effects.values()))
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
    worth = []
    for decision in plan.decisions:
        found = EffectWorth()
        # A model may have no answer without an effect that another one in it relies on.
        with suppress(RopefricError):
            if decision.fate == "simulated":
                other, other_s = solved(simulated - {decision.name})
                share = max(0.0, 1.0 - other_s / planned_s) if planned_s > 0.0 else math.nan
                found = EffectWorth(system.distance(other, planned), share)
            elif decision.fate == "left out":
                found = EffectWorth(system.distance(planned, solved(simulated | {decision.name})[0]))
        worth.append(found)
    everything, all_s = solved(simulated | set(plan.left_out))
    return replace(
        told,
        worth=tuple(worth),
        planned_s=planned_s,
        all_s=all_s,
        difference=system.distance(planned, everything),
    )
