"""The effects a belt drive may be simulated with, and how much each can matter at most."""

import math
from functools import partial

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.registry import Registry
from ropefric.systems.beltdrive.drive import DriveAnswer, DriveProblem, solve_drive
from ropefric.systems.effect import Effect, System, closed_form_system, law_effects, missing

_ROOM = 0.5
"""Of ln P: how far what presses on the slack side may lie from where it does without an effect of the law."""


def _law_bound(problem: DriveProblem, answer: DriveAnswer | None) -> FloatArray:
    """Return an upper bound of what all that the law is not told changes in any number.

    A coefficient that changes by the factor e^d makes M of the pulley that slips first another by D = M (e^d − 1): no
    tension changes by more, no pull by more than D + d, no arc and no ratio of speeds by more than twice that. What
    presses on the slack side follows, so that D is one only as long as it stays in the range the law was asked for.
    """
    friction = problem.friction
    if answer is None and friction.theta.ndim > 1:
        return np.zeros(1)
    pressed_N = friction.reference.end_tension_N
    if answer is not None:
        pressing_N, slack_N = problem.tension_N - answer.circling_N, answer.full_slack_N - answer.circling_N
        pressed_N = np.stack([pressing_N, math.exp(-_ROOM) * slack_N, math.exp(_ROOM) * slack_N])
    # Where each case has parameters of its own the ranges are of each case as well.
    ends = [partial(way, axis=0 if friction.theta.ndim > 1 else None) for way in (np.min, np.max)]
    found = [
        friction.spread(
            wheel_radius_m=(radius_m.min(), radius_m.max()),
            rope_radius_m=(problem.rope_radius_m.min(), problem.rope_radius_m.max()),
            wrap_angle_rad=(wrap.min(), wrap.max()),
            slack_tension_N=(ends[0](pressed_N), ends[1](pressed_N)),
        )
        for radius_m, wrap in problem.pulleys
    ]
    off: FloatArray = np.max(found, axis=0)
    if answer is None:
        return off
    change = np.exp(off) * np.expm1(off) * np.nanmin(answer.exponents, axis=0)
    return np.where((off < _ROOM) & (change < _ROOM), 2.0 * (change + off), np.inf)


EFFECTS: Registry[Effect] = Registry(
    "effect of a belt drive",
    (
        Effect(
            name="centrifugal",
            adds="the tension m v^2 that keeps the running belt on its circle and presses nothing",
            instead="a belt at rest",
            needs=missing({"linear_density_kg_m": "belt.linear_density", "speed_rad_s": "driving.speed"}),
        ),
        Effect(
            name="wedge",
            adds="the flanks of the groove, that press with 1/sin(half its angle)",
            instead="a flat pulley",
            needs=missing({"groove_angle_rad": "belt.groove_angle"}),
        ),
        Effect(
            name="creep",
            adds="a belt that stretches where it adheres, so that the driven pulley runs slower and power is lost",
            instead="a belt that does not stretch; both rims run at one speed",
            needs=missing({"axial_stiffness_N": "belt.axial_stiffness"}),
        ),
        *law_effects("pulley", "belt", missing({}), 1e-7, _law_bound),
    ),
)
"""In the order in which they are applied."""

SYSTEM: System = closed_form_system(
    "beltdrive",
    EFFECTS,
    solve_drive,
    error=1e-11,
    why="an exponential and a balance of tensions; there is nothing to approximate",
)
"""A belt on one pulley or two."""
