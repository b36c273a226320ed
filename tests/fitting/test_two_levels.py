"""Scatter at two levels and what it leaves of the parameters: against closed forms, direct algebra and simulation."""

import math

import numpy as np
import pytest
from scipy import stats

from ropefric.fitting.budgets import state_lift
from ropefric.fitting.fit import fit_law
from ropefric.fitting.intervals import bootstrap_t, is_straight, with_intervals
from ropefric.fitting.predict import predict
from ropefric.fitting.result import FitResult
from ropefric.fitting.statistics import (
    clustered_covariance,
    combined_dof,
    pooled_scatter,
    two_levels,
)
from ropefric.friction.condition import Conditions, one_condition
from ropefric.friction.laws import LAWS
from ropefric.trials.table import TrialTable

WRAPS = np.array([2.0, 3.0, 4.5, 6.0, 9.0, 12.0])


def table(log_lift, repeats=1, *, wraps=WRAPS, wheel_m=0.03, end_N=20.0, **more):
    n = np.size(log_lift)
    return TrialTable(trial=tuple(map(str, range(n))), wheel_radius_m=wheel_m, rope_radius_m=0.005,
        wrap_angle_rad=np.repeat(wraps, repeats), end_tension_N=end_N, peak_N=end_N * np.exp(log_lift),
        **more)  # fmt: skip


def wheel(wrap=5.0, radius_m=0.03, end_N=20.0):
    return one_condition(radius_m, 0.005, wrap, end_N)


# --- degrees of freedom ---------------------------------------------------------------------------------------------


def test_degrees_of_freedom_of_two_groups_are_those_printed():
    """Imbens & Kolesár (2016), Rev. Econ. Stat. 98:701: 3 treated among 30 units leave 2.5 degrees of freedom.

    With even scatter the contrast of two means has Welch's (1/n₁ + 1/n₀)²/(1/n₁²(n₁ − 1) + 1/n₀²(n₀ − 1)).
    """
    n1, n0 = 3, 27
    J = np.column_stack([np.ones(30), np.arange(30) < n1]).astype(float)
    _, dof = clustered_covariance(J, np.ones(30), np.arange(30))
    welch = (1 / n1 + 1 / n0) ** 2 / (1 / n1**2 / (n1 - 1) + 1 / n0**2 / (n0 - 1))
    assert (dof[1], round(dof[1], 1)) == (pytest.approx(welch, rel=1e-5), 2.5)
    assert dof[0] == pytest.approx(n0 - 1)  # the mean of the others alone


def test_a_part_that_is_known_for_sure_raises_the_degrees_of_freedom():
    assert combined_dof(2.0, 1.0, 4.0) == pytest.approx(16.0)  # u_c⁴/(u⁴/ν)
    assert combined_dof(2.0, 0.0, 4.0) == 4.0
    assert np.isinf(combined_dof(2.0, 2.0, 4.0))


# --- two levels -----------------------------------------------------------------------------------------------------


def linear_problem(rng, sizes, between, within, common=0.0):
    """A straight line through conditions of `sizes` repeats; truth zero."""
    group = np.repeat(np.arange(sizes.size), sizes)
    J = np.column_stack([np.ones(sizes.size), WRAPS[: sizes.size]])[group]
    y = (between * rng.standard_normal(sizes.size))[group] + within * rng.standard_normal(group.size)
    return J, y + common * rng.standard_normal(), group


def solved(J, y, group, common=None):
    theta = np.linalg.lstsq(J, y, rcond=None)[0]
    residual, std = y - J @ theta, np.ones(y.size)
    return theta, two_levels(J, residual, std, group, pooled_scatter(residual, group), common)


@pytest.mark.parametrize("between", [0.0, 0.03])
def test_where_all_have_as_many_repeats_it_is_the_straight_line_through_the_means(between):
    J, y, group = linear_problem(np.random.default_rng(5), np.full(6, 4), between, 0.02)
    _, found = solved(J, y, group)
    line = stats.linregress(WRAPS, y.reshape(6, 4).mean(axis=1))
    assert math.sqrt(found.covariance[1, 1]) == pytest.approx(line.stderr, rel=1e-9)
    assert math.sqrt(found.covariance[0, 0]) == pytest.approx(line.intercept_stderr, rel=1e-9)
    assert found.dof == pytest.approx(4.0)


@pytest.mark.parametrize(("sizes", "between"),
    [pytest.param((5, 5, 5, 5, 5, 5), 0.0, marks=pytest.mark.slow),
    pytest.param((1, 1, 1, 1, 1, 1), 0.02, marks=pytest.mark.slow), ((1, 9, 2, 7, 1, 5), 0.02)])  # fmt: skip
