"""The effects a hoist may be simulated with, and how much each can matter at most."""

from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import RopefricError
from ropefric.friction.laws.bending import lifted_arc_rad
from ropefric.registry import Registry
from ropefric.systems.checks import lean
from ropefric.systems.effect import Effect, System, closed_form_system, missing
from ropefric.systems.hoist.contact import HoistModel, HoistProblem, Lift, solve_lift

_LEVELS, _STEP = 5, 1e-4
"""Of each number that a law looks at, over its range; and the relative step of a slope there."""
_BETWEEN = 1.1
"""What a slope between two levels may exceed those at them by; at the ends of the range monotone slopes are largest."""


def stiffness_bound(problem: HoistProblem) -> FloatArray:
    """Return an upper bound of what the stiffness changes in any number, shape (n,): no law is solved case by case.

    With E/P of what presses gone and at most 2θ_B of the wrap, |Δ ln F_A| ≤ ln(P/(P − E)) + |ΔM|; M's slopes over wrap
    and tension are the largest of the range of all cases, whatever of a contact the law is told.
    """
    bound = np.full(problem.n, np.inf)
    wrap, end_N, stiff_N = map(lean, (problem.wrap_angle_rad, problem.end_tension_N, problem.bending_N))
    least_N, most_N = end_N - lean(problem.circling_N), end_N + lean(problem.weight_N)
    share = stiff_N / np.maximum(least_N, 2.0 * stiff_N + 1e-300)
    lost = 2.0 * lifted_arc_rad(share)
    known = np.broadcast_to((share < 0.5) & (lost < 0.5 * wrap), bound.shape)
    if not known.any():
        return bound
    if not known.all():
        wrap, end_N, least_N, most_N, stiff_N, share, lost = (
            np.broadcast_to(one, bound.shape)[known]
            for one in (wrap, end_N, least_N, most_N, stiff_N, share, lost)
        )
    pressed, shortened = -np.log1p(-share), -np.log1p(-lost / wrap)
    ends = {
        "wheel_radius_m": (problem.wheel_radius_m, problem.wheel_radius_m),
        "rope_radius_m": (problem.rope_radius_m, problem.rope_radius_m),
        "wrap_angle_rad": (wrap - lost, wrap),
        "slack_tension_N": (least_N - stiff_N, most_N),
    }
    ranges = {name: (float(low.min()), float(high.max())) for name, (low, high) in ends.items()}
    try:
        by_wrap, by_tension, own_wrap, own_tension = _slopes(problem, ranges)
    except RopefricError:  # somewhere in the range the law has no answer
        return bound
    lift = pressed + by_wrap * lost + by_tension * pressed
    coefficient = own_wrap * shortened + own_tension * pressed
    bound[slice(None) if known.all() else known] = np.maximum(np.maximum(lift, coefficient), shortened)
    return np.where(np.isnan(bound), np.inf, bound)


def _slopes(problem: HoistProblem, ranges: dict[str, tuple[float, float]]) -> tuple[float, ...]:
    """Return the largest |dM/dφ| and |dM/d ln P| over ranges of what a law is told, and those of ln(M/φ).

    Of parameters that differ from case to case, with those sets that have the least or the largest of any.
    """
    theta, own, levels = problem.friction.theta, problem.friction.reference, []
    if theta.ndim > 1:
        ends = np.unique([theta.argmin(axis=0), theta.argmax(axis=0)])
        sets = [replace(problem.friction, theta=theta[i]) for i in ends]
        return tuple(
            np.max([_slopes(replace(problem, friction=one), ranges) for one in sets], axis=0).tolist()
        )
    for name, (low, high) in ranges.items():
        stand_in = getattr(own, "end_tension_N" if name == "slack_tension_N" else name)
        levels.append(np.append(np.unique(np.geomspace(low, high, _LEVELS)), stand_in))
    corners = dict(zip(ranges, np.array(list(product(*levels))).T, strict=True))

    def exponent(**scaled: float) -> FloatArray:
        return problem.friction.exponent(
            **{name: one * scaled.get(name, 1.0) for name, one in corners.items()}
        )

    at, longer, tighter = (
        exponent(),
        exponent(wrap_angle_rad=1.0 + _STEP),
        exponent(slack_tension_N=1.0 + _STEP),
    )
    wrap, looks = corners["wrap_angle_rad"], problem.friction.law.effects
    step, tells = np.log1p(_STEP), float("end-tension" in looks)
    found = (
        np.maximum(np.abs(longer - at) / (_STEP * wrap), at / wrap).max(),
        tells * np.abs(tighter - at).max() / step,
        np.abs(np.log(longer / at) / step - 1.0).max(),
        tells * np.abs(np.log(tighter / at)).max() / step,
    )
    return tuple(_BETWEEN * float(one) for one in found)


def _stiffness_needs(problem: HoistProblem) -> tuple[str, ...]:
    if "bending-stiffness" in problem.friction.law.effects:
        return ("friction.law (bending has the stiffness in it already)",)
    return missing({"bending_stiffness_N_m2": "rope.bending_stiffness"})(problem)


EFFECTS: Registry[Effect[Any, Any]] = Registry(
    "effect of a hoist",
    (
        Effect(
            name="wrap-dependence",
            adds="a coefficient that depends on how far the rope wraps",
            instead="its average at the reference wrap, over the whole wrap",
            cost=1e-7,
        ),
        Effect(
            name="size",
            adds="a coefficient that depends on the wheel's radius over the rope's",
            instead="the coefficient at the reference wheel and rope",
            cost=5e-8,
        ),
        Effect(
            name="end-tension",
            adds="a coefficient that depends on the end tension (the wrap it stands for)",
            instead="the coefficient at the reference end tension",
            cost=1e-7,
        ),
        Effect(
            name="rope-weight",
            adds="the weight of the rope that hangs from the slack side, on top of the end tension",
            instead="a rope without weight",
            needs=missing(
                {"linear_density_kg_m": "rope.linear_density", "hanging_length_m": "rope.hanging_length"}
            ),
        ),
        Effect(
            name="centrifugal",
            adds="the tension rho v^2 that keeps the running rope on its circle and presses nothing",
            instead="a rope at rest",
            needs=missing({"linear_density_kg_m": "rope.linear_density", "speed_m_s": "wheel.speed"}),
        ),
        Effect(
            name="bending-stiffness",
            adds="the tension EI/(2 R^2) that bends the rope, and the arcs at both ends where it stands off",
            instead="a limp rope",
            needs=_stiffness_needs,
            each=stiffness_bound,
            cost=1e-6,
        ),
    ),
)
"""In the order in which they are applied."""

SYSTEM: System[HoistProblem, HoistModel, Lift] = closed_form_system(
    "hoist",
    EFFECTS,
    solve_lift,
    error=1e-12,
    why="the wrap integral and the end tension's root are exact to rounding; a coarser rule would save microseconds",
)
"""A rope on a wheel."""
