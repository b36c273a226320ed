"""Protocols that find several trials in one recording."""

import numpy as np
from rigged import rigged_trace

from ropefric.rig.bench import HELD_BENCH
from ropefric.traces.breakaway import PickSettings, Status
from ropefric.traces.protocols import pick_plateaus, pick_teeth
from ropefric.traces.trace import ForceTrace

AUTO = PickSettings()


def test_every_tooth_is_found_once_and_right():
    errors = []
    for seed in range(6):
        trace, truth = rigged_trace(
            seed, lift_force_N=(120.0, 320.0, 600.0)[seed % 3], end_tension_N=60.0, protocol="stick-slip"
        )
        teeth = pick_teeth(trace, AUTO)
        assert [tooth.status for tooth in teeth] == [Status.OK] * len(truth.tooth_tops_N)
        times_s = np.array([tooth.peak_time_s for tooth in teeth])
        np.testing.assert_allclose(times_s, truth.tooth_times_s, atol=0.03)
        errors.extend(np.array([tooth.peak_N for tooth in teeth]) / truth.tooth_tops_N - 1)
    assert abs(np.mean(errors)) < 0.003
    assert np.abs(errors).max() < 0.012


def test_a_recording_without_a_slip_gives_the_reason_once():
    trace, _ = rigged_trace(3, faults=("no-breakaway",))
    (result,) = pick_teeth(trace, AUTO)
    assert result.status is Status.NO_BREAKAWAY


def test_plateaus_of_the_rig():
    for seed in range(4):
        trace, truth = rigged_trace(seed, end_tension_N=60.0, protocol="held", bench=HELD_BENCH)
        found = pick_plateaus(trace, AUTO)
        forces_N = [plateau.peak_N for plateau in found]
        np.testing.assert_allclose(forces_N, truth.plateaus_N, rtol=0.003)
        for plateau, phase in zip(found, truth.phases, strict=True):
            held = plateau.phases[0]
            assert phase.start_s - 1.0 <= held.start_s < held.end_s <= phase.end_s + 0.2


def test_no_plateau_no_load_and_too_few_samples_are_said():
    time_s = np.arange(0, 40, 0.02)
    up_and_down = ForceTrace(time_s=time_s, force_N=np.abs(((time_s - 20) % 20) - 10))
    assert {p.status for p in pick_plateaus(up_and_down, AUTO)} == {Status.NO_BREAKAWAY}
    (idle,) = pick_plateaus(ForceTrace(time_s=time_s, force_N=0.01 * np.sin(1e4 * time_s)), AUTO)
    assert "never loaded" in idle.detail
    (short,) = pick_plateaus(ForceTrace(time_s=time_s[:9], force_N=time_s[:9]), AUTO)
    assert short.status is Status.TOO_SHORT
