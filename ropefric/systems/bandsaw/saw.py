"""A band saw: one blade on two wheels, what it is made of, what drives it, and the frequencies of its two sides."""

import math
from dataclasses import dataclass, fields
from enum import StrEnum
from typing import Any

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.bandsaw.beam import beam_frequencies_Hz
from ropefric.systems.bandsaw.span import CLAMPED, Ends, Span
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Saw:
    """The data of a saw."""

    free_span_m: float
    linear_density_kg_m: float
    preload_N: float
    wheel_radius_m: float
    wheel_speed_rad_s: float
    tension_difference_N: float = 0.0
    mounting_factor: float = 0.0
    bending_stiffness_N_m2: float = 0.0
    ends: Ends = CLAMPED

    @property
    def speed_m_s(self) -> float:
        """Return the blade's speed at work v = ω R [m/s]."""
        return self.wheel_speed_rad_s * self.wheel_radius_m


def span_of(
    saw: Saw, side: Side, *, speed_m_s: npt.ArrayLike | None = None, preload_N: npt.ArrayLike | None = None
) -> Span:
    """Return one side of a saw with all its parts in it, for one speed and preload or many."""
    speed = abs(side.sign) * np.asarray(saw.speed_m_s if speed_m_s is None else speed_m_s, dtype=np.float64)
    parts: dict[str, Any] = {
        name: getattr(saw, name)
        for name in ("free_span_m", "linear_density_kg_m", "mounting_factor", "bending_stiffness_N_m2")
    }
    return Span(
        **parts,
        preload_N=np.asarray(saw.preload_N if preload_N is None else preload_N),
        pull_N=np.asarray(0.5 * side.sign * saw.tension_difference_N),
        wheel_speed_m_s=speed,
        travel_speed_m_s=speed,
    )


def frequencies_Hz(
    saw: Saw,
    side: Side,
    n_modes: int = 6,
    *,
    speed_m_s: npt.ArrayLike | None = None,
    preload_N: npt.ArrayLike | None = None,
    accuracy: float = 1e-10,
) -> FloatArray:
    """Return the first frequencies of one side of a saw [Hz], shape (m, n_modes).

    Arguments as in `span_of`; `accuracy` is that of the beam, where the blade is one.
    """
    span = span_of(saw, side, speed_m_s=speed_m_s, preload_N=preload_N)
    return beam_frequencies_Hz(span, saw.ends, n_modes, accuracy=accuracy)
