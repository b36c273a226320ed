"""A band saw: one blade on two wheels, its tight and its slack side."""

import math
from dataclasses import dataclass, fields
from enum import StrEnum

import numpy as np
import numpy.typing as npt

from ropefric.errors import InputError
from ropefric.friction.condition import FloatArray
from ropefric.systems.bandsaw.beam import beam_frequencies_Hz
from ropefric.systems.bandsaw.ends import CLAMPED, Ends
from ropefric.systems.bandsaw.span import Span

__all__ = ["Saw", "Side", "frequencies_Hz", "span_of"]


class Side(StrEnum):
    """Which free span of the blade, and whether the saw runs."""

    TIGHT = "tight"
    SLACK = "slack"
    REST = "rest"

    @property
    def sign(self) -> float:
        """Return the sign of ΔF/2 in its tension: +1, −1, or 0 at rest.

        Examples
        --------
        >>> [side.sign for side in Side]
        [1.0, -1.0, 0.0]
        """
        return {Side.TIGHT: 1.0, Side.SLACK: -1.0, Side.REST: 0.0}[self]


@dataclass(frozen=True, slots=True, kw_only=True)
class Saw:
    """What is known of a saw.

    Attributes
    ----------
    free_span_m : float
        Length l of each free span [m], positive.
    linear_density_kg_m : float
        Mass per length ρA of the blade [kg/m], positive.
    preload_N : float
        Tension F_0 of each side at rest [N], positive.
    wheel_radius_m : float
        R [m], positive.
    wheel_speed_rad_s : float
        ω of the wheels at work [rad/s], zero or more.
    tension_difference_N : float
        ΔF = M/R of the sides at work [N], zero or more; see `ropefric.systems.bandsaw.drive`.
    mounting_factor : float
        κ from 0 (fixed wheel axles) to 1 (constant-force mounting).
    bending_stiffness_N_m2 : float
        EI [N m2]; zero makes the blade a string.
    ends : Ends
        How the ends of a stiff blade are held.

    Raises
    ------
    InputError
        If a number is outside its range.

    Examples
    --------
    >>> saw = Saw(free_span_m=1.6, linear_density_kg_m=0.5967, preload_N=3412.0, wheel_radius_m=0.35,
    ...     wheel_speed_rad_s=970 * math.pi / 30, tension_difference_N=210.95)
    >>> round(saw.speed_m_s, 3)
    35.552
    """

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
    """Return one side of a saw with all its parts in it, for one speed and preload or many.

    Parameters
    ----------
    saw : Saw
        The saw.
    side : Side
        At `REST` the blade stands still and pulls nothing, whatever the speed.
    speed_m_s : array_like, optional
        Speeds of the blade [m/s], by default the speed at work. The torque is the same at all of them.
    preload_N : array_like, optional
        Preloads F_0 [N], by default the saw's.

    Raises
    ------
    InputError
        As `Span`.

    Examples
    --------
    >>> saw = Saw(free_span_m=1.6, linear_density_kg_m=0.5967, preload_N=3412.0, wheel_radius_m=0.35,
    ...     wheel_speed_rad_s=100.0, tension_difference_N=210.0)
    >>> span_of(saw, Side.SLACK, speed_m_s=[0.0, 20.0]).tension_N.tolist()
    [3307.0, 3307.0]
    """
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

    Raises
    ------
    InputError
        As `span_of`, and at the critical speed or above.

    Examples
    --------
    >>> saw = Saw(free_span_m=1.6, linear_density_kg_m=0.5967, preload_N=3412.0, wheel_radius_m=0.35,
    ...     wheel_speed_rad_s=970 * math.pi / 30, tension_difference_N=210.95)
    >>> frequencies_Hz(saw, Side.TIGHT, 2).round(3).tolist()
    [[18.849, 37.697]]
    """
    span = span_of(saw, side, speed_m_s=speed_m_s, preload_N=preload_N)
    return beam_frequencies_Hz(span, saw.ends, n_modes, accuracy=accuracy)
