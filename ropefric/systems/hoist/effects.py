"""The effects a rope on a wheel may be simulated with, and how much each can matter at most."""

from collections.abc import Callable
from dataclasses import replace

from ropefric.registry import Registry
from ropefric.systems.effect import Effect
from ropefric.systems.hoist.contact import HoistModel
from ropefric.systems.hoist.influence import (
    bending_bound,
    bending_N,
    bounded,
    centrifugal_bound,
    circling_N,
    told_bound,
    weight_bound,
    weight_N,
)
from ropefric.systems.hoist.problem import HoistProblem

__all__ = ["EFFECTS", "bare"]


def bare(problem: HoistProblem) -> HoistModel:
    """Return the model without any effect: one coefficient, a light and limp rope at rest, F_A = F_B e^{μφ}."""
    return HoistModel(
        friction=problem.friction,
        told=frozenset(),
        wheel_radius_m=problem.wheel_radius_m,
        rope_radius_m=problem.rope_radius_m,
        wrap_angle_rad=problem.wrap_angle_rad,
        end_tension_N=problem.end_tension_N,
    )


def _nothing(problem: HoistProblem) -> tuple[str, ...]:  # noqa: ARG001  (the signature of `needs`)
    return ()


def _needs(**keys: str) -> Callable[[HoistProblem], tuple[str, ...]]:
    def missing(problem: HoistProblem) -> tuple[str, ...]:
        return tuple(key for name, key in keys.items() if getattr(problem, name) is None)

    return missing


def _told(what: str) -> Callable[[HoistModel, HoistProblem], HoistModel]:
    def apply(model: HoistModel, problem: HoistProblem) -> HoistModel:  # noqa: ARG001  (the signature of `apply`)
        return replace(model, told=model.told | {what})

    return apply


def _circle(model: HoistModel, problem: HoistProblem) -> HoistModel:
    return replace(model, circling_N=circling_N(problem))


def _hang(model: HoistModel, problem: HoistProblem) -> HoistModel:
    return replace(model, end_tension_N=model.end_tension_N + weight_N(problem))


def _bend(model: HoistModel, problem: HoistProblem) -> HoistModel:
    return replace(model, bending_N=bending_N(problem))


def _stiffness_needs(problem: HoistProblem) -> tuple[str, ...]:
    if "bending-stiffness" in problem.friction.law.effects:
        return ("friction.law (bending has the stiffness in it already)",)
    return _needs(bending_stiffness_N_m2="rope.bending_stiffness")(problem)


EFFECTS: Registry[Effect[HoistProblem, HoistModel]] = Registry(
    "effect of a hoist",
    (
        Effect(
            name="wrap-dependence",
            adds="a coefficient that depends on how far the rope wraps",
            instead="its average at the reference wrap, over the whole wrap",
            needs=_nothing,
            influence=bounded(told_bound("wrap")),
            apply=_told("wrap"),
            cost=0.3,
        ),
        Effect(
            name="size",
            adds="a coefficient that depends on the wheel's radius over the rope's",
            instead="the coefficient at the reference wheel and rope",
            needs=_nothing,
            influence=bounded(told_bound("size")),
            apply=_told("size"),
            cost=0.1,
        ),
        Effect(
            name="end-tension",
            adds="a coefficient that depends on the end tension (the wrap it stands for)",
            instead="the coefficient at the reference end tension",
            needs=_nothing,
            influence=bounded(told_bound("end-tension")),
            apply=_told("end-tension"),
            cost=0.3,
        ),
        Effect(
            name="rope-weight",
            adds="the weight of the rope that hangs from the slack side, on top of the end tension",
            instead="a rope without weight",
            needs=_needs(linear_density_kg_m="rope.linear_density", hanging_length_m="rope.hanging_length"),
            influence=bounded(weight_bound),
            apply=_hang,
            cost=0.05,
        ),
        Effect(
            name="centrifugal",
            adds="the tension rho v^2 that keeps the running rope on its circle and presses nothing",
            instead="a rope at rest",
            needs=_needs(linear_density_kg_m="rope.linear_density", speed_m_s="wheel.speed"),
            influence=bounded(centrifugal_bound),
            apply=_circle,
            cost=0.2,
        ),
        Effect(
            name="bending-stiffness",
            adds="the tension EI/(2 R^2) that bends the rope, and the arcs at both ends where it stands off",
            instead="a limp rope",
            needs=_stiffness_needs,
            influence=bounded(bending_bound),
            apply=_bend,
            cost=5.0,
        ),
    ),
)
"""In the order in which they are applied."""
