"""Why a scene is solved the way it is: every effect with its bound and, if wanted, its measured worth and time."""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from typing import Any

from ropefric.errors import RopefricError
from ropefric.scenes.jsonable import finite, method_tree
from ropefric.scenes.plan import Decision, Plan, make_plan
from ropefric.scenes.scene import Scene, placed
from ropefric.systems.effect import Effect, assemble

_REPEATS = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectWorth:
    """What one effect turned out to be worth."""

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
        return {
            "system": self.system,
            "accuracy": self.plan.accuracy,
            "error_bound": finite(self.plan.error_bound),
            "method": method_tree(self.plan.method),
            "effects": [
                _effect_tree(decision, effect, found)
                for decision, effect, found in zip(self.plan.decisions, self.effects, worth, strict=True)
            ],
            "measured": None
            if self.worth is None
            else {
                "planned_s": finite(self.planned_s),
                "all_effects_s": finite(self.all_s),
                "difference": finite(self.difference),
            },
        }


def _effect_tree(decision: Decision, effect: Effect[Any, Any], worth: EffectWorth) -> dict[str, Any]:
    return {
        "name": decision.name,
        "simulated": decision.fate == "simulated",
        "fate": decision.fate,
        "bound": finite(decision.bound),
        "why": decision.why,
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
        if decision.fate == "not applicable":
            worth.append(EffectWorth())
            continue
        try:
            other, other_s = solved(simulated ^ {decision.name})
        except RopefricError:
            # A model may have no answer without an effect that another one in it relies on.
            worth.append(EffectWorth())
            continue
        if decision.name in simulated:
            share = max(0.0, 1.0 - other_s / planned_s) if planned_s > 0.0 else math.nan
            worth.append(EffectWorth(worth=system.distance(other, planned), time_share=share))
        else:
            worth.append(EffectWorth(worth=system.distance(planned, other)))
    everything, all_s = solved({one.name for one in plan.decisions if one.fate != "not applicable"})
    return Explanation(
        system=told.system,
        plan=plan,
        effects=told.effects,
        worth=tuple(worth),
        planned_s=planned_s,
        all_s=all_s,
        difference=system.distance(planned, everything),
    )
