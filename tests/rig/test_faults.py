"""Every fault does what it says, and nothing else."""

import gzip

import numpy as np
import pytest
from thinned import slow, thinned

from ropefric.errors import InputError
from ropefric.rig.bench import HELD_BENCH, Bench
from ropefric.rig.recording import FAULTS, simulate_recording
from ropefric.traces.breakaway import Status

SEEDS = range(25)
CEILING = 1023


def record(seed, *faults, lift=320.7, end=80.0, **kw):
    return simulate_recording(
        Bench(), lift_force_N=lift, end_tension_N=end, rng=np.random.default_rng(seed), faults=faults, **kw
    )


@pytest.mark.parametrize(
    ("name", "physics"),
    [(name, "coulomb") for name in FAULTS]
    + [
        slow((name, one)) for name, fault in FAULTS.items() if fault.ranges for one in ("rate-state", "lugre")
    ],
)
def test_the_truth_names_the_fault_and_its_status(name, physics):
    fault = FAULTS[name]
    truth = record(1, name, physics=physics).truth
    assert truth.faults == (name,)
    assert truth.status is (fault.expected_status or Status.OK)
    assert 0.0 <= fault.rate <= 0.1


def runs(mask):
    edges = np.diff(np.concatenate(([0], mask.astype(int), [0])))
    return np.flatnonzero(edges == -1) - np.flatnonzero(edges == 1)


def test_spikes_are_one_or_two_samples_and_sometimes_near_the_peak():
    near = 0
    for seed in range(80):
        clean, spoilt = record(seed), record(seed, "spike")
        changed = clean.counts != spoilt.counts
        assert 1 <= changed.sum() <= 6
        assert len(runs(changed)) <= 3
        assert spoilt.counts.min() >= 0
        assert spoilt.counts.max() <= CEILING
        near += (np.abs(clean.time_s[changed] - clean.truth.breakaway_time_s) < 0.03).any()
        assert spoilt.truth.lift_force_N == clean.truth.lift_force_N
    assert 10 < near < 60


def test_dropouts_are_short_and_spare_the_peak():
    empty = stuck = 0
    for seed in range(60):
        clean, spoilt = record(seed), record(seed, "dropout")
        lost = np.isnan(spoilt.counts)
        assert max(runs(lost), default=0) <= 60  # two gaps may touch
        frozen = ~lost & (spoilt.counts != clean.counts)
        empty, stuck = empty + lost.any(), stuck + frozen.any()
        touched_s = clean.time_s[lost | frozen]
        assert (np.abs(touched_s - clean.truth.breakaway_time_s) > 0.011).all()
    assert empty > 20
    assert stuck > 5


def test_saturation_hides_the_peak_above_the_ceiling():
    for seed in SEEDS:
        for lift, end, cell in ((1200.0, 150.0, "K1"), (320.7, 80.0, "K1"), (5900.0, 700.0, "K5")):
            recording = record(seed, "saturation", lift=lift, end=end)
            truth = recording.truth
            assert truth.cell == cell
            assert truth.lift_force_N > 1000.0 * (1 - 15.0 / CEILING)
            at_peak = np.abs(recording.time_s - truth.breakaway_time_s) < 0.5 / 3000.0
            assert (recording.counts[at_peak] == CEILING).all()
            assert runs(recording.counts == CEILING).max() > 5
    assert record(0, "saturation", lift=1200.0, end=150.0).truth.lift_force_N == 1200.0


def test_no_breakaway_never_reaches_the_static_force_and_comes_held_and_cut():
    ends = set()
    for seed in range(60):
        recording = record(seed, "no-breakaway")
        truth = recording.truth
        assert truth.status is Status.NO_BREAKAWAY
        assert recording.true_force_N.max() < 0.97 * truth.lift_force_N
        assert np.isnan(truth.breakaway_time_s)
        assert truth.tooth_tops_N == ()
        loading = next(p for p in truth.phases if p.name == "loading")
        rising = recording.true_time_s[-1] < loading.end_s
        ends.add("cut" if rising else "held")
        # Nothing snaps: no sample-to-sample fall that a slip would make.
        held = recording.true_force_N[recording.true_time_s < truth.phases[-1].start_s]
        assert np.diff(held).min() > -0.006 * truth.lift_force_N
    assert ends == {"cut", "held"}


