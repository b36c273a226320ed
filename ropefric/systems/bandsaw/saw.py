"""A band saw: one blade on two wheels, what it is made of, what drives it, and what shakes it."""

import math
from dataclasses import dataclass, fields
from enum import StrEnum
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.checks import checked


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """The cross-section of a blade, a thin strip, and what it is made of."""

    width_m: float
    thickness_m: float
    density_kg_m3: float = 7800.0
    young_modulus_Pa: float = 206e9
    shear_modulus_Pa: float = 79.4e9

    def __post_init__(self) -> None:
        for field in fields(self):
            checked(field.name, getattr(self, field.name))
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

PRINTED_TORQUE_FACTOR = 9549.0
"""The factor of M = 9549 P/n with P in kW and n in 1/min; unrounded it is 30000/π = 9549.2966."""


def torque_N_m(
    power_W: npt.ArrayLike, wheel_speed_rad_s: npt.ArrayLike, *, printed: bool = False
) -> FloatArray:
    """Return the torque of the driven wheel M = P/ω [N m], eq. (16)."""
    power = checked("power_W", power_W, "zero or more")
    rounding = PRINTED_TORQUE_FACTOR / (30000.0 / math.pi) if printed else 1.0
    return np.asarray(power / checked("wheel_speed_rad_s", wheel_speed_rad_s) * rounding)


def tension_difference_N(torque_N_m: npt.ArrayLike, wheel_radius_m: npt.ArrayLike) -> FloatArray:
    """Return the difference of the tensions on the two sides of the driven wheel ΔF = M/R [N], eq. (17)."""
    torque = checked("torque_N_m", torque_N_m, "zero or more")
    return np.asarray(torque / checked("wheel_radius_m", wheel_radius_m))


class Side(StrEnum):
    """Which free span of the blade, and whether the saw runs."""

    TIGHT = "tight"
    SLACK = "slack"
    REST = "rest"

    @property
    def sign(self) -> float:
        """Return the sign of ΔF/2 in its tension: +1, −1, or 0 at rest."""
        return {Side.TIGHT: 1.0, Side.SLACK: -1.0, Side.REST: 0.0}[self]


class Excitation(NamedTuple):
    """A cause of vibration and its harmonics: f_h(v) = h (f_0 + v/λ)."""

    name: str
    constant_Hz: float = 0.0
    per_metre: float = 0.0
    harmonics: tuple[int, ...] = (1,)

    def frequencies_Hz(self, speed_m_s: npt.ArrayLike) -> FloatArray:
        """Return the frequencies of the harmonics at blade speeds, shape (…, n_harmonics) [Hz]."""
        basic = self.constant_Hz + self.per_metre * np.abs(np.asarray(speed_m_s, dtype=np.float64))
        return np.multiply.outer(basic, np.asarray(self.harmonics, dtype=np.float64))
