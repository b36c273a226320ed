"""What is measured beside F_A: how long it slides, how far it falls, how often it slips."""

import numpy as np
import pytest
from rigged import rigged_trace

from ropefric.traces.breakaway import PickSettings, Status
from ropefric.traces.decision import pick_breakaway

SEEDS = range(12)


def test_slips_and_their_recurrence_are_those_of_the_rig():
    for seed in SEEDS:
        trace, truth = rigged_trace(seed)
        (result,) = pick_breakaway(trace, PickSettings())
        assert result.status is Status.OK
        true_s = np.array([truth.breakaway_time_s, *truth.tooth_times_s])
        assert true_s.size - 2 <= result.n_slips <= true_s.size
        assert result.recurrence_s == pytest.approx(np.median(np.diff(true_s)), rel=0.15)


def test_the_fall_and_the_time_of_sliding_are_those_of_the_recording():
    for seed in SEEDS:
        trace, truth = rigged_trace(seed)
        (result,) = pick_breakaway(trace, PickSettings())
        (sliding,) = (phase for phase in truth.phases if phase.name == "sliding")
        assert result.kinetic_s == pytest.approx(sliding.end_s - sliding.start_s, abs=0.15)
        after = (trace.time_s > truth.breakaway_time_s) & (trace.time_s < truth.breakaway_time_s + 0.01)
        lowest_N = float(np.nanmin(trace.force_N[after]))
        assert lowest_N <= result.trough_N <= lowest_N + 0.6 * (truth.lift_force_N - lowest_N)
        assert result.drop_N == pytest.approx(result.peak_N - result.trough_N)


def test_a_fall_without_slips_counts_none():
    trace, _ = rigged_trace(0, faults=("slow-fall",))
    (result,) = pick_breakaway(trace, PickSettings())
    if result.status is Status.OK:
        assert result.n_slips == 0 or result.n_slips > 1
    else:
        assert np.isnan(result.dwell_s)
