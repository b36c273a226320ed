"""Observed orders are those of theory: nothing here looks at a clock."""

import mpmath as mp
import numpy as np
import pytest

from ropefric.accuracy.measure import enough, error_table
from ropefric.accuracy.studies.integral import A, gauss_legendre, segment_sum, simpson, trapezoid
from ropefric.friction.integral import power_integral

WRAP = 9.4


def rule_errors(rule, start, b, counts):
    p, delta = np.array([start]), np.array([WRAP])
    exact = power_integral(delta, A, b, 0.1, start_rad=p)
    return {n: abs(float((rule(lambda phi: A * phi**b + 0.1, p, delta, n) - exact)[0])) for n in counts}


def test_segments_and_trapezoid_are_second_order_and_simpson_fourth(errors, order):
    assert order(errors("integral", "regular", "segment sum"), 256, 1024) == pytest.approx(2.0, abs=0.01)
    assert order(errors("integral", "regular", "trapezoid"), 256, 1024) == pytest.approx(2.0, abs=0.01)
    assert order(errors("integral", "regular", "simpson"), 128, 512) == pytest.approx(4.0, abs=0.02)


def test_trapezoid_errs_twice_as_much_as_the_segments_the_other_way(errors):
    """h²/12 f'' against −h²/24 f''."""
    ratio = (
        errors("integral", "regular", "trapezoid")[1024] / errors("integral", "regular", "segment sum")[1024]
    )
    assert ratio == pytest.approx(2.0, rel=1e-3)


def test_gauss_legendre_converges_by_the_ellipse_through_the_singularity(errors):
    """On [-1, 1] φ = 0 lies at −(1 + 2p/δ); the error falls by the sum of that ellipse's axes, squared, a point."""
    z = 1.0 + 2.0 * 1.7 / WRAP
    rate = 2.0 * np.log(z + np.sqrt(z**2 - 1.0))
    found = errors("integral", "regular", "gauss-legendre")
    assert np.log(found[6] / found[12]) / 6.0 == pytest.approx(rate, rel=0.05)


@pytest.mark.parametrize("b", [-0.3, -0.5, -0.8])
def test_segments_from_zero_are_of_order_b_plus_one(b, order):
    """Euler-Maclaurin with a singular end: the middles of segments from φ = 0 leave ζ(−b, 1/2) h^(b+1) of φ^b."""
    found = rule_errors(segment_sum, 0.0, b, (4096, 16384))
    assert order(found, 4096, 16384) == pytest.approx(b + 1.0, abs=0.002)
    leading = A * float(abs(mp.zeta(-b, mp.mpf(1) / 2))) * (WRAP / 16384) ** (b + 1.0)
    assert found[16384] == pytest.approx(leading, rel=1e-3)


@pytest.mark.parametrize(("rule", "weight"), [(trapezoid, 1 / 2), (simpson, 1 / 3)])
def test_closed_rules_look_first_order_while_the_end_point_dominates(rule, weight, order):
    """Their weight on φ0 ≪ h is h/2 or h/3: the error is that times p^b, whatever the order of the rule."""
    p, b = 1e-9, -0.5
    found = rule_errors(rule, p, b, (8, 64))
    assert order(found, 8, 64) == pytest.approx(1.0, abs=0.01)
    assert found[64] == pytest.approx(weight * WRAP / 64 * A * p**b, rel=0.01)


@pytest.mark.parametrize("b", [-0.3, -0.5, -0.8])
def test_gauss_legendre_from_zero_is_of_order_two_b_plus_two(b, order):
    found = rule_errors(gauss_legendre, 0.0, b, (32, 128))
    assert order(found, 32, 128) == pytest.approx(2.0 * (b + 1.0), abs=0.02)


def test_rules_without_an_answer_say_so(errors):
    assert set(errors("integral", "from-zero", "trapezoid").values()) == {float("inf")}
    assert set(errors("integral", "from-zero", "simpson").values()) == {float("inf")}


def test_bisection_gains_a_bit_a_step_and_newton_doubles_the_digits(errors):
    bits = errors("end-tension", "power", "bisection")
    assert np.log2(bits[10] / bits[40]) == pytest.approx(30.0, abs=2.0)
    steps = errors("end-tension", "exponential", "Newton in φ")
    assert np.log(steps[3]) / np.log(steps[2]) == pytest.approx(2.0, abs=0.3)


def test_newton_in_the_logarithm_goes_where_newton_in_the_angle_cannot(errors):
    assert min(errors("end-tension", "power-underflow", "Newton in φ").values()) == pytest.approx(1.0)
    assert errors("end-tension", "power-underflow", "Newton in ln φ")[4] < 1e-11


def test_galerkin_and_chebyshev_converge_faster_than_any_power(errors, order):
    for method in ("Galerkin, one element", "Chebyshev series"):
        found = errors("blade-modes", "blade", method)
        assert order(found, 12, 16) + 2.0 < order(found, 24, 32)


def test_the_string_is_off_by_twice_the_boundary_layer():
    """Each clamped end shortens the string by its layer, e/√S of the span with e = √(EI/F l²), S = 1 − V²."""
    (string,) = error_table("blade-modes", "tiny", method="string")
    second_order = 0.01
    assert string.error == pytest.approx(2.0 * 1e-4 / np.sqrt(0.75), rel=second_order)


def test_an_analytic_jacobian_takes_fewer_evaluations_for_the_same_error():
    work = {way: enough("fit", 1e-6, method=f"{way} Jacobian").evaluations for way in ("analytic", "2-point")}
    assert work["analytic"] < 0.6 * work["2-point"]