def test_no_peak_slides_on_roughly_without_a_slip():
    for seed in SEEDS:
        recording = record(seed, "no-peak")
        truth = recording.truth
        slide = next(p for p in truth.phases if p.name == "sliding")
        sliding = (recording.true_time_s > slide.start_s + 0.1) & (recording.true_time_s < slide.end_s)
        force_N = recording.true_force_N[sliding]
        assert force_N.mean() == pytest.approx(truth.lift_force_N, rel=0.03)
        assert 0.004 < force_N.std() / truth.lift_force_N < 0.03
        # It wanders below 15 Hz: nothing falls within a few milliseconds, as a slip would.
        steps = round(0.008 / (recording.true_time_s[1] - recording.true_time_s[0]))
        assert (force_N[:-steps] - force_N[steps:]).max() < 0.035 * truth.lift_force_N
        assert np.isnan(truth.breakaway_time_s)


def test_too_short_ends_while_idle():
    for seed in SEEDS:
        recording = record(seed, "too-short")
        assert 5 <= recording.counts.size < 50
        assert recording.counts.max() < 25


def test_high_teeth_stand_above_the_first_peak_which_stays_the_truth():
    for seed in SEEDS:
        recording = record(seed, "high-tooth")
        truth = recording.truth
        tops_N = np.array(truth.tooth_tops_N)
        high = tops_N[1:] > truth.lift_force_N
        assert 1 <= high.sum() <= 3
        assert (tops_N[1:][high] / truth.lift_force_N).min() >= 1.02 - 1e-9
        assert tops_N.max() <= 1.08 * truth.lift_force_N * (1 + 1e-9)
        assert recording.true_force_N.max() == pytest.approx(tops_N.max(), rel=2e-3)
        before = recording.true_time_s < truth.breakaway_time_s
        assert recording.true_force_N[before].max() == pytest.approx(320.7, rel=1e-3)


def test_drift_climbs_above_the_first_peak():
    for seed in SEEDS:
        recording = record(seed, "drift")
        slide = next(p for p in recording.truth.phases if p.name == "sliding")
        length_s = slide.end_s - slide.start_s
        late = (recording.true_time_s > slide.end_s - 0.25 * length_s) & (recording.true_time_s < slide.end_s)
        assert recording.true_force_N[late].max() > 320.7
        assert recording.truth.lift_force_N == 320.7


def test_noise_is_four_times_as_loud():
    for seed in range(5):
        idle = [record(seed, *f).counts[:700].var() - 1 / 12 for f in ((), ("noisy",))]
        assert np.sqrt(idle[1] / idle[0]) == pytest.approx(4.0, rel=0.2)


def test_clocks_jitter_or_repeat():
    kinds = set()
    for seed in SEEDS:
        clean, spoilt = record(seed), record(seed, "clock-jitter")
        assert np.array_equal(clean.counts, spoilt.counts)
        steps_s = np.diff(spoilt.time_s)
        kinds.add("repeats" if (steps_s == 0).any() else "jitters")
        assert np.abs(spoilt.time_s - clean.time_s).max() < 1.001 / 3000.0
    assert kinds == {"repeats", "jitters"}


def test_unreadable_files_cannot_be_unpacked():
    data = gzip.compress(b"time_s,counts\n" + b"0.000000,11\n" * 500, mtime=0)
    for seed in range(40):
        damaged = FAULTS["unreadable"].on_bytes(data, np.random.default_rng(seed))
        assert damaged != data
        with pytest.raises((EOFError, OSError)):
            gzip.decompress(damaged)


def test_faults_combine_and_the_worst_status_counts():
    assert record(0, "no-peak", "spike").truth.status is Status.NO_PEAK
    assert record(0, "no-peak", "too-short", "unreadable").truth.status is Status.UNREADABLE


