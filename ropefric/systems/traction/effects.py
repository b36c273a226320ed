"""The effects a lift's traction may be checked with, and how much each can change any number of it at most."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.registry import Registry
from ropefric.systems.effect import Effect, Method, System, missing
from ropefric.systems.subsets import log_change, subset_bounds
from ropefric.systems.traction.sheave import TractionAnswer, TractionModel, TractionProblem, solve_traction


def _numbers(problem: TractionProblem, effects: frozenset[str]) -> FloatArray:
    return solve_traction(TractionModel(problem=problem, effects=effects)).logs


def _applicable(problem: TractionProblem) -> tuple[str, ...]:
    """Return the effects that can change a number: a law of one coefficient depends on nothing."""
    alike = problem.friction is None or not problem.friction.law.effects
    return tuple(
        effect.name
        for effect in EFFECTS.values()
        if not effect.needs(problem) and not (alike and effect.name in {"wrap-dependence", "size"})
    )


_influence_of = subset_bounds(_numbers, _applicable)


def _pulleys(problem: TractionProblem) -> tuple[str, ...]:
    heavy = problem.car_pulley_kg is not None or problem.counterweight_pulley_kg is not None
    lacking = () if heavy else ("pulleys.car_side or pulleys.counterweight_side",)
    return (*lacking, *missing({"deceleration_m_s2": "lift.deceleration"})(problem))


def _effect(name: str, adds: str, instead: str, needs: Callable[[TractionProblem], tuple[str, ...]]) -> Any:
    return Effect(
        name=name, adds=adds, instead=instead, needs=needs, influence=_influence_of(name), cost=0.05
    )


EFFECTS: Registry[Effect[TractionProblem, TractionModel]] = Registry(
    "effect of a traction sheave",
    (
        _effect(
            "rope-weight",
            "the weight of the ropes, on the car's or the counterweight's side by where the car is",
            "ropes without weight",
            missing({"linear_density_kg_m": "ropes.linear_density"}),
        ),
        _effect(
            "deceleration",
            "the inertia of car, load, counterweight and ropes in an emergency stop",
            "a stop so soft that only the weights count",
            missing({"deceleration_m_s2": "lift.deceleration"}),
        ),
        _effect(
            "pulley-inertia",
            "the inertia of the deflector pulleys in an emergency stop",
            "pulleys without mass",
            _pulleys,
        ),
        _effect(
            "speed",
            "a coefficient that falls with the rope's speed in an emergency stop, by 1 + v/(10 m/s)",
            "the coefficient at rest",
            missing({"speed_m_s": "lift.speed"}),
        ),
        _effect(
            "wrap-dependence",
            "a coefficient that depends on wrap and tension",
            "its average at the reference wrap and tension",
            missing({"friction": "friction"}),
        ),
        _effect(
            "size",
            "a coefficient that depends on the sheave's radius over the rope's",
            "the coefficient at the reference wheel and rope",
            missing({"friction": "friction"}),
        ),
    ),
)

_CLOSED_FORM = Method(
    name="closed form",
    error=1e-12,
    why="weights, inertia and an exponential; there is nothing to approximate",
)


def _distance(answer: TractionAnswer, reference: TractionAnswer) -> float:
    return float(np.expm1(log_change(answer.logs, reference.logs)))


SYSTEM: System[TractionProblem, TractionModel, TractionAnswer] = System(
    name="traction",
    effects=EFFECTS,
    bare=lambda problem: TractionModel(problem=problem),
    method=lambda model, budget: _CLOSED_FORM,  # noqa: ARG005
    solve=lambda model, method: solve_traction(model),  # noqa: ARG005
    distance=_distance,
)
"""A lift on its traction sheave."""
