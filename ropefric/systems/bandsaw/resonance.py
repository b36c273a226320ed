"""Where a mode of the blade meets an excitation: over the speed, and how far off at work."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from ropefric.errors import InputError
from ropefric.friction.condition import FloatArray
from ropefric.systems.bandsaw.saw import Saw, Side, frequencies_Hz

__all__ = [
    "Crossing",
    "Excitation",
    "blade_passing",
    "find_crossings",
    "fixed_frequency",
    "margins",
    "tooth_passing",
    "wheel_rotation",
]


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Crossing:
    """A blade speed at which an excitation has the frequency of a mode.

    Attributes
    ----------
    side : Side
        Tight or slack.
    mode : int
        n = 1, 2, …
    excitation : str
        Its name.
    harmonic : int
        Which harmonic.
    speed_m_s, frequency_Hz : float
        Where they meet.
    speed_margin : float
        (speed of the crossing)/(speed at work) − 1 [-]: how much faster (or slower, if negative) the blade would have
        to run; infinite for a saw that stands still.
    """

    side: Side
    mode: int
    excitation: str
    harmonic: int
    speed_m_s: float
    frequency_Hz: float
    speed_margin: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Margin:
    """How far a mode is from an excitation at the speed at work.

    Attributes
    ----------
    side, mode, excitation, harmonic
        As in `Crossing`.
    mode_Hz, excitation_Hz : float
        Their frequencies.
    relative : float
        mode_Hz/excitation_Hz − 1 [-].
    """

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

    Parameters
    ----------
    saw : Saw
        The saw; its torque is the same at all speeds.
    side : Side
        Tight or slack.
    excitations : tuple of Excitation
        The excitations.
    speeds_m_s : array_like, shape (k,)
        Rising speeds from 0 or more [m/s], below the critical speed; between neighbours a crossing is bracketed.
    n_modes : int
        How many modes.

    Raises
    ------
    InputError
        If the speeds do not rise, or as `frequencies_Hz`.

    Examples
    --------
    >>> from ropefric.systems.bandsaw.resonance import wheel_rotation
    >>> saw = Saw(free_span_m=1.6, linear_density_kg_m=0.5967, preload_N=3412.0, wheel_radius_m=0.35,
    ...     wheel_speed_rad_s=100.0)
    >>> [(found.harmonic, round(found.speed_m_s, 3)) for found in find_crossings(
    ...     saw, Side.TIGHT, (wheel_rotation(0.35),), [0.0, 40.0], n_modes=1)]
    [(3, 16.498), (2, 23.478), (1, 38.498)]
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
    """Return how far every mode is from every excitation at the speed at work, the nearest first.

    Parameters
    ----------
    saw : Saw
        The saw.
    sides : tuple of Side
        Which sides.
    excitations : tuple of Excitation
        The excitations; a harmonic of zero frequency (a wheel at rest) excites nothing and is left out.
    n_modes : int
        How many modes.

    Examples
    --------
    >>> from ropefric.systems.bandsaw.resonance import wheel_rotation
    >>> saw = Saw(free_span_m=1.6, linear_density_kg_m=0.5967, preload_N=3412.0, wheel_radius_m=0.35,
    ...     wheel_speed_rad_s=970 * 3.14159265 / 30, tension_difference_N=210.95)
    >>> nearest = margins(saw, (Side.SLACK,), (wheel_rotation(0.35),), 2)[0]
    >>> nearest.mode, nearest.harmonic, round(nearest.relative, 3)
    (1, 1, 0.111)
    """
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
