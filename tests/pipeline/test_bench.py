"""From the counts of data/prth-bench to the law and the lift force: what the rig knows must come out."""

from pathlib import Path

import numpy as np
import pytest

from ropefric.fitting.fit import fit_law
from ropefric.fitting.intervals import with_intervals
from ropefric.fitting.predict import predict
from ropefric.fitting.store import load_fit, verify_fits
from ropefric.friction.condition import Conditions, one_condition
from ropefric.report.campaign import write_report
from ropefric.report.page import Wish
from ropefric.trials.table import read_trial_table

pytestmark = pytest.mark.slow  # the run of all 432 recordings
FITS = Path(__file__).parents[2] / "fits"


def test_the_true_law_wins_by_far(bench_run, bench_truth):
    answer = bench_run[0].answer
    assert (answer.fit.law, answer.verdict.word) == (bench_truth["law"], "supported")
    assert answer.comparison.ranking[1].delta_aicc > 100
    supported = {cause.cause: cause.supported for cause in answer.diagnosis.causes}
    assert [supported[name] for name in ("size effect", "wrap effect", "load dependence")] == ["yes"] * 3
    assert supported["offset"] == "no"


@pytest.mark.parametrize("method", ["covariance", "profile"])
def test_the_truth_lies_within_the_stated_intervals(bench_run, bench_truth, method):
    fit = with_intervals(bench_run[0].answer.fit, method)
    for parameter in fit.parameters:
        low, high = parameter.ci95
        assert low <= bench_truth["parameters"][parameter.name] <= high, parameter
        assert high - low < 8 * parameter.std


def test_three_unseen_wheels_within_one_per_cent_and_within_their_intervals(bench_run, bench_truth):
    unseen = bench_truth["unseen"]
    assert len(unseen) == 3
    columns = {name: np.array([case[name] for case in unseen]) for name in unseen[0]}
    true_N = columns.pop("lift_force_N")
    found = predict(bench_run[0].answer.fit, Conditions(rope_radius_m=np.array(0.0049), **columns))
    assert np.abs(found.lift_force_N / true_N - 1).max() < 0.01
    assert (found.interval_N[:, 0] <= true_N).all()
    assert (true_N <= found.interval_N[:, 1]).all()
    assert not found.extrapolated.any()


def test_the_report_of_432_recordings_is_a_small_file(bench_run, tmp_path):
    write_report(bench_run[0], tmp_path, Wish())
    assert (tmp_path / "report.html").stat().st_size < 3_000_000


def test_the_design_of_the_campaign_is_predicted(bench_run, bench_truth):
    prediction = bench_run[0].answer.prediction
    case = bench_truth["unseen"][0]
    assert prediction.conditions.wheel_radius_m[0] == case["wheel_radius_m"]
    assert prediction.lift_force_N[0] == pytest.approx(case["lift_force_N"], rel=0.01)


def test_every_fit_of_the_run_can_be_made_again(bench_run):
    run, folder = bench_run
    found = verify_fits(folder / "fits")
    assert len(found) == len(run.answer.fits) >= 10
    assert all(item.ok for item in found), found


def test_the_stored_fits_come_out_of_their_data():
    found = verify_fits(FITS)
    assert {"coupled", "wrap-power", "constant", "constant-offset"} <= {item.law for item in found}
    assert all(item.ok for item in found), [item for item in found if not item.ok]


def test_the_stored_trials_and_fit_come_out_of_the_recordings(bench_run):
    run, folder = bench_run
    stored, fresh = read_trial_table(FITS / "prth-trials.csv"), read_trial_table(folder / "trials.csv")
    assert (stored.trial, stored.status) == (fresh.trial, fresh.status)
    assert (stored.kept == fresh.kept).all()
    np.testing.assert_allclose(stored.peak_N, fresh.peak_N, rtol=1e-4)
    old, new = load_fit(FITS / "prth-coupled.json"), run.answer.fit
    for was, now in zip(old.parameters, new.parameters, strict=True):
        assert abs(was.value - now.value) < 0.05 * was.std
        assert now.std == pytest.approx(was.std, rel=0.05)


def test_fixing_a_parameter_at_the_truth_sharpens_the_others(bench_run, bench_truth):
    table = bench_run[0].answer.table
    held = fit_law(table, "coupled", fixed={"d": bench_truth["parameters"]["d"]})
    free = bench_run[0].answer.fit
    assert held["c"].std < 0.6 * free["c"].std  # not half: what all trials have in common, the cells, stays
    assert held["d"].std == 0
    wheel = one_condition(0.035, 0.0049, 7.0, 60.0)
    assert predict(held, wheel).std_N[0] <= 1.05 * predict(free, wheel).std_N[0]
