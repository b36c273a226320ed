"""The effects a lift's traction may be checked with."""

from ropefric.systems.effect import Method, System, missing
from ropefric.systems.subsets import closed_form_system
from ropefric.systems.traction.sheave import TractionAnswer, TractionModel, TractionProblem, solve_traction


def _pulleys(problem: TractionProblem) -> tuple[str, ...]:
    heavy = problem.car_pulley_kg is not None or problem.counterweight_pulley_kg is not None
    lacking = () if heavy else ("pulleys.car_side or pulleys.counterweight_side",)
    return (*lacking, *missing({"deceleration_m_s2": "lift.deceleration"})(problem))


SYSTEM: System[TractionProblem, TractionModel, TractionAnswer] = closed_form_system(
    "traction",
    "effect of a traction sheave",
    solve_traction,
    (
        (
            "rope-weight",
            "the weight of the ropes, on the car's or the counterweight's side by where the car is",
            "ropes without weight",
            missing({"linear_density_kg_m": "ropes.linear_density"}),
        ),
        (
            "deceleration",
            "the inertia of car, load, counterweight and ropes in an emergency stop",
            "a stop so soft that only the weights count",
            missing({"deceleration_m_s2": "lift.deceleration"}),
        ),
        (
            "pulley-inertia",
            "the inertia of the deflector pulleys in an emergency stop",
            "pulleys without mass",
            _pulleys,
        ),
        (
            "speed",
            "a coefficient that falls with the rope's speed in an emergency stop, by 1 + v/(10 m/s)",
            "the coefficient at rest",
            missing({"speed_m_s": "lift.speed"}),
        ),
        (
            "wrap-dependence",
            "a coefficient that depends on wrap and tension",
            "its average at the reference wrap and tension",
            missing({"friction": "friction"}),
        ),
        (
            "size",
            "a coefficient that depends on the sheave's radius over the rope's",
            "the coefficient at the reference wheel and rope",
            missing({"friction": "friction"}),
        ),
    ),
    Method(
        name="closed form",
        error=1e-12,
        why="weights, inertia and an exponential; there is nothing to approximate",
    ),
)
"""A lift on its traction sheave."""
