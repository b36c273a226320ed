"""The data of a Campbell chart: modes and excitations over the blade's speed, and where they meet."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.bandsaw.resonance import Crossing, Excitation, find_crossings
from ropefric.systems.bandsaw.saw import Saw, Side, frequencies_Hz


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SawChart:
    """What a Campbell chart shows."""

    saw: Saw
    speed_m_s: FloatArray
    mode_Hz: dict[Side, FloatArray]
    excitations: tuple[Excitation, ...]
    crossings: tuple[Crossing, ...]


def saw_chart(
    saw: Saw, excitations: tuple[Excitation, ...], speeds_m_s: npt.ArrayLike, n_modes: int = 4
) -> SawChart:
    """Return the data of a Campbell chart of both sides at constant torque."""
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
