"""Designs: round trips through the prediction, closed forms, reachability, and charts."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import optimize, stats

from ropefric.errors import InputError
from ropefric.fitting.design import DesignStatus, design, design_chart, first_crossing, rising_root
from ropefric.fitting.fit import fit_law
from ropefric.fitting.predict import predict
from ropefric.friction.condition import Conditions

FIXED = {"rope_radius_m": 0.005, "wheel_radius_m": 0.04, "wrap_angle_rad": 10.0, "end_tension_N": 20.0}
TARGET = {"wrap": "wrap_angle_rad", "radius": "wheel_radius_m", "end_tension": "end_tension_N"}


def find(fit, solve_for, lift_N, **options):
    given_ = {name: value for name, value in FIXED.items() if name != TARGET[solve_for]}
    return design(fit, lift_N=lift_N, solve_for=solve_for, **(given_ | options))


@pytest.mark.parametrize("solve_for", TARGET)
@pytest.mark.parametrize("fixture", ["constant_fit", "wrap_fit", "coupled_fit"])
def test_round_trip(request, fixture, solve_for):
    """What was predicted for x is designed back to x, the smallest that does, by the mean and by the one-sided bound."""
    fit = request.getfixturevalue(fixture)
    if solve_for == "radius" and fixture != "coupled_fit":
        with pytest.raises(InputError, match="does not depend on the wheel radius"):
            find(fit, solve_for, 50.0)
        return
    x = np.linspace(*{"wrap": (2, 20), "radius": (0.012, 0.06), "end_tension": (2, 90)}[solve_for], 3)
    at = Conditions(**{name: np.array(value) for name, value in (FIXED | {TARGET[solve_for]: x}).items()})
    truth = predict(fit, at, level=0.9)
    mean = find(fit, solve_for, truth.lift_force_N, probability=None)
    np.testing.assert_allclose(mean.value, x, rtol=1e-9)
    # The lower end of a two-sided 90 % interval is exceeded with 95 %.
    safe = find(fit, solve_for, truth.prediction_interval_N[:, 0], probability=0.95)
    np.testing.assert_allclose(safe.value, x, rtol=1e-6)
    np.testing.assert_allclose(safe.lower_bound_N, safe.required_N, rtol=1e-6)


def test_constant_law_on_paper(constant_fit):
    """φ μ − t √((φ s)² + σ²) = ln(L/F_B) is a quadratic in φ, with t of the effective degrees of freedom at the end."""
    mu, s = constant_fit["mu"].value, constant_fit["mu"].std
    sigma = math.sqrt(np.maximum(constant_fit.scatter.variance, 0.0).sum())
    found, y, paper = constant_fit.statistics, math.log(300 / 20), math.log(300 / 20) / mu
    pulls2 = found.scatter_within**2 * (1 - found.n_conditions / found.n)
    for _ in range(30):
        all2 = (paper * s) ** 2 + sigma**2
        squares = (all2 - pulls2) ** 2 / found.interval_dof + pulls2**2 / (found.n - found.n_conditions)
        dof = all2**2 / squares
        t = stats.t.ppf(0.99, dof)
        a, b, c = mu**2 - (t * s) ** 2, -2 * mu * y, y**2 - (t * sigma) ** 2
        paper = (-b + math.sqrt(b * b - 4 * a * c)) / (2 * a)
    assert find(constant_fit, "wrap", 300.0, probability=0.99).value[0] == pytest.approx(paper, rel=1e-6)
    assert find(constant_fit, "wrap", 300.0, probability=None).value[0] == pytest.approx(y / mu, rel=1e-12)


def test_heavier_and_surer_needs_more_wrap(wrap_fit):
    loads = [25.0, 1000.0]
    needed = [find(wrap_fit, "wrap", loads, probability=p).value for p in (None, 0.5, 0.999)]
    assert (np.diff(needed, axis=1) > 0).all()
    assert (np.diff(needed, axis=0) >= -1e-9 * needed[0]).all()


def test_what_cannot_be_reached_is_said_with_its_limit(coupled_fit):
    found = find(coupled_fit, "radius", [40.0, 1e6], probability=None)
    assert found.status.tolist() == [DesignStatus.OK, DesignStatus.OUT_OF_REACH]
    assert math.isnan(found.value[1])
    assert "even wheel_radius_m = 10 m lifts" in found.explain(1)
    vast = Conditions(wheel_radius_m=10.0, rope_radius_m=0.005, wrap_angle_rad=10.0, end_tension_N=20.0)
    assert found.limit_lift_N[1] == pytest.approx(predict(coupled_fit, vast).lift_force_N[0])
    json.dumps(found.to_dict(), allow_nan=False)


def test_saturating_law_is_out_of_reach(constant_fit):
    """μ = a e^{bφ} with c = 0 lifts no more than F_B e^{a/|b| − y}, whatever the wrap."""
    first = constant_fit.parameters[0]
    values = tuple(replace(first, name=k, value=v) for k, v in {"a": 0.5, "b": -0.1, "c": 0.0}.items())
    fit = replace(constant_fit, law="wrap-exponential", parameters=values, covariance=np.zeros((3, 3)))
    found = find(fit, "wrap", [100.0, 200.0], probability=None)
    assert found.status.tolist() == [DesignStatus.OK, DesignStatus.OUT_OF_REACH]
    assert found.limit_lift_N[1] == pytest.approx(math.exp(5.0), rel=1e-4)


def test_load_below_the_end_tension_needs_no_wrap(wrap_fit):
    found = find(wrap_fit, "wrap", 10.0)
    assert (found.status[0], found.value[0]) == (DesignStatus.LOWER_LIMIT, 0.0)
    assert "already lifts" in found.explain()


def test_too_uncertain_is_told_from_out_of_reach(constant_fit):
    vague = replace(constant_fit, covariance=np.array([[0.2**2]]))
    found = find(vague, "wrap", 1000.0)
    assert found.status[0] == DesignStatus.TOO_UNCERTAIN
    assert "measure nearer" in found.explain()
    assert find(vague, "wrap", 1000.0, probability=None).reached[0]


def test_bending_and_low_limits(campaign):
    """A law that refuses a low end tension is searched above it, not into an exception."""
    plan = {"radii": (0.02, 0.04), "wraps_deg": (180, 360, 540), "repeats": 2, "within": 0.002}
    fit = fit_law(campaign("bending", [0.2, 1e-3], **plan), "bending")
    found = find(fit, "end_tension", 60.0, probability=None)
    assert found.lift_force_N[0] == pytest.approx(60.0, rel=1e-9)
    assert find(fit, "radius", 60.0, probability=None, end_tension_N=10.0).status[0] in set(DesignStatus)


def test_extrapolated_designs_are_flagged(wrap_fit):
    found = find(wrap_fit, "wrap", [40.0, 1e4], wheel_radius_m=0.03, probability=None)
    assert found.extrapolated.tolist() == [False, True]


def test_many_designs_at_once_equal_one_by_one(constant_fit, wrap_fit):
    """Of a curved law as near as its profile is found, and beyond 100 designs by the linear interval."""
    for fit, n, rtol in ((constant_fit, 101, 1e-11), (wrap_fit, 3, 1e-6), (wrap_fit, 101, 1e-3)):
        loads = np.geomspace(25, 1000, n)
        found = find(fit, "wrap", loads)
        assert find(fit, "wrap", loads[n // 2]).value[0] == pytest.approx(found.value[n // 2], rel=rtol)
        assert (np.diff(found.value) > 0).all()


def test_bad_arguments(wrap_fit):
    usual = {"lift_N": 100.0, "rope_radius_m": 0.005, "wheel_radius_m": 0.04, "end_tension_N": 20.0}
    for change, message in (({"wrap_angle_rad": 3.0}, "given and looked for"),
            ({"end_tension_N": None}, "end_tension_N is missing"), ({"lift_N": -5.0}, r"lift_N\[0\] is -5 N"),
            ({"lift_N": [5.0, math.nan]}, r"lift_N\[1\] is nan N"), ({"lift_N": "heavy"}, "not a number"),
            ({"probability": 0.3}, "probability is 0.3"), ({"probability": 1.0}, "probability is 1"),
            ({"end_tension_N": -1.0}, "end_tension_N"),
            ({"lift_N": [50.0, 60.0, 70.0], "end_tension_N": [1.0, 2.0]}, "disagree in length"),
            ({"solve_for": "luck"}, "cannot solve for")):  # fmt: skip
        with pytest.raises(InputError, match=message):
            design(wrap_fit, **(usual | change))


def test_chart_is_the_prediction_on_a_grid(coupled_fit):
    radii, wraps = [0.02, 0.05, 0.2], [3.0, 9.0]
    chart = design_chart(coupled_fit, radii, wraps, 20.0, rope_radius_m=0.005)
    assert chart.lift_force_N.shape == (3, 2)
    at = Conditions(wheel_radius_m=0.05, rope_radius_m=0.005, wrap_angle_rad=9.0, end_tension_N=20.0)
    one = predict(coupled_fit, at, level=0.9)
    assert chart.lift_force_N[1, 1] == pytest.approx(one.lift_force_N[0])
    assert chart.lower_bound_N[1, 1] == pytest.approx(one.prediction_interval_N[0, 0])
    assert chart.extrapolated.tolist() == [[False, False], [False, False], [True, True]]


def test_rising_root_against_brentq():
    rng = np.random.default_rng(0)
    a, power = rng.uniform(0.1, 50, 200), rng.choice([0.2, 1, 3, 9], 200)
    low, high = np.full(200, 1e-6), np.full(200, 1e3)
    a = np.minimum(a, high**power * 0.9)

    def function(x, i):
        return x ** power[i] - a[i]

    found = rising_root(function, low, high)
    for i in range(200):
        direct = optimize.brentq(lambda x, i=i: x ** power[i] - a[i], 1e-6, 1e3, xtol=1e-14, rtol=1e-14)
        assert found[i] == pytest.approx(direct, rel=1e-10, abs=1e-12)


def test_rising_root_survives_a_stretch_without_an_answer():
    def function(x, rows):
        return np.where(x < 2, -np.inf, x - 3.0)

    assert rising_root(function, np.zeros(1), np.full(1, 100.0))[0] == pytest.approx(3.0, abs=1e-10)


def test_first_crossing_of_a_curve_that_falls_again():
    left, right = first_crossing(lambda x, i: 0.2 - (x - 1) ** 2, np.zeros(1), np.full(1, 10.0))
    assert left[0] < 1 - math.sqrt(0.2) <= right[0]
    assert np.isnan(first_crossing(lambda x, i: -1 - x, np.zeros(1), np.ones(1))[1]).all()
