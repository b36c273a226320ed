"""The effects a hoist may be simulated with, and how much each can matter at most."""

import math
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.friction.laws.bending import lifted_arc_rad
from ropefric.registry import Registry
from ropefric.systems.checks import lean
from ropefric.systems.effect import Effect, System, closed_form_system, law_bound, missing
from ropefric.systems.hoist.contact import TOLD, HoistProblem, Lift, solve_lift


class _Stiff(NamedTuple):
    """What a stiff rope loses at most, shape (n,) or (1,): ln P/(P − E) of what presses, and a share of its wrap."""

    pressing: FloatArray
    share: FloatArray


@lru_cache(maxsize=2)
def _stiff(problem: HoistProblem) -> _Stiff:
    """Return what stiffness takes, with the least P that any other effects leave, and 2θ_B of the wrap lifted."""
    stiff_N = lean(problem.bending_N)
    least_N = lean(problem.end_tension_N) - lean(problem.circling_N)
    share = stiff_N / np.maximum(least_N, 2.0 * stiff_N + 1e-300)
    lost = 2.0 * lifted_arc_rad(share) / lean(problem.wrap_angle_rad)
    known = (share < 0.5) & (lost < 0.5)
    return _Stiff(*(np.where(known, one, np.inf) for one in (-np.log1p(-np.minimum(share, 0.5)), lost)))


@lru_cache(maxsize=2)
def _spread(problem: HoistProblem) -> float:
    """Return by what factor, in logarithms, what the law is told changes any coefficient of any case at most.

    Of parameters that differ from case to case it is not known: a law has but one contact, and no bound is quicker.
    """
    end_N, stiff_N, wrap = map(lean, (problem.end_tension_N, problem.bending_N, problem.wrap_angle_rad))
    least_N = end_N - lean(problem.circling_N) - stiff_N
    contact = wrap * (1.0 - np.minimum(_stiff(problem).share, 0.5))
    many = problem.friction.theta.ndim > 1 and problem.friction.law.effects & TOLD.keys()
    if many or not (least_N > 0.0).all():
        return math.inf
    ranges = {
        "wheel_radius_m": (problem.wheel_radius_m, problem.wheel_radius_m),
        "rope_radius_m": (problem.rope_radius_m, problem.rope_radius_m),
        "wrap_angle_rad": (contact, wrap),
        "slack_tension_N": (least_N, end_N + lean(problem.weight_N)),
    }
    ends = {name: (low.min(), high.max()) for name, (low, high) in ranges.items()}
    return float(problem.friction.spread(**ends)[0])


def stiffness_bound(problem: HoistProblem, answer: Lift | None = None) -> FloatArray:
    """Return an upper bound of what the stiffness changes in any number: no law is solved for it.

    With E/P of what presses gone and the share s of the wrap, M of a law that weakens loses at most s M, as it is
    concave, and gains ln(P/(P − E)) at most; so |Δ ln F_A| ≤ ln(P/(P − E)) + s M, and M over the contact grows by the
    gain and 1/(1 − s). A law that is not told the wrap has the slope over P of another wrap, its reference.
    """
    friction, (pressing, share) = problem.friction, _stiff(problem)
    with np.errstate(divide="ignore", invalid="ignore"):
        shorter = -np.log1p(-share)
        bound = np.maximum(pressing, shorter)
        if answer is not None:
            theta, law, effects = friction.theta, friction.law, answer.model.effects
            wrap, own = lean(problem.wrap_angle_rad), friction.reference.wrap_angle_rad
            gain = pressing * lean(np.asarray(friction.scale))
            gain = gain * (1.0 if "wrap-dependence" in effects else np.maximum(1.0, wrap / own))
            # What of the law is left out as well may make M another.
            off = 1.0 if law.effects & TOLD.keys() <= effects else math.exp(_spread(problem))
            M, sound = lean(answer.exponent), law.weakens & (theta >= law.lower) & (theta <= law.upper)
            bound = np.maximum(
                np.maximum(pressing + off * share * M, gain), shorter + np.log1p(off * gain / M)
            )
            bound = np.where(np.all(sound, axis=-1), bound, np.inf)
    return np.where(np.isnan(bound), np.inf, bound)


def _law_bound(problem: HoistProblem, answer: Lift | None) -> FloatArray:
    """Return an upper bound of what all that the law is not told changes in any number.

    A coefficient that changes by the factor e^d makes M another by M (e^d − 1), and as much ln F_A; of a stiff rope the
    contact changes too, but by no more than the arcs that it stands off.
    """
    off = _spread(problem)
    if answer is None or not off:
        return np.array([off])
    most = np.exp(off) * answer.exponent
    lost = _stiff(problem).share if "bending-stiffness" in answer.model.effects else 0.0
    return np.asarray(np.maximum(off, most * np.expm1(off)) + lost / (1.0 - lost) * np.maximum(most, 1.0))


def _of_law(name: str, what: str, instead: str, cost: float) -> Effect:
    each = partial(law_bound, name, _law_bound, told=TOLD)
    return Effect(name, f"a coefficient that depends on {what}", instead, cost=cost, each=each)


def _stiffness_needs(problem: HoistProblem) -> tuple[str, ...]:
    if "bending-stiffness" in problem.friction.law.effects:
        return ("friction.law (bending has the stiffness in it already)",)
    return missing({"bending_stiffness_N_m2": "rope.bending_stiffness"})(problem)


EFFECTS: Registry[Effect] = Registry(
    "effect of a hoist",
    (
        _of_law(
            "wrap-dependence",
            "how far the rope wraps",
            "its average at the reference wrap, over the whole wrap",
            1e-7,
        ),
        _of_law(
            "size",
            "the wheel's radius over the rope's",
            "the coefficient at the reference wheel and rope",
            5e-8,
        ),
        _of_law(
            "end-tension",
            "the end tension (the wrap it stands for)",
            "the coefficient at the reference end tension",
            1e-7,
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

SYSTEM: System = closed_form_system(
    "hoist",
    EFFECTS,
    solve_lift,
    error=1e-12,
    why="the wrap integral and the end tension's root are exact to rounding; a coarser rule would save microseconds",
)
"""A rope on a wheel."""
