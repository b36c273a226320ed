"""Doubtful fits say so, name the parameter that cannot be seen and the experiment that would show it.

Also the reference numbers of the model paper's analysis: ratios of singular values and standard errors.
"""

import dataclasses
from math import inf, isnan

import numpy as np
import pytest
from pulled import grid, table_at

from ropefric.fitting import fit as fitting
from ropefric.fitting.fit import fit_law
from ropefric.fitting.problem import FitProblem, batched_fit
from ropefric.fitting.result import FitStatus
from ropefric.fitting.statistics import find_trends, identify
from ropefric.friction.condition import Conditions
from ropefric.friction.laws import ALL_LAWS, LAWS

TWELVE_WRAPS = np.linspace(np.pi / 2, 4 * np.pi, 12)


def pulled(law, theta, *, radii=(0.04,), wraps=(6.0,), loads=(20.0,), repeats=3, within=0.01, seed=0):
    at = grid(radii, wraps, loads, repeats)
    noise = within * np.random.default_rng(seed).normal(size=len(at))
    return table_at(at, LAWS[law].log_lift(theta, at) + noise)


def ratio(law, theta, *, size_ratios=(8.0,), wraps=(6.0,), loads=(20.0,)):
    at, chosen = grid(0.005 * np.asarray(size_ratios), wraps, loads), ALL_LAWS[law]
    return identify(chosen.jacobian(theta, at), chosen.parameter_names)


# ---- reference numbers; the designs are eight wheels (and eight wraps) evenly over the range printed ----


RATIOS = [
    *(("size-exponential", theta, span, (6.0,), 13, 3) for span in ((3, 15), (8, 40))
      for theta in ((0.2, -0.2, -0.3), (0.46, -0.22, -0.3), (0.2, -0.2, 0.0))),
    *(("size-power", (0.2, 1.0, 0.02), *more) for more in (((3, 15), (6.0,), 985, 0.5), ((8, 40), (6.0,), 5900, 50))),
    # It grows as the exponent vanishes.
    *(("coupled", (0.2, -0.2, -0.1, c, 0.05), (3, 15), np.linspace(np.pi / 2, 4 * np.pi, 8), printed, 0.035 * printed)
      for c, printed in ((-0.4, 750), (-0.1, 2.4e3), (-0.02, 1.2e4))),
]  # fmt: skip


def test_ratios_of_singular_values_are_those_printed():
    for law, theta, span, wraps, printed, tolerance in RATIOS:
        seen = ratio(law, theta, size_ratios=np.linspace(*span, 8), wraps=wraps)
        assert seen.ratio == pytest.approx(printed, abs=tolerance), law
        assert law != "size-power" or set(seen.weak) == {"mu_inf", "b"}, (
            "mu_inf + b is seen, not which of the two"
        )


@pytest.mark.parametrize(("loads", "printed", "tolerance"),
    [([20.0], (0.75, 3.7, 2.0), (0.005, 0.05, 0.05)),
    (np.geomspace(1.5, 200, 6), (0.004, 0.011, 0.009), (0.0005, 0.0005, 0.0005))])  # fmt: skip
def test_standard_errors_of_a_wrap_series_at_one_load_and_at_six(loads, printed, tolerance):
    """0.75, 3.7, 2.0 at one load; 0.004, 0.011, 0.009 at six, at a = 0.2, b = -0.5, c = 0.1 and sd 0.005."""
    phi, F = (axis.ravel() for axis in np.meshgrid(TWELVE_WRAPS, loads))
    pulls = Conditions(wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=phi, end_tension_N=F)
    theta = np.array([0.2, -0.5, 0.1])
    J = LAWS["wrap-power"].jacobian(theta, pulls) / 0.005
    relative = np.sqrt(np.diag(np.linalg.inv(J.T @ J))) / np.abs(theta)
    for value, shown, margin in zip(relative, printed, tolerance, strict=True):
        assert value == pytest.approx(shown, abs=margin)


