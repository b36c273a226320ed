"""The effects a traction sheave may be simulated with, and how much each can matter at most."""

from ropefric.registry import Registry
from ropefric.systems.effect import Effect, System, closed_form_system, law_effects, missing
from ropefric.systems.traction.sheave import TractionProblem, solve_traction


def _pulleys(problem: TractionProblem) -> tuple[str, ...]:
    heavy = problem.car_pulley_kg is not None or problem.counterweight_pulley_kg is not None
    lacking = () if heavy else ("pulleys.car_side or pulleys.counterweight_side",)
    return (*lacking, *missing({"deceleration_m_s2": "lift.deceleration"})(problem))


EFFECTS: Registry[Effect] = Registry(
    "effect of a traction sheave",
    (
        Effect(
            name="rope-weight",
            adds="the weight of the ropes, on the car's or the counterweight's side by where the car is",
            instead="ropes without weight",
            needs=missing({"linear_density_kg_m": "ropes.linear_density"}),
        ),
        Effect(
            name="deceleration",
            adds="the inertia of car, load, counterweight and ropes in an emergency stop",
            instead="a stop so soft that only the weights count",
            needs=missing({"deceleration_m_s2": "lift.deceleration"}),
        ),
        Effect(
            name="pulley-inertia",
            adds="the inertia of the deflector pulleys in an emergency stop",
            instead="pulleys without mass",
            needs=_pulleys,
        ),
        Effect(
            name="speed",
            adds="a coefficient that falls with the rope's speed in an emergency stop, by 1 + v/(10 m/s)",
            instead="the coefficient at rest",
            needs=missing({"speed_m_s": "lift.speed"}),
        ),
        *law_effects("sheave", "rope", missing({"friction": "friction"})),
    ),
)
"""In the order in which they are applied."""

SYSTEM: System = closed_form_system(
    "traction",
    EFFECTS,
    solve_traction,
    error=1e-12,
    why="weights, inertia and an exponential; there is nothing to approximate",
)
"""A lift on its traction sheave."""
