"""A stuck converter and a recording that is cut short give no force; coarse converters and smooth signals do."""

import csv
import gzip
import random
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ropefric.traces.breakaway import PickSettings, Status
from ropefric.traces.decision import pick_breakaway
from ropefric.traces.noise import find_stuck, noise_std, resolution
from ropefric.traces.readers import read_recordings
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.trace import ForceTrace
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


def picked(force_N):
    # The rope is loaded with 10 N before the pull.
    (found,) = pick_breakaway(ForceTrace(time_s=TIME_S, force_N=force_N), PickSettings(rest="pretension"))
    return found


def stuck_in(force_N):
    return find_stuck(force_N, resolution(force_N), noise_std(force_N)).tolist()


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("length", [150, 300, 600, 1500])
@pytest.mark.parametrize("before", [0.1, 0.5, 0.9])
def test_a_converter_that_sticks_over_the_peak_gives_no_force(length, before, seed):
    force = pull(0.6, 1.0, seed)
    start = int(PEAK_S * RATE_HZ - before * length)
    force[start : start + length] = force[start]
    found = picked(force)
    assert found.status is Status.NO_PEAK
    assert "reads exactly" in found.detail
    assert "stuck" in found.detail
    assert np.isnan(found.peak_N)


def test_a_converter_that_sticks_elsewhere_is_noted_and_the_force_is_right():
    whole = picked(pull(0.6, 1.0))
    for at_s in (0.1, 2.5):
        force = pull(0.6, 1.0)
        start = int(at_s * RATE_HZ)
        force[start : start + 600] = force[start]
        found = picked(force)
        assert found.status is Status.OK
        assert found.peak_N == pytest.approx(whole.peak_N, rel=2e-3)
        assert any("stuck" in note for note in found.notes)
        assert found.noise_std_N == pytest.approx(whole.noise_std_N, rel=0.05)


@pytest.mark.parametrize("count_N", [0.0, 0.1, 1.0, 5.0, 20.0])
@pytest.mark.parametrize("noise_N", [0.0, 0.02, 0.2, 0.6, 2.0])
def test_coarse_quiet_and_noise_free_signals_are_not_stuck(noise_N, count_N):
    """Before the load comes on all samples may be alike, and a coarse converter repeats itself for long."""
    for seed in range(3):
        force = pull(noise_N, count_N, seed)
        assert stuck_in(force) == []
        held = np.where(TIME_S < 1.5, force, force[int(1.5 * RATE_HZ)] if noise_N == 0.0 else force)
        assert stuck_in(held) == []


def test_no_recording_of_the_bench_sticks_but_at_the_ceiling():
    campaign = load_campaign(BENCH)
    for spec in campaign.trials[::12]:
        ((result,),) = extract_recording(campaign, [spec])
        assert not any("stuck" in note for note in result.breakaway.notes), spec.trial


@pytest.mark.parametrize("name", ["rsf_near_critical", "rsf_slow_weakening", "rsf_unstable"])
def test_simulated_sliders_are_not_stuck(real_data, name):
    rows = list(csv.reader((real_data / "rate_state_slider" / f"{name}.csv").read_text().splitlines()))
    numbers = [
        row for row in rows if row and row[-1].replace(".", "").replace("e-", "").lstrip("-").isdigit()
    ]
    for column in zip(*numbers, strict=True):
        assert stuck_in(np.array([float(cell) for cell in column])) == []


def cut_bench(campaign, tmp_path, n, seed):
    """Yield bench recordings cut at random places, with the force of the whole one."""
    draw = random.Random(seed)
    specs = [
        spec for spec in campaign.trials if spec.trial.startswith(("c01-r0", "c16-r", "c03-r0", "c31-r0"))
    ]
    whole = {spec.trial: extract_recording(campaign, [spec])[0][0] for spec in specs}
    # A partial slip is the only one that a file knows of which is cut after it.
    found = {trial: result.breakaway for trial, result in whole.items()}
    specs = [s for s in specs if found[s.trial].status is Status.OK and not found[s.trial].events]
    path = tmp_path / "cut.csv"
    for i in range(n):
        spec = specs[i % len(specs)]
        data = gzip.decompress(spec.path.read_bytes())
        data = data[: draw.randrange(int(0.1 * len(data)), len(data))]
        # Half of the cuts fall between two lines, as when a logger is stopped.
        path.write_bytes(data if i % 2 else data[: data.rfind(b"\n") + 1])
        ((found,),) = extract_recording(campaign, [replace(spec, path=path)])
        yield spec.trial, len(data), found, whole[spec.trial].peak_N


def test_a_recording_cut_anywhere_gives_its_force_or_none(tmp_path):
    """The bump of the load coming on passed for the peak where the file ended before the ramp."""
    campaign, statuses = load_campaign(BENCH), set()
    for name, length, found, peak_N in cut_bench(campaign, tmp_path, 250, seed=12):
        statuses.add(found.breakaway.status)
        if found.breakaway.status is Status.OK:
            assert found.peak_N == pytest.approx(peak_N, rel=0.02), (name, length)
    assert {Status.OK, Status.NO_BREAKAWAY, Status.UNREADABLE} <= statuses


def test_a_load_that_comes_on_and_is_held_is_no_break_away():
    """A damped overshoot, a rest of half a second, and the begin of the ramp: nothing slid."""
    on_s = TIME_S - 0.3
    rise = np.where(on_s < 0.15, 0.5 - 0.5 * np.cos(np.pi * np.clip(on_s, 0.0, 0.15) / 0.15), 1.0)
    ring = np.where(
        on_s > 0.15, 0.12 * np.exp(-(on_s - 0.15) / 0.02) * np.sin((on_s - 0.15) * 2 * np.pi / 0.08), 0.0
    )
    force = 10.0 + 140.0 * (rise + ring) + 180.0 * np.maximum(TIME_S - 1.0, 0.0)
    force = np.round(force + np.random.default_rng(1).normal(0.0, 0.6, force.size))
    for end_s in (0.55, 0.6, 0.7, 0.8, 0.9, 1.0, 1.05, 1.1, 1.2):
        part = end_s > TIME_S
        (found,) = pick_breakaway(ForceTrace(time_s=TIME_S[part], force_N=force[part]), PickSettings())
        assert found.status is not Status.OK, end_s


@pytest.mark.parametrize(("end", "n"), [("12.5\n", 5), ("12.5", 5), ("12.", 4), ("1", 4), ("123.45", 5)])
def test_a_last_number_that_may_be_cut_is_left_out(tmp_path, end, n):
    path = tmp_path / "a.csv"
    path.write_text("time_s,force_N\n0,12.1\n0.1,12.2\n0.2,12.3\n0.3,12.4\n0.4," + end)
    (found,) = read_recordings(path, ImportProfile())
    assert len(found.columns["force"]) == n