def test_wrap_series_at_one_load_is_refused_and_at_six_is_not():
    theta = [0.2, -0.5, 0.1]
    one = fit_law(pulled("wrap-power", theta, wraps=TWELVE_WRAPS, within=0.005), "wrap-power")
    assert not one.trustworthy
    assert one.status in {FitStatus.UNIDENTIFIABLE, FitStatus.AT_BOUND}
    six = fit_law(pulled("wrap-power", theta, wraps=TWELVE_WRAPS, loads=np.geomspace(1.5, 200, 6), within=0.005),
                  "wrap-power")  # fmt: skip
    assert six.status == "ok", six.advice


# ---- designs that cannot show a parameter ----


def test_one_radius_does_not_show_the_size_effect():
    fit = fit_law(pulled("constant", [0.2], wraps=(3, 6, 9)), "size-exponential")
    assert (fit.status, fit["a"].std, fit.identifiability.ratio) == ("unidentifiable", inf, inf)
    assert "The data do not show mu_inf, a and b" in fit.advice[0]
    assert "only one size ratio (R_w/R_r = 8)" in fit.advice[0]
    assert fit["a"].ci95 == (fit["a"].lower, fit["a"].upper)


def test_one_wrap_does_not_show_an_offset():
    fit = fit_law(pulled("constant", [0.2], radii=(0.02, 0.04, 0.08), loads=(5, 20, 80)), "constant-offset")
    assert fit.status == "unidentifiable"
    assert all(one in fit.advice[0] for one in ("mu and k", "only one wrap angle (343.8 deg)"))
    assert fit.identifiability.weak_direction in {"mu up while k down", "k up while mu down"}


def test_two_points_never_fail_and_never_pass_for_more_than_they_are():
    table = pulled("constant", [0.2], wraps=(3.0, 6.0), repeats=1)
    for law in LAWS:
        fit = fit_law(table, law)
        few = sum(item.vary for item in fit.parameters) > 2
        assert not few or fit.status == "too-few-points", law
        assert fit.to_dict()["status"] == str(fit.status)


def test_one_condition_judges_no_law():
    table = pulled("constant", [0.2], repeats=20)
    for law in ALL_LAWS:
        fit = fit_law(table, law)
        n_free = sum(item.vary for item in fit.parameters)
        assert (fit.status == "ok") == (n_free == 1), law
        assert n_free == 1 or f"1 condition cannot determine the {n_free} parameters of {law}" in " ".join(
            fit.advice
        )
        assert fit.verdict.word == "not judged"


def test_parameter_at_its_bound_is_no_result():
    table = pulled("constant", [0.2], radii=(0.02, 0.04, 0.08), wraps=(3, 6, 9, 12), loads=(5, 20, 80))
    rising = dataclasses.replace(table, peak_N=table.peak_N * (table.end_tension_N / 20) ** 0.02)
    fit = fit_law(rising, "howell")
    assert fit["n"].at_bound
    assert fit["n"].value == fit["n"].upper == 1.0
    assert isnan(fit["n"].std)
    assert not fit.trustworthy
    assert any("n of howell lies on its bound 1, which is not a measurement of it" in text
        for text in fit.advice)  # fmt: skip
    assert fit["A"].std > 0
    narrow = fit_law(table, "constant", bounds={"mu": (0.0, 0.11)})
    assert (narrow["mu"].value, narrow["mu"].at_bound, str(narrow.status)) == (0.11, True, "at-bound")


def test_an_effect_that_is_not_there_cannot_be_seen():
    """Without a wrap effect a φ^b and c are one, and the search ends in a valley."""
    table = pulled("constant", [0.2], radii=(0.02, 0.04, 0.08), wraps=(3, 6, 9, 12), loads=(5, 20, 80))
    fit = fit_law(table, "wrap-power")
    assert fit.status in {"unidentifiable", "at-bound"}
    assert fit.statistics.chi2 <= fit_law(table, "constant").statistics.chi2 * (1 + 1e-6)


