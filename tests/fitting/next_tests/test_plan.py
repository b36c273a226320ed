"""Plans: what they promise, what they keep to, and what they are worth."""

import csv
import dataclasses
import io
import math

import numpy as np
import pytest
from pulled import grid, table_at
from thinned import thinned

from ropefric.errors import InputError
from ropefric.fitting.fit import fit_law
from ropefric.fitting.next_tests import plan_tests, planned_fit, planned_guess
from ropefric.fitting.predict import predict
from ropefric.fitting.resolution import MeanScatter
from ropefric.fitting.result import CommonError
from ropefric.fitting.store import load_fit
from ropefric.friction.condition import Conditions, one_condition
from ropefric.friction.laws import LAWS
from ropefric.trials.table import read_trial_table

LAW_GUESSES = ("constant", "size-exponential", "wrap-power", "howell", "coupled")
# Expected gain in the width of the wanted interval over one factor at a time about the middle of the settings.
WORTHWHILE = 1.5


def expected_std(planned, evidence, wanted):
    """The standard error of ln F_A to expect at conditions."""
    return evidence.errors(planned.gradients(wanted))[0]


def test_no_number_of_pulls_takes_away_what_they_all_share(guessed):
    """Constant law, k conditions of wrap φ_i by a chain that is off by u: generalised least squares, written out."""
    u, error = 0.02, CommonError("calibration", "-", 0.02, (), "cell", "cell")
    scatter = MeanScatter(within=0.02, between=0.01)
    planned = dataclasses.replace(guessed("constant", scatter), chain="calibration", common=(error,))
    wraps, target = np.array([2.0, 5.0, 9.0]), one_condition(0.04, 0.0049, 12.0, 20.0)
    totals = []
    for k, repeats in ((1, 1), (1, 10**6), (100, 10**4)):
        at = Conditions(wheel_radius_m=0.04, rope_radius_m=0.0049, wrap_angle_rad=np.tile(wraps, k),
            end_tension_N=20)  # fmt: skip
        (total,), shared = planned.evidence(at, repeats).errors(planned.gradients(target))
        effect = np.full(3, u)
        own2 = 1e-4 + 4e-4 / repeats
        V = own2 / k * np.eye(3) + np.outer(effect, effect)
        weight = np.linalg.solve(V, wraps)
        assert total == pytest.approx(12.0 / math.sqrt(weight @ wraps), rel=1e-6)
        assert abs(shared.item()) == pytest.approx(abs(12.0 * (weight @ effect) / (weight @ wraps)), rel=1e-4)
        totals.append(total)
    assert totals[0] > totals[1] > totals[2]


def test_a_plan_says_when_more_pulls_do_not_help(bench, guessed, wanted):
    """A gain that all share goes with the offset of the law, so that no data tell the two apart."""
    law, name = LAWS["constant-offset"], "calibration of the force cell"
    plain = planned_guess(law, {"mu": 0.2, "k": 0.05}, MeanScatter(within=0.02, between=0.01))
    known, bad = (plan_tests(dataclasses.replace(plain, chain=name,
        common=(CommonError(name, "-", u, (), "cell", "cell"),)),
        bench, wanted("inside"), n_conditions=30, repeats=100, starts=1) for u in (0.001, 0.05))  # fmt: skip
    assert not any("more pulls would not narrow" in note for note in known.notes)
    (note,) = (note for note in bad.notes if "more pulls would not narrow" in note)
    assert name in note
    assert bad.after.shared_log[0] > 0.7 * bad.after.std_log[0]


