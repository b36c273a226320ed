"""A smooth run-up: speed v (3 s² − 2 s³) with s = t/duration, so that the acceleration has no jump."""

from ropefric.systems.press.transient.drives.law import DriveLaw, positive
from ropefric.systems.press.transient.polynomial import PiecewisePolynomial

__all__ = ["DRIVE_LAW"]


def _speed(*, speed_m_s: float, duration_s: float) -> PiecewisePolynomial:
    final, duration = positive("speed_m_s", speed_m_s), positive("duration_s", duration_s)
    rise = [0.0, 0.0, 3.0 * final / duration**2, -2.0 * final / duration**3]
    return PiecewisePolynomial.of([0.0, duration], [rise, [final, 0.0, 0.0, 0.0]])


DRIVE_LAW = DriveLaw(
    name="s-curve",
    meaning="a smooth rise whose acceleration starts and ends at zero; its greatest is 1.5 times the mean",
    parameters=("speed_m_s", "duration_s"),
    speed=_speed,
)
