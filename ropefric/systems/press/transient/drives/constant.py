"""Full speed at once: the hardest start, with a jump of the drivers' speed."""

from ropefric.systems.press.transient.drives.law import DriveLaw, positive
from ropefric.systems.press.transient.polynomial import PiecewisePolynomial

__all__ = ["DRIVE_LAW"]


def _speed(*, speed_m_s: float) -> PiecewisePolynomial:
    return PiecewisePolynomial.of([0.0], [[positive("speed_m_s", speed_m_s)]])


DRIVE_LAW = DriveLaw(
    name="constant",
    meaning="full speed from the first moment, while the rest of the machine still stands",
    parameters=("speed_m_s",),
    speed=_speed,
)
