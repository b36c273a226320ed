"""The effects a belt drive may be simulated with."""

from ropefric.registry import Registry
from ropefric.systems.beltdrive.drive import DriveProblem, solve_drive
from ropefric.systems.effect import Effect, System, closed_form_system, law_effects, missing


def _centrifugal_needs(problem: DriveProblem) -> tuple[str, ...]:
    mass = {} if problem.density_kg_m3 is not None else {"linear_density_kg_m": "belt.linear_density"}
    return missing(mass | {"speed_rad_s": "driving.speed"})(problem)


EFFECTS: Registry[Effect] = Registry(
    "effect of a belt drive",
    (
        Effect(
            name="centrifugal",
            adds="the tension m v^2 that keeps the running belt on its circle and presses nothing",
            instead="a belt at rest",
            needs=_centrifugal_needs,
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
        *law_effects("pulley", "belt"),
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
