"""Which effects a scene needs for the accuracy wanted, which method is enough, and why: what each is worth."""

import math
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import accumulate
from statistics import median
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

from ropefric.errors import InputError, RopefricError
from ropefric.scenes.kind import finite
from ropefric.scenes.scene import Scene, placed
from ropefric.shown import Shown
from ropefric.systems.effect import Effect, Method, System, assemble

_METHOD_SHARE = 0.1
"""What the method may err by at least, of the accuracy: no effects are left out for the sake of the last tenth."""
_LEAST_SAVED_S = 2e-3
"""An effect that takes less time than this in all is not worth asking whether it can go."""

Fate = Literal["simulated", "left out", "not applicable"]


class Decision(NamedTuple):
    """What became of one effect and why; what it turned out to be worth, and the time it takes, if measured."""

    name: str
    fate: Fate
    bound: float
    why: str
    missing: tuple[str, ...] = ()
    adds: str = ""
    instead: str = ""
    worth: float = math.nan
    time_share: float = math.nan
    time_s: float = math.nan


class Plan(NamedTuple):
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
    system: System,
    problem: Any,
    *,
    accuracy: float,
    effects: str | tuple[str, ...],
    all_bounds: bool = False,
    kept: Mapping[str, str] = MappingProxyType({}),
) -> tuple[Plan, Any]:
    """Return the plan for a problem, and the model assembled to it.

    With "auto" the effects that cost time and have the smallest bounds are left out as long as all bounds together,
    and the method's error, stay within the accuracy; not those that are `kept`, by why. Bounds are of |Δ ln answer|,
    so they add up.
    """
    every = list(system.effects.values())
    missing = {effect.name: effect.needs(problem) for effect in every}
    applicable = [effect for effect in every if not missing[effect.name]]
    simulated = {effect.name for effect in applicable}
    spare = [one for one in worth_asking(applicable, 1) if one.name not in kept] if effects == "auto" else []
    if isinstance(effects, tuple):
        simulated = {system.effects[name].name for name in effects}
        for name, lacking in ((name, " and ".join(missing[name])) for name in effects if missing[name]):
            raise InputError(
                f"the effect {name} cannot be simulated without {lacking}",
                code="RF502",
                key="effects",
                fix=f"add {lacking}, or take {name} off the list",
            )
    bounds = {
        effect.name: effect.influence(problem)
        for effect in applicable
        if all_bounds or effect in spare or effect.name not in simulated
    }
    # The smallest influence goes first, of two equal ones the dearer.
    order = sorted(spare, key=lambda one: (bounds[one.name], -one.cost))
    spent, room = accumulate(bounds[one.name] for one in order), room_for_effects(accuracy)
    simulated -= {one.name for one, sum_so_far in zip(order, spent, strict=True) if sum_so_far <= room}
    model = assemble(system, problem, simulated)
    left_out_error = _relative(sum(bound for name, bound in bounds.items() if name not in simulated))
    # What the method errs by counts on top of an answer that may be off by what was left out already.
    budget = max(accuracy - left_out_error, _METHOD_SHARE * accuracy) / (1.0 + min(left_out_error, 1.0))
    method = system.method(model, budget)
    error_bound = left_out_error
    if left_out_error < math.inf:
        error_bound += method.error * (1.0 + left_out_error)
    asked = {"all": "all effects are asked for", "auto": ""}.get(str(effects), "asked for by name")
    no_gain = "leaving it out would save no time"
    stays = {one.name: "" if one in spare else no_gain for one in every} | dict(kept)
    decisions = []
    for one in every:
        bound, why = _relative(bounds.get(one.name, math.nan)), ""
        is_in, keys = one.name in simulated, missing[one.name]
        if bound in {0.0, math.inf}:
            why = "no bound is known" if bound else "changes no number that is there without it"
        elif not math.isnan(bound):
            why = f"worth {'up to' if is_in else 'at most'} {bound:.2g} of the answer"
        if keys:
            why = f"the scene does not give {' and '.join(keys)}"
        elif asked and is_in:
            why = asked
        elif not is_in or not bound > accuracy:
            reason = stays[one.name] if is_in else f"instead: {one.instead}"
            detail = "" if is_in or one.detail is None else one.detail(problem)
            why = "; ".join(part for part in (why, reason, detail) if part)
        fate: Fate = "not applicable" if keys else "simulated" if is_in else "left out"
        decisions.append(Decision(one.name, fate, bound, why, keys, one.adds, one.instead))
    return Plan(tuple(decisions), method, accuracy, error_bound), model


def solve_planned(scene: Scene, problem: Any, effects: str | tuple[str, ...] = "") -> tuple[Plan, Any]:
    """Return the plan of a scene for a problem of its kind, with effects as it asks for or others, and the answer."""
    system, kept = scene.kind.system, scene.kind.kept(problem)
    plan, model = make_plan(
        system, problem, accuracy=scene.accuracy, effects=effects or scene.effects, kept=kept
    )
    return plan, system.solve(model, plan.method)


