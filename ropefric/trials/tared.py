"""A recording as a force trace: calibrated by its cell, and the reading of the idle cell taken off."""

from dataclasses import dataclass, replace
from math import nan

import numpy as np

from ropefric.errors import DataError, Problem
from ropefric.traces.assemble import assemble_trace
from ropefric.traces.calibration import Calibration, tare_from_interval
from ropefric.traces.readers.profile import RawRecording
from ropefric.traces.segments import MIN_SAMPLES
from ropefric.traces.trace import ForceTrace, recalibrate
from ropefric.trials.campaign_model import Campaign
from ropefric.trials.trial_spec import TrialSpec

LARGEST_N = 1e12
"""More than was ever pulled: such a number is damage, and its square may be none at all."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Tared:
    """A trace and what was taken off it."""

    trace: ForceTrace
    tare_N: float
    problems: tuple[Problem, ...]


def tared_trace(campaign: Campaign, spec: TrialSpec, raw: RawRecording) -> Tared:
    """Return a recording as a force trace: assembled, calibrated and tared as its campaign says."""
    calibration = None
    if spec.cell and campaign.adc is not None:
        calibration = Calibration(cell=campaign.cells[spec.cell], adc=campaign.adc)
    trace = assemble_trace(raw, campaign.profile, calibration=calibration)
    _check_size(spec, trace)
    if campaign.tare_interval_s is None:
        return Tared(trace=trace, tare_N=0.0, problems=())
    start_s, stop_s = campaign.tare_interval_s
    if np.count_nonzero(np.isfinite(trace.force_N)) < MIN_SAMPLES:
        return Tared(trace=trace, tare_N=nan, problems=())  # picking says that it is too short
    if trace.counts is not None and trace.calibration is not None:
        tared, problems = tare_from_interval(trace.time_s, trace.counts, trace.calibration, start_s, stop_s)
        placed = tuple(replace(p, path=spec.file) for p in problems)
        return Tared(trace=recalibrate(trace, tared), tare_N=tared.tare_N, problems=placed)
    inside = (trace.time_s >= start_s) & (trace.time_s <= stop_s) & np.isfinite(trace.force_N)
    if not inside.any():
        raise DataError(
            f"no sample lies in the tare interval from {start_s:g} s to {stop_s:g} s",
            code="RF212",
            path=spec.file,
            key="[tare] interval",
            fix="name an idle interval inside the recording, or remove [tare]",
        )
    tare_N = float(np.median(trace.force_N[inside]))
    return Tared(trace=replace(trace, force_N=trace.force_N - tare_N), tare_N=tare_N, problems=())


def _check_size(spec: TrialSpec, trace: ForceTrace) -> None:
    too_large = np.abs(trace.force_N) > LARGEST_N
    if too_large.any():
        sample = int(np.argmax(too_large))
        raise DataError(
            f"{trace.force_N[sample]:.4g} N at {trace.time_s[sample]:.6g} s is no force that a cell can read",
            code="RF204",
            path=spec.file,
            fix='correct the unit or the cell, or list its text under [import] missing = ["..."]',
        )
