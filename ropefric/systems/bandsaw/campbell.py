"""The data of a Campbell chart: modes and excitations over the blade's speed, and where they meet."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ropefric.errors import InputError
from ropefric.friction.condition import FloatArray
from ropefric.systems.bandsaw.resonance import Crossing, Excitation, find_crossings
from ropefric.systems.bandsaw.saw import Saw, Side, frequencies_Hz

__all__ = ["SawChart", "saw_chart"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SawChart:
    """What a Campbell chart shows.

    Attributes
    ----------
    saw : Saw
        The saw.
    speed_m_s : ndarray, shape (k,)
        Speeds of the blade [m/s].
    mode_Hz : dict of Side to ndarray, shape (k, n_modes)
        Frequencies of the modes of each side [Hz].
    excitations : tuple of Excitation
        The excitations.
    crossings : tuple of Crossing
        Of both sides, by speed.
    """

    saw: Saw
    speed_m_s: FloatArray
    mode_Hz: dict[Side, FloatArray]
    excitations: tuple[Excitation, ...]
    crossings: tuple[Crossing, ...]


def saw_chart(
    saw: Saw, excitations: tuple[Excitation, ...], speeds_m_s: npt.ArrayLike, n_modes: int = 4
) -> SawChart:
    """Return the data of a Campbell chart of both sides at constant torque.

    Parameters
    ----------
    saw : Saw
        The saw.
    excitations : tuple of Excitation
        What shakes it.
    speeds_m_s : array_like, shape (k,)
        Two or more rising speeds [m/s], below the critical speed of both sides.
    n_modes : int
        How many modes.

    Raises
    ------
    InputError
        As `find_crossings`.

    Examples
    --------
    >>> from ropefric.systems.bandsaw.resonance import wheel_rotation
    >>> saw = Saw(free_span_m=1.6, linear_density_kg_m=0.5967, preload_N=3412.0, wheel_radius_m=0.35,
    ...     wheel_speed_rad_s=101.58, tension_difference_N=210.95)
    >>> chart = saw_chart(saw, (wheel_rotation(0.35),), [0.0, 20.0, 40.0], n_modes=1)
    >>> chart.mode_Hz[Side.TIGHT].shape, len(chart.crossings)
    ((3, 1), 6)
    """
    speeds = np.array(speeds_m_s, dtype=np.float64)
    if not excitations:
        raise InputError("a chart without excitations shows no resonance", key="excitations")
    sides = (Side.TIGHT, Side.SLACK)
    found = [
        crossing for side in sides for crossing in find_crossings(saw, side, excitations, speeds, n_modes)
    ]
    speeds.flags.writeable = False
    return SawChart(
        saw=saw,
        speed_m_s=speeds,
        mode_Hz={side: frequencies_Hz(saw, side, n_modes, speed_m_s=speeds) for side in sides},
        excitations=excitations,
        crossings=tuple(sorted(found, key=lambda crossing: crossing.speed_m_s)),
    )
