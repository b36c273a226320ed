"""Fits with nothing to go on: identical conditions, no scatter, fewer trials than parameters, one wheel, one wrap.

What the data do show comes out exactly; what they do not show is named, with the experiment that would.
"""

import math

import numpy as np
import pytest
from hard_regime import Regime, once

from ropefric.files.plain_text import STD_DIGITS, significant, to_share
from ropefric.fitting.fit import fit_law
from ropefric.fitting.predict import predict
from ropefric.fitting.result import FitStatus
from ropefric.friction.condition import Conditions, one_condition
from ropefric.friction.laws import ALL_LAWS, LAWS
from ropefric.trials.table import TrialTable

REGIME = Regime(
    name="degenerate fits",
    statement="identical conditions, zero scatter, n < parameters, one radius, one wrap: what is determined, against "
    "exact sums and the known truth; what is not is named",
    accuracy=1e-8,
)
RADII = (0.02, 0.03, 0.05, 0.09)
WRAPS = (2.0, 5.0, 9.0, 14.0)
LOADS = (2.0, 10.0, 60.0)
TRUTH = {
    "constant": [0.2],
    "constant-offset": [0.2, 0.05],
    "size-exponential": [0.25, -0.3, -0.2],
    "wrap-exponential": [0.3, -0.5, 0.1],
    "wrap-power": [0.2, -0.5, 0.1],
    "coupled": [0.25, -0.3, -0.2, -0.5, 0.05],
    "thickness": [0.25],
    "howell": [0.5, 0.9],
}


def table(pulls, log_lift):
    return TrialTable(
        trial=tuple(f"t{i}" for i in range(len(pulls))),
        wheel_radius_m=pulls.wheel_radius_m,
        rope_radius_m=pulls.rope_radius_m,
        wrap_angle_rad=pulls.wrap_angle_rad,
        end_tension_N=pulls.end_tension_N,
        peak_N=np.exp(log_lift),
    )


def plan(radii=RADII, wraps=WRAPS, loads=LOADS, repeats=1):
    wheel, wrap, load, _ = np.meshgrid(radii, wraps, loads, np.arange(repeats), indexing="ij")
    return Conditions(
        wheel_radius_m=wheel.ravel(),
        rope_radius_m=0.005,
        wrap_angle_rad=wrap.ravel(),
        end_tension_N=load.ravel(),
    )


def identical(scatter=0.02, n=12):
    rng = np.random.default_rng(8)
    pulls = plan([0.04], [6.0], [20.0], n)
    return table(pulls, np.log(20.0) + 1.2 + scatter * rng.normal(size=n))


def sound(fit):
    for item in fit.parameters:
        assert math.isfinite(item.value)
        assert item.lower <= item.value <= item.upper
        assert item.at_bound or item.std >= 0.0
        assert item.at_bound or item.ci95[0] <= item.value <= item.ci95[1]
    assert np.isfinite(fit.covariance).all()
    assert fit.status is FitStatus.OK or fit.advice
    return fit


@once(REGIME)
def measured():
    worst = 0.0
    # One condition, twelve times: the mean and its standard error are sums that can be done exactly.
    trials = identical()
    fit = sound(fit_law(trials, "constant"))
    rises = np.log(trials.peak_N) - math.log(20.0)
    mean = math.fsum(rises) / 12
    std = math.sqrt(math.fsum((rises - mean) ** 2) / 11 / 12)
    # Of both the digits that a fit keeps.
    value, error = to_share(mean / 6.0, std / 6.0), significant(std / 6.0, STD_DIGITS)
    worst = max(worst, abs(fit["mu"].value / value - 1), abs(fit["mu"].std / error - 1))
    # No scatter: the truth itself.
    for name, theta in TRUTH.items():
        pulls = plan()
        fit = sound(fit_law(table(pulls, LAWS[name].log_lift(theta, pulls)), name))
        worst = max(worst, float(np.abs(fit.theta / np.array(theta) - 1).max()))
    return worst


