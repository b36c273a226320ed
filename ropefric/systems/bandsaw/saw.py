"""A band saw: one blade on two wheels, its tight and its slack side."""

import math
from dataclasses import dataclass, fields
from enum import StrEnum

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.bandsaw.beam import beam_frequencies_Hz
from ropefric.systems.bandsaw.ends import CLAMPED, Ends
from ropefric.systems.bandsaw.span import Span


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
    """What is known of a saw."""

    free_span_m: float
    linear_density_kg_m: float
    preload_N: float
    wheel_radius_m: float
    wheel_speed_rad_s: float
    tension_difference_N: float = 0.0
    mounting_factor: float = 0.0
    bending_stiffness_N_m2: float = 0.0
    ends: Ends = CLAMPED

    def __post_init__(self) -> None:
        for field in fields(self):
            if field.name == "ends":
                continue
            value = getattr(self, field.name)
            may_be_zero = field.name in _MAY_BE_ZERO
            if not (math.isfinite(value) and (value >= 0.0 if may_be_zero else value > 0.0)):
                rule = "zero or more" if may_be_zero else "positive"
                raise InputError(
                    f"{field.name} is {value:g}; it must be finite and {rule}",
                    key=field.name,
                    fix="correct this value",
                )
        if self.mounting_factor > 1.0:
            raise InputError(
                f"the mounting factor is {self.mounting_factor:g}; it must be from 0 to 1",
                key="mounting_factor",
                fix="give 0 for fixed wheel axles, 1 for a constant-force mounting, or a number between",
            )

    @property
    def speed_m_s(self) -> float:
        """Return the blade's speed at work v = ω R [m/s]."""
        return self.wheel_speed_rad_s * self.wheel_radius_m


_MAY_BE_ZERO = {"wheel_speed_rad_s", "tension_difference_N", "mounting_factor", "bending_stiffness_N_m2"}


def span_of(
    saw: Saw,
    side: Side,
    *,
    speed_m_s: npt.ArrayLike | None = None,
    preload_N: npt.ArrayLike | None = None,
) -> Span:
    """Return one side of a saw with all its parts in it, for one speed and preload or many."""
    speed = np.asarray(saw.speed_m_s if speed_m_s is None else speed_m_s, dtype=np.float64)
    runs = 0.0 if side is Side.REST else 1.0
    return Span(
        free_span_m=np.asarray(saw.free_span_m),
        linear_density_kg_m=np.asarray(saw.linear_density_kg_m),
        preload_N=np.asarray(saw.preload_N if preload_N is None else preload_N, dtype=np.float64),
        pull_N=np.asarray(0.5 * side.sign * saw.tension_difference_N),
        mounting_factor=np.asarray(saw.mounting_factor),
        wheel_speed_m_s=runs * speed,
        travel_speed_m_s=runs * speed,
        bending_stiffness_N_m2=np.asarray(saw.bending_stiffness_N_m2),
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