def test_intervals_hold_the_truth_in_95_of_100(sizes, between):
    """A simulation that shares no code with the estimate but the estimate itself."""
    rng, n, inside = np.random.default_rng(11), 800, 0
    for _ in range(n):
        J, y, group = linear_problem(rng, np.array(sizes), between, 0.02)
        theta, found = solved(J, y, group)
        inside += abs(theta[1]) <= stats.t.ppf(0.975, found.dof) * math.sqrt(found.covariance[1, 1])
    # Binomial: four standard deviations, and half a per cent for Satterthwaite where the repeats are uneven.
    assert abs(inside / n - 0.95) < 4 * math.sqrt(0.95 * 0.05 / n) + 0.005 * (len(set(sizes)) > 1)


def test_the_scatter_between_conditions_is_unbiased_but_for_its_floor():
    rng, sizes, n = np.random.default_rng(2), np.array([2, 6, 3, 8, 2, 4]), 800
    found = [solved(*linear_problem(rng, sizes, 0.05, 0.02))[1].between ** 2 for _ in range(n)]
    assert np.mean(found) == pytest.approx(0.05**2, rel=4 * math.sqrt(2 / 4 / n) + 0.01)


# --- errors in common -----------------------------------------------------------------------------------------------


def test_a_cells_gain_reaches_the_coefficient_by_hand_and_does_not_average_out():
    """ln F_A too high by ε everywhere moves μ by ε Σφ/Σφ²; what of it the residuals show is not counted twice."""
    rng, gain, n = np.random.default_rng(8), 0.03, 80
    estimates, claimed = [], []
    for _ in range(n):
        y = 0.2 * np.repeat(WRAPS, 4) + 0.01 * rng.standard_normal(24) + gain * rng.standard_normal()
        trials = table(y, 4)
        rough = table(y, 4, peak_std_N=gain * trials.peak_N)
        fit = fit_law(rough, "constant", n_starts=1)
        estimates.append(fit["mu"].value)
        claimed.append(fit["mu"].std)
    (common,) = fit.common_errors
    assert (common.name, common.unit) == ("calibration of the force cell", "-")
    assert common.change[0] == pytest.approx(gain * WRAPS.sum() / (WRAPS @ WRAPS), rel=1e-6)
    # The spread of 80 estimates is known to 8 %; the claim holds a scatter of few degrees of freedom.
    assert np.sqrt(np.mean(np.square(claimed))) == pytest.approx(np.std(estimates), rel=0.12)
    plain = fit_law(trials, "constant", n_starts=1)
    assert np.mean(claimed) > 1.5 * plain["mu"].std


def test_a_wheels_radius_is_one_error_for_all_its_conditions():
    """ln F_A of `thickness` by R_w, seen through the fit: the same as the fit with all radii wrong by 1 σ."""
    wheels = np.repeat([0.02, 0.05], 12)
    rng = np.random.default_rng(4)
    at = Conditions(wheel_radius_m=wheels, rope_radius_m=0.005, wrap_angle_rad=np.tile(WRAPS, 4),
        end_tension_N=20.0)  # fmt: skip
    y = LAWS["thickness"].log_lift([0.25], at) - math.log(20.0) + 0.005 * rng.standard_normal(24)
    std_m = np.where(wheels < 0.03, 2e-4, 0.0)
    fit = fit_law(table(y, wraps=np.tile(WRAPS, 4), wheel_m=wheels, wheel_radius_std_m=std_m), "thickness")
    # Truth larger than written by 1 σ: what is written is smaller than what was pulled over.
    larger = table(y, wraps=np.tile(WRAPS, 4), wheel_m=wheels + std_m, wheel_radius_std_m=std_m)
    other = fit_law(larger, "thickness")
    (common,) = fit.common_errors
    assert common.name == "radius of the wheels of 20 mm"
    assert abs(common.change[0]) == pytest.approx(abs(other["mu"].value - fit["mu"].value), rel=0.05)


def test_cells_and_ropes_are_known_by_name_and_survive_the_file():
    y = 0.2 * np.repeat(WRAPS, 2) + 0.01 * np.sin(np.arange(12.0))
    peak_N = 20 * np.exp(y)
    trials = table(y, 2, peak_std_N=0.02 * peak_N, cell_std_N=0.01 * peak_N,
        labels={"cell": ("K1",) * 6 + ("K2",) * 6, "rope_id": ("red",) * 12}, rope_radius_std_m=1e-4,
        wrap_std_rad=0.05, end_tension_std_N=0.1)  # fmt: skip
    fit = fit_law(trials, "thickness")
    assert [item.name for item in fit.common_errors] == [
        "calibration of cell K1",
        "calibration of cell K2",
        "weights of 20 N",
        "radius of the rope red",
    ]  # each wrap is one condition: what it was set wrong by is scatter between conditions
    assert [item.std for item in fit.common_errors] == pytest.approx([0.01, 0.01, 0.005, 1e-4])
    again = FitResult.from_dict(fit.to_dict())
    assert again.common_errors == fit.common_errors
    assert predict(again, wheel()).to_dict() == predict(fit, wheel()).to_dict()


