"""Observed orders are those of theory: nothing here looks at a clock."""

import numpy as np
import pytest

from ropefric.accuracy.measure import error_table
from ropefric.accuracy.studies import STUDIES, press_transient

WRAP = 9.4


def test_segments_and_trapezoid_are_second_order(errors, order):
    assert order(errors("integral", "regular", "segment sum"), 256, 1024) == pytest.approx(2.0, abs=0.01)
    assert order(errors("integral", "regular", "trapezoid"), 256, 1024) == pytest.approx(2.0, abs=0.01)


def test_gauss_legendre_converges_by_the_ellipse_through_the_singularity(errors):
    """On [-1, 1] φ = 0 lies at −(1 + 2p/δ); the error falls by the sum of that ellipse's axes, squared, a point."""
    z = 1.0 + 2.0 * 1.7 / WRAP
    rate = 2.0 * np.log(z + np.sqrt(z**2 - 1.0))
    found = errors("integral", "regular", "gauss-legendre")
    assert np.log(found[6] / found[12]) / 6.0 == pytest.approx(rate, rel=0.05)


def test_rules_without_an_answer_say_so(errors):
    assert set(errors("integral", "from-zero", "trapezoid").values()) == {float("inf")}


def test_galerkin_and_chebyshev_converge_faster_than_any_power(errors, order):
    for method in ("Galerkin, one element", "Chebyshev series"):
        found = errors("blade-modes", "blade", method)
        assert order(found, 12, 16) + 2.0 < order(found, 24, 32)


def test_the_string_is_off_by_twice_the_boundary_layer():
    """Each clamped end shortens the string by its layer, e/√S of the span with e = √(EI/F l²), S = 1 − V²."""
    (string,) = error_table("blade-modes", "tiny", method="string")
    second_order = 0.01
    assert string.error == pytest.approx(2.0 * 1e-4 / np.sqrt(0.75), rel=second_order)


def test_the_exponential_has_no_error_of_discretisation(errors):
    for case in press_transient.BELTS:
        (row,) = error_table("press-transient", case, method="exact")
        assert row.error < 1e-11
        assert row.evaluations == 0


def test_a_stiff_belt_takes_an_explicit_method_far_more_steps_at_every_tolerance():
    """Stability and not accuracy sets the step: the tolerance hardly changes the work."""
    settings = {(s.method, s.setting): s for s in STUDIES["press-transient"].case("stiff").settings()}
    rough, fine = (settings["dop853", f"tolerance {t}"].assess() for t in ("0.001", "1e-05"))
    assert fine.evaluations < 1.2 * rough.evaluations
    radau = settings["radau", "tolerance 0.0001"].assess()
    assert radau.evaluations < 0.1 * fine.evaluations
    assert radau.error < fine.error
