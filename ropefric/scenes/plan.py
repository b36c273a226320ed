"""Which effects a scene needs for the accuracy wanted, and which method is enough."""

import math
from dataclasses import dataclass
from typing import Any, Literal, TypeVar

from ropefric.errors import InputError
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
    if missing:
        why = f"the scene does not give {' and '.join(missing)}"
        return Decision(name=effect.name, fate="not applicable", bound=math.nan, why=why, missing=missing)
    log_bound = bounds.get(effect.name, math.nan)
    bound = math.expm1(log_bound) if not log_bound > 700.0 else math.inf
    if effect.name in simulated and named != "auto":
        asked = "all effects are asked for" if named == "all" else "asked for by name"
        return Decision(name=effect.name, fate="simulated", bound=bound, why=asked)
    if effect.name in simulated:
        why = "no bound is known" if math.isinf(bound) else f"worth up to {bound:.2g} of the answer"
        return Decision(name=effect.name, fate="simulated", bound=bound, why=why)
    reason = "cannot change the answer" if bound == 0.0 else f"worth at most {bound:.2g} of the answer"
    return Decision(name=effect.name, fate="left out", bound=bound, why=f"{reason}; {effect.instead}")