def test_the_budget_of_a_lift_force_names_what_is_in_common():
    y = 0.2 * np.repeat(WRAPS, 2) + 0.01 * np.sin(np.arange(12.0))
    fit = fit_law(table(y, 2, peak_std_N=0.01 * 20 * np.exp(y), labels={"cell": ("K1",) * 12}), "constant")
    found = state_lift(fit, wheel(), {})
    lines = {line.name: line for line in found.budget.lines}
    expected = found.budget.estimate * 5.0 * fit.common_errors[0].change[0]
    assert lines["calibration of cell K1"].contribution == pytest.approx(expected, rel=1e-6)
    prediction = predict(fit, wheel())
    assert found.budget.combined == pytest.approx(prediction.std_N[0], rel=1e-4)
    assert found.drawn.agrees
    assert prediction.dof[0] > fit.statistics.interval_dof


# --- nothing left to estimate from ----------------------------------------------------------------------------------


@pytest.mark.parametrize("law", ["constant", "coupled", "wrap-power"])
def test_exact_data_give_no_interval(law):
    y = 0.2 * np.tile(WRAPS, 6)
    wheels_m, loads_N = np.repeat([0.02, 0.04, 0.08], 12), np.tile(np.repeat([5.0, 50.0], 6), 3)
    trials = table(y, wraps=np.tile(WRAPS, 6), wheel_m=wheels_m, end_N=loads_N)
    found = predict(fit_law(trials, law), wheel())
    assert (found.lift_force_N[0], found.dof[0]) == (pytest.approx(20 * math.exp(1.0), rel=1e-6), 0.0)
    assert np.isnan([*found.interval_N[0], *found.prediction_interval_N[0], found.std_N[0]]).all()


def test_too_few_trials_or_one_wheel_give_no_interval():
    found = predict(fit_law(table([0.6, 1.2], wraps=[3.0, 6.0]), "wrap-power"), wheel())
    assert np.isnan([*found.interval_N[0], *found.prediction_interval_N[0]]).all()
    y = 0.2 * np.repeat(WRAPS, 3) + 0.02 * np.random.default_rng(1).standard_normal(18)
    fit = fit_law(table(y, 3), "size-exponential")
    assert fit.status.value == "unidentifiable"
    assert np.isnan(predict(fit, wheel(radius_m=0.06)).interval_N).all()


def test_without_repeats_a_new_rope_scatters_like_the_conditions():
    rng = np.random.default_rng(6)
    wraps = np.linspace(2.0, 12.0, 20)
    fit = fit_law(table(0.2 * wraps + 0.03 * rng.standard_normal(20), wraps=wraps), "constant")
    low, high = np.log(predict(fit, wheel()).prediction_interval_N[0])
    t, s = stats.t.ppf(0.975, 19), fit.statistics.scatter_between
    assert s == pytest.approx(0.03, rel=0.5)
    assert high - low == pytest.approx(2 * t * math.hypot(s, 5.0 * fit["mu"].std), rel=1e-3)


# --- other intervals ------------------------------------------------------------------------------------------------


def test_bootstrap_t_is_students_interval_where_the_law_is_linear(bench_problem):
    problem = bench_problem(LAWS["constant"], [0.2], std=0.02, seed=3)
    phi, y = problem.conditions.wrap_angle_rad, problem.log_lift - problem.conditions.log_end_tension
    mu = phi @ y / (phi @ phi)
    half = stats.t.ppf(0.975, 63) * math.sqrt(((y - mu * phi) ** 2).sum() / 63 / (phi @ phi))
    ends = bootstrap_t(problem, [mu], at=wheel(), n=4000)
    np.testing.assert_allclose(ends[0], [mu - half, mu + half], atol=0.12 * half)
    np.testing.assert_allclose(ends[1] - math.log(20), 5.0 * ends[0], rtol=1e-9)


def test_auto_takes_the_profile_only_where_the_chi_square_is_no_parabola():
    at = Conditions(wheel_radius_m=0.03, rope_radius_m=0.005,
        wrap_angle_rad=np.tile([1.6, 3.1, 6.3, 12.6], 2),
        end_tension_N=np.repeat([10.0, 40.0], 4))  # fmt: skip
    rise = LAWS["wrap-power"].log_lift([0.25, -0.4, 0.1], at) - at.log_end_tension
    y = np.repeat(rise, 5) + 0.02 * np.random.default_rng(0).standard_normal(40)
    trials = table(y, 5, wraps=at.wrap_angle_rad, end_N=np.repeat(at.end_tension_N, 5))
    straight, bent = fit_law(trials, "constant"), fit_law(trials, "wrap-power")
    assert is_straight(straight)
    assert with_intervals(straight, "auto") is straight
    assert not is_straight(bent)
    assert with_intervals(bent, "auto").parameters == with_intervals(bent, "profile").parameters
