import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from ropefric.errors import InputError, UnknownNameError
from ropefric.trials.outliers import RULES, grubbs_critical_value, max_z, scaled

MECMESIN = [7.18, 7.64, 8.00, 7.40, 9.14, 7.82, 7.67, 7.73, 8.27, 7.30]
SERIES = st.lists(st.integers(-50, 50), min_size=0, max_size=15)
FEW = settings(max_examples=40)


def test_the_default_comes_first():
    assert list(RULES) == ["two-sigma", "grubbs", "none"]
    with pytest.raises(UnknownNameError, match="did you mean 'grubbs'"):
        RULES["grubs"]


def test_the_ten_recorded_peaks_lose_exactly_one():
    for name in ("two-sigma", "grubbs"):
        assert np.flatnonzero(RULES[name].flag(MECMESIN)).tolist() == [4], name


# The definitions once more, in exact arithmetic and without any of the package's.


def exact_z_squared(values):
    """(x − mean)²/s² as fractions; None where s is 0."""
    n, exact = len(values), [Fraction(v) for v in values]
    mean = sum(exact) / n
    variance = sum((v - mean) ** 2 for v in exact) / (n - 1)
    return [(v - mean) ** 2 / variance for v in exact] if variance else None


@FEW
@given(SERIES, st.sampled_from([0.0, 1e9, -1e9]), st.sampled_from([1.0, 2.0**-10, 2.0**600, 2.0**-900]))
def test_two_sigma_is_exact_at_any_offset_and_scale(steps, offset, scale):
    values = [(offset + step / 1024) * scale for step in steps]
    flagged = RULES["two-sigma"].flag(values).tolist()
    z_squared = exact_z_squared(values) if len(values) > 1 else None
    assert flagged == ([z > 4 for z in z_squared] if z_squared else [False] * len(values))


def test_a_value_on_the_limit_is_inside():
    # z of the two is exactly 2: s² = 2/8, |x| = 1
    values = np.array([0.0] * 7 + [1.0, -1.0])
    for factor in (1.0, 0.1, 1e-7, 3.3):
        assert not RULES["two-sigma"].flag(values * factor + 7 * factor).any()


@FEW
@given(SERIES)
def test_grubbs_against_its_definition(steps):
    assume(len(steps) > 2)
    z_squared = exact_z_squared(steps)
    flagged = RULES["grubbs"].flag(steps).tolist()
    if z_squared is None:
        assert not any(flagged)
        return
    critical = grubbs_critical_value(len(steps))
    assert flagged == [z == max(z_squared) and math.sqrt(z) > critical for z in z_squared]


# Of every rule, beside what `ropefric.testing` asks of it.


def test_what_is_refused_is_named():
    for rule in RULES.values():
        with pytest.raises(InputError, match="value 3 of 4 is") as error:
            rule.flag([1.0, 2.0, math.nan, 3.0])
        assert error.value.code == "RF311"
        with pytest.raises(InputError, match="not a series of numbers"):
            rule.flag(["a"])
        with pytest.raises(InputError, match="in one dimension"):
            rule.flag([[1.0, 2.0]])


@FEW
@given(SERIES, st.integers(-64, 64).filter(bool), st.integers(-(2**40), 2**40), st.integers(-300, 300))
def test_shift_scale_and_mirror_do_not_matter_and_the_series_is_left_alone(steps, slope, offset, exponent):
    values = np.array(steps, dtype=float)
    other = (slope * values[::-1] + offset) * 2.0**exponent
    before = other.tolist()
    for rule in RULES.values():
        assert rule.flag(other).tolist() == rule.flag(values)[::-1].tolist(), rule.name
    assert other.tolist() == before


@FEW
@given(st.lists(st.floats(-1e300, 1e300), max_size=12))
def test_any_finite_floats_give_flags_and_never_most_of_the_series(values):
    for rule in RULES.values():
        assert 2 * rule.flag(values).sum() <= max(len(values), 1), rule.name


@FEW
@given(st.lists(st.floats(-1e6, 1e6), max_size=5))
def test_two_sigma_can_never_reject_among_five(values):
    assert not RULES["two-sigma"].flag(values).any()


def test_the_largest_z():
    for n in range(2, 40):
        z_squared = exact_z_squared([0] * (n - 1) + [1])
        assert max_z(n) == pytest.approx(math.sqrt(max(z_squared)), rel=1e-14)
    assert max_z(0) == max_z(1) == 0.0


def test_a_rule_that_can_reject_nothing_says_so():
    assert not any(RULES[name].warning(n) for name, n in (("two-sigma", 6), ("none", 3)))
    for name, n, words in (("two-sigma", 0, "the ±2s rule"), ("grubbs", 2, "Grubbs' test")):
        assert RULES[name].warning(n).startswith(f"n = {n}, {words}"), name


# Printed numbers and independent arithmetic.


# ASTM E178 table 1: n, upper 2.5 % significance level
E178 = {3: 1.155, 4: 1.481, 5: 1.715, 6: 1.887, 7: 2.020, 8: 2.126, 9: 2.215, 10: 2.290, 12: 2.412, 15: 2.549,
    20: 2.709, 30: 2.908}  # fmt: skip


def test_grubbs_critical_values_as_printed_and_against_mpmath():
    assert grubbs_critical_value(2) == math.inf
    for n, printed in E178.items():
        assert grubbs_critical_value(n) == pytest.approx(printed, abs=1.01e-3), n
    for n in (3, 6, 17, 100):  # P(|t| > t_c) from the incomplete beta function must be α/n
        g = mpmath.mpf(grubbs_critical_value(n))
        # invert G(t): t² = G² n (n−2) / ((n−1)² − n G²)
        t_squared = g**2 * n * (n - 2) / ((n - 1) ** 2 - n * g**2)
        tail = mpmath.betainc(
            (n - 2) / mpmath.mpf(2), 0.5, 0, (n - 2) / (n - 2 + t_squared), regularized=True
        )
        assert float(tail) == pytest.approx(0.05 / n, rel=1e-9), n


@FEW
@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=20), st.sampled_from([0.0, 1e9, 1e12]))
def test_mean_and_scatter_against_fractions(values, offset):
    shifted = [v + offset for v in values]
    exact = [Fraction(v) for v in shifted]
    mean = sum(exact) / len(exact)
    series = scaled(shifted)
    # Four roundings of numbers no larger than the largest value.
    assert series.mean() == pytest.approx(float(mean), rel=0, abs=4 * 2.3e-16 * max(map(abs, shifted)))
    if len(exact) > 1:
        with mpmath.workdps(40):
            variance = sum((v - mean) ** 2 for v in exact) / (len(exact) - 1)
            std = mpmath.sqrt(mpmath.mpf(variance.numerator) / variance.denominator)
        assert series.std() == pytest.approx(float(std), rel=1e-13, abs=1e-300)
