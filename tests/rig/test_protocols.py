"""The other ways of running the rig."""

import numpy as np
import pytest
from drawn import record

from ropefric.rig.bench import HELD_BENCH


def test_every_tooth_of_a_stick_slip_recording_is_a_peak_of_known_height():
    tops = []
    for seed in range(15):
        recording = record(seed, protocol="stick-slip")
        truth = recording.truth
        assert 8 <= len(truth.tooth_tops_N) <= 16
        for top_s, top_N in zip(truth.tooth_times_s, truth.tooth_tops_N, strict=True):
            near = np.abs(recording.true_time_s - top_s) < 0.02
            assert recording.true_force_N[near].max() == pytest.approx(top_N, rel=3e-3)
        tops += truth.tooth_tops_N
    assert np.mean(tops) == pytest.approx(320.7, rel=4 * 0.017 / np.sqrt(len(tops)))
    assert np.std(tops, ddof=1) / 320.7 == pytest.approx(0.017, rel=0.2)
    assert 1 / np.diff(truth.tooth_times_s).mean() == pytest.approx(4.0, abs=2.5)


def test_held_plateaus_settle_where_the_truth_says():
    plateaus = []
    for seed in range(30):
        recording = record(seed, lift_N=7.8816, end_N=4.58, bench=HELD_BENCH, protocol="held")
        truth = recording.truth
        assert recording.time_s[1] == pytest.approx(0.02)
        assert len(truth.plateaus_N) == len(truth.phases) == 3
        for phase, plateau_N in zip(truth.phases, truth.plateaus_N, strict=True):
            held = (recording.true_time_s >= phase.start_s) & (recording.true_time_s < phase.end_s)
            assert recording.true_force_N[held].mean() == pytest.approx(plateau_N, rel=3e-3)
            assert recording.true_force_N[held][-1] == pytest.approx(plateau_N, rel=1e-4)
        before = recording.true_time_s < 1.4
        assert not recording.true_force_N[before].any()
        plateaus += truth.plateaus_N
    assert np.mean(plateaus) == pytest.approx(4.58, rel=4 * 0.017 / np.sqrt(90))
    assert truth.lift_force_N == 7.8816
