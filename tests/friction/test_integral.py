"""The closed forms against 50 digits, against quadrature, and against the numbers printed on paper."""

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
from ropefric.friction.integral import (
    PowerSpan,
    exponential_start_rad,
    exprel_slope,
    log1prel,
    log1prel_slope,
    power_log_start,
)
from ropefric.friction.laws import LAWS
from ropefric.friction.laws.wrap import exponential_rise

# Issue 3 asks for 1e-12; what is reached is 5e-15, and the tests hold a tenth of what is asked.
ASKED = 1e-13


def power_rise(y, delta, a, b, c):
    return float(a * PowerSpan(power_log_start(y, a, b, c), delta, b).integral() + c * delta)


def wrap_exponential_rise(y, delta, a, b, c):
    return float(exponential_rise(exponential_start_rad(y, a, b, c), np.float64(delta), a, b, c))


def lift(name, theta, wrap_rad, tension_N):
    return float(LAWS[name].log_lift(theta, one_condition(0.04, 0.005, wrap_rad, tension_N))[0])


def decades(rng, low, high):
    return 10.0 ** rng.uniform(low, high)


POWER_REGIMES = {
    "ordinary": lambda r: (r.uniform(0.1, 6), r.uniform(0.1, 40), 0.2, r.uniform(-0.95, -0.01), 0.1),
    "zero wrap": lambda r: (r.uniform(0.1, 6), decades(r, -15, -6), 0.3, r.uniform(-0.95, -0.01), 0.1),
    "F_B -> F_0": lambda r: (decades(r, -15, -3), r.uniform(0.1, 40), 0.3, r.uniform(-0.95, -0.01), 0.1),
    "both": lambda r: (decades(r, -15, -3), decades(r, -12, -3), 0.3, r.uniform(-0.95, -0.01), 0.05),
    "F_B = F_0": lambda r: (0.0, r.uniform(0.1, 40), 0.3, r.uniform(-0.95, -0.01), 0.05),
    "b -> 0": lambda r: (r.uniform(0.1, 6), r.uniform(0.1, 40), 0.2, -decades(r, -15, -3), 0.1),
    "b = 0": lambda r: (r.uniform(0.1, 6), r.uniform(0.1, 40), 0.2, 0.0, 0.1),
    "phi0 underflows": lambda r: (r.uniform(0.1, 6), decades(r, -9, 2), 0.2, -1 + 1e-3, 0.1),
    "phi0 underflows, c = 0": lambda r: (r.uniform(0.1, 6), decades(r, -9, 2), 0.2, -1 + 1e-3, 0.0),
    "b + 1 = 1e-9": lambda r: (r.uniform(0.1, 6), decades(r, -9, 2), 0.2, -1 + 1e-9, 0.05),
    "hundreds of turns": lambda r: (r.uniform(0.1, 6), r.uniform(600, 6000), 0.4, r.uniform(-0.95, -0.01), 0.2),
    "a = 0": lambda r: (r.uniform(0.1, 6), r.uniform(0.1, 40), 0.0, -0.5, 0.1),
    "tiny a": lambda r: (r.uniform(0.1, 6), r.uniform(0.1, 40), decades(r, -200, -10), -0.5, 0.1),
}  # fmt: skip


def saturating(r):
    a, b = 0.2, -r.uniform(0.01, 2)
    return a / -b * r.uniform(0.01, 0.99), r.uniform(0.1, 40), a, b, 0.0


EXPONENTIAL_REGIMES = {
    "ordinary": lambda r: (r.uniform(0.1, 6), r.uniform(0.1, 40), 0.2, -r.uniform(0.01, 2), 0.1),
    "zero wrap": lambda r: (r.uniform(0.1, 6), decades(r, -15, -6), 0.2, -r.uniform(0.01, 2), 0.1),
    "F_B -> F_0": lambda r: (decades(r, -15, -3), r.uniform(0.1, 40), 0.2, -r.uniform(0.01, 2), 0.1),
    "F_B = F_0": lambda r: (0.0, r.uniform(0.1, 40), 0.2, -r.uniform(0.01, 2), 0.1),
    "b -> 0": lambda r: (r.uniform(0.1, 6), r.uniform(0.1, 40), 0.2, -decades(r, -15, -3), 0.1),
    "b = 0": lambda r: (r.uniform(0.1, 6), r.uniform(0.1, 40), 0.2, 0.0, 0.1),
    "steep": lambda r: (r.uniform(0.1, 6), r.uniform(0.1, 40), 0.2, -decades(r, 0, 1.3), 0.1),
    "c -> 0": lambda r: (r.uniform(0.1, 6), r.uniform(0.1, 40), 0.2, -r.uniform(0.01, 2), decades(r, -12, -3)),
    "c = 0": saturating,
    "hundreds of turns": lambda r: (r.uniform(0.1, 6), r.uniform(600, 6000), 0.2, -r.uniform(0.01, 2), 0.2),
    "a = 0": lambda r: (r.uniform(0.1, 6), r.uniform(0.1, 40), 0.0, -0.5, 0.1),
}  # fmt: skip


