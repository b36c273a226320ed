"""The answer of a start-up: histories at the times asked for, and what they amount to."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.systems.press.machine import Press
from ropefric.systems.press.transient.energy import Energies


@dataclass(frozen=True, slots=True, kw_only=True)
class SlipInterval:
    """One time during which a belt slipped on a roller."""

    roller: str
    start_s: float
    end_s: float
    direction: int
    ends_stuck: bool


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StartUp:
    """A start-up of a press."""

    press: Press
    integrator: str
    time_s: FloatArray
    drive_speed_m_s: FloatArray
    tension_N: FloatArray
    roller_speed_rad_s: FloatArray
    relative_angle_rad: FloatArray
    travel_m: FloatArray
    contact: npt.NDArray[np.int8]
    slip_m: FloatArray
    slip_speed_m_s: FloatArray
    friction_N: FloatArray
    utilisation: FloatArray | None
    energy: Energies
    slips: tuple[SlipInterval, ...]
    settled_tension_N: FloatArray | None

    @property
    def peak_tension_N(self) -> dict[str, float]:
        """Return the highest tension of each span at the times asked for [N]."""
        peaks = self.tension_N.max(axis=0)
        return {span.name: float(peak) for span, peak in zip(self.press.spans, peaks, strict=True)}

    @property
    def peak_utilisation(self) -> dict[str, float]:
        """Return the highest utilisation of each roller at the times asked for [-]; empty without friction."""
        if self.utilisation is None:
            return {}
        peaks = self.utilisation.max(axis=0)
        return {roller.name: float(peak) for roller, peak in zip(self.press.rollers, peaks, strict=True)}

    @property
    def first_slip_s(self) -> dict[str, float]:
        """Return when each roller that slips does so first [s], in the order of time."""
        first: dict[str, float] = {}
        for slip in self.slips:
            first.setdefault(slip.roller, slip.start_s)
        return first

    @property
    def slipping_s(self) -> dict[str, float]:
        """Return how long each roller that slips does so in all [s]."""
        total: dict[str, float] = {}
        for slip in self.slips:
            total[slip.roller] = total.get(slip.roller, 0.0) + slip.end_s - slip.start_s
        return total

    def summary(self) -> dict[str, Any]:
        """Return what the histories amount to, as plain data."""
        spans = [span.name for span in self.press.spans]
        lowest = self.tension_N.min(axis=0).tolist()
        settled = None if self.settled_tension_N is None else self.settled_tension_N.tolist()
        return {
            "peak_tension_N": self.peak_tension_N,
            "lowest_tension_N": dict(zip(spans, lowest, strict=True)),
            "peak_utilisation": self.peak_utilisation,
            "first_slip_s": self.first_slip_s,
            "slipping_s": self.slipping_s,
            "drive_work_J": float(self.energy.drive[-1]),
            "slip_loss_J": float(self.energy.slip[-1]),
            "energy_residual": self.energy.relative_residual,
            "settled_tension_N": None if settled is None else dict(zip(spans, settled, strict=True)),
        }
