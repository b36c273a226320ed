"""What shakes a blade: wheels out of round, teeth that cut, the joint that passes, and whatever else is known."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ropefric.errors import InputError
from ropefric.friction.condition import FloatArray

__all__ = ["Excitation", "blade_passing", "fixed_frequency", "tooth_passing", "wheel_rotation"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Excitation:
    """A cause of vibration and its harmonics: f_h(v) = h (f_0 + v/λ).

    Attributes
    ----------
    name : str
        For people.
    constant_Hz : float
        f_0 [Hz], zero or more.
    per_metre : float
        1/λ [1/m]: how often it happens for each metre of blade that runs past; zero or more.
    harmonics : tuple of int
        Which h, from 1 on.

    Raises
    ------
    InputError
        If a number is outside its range, or all are zero.

    Examples
    --------
    >>> wheel_rotation(0.35, harmonics=(1, 2)).frequencies_Hz(35.552).round(3).tolist()
    [16.167, 32.333]
    """

    name: str
    constant_Hz: float = 0.0
    per_metre: float = 0.0
    harmonics: tuple[int, ...] = (1,)

    def __post_init__(self) -> None:
        numbers = (self.constant_Hz, self.per_metre)
        if not all(math.isfinite(number) and number >= 0.0 for number in numbers) or not any(numbers):
            raise InputError(
                f"excitation {self.name!r}: {self.constant_Hz:g} Hz and {self.per_metre:g} per metre; both must be "
                "finite and zero or more, and one of them positive",
                fix="correct this value",
            )
        if not self.harmonics or min(self.harmonics) < 1:
            raise InputError(f"excitation {self.name!r}: harmonics count from 1", key="harmonics")

    def frequencies_Hz(self, speed_m_s: npt.ArrayLike) -> FloatArray:
        """Return the frequencies of the harmonics at blade speeds, shape (…, n_harmonics) [Hz]."""
        basic = self.constant_Hz + self.per_metre * np.abs(np.asarray(speed_m_s, dtype=np.float64))
        return np.multiply.outer(basic, np.asarray(self.harmonics, dtype=np.float64))


def wheel_rotation(wheel_radius_m: float, harmonics: tuple[int, ...] = (1, 2, 3)) -> Excitation:
    """Return the excitation by a wheel that is out of round or balance: once a turn, v/(2πR).

    Examples
    --------
    >>> round(wheel_rotation(0.35).per_metre, 4)
    0.4547
    """
    return Excitation(
        name="wheel rotation",
        per_metre=1.0 / (2.0 * math.pi * _length("wheel_radius_m", wheel_radius_m)),
        harmonics=harmonics,
    )


def tooth_passing(tooth_pitch_m: float, harmonics: tuple[int, ...] = (1,)) -> Excitation:
    """Return the excitation by teeth that enter the wood: once a pitch.

    Examples
    --------
    >>> tooth_passing(0.04).per_metre
    25.0
    """
    return Excitation(
        name="tooth passing",
        per_metre=1.0 / _length("tooth_pitch_m", tooth_pitch_m),
        harmonics=harmonics,
    )


def blade_passing(loop_length_m: float, harmonics: tuple[int, ...] = (1, 2, 3)) -> Excitation:
    """Return the excitation by the joint of the blade: once a round.

    Examples
    --------
    >>> blade_passing(5.0).per_metre
    0.2
    """
    return Excitation(
        name="blade passing",
        per_metre=1.0 / _length("loop_length_m", loop_length_m),
        harmonics=harmonics,
    )


def fixed_frequency(name: str, frequency_Hz: float, harmonics: tuple[int, ...] = (1,)) -> Excitation:
    """Return an excitation whose frequency does not depend on the blade's speed, such as a motor or a fan.

    Examples
    --------
    >>> fixed_frequency("fan", 24.5).frequencies_Hz([0.0, 10.0]).tolist()
    [[24.5], [24.5]]
    """
    return Excitation(name=name, constant_Hz=frequency_Hz, harmonics=harmonics)


def _length(name: str, value: float) -> float:
    if not (math.isfinite(value) and value > 0.0):
        raise InputError(
            f"{name} is {value:g}; it must be finite and positive", key=name, fix="correct this value"
        )
    return value
