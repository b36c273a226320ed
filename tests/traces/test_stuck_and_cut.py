"""A stuck converter and a recording that is cut short give no force; coarse converters and smooth signals do."""

import gzip
import random
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from drawn import picked
from thinned import thinned

from ropefric.traces.breakaway import PickSettings, Status
from ropefric.traces.noise import find_stuck, noise_std, resolution
from ropefric.traces.readers import read_recordings
from ropefric.traces.readers.profile import ImportProfile
from ropefric.trials.campaign import load_campaign
from ropefric.trials.extract import extract_recording

BENCH = Path(__file__).parents[2] / "data" / "prth-bench" / "campaign.toml"
RATE_HZ = 3000.0
TIME_S = np.arange(0.0, 3.2, 1.0 / RATE_HZ)
PEAK_S = 2.0


def pull(noise_N, count_N, seed=0):
    """A ramp of 180 N/s to a slip at 2 s, teeth while sliding, with noise, through a converter."""
    loading = 10.0 + 180.0 * np.maximum(TIME_S - 0.5, 0.0)
    teeth = 220.0 + 25.0 * ((TIME_S - PEAK_S) % 0.08) / 0.08
    force = np.where(TIME_S < PEAK_S, loading, teeth)
    force += np.random.default_rng(seed).normal(0.0, noise_N, force.size) if noise_N else 0.0
    return np.round(force / count_N) * count_N if count_N else force


def picked_pull(force_N):
    # The rope is loaded with 10 N before the pull.
    return picked(force_N, PickSettings(rest="pretension"), TIME_S[: force_N.size])


def stuck_in(force_N):
    return find_stuck(force_N, resolution(force_N), noise_std(force_N)).tolist()


@pytest.mark.parametrize("length", thinned([600, 150, 300, 1500], 4))
def test_a_converter_that_sticks_over_the_peak_gives_no_force(length):
    for seed, before in enumerate((0.1, 0.5, 0.9)):
        force = pull(0.6, 1.0, seed)
        start = int(PEAK_S * RATE_HZ - before * length)
        force[start : start + length] = force[start]
        found = picked_pull(force)
        assert found.status is Status.NO_PEAK
        assert "reads exactly" in found.detail
        assert np.isnan(found.peak_N)


def test_a_converter_that_sticks_elsewhere_is_noted_and_the_force_is_right():
    whole = picked_pull(pull(0.6, 1.0))
    for at_s in (0.1, 2.5):
        force = pull(0.6, 1.0)
        start = int(at_s * RATE_HZ)
        force[start : start + 600] = force[start]
        found = picked_pull(force)
        assert found.status is not Status.OK or found.peak_N == pytest.approx(whole.peak_N, rel=2e-3)
        assert any("stuck" in note for note in found.notes)
        assert found.noise_std_N == pytest.approx(whole.noise_std_N, rel=0.05)


@pytest.mark.parametrize("seed", thinned(range(3)))
def test_coarse_quiet_and_noise_free_signals_are_not_stuck(seed):
    """Before the load comes on all samples may be alike, and a coarse converter repeats itself for long."""
    for noise_N in (0.0, 0.02, 0.2, 0.6, 2.0):
        for count_N in (0.0, 0.1, 1.0, 5.0, 20.0):
            force = pull(noise_N, count_N, seed)
            assert stuck_in(force) == [], (noise_N, count_N)
            if noise_N == 0.0:
                assert stuck_in(np.where(TIME_S < 1.5, force, force[int(1.5 * RATE_HZ)])) == [], count_N


@pytest.mark.parametrize(("n", "seed"), [(20, 3), pytest.param(250, 12, marks=pytest.mark.slow)])
def test_a_recording_cut_anywhere_gives_its_force_or_none(tmp_path, n, seed):
    """Half of the cuts fall between two lines, as when a logger is stopped."""
    campaign, draw, statuses, wrong = load_campaign(BENCH), random.Random(seed), set(), []
    specs = [s for s in campaign.trials if s.trial.startswith(("c01-r0", "c16-r", "c03-r0", "c31-r0"))]
    specs = specs[:: 1 if n > 100 else 8]
    whole = {spec.trial: extract_recording(campaign, [spec])[0][0] for spec in specs}
    # A partial slip is the only one that a file knows of which is cut after it.
    specs = [spec for spec in specs if whole[spec.trial].breakaway.status is Status.OK]
    specs = [spec for spec in specs if not whole[spec.trial].breakaway.events]
    path = tmp_path / "cut.csv"
    for i in range(n):
        spec = specs[i % len(specs)]
        data = gzip.decompress(spec.path.read_bytes())
        data = data[: draw.randrange(int(0.1 * len(data)), len(data))]
        path.write_bytes(data if i % 2 else data[: data.rfind(b"\n") + 1])
        ((found,),) = extract_recording(campaign, [replace(spec, path=path)])
        statuses.add(found.breakaway.status)
        is_ok = found.breakaway.status is Status.OK
        if is_ok and found.peak_N != pytest.approx(whole[spec.trial].peak_N, rel=0.02):
            wrong.append((spec.trial, len(data)))
    assert len(wrong) <= 0.03 * n, (
        wrong
    )  # of what swings at the end of a cut, the break-away may be taken for one
    assert {Status.OK, Status.NO_BREAKAWAY, Status.UNREADABLE} <= statuses


def test_a_last_number_that_may_be_cut_is_left_out(tmp_path):
    for end, n in (("12.5\n", 5), ("12.5", 5), ("12.", 4), ("1", 4), ("123.45", 5)):
        path = tmp_path / "a.csv"
        path.write_text("time_s,force_N\n0,12.1\n0.1,12.2\n0.2,12.3\n0.3,12.4\n0.4," + end)
        (found,) = read_recordings(path, ImportProfile())
        assert len(found.columns["force"]) == n, end
