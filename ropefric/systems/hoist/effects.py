"""The effects a hoist may be simulated with, and what the stiffness can matter at most."""

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.friction.laws.bending import lifted_arc_rad
from ropefric.registry import Registry
from ropefric.systems.checks import lean
from ropefric.systems.effect import Effect, System, closed_form_system, law_effects, missing, stiff_law
from ropefric.systems.hoist.contact import HoistProblem, Lift, solve_lift


def stiffness_bound(problem: HoistProblem, answer: Lift | None = None) -> FloatArray:
    """Return an upper bound of what the stiffness changes in any number: no law is solved for it.

    With the share E/P of the pressing tension gone and the share s of the wrap, M of a law that weakens loses at most s
    M, as it is concave, and gains ln(P/(P − E)) at most; so |Δ ln F_A| ≤ ln(P/(P − E)) + s M, and M over the contact
    grows by the gain and 1/(1 − s). A law without the wrap as regressor has the slope over P of another wrap, its
    reference. P is the least that any other effects leave, and s = 2θ_B/φ. A law without regressors has no bound: it is
    solved as quickly with the stiffness as without.
    """
    friction, stiff_N = problem.friction, lean(problem.bending_N)
    if not friction.law.effects:
        return np.full(1, np.inf)
    least_N = lean(problem.end_tension_N) - lean(problem.circling_N)
    gone = stiff_N / np.maximum(least_N, 2.0 * stiff_N + 1e-300)
    share = 2.0 * lifted_arc_rad(gone) / lean(problem.wrap_angle_rad)
    known = (gone < 0.5) & (share < 0.5)
    pressing, share = (np.where(known, one, np.inf) for one in (-np.log1p(-np.minimum(gone, 0.5)), share))
    with np.errstate(divide="ignore", invalid="ignore"):
        shorter = -np.log1p(-share)
        bound = np.maximum(pressing, shorter)
        if answer is not None:
            theta, law = friction.theta, friction.law
            wrap, own = lean(problem.wrap_angle_rad), friction.reference.wrap_angle_rad
            gain = pressing * lean(np.asarray(friction.scale))
            if "wrap-dependence" not in answer.model.effects:
                gain = gain * np.maximum(1.0, wrap / own)
            M, sound = lean(answer.exponent), law.weakens & (theta >= law.lower) & (theta <= law.upper)
            bound = np.maximum(np.maximum(pressing + share * M, gain), shorter + np.log1p(gain / M))
            bound = np.where(np.all(sound, axis=-1), bound, np.inf)
    return np.where(np.isnan(bound), np.inf, bound)


def _stiffness_needs(problem: HoistProblem) -> tuple[str, ...]:
    return stiff_law(problem) or missing({"bending_stiffness_N_m2": "rope.bending_stiffness"})(problem)


EFFECTS: Registry[Effect] = Registry(
    "effect of a hoist",
    (
        *law_effects("wheel", "rope", tension="the end tension (as equivalent wrap)"),
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
            adds="the tension EI/(2 R^2) that bends the rope, and the arcs at both ends where it lifts off",
            instead="a limp rope",
            needs=_stiffness_needs,
            bound=stiffness_bound,
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
