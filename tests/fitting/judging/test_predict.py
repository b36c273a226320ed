"""Predictions: intervals against closed forms and draws, extrapolation, running ropes, the hand calculation."""

import ast
import json
import math
import operator
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import optimize, stats

from ropefric.errors import InputError
from ropefric.fitting.fit import fit_law
from ropefric.fitting.predict import lift_ends, predict
from ropefric.fitting.scatter import ALL
from ropefric.fitting.store import load_fit
from ropefric.friction.condition import Conditions
from ropefric.friction.law import LiftModel
from ropefric.friction.laws import ALL_LAWS


def pulls(wrap=(3.0, 9.0), load=20.0, wheel=0.03):
    return Conditions(wheel_radius_m=wheel, rope_radius_m=0.005, wrap_angle_rad=np.array(wrap),
        end_tension_N=load)  # fmt: skip


def test_outside_what_was_tested_a_rival_law_lowers_the_bound_of_one_pull():
    """To its own lower bound, if that is lower; within the tested range the law alone counts."""
    stored = Path(__file__).parents[3] / "fits"
    fit, rival = (load_fit(stored / f"prth-{name}.json") for name in ("coupled", "constant"))
    law, other = (LiftModel(law=one.friction_law) for one in (fit, rival))
    lower = []
    for wheel_m in (0.04, 0.3):
        at = replace(pulls((6.0, 9.0), load=60.0, wheel=wheel_m), rope_radius_m=0.0049)
        own = lift_ends(fit, law, at, 0.95).pull[:, 0]
        with_rival = lift_ends(replace(fit, rivals=(rival,)), law, at, 0.95).pull[:, 0]
        of_rival = lift_ends(rival, other, at, 0.95).pull[:, 0]
        lower.append((own, with_rival, np.minimum(own, of_rival)))
    (own, with_rival, _), (alone, outside, both) = lower
    np.testing.assert_array_equal(own, with_rival)
    np.testing.assert_allclose(outside, both, rtol=1e-12)
    assert (outside < alone).all()


def test_constant_law_by_hand(constant_fit):
    """ln F_A = ln F_B + μ φ, so its standard deviation is φ s_μ, and the intervals follow on paper."""
    mu, std = constant_fit["mu"].value, constant_fit["mu"].std
    found = predict(constant_fit, pulls(), level=0.9)
    np.testing.assert_allclose(found.lift_force_N, 20 * np.exp(mu * np.array([3, 9])), rtol=1e-12)
    np.testing.assert_allclose(found.std_log, std * np.array([3, 9]), rtol=1e-9)
    t = stats.t.ppf(0.95, constant_fit.statistics.interval_dof)
    high = np.log(20) + (mu + t * std) * np.array([3, 9])
    np.testing.assert_allclose(np.log(found.interval_N[:, 1]), high, rtol=1e-7)
    np.testing.assert_allclose(found.log_half_width, t * std * np.array([3, 9]), rtol=1e-6)
    s = constant_fit.statistics
    # Welch and Satterthwaite: what repeats alone show has their degrees of freedom, the rest those of the conditions.
    law2, nu = (std * np.array([3, 9])) ** 2, s.interval_dof
    pulls2 = s.scatter_within**2 * (1 - s.n_conditions / s.n)
    all2 = law2 + s.scatter_within**2 + s.scatter_between**2
    effective = all2**2 / ((all2 - pulls2) ** 2 / nu + pulls2**2 / (s.n - s.n_conditions))
    wide = stats.t.ppf(0.95, effective) * np.sqrt(all2)
    np.testing.assert_allclose(np.log(found.prediction_interval_N[:, 0]), found.log_lift - wide, rtol=1e-6)
    # Made in ln F, so longer upward.
    up, down = found.interval_N[:, 1] - found.lift_force_N, found.lift_force_N - found.interval_N[:, 0]
    assert (up > down).all()


def test_the_profile_is_the_linear_interval_where_the_law_is_straight(constant_fit):
    assert predict(constant_fit, pulls()).method == "linear"
    by_profile = predict(constant_fit, pulls(), method="profile")
    np.testing.assert_allclose(by_profile.interval_N, predict(constant_fit, pulls()).interval_N, rtol=1e-12)


