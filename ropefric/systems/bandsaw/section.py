"""The cross-section of a blade and what it is made of."""

import math
from dataclasses import dataclass, fields

from ropefric.errors import InputError


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """A thin strip."""

    width_m: float
    thickness_m: float
    density_kg_m3: float = 7800.0
    young_modulus_Pa: float = 206e9
    shear_modulus_Pa: float = 79.4e9

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (math.isfinite(value) and value > 0.0):
                raise InputError(
                    f"{field.name} is {value:g}; it must be finite and positive",
                    key=field.name,
                    fix="correct this value",
                )
        if self.thickness_m > self.width_m:
            raise InputError(
                f"the strip is {self.thickness_m:g} m thick and {self.width_m:g} m wide",
                key="thickness_m",
                fix="the thickness is the smaller one",
            )

    @property
    def linear_density_kg_m(self) -> float:
        """Return ρA [kg/m]."""
        return self.density_kg_m3 * self.width_m * self.thickness_m

    @property
    def bending_stiffness_N_m2(self) -> float:
        """Return EI = E b h³/12 of bending the flat way [N m2]."""
        return self.young_modulus_Pa * self.width_m * self.thickness_m**3 / 12.0


STEEL_85_09 = Section(width_m=0.085, thickness_m=0.0009)
"""A strip with the cross-section Wang and Jiang (2010) print; its width and thickness are a guess."""
