"""The effects a belt drive may be simulated with."""

from ropefric.systems.beltdrive.drive import DriveAnswer, DriveModel, DriveProblem, solve_drive
from ropefric.systems.effect import Method, System, missing
from ropefric.systems.subsets import closed_form_system

SYSTEM: System[DriveProblem, DriveModel, DriveAnswer] = closed_form_system(
    "beltdrive",
    "effect of a belt drive",
    solve_drive,
    (
        (
            "centrifugal",
            "the tension m v^2 that keeps the running belt on its circle and presses nothing",
            "a belt at rest",
            missing({"linear_density_kg_m": "belt.linear_density", "speed_rad_s": "driving.speed"}),
        ),
        (
            "wedge",
            "the flanks of the groove, that press with 1/sin(half its angle)",
            "a flat pulley",
            missing({"groove_angle_rad": "belt.groove_angle"}),
        ),
        (
            "creep",
            "a belt that stretches where it adheres, so that the driven pulley runs slower and power is lost",
            "a belt that does not stretch; both rims run at one speed",
            missing({"axial_stiffness_N": "belt.axial_stiffness"}),
        ),
        (
            "wrap-dependence",
            "a coefficient that depends on wrap and tension",
            "its average at the reference wrap and tension",
            missing({}),
        ),
        (
            "size",
            "a coefficient that depends on the pulley's radius over the belt's",
            "the coefficient at the reference wheel and rope",
            missing({}),
        ),
    ),
    Method(
        name="closed form",
        error=1e-11,
        why="an exponential and a balance of tensions; there is nothing to approximate",
    ),
)
"""A belt on one pulley or two."""
