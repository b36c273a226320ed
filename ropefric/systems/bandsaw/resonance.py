"""Where a mode of the blade meets an excitation: over the speed, and how far off at work."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from ropefric.errors import InputError
from ropefric.systems.bandsaw.excitation import Excitation
from ropefric.systems.bandsaw.saw import Saw, Side, frequencies_Hz

__all__ = ["Crossing", "Margin", "find_crossings", "margins"]


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
    >>> from ropefric.systems.bandsaw.excitation import wheel_rotation
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
    >>> from ropefric.systems.bandsaw.excitation import wheel_rotation
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
