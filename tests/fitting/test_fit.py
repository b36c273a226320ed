"""What a fit does with weights, bounds, fixed parameters and starts."""

import dataclasses
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pulled import grid, table_at

from ropefric.errors import InputError, UnknownNameError
from ropefric.fitting.fit import fit_law
from ropefric.friction.condition import Conditions
from ropefric.friction.laws import LAWS

BENCH = Path(__file__).parents[2] / "data" / "prth-bench" / "truth.toml"


def table_of(law, theta, *, radii=(0.02, 0.04, 0.08), wraps=(3.0, 6.0, 9.0), loads=(5, 50), repeats=3, within=0.01,
             seed=0, **more):  # fmt: skip
    at = grid(radii, wraps, loads, repeats)
    noise = within * np.random.default_rng(seed).normal(size=len(at))
    return table_at(at, LAWS[law].log_lift(theta, at) + noise, **more)


def test_constant_law_is_the_weighted_mean_by_hand():
    table = table_of("constant", [0.2])
    phi, rise = table.wrap_angle_rad, np.log(table.peak_N / table.end_tension_N)
    fit = fit_law(table, "constant")
    # Kept to 1e-4 of a standard error, and that to four digits.
    assert fit["mu"].value == pytest.approx(phi @ rise / (phi @ phi), rel=0, abs=1e-4 * fit["mu"].std)
    cells, wrap = rise.reshape(-1, 3), phi[::3]
    scatter = np.sqrt(((cells - cells.mean(axis=1, keepdims=True)) ** 2).sum() / (cells.size - len(cells)))
    assert fit.statistics.scatter_within == pytest.approx(scatter, rel=1e-9)
    rest = cells.mean(axis=1) - fit["mu"].value * wrap
    assert fit["mu"].std == pytest.approx(np.sqrt(rest @ rest / 17 / (wrap @ wrap)), rel=5e-4)
    assert (fit.covariance_kind, fit.covariance[0, 0]) == ("clustered", pytest.approx(fit["mu"].std ** 2))


def test_without_repeats_the_scatter_comes_from_the_residuals():
    table = table_of("constant", [0.2], repeats=1, loads=(20,))
    fit = fit_law(table, "constant")
    phi, rise = table.wrap_angle_rad, np.log(table.peak_N / table.end_tension_N)
    rest = rise - fit["mu"].value * phi
    assert fit["mu"].std == pytest.approx(np.sqrt(rest @ rest / 8 / (phi @ phi)), rel=5e-4)
    assert fit.covariance_kind == "scaled"
    assert "taken from the residuals" in fit.notes[0]


def test_both_criteria_count_each_parameter_and_the_scatter():
    at = grid([0.02, 0.04], [3.0, 6.0, 9.0], [20.0, 60.0])
    log_lift = np.log(at.end_tension_N) + 0.2 * at.wrap_angle_rad + 0.01 * np.sin(np.arange(len(at)))
    found, n, k = fit_law(table_at(at, log_lift), "constant").statistics, len(at), 2
    assert found.bic - found.aicc == pytest.approx(k * np.log(n) - 2 * k - 2 * k * (k + 1) / (n - k - 1))


def test_unused_trials_do_not_count():
    table = table_of("constant", [0.2])
    wild = np.where(np.arange(len(table)) % 5 == 0, 10 * table.peak_N, table.peak_N)
    kept = np.arange(len(table)) % 5 != 0
    spoiled = dataclasses.replace(table, peak_N=wild, kept=kept)
    fit = fit_law(spoiled, "constant")
    assert (fit.statistics.n, fit["mu"].value) == (kept.sum(), pytest.approx(0.2, abs=0.002))


def test_fixed_bounded_and_started():
    table = table_of("wrap-power", [0.2, -0.5, 0.1], wraps=(2, 5, 8, 12), loads=(2, 20, 200))
    held = fit_law(table, "wrap-power", fixed={"b": -0.5})
    assert (held["b"].value, held["b"].std, held["b"].ci95) == (-0.5, 0.0, (-0.5, -0.5))
    assert held["b"].vary is False
    assert not held.covariance[1].any()
    assert held["a"].std < fit_law(table, "wrap-power")["a"].std
    walled = fit_law(table, "wrap-power", bounds={"c": (0.15, 0.3)})
    assert walled["c"].value == 0.15
    assert walled["c"].at_bound
    groove = fit_law(table, "groove")
    assert [item.vary for item in groove.parameters] == [True, False]
    started = fit_law(table, "wrap-power", start={"a": 0.3, "c": 0.05}, n_starts=1)
    assert started.theta == pytest.approx(fit_law(table, "wrap-power").theta, rel=1e-5)


