"""Simulated campaigns with known truth: every status, every force, every mean."""

import math
import tomllib
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest

from ropefric.traces.breakaway import Status
from ropefric.trials.campaign import load_campaign
from ropefric.trials.extract import extract_campaign

BENCH, BIAS = Path(__file__).parents[2] / "data" / "prth-bench", 3e-3


def truths(folder):
    return tomllib.loads((folder / "truth.toml").read_text(encoding="utf-8"))


def wrong_statuses(extraction, truth):
    return [f"{trial.trial}: {trial.breakaway.status} for {truth[trial.trial]['status']}, "
        f"faults {truth[trial.trial]['faults']}: {trial.breakaway.detail}" for trial in extraction.trials
        if trial.breakaway.status != truth[trial.trial]["status"]]  # fmt: skip


@pytest.fixture(scope="module", params=[6, pytest.param(1, marks=pytest.mark.slow)])
def bench(request):
    """The committed bench, or one condition of six, extracted once."""
    campaign = load_campaign(BENCH / "campaign.toml")
    chosen = tuple(spec for spec in campaign.trials if int(spec.trial[1:3]) % request.param == 0)
    campaign = campaign.model_copy(update={"trials": chosen})
    return extract_campaign(campaign, jobs=2), truths(campaign.folder), campaign


def test_every_status_is_the_true_one_and_the_bad_have_their_problem_and_remedy(bench):
    extraction, truth, campaign = bench
    assert len(extraction.trials) == len(campaign.trials) >= 72
    assert len(truth["trials"]) == 432
    wrong = wrong_statuses(extraction, truth["trials"])
    # Where the picker is less sure than 0.8, or the zero drifts by a twentieth of F_A, it leaves a doubt, and no more.
    assert all(": doubtful for ok, " in said for said in wrong), wrong
    assert len(wrong) <= 0.035 * len(extraction.trials)
    if len(campaign.trials) == 432:
        assert {trial.breakaway.status for trial in extraction.trials} == set(Status)
    bad = {trial.file for trial in extraction.trials if trial.breakaway.status is not Status.OK}
    assert bad <= {one.path for one in extraction.problems if one.code.startswith(("RF1", "RF2"))}
    assert all(problem.fix for problem in extraction.problems)


def test_break_away_forces_have_no_bias_and_little_scatter_and_their_uncertainties_cover_it(bench):
    """A spike, a gap, hum, a snag before or a higher tooth after the static peak leave it where it was."""
    extraction, truth, campaign = bench
    ok = [trial for trial in extraction.trials if trial.breakaway.status is Status.OK]
    true_N = np.array([truth["trials"][trial.trial]["lift_force_N"] for trial in ok])
    peak_N, std_N = (np.array([getattr(trial, name) for trial in ok]) for name in ("peak_N", "peak_std_N"))
    relative = peak_N / true_N - 1
    assert relative.size > 0.92 * len(campaign.trials)
    assert abs(relative.mean()) < BIAS
    assert relative.std(ddof=1) < BIAS
    by_fault = defaultdict(list)
    for trial, error in zip(ok, relative, strict=True):
        for fault in truth["trials"][trial.trial]["faults"] or ["none"]:
            by_fault[fault].append(error)
    usual = {"none", "spike", "dropout", "high-tooth", "drift", "noisy", "clock-jitter"}
    if len(campaign.trials) == 432:
        assert usual | {"hum", "snag", "impact", "precursor", "rounded", "slow-fall"} <= set(by_fault)
    for fault, of_fault in by_fault.items():
        assert abs(np.mean(of_fault)) < BIAS, fault
        assert np.max(np.abs(of_fault)) < 0.02, fault
    pulls = np.abs(peak_N - true_N) / std_N
    assert pulls.mean() < 1.0  # the chain's limits count too, and a simulated cell has none
    assert pulls.max() < 4


def test_kept_means_are_the_true_ones(bench):
    extraction, truth, campaign = bench
    of_trial = {name: one.get("lift_force_N", math.nan) for name, one in truth["trials"].items()}
    assert len(extraction.conditions) == len(campaign.trials) // 12
    by_condition = {(c["wheel_radius_m"], round(c["wrap_angle_rad"], 6),
        c["end_tension_N"]): c["lift_force_N"] for c in truth["conditions"]}  # fmt: skip
    kept = {trial.trial for trial in extraction.trials if trial.kept}
    for found in extraction.conditions:
        law_N = by_condition[found.wheel_radius_m, round(found.wrap_angle_rad, 6), found.end_tension_N]
        mean_N = np.mean([of_trial[name] for name in found.trials if name in kept])
        assert found.mean_kept_N == pytest.approx(mean_N, rel=BIAS)
        # The ropes of a condition scatter by 1.7 % of the law; their mean of a dozen by half a percent.
        assert found.mean_kept_N == pytest.approx(law_N, rel=4 * 0.017 / math.sqrt(found.n_kept))
        assert found.lift_force_N == found.mean_kept_N


def test_what_counts_is_marked_and_nothing_is_deleted(bench):
    extraction, _, campaign = bench
    assert [trial.trial for trial in extraction.trials] == [spec.trial for spec in campaign.trials]
    rejected = {name for condition in extraction.conditions for name in condition.rejected}
    assert 0 < len(rejected) < 0.14 * len(campaign.trials)
    for trial in extraction.trials:
        assert trial.kept == (trial.breakaway.status is Status.OK and trial.trial not in rejected)
        assert (trial.rejected_by == "two-sigma") == (trial.trial in rejected)
        assert math.isfinite(trial.peak_N) == (trial.breakaway.status is Status.OK)
    for condition in extraction.conditions:
        assert condition.n_recorded == len(condition.trials) == 12
        assert condition.n_kept == condition.n - len(condition.rejected)
    n_kept = sum(trial.kept for trial in extraction.trials)
    assert sum(condition.n_kept for condition in extraction.conditions) == n_kept
