"""The effects a rope on a wheel may be simulated with."""

from ropefric.systems.effect import Method, System, missing
from ropefric.systems.hoist.contact import HoistModel, HoistProblem, Lift, solve_lift
from ropefric.systems.subsets import closed_form_system


def _stiffness_needs(problem: HoistProblem) -> tuple[str, ...]:
    if "bending-stiffness" in problem.friction.law.effects:
        return ("friction.law (bending has the stiffness in it already)",)
    return missing({"bending_stiffness_N_m2": "rope.bending_stiffness"})(problem)


SYSTEM: System[HoistProblem, HoistModel, Lift] = closed_form_system(
    "hoist",
    "effect of a hoist",
    solve_lift,
    (
        (
            "wrap-dependence",
            "a coefficient that depends on how far the rope wraps",
            "its average at the reference wrap, over the whole wrap",
            missing({}),
        ),
        (
            "size",
            "a coefficient that depends on the wheel's radius over the rope's",
            "the coefficient at the reference wheel and rope",
            missing({}),
        ),
        (
            "end-tension",
            "a coefficient that depends on the end tension (the wrap it stands for)",
            "the coefficient at the reference end tension",
            missing({}),
        ),
        (
            "rope-weight",
            "the weight of the rope that hangs from the slack side, on top of the end tension",
            "a rope without weight",
            missing(
                {"linear_density_kg_m": "rope.linear_density", "hanging_length_m": "rope.hanging_length"}
            ),
        ),
        (
            "centrifugal",
            "the tension rho v^2 that keeps the running rope on its circle and presses nothing",
            "a rope at rest",
            missing({"linear_density_kg_m": "rope.linear_density", "speed_m_s": "wheel.speed"}),
        ),
        (
            "bending-stiffness",
            "the tension EI/(2 R^2) that bends the rope, and the arcs at both ends where it stands off",
            "a limp rope",
            _stiffness_needs,
        ),
    ),
    Method(
        name="closed form",
        error=1e-12,
        why="the wrap integral and the end tension's root are exact to rounding; a coarser rule would save microseconds",
    ),
)
"""A rope on a wheel."""
