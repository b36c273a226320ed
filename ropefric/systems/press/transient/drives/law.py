"""What a drive law is: a way to bring a belt from rest to its speed."""

from collections.abc import Callable
from dataclasses import dataclass

from ropefric.errors import InputError
from ropefric.systems.press.transient.polynomial import PiecewisePolynomial

__all__ = ["DriveLaw", "positive"]


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveLaw:
    """A named way to run up; position, speed and acceleration follow from it exactly.

    Attributes
    ----------
    name : str
        Its name in scenes.
    meaning : str
        What it does, in words.
    parameters : tuple of str
        The names of what `speed` takes.
    speed : callable
        Returns the surface speed of the drivers [m/s] over time as a `PiecewisePolynomial`.

    Examples
    --------
    >>> from ropefric.systems.press.transient.drives import DRIVE_LAWS
    >>> speed = DRIVE_LAWS["ramp"].speed(speed_m_s=1.0, duration_s=2.0)
    >>> float(speed(1.0)), float(speed.integral()(2.0)), float(speed.derivative()(1.0))
    (0.5, 1.0, 0.5)
    """

    name: str
    meaning: str
    parameters: tuple[str, ...]
    speed: Callable[..., PiecewisePolynomial]


def positive(name: str, value: float) -> float:
    """Return a finite positive number.

    Raises
    ------
    InputError
        If it is not.
    """
    if not 0.0 < value < float("inf"):
        raise InputError(f"{name} is {value:g}; it must be positive and finite", key=name)
    return float(value)
