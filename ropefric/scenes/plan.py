"""Which effects a scene needs for the accuracy wanted, and which method is enough."""

import math
from collections.abc import Iterable, Mapping
from itertools import accumulate
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

from ropefric.errors import InputError, RopefricError
from ropefric.scenes.kind import finite
from ropefric.scenes.scene import Scene
from ropefric.systems.effect import Effect, Method, System, applicable, assemble

_METHOD_SHARE = 0.1
"""Smallest error that the method may have, a fraction of the accuracy: no effects are left out for the last tenth."""
_LEAST_SAVED_S = 2e-3
"""An effect that takes less time than this in all is never left out."""
_DEAR_S = 1e-3
"""An effect that takes more time than this in a case is not simulated only to find its influence."""

Fate = Literal["simulated", "left out", "not applicable"]


class Decision(NamedTuple):
    """The use of one effect and its reason; its influence and its time, if measured."""

    name: str
    fate: Fate
    bound: float
    why: str
    missing: tuple[str, ...] = ()
    adds: str = ""
    instead: str = ""
    worth: float = math.nan
    time_s: float = math.nan
    time_spread_s: float = math.nan


class Plan(NamedTuple):
    """Simulated effects, method, and error bound against simulating everything."""

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
    kept: Mapping[str, str] = MappingProxyType({}),
) -> tuple[Plan, Any]:
    """Return the plan for a problem, and the model assembled to it.

    With "auto" the effects that cost time and have the smallest bounds are left out as long as all bounds together,
    and the method's error, stay within the accuracy; not those that are `kept`, by why. Bounds are of |Δ ln answer|,
    so they add up. How far a list is from everything is known once it is solved: until then its bound is infinite.
    """
    known = applicable(system.effects, problem)
    spare = [one for one in worth_asking(known.values(), 1) if one.name not in kept]
    bounds = {}
    if effects == "auto":
        bounds = {one.name: float(one.bound(problem, None).max()) for one in spare if one.bound}
    if isinstance(effects, tuple):
        _refuse_missing(system, problem, effects)
        simulated = known.keys() & set(effects)
    else:
        simulated = known.keys() - _left_out(bounds, room_for_effects(accuracy))
    model = assemble(system, problem, simulated)
    off = _relative(sum(bounds.get(name, math.inf) for name in known.keys() - simulated))
    # What the method errs by counts on top of an answer that may be off by what was left out already.
    method = system.method(model, max(accuracy - off, _METHOD_SHARE * accuracy) / (1.0 + min(off, 1.0)))
    decisions = tuple(
        _decided(one, problem, simulated, bounds, effects, kept) for one in system.effects.values()
    )
    return Plan(decisions, method, accuracy, _with_method(off, method)), model


def _left_out(bounds: Mapping[str, float], room: float) -> set[str]:
    """Return the effects of the smallest bounds, which together stay within the room."""
    order = sorted(bounds, key=lambda name: bounds[name])
    spent = accumulate(bounds[name] for name in order)
    return {name for name, sum_so_far in zip(order, spent, strict=True) if sum_so_far <= room}


def _refuse_missing(system: System, problem: Any, names: Iterable[str]) -> None:
    for name in names:
        if lacking := " and ".join(system.effects[name].needs(problem)):
            raise InputError(
                f"the effect {name} cannot be simulated without {lacking}",
                code="RF502",
                key="effects",
                fix=f"add {lacking}, or remove {name} from the list",
            )


def _decided(  # noqa: PLR0917  (facts of one plan)
    one: Effect,
    problem: Any,
    simulated: Iterable[str],
    bounds: Mapping[str, float],
    asked: str | tuple[str, ...],
    kept: Mapping[str, str],
) -> Decision:
    """Return what becomes of one effect, and why."""
    missing, bound = one.needs(problem), _relative(bounds.get(one.name, math.nan))
    fate: Fate = "not applicable" if missing else "simulated" if one.name in simulated else "left out"
    why = {
        "not applicable": f"the scene does not give {' and '.join(missing)}",
        "left out": f"instead: {one.instead}",
        "simulated": _why_simulated(one, bound, asked, kept),
    }[fate]
    if fate == "left out" and one.name in bounds:
        why = f"influence at most {bound:.2g} of the answer; {why}"
    return Decision(one.name, fate, bound, why, missing, one.adds, one.instead)


def _why_simulated(one: Effect, bound: float, asked: str | tuple[str, ...], kept: Mapping[str, str]) -> str:
    if asked != "auto":
        return "the scene requires all effects" if asked == "all" else "named in the scene"
    if one.name in kept:
        return kept[one.name]
    if math.isnan(bound):
        return "the scene gives its data; an effect without a bound is always simulated"
    return "no bound is known" if math.isinf(bound) else f"influence up to {bound:.2g} of the answer"


def _with_method(off: float, method: Method) -> float:
    return off + method.error * (1.0 + off) if off < math.inf else math.inf


def plan_scene(scene: Scene, problem: Any, effects: str | tuple[str, ...] = "") -> tuple[Plan, Any]:
    """Return the plan of a scene for a problem of its kind, with its effects or others, and the model."""
    kind, asked = scene.kind, effects or scene.effects
    return make_plan(kind.system, problem, accuracy=scene.accuracy, effects=asked, kept=kind.kept(problem))


def solve_planned(scene: Scene, problem: Any, effects: str | tuple[str, ...] = "") -> tuple[Plan, Any]:
    """Return the plan of a scene for a problem of its kind, with its effects or others, and the answer."""
    system, (plan, model) = scene.kind.system, plan_scene(scene, problem, effects)
    answer = system.solve(model, plan.method)
    if isinstance(effects or scene.effects, tuple):
        plan = plan._replace(error_bound=_with_method(_off_by(system, problem, plan, answer), plan.method))
    return plan, answer


def _off_by(system: System, problem: Any, plan: Plan, answer: Any) -> float:
    """Return how far the answer of a list of effects is from that of all of them."""
    try:
        whole, rest = nearly_whole(system, problem, plan, answer)
        return _relative(math.log1p(system.distance(answer, whole, whole)) + rest)
    except RopefricError:
        return math.inf


def nearly_whole(system: System, problem: Any, plan: Plan, answer: Any) -> tuple[Any, float]:
    """Return the answer with all effects but the expensive ones, and the bound of |Δ ln| of those.

    Effects that a list leaves out are simulated for that; expensive ones are covered by their bound.
    """
    left_out = [system.effects[name] for name in plan.left_out]
    dear = [one for one in left_out if one.cost >= _DEAR_S]
    if len(dear) < len(left_out):
        names = {*plan.simulated, *plan.left_out} - {one.name for one in dear}
        answer = system.solve(assemble(system, problem, names), plan.method)
    bounds = (math.inf if one.bound is None else float(one.bound(problem, answer).max()) for one in dear)
    return answer, sum(bounds)


def worth_asking(known: Iterable[Effect], cases: int) -> list[Effect]:
    """Return the effects that may be left out and take so long to simulate that this may save time."""
    return [one for one in known if one.bound is not None and one.cost * cases >= _LEAST_SAVED_S]


def room_for_effects(accuracy: float) -> float:
    """Return what |Δ ln answer| all effects left out may come to."""
    return math.log1p((1.0 - _METHOD_SHARE) * accuracy)


def _relative(log_change: float) -> float:
    return math.inf if log_change > 700.0 else math.expm1(log_change)


def method_tree(method: Method) -> dict[str, Any]:
    """Return how a model was solved as a JSON tree."""
    return method._asdict() | {"settings": dict(method.settings), "error": finite(method.error)}
