"""The effects a belt drive may be simulated with, and how much each can change any number of it at most."""

from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.registry import Registry
from ropefric.systems.beltdrive.drive import DriveAnswer, DriveModel, DriveProblem, solve_drive
from ropefric.systems.effect import Effect, Method, System, missing
from ropefric.systems.subsets import log_change, subset_bounds

_OF_LAW = {"wrap-dependence", "size"}


def _numbers(problem: DriveProblem, effects: frozenset[str]) -> FloatArray:
    return solve_drive(DriveModel(problem=problem, effects=effects)).logs


def _applicable(problem: DriveProblem) -> tuple[str, ...]:
    """Return the effects that can change a number: a law of one coefficient depends on nothing."""
    alike = not problem.friction.law.effects
    return tuple(
        effect.name
        for effect in EFFECTS.values()
        if not effect.needs(problem) and not (alike and effect.name in _OF_LAW)
    )


_influence_of = subset_bounds(_numbers, _applicable)


def _effect(name: str, adds: str, instead: str, **needs: str) -> Any:
    influence = _influence_of(name)
    return Effect(name=name, adds=adds, instead=instead, needs=missing(needs), influence=influence, cost=0.05)


EFFECTS: Registry[Effect[DriveProblem, DriveModel]] = Registry(
    "effect of a belt drive",
    (
        _effect(
            "centrifugal",
            "the tension m v^2 that keeps the running belt on its circle and presses nothing",
            "a belt at rest",
            linear_density_kg_m="belt.linear_density",
            speed_rad_s="driving.speed",
        ),
        _effect(
            "wedge",
            "the flanks of the groove, that press with 1/sin(half its angle)",
            "a flat pulley",
            groove_angle_rad="belt.groove_angle",
        ),
        _effect(
            "creep",
            "a belt that stretches where it adheres, so that the driven pulley runs slower and power is lost",
            "a belt that does not stretch; both rims run at one speed",
            axial_stiffness_N="belt.axial_stiffness",
        ),
        _effect(
            "wrap-dependence",
            "a coefficient that depends on wrap and tension",
            "its average at the reference wrap and tension",
        ),
        _effect(
            "size",
            "a coefficient that depends on the pulley's radius over the belt's",
            "the coefficient at the reference wheel and rope",
        ),
    ),
)
"""In the order in which they are applied."""

_CLOSED_FORM = Method(
    name="closed form",
    error=1e-11,
    why="an exponential and a balance of tensions; there is nothing to approximate",
)


def _distance(answer: DriveAnswer, reference: DriveAnswer) -> float:
    return float(np.expm1(log_change(answer.logs, reference.logs)))


SYSTEM: System[DriveProblem, DriveModel, DriveAnswer] = System(
    name="beltdrive",
    effects=EFFECTS,
    bare=lambda problem: DriveModel(problem=problem),
    method=lambda model, budget: _CLOSED_FORM,  # noqa: ARG005
    solve=lambda model, method: solve_drive(model),  # noqa: ARG005
    distance=_distance,
)
"""A belt on one pulley or two."""