def test_errors_that_a_fit_shares_reach_the_plan_as_in_its_prediction(bench, root):
    """Before: those of the fit; with more tests less, for these tell the errors as well."""
    fit = load_fit(root / "fits" / "prth-coupled.json")
    planned, target = planned_fit(fit), one_condition(0.04, 0.0049, math.radians(540), 80.0)
    along = planned.gradients(target)
    before, shared = planned.known.errors(along)
    by_fit = fit.friction_law.jacobian(fit.theta, target) @ fit.common_changes
    np.testing.assert_allclose(shared, by_fit, rtol=1e-3)
    at = bench.conditions()
    (many,), (most,) = (planned.known.joined(planned.evidence(at, repeats)).errors(along)[0]
        for repeats in (1000, 10**9))  # fmt: skip
    assert most <= many < before[0]


def test_the_expected_error_is_that_of_least_squares_in_closed_form(guessed):
    scatter = MeanScatter(within=0.02, between=0.01)
    np.testing.assert_allclose(scatter.variance([4, 10**9]), [2e-4, 1e-4], rtol=1e-6)
    planned, target = guessed("constant", scatter), one_condition(0.04, 0.0049, 12.0, 20.0)
    at = Conditions(wheel_radius_m=0.04, rope_radius_m=0.0049, wrap_angle_rad=[2, 5, 9], end_tension_N=20)
    found = expected_std(planned, planned.evidence(at, 5), target)[0]
    assert found == pytest.approx(12.0 * math.sqrt(0.01**2 + 0.02**2 / 5) / math.sqrt(4 + 25 + 81), rel=1e-12)


def test_an_error_that_cannot_be_told_is_infinite(guessed):
    planned = guessed("wrap-power")
    at = Conditions(wheel_radius_m=0.04, rope_radius_m=0.0049, wrap_angle_rad=[2, 5], end_tension_N=20)
    there = expected_std(planned, planned.evidence(at, 5), at)
    assert there.tolist() == [pytest.approx(0.01256, rel=0.01)] * 2
    other = one_condition(0.04, 0.0049, 12.0, 100.0)
    assert np.isinf(expected_std(planned, planned.evidence(at, 5), other)).all()
    assert np.isinf(expected_std(planned, guessed("wrap-power").known, other)).all()


@pytest.mark.parametrize(("name", "where"), thinned([(name, where) for name in LAW_GUESSES
    for where in ("inside", "large wheel", "strong")], every=4))  # fmt: skip
def test_a_plan_is_worth_half_as_much_again_as_one_factor_at_a_time(
    bench, guessed, wanted, usual, *, name, where
):
    found = plan_tests(guessed(name), bench, wanted(where), starts=2)
    planned, target = found.planned, wanted(where)
    usual_std = expected_std(planned, planned.evidence(usual(planned), 12), target)[0]
    assert usual_std > WORTHWHILE * found.after.std_log[0]
    assert found.after.dof == pytest.approx(12 - planned.n_free, rel=1e-9)


@pytest.mark.parametrize("name", thinned(["size-exponential", "wrap-power", "coupled"]))
def test_a_guess_that_is_off_by_a_fifth_still_gives_a_plan_worth_having(bench, guessed, wanted, usual, name):
    """The plan is made for the guess, and judged by the truth."""
    truth, target, rng = guessed(name), wanted("strong"), np.random.default_rng(1)
    usual_std = expected_std(truth, truth.evidence(usual(truth), 12), target)[0]
    for _ in range(3):
        off = 1.0 + 0.2 * rng.uniform(-1.0, 1.0, truth.theta.size)
        guess = dataclasses.replace(truth, theta=truth.theta * off)
        at = plan_tests(guess, bench, target, starts=2).conditions
        assert usual_std > 1.25 * expected_std(truth, truth.evidence(at, 12), target)[0]


def test_a_plan_keeps_to_the_rig(bench, guessed, wanted):
    found = plan_tests(guessed("coupled"), bench, wanted("strong"), starts=2)
    at = found.conditions
    for name in ("wheel_radius_m", "wrap_angle_rad", "end_tension_N"):
        assert set(getattr(at, name).tolist()) <= set(getattr(bench, name))
    assert np.exp(found.log_lift).max() <= bench.largest_force_N
    rows = {tuple(row.values())[1:5] for row in found.rows()}
    assert len(rows) == 12
    assert any("800 N of the cell" in note for note in found.notes)