def test_the_profile_of_a_prediction_is_where_a_constrained_fit_says(wrap_fit):
    """Held to the force at an end, the best fit is as far off the data as Student's t allows: by another minimiser."""
    at, level = pulls([4.0], load=40.0), 0.95
    found, straight = predict(wrap_fit, at, level=level), predict(wrap_fit, at, level=level, method="linear")
    assert (found.method, straight.method) == ("profile", "linear")
    means, law = wrap_fit.weighted(), wrap_fit.friction_law
    J, C = law.jacobian(wrap_fit.theta, at)[0], wrap_fit.covariance
    S = means.jacobian(wrap_fit.theta)
    widened = (J @ C @ J) / (J @ np.linalg.inv(S.T @ S) @ J)
    allowed = stats.t.ppf(0.975, found.dof[0]) ** 2 * widened
    least = (means.residuals(wrap_fit.theta) ** 2).sum()
    for end_N in found.interval_N[0]:
        held = optimize.minimize(lambda x: (means.residuals(x) ** 2).sum(), wrap_fit.theta, method="SLSQP",
            constraints={"type": "eq", "fun": lambda x, end=end_N: law.log_lift(x, at)[0] - math.log(end)},
            options={"ftol": 1e-12, "maxiter": 500})  # fmt: skip
        assert held.fun - least == pytest.approx(allowed, rel=2e-3)
    assert found.interval_N[0] == pytest.approx(straight.interval_N[0], rel=0.02)


@pytest.mark.parametrize("speed", [0.0, 10.0])
def test_gradient_of_a_running_rope(wrap_fit, speed):
    model = LiftModel(law=ALL_LAWS["wrap-power"], linear_density_kg_m=0.06, speed_m_s=speed)
    theta, at = wrap_fit.theta, pulls(wrap=[1.0, 9.0, 30.0])
    J = model.jacobian(theta, at)
    for i in range(3):
        h = 1e-6 * max(abs(theta[i]), 0.01)
        up, down = theta.copy(), theta.copy()
        up[i] += h
        down[i] -= h
        slope = (model.log_lift(up, at) - model.log_lift(down, at)) / (2 * h)
        np.testing.assert_allclose(J[:, i], slope, rtol=2e-6)
    running = {"linear_density_kg_m": 0.06, "speed_m_s": speed} if speed else {}
    expected = [math.sqrt(j @ wrap_fit.covariance @ j) for j in J]
    np.testing.assert_allclose(predict(wrap_fit, at, **running).std_log, expected, rtol=1e-9)


def test_running_rope_lifts_by_the_centrifugal_formula(constant_fit):
    mu = constant_fit["mu"].value
    running = {"linear_density_kg_m": 0.06, "speed_m_s": 10.0}
    found = predict(constant_fit, pulls([6.0]), **running)
    assert found.lift_force_N[0] == pytest.approx(6 + 14 * math.exp(6 * mu), rel=1e-12)
    by_profile = predict(constant_fit, pulls([6.0]), method="profile", **running)
    assert by_profile.interval_N == pytest.approx(found.interval_N, rel=1e-9)
    with pytest.raises(InputError, match="lifts off the wheel"):
        predict(constant_fit, pulls(), linear_density_kg_m=0.06, speed_m_s=30.0)
    with pytest.raises(InputError, match="speed_m_s is missing"):
        predict(constant_fit, pulls(), linear_density_kg_m=0.06)


def test_extrapolation_in_words(constant_fit):
    found = predict(constant_fit, pulls(np.radians([360.0, 720.0, 900.0])))
    assert found.extrapolated.tolist() == [False, False, True]
    assert (found.notes(2)[0], found.notes(0)) == ("wrap 900 deg is outside the tested 90–720 deg", ())
    other = predict(constant_fit, pulls([6.0], load=200.0, wheel=0.05))
    assert other.notes(0) == ("wheel radius 50 mm is outside the tested 30 mm",
        "end tension 200 N is outside the tested 5–80 N")  # fmt: skip


def test_json(constant_fit):
    tree = predict(constant_fit, pulls([6.0])).to_dict()
    assert {"lift_force_N", "std_N", "interval_N", "level", "extrapolated", "method"} <= set(tree)
    assert len(json.loads(json.dumps(tree, allow_nan=False))["interval_N"]) == 2
    assert len(predict(constant_fit, pulls()).to_dict()["predictions"]) == 2


def test_bad_arguments(constant_fit):
    for options, message in (({"level": 1.0}, "level is 1"), ({"level": math.nan}, "level is nan"),
            ({"method": "magic"}, "unknown method"),
            ({"linear_density_kg_m": -1.0, "speed_m_s": 1.0}, "zero or more")):  # fmt: skip
        with pytest.raises(InputError, match=message):
            predict(constant_fit, pulls(), **options)
    with pytest.raises(InputError, match="overflows"):
        predict(constant_fit, pulls([1e4]))


