"""The stored references are what 50-digit arithmetic says, by formulas of its own."""

import mpmath as mp
import numpy as np
import pytest

from ropefric.accuracy.studies import blade_modes, integral, interval
from ropefric.friction.laws import LAWS

HALF_A_UNIT = 1.2e-16


@pytest.fixture(autouse=True)
def _fifty_digits():
    with mp.workdps(50):
        yield


def agrees(stored, exact):
    return abs(mp.mpf(float(stored)) - exact) <= HALF_A_UNIT * abs(exact)


def quadrature(start, wrap, b):
    """∫ (0.2 φ^b + 0.1) dφ in the logarithm of φ, where the integrand is entire; no antiderivative of φ^b."""
    p, delta, s = mp.mpf(start), mp.mpf(wrap), mp.mpf(b) + 1
    end = mp.log(p + delta)
    begin = mp.log(p) if p else end - 60 / s * mp.log(10)
    power = mp.quad(lambda u: mp.exp(s * u), mp.linspace(begin, end, 12))
    return mp.mpf(integral.A) * power + mp.mpf(integral.C) * delta


def test_integrals():
    many = zip(
        integral.MANY, [(p, delta) for p in (0.5, 1.7, 5.0, 15.0) for delta in (1.5, 12.0)], strict=True
    )
    for stored, start, wrap, b in ((integral.REGULAR, 1.7, 9.4, -0.5), (integral.FROM_ZERO, 0.0, 9.4, -0.5),
                                   (integral.NEAR_MINUS_ONE, 1e-3, 9.4, integral.NEARLY),
                                   (integral.SHORT_WRAP, 10.0, 1e-6, -0.5),
                                   *((value, p, delta, -0.5) for value, (p, delta) in many)):  # fmt: skip
        assert agrees(stored, quadrature(start, wrap, b)), (start, wrap, b)


def test_frequencies_are_those_the_field_prints():
    """Scaled reference of band_saw.md, clamped, eps² = 1e-2, V = 0.5."""
    printed = (3.445561083223, 8.337819919385)
    np.testing.assert_allclose(blade_modes.FREQUENCIES[1e-2][:2], printed, rtol=0, atol=6e-13)


@pytest.mark.parametrize("law", ["constant", "thickness"])
def test_exact_interval_is_where_chi_squared_has_grown_by_its_quantile(law):
    problem = interval.interval_problem(law)
    best, low, high = interval.exact_interval(law)
    quantile = mp.mpf(2) * mp.erfinv(mp.mpf("0.95")) ** 2
    A = mp.mpf(interval.SIZE_SHARE)

    def chi2(mu):
        mu = mp.mpf(float(mu))
        rate = mu if law == "constant" else (-1 + mp.sqrt(1 + 4 * A * mu**2 * (1 - A))) / (2 * A * mu)
        wraps = problem.conditions.wrap_angle_rad
        rises = [mp.mpf(float(value)) - mp.log(20) for value in problem.log_lift]
        sigma = mp.mpf(float(problem.std[0]))
        return sum(((rate * mp.mpf(float(p)) - y) / sigma) ** 2 for p, y in zip(wraps, rises, strict=True))

    assert chi2(best) < min(chi2(best * (1 - 1e-6)), chi2(best * (1 + 1e-6)))
    for end in (low, high):
        assert float((chi2(end) - chi2(best)) / quantile) == pytest.approx(1.0, rel=1e-12)


def test_the_exponent_of_the_thick_rope_is_inverted():
    """The wheel of the study and the law of the library mean the same A."""
    problem = interval.interval_problem("thickness")
    mu = 0.7
    rise = LAWS["thickness"].log_lift([mu], problem.conditions) - np.log(20.0)
    exponent = rise / problem.conditions.wrap_angle_rad
    np.testing.assert_allclose(interval.mu_of_exponent("thickness", exponent), mu, rtol=1e-13)