def worth_asking(applicable: list[Effect], cases: int) -> list[Effect]:
    """Return the effects that take so long to simulate that leaving them out may save time."""
    return [one for one in applicable if one.cost * cases >= _LEAST_SAVED_S]


def room_for_effects(accuracy: float) -> float:
    """Return what |Δ ln answer| all effects left out may come to."""
    return math.log1p((1.0 - _METHOD_SHARE) * accuracy)


def _relative(log_change: float) -> float:
    return math.inf if log_change > 700.0 else math.expm1(log_change)


def method_tree(method: Method) -> dict[str, Any]:
    """Return how a model was solved as a JSON tree."""
    return method._asdict() | {"settings": dict(method.settings), "error": finite(method.error)}


_REPEATS = 5
_LONG_S = 0.3
"""What has taken so long is not timed more than once."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Explanation(Shown):
    """A plan, with what its effects are and what they are worth.

    Attributes
    ----------
    system : str
        Name of the system.
    plan : Plan
        With the bounds of all effects, and what they turned out to be worth if that was measured.
    planned_s, all_s : float
        Median time of planning and solving, as asked and with all effects [s]; NaN where it was not measured.
    difference : float
        Relative difference of the planned answer to that with all effects; NaN where it was not measured.
    """

    _said = (
        "system",
        "plan.simulated",
        "plan.left_out",
        "plan.error_bound",
        "planned_s",
        "all_s",
        "difference",
    )
    _framed = "plan.decisions"

    system: str
    plan: Plan
    planned_s: float = math.nan
    all_s: float = math.nan
    difference: float = math.nan

    @property
    def saved_s(self) -> float:
        """Return the time that leaving effects out saves, planning included [s]; NaN where it was not measured."""
        return self.all_s - self.planned_s

    @property
    def is_measured(self) -> bool:
        """Return whether the effects were solved with and without, and the clock read."""
        return not math.isnan(self.planned_s)

    def to_dict(self) -> dict[str, Any]:
        """Return the explanation as a JSON tree; what is not known is null."""
        measured = {name: getattr(self, name) for name in ("planned_s", "saved_s", "difference")}
        measured["all_effects_s"] = self.all_s
        return {
            "system": self.system,
            "accuracy": self.plan.accuracy,
            "error_bound": finite(self.plan.error_bound),
            "method": method_tree(self.plan.method),
            "effects": [
                one._asdict()
                | {name: finite(getattr(one, name)) for name in ("bound", "worth", "time_share", "time_s")}
                | {"simulated": one.fate == "simulated", "missing": list(one.missing)}
                for one in self.plan.decisions
            ],
            "measured": {name: finite(one) for name, one in measured.items()} if self.is_measured else None,
        }


def explain_scene(
    scene: Scene, *, measure: bool = False, clock: Callable[[], float] = time.perf_counter
) -> Explanation:
    """Return why a scene is solved the way it is."""
    system, problem = scene.kind.system, scene.problem
    asked: dict[str, Any] = {"accuracy": scene.accuracy, "effects": scene.effects, "all_bounds": True}
    try:
        plan, _ = make_plan(system, problem, kept=scene.kind.kept(problem), **asked)
        told = Explanation(system=scene.kind.name, plan=plan)
        return _measured(scene, told, clock) if measure else told
    except RopefricError as error:
        raise placed(error, scene.document) from error


def _measured(scene: Scene, told: Explanation, clock: Callable[[], float]) -> Explanation:
    system, plan, problem = scene.kind.system, told.plan, scene.problem
    simulated = set(plan.simulated)

    def timed(once: Callable[[], Any]) -> tuple[Any, float]:
        times: list[float] = []
        # The first call warms up what is kept between calls.
        while len(times) < 2 or (len(times) <= _REPEATS and sum(times) < _LONG_S):
            start = clock()
            answer = once()
            times.append(clock() - start)
        return answer, median(times[1:])

    def solved(names: set[str]) -> tuple[Any, float]:
        return timed(lambda: system.solve(assemble(system, problem, names), plan.method))

    own, own_s = solved(simulated)
    (_, everything), all_s = timed(lambda: solve_planned(scene, problem, "all"))
    decisions = list(plan.decisions)
    for place, one in enumerate(plan.decisions):
        is_in = one.fate == "simulated"
        # A model may have no answer without an effect that another one in it relies on.
        with suppress(RopefricError):
            if one.fate != "not applicable":
                other, other_s = solved(simulated ^ {one.name})
                takes_s = max(0.0, own_s - other_s if is_in else other_s - own_s)
                worth = system.distance(*((other, own) if is_in else (own, other)), everything)
                share = takes_s / own_s if is_in and own_s > 0.0 else math.nan
                decisions[place] = one._replace(worth=worth, time_share=share, time_s=takes_s)
    planned_s = timed(lambda: solve_planned(scene, problem))[1]
    plan, difference = plan._replace(decisions=tuple(decisions)), system.distance(own, everything, everything)
    return replace(told, plan=plan, planned_s=planned_s, all_s=all_s, difference=difference)