def test_a_fault_of_the_mechanics_is_refused_where_there_is_no_breakaway():
    with pytest.raises(InputError, match="'no-peak' does not go with protocol 'held'"):
        simulate_recording(
            HELD_BENCH,
            lift_force_N=7.9,
            end_tension_N=4.6,
            rng=np.random.default_rng(0),
            faults=["no-peak"],
            protocol="held",
        )


@pytest.mark.parametrize("physics", thinned(["coulomb", "rate-state"]))
@pytest.mark.parametrize(("name", "shortest_s", "longest_s"), [("snag", 0.03, 0.8), ("impact", 0.004, 0.03)])
def test_pushes_return_to_what_was_there_before_the_pull(name, shortest_s, longest_s, physics):
    for seed in range(4 if physics == "coulomb" else 2):
        clean, spoilt = record(seed, physics=physics), record(seed, name, physics=physics)
        added = spoilt.true_force_N - clean.true_force_N
        pushed = np.flatnonzero(added)
        begin_s, end_s = spoilt.true_time_s[pushed[[0, -1]]]
        assert shortest_s < end_s - begin_s < longest_s
        assert end_s < clean.truth.phases[1].end_s - 0.9  # before the motor starts
        assert spoilt.true_force_N[pushed].max() < 0.96 * clean.truth.lift_force_N
        assert spoilt.truth.breakaway_time_s == clean.truth.breakaway_time_s


@pytest.mark.parametrize("physics", thinned(["coulomb", "lugre"]))
def test_a_precursor_falls_and_the_climb_still_ends_at_the_static_friction(physics):
    for seed in range(4 if physics == "coulomb" else 2):
        clean, spoilt = record(seed, physics=physics), record(seed, "precursor", physics=physics)
        before = clean.true_time_s < clean.truth.breakaway_time_s
        lost = (clean.true_force_N - spoilt.true_force_N)[before] / clean.truth.lift_force_N
        assert 0.015 < lost.max() < 0.12
        assert clean.true_force_N[before][np.argmax(lost > 0.0)] > 0.77 * clean.truth.lift_force_N
        assert spoilt.true_force_N[before].max() == pytest.approx(clean.truth.lift_force_N, rel=3e-3)


@pytest.mark.parametrize("physics", thinned(["coulomb", "rate-state"]))
@pytest.mark.parametrize(
    ("name", "shortest_s", "longest_s"), [("rounded", 0.01, 0.25), ("slow-fall", 0.04, 0.7)]
)
def test_slow_peaks_fall_slowly(name, shortest_s, longest_s, physics):
    for seed in range(4 if physics == "coulomb" else 2):
        one = record(seed, name, physics=physics)
        after = one.true_time_s >= one.truth.breakaway_time_s
        force_N = one.true_force_N[after]
        level_N = force_N[: int(0.3 * force_N.size)].min()
        lasting_s = np.argmax(force_N < level_N + 0.1 * (force_N[0] - level_N)) / 3000.0
        assert shortest_s < lasting_s < longest_s
        assert force_N[0] == pytest.approx(one.truth.lift_force_N, rel=2e-3)


def test_hum_and_drifting_zero_are_in_the_counts_alone():
    for seed in range(4):
        clean, hum, drift = record(seed), record(seed, "hum"), record(seed, "zero-drift")
        wave = (hum.counts - clean.counts)[:3000]
        strongest_Hz = np.argmax(np.abs(np.fft.rfft(wave))[1:]) + 1
        assert strongest_Hz in {50, 60}
        assert np.array_equal(clean.true_force_N, hum.true_force_N)
        wandered = drift.counts - clean.counts
        part = (
            (np.median(wandered[-300:]) - np.median(wandered[:300]))
            * 1000.0
            / 1023
            / clean.truth.lift_force_N
        )
        assert 0.04 < abs(part) < 0.11
        assert drift.counts.min() > 0
