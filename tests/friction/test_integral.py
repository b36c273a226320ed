"""The closed forms against quadrature and the numbers printed on paper; tests/hard has them in many digits."""

import math

import mpmath as mp
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from ropefric.errors import SolverError
from ropefric.friction import integral
from ropefric.friction.condition import one_condition
from ropefric.friction.integral import exprel_slope, log1prel, log1prel_slope, power_log_start
from ropefric.friction.laws import LAWS
from ropefric.friction.laws.wrap import exponential_rise


def lift(name, theta, wrap_rad, tension_N):
    return float(LAWS[name].log_lift(theta, one_condition(0.04, 0.005, wrap_rad, tension_N))[0])


def test_the_numbers_on_paper():
    # rope_wheel.md §3: F_B = 20 N, a = .2, b = -.5, c = .1, φ = 10 rad
    assert lift("wrap-power", [0.2, -0.5, 0.1], 10, 20) == pytest.approx(4.4507, abs=5e-5)
    # §4: b = -0.999, y = 1: ln φ0 = -5298 (a = 0.2, c = 0)
    assert float(power_log_start(1.0, 0.2, -0.999, 0.0)) == pytest.approx(-5298, abs=0.5)


def test_five_newton_steps_are_not_enough_near_minus_one(monkeypatch):
    # rope_wheel.md §4 promises at most 5 steps. That holds for b >= -0.8; at b = -0.999 it takes 10.
    y, c = 1e-3, 1e-3
    monkeypatch.setattr(integral, "_MAX_STEPS", 5)
    assert np.isfinite(power_log_start(y, 0.2 * y, -0.8, c))
    with pytest.raises(SolverError, match="did not converge"):
        power_log_start(y, 1e-3 * y, -0.999, c)
    monkeypatch.setattr(integral, "_MAX_STEPS", 10)
    assert np.isfinite(power_log_start(y, 1e-3 * y, -0.999, c))


@settings(deadline=None, max_examples=40)
@given(a=st.floats(0.01, 1), b=st.floats(-0.9, 0), c=st.floats(0.01, 0.5), wrap=st.floats(0.01, 60),
       tension=st.floats(1.1, 1000), exponential=st.booleans())  # fmt: skip
def test_lift_is_the_solution_of_the_differential_equation(*, a, b, c, wrap, tension, exponential):
    """d ln F/dφ = μ(φ) with F = 1 N at φ = 0: φ0 by halving an interval, the lift by Runge-Kutta from there."""

    def mu(phi):
        return a * math.exp(b * phi) + c if exponential else a * phi**b + c

    def rise(phi):
        if exponential:
            return a * math.expm1(b * phi) / b + c * phi if abs(b) > 1e-9 else (a + c) * phi
        return a * phi ** (b + 1) / (b + 1) + c * phi

    y = math.log(tension)
    low, high = 0.0, y / c
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if rise(middle) < y else (low, middle)
    assume(low > 1e-6)
    answer = solve_ivp(lambda phi, _f: [mu(phi)], (low, low + wrap), [y], rtol=1e-10, atol=1e-12).y[0, -1]
    name = "wrap-exponential" if exponential else "wrap-power"
    assert lift(name, [a, b, c], wrap, tension) == pytest.approx(answer, rel=1e-7)


@settings(deadline=None, max_examples=50)
@given(p=st.floats(1e-3, 50), delta=st.floats(1e-3, 50), b=st.floats(-3, 2), rate=st.floats(-5, 0.2))
def test_integrals_agree_with_quadrature(p, delta, b, rate):
    power = quad(lambda t: math.exp((b + 1) * t), math.log(p), math.log(p + delta), epsrel=1e-12, epsabs=0)[0]
    assert float(integral.PowerSpan(np.log(p), delta, b).integral()) == pytest.approx(power, rel=1e-9)
    exponential = quad(lambda t: math.exp(rate * t), 0, delta, epsrel=1e-12, epsabs=0, limit=200)[0]
    found = float(exponential_rise(np.float64(p), np.float64(delta), math.exp(-rate * p), rate, 0.0))
    assert found == pytest.approx(exponential, rel=1e-9)


def test_special_functions():
    for z in (-700.0, -40.0, -1.0, -0.1001, -0.0999, -1e-5, 0.0, 1e-12, 0.05, 0.0999, 0.1001, 30.0):
        with mp.workdps(40):
            x = mp.mpf(z)
            psi = mp.mpf(1) / 2 if z == 0 else (x * mp.exp(x) - mp.expm1(x)) / x**2
            assert abs(float(exprel_slope(z)) / psi - 1) < 1e-14, z
            if z > -1:
                rel = mp.mpf(1) if z == 0 else mp.log1p(x) / x
                slope = -mp.mpf(1) / 2 if z == 0 else (x / (1 + x) - mp.log1p(x)) / x**2
                assert abs(float(log1prel(z)) / rel - 1) < 1e-15, z
                assert abs(float(log1prel_slope(z)) / slope - 1) < 1e-14, z
