"""Every fault does what it says, and nothing else."""

import gzip

import numpy as np
import pytest
from drawn import record

from ropefric.rig.recording import FAULTS
from ropefric.traces.breakaway import Status

LIFT_N, CEILING = 320.7, 1023


def runs(mask):
    edges = np.diff(np.concatenate(([0], mask.astype(int), [0])))
    return np.flatnonzero(edges == -1) - np.flatnonzero(edges == 1)


def phase(truth, name):
    return next(one for one in truth.phases if one.name == name)


def test_the_truth_names_the_fault_and_its_status():
    for name, fault in FAULTS.items():
        truth = record(1, name).truth
        assert (truth.faults, truth.status) == ((name,), fault.expected_status or Status.OK)
        assert 0.0 <= fault.rate <= 0.1


def test_faults_combine_and_the_worst_status_counts():
    assert record(0, "no-peak", "spike").truth.status is Status.NO_PEAK
    assert record(0, "no-peak", "too-short", "unreadable").truth.status is Status.UNREADABLE


# --- of the samples ---


def test_spikes_are_one_or_two_samples_and_sometimes_near_the_peak():
    near = 0
    for seed in range(30):
        clean, spoilt = record(seed), record(seed, "spike")
        changed = clean.counts != spoilt.counts
        assert 1 <= changed.sum() <= 6
        assert len(runs(changed)) <= 3
        assert 0 <= spoilt.counts.min() <= spoilt.counts.max() <= CEILING
        near += (np.abs(clean.time_s[changed] - clean.truth.breakaway_time_s) < 0.03).any()
        assert spoilt.truth.lift_force_N == clean.truth.lift_force_N
    assert 4 < near < 22


def test_dropouts_are_short_and_spare_the_peak():
    empty = stuck = 0
    for seed in range(30):
        clean, spoilt = record(seed), record(seed, "dropout")
        lost = np.isnan(spoilt.counts)
        assert max(runs(lost), default=0) <= 60  # two gaps may touch
        frozen = ~lost & (spoilt.counts != clean.counts)
        empty, stuck = empty + lost.any(), stuck + frozen.any()
        touched_s = clean.time_s[lost | frozen]
        assert (np.abs(touched_s - clean.truth.breakaway_time_s) > 0.011).all()
    assert empty > 10
    assert stuck > 2


def test_too_short_ends_while_idle():
    for seed in range(10):
        counts = record(seed, "too-short").counts
        assert 5 <= counts.size < 50
        assert counts.max() < 25


def test_clocks_jitter_or_repeat():
    kinds = set()
    for seed in range(10):
        clean, spoilt = record(seed), record(seed, "clock-jitter")
        assert np.array_equal(clean.counts, spoilt.counts)
        kinds.add("repeats" if (np.diff(spoilt.time_s) == 0).any() else "jitters")
        assert np.abs(spoilt.time_s - clean.time_s).max() < 1.001 / 3000.0
    assert kinds == {"repeats", "jitters"}


def test_noise_hum_and_a_drifting_zero_are_in_the_counts_alone():
    for seed in range(4):
        clean, noisy, hum, drift = (record(seed, *f) for f in ((), ("noisy",), ("hum",), ("zero-drift",)))
        loud, quiet = (one.counts[:700].var() - 1 / 12 for one in (noisy, clean))
        assert np.sqrt(loud / quiet) == pytest.approx(4.0, rel=0.2)
        wave = (hum.counts - clean.counts)[:3000]
        assert np.argmax(np.abs(np.fft.rfft(wave))[1:]) + 1 in {50, 60}
        assert np.array_equal(clean.true_force_N, hum.true_force_N)
        wandered = drift.counts - clean.counts
        counts = np.median(wandered[-300:]) - np.median(wandered[:300])
        assert 0.04 < abs(counts) * 1000.0 / CEILING / clean.truth.lift_force_N < 0.11
        assert drift.counts.min() > 0


def test_unreadable_files_cannot_be_unpacked():
    data = gzip.compress(b"time_s,counts\n" + b"0.000000,11\n" * 500, mtime=0)
    for seed in range(40):
        damaged = FAULTS["unreadable"].on_bytes(data, np.random.default_rng(seed))
        assert damaged != data
        with pytest.raises((EOFError, OSError)):
            gzip.decompress(damaged)


# --- of the pull ---


def test_saturation_hides_the_peak_above_the_ceiling():
    for seed in range(8):
        for lift_N, end_N, cell in ((1200.0, 150.0, "K1"), (LIFT_N, 80.0, "K1"), (5900.0, 700.0, "K5")):
            recording = record(seed, "saturation", lift_N=lift_N, end_N=end_N)
            assert recording.truth.cell == cell
            assert recording.truth.lift_force_N > 1000.0 * (1 - 15.0 / CEILING)
            at_peak = np.abs(recording.time_s - recording.truth.breakaway_time_s) < 0.5 / 3000.0
            assert (recording.counts[at_peak] == CEILING).all()
            assert runs(recording.counts == CEILING).max() > 5
    assert record(0, "saturation", lift_N=1200.0, end_N=150.0).truth.lift_force_N == 1200.0