def test_prediction_interval_covers_new_ropes(campaign):
    """95 % of single pulls at a new condition lie inside, between-condition scatter included."""
    at, inside, n, rng = pulls([6.0]), 0, 40, np.random.default_rng(11)
    for seed in range(n):
        table = campaign("constant", [0.2], between=0.02, repeats=3, seed=seed, loads=(5.0, 20.0))
        low, high = predict(fit_law(table, "constant"), at).prediction_interval_N[0]
        new = 20 * math.exp(1.2 + 0.02 * rng.standard_normal() + 0.01 * rng.standard_normal())
        inside += low <= new <= high
    # Binomial: 0.95 ± 3.5 standard deviations.
    assert abs(inside / n - 0.95) < 3.5 * math.sqrt(0.95 * 0.05 / n)


def test_unknown_scatter_gives_no_prediction_interval(constant_fit):
    model = constant_fit.scatter
    bare = replace(constant_fit, trials={}, scatter=replace(model, names=tuple(ALL for _ in model.names)))
    assert not bare.scatter.of_pulls
    found = predict(bare, pulls([6.0]))
    assert np.isnan(found.prediction_interval_N).all()
    assert np.isfinite(found.interval_N).all()
    assert found.to_dict()["prediction_interval_N"] == [None, None]


# --- the hand calculation ---------------------------------------------------------------------------------------

_FUNCTIONS = {"ln": math.log, "exp": math.exp, "sqrt": math.sqrt, "sin": math.sin, "acos": math.acos}
_OPERATORS = {ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv}
_OPERATORS |= {ast.Pow: operator.pow}


def calculate(text):
    """A pocket calculator: arithmetic of numbers and four functions."""

    def value(node):
        match node:
            case ast.Constant(value=number):
                return float(number)
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return -value(operand)
            case ast.BinOp(left=left, op=op, right=right):
                return _OPERATORS[type(op)](value(left), value(right))
            case ast.Call(func=ast.Name(id=name), args=[argument]):
                return _FUNCTIONS[name](value(argument))
        raise AssertionError(ast.dump(node))

    return value(ast.parse(text.replace("^", "**"), mode="eval").body)


HAND = {"constant": [0.2], "constant-offset": [0.2, -0.05], "size-power": [0.2, 1.5, 0.03],
    "size-exponential": [0.25, -0.2, -0.3], "wrap-exponential": [0.1, -0.5, 0.12],
    "wrap-exponential-from-zero": [0.1, -0.5, 0.12], "wrap-power": [0.2, -0.5, 0.1],
    "wrap-power-from-zero": [0.2, -0.5, 0.1], "coupled": [0.25, -0.2, -0.3, -0.4, 0.05],
    "coupled-from-zero": [0.25, -0.2, -0.3, -0.4, 0.05], "thickness": [0.2], "howell": [0.5, 0.9],
    "groove": [0.07, 0.349], "bending": [0.2, 1e-5]}  # fmt: skip


HARD = [("wrap-power", [0.2, -0.995, 0.1]), ("wrap-exponential", [0.1, 0.0, 0.1]), ("howell", [0.2, 1.0])]


@pytest.mark.parametrize(("wrap", "load"), [(0.5, 1.0), (9.42478, 20.0), (20.0, 80.0)])
def test_hand_calculation_is_right_to_its_last_digit(wrap, load):
    at = pulls([wrap], load=load)
    for name, theta in [*HAND.items(), *HARD]:
        lines = ALL_LAWS[name].calculation(np.array(theta), at)
        sums = [line for line in lines if line.count(" = ") == 2 and not line.startswith("law ")]
        assert len(sums) >= 4, name
        for line in sums:
            _name, arithmetic, printed = line.split(" = ")
            result, shown = calculate(arithmetic), calculate(printed)
            # Half a unit of the ninth digit, and what cancels in a sum of nine-digit terms.
            terms = [abs(float(x)) for x in re.findall(r"\d+\.?\d*(?:e[-+]\d+)?", arithmetic)]
            assert abs(result - shown) <= 0.51e-8 * abs(shown) + 1e-15 * max(terms), line
        final = float(re.match(r"F_A \[N\] = .* = (\S+)", lines[-2]).group(1))
        exact = float(np.exp(ALL_LAWS[name].log_lift(theta, at))[0])
        assert final == pytest.approx(exact, rel=2e-6), name


def test_hand_calculation_shows_the_numbers_of_the_model_page():
    """F_B = 20 N, a = .2, b = −.5, c = .1, φ = 10 rad: ln F_A = 4.4507."""
    lines = ALL_LAWS["wrap-power"].calculation([0.2, -0.5, 0.1], pulls([10.0]))
    (log_lift,) = [line for line in lines if line.startswith("ln F_A = ")]
    assert round(float(log_lift.split(" = ")[-1]), 4) == 4.4507
