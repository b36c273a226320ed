"""The models of the blade that are compared with measurements: each a saw with some of its parts left out."""

from dataclasses import dataclass, replace

from ropefric.registry import Registry
from ropefric.systems.bandsaw.saw import Saw


@dataclass(frozen=True, slots=True, kw_only=True)
class BladeModel:
    """A choice of parts."""

    name: str
    meaning: str
    runs: bool
    mounting_factor: float
    bends: bool

    def applied_to(self, saw: Saw) -> Saw:
        """Return the saw with this model's parts."""
        return replace(
            saw,
            wheel_speed_rad_s=saw.wheel_speed_rad_s if self.runs else 0.0,
            mounting_factor=self.mounting_factor,
            bending_stiffness_N_m2=saw.bending_stiffness_N_m2 if self.bends else 0.0,
        )


MODELS: Registry[BladeModel] = Registry(
    "model of the blade",
    (
        BladeModel(
            name="string-at-rest",
            meaning="a string under the tensions of work that does not move (table 2, left)",
            runs=False,
            mounting_factor=0.0,
            bends=False,
        ),
        BladeModel(
            name="string-fixed-axles",
            meaning="a running string between fixed wheel axles, kappa = 0 (table 2, right)",
            runs=True,
            mounting_factor=0.0,
            bends=False,
        ),
        BladeModel(
            name="string-constant-force",
            meaning="a running string, wheels pressed apart with a constant force, kappa = 1 (table 3, right)",
            runs=True,
            mounting_factor=1.0,
            bends=False,
        ),
        BladeModel(
            name="beam-fixed-axles",
            meaning="a running stiff blade between fixed wheel axles, kappa = 0",
            runs=True,
            mounting_factor=0.0,
            bends=True,
        ),
        BladeModel(
            name="beam-constant-force",
            meaning="a running stiff blade, wheels pressed apart with a constant force, kappa = 1",
            runs=True,
            mounting_factor=1.0,
            bends=True,
        ),
    ),
)
"""Every model by name, from plain to complete."""