def test_no_breakaway_never_reaches_the_static_force_and_comes_held_and_cut():
    ends = set()
    for seed in range(30):
        recording = record(seed, "no-breakaway")
        truth, time_s, force_N = recording.truth, recording.true_time_s, recording.true_force_N
        assert force_N.max() < 0.97 * truth.lift_force_N
        assert np.isnan(truth.breakaway_time_s)
        assert truth.tooth_tops_N == ()
        ends.add("cut" if time_s[-1] < phase(truth, "loading").end_s else "held")
        # Nothing snaps: no sample-to-sample fall that a slip would make.
        assert np.diff(force_N[time_s < truth.phases[-1].start_s]).min() > -0.006 * truth.lift_force_N
    assert ends == {"cut", "held"}


def test_no_peak_slides_on_roughly_without_a_slip():
    for seed in range(10):
        recording = record(seed, "no-peak")
        slide, time_s = phase(recording.truth, "sliding"), recording.true_time_s
        force_N = recording.true_force_N[(time_s > slide.start_s + 0.1) & (time_s < slide.end_s)]
        assert force_N.mean() == pytest.approx(LIFT_N, rel=0.03)
        assert 0.004 < force_N.std() / LIFT_N < 0.03
        # It wanders below 15 Hz: nothing falls within a few milliseconds, as a slip would.
        assert (force_N[:-24] - force_N[24:]).max() < 0.035 * LIFT_N
        assert np.isnan(recording.truth.breakaway_time_s)


def test_high_teeth_and_drift_rise_above_the_first_peak_which_stays_the_truth():
    for seed in range(10):
        high, drift = record(seed, "high-tooth"), record(seed, "drift")
        tops_N = np.array(high.truth.tooth_tops_N)
        above = tops_N[1:] > LIFT_N
        assert 1 <= above.sum() <= 3
        assert 1.02 - 1e-9 <= (tops_N[1:][above] / LIFT_N).min() <= tops_N.max() / LIFT_N <= 1.08 * (1 + 1e-9)
        assert high.true_force_N.max() == pytest.approx(tops_N.max(), rel=2e-3)
        before = high.true_time_s < high.truth.breakaway_time_s
        assert high.true_force_N[before].max() == pytest.approx(LIFT_N, rel=1e-3)
        slide, time_s = phase(drift.truth, "sliding"), drift.true_time_s
        late_s = slide.end_s - 0.25 * (slide.end_s - slide.start_s)
        assert drift.true_force_N[(time_s > late_s) & (time_s < slide.end_s)].max() > LIFT_N
        assert drift.truth.lift_force_N == LIFT_N


def test_what_comes_before_the_peak_leaves_it_as_it_was():
    """A snag and an impact return to what was there before the pull; after a precursor the climb makes good for it."""
    for seed in range(3):
        clean = record(seed)
        for name, shortest_s, longest_s in (("snag", 0.03, 0.8), ("impact", 0.004, 0.03)):
            spoilt = record(seed, name)
            pushed = np.flatnonzero(spoilt.true_force_N - clean.true_force_N)
            begin_s, end_s = spoilt.true_time_s[pushed[[0, -1]]]
            assert shortest_s < end_s - begin_s < longest_s
            assert end_s < clean.truth.phases[1].end_s - 0.9  # before the motor starts
            assert spoilt.true_force_N[pushed].max() < 0.96 * clean.truth.lift_force_N
            assert spoilt.truth.breakaway_time_s == clean.truth.breakaway_time_s
        spoilt = record(seed, "precursor")
        before = clean.true_time_s < clean.truth.breakaway_time_s
        lost = (clean.true_force_N - spoilt.true_force_N)[before] / clean.truth.lift_force_N
        assert 0.015 < lost.max() < 0.12
        assert clean.true_force_N[before][np.argmax(lost > 0.0)] > 0.77 * clean.truth.lift_force_N
        assert spoilt.true_force_N[before].max() == pytest.approx(clean.truth.lift_force_N, rel=3e-3)


def test_slow_peaks_fall_slowly():
    for name, shortest_s, longest_s in (("rounded", 0.01, 0.25), ("slow-fall", 0.04, 0.7)):
        for seed in range(3):
            one = record(seed, name)
            force_N = one.true_force_N[one.true_time_s >= one.truth.breakaway_time_s]
            level_N = force_N[: int(0.3 * force_N.size)].min()
            lasting_s = np.argmax(force_N < level_N + 0.1 * (force_N[0] - level_N)) / 3000.0
            assert shortest_s < lasting_s < longest_s
            assert force_N[0] == pytest.approx(one.truth.lift_force_N, rel=2e-3)
