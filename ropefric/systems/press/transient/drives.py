"""Ways to bring a belt from rest to its speed; position, speed and acceleration follow from each exactly."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ropefric.errors import InputError
from ropefric.registry import Registry
from ropefric.systems.press.transient.polynomial import PiecewisePolynomial


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveLaw:
    """A named way to run up; position, speed and acceleration follow from it exactly."""

    name: str
    meaning: str
    parameters: tuple[str, ...]
    speed: Callable[..., PiecewisePolynomial]


def positive(name: str, value: float) -> float:
    """Return a finite positive number."""
    if not 0.0 < value < float("inf"):
        raise InputError(f"{name} is {value:g}; it must be positive and finite", key=name)
    return float(value)


def _constant(*, speed_m_s: float) -> PiecewisePolynomial:
    return PiecewisePolynomial.of([0.0], [[positive("speed_m_s", speed_m_s)]])


_CONSTANT = DriveLaw(
    name="constant",
    meaning="full speed from the first moment, while the rest of the machine still stands",
    parameters=("speed_m_s",),
    speed=_constant,
)


def _ramp(*, speed_m_s: float, duration_s: float) -> PiecewisePolynomial:
    final, duration = positive("speed_m_s", speed_m_s), positive("duration_s", duration_s)
    return PiecewisePolynomial.of([0.0, duration], [[0.0, final / duration], [final, 0.0]])


_RAMP = DriveLaw(
    name="ramp",
    meaning="constant acceleration; it jumps at both ends of the ramp",
    parameters=("speed_m_s", "duration_s"),
    speed=_ramp,
)


def _s_curve(*, speed_m_s: float, duration_s: float) -> PiecewisePolynomial:
    final, duration = positive("speed_m_s", speed_m_s), positive("duration_s", duration_s)
    rise = [0.0, 0.0, 3.0 * final / duration**2, -2.0 * final / duration**3]
    return PiecewisePolynomial.of([0.0, duration], [rise, [final, 0.0, 0.0, 0.0]])


_S_CURVE = DriveLaw(
    name="s-curve",
    meaning="a smooth rise whose acceleration starts and ends at zero; its greatest is 1.5 times the mean",
    parameters=("speed_m_s", "duration_s"),
    speed=_s_curve,
)


def _table(*, time_s: npt.ArrayLike, speed_m_s: npt.ArrayLike) -> PiecewisePolynomial:
    times, speeds = np.asarray(time_s, dtype=np.float64), np.asarray(speed_m_s, dtype=np.float64)
    if times.ndim != 1 or times.shape != speeds.shape or not times.size:
        raise InputError(
            f"the table has {times.size} times and {speeds.size} speeds",
            key="time_s",
            fix="give one speed for each time",
        )
    if times[0] != 0.0 or (np.diff(times) <= 0.0).any() or not np.isfinite(times).all():
        raise InputError("the times of the table must start at 0 s and rise", key="time_s")
    if not (np.isfinite(speeds).all() and (speeds >= 0.0).all()):
        raise InputError("the speeds of the table must be finite and zero or more", key="speed_m_s")
    slopes = np.append(np.diff(speeds) / np.diff(times), 0.0)
    return PiecewisePolynomial(starts_s=times, coefficients=np.column_stack([speeds, slopes]))


_TABLE = DriveLaw(
    name="table",
    meaning="speeds at given times with straight lines between them; after the last one the speed stays",
    parameters=("time_s", "speed_m_s"),
    speed=_table,
)


DRIVE_LAWS: Registry[DriveLaw] = Registry("drive law", [_CONSTANT, _RAMP, _S_CURVE, _TABLE])
"""The drive laws."""
