"""Recordings of the virtual rig as the picker gets them: calibrated, tared, clock mended."""

import numpy as np
from drawn import record

from ropefric.rig.bench import Bench
from ropefric.traces.calibration import Calibration
from ropefric.traces.clock import mend_clock
from ropefric.traces.segments import MIN_SAMPLES
from ropefric.traces.trace import ForceTrace

IDLE_S = 0.25


def rigged_trace(
    seed,
    *,
    lift_force_N=320.0,
    end_tension_N=80.0,
    faults=(),
    bench=Bench(),  # noqa: B008
):
    """Return a recording of known truth as a trace, and that truth."""
    given = {"lift_N": lift_force_N, "end_N": end_tension_N, "bench": bench}
    recording = record(seed, *faults, **given)
    counts = np.where(np.isnan(recording.counts), -1, recording.counts).astype(np.int64)
    calibration = Calibration(cell=bench.cell_named(recording.truth.cell), adc=bench.adc)
    if counts.size >= MIN_SAMPLES:
        calibration, _ = calibration.with_tare(counts[recording.time_s <= IDLE_S])
    force_N, saturation = calibration.apply(counts)
    keep, time_s, notes = mend_clock(recording.time_s, [force_N])
    trace = ForceTrace(
        time_s=time_s, force_N=force_N[keep], saturation=saturation, name=f"seed {seed}", notes=notes
    )
    return trace, recording.truth