def test_the_errors_expected_of_parameters_are_those_of_a_fit(bench, guessed, wanted):
    planned = guessed("size-exponential", MeanScatter(within=0.017))
    plan = plan_tests(planned, bench, wanted("large wheel"), repeats=8, starts=2)
    at = plan.conditions.select(np.repeat(np.arange(12), 8))
    ratio2 = []
    for seed in range(8):
        scatter = 0.017 * np.random.default_rng(seed).standard_normal(len(at))
        fit = fit_law(table_at(at, planned.law.log_lift(planned.theta, at) + scatter), planned.law)
        ratio2.append([(fit[name].std / std) ** 2 for name, std in plan.expected_parameter_std().items()])
    # The fit's own slopes are those at its estimate, and its scatter is estimated with 9 degrees of freedom each.
    assert np.mean(ratio2, axis=0) == pytest.approx(np.ones(len(ratio2[0])), abs=0.5)


def test_several_wanted_conditions_are_served_together(bench, guessed, wanted):
    planned, (near, far) = guessed("size-exponential"), (wanted("inside"), wanted("large wheel"))
    names = ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N")
    both = Conditions(**{name: np.append(getattr(near, name), getattr(far, name)) for name in names})
    together = plan_tests(planned, bench, both, starts=2)
    for i, alone in enumerate((near, far)):
        own = plan_tests(planned, bench, alone, starts=2)
        assert together.after.std_log[i] >= 0.98 * own.after.std_log[0]


def test_tests_that_add_to_a_fit_know_what_it_knows(bench, root):
    fit = load_fit(root / "fits" / "prth-coupled.json")
    planned = planned_fit(fit)
    target = one_condition(0.1, 0.0049, math.radians(720), 80.0)
    found = plan_tests(planned, bench, target, n_conditions=6, starts=2)
    # 31, and 37 with six more; the errors that are stated do not count against them.
    assert found.before.dof == pytest.approx(predict(fit, target).dof, rel=0.06)
    assert 31 < found.before.dof[0] < found.after.dof[0] - 6 < 34
    assert found.after.std_log[0] < found.before.std_log[0]
    assert found.improvement > 1.0

    def settings(at):
        columns = at.wheel_radius_m, at.wrap_angle_rad, at.end_tension_N
        return {tuple(np.round(row, 9)) for row in zip(*columns, strict=True)}

    assert not settings(planned.tested) & settings(found.conditions)


def test_only_a_parameter_at_its_bound_is_held_and_named(root):
    fit = load_fit(root / "fits" / "prth-coupled.json")
    assert not any("bound" in note for note in planned_fit(fit).notes)
    parameters = [dataclasses.replace(one, at_bound=one.name == "d") for one in fit.parameters]
    walled = planned_fit(dataclasses.replace(fit, parameters=tuple(parameters)))
    assert "d lies on a bound in the fit and is held there" in walled.notes


def test_the_error_before_is_about_that_of_the_fit(root):
    table = read_trial_table(root / "fits" / "prth-trials.csv")
    fit = fit_law(table, "coupled")
    planned = planned_fit(fit)
    target = one_condition(0.035, 0.0049, math.radians(400), 60.0)
    # The fit's is estimated from the residuals of 36 conditions, about 1/√(2·31) = 13 % off; three of these.
    ratio = expected_std(planned, planned.known, target)[0] / predict(fit, target).std_log[0]
    assert ratio == pytest.approx(1.0, abs=0.4)


