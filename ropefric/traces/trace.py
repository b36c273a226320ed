"""A force recording: what every reader hands over and every later step works on."""

from dataclasses import dataclass, field

import numpy as np

from ropefric.arrays import FloatArray, IntArray, frozen_array
from ropefric.errors import DataError, Problem
from ropefric.shown import Shown
from ropefric.traces.calibration import Calibration, Saturation

_LARGEST = 1e100
"""Beyond this in s, N or Hz, squares and their sums are no floats any more."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ForceTrace(Shown):
    """One force recording in SI units.

    Attributes
    ----------
    time_s : ndarray, shape (n,)
        Time stamps [s], finite and strictly increasing; not necessarily uniform.
    force_N : ndarray, shape (n,)
        Force [N]; NaN where a sample is missing.
    name : str
        The name of the recording in messages.
    source : str
        The file it came from, as its owner wrote it.
    counts : ndarray of int64, shape (n,), optional
        Raw ADC counts, where the force was computed from them.
    calibration : Calibration, optional
        How `force_N` came from `counts`.
    saturation : Saturation, optional
        Where the ADC sat at its ceiling or floor.
    end_tension_N : ndarray, shape (n,), optional
        Force on the slack side [N], where a second sensor measures it; NaN where a sample is missing.
    end_calibration : Calibration, optional
        How it was measured.
    tare_N : float
        The tare subtracted from the force [N]; NaN where its interval was too short.
    notes : tuple of str
        Corrections on reading: repeated time stamps, gaps.
    doubts : tuple of Problem
        Warnings about the tares.

    Raises
    ------
    DataError
        If the arrays disagree in length, are empty, time does not strictly increase, or a force, time or step is
        so large or small (1e100, 1e-100) that floats overflow in its square.

    Examples
    --------
    >>> trace = ForceTrace(time_s=[0.0, 0.1, 0.2], force_N=[0, 1, 2], name="run07")
    >>> trace.force_N.dtype, trace.sampling_rate_Hz
    (dtype('float64'), 10.0)
    """

    _said = ("name", "source", "time_s", "force_N", "sampling_rate_Hz", "notes")
    _framed = ("time_s", "force_N")

    time_s: FloatArray
    force_N: FloatArray
    name: str = "trace"
    source: str = ""
    counts: IntArray | None = None
    calibration: Calibration | None = None
    saturation: Saturation | None = None
    end_tension_N: FloatArray | None = None
    end_calibration: Calibration | None = None
    tare_N: float = 0.0
    notes: tuple[str, ...] = field(default=())
    doubts: tuple[Problem, ...] = ()

    def __post_init__(self) -> None:
        time_s, force_N = frozen_array(self.time_s), frozen_array(self.force_N)
        object.__setattr__(self, "time_s", time_s)
        object.__setattr__(self, "force_N", force_N)
        if time_s.ndim != 1 or time_s.shape != force_N.shape:
            why = f"{time_s.shape} time stamps for {force_N.shape} force samples"
            raise self._refused(why, "RF201", "check which columns the import profile names")
        if time_s.size == 0:
            raise self._refused("no samples", "RF201")
        if self.end_tension_N is not None:
            object.__setattr__(self, "end_tension_N", frozen_array(self.end_tension_N))
            if self.end_tension_N.shape != time_s.shape:
                raise self._refused(
                    f"{self.end_tension_N.shape} end tensions for {time_s.shape} samples", "RF201"
                )
        shortest_s = float(np.diff(time_s).min(initial=np.inf))
        # Where all steps are positive, only the ends can be anything but finite.
        if not (shortest_s > 0 and np.isfinite(time_s[[0, -1]]).all()):
            fix = "sort and mend the time stamps first (in Python: ropefric.traces.clock.mend_clock)"
            raise self._refused("time does not strictly increase", "RF202", fix)
        if max(-np.fmin.reduce(force_N), np.fmax.reduce(force_N)) > _LARGEST:
            at = int(np.argmax(np.abs(force_N) > _LARGEST))
            why = f"sample {at + 1} is {force_N[at]:g} N, which is no force"
            raise self._refused(why, "RF204", "correct the unit, or mark the sample as missing (NaN)")
        if max(-time_s[0], time_s[-1]) > _LARGEST or shortest_s < 1.0 / _LARGEST:
            span = f"{time_s[0]:g} s to {time_s[-1]:g} s in {time_s.size} samples"
            fix = "correct the unit of the time, or give the sampling rate"
            raise self._refused(f"time runs from {span}, which no clock can", "RF202", fix)

    def _refused(self, why: str, code: str, fix: str = "") -> DataError:
        return DataError(f"{self.name}: {why}", code=code, path=self.source, fix=fix)

    @property
    def sampling_rate_Hz(self) -> float:
        """Return the median sampling rate [Hz]; 0 for a single sample."""
        if self.time_s.size < 2:
            return 0.0
        # The mean step is exact for uniform stamps and costs nothing; a gap would spoil it, so check.
        step_s = float(self.time_s[-1] - self.time_s[0]) / (self.time_s.size - 1)
        steps_s = np.diff(self.time_s)
        if float(steps_s.max()) > 1.5 * step_s:
            step_s = float(np.median(steps_s))
        return float(f"{1.0 / step_s:.12g}")