def test_settings_that_cannot_be_are_refused():
    table = table_of("constant", [0.2])
    for options, error, said in (({"fixed": {"nu": 1}}, UnknownNameError, "constant has no parameter 'nu'"),
            ({"bounds": {"mu": (1, 0)}}, InputError, "leave nothing between them"),
            ({"start": {"mu": -1}}, InputError, "start value mu = -1 lies outside its bounds 0 … 5"),
            ({"fixed": {"mu": 9}}, InputError, "fixed value mu = 9 lies outside"),
            *(({key: {"mu": odd}}, InputError, "mu is given as .*, not as a number")
                for key in ("fixed", "start") for odd in ("x", None, float("nan"), [0.1])),
            ({"bounds": {"mu": ("x", 1)}}, InputError, "not as .lower, upper"),
            ({"groups": ("rope",)}, UnknownNameError, "has no column 'rope'"),
            ({"shared": {"wraps": "rig"}}, UnknownNameError, "did you mean 'wrap'"),
            ({"shared": {"wrap": "lab"}}, UnknownNameError, "nothing called 'lab' shares an error"),
            ({"n_starts": 0}, InputError, "at least one")):  # fmt: skip
        with pytest.raises(error, match=said):
            fit_law(table, "constant", **options)
    with pytest.raises(UnknownNameError, match="did you mean 'wrap-power'"):
        fit_law(table, "wrap-powr")


@given(mu=st.floats(0.05, 0.6), scale=st.floats(0.1, 100), seed=st.integers(0, 99),
    within=st.floats(0.001, 0.1))  # fmt: skip
@settings(max_examples=8, deadline=None)
def test_constant_coefficient_does_not_depend_on_the_unit_of_force(mu, scale, seed, within):
    table = table_of("constant", [mu], within=within, seed=seed, loads=(20,))
    larger = dataclasses.replace(table, peak_N=table.peak_N * scale,
        end_tension_N=table.end_tension_N * scale)  # fmt: skip
    one, two = fit_law(table, "constant"), fit_law(larger, "constant")
    assert two["mu"].value == pytest.approx(one["mu"].value, rel=1e-6)
    assert two["mu"].std == pytest.approx(one["mu"].std, rel=1e-6)


def test_the_bench_is_determined_well_enough_to_be_trusted():
    truth = tomllib.loads(BENCH.read_text(encoding="utf-8"))
    keys = ("wheel_radius_m", "wrap_angle_rad", "end_tension_N")
    rows = np.array([[row[key] for key in keys] for row in truth["conditions"]]).repeat(12, axis=0)
    at = Conditions(rope_radius_m=truth["rope_radius_m"], **dict(zip(keys, rows.T, strict=True)))
    law, theta = LAWS["coupled"], LAWS["coupled"].theta_from(truth["parameters"])
    noise = truth["trial_scatter"] * np.random.default_rng(2).normal(size=len(at))
    fit = fit_law(table_at(at, law.log_lift(theta, at) + noise), "coupled")
    assert fit.status == "ok", fit.advice
    assert fit.trustworthy
    for item, true in zip(fit.parameters, theta, strict=True):
        assert abs(item.value - true) < 4 * item.std
        assert item.std < 0.1 * abs(true)
    assert fit.validity["end_tension_N"] == (5.0, 200.0)


def test_copies_of_a_trial_say_nothing_of_how_repeats_scatter():
    """Each force written down twice: the scatter is that about the law, not the zero between the copies."""
    wraps = np.linspace(2.0, 12.0, 8)
    log_lift = np.log(20.0) + 0.2 * wraps + 0.03 * np.sin(1.0 + 2.0 * np.arange(8))

    def fitted(copies):
        at = grid([0.04], np.tile(wraps, copies), [20.0])
        return fit_law(table_at(at, np.tile(log_lift, copies)), "constant")

    once, twice = fitted(1), fitted(2)
    assert twice.statistics.chi2_reduced == pytest.approx(once.statistics.chi2_reduced)
    assert twice.statistics.scatter_within == 0.0
    assert twice.statistics.scatter_between == pytest.approx(once.statistics.scatter_between, rel=1e-6)
    assert twice["mu"].value == pytest.approx(once["mu"].value, rel=1e-6)
    assert twice["mu"].std == pytest.approx(once["mu"].std, rel=1e-3)


def test_an_exponent_of_nothing_has_few_digits():
    """μ that grows with the wrap leaves a = 0, and b without effect: processors differ in where its search stops."""
    wrap_rad = np.repeat([1.0, 2.0, 4.0, 6.0, 9.0, 12.0], 2)
    mu = 0.15 + 0.002 * wrap_rad + 0.001 * np.tile([1.0, -1.0], 6)
    at = Conditions(wheel_radius_m=0.03, rope_radius_m=0.005, wrap_angle_rad=wrap_rad, end_tension_N=20.0)
    table = table_at(at, np.log(20.0) + mu * wrap_rad)
    a, b, _ = fit_law(table, "wrap-power").parameters
    assert a.at_bound
    assert b.value == float(f"{b.value:.4g}")
