"""Campaigns on disk: the same seed gives the same bytes, and the truth is the truth."""

import csv
import gzip
import math
import tomllib
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from ropefric.errors import InputError, UnknownNameError
from ropefric.rig.campaign import (
    PRTH_SEED,
    campaign_text,
    plan_trials,
    prth_bench_plan,
    record_trial,
    recording_text,
    simulate_campaign,
)
from ropefric.trials.campaign import check_campaign, load_campaign

COMMITTED = Path(__file__).parents[2] / "data" / "prth-bench"


def small(**changes):
    plan = prth_bench_plan()
    return replace(plan, name="small", conditions=plan.conditions[:3], **{"repeats": 4} | changes)


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A small campaign, its plan, what was told of its progress and the paths that were."""
    folder, seen = tmp_path_factory.mktemp("written") / "a", []
    plan = small(repeats=2, faults={"dropout": 0.5})
    paths = simulate_campaign(folder, plan, seed=5, progress=lambda *args: seen.append(args))
    return folder, plan, seen, paths


def contents(folder):
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def test_the_same_seed_writes_the_same_bytes_and_another_does_not(written, tmp_path):
    folder, plan, seen, paths = written
    simulate_campaign(tmp_path / "b", plan, seed=5)
    other, _ = record_trial(plan, plan_trials(plan, seed=6)[0], seed=6)
    first = contents(folder)
    assert first == contents(tmp_path / "b")
    assert gzip.decompress(first["traces/c01-r01.csv.gz"]).decode() != recording_text(other)
    assert sorted(str(path.relative_to(folder)) for path in paths) == sorted(first)
    assert [(done, n) for done, n, _ in seen] == [(i + 1, 6) for i in range(6)]


def test_files_hold_what_they_say(written):
    folder, plan, *_ = written
    campaign, truth = (tomllib.loads((folder / f"{name}.toml").read_text()) for name in ("campaign", "truth"))
    assert campaign["schema"] == "ropefric.campaign/1"
    assert "simulated" in campaign["name"]
    assert (campaign["wheels"]["W30"]["radius"], campaign["cells"]["K5"]["full_scale"]) == ("30 mm", "5 kN")
    assert campaign["tare"]["interval"] == ["0 s", "0.25 s"]
    header, *_ = lines = (folder / "trials.csv").read_text().splitlines()
    assert header == "trial,file,wheel,wrap_angle_deg,end_tension_N,cell,rope_id,dwell_s,exclude"
    rows = list(csv.DictReader(lines))
    assert len({row["rope_id"] for row in rows}) == len(rows) == 6
    assert {row["exclude"] for row in rows} == {""}
    assert set(truth["trials"]) == {row["trial"] for row in rows}
    planned, empty = {trial.name: trial for trial in plan_trials(plan, seed=5)}, 0
    for row in rows:
        head, *lines = gzip.decompress((folder / row["file"]).read_bytes()).decode().splitlines()
        assert head == "time_s,counts"
        cells = np.array([[cell or "nan" for cell in line.split(",")] for line in lines], dtype=np.float64)
        recording, _ = record_trial(plan, planned[row["trial"]], seed=5)
        np.testing.assert_allclose(cells[:, 0], recording.time_s, rtol=0.0, atol=5.01e-7)
        np.testing.assert_array_equal(cells[:, 1], recording.counts)
        empty += np.isnan(cells[:, 1]).sum()
        assert truth["trials"][row["trial"]]["lift_force_N"] == pytest.approx(recording.truth.lift_force_N)
    assert empty > 0


def lift_by_quadrature(condition, p, rope_radius_m):
    """Eqs. (16), (17) straight from the page: φ0 by root finding, the integral by quadrature."""
    mu_r = p["mu_inf"] * (1 - math.exp(p["a"] * condition.wheel_radius_m / rope_radius_m + p["b"]))

    def risen(phi):
        # φ = x² takes the singularity of φ^c at 0 away.
        return quad(lambda x: (mu_r * x ** (2 * p["c"]) + p["d"]) * 2 * x, 0, math.sqrt(phi), epsabs=1e-12)[0]

    phi0 = brentq(lambda phi: risen(phi) - math.log(condition.end_tension_N), 1e-9, 1e3, xtol=1e-13)
    return math.exp(risen(phi0 + condition.wrap_angle_rad))


def test_the_true_lift_force_is_the_integral_of_the_law():
    plan = prth_bench_plan()
    points = (*plan.conditions, plan.design, *plan.unseen)
    expected = [lift_by_quadrature(c, plan.parameters, 0.0049) for c in points]
    assert plan.lift_force_N(points) == pytest.approx(expected, rel=1e-8)


def test_trial_scatter_is_17_per_mille_about_the_law():
    plan = prth_bench_plan()
    law_N = np.repeat(plan.lift_force_N(plan.conditions), plan.repeats)
    z = np.concatenate([[t.lift_force_N for t in plan_trials(plan, seed=s)] / law_N - 1 for s in range(10)])
    assert z.std() == pytest.approx(0.017, rel=3 / math.sqrt(2 * z.size))
    assert abs(z.mean()) < 3.5 * 0.017 / math.sqrt(z.size)


def test_condition_scatter_is_shared_by_the_repeats():
    plan = prth_bench_plan()
    plan = replace(plan, bench=replace(plan.bench, condition_scatter=0.03, trial_scatter=0.0))
    lift_N = np.reshape([t.lift_force_N for t in plan_trials(plan, seed=1)], (36, 12))
    assert np.ptp(lift_N, axis=1) == pytest.approx(0.0, abs=1e-9)
    assert (lift_N[:, 0] / plan.lift_force_N(plan.conditions) - 1).std() == pytest.approx(0.03, rel=0.4)


def test_faults_are_dealt_by_quota_and_mechanics_are_spoilt_at_most_once():
    trials = plan_trials(prth_bench_plan(), seed=3)
    dealt = Counter(name for trial in trials for name in trial.faults)
    assert (dealt["spike"], dealt["unreadable"]) == (30, 1)
    assert dealt["saturation"] == dealt["no-peak"] == dealt["no-breakaway"] == 4
    mechanics = {"saturation", "no-breakaway", "no-peak", "high-tooth", "drift", "noisy"}
    assert max(len(mechanics & set(trial.faults)) for trial in trials) == 1
    # A cell too small, not a jammed rope: the truth keeps to the law.
    assert all(t.lift_force_N > 1020.0 for t in trials if "saturation" in t.faults)


def test_the_campaign_reader_finds_nothing_wrong(written):
    problems = check_campaign(written[0] / "campaign.toml")
    # Three conditions see neither load nor wrap, and the reader may say so; nothing may be an error.
    assert not [problem for problem in problems if problem.severity == "error"]
    assert check_campaign(COMMITTED / "campaign.toml") == ()
    campaign = load_campaign(written[0] / "campaign.toml")
    condition = small().conditions[1]
    trial = campaign.trials[2]
    assert (trial.trial, trial.wheel_radius_m, trial.end_tension_N) == ("c02-r01", 0.015, 60.0)
    assert trial.wrap_angle_rad == pytest.approx(condition.wrap_angle_rad, rel=1e-14)


def test_nothing_is_overwritten(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match=r"already holds notes\.txt"):
        simulate_campaign(tmp_path, small(), seed=1)
    assert (tmp_path / "notes.txt").read_text() == "mine"
    with pytest.raises(InputError, match="cannot write there"):
        simulate_campaign(tmp_path / "notes.txt", small(), seed=1)


def test_impossible_plans_are_refused():
    lacking = {"mu_inf": 0.4, "a": -0.2, "b": -0.3, "c": -0.4}
    for wrong, words in ((lambda: small(repeats=0), "are 0 recordings"),
        (lambda: small(parameters=lacking), "no value for d"),
        (lambda: small(parameters={"mu_ifn": 0.4}), "did you mean 'mu_inf'"),
        (lambda: small(faults={"gremlins": 0.1}), "unknown fault"),
        (lambda: small(faults={"spike": 1.5}), r"rate 1\.5 is not between 0 and 1")):  # fmt: skip
        with pytest.raises((InputError, UnknownNameError), match=words):
            wrong()


def test_the_committed_bench_is_what_the_plan_and_seed_give():
    plan = prth_bench_plan()
    trials = plan_trials(plan, seed=PRTH_SEED)
    truth = tomllib.loads((COMMITTED / "truth.toml").read_text())
    assert ((COMMITTED / "campaign.toml").read_text(), truth["seed"]) == (campaign_text(plan), PRTH_SEED)
    assert len(list((COMMITTED / "traces").iterdir())) == len(trials) == 432
    assert sum(p.stat().st_size for p in COMMITTED.rglob("*") if p.is_file()) < 12e6
    damaged = {t.place for t in trials if "unreadable" in t.faults}
    for index in sorted({0, 200, 431} - damaged):
        recording, _ = record_trial(plan, trials[index], seed=PRTH_SEED)
        # The text, not the packed bytes: another zlib may pack the same text differently.
        assert gzip.decompress((COMMITTED / trials[index].file).read_bytes()).decode() == recording_text(
            recording
        )
        assert truth["trials"][trials[index].name]["status"] == recording.truth.status.value