def test_trends_are_not_found_where_there_are_none():
    """Conditions that scatter by themselves show a trend with p < 0.001 in about three of a thousand tests."""
    rng = np.random.default_rng(0)
    r, phi, F = (axis.ravel() for axis in np.meshgrid([3, 6, 12.0], [3, 6, 9.0, 12], [5, 20, 80.0]))
    at = Conditions(wheel_radius_m=0.005 * r, rope_radius_m=0.005, wrap_angle_rad=phi, end_tension_N=F)
    found = []
    for _ in range(400):
        means = FitProblem.plain(LAWS["constant"], at, 0.05 * rng.normal(size=36), 0.05)
        J = means.jacobian(np.array([0.2]))
        left = means.log_lift / 0.05
        left = left - J[:, 0] * (J[:, 0] @ left) / (J[:, 0] @ J[:, 0])
        found += [trend.p_value for trend in find_trends(means, J, left)]
    assert (len(found), np.mean(np.array(found) < 0.05)) == (1600, pytest.approx(0.05, abs=0.02))
    assert np.mean(np.array(found) < 1e-3) < 0.006


def test_load_effect_from_a_measured_slack_side_is_refused():
    """With F_A one known weight, a law that makes F_A independent of F_B fits anything."""
    rng = np.random.default_rng(3)
    phi = np.repeat([1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 3)
    slack = 8.0 * np.exp(-0.18 * phi + 0.03 * rng.normal(size=18))
    at = Conditions(wheel_radius_m=0.03, rope_radius_m=0.002, wrap_angle_rad=phi, end_tension_N=slack)
    table = table_at(at, np.full(18, np.log(8.0)))
    assert table.measures_slack
    fit = fit_law(table, "constant")
    assert (fit.status, fit["mu"].value) == ("ok", pytest.approx(0.18, abs=4 * fit["mu"].std))
    wrong = fit_law(table, "wrap-power")
    assert not wrong.trustworthy
    assert any("would agree with any such data" in text for text in wrong.advice)


def test_extreme_scatter():
    fit = fit_law(pulled("constant", [0.3], wraps=(6, 9, 12), repeats=8, within=0.5), "constant")
    assert fit.status == "extreme-scatter"
    assert "Repeats scatter by" in fit.advice[0]


def test_search_that_stops_early_is_not_a_success(monkeypatch):
    monkeypatch.setattr(fitting, "batched_fit", lambda problem,
        **more: batched_fit(problem, **(more | {"max_iterations": 1})))  # fmt: skip
    table = pulled("wrap-power", [0.2, -0.5, 0.1], wraps=TWELVE_WRAPS, loads=(2, 20, 200))
    fit = fit_law(table, "wrap-power", start={"a": 3.0, "b": -0.9, "c": 0.5}, n_starts=1)
    assert fit.status == "not-converged"
    assert "did not reach a minimum" in fit.advice[0]
    assert not fit.trustworthy


def test_identifiability_by_hand():
    seen = identify(np.array([[1.0, 0.0], [0.0, 2.0]]), ["a", "b"])
    assert seen.ratio == pytest.approx(1.0)
    same = identify(np.array([[1.0, 1.0, 0.0], [2.0, 2.0, 1.0], [1.0, 1.0, 3.0]]), ["a", "b", "c"])
    assert (same.ratio, same.unseen, identify(np.zeros((3, 1)), ["a"]).unseen) == (inf, ("a", "b"), ("a",))
    assert identify(np.ones((1, 2)), ["a", "b"]).unseen == ("a", "b")
    assert identify(np.zeros((3, 0)), []).ratio == 1.0


def test_a_trend_of_mu_is_found_though_wraps_differ():
    """μ falls by a fifth from the smallest wheel to the largest, which no law of size allows; 12 conditions of 3."""
    k, rng = np.arange(12), np.random.default_rng(4)
    wrap, radius = np.pi * np.array([0.5, 1, 2, 4])[k % 4], np.array([0.015, 0.02, 0.03, 0.04, 0.06])[k % 5]
    mu = 0.2 * (radius / 0.015) ** (np.log(0.8) / np.log(4.0))
    group, load = np.repeat(k, 3), np.array([10.0, 40.0, 120.0])[k // 4]
    log_lift = np.log(load) + mu * wrap + 0.02 * rng.normal(size=12)
    at = Conditions(wheel_radius_m=radius, rope_radius_m=0.0049, wrap_angle_rad=wrap, end_tension_N=load)
    fit = fit_law(table_at(at.select(group), log_lift[group] + 0.02 * rng.normal(size=36)), "constant")
    assert fit.status == "residual-structure"
    assert "depend on the size ratio" in fit.advice[0]
