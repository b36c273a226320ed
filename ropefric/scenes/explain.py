"""Influence of each effect of a scene, by leaving it out once, and its time."""

import math
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import RopefricError
from ropefric.scenes.kind import finite
from ropefric.scenes.plan import Plan, method_tree, plan_scene, solve_planned
from ropefric.scenes.scene import Scene, placed
from ropefric.scenes.solve import Solution
from ropefric.shown import Shown
from ropefric.systems.effect import assemble

_ROUNDS = (2, 25)
_LONG_S = 0.5
"""Least and largest number of rounds of timing, and the time [s] of all that stops them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Explanation(Shown):
    """A plan with its effects and their influence.

    Attributes
    ----------
    system : str
        Name of the system.
    plan : Plan
        With the influence of each effect, and its time if that was measured.
    planned_s, all_s : float
        Median time of planning and solving, as asked and with all effects [s]; NaN where it was not measured.
    spread_s : float
        Width of the middle half of their differences, of runs that followed each other [s].
    difference : float
        Relative difference of the planned answer to that with all effects; NaN where one of them has no answer.
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
    spread_s: float = math.nan
    difference: float = math.nan

    @property
    def saved_s(self) -> float:
        """Return the time that leaving effects out saves, planning included [s]; NaN where it was not measured."""
        return self.all_s - self.planned_s

    @property
    def is_measured(self) -> bool:
        """Return whether the clock was read."""
        return not math.isnan(self.planned_s)

    def to_dict(self) -> dict[str, Any]:
        """Return the explanation as a JSON tree; unknown values are null."""
        measured = {name: getattr(self, name) for name in ("planned_s", "saved_s", "spread_s", "difference")}
        measured["all_effects_s"] = self.all_s
        numbers = ("bound", "worth", "time_s", "time_spread_s")
        return {
            "system": self.system,
            "accuracy": self.plan.accuracy,
            "error_bound": finite(self.plan.error_bound),
            "method": method_tree(self.plan.method),
            "effects": [
                one._asdict()
                | {name: finite(getattr(one, name)) for name in numbers}
                | {"simulated": one.fate == "simulated", "missing": list(one.missing)}
                for one in self.plan.decisions
            ],
            "measured": {name: finite(one) for name, one in measured.items()} if self.is_measured else None,
        }


def explain_scene(
    scene: Scene, *, measure: bool = False, clock: Callable[[], float] = time.perf_counter
) -> Explanation:
    """Return how a scene is solved, and the influence of each of its effects."""
    with placed(scene.document):
        try:
            plan, own = solve_planned(scene, scene.problem)
        except RopefricError:
            # What has no answer has a plan all the same, or says what is wrong with it.
            if measure:
                raise
            return Explanation(system=scene.kind.name, plan=plan_scene(scene, scene.problem)[0])
        explained = _weighed(scene, plan, own)
        return _timed(scene, explained, clock) if measure else explained


def explain_solution(solution: Solution) -> Explanation:
    """Return the influence of each effect on an answer that is known; the scene is not solved a second time."""
    with placed(solution.scene.document):
        return _weighed(solution.scene, solution.plan, solution.answer)


def _runs(scene: Scene, plan: Plan) -> dict[str, Callable[[], Any]]:
    """Return for each effect that the scene gives what solves the model as planned, but for that effect."""
    system, simulated = scene.kind.system, frozenset(plan.simulated)

    def solved(names: frozenset[str]) -> Any:
        return system.solve(assemble(system, scene.problem, names), plan.method)

    names = [one.name for one in plan.decisions if one.fate != "not applicable"]
    return {name: partial(solved, simulated ^ {name}) for name in names}


def _weighed(scene: Scene, plan: Plan, own: Any) -> Explanation:
    """Return a plan with the influence of each effect: the change of the answer with it left out, or added."""
    distance, everything, worth = scene.kind.system.distance, own, dict[str, float]()
    explained = Explanation(system=scene.kind.name, plan=plan)
    with suppress(RopefricError):
        if plan.left_out:
            everything = solve_planned(scene, scene.problem, "all")[1]
        explained = replace(explained, difference=distance(own, everything, everything))
        for name, solve in _runs(scene, plan).items():
            # A model may have no answer without an effect that another one in it relies on.
            with suppress(RopefricError):
                pair = (solve(), own) if name in plan.simulated else (own, solve())
                worth[name] = distance(*pair, everything)
    decisions = tuple(one._replace(worth=worth.get(one.name, math.nan)) for one in plan.decisions)
    return replace(explained, plan=plan._replace(decisions=decisions))


def _timed(scene: Scene, explained: Explanation, clock: Callable[[], float]) -> Explanation:
    """Return an explanation with times: medians of runs that take turns, and how far these are apart."""
    system, plan, problem = scene.kind.system, explained.plan, scene.problem
    solves = _runs(scene, plan)
    weighed = [one.name for one in plan.decisions if not math.isnan(one.worth)]
    times_s = _in_turn(
        {
            "": lambda: system.solve(assemble(system, problem, plan.simulated), plan.method),
            **{name: solves[name] for name in weighed},
            "planned": lambda: solve_planned(scene, problem),
            "all": lambda: solve_planned(scene, problem, "all"),
        },
        clock,
    )
    decisions = []
    for one in plan.decisions:
        if one.name in weighed:
            is_in = one.fate == "simulated"
            apart_s = (times_s[""] - times_s[one.name]) * (1.0 if is_in else -1.0)
            spread_s, time_s = _spread(apart_s), float(np.median(apart_s))
            time_s = time_s if time_s > spread_s else math.nan
            one = one._replace(time_s=time_s, time_spread_s=spread_s)  # noqa: PLW2901
        decisions.append(one)
    return replace(
        explained,
        plan=plan._replace(decisions=tuple(decisions)),
        planned_s=float(np.median(times_s["planned"])),
        all_s=float(np.median(times_s["all"])),
        spread_s=_spread(times_s["all"] - times_s["planned"]),
    )


def _in_turn(runs: Mapping[str, Callable[[], Any]], clock: Callable[[], float]) -> dict[str, FloatArray]:
    """Return the times of each run in every round."""
    times: dict[str, list[float]] = {name: [] for name in runs}
    began = clock()
    for rounds in range(_ROUNDS[1]):
        if rounds >= _ROUNDS[0] and clock() - began > _LONG_S:
            break
        for name, run in runs.items():
            start = clock()
            run()
            times[name].append(clock() - start)
    return {name: np.array(found) for name, found in times.items()}


def _spread(apart_s: FloatArray) -> float:
    """Return the width of the middle half."""
    low, high = np.quantile(apart_s, [0.25, 0.75])
    return float(high - low)