@pytest.mark.parametrize(
    ("regimes", "rise", "seed"),
    [(POWER_REGIMES, power_rise, 7), (EXPONENTIAL_REGIMES, wrap_exponential_rise, 9)],
    ids=["power", "exponential"],
)
def test_wrap_laws_keep_their_digits(regimes, rise, seed, reference):
    exact = reference.power_rise if rise is power_rise else reference.exponential_rise
    for regime, draw in regimes.items():
        rng = np.random.default_rng(seed)
        for case in (draw(rng) for _ in range(4)):
            assert abs(mp.mpf(rise(*case)) / exact(*case) - 1) < ASKED, (regime, case)


def test_power_law_near_the_angle_where_the_problem_itself_is_ill_conditioned(reference):
    # φ0 = (y s/a)^{1/s}: one rounding of y moves φ0, and with it the rise, by up to 1/s roundings. Where φ0 is
    # neither far above nor far below the wrap no method in doubles can do better than a few eps/s.
    a = 0.2
    for s in (1e-2, 1e-4, 1e-6):
        for start in 10.0 ** np.random.default_rng(8).uniform(-2, 1, 4):
            b = s - 1.0
            case = (a * start ** (b + 1.0) / (b + 1.0), 3.0, a, b, 0.0)
            off = abs(mp.mpf(power_rise(*case)) / reference.power_rise(*case) - 1)
            assert off < 8 * np.finfo(float).eps / s, case


def test_stretch_away_from_zero_goes_through_minus_one():
    p = 0.7
    for b in (-1.0, -1 - 1e-15, -1 + 1e-15, -1 - 1e-6, -1 + 1e-6, -1.5, -0.5, 0.0, 2.0):
        for delta in (1e-12, 1e-9, 0.3, 100.0):
            with mp.workdps(60):
                s, lo, hi = mp.mpf(b) + 1, mp.mpf(p), mp.mpf(p) + mp.mpf(delta)
                truth = mp.log(hi / lo) if s == 0 else (hi**s - lo**s) / s
                slope = mp.quad(lambda t, s=s: mp.exp(s * t) * t, [mp.log(lo), mp.log(hi)])
            found = float(integral.power_integral(delta, 1.0, b, start_rad=p))
            assert abs(found / truth - 1) < ASKED, (b, delta)
            # Relative to ∫ φ^b |ln φ|: ln φ changes sign at 1 rad, and the slope itself may pass through zero.
            scale = max(abs(slope), truth * 0.3)
            assert abs(float(PowerSpan(math.log(p), delta, b).slope()) - slope) < 1e-12 * scale, (b, delta)


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
@given(
    a=st.floats(0.01, 1), b=st.floats(-0.9, 0), c=st.floats(0.01, 0.5),
    wrap=st.floats(0.01, 60), tension=st.floats(1.1, 1000), exponential=st.booleans(),
)  # fmt: skip
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
@given(
    p=st.floats(1e-3, 50), delta=st.floats(1e-3, 50), b=st.floats(-3, 2), rate=st.floats(-5, 0.2)
)  # fmt: skip
def test_integrals_agree_with_quadrature(p, delta, b, rate):
    power = quad(lambda t: math.exp((b + 1) * t), math.log(p), math.log(p + delta), epsrel=1e-12, epsabs=0)[0]
    assert float(integral.power_integral(delta, 1.0, b, start_rad=p)) == pytest.approx(power, rel=1e-9)
    exponential = quad(lambda t: math.exp(rate * t), 0, delta, epsrel=1e-12, epsabs=0, limit=200)[0]
    found = float(exponential_rise(np.float64(p), np.float64(delta), math.exp(-rate * p), rate, 0.0))
    assert found == pytest.approx(exponential, rel=1e-9)


@settings(deadline=None, max_examples=50)
@given(a=st.floats(0.01, 1), b=st.floats(-0.99, 0), wrap=st.floats(0.01, 50), cut=st.floats(0.05, 0.95))
def test_two_stretches_make_one(a, b, wrap, cut):
    first, rest = cut * wrap, (1 - cut) * wrap
    whole = integral.power_integral(wrap, a, b)
    parts = integral.power_integral(first, a, b) + integral.power_integral(rest, a, b, start_rad=first)
    assert float(parts) == pytest.approx(float(whole), rel=1e-12)


def test_zero_wrap_adds_nothing():
    assert float(integral.power_integral(0.0, 0.2, -0.5, 0.1)) == 0.0
    assert lift("wrap-power", [0.2, -0.5, 0.1], 0.0, 20) == math.log(20.0)


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
