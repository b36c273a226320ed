"""Constant acceleration up to full speed."""

from ropefric.systems.press.transient.drives.law import DriveLaw, positive
from ropefric.systems.press.transient.polynomial import PiecewisePolynomial

__all__ = ["DRIVE_LAW"]


def _speed(*, speed_m_s: float, duration_s: float) -> PiecewisePolynomial:
    final, duration = positive("speed_m_s", speed_m_s), positive("duration_s", duration_s)
    return PiecewisePolynomial.of([0.0, duration], [[0.0, final / duration], [final, 0.0]])


DRIVE_LAW = DriveLaw(
    name="ramp",
    meaning="constant acceleration; it jumps at both ends of the ramp",
    parameters=("speed_m_s", "duration_s"),
    speed=_speed,
)