def test_what_is_determined_comes_out():
    assert measured() <= REGIME.accuracy


@pytest.mark.parametrize(
    "name", [name for name in ALL_LAWS if name not in {"constant", "thickness", "groove"}]
)
def test_identical_conditions_show_one_parameter_only(name):
    fit = sound(fit_law(identical(), name))
    assert fit.status is FitStatus.TOO_FEW_POINTS
    assert not fit.trustworthy
    assert "1 condition" in " ".join(fit.advice)


@pytest.mark.parametrize("name", TRUTH)
def test_no_scatter_is_no_failure(name):
    pulls = plan()
    fit = sound(fit_law(table(pulls, LAWS[name].log_lift(TRUTH[name], pulls)), name))
    assert fit.status in {FitStatus.OK, FitStatus.UNIDENTIFIABLE}
    assert all(item.std < 1e-6 for item in fit.parameters)
    found = predict(fit, one_condition(0.04, 0.005, 7.0, 30.0))
    assert found.lift_force_N[0] > 0.0
    # Nothing scatters, so that nothing says how far off the law may be.
    assert np.isnan(found.interval_N).all()


def test_repeats_that_agree_to_the_last_digit():
    pulls = plan(repeats=3)
    for name, theta in TRUTH.items():
        fit = sound(fit_law(table(pulls, LAWS[name].log_lift(theta, pulls)), name))
        assert np.allclose(fit.theta, theta, rtol=1e-6, atol=0.0)


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("n", [1, 3])
def test_fewer_trials_than_parameters(name, n):
    pulls = plan([0.04], WRAPS[:n], [20.0])
    fit = sound(fit_law(table(pulls, np.log(20.0) + 0.2 * pulls.wrap_angle_rad + 0.01), name))
    free = sum(item.vary for item in fit.parameters)
    if n < free:
        assert fit.status is FitStatus.TOO_FEW_POINTS
        assert f"{n} condition" in " ".join(fit.advice)
        assert f"{free} parameters" in " ".join(fit.advice)
    assert n > 1 or not fit.trustworthy or free == 1


@pytest.mark.parametrize(
    ("name", "series", "said"),
    [
        ("size-exponential", {"radii": [0.04]}, "only one size ratio"),
        ("size-power", {"radii": [0.04]}, "only one size ratio"),
        ("coupled", {"radii": [0.04]}, "only one size ratio"),
        ("constant-offset", {"wraps": [6.0]}, "only one wrap angle"),
        ("wrap-power", {"wraps": [6.0], "loads": [20.0]}, "only one wrap angle"),
        ("wrap-power-from-zero", {"wraps": [6.0]}, "only one wrap angle"),
        ("wrap-exponential-from-zero", {"wraps": [6.0]}, "only one wrap angle"),
        ("wrap-power", {"loads": [20.0]}, "only one end tension"),
    ],
)
def test_one_value_of_a_regressor_is_named(name, series, said):
    pulls = plan(**series, repeats=2)
    truth = LAWS["coupled"].log_lift(TRUTH["coupled"], pulls)
    trials = table(pulls, truth + 0.01 * np.random.default_rng(9).normal(size=len(pulls)))
    fit = sound(fit_law(trials, name))
    assert not fit.trustworthy
    advice = " ".join(fit.advice)
    assert said in advice or fit.status in {FitStatus.TOO_FEW_POINTS, FitStatus.AT_BOUND}, advice
    named = [item.name for item in fit.parameters if item.vary and item.name in advice]
    assert named or fit.status is FitStatus.TOO_FEW_POINTS


def test_no_trial_at_all_is_refused(refused):
    nothing = TrialTable(
        trial=("a",),
        wheel_radius_m=0.04,
        rope_radius_m=0.005,
        wrap_angle_rad=3.0,
        end_tension_N=20,
        peak_N=np.nan,
    )
    refused(lambda: fit_law(nothing, "constant"), "no trial of the table can be used")