def test_a_rope_for_each_condition_scatters_in_new_tests_as_in_those_of_the_fit():
    rng = np.random.default_rng(1)
    at = grid([0.03], np.linspace(1.5, 18.0, 8), [10.0, 80.0], 3)
    mu, noise = 0.2 * (1 + 0.03 * rng.normal(size=16)), 0.005 * rng.normal(size=48)
    table = table_at(at, at.log_end_tension + np.repeat(mu, 3) * at.wrap_angle_rad + noise)
    fit = fit_law(
        dataclasses.replace(table, labels={"rope_id": tuple(f"r{i // 3}" for i in range(48))}), "constant"
    )
    planned, target = planned_fit(fit), one_condition(0.03, 0.005, 20.0, 20.0)
    assert planned.own_mu_std == pytest.approx(0.03, rel=0.5)
    assert not planned.levels
    assert expected_std(planned, planned.known, target)[0] == pytest.approx(
        predict(fit, target).std_log[0], rel=0.15
    )
    # Pulls of one rope do not average out what makes it differ.
    once, often = (expected_std(planned, planned.evidence(target, n), target)[0] for n in (1, 1000))
    assert once == pytest.approx(math.hypot(planned.own_mu_std * 20.0 * fit["mu"].value, 0.005), rel=0.1)
    assert 0.9 * once < often < once


def test_what_lies_outside_is_said(bench, guessed, wanted):
    found = plan_tests(guessed("constant"), bench, wanted("large wheel"), starts=1)
    assert any("wheel radius 100 mm is outside" in note for note in found.notes)
    # The best for a constant coefficient is the largest wrap only, which would not show that it is none.
    assert any(note.startswith("only wrap") for note in found.notes)


def test_the_plan_is_a_table_for_the_lab(bench, guessed, wanted):
    found = plan_tests(guessed("constant"), bench, wanted("inside"), n_conditions=3, repeats=5, starts=1)
    rows = list(csv.DictReader(io.StringIO(found.to_csv())))
    assert [row["repeats"] for row in rows] == ["5"] * 3
    assert {float(row["wrap_angle_deg"]) % 45 for row in rows} == {0.0}
    assert {row["rope_diameter_mm"] for row in rows} == {"9.8"}
    law = LAWS["constant"]
    for row in rows:
        keys = ("wheel_radius_mm", "rope_diameter_mm", "wrap_angle_deg", "end_tension_N")
        R, d, wrap, load_N = (float(row[key]) for key in keys)
        at = one_condition(R / 1e3, d / 2e3, math.radians(wrap), load_N)
        lift_N = math.exp(law.log_lift([0.15], at)[0])
        assert float(row["expected_lift_force_N"]) == pytest.approx(lift_N, rel=1e-3)


def test_what_cannot_be_planned_is_told(bench, guessed, wanted):
    target = wanted("inside")
    with pytest.raises(InputError, match="3 conditions cannot determine the 3 parameters"):
        plan_tests(guessed("wrap-power"), bench, target, n_conditions=3)
    one_wheel = dataclasses.replace(bench, wheel_radius_m=(0.03,))
    with pytest.raises(InputError, match=r"singular.*determine") as caught:
        plan_tests(guessed("size-exponential"), one_wheel, target)
    assert "wheels" in caught.value.fix
    with pytest.raises(InputError, match="leave 0 conditions"):
        plan_tests(guessed("constant"), dataclasses.replace(bench, largest_force_N=1.0), target)
    with pytest.raises(InputError, match="at level 2"):
        plan_tests(guessed("constant"), bench, target, level=2.0)
    with pytest.raises(InputError, match="nothing to determine"):
        dataclasses.replace(guessed("constant"), free=np.array([False]))
    with pytest.raises(InputError, match="give standard deviations"):
        MeanScatter(within=0.0)
    with pytest.raises(InputError, match="are no settings"):
        dataclasses.replace(bench, wheel_radius_m=(0.0, 0.03))


def test_settings_the_law_has_no_answer_for_are_left_out(bench, guessed, wanted):
    low = dataclasses.replace(bench, end_tension_N=(0.5, 20.0, 80.0))
    found = plan_tests(guessed("wrap-power"), low, wanted("inside"), starts=1)
    assert any("wrap-power has no answer there" in note for note in found.notes)
    assert found.conditions.end_tension_N.min() >= 20.0
