"""A measured or programmed run-up: speeds at given times, straight lines between them."""

import numpy as np
import numpy.typing as npt

from ropefric.errors import InputError
from ropefric.systems.press.transient.drives.law import DriveLaw
from ropefric.systems.press.transient.polynomial import PiecewisePolynomial

__all__ = ["DRIVE_LAW"]


def _speed(*, time_s: npt.ArrayLike, speed_m_s: npt.ArrayLike) -> PiecewisePolynomial:
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


DRIVE_LAW = DriveLaw(
    name="table",
    meaning="speeds at given times with straight lines between them; after the last one the speed stays",
    parameters=("time_s", "speed_m_s"),
    speed=_speed,
)
