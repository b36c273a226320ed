"""Where a mode of the blade meets an excitation: over the speed, and how far off at work."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.bandsaw.saw import Saw, Side, frequencies_Hz


@dataclass(frozen=True, slots=True, kw_only=True)
class Excitation:
    """A cause of vibration and its harmonics: f_h(v) = h (f_0 + v/λ)."""

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
    """Return the excitation by a wheel that is out of round or balance: once a turn, v/(2πR)."""
    return Excitation(
        name="wheel rotation",
        per_metre=1.0 / (2.0 * math.pi * _length("wheel_radius_m", wheel_radius_m)),
        harmonics=harmonics,
    )


def tooth_passing(tooth_pitch_m: float, harmonics: tuple[int, ...] = (1,)) -> Excitation:
    """Return the excitation by teeth that enter the wood: once a pitch."""
    return Excitation(
        name="tooth passing",
        per_metre=1.0 / _length("tooth_pitch_m", tooth_pitch_m),
        harmonics=harmonics,
    )


def blade_passing(loop_length_m: float, harmonics: tuple[int, ...] = (1, 2, 3)) -> Excitation:
    """Return the excitation by the joint of the blade: once a round."""
    return Excitation(
        name="blade passing",
        per_metre=1.0 / _length("loop_length_m", loop_length_m),
        harmonics=harmonics,
    )


def fixed_frequency(name: str, frequency_Hz: float, harmonics: tuple[int, ...] = (1,)) -> Excitation:
    """Return an excitation whose frequency does not depend on the blade's speed, such as a motor or a fan."""
    return Excitation(name=name, constant_Hz=frequency_Hz, harmonics=harmonics)


def _length(name: str, value: float) -> float:
    if not (math.isfinite(value) and value > 0.0):
        raise InputError(
            f"{name} is {value:g}; it must be finite and positive", key=name, fix="correct this value"
        )
    return value


@dataclass(frozen=True, slots=True, kw_only=True)
class Crossing:
    """A blade speed at which an excitation has the frequency of a mode."""

    side: Side
    mode: int
    excitation: str
    harmonic: int
    speed_m_s: float
    frequency_Hz: float
    speed_margin: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Margin:
    """How far a mode is from an excitation at the speed at work."""

    side: Side
    mode: int
    excitation: str
    harmonic: int
    mode_Hz: float
    excitation_Hz: float
    relative: float


def find_crossings(
    saw: Saw,
    side: Side,
    excitations: tuple[Excitation, ...],
    speeds_m_s: npt.ArrayLike,
    n_modes: int = 6,
) -> tuple[Crossing, ...]:
    """Return all crossings between the first and the last of some speeds, by speed.

    A mode's frequency falls with the speed and an excitation's does not, so a pair crosses at most once and its ends
    tell whether it does.
    """
    speeds = np.asarray(speeds_m_s, dtype=np.float64)
    if speeds.ndim != 1 or speeds.size < 2 or not (np.diff(speeds) > 0.0).all() or speeds[0] < 0.0:
        raise InputError(
            "the speeds must be two or more, rising from 0 or more",
            key="speeds_m_s",
            fix="give np.linspace(...)",
        )
    of_modes = frequencies_Hz(saw, side, n_modes, speed_m_s=speeds)
    found = []
    for excitation in excitations:
        excited = excitation.frequencies_Hz(speeds)
        for column, harmonic in enumerate(excitation.harmonics):
            above = of_modes > excited[:, column, np.newaxis]
            for mode in np.flatnonzero(above[0] & ~above[-1]) + 1:
                after = int(np.argmin(above[:, mode - 1]))
                bracket = (float(speeds[after - 1]), float(speeds[after]))
                speed = _meeting_m_s(
                    saw, side, excitation, harmonic=harmonic, mode=int(mode), bracket=bracket
                )
                found.append(
                    Crossing(
                        side=side,
                        mode=int(mode),
                        excitation=excitation.name,
                        harmonic=harmonic,
                        speed_m_s=speed,
                        frequency_Hz=harmonic * float(excitation.constant_Hz + excitation.per_metre * speed),
                        speed_margin=speed / saw.speed_m_s - 1.0 if saw.speed_m_s > 0.0 else np.inf,
                    )
                )
    return tuple(sorted(found, key=lambda crossing: (crossing.speed_m_s, crossing.mode, crossing.harmonic)))


def margins(
    saw: Saw, sides: tuple[Side, ...], excitations: tuple[Excitation, ...], n_modes: int = 6
) -> tuple[Margin, ...]:
    """Return how far every mode is from every excitation at the speed at work, the nearest first."""
    found = []
    for side in sides:
        of_modes = frequencies_Hz(saw, side, n_modes)[0]
        for excitation in excitations:
            excited = excitation.frequencies_Hz(saw.speed_m_s)
            found += [
                Margin(
                    side=side,
                    mode=mode,
                    excitation=excitation.name,
                    harmonic=harmonic,
                    mode_Hz=mode_Hz,
                    excitation_Hz=excited_Hz,
                    relative=mode_Hz / excited_Hz - 1.0,
                )
                for harmonic, excited_Hz in zip(excitation.harmonics, excited.tolist(), strict=True)
                if excited_Hz > 0.0
                for mode, mode_Hz in enumerate(of_modes.tolist(), start=1)
            ]
    return tuple(sorted(found, key=lambda margin: abs(margin.relative)))


def _meeting_m_s(
    saw: Saw, side: Side, excitation: Excitation, *, harmonic: int, mode: int, bracket: tuple[float, float]
) -> float:
    def above_Hz(speed: float) -> float:
        mode_Hz = float(frequencies_Hz(saw, side, mode, speed_m_s=speed)[0, -1])
        return mode_Hz - harmonic * (excitation.constant_Hz + excitation.per_metre * speed)

    return float(brentq(above_Hz, *bracket, xtol=1e-10 * bracket[1], rtol=1e-12))
