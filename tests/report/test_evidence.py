"""What stands behind an answer: budgets, sensitivities and plans, against closed forms and their own definition."""

import csv
import json
import math
import statistics
from dataclasses import replace

import numpy as np
import pytest

from ropefric.errors import DataError
from ropefric.fitting.fit import fit_law
from ropefric.fitting.next_tests import plan_tests, planned_fit
from ropefric.fitting.predict import predict
from ropefric.fitting.resolution import RigLimits
from ropefric.friction.condition import one_condition
from ropefric.pipeline import (
    STEP,
    Evidence,
    chart_of_design,
    evidence_files,
    recorded_run,
    rejection_words,
    state_design,
    swings_of_design,
)
from ropefric.trials.outliers import RULES
from ropefric.trials.table import TrialTable

WHEEL = one_condition(0.04, 0.005, 5.0, 60.0)


@pytest.fixture(scope="module")
def capstan():
    wraps = np.repeat([3.0, 6.0, 9.0], 4)
    noise = 0.02 * np.random.default_rng(5).standard_normal(wraps.size)
    return fit_law(
        TrialTable(
            trial=tuple(f"t{i}" for i in range(wraps.size)), wheel_radius_m=0.04, rope_radius_m=0.005,
            wrap_angle_rad=wraps, end_tension_N=20.0, peak_N=20.0 * np.exp(0.2 * wraps + noise),
        ),
        "constant",
    )  # fmt: skip


def test_the_capstan_equation_swings_as_its_formula_says(capstan):
    prediction = predict(capstan, WHEEL)
    rows = {name.split(" ±")[0].split(":")[0]: row for name, *row in swings_of_design(capstan, prediction)}
    base_N, mu = float(prediction.lift_force_N[0]), capstan["mu"].value
    assert rows["end tension"] == pytest.approx([base_N * (1 - STEP), base_N * (1 + STEP), base_N])
    by_wrap = [base_N * math.exp(sign * STEP * mu * 5.0) for sign in (-1, 1)]
    assert rows["wrap"] == pytest.approx([*by_wrap, base_N])
    for name in ("wheel radius", "rope radius"):
        assert rows[name] == pytest.approx([base_N] * 3)
    assert rows["mean law"][:2] == pytest.approx(prediction.interval_N[0].tolist())
    assert rows["new rope"][:2] == pytest.approx(prediction.prediction_interval_N[0].tolist())


def test_a_budget_of_one_pull_agrees_with_the_prediction(capstan):
    """u_c²/F_A² is the variance of the mean law plus the scatter of a new rope."""
    stated, found = state_design(capstan, WHEEL), predict(capstan, WHEEL)
    std = math.hypot(capstan.statistics.scatter_within, np.nan_to_num(capstan.statistics.scatter_between))
    expected = math.hypot(float(found.std_log[0]), std)
    assert stated.budget.combined / stated.budget.estimate == pytest.approx(expected, rel=1e-6)
    assert sum(line.share for line in stated.budget.lines) == pytest.approx(1.0)


def test_the_chart_holds_the_law_on_the_wheel_that_was_asked_for(capstan):
    chart = chart_of_design(capstan, one_condition(0.037, 0.005, 5.0, 60.0))
    row = chart.wheel_radius_m.tolist().index(0.037)
    expected = 60.0 * np.exp(capstan["mu"].value * chart.wrap_angle_rad)
    assert np.allclose(chart.lift_force_N[row], expected)
    assert chart.wrap_angle_rad[-1] > 9.0


def test_the_marks_of_a_plan_do_not_hide_each_other(capstan):
    limits = RigLimits(
        wheel_radius_m=(0.02, 0.04, 0.06), wrap_angle_rad=(9.0,), end_tension_N=(30.0,), rope_radius_m=0.005
    )
    plan = plan_tests(planned_fit(capstan), limits, WHEEL, n_conditions=3, repeats=2)
    marks = plan.plot().collections[0]
    assert len({*marks.get_sizes()}) == 3
    assert [*marks.get_sizes()] == sorted(marks.get_sizes(), reverse=True)


def test_each_condition_has_a_budget_and_the_typical_one_is_the_median(run, evidence):
    assert [condition.number for condition, _ in evidence.measured] == list(range(1, 7))
    for (_, item), summary in zip(evidence.measured, run.extraction.conditions, strict=True):
        assert item.estimate == pytest.approx(summary.mean_kept_N)
        assert item.combined > summary.std_kept_N / math.sqrt(summary.n_kept)
    middle = statistics.median_high(item.relative for _, item in evidence.measured)
    found = evidence.typical.budget
    assert found.combined / found.estimate == pytest.approx(middle)
    assert evidence.measured[evidence.typical_number - 1][1].relative == pytest.approx(middle)


def test_the_plan_stays_within_what_the_rig_has_done_and_helps(run, evidence):
    plan, validity = evidence.plan, run.answer.fit.validity
    for name, (low, high) in validity.items():
        values = getattr(plan.conditions, name)
        assert (values >= low * (1 - 1e-6)).all()
        assert (values <= high * (1 + 1e-6)).all()
    assert {*plan.conditions.wheel_radius_m} <= {wheel.radius_m for wheel in run.campaign.wheels.values()}
    assert plan.improvement > 1.0
    assert plan.repeats == 6


def test_there_is_a_file_for_what_there_is(evidence):
    assert evidence_files(Evidence()) == {}
    texts = evidence_files(evidence)
    assert list(texts) == ["uncertainty.json", "next_tests.csv"]
    assert len(list(csv.DictReader(texts["next_tests.csv"].splitlines()))) == len(evidence.plan)


def test_a_manifest_that_is_none_is_said(tmp_path):
    damaged = json.dumps({"schema": "ropefric.run/1", "campaign": 3})
    for text in ("{", "[]", '{"schema": "ropefric.run/2"}', damaged):
        (tmp_path / "manifest.json").write_text(text, encoding="utf-8")
        with pytest.raises(DataError, match="this is no ropefric"):
            recorded_run(tmp_path)


def test_what_the_outlier_rule_costs_and_the_result_without_it(run, evidence):
    """As if the rule had taken one trial more: without the rule, the result is the one with that trial."""
    conditions, trials, answer = run.extraction.conditions, run.extraction.trials, run.answer
    sizes = [sum(trial.usable and trial.trial in item.trials for trial in trials) for item in conditions]
    lost = sum(RULES["two-sigma"].good_lost(n) for n in sizes)
    told = f"rejects {lost:.2g} good trials on average; here it rejected"
    assert f"{told} 0 of {sum(sizes)}" in evidence.rejection[0]
    taken = int(np.flatnonzero(answer.table.used)[3])
    marked = tuple(
        replace(t, kept=False, rejected_by="two-sigma") if i == taken else t for i, t in enumerate(trials)
    )
    kept = answer.table.kept & (np.arange(len(trials)) != taken)
    fit = fit_law(replace(answer.table, kept=kept), answer.fit.law)
    changed = replace(run, extraction=replace(run.extraction, trials=marked),
        answer=replace(answer, table=replace(answer.table, kept=kept),
        winner=replace(answer.winner, fit=fit)))  # fmt: skip
    expected, without = rejection_words(changed)
    assert f"{told} 1 of {sum(sizes)}" in expected
    lifts_N = [predict(one, answer.prediction.conditions).lift_force_N[0] for one in (answer.fit, fit)]
    assert f"F_A of the design is {lifts_N[0]:.5g} N instead of {lifts_N[1]:.5g} N" in without
    assert f"{answer.fit.law} has " in without
