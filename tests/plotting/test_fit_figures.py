"""Figures of fits: their tables are what the laws and the trials say, worked out here a second time."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.stats import norm

from ropefric.errors import InputError
from ropefric.fitting.fit import fit_law
from ropefric.fitting.predict import predict
from ropefric.friction.condition import Conditions
from ropefric.plotting.fits import (
    FACETS,
    condition_points,
    draw_capstan,
    draw_fit_band,
    draw_mu_facets,
    draw_residuals,
)
from ropefric.trials.table import TrialTable

STAR = {"wheel_radius_m": 0.04, "rope_radius_m": 0.005, "wrap_angle_rad": 6.0, "end_tension_N": 20.0}


def by_condition(pulls):
    """Mean and count of ln(F_A/F_B) of each condition, straight from the table."""
    rise = np.log(pulls.peak_N / pulls.end_tension_N)
    keys = list(zip(pulls.wheel_radius_m, pulls.wrap_angle_rad, pulls.end_tension_N, strict=True))
    return {tuple(map(float, key)): rise[[other == key for other in keys]] for key in dict.fromkeys(keys)}


def styles(axes):
    return {line.get_linestyle() for line in axes.lines if line.get_linestyle() not in {"None", ""}}


def table_of(wraps_rad, loads_N, peaks_N):
    names = tuple(f"t{i}" for i in range(len(peaks_N)))
    common = {"wheel_radius_m": 0.04, "rope_radius_m": 0.005}
    return TrialTable(trial=names, wrap_angle_rad=wraps_rad, end_tension_N=loads_N, peak_N=peaks_N, **common)


def test_facets_show_the_average_coefficient_of_each_condition(pulls, fitted, told, assert_readable):
    made = told(draw_mu_facets(list(fitted.values())))
    assert_readable(made)
    known = by_condition(pulls)
    assert len(made.tables[0].rows) == len(known) == 7
    within = fitted["constant"].statistics.scatter_within
    for wheel_m, rope_m, wrap_rad, end_N, n, mu, std in made.tables[0].rows:
        rises = next(v for k, v in known.items() if k == pytest.approx((wheel_m, wrap_rad, end_N)))
        assert ((rope_m, n), mu) == ((pytest.approx(0.005), 4), pytest.approx(rises.mean() / wrap_rad))
        # The scatter of four pulls over two, and 0.2 % of the instrument which every pull shares.
        assert std == pytest.approx(math.hypot(within / 2.0, 0.002) / wrap_rad, rel=1e-3)
    axes = made.figure.axes
    assert [one.get_xlabel()[-4:] for one in axes] == [" [N]", "deg]", "[mm]"]
    assert (axes[0].get_ylabel(), axes[0].get_xscale()) == ("Friction coefficient μ̄ [-]", "log")
    assert all(words in made.figure.get_suptitle() for words in ("28 trials, 7 conditions", "k = 2"))
    # Each law in its own line style, at the common settings.
    for one, over in zip(axes, FACETS, strict=True):
        assert (len(styles(one)), sum(row[0] == over for row in made.tables[1].rows)) == (2, 2 * 61)
    for over, law, x, mu in made.tables[1].rows[::30]:
        fit = fitted[law]
        assert mu == pytest.approx(
            float(fit.friction_law.average_mu(fit.theta, Conditions(**STAR | {over: x}))[0])
        )
    # Error bars are two standard uncertainties.
    bars = next(c for c in axes[1].containers if c.get_label().startswith("conditions"))
    (segments,) = [c.get_segments() for c in bars[2]]
    shown = [r for r in made.tables[0].rows if (r[0], r[3]) == (pytest.approx(0.04), pytest.approx(20.0))]
    ends = [(r[5] - 2 * r[6], r[5] + 2 * r[6]) for r in shown]
    np.testing.assert_allclose([(s[0, 1], s[1, 1]) for s in segments], ends)


def test_capstan_plot_has_eulers_line_through_the_origin(pulls, fitted, told, assert_readable):
    made = told(draw_capstan([fitted["wrap-power"]]))
    assert_readable(made)
    known = by_condition(pulls)
    wrap, rise = np.array([k[1] for k in known]), np.array([v.mean() for v in known.values()])
    np.testing.assert_allclose(sorted(row[5] for row in made.tables[0].rows), np.sort(rise))
    slope = float(np.linalg.lstsq(wrap[:, None], rise, rcond=None)[0][0])
    line = [row for row in made.tables[1].rows if row[0] == "straight line"]
    np.testing.assert_allclose([row[2] for row in line], [slope * row[1] for row in line])
    assert f"{slope:.4g}" in made.alt
    axes = made.figure.axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()[-3:]) == ("Wrap angle φ [deg]", "[-]")
    assert len({bars[0].get_marker() for bars in axes.containers}) == 3  # a wheel each
    assert len(styles(axes)) == 2
    # The constant law is that line, where it is there.
    both = draw_capstan(list(fitted.values())).tables[1].rows
    line = np.array([row[1:] for row in both if row[0] == "straight line"])
    np.testing.assert_allclose(line[:, 1], fitted["constant"]["mu"].value * line[:, 0])
    assert {row[0] for row in both} == {"straight line", "wrap-power"}


def test_bands_are_those_of_the_prediction(fitted, assert_readable):
    fit = fitted["wrap-power"]
    for over in STAR:
        made = draw_fit_band(fit, over=over)
        table = np.array([row[:6] for row in made.tables[0].rows])
        found = predict(fit, Conditions(**STAR | {over: table[:, 0]}), level=0.95, method="linear")
        wanted = np.column_stack([found.lift_force_N, found.interval_N, found.prediction_interval_N])
        np.testing.assert_allclose(table[:, 1:], wanted)
        assert (table[:, 4] < table[:, 2]).all()
        assert (table[:, 3] < table[:, 5]).all()
        low, high = fit.validity[over]
        outside = [row[6] for row in made.tables[0].rows]
        np.testing.assert_array_equal(
            outside, (table[:, 0] < low * 0.999999) | (table[:, 0] > high * 1.000001)
        )
        assert [patch for patch in made.figure.axes[0].patches if patch.get_hatch()]
        assert "95 % confidence" in made.alt
    (axes,) = made.figure.axes
    assert axes.get_ylabel() == "Lift force $F_{\\mathrm{A}}$ [N]"
    assert_readable(draw_fit_band(fit, over="wrap_angle_rad"))


def test_the_trials_are_drawn_at_their_forces_and_the_means_with_two_standard_uncertainties(pulls, fitted):
    fit = fitted["constant"]
    made = draw_fit_band(fit)
    crosses = next(line for line in made.figure.axes[0].lines if line.get_marker() == "x")
    chosen = (pulls.wheel_radius_m == 0.04) & (pulls.end_tension_N == 20.0)
    np.testing.assert_allclose(crosses.get_ydata(), pulls.peak_N[chosen])
    bars = made.figure.axes[0].containers[0].lines[2][0].get_segments()
    rows = made.tables[1].rows
    wanted = [[row[1] * math.exp(side * 2.0 * row[3]) for side in (-1, 1)] for row in rows]
    np.testing.assert_allclose([bar[:, 1] for bar in bars], wanted)
    assert "12 trials shown of 28 fitted" in made.figure.axes[0].get_title()


def test_residuals_of_trials_are_measured_less_fitted(pulls, fitted, told, assert_readable, stored):
    fit = fitted["constant"]
    made = told(draw_residuals(fit))
    assert_readable(made)
    table = np.array(made.tables[0].rows)
    law = np.log(pulls.end_tension_N) + fit["mu"].value * pulls.wrap_angle_rad
    np.testing.assert_allclose(table[:, 1], np.exp(law))
    np.testing.assert_allclose(table[:, 2], np.log(pulls.peak_N) - law, atol=1e-12)
    np.testing.assert_allclose(table[:, 3], table[:, 2] / fit.problem.std, atol=1e-9)
    order = np.argsort(table[:, 3])
    np.testing.assert_allclose(table[order, 4], norm.ppf((np.arange(28) + 0.5) / 28))
    beyond = int((np.abs(table[:, 3]) > 2).sum())
    assert f"{beyond} of 28 beyond ±2" in made.figure.get_suptitle()
    assert len(made.figure.axes) == 3
    near, far = made.figure.axes[0].lines[-2:]
    assert (near.get_marker(), far.get_marker(), far.get_xdata().size) == ("o", "X", beyond)
    assert {float(line.get_ydata()[0]) for line in made.figure.axes[0].lines[:3]} == {0.0, -2.0, 2.0}
    # Those of a stored fit are those of its means.
    made = draw_residuals(stored(fit))
    points = condition_points(stored(fit))
    law = points.conditions.log_end_tension + fit["mu"].value * points.conditions.wrap_angle_rad
    np.testing.assert_allclose(
        [row[3] for row in made.tables[0].rows], (points.log_lift - law) / points.std_log
    )
    assert len(made.figure.axes) == 2
    assert "7 condition means" in made.alt


def test_one_pull_a_condition_and_no_known_uncertainty_is_drawn():
    lone = fit_law(table_of([3.0, 6.0], 20.0, [36.0, 66.0]), "constant")
    rows = draw_mu_facets([lone]).tables[0].rows
    assert [row[4] for row in rows] == [1, 1]
    assert all(math.isnan(row[6]) for row in rows)
    for drawing in (draw_fit_band, draw_residuals):
        assert "nan" not in drawing(lone).alt
    assert "2 conditions" in draw_capstan([lone]).alt


def test_a_fit_without_its_trials_says_so_and_none_at_all_is_refused(fitted):
    bare = dataclasses.replace(fitted["wrap-power"], trials={}, problem=None)
    for made in (draw_mu_facets([bare]), draw_capstan([bare]), draw_residuals(bare)):
        assert "no trials are stored" in made.alt
        assert made.tables[0].rows == ()
    assert draw_fit_band(bare).tables[1].rows == ()
    for drawing in (draw_mu_facets, draw_capstan):
        with pytest.raises(InputError, match="no fit"):
            drawing([])


@pytest.mark.parametrize("wrap_deg", [60.0, 90.0, 810.0])
def test_no_wrap_is_lost_from_a_figure_over_the_load(wrap_deg):
    """Settings were rounded to nine digits and then looked for more closely than that."""
    loads_N = np.repeat([5.0, 10.0, 50.0], 4) * 4.4482216152605
    peaks_N = loads_N * np.exp(0.1 * np.radians(wrap_deg) + np.tile(np.linspace(-0.02, 0.02, 4), 3))
    made = draw_fit_band(
        fit_law(table_of(np.radians(wrap_deg), loads_N, peaks_N), "constant"), over="end_tension_N"
    )
    assert "12 trials shown of 12 fitted" in made.figure.axes[0].get_title()
    assert len(made.tables[1].rows) == 3


def test_a_prediction_shows_the_measured_conditions_of_its_fit(fitted):
    fit = fitted["wrap-power"]
    axes = predict(fit, Conditions(**STAR | {"wrap_angle_rad": np.array([2.0, 5.0])})).plot()
    (points,) = (line for line in axes.lines if "measured" in str(line.get_label()))
    np.testing.assert_allclose(points.get_xdata(), np.degrees(fit.trials["wrap_angle_rad"]))
    np.testing.assert_allclose(points.get_ydata(), np.exp(fit.trials["mean_log_lift"]))
