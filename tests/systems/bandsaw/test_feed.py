"""The limit under feed force against closed forms and against the differential equations solved by collocation."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_bvp
from scipy.optimize import brentq
from scipy.special import jv

from ropefric.errors import InputError
from ropefric.systems.bandsaw.answer import feed_limit_N
from ropefric.systems.bandsaw.saw import STEEL_85_09
from ropefric.systems.bandsaw.span import CLAMPED, PINNED

EI = STEEL_85_09.bending_stiffness_N_m2
GJ = STEEL_85_09.shear_modulus_Pa * 0.085 * 0.0009**3 / 3.0
R_SQUARED = (0.085**2 + 0.0009**2) / 12.0
LENGTH_M = 1.6
NONE_N = np.zeros(1)


def bessel_limit_N(offset_m):
    """φ = √x J_1/4(βx²/2) on half a pinned beam without tension, 2 GJ φ' = Q e φ at its middle."""
    half = 0.5 * LENGTH_M

    def surplus(z):
        beta = 2.0 * z / half**2
        return beta * half * jv(-0.75, z) / jv(0.25, z) - beta * math.sqrt(EI * GJ) * offset_m / GJ

    return 2.0 * (2.0 * brentq(surplus, 1e-6, 1.9, xtol=1e-14) / half**2) * math.sqrt(EI * GJ)


def test_without_tension_it_is_the_lateral_buckling_of_a_beam():
    for offset_m in [0.0, 0.001, 0.0425, 0.3]:
        found = feed_limit_N(NONE_N, STEEL_85_09, PINNED, LENGTH_M, offset_m)[0]
        assert found == pytest.approx(bessel_limit_N(offset_m), rel=1e-6), offset_m


def test_timoshenkos_factor():
    found = feed_limit_N(NONE_N, STEEL_85_09, PINNED, LENGTH_M, 0.0)[0]
    assert found * LENGTH_M**2 / math.sqrt(EI * GJ) == pytest.approx(16.94, abs=5e-3)


def test_far_from_the_middle_only_the_twist_counts():
    """A string of stiffness T under a spring −Q e at its middle: Q = 4T/(l e)."""
    net_N, offset_m = 3412.0, 50.0
    found = feed_limit_N(np.array([net_N]), STEEL_85_09, CLAMPED, LENGTH_M, offset_m)[0]
    assert found == pytest.approx(4.0 * (GJ + net_N * R_SQUARED) / (LENGTH_M * offset_m), rel=1e-5)


@pytest.mark.parametrize("ends", [PINNED, CLAMPED], ids=lambda one: one.name)
@pytest.mark.parametrize(("net_N", "length_m"), [(30.0, 0.6), (200.0, 1.6), (800.0, 0.4)])
def test_under_tension_it_solves_the_equations(ends, net_N, length_m):
    """EI u'''' − P u'' + Q (mφ)'' = 0 and T φ'' = Q m u'' on half the span, by a general solver."""
    P, e, half = net_N, 0.0425, 0.5 * length_m
    T = GJ + P * R_SQUARED
    k = math.sqrt(P / (EI * (0.085 / 0.0009) ** 2))

    def moments(x):
        low = 2.0 * math.cosh(k * half)
        return np.sinh(k * x) / (k * low), np.cosh(k * x) / low, k * np.sinh(k * x) / low

    def slopes(x, y, p):
        m, dm, ddm = moments(x)
        twisted = p[0] * m * y[2] / T
        bent = (P * y[2] - p[0] * (ddm * y[4] + 2.0 * dm * y[5] + m * twisted)) / EI
        return np.vstack([y[1], y[2], y[3], bent, y[5], twisted])

    def ends_hold(a, b, p):
        m, dm, _ = moments(np.array(half))
        held = a[2] if ends.turns else a[1]
        shear = (EI * b[3] - P * b[1] + p[0] * (dm * b[4] + m * b[5])) / P
        return np.array([a[0], held, a[4], b[1], shear, 2.0 * T * b[5] - p[0] * e * b[4], b[4] - 1.0])

    x = np.linspace(0.0, half, 401)
    guess = np.zeros((6, x.size))
    guess[4], guess[5] = x / half, 1.0 / half
    found = solve_bvp(
        slopes, ends_hold, x, guess, p=[0.7 * 4.0 * T / (length_m * e)], tol=1e-7, max_nodes=20000
    )
    assert found.success
    own = feed_limit_N(np.array([net_N]), STEEL_85_09, ends, length_m)[0]
    assert own == pytest.approx(found.p[0], rel=1e-5)


def test_tension_width_of_the_guides_and_stiffness_help():
    limits = feed_limit_N(np.array([500.0, 1500.0, 4000.0]), STEEL_85_09, CLAMPED, LENGTH_M)
    assert (np.diff(limits) > 0.0).all()
    near = feed_limit_N(np.array([1500.0]), STEEL_85_09, CLAMPED, 0.4)[0]
    assert near > limits[1]
    thick = feed_limit_N(np.array([1500.0]), replace(STEEL_85_09, thickness_m=0.0012), CLAMPED, LENGTH_M)[0]
    assert thick > limits[1]
    slopes = np.diff(np.log(limits)) / np.diff(np.log([500.0, 1500.0, 4000.0]))
    assert (slopes < 1.5).all(), "the effects' bound counts on it"


def test_a_hair_of_compression_changes_next_to_nothing():
    around = feed_limit_N(np.array([-1e-3, 1e-3]), STEEL_85_09, CLAMPED, LENGTH_M)
    assert around[0] < around[1]
    assert around[0] == pytest.approx(around[1], rel=1e-3)


def test_a_blade_too_fast_to_stand_by_itself_is_refused():
    """Beyond π² EI/l² of compression there is no limit under feed: the blade has buckled before."""
    for net_N in [-40.0, -1e4]:
        own_N = math.pi**2 * STEEL_85_09.bending_stiffness_N_m2 / LENGTH_M**2
        assert own_N < 40.0, net_N
        with pytest.raises(InputError, match="buckles by itself, without any feed"):
            feed_limit_N(np.array([net_N]), STEEL_85_09, PINNED, LENGTH_M)
        assert feed_limit_N(np.array([-0.9 * own_N]), STEEL_85_09, PINNED, LENGTH_M)[0] > 0.0, net_N
