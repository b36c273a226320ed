"""The travelling string: against 50 digits, its tendencies, its waves, its refusals; tests/hard has its limits."""

from dataclasses import replace

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from paper import whole

from ropefric.errors import InputError
from ropefric.systems.bandsaw.answer import frequencies_Hz, span_of, torsion_frequencies_Hz
from ropefric.systems.bandsaw.saw import (
    STEEL_85_09,
    Section,
    Side,
    tension_difference_N,
    torque_N_m,
)
from ropefric.systems.bandsaw.span import CLAMPED, PINNED, Pair, Span, string_frequencies_Hz


def exact_hz(span, case=0):
    """f_1 of a span's own floats, to 50 digits."""
    with mpmath.workdps(50):
        parts = "free_span_m linear_density_kg_m preload_N pull_N mounting_factor wheel_speed_m_s travel_speed_m_s"
        length, m, F_0, pull, kappa, w, v = (
            mpmath.mpf(float(getattr(span, name)[case])) for name in parts.split()
        )
        F = F_0 + pull + kappa * m * w**2
        return float((F - m * v**2) / (2 * length * mpmath.sqrt(F * m)))


@settings(max_examples=40, deadline=None)
@given(preload=st.floats(100, 1e5), pull=st.floats(-0.4, 0.4), kappa=st.floats(0, 1),
       share=st.floats(0, 0.999), density=st.floats(0.05, 5), more=st.floats(1.001, 4))  # fmt: skip
def test_scaling_and_tendencies(*, preload, pull, kappa, share, density, more):
    parts = {"free_span_m": 1.3, "linear_density_kg_m": density, "preload_N": preload,
             "pull_N": pull * preload, "mounting_factor": kappa}  # fmt: skip
    limit = min(float(Span(**parts).critical_speed_m_s(PINNED)[0]), 1e3)
    speed = share * limit

    def first(speed=speed, **changed):
        running = {"wheel_speed_m_s": speed, "travel_speed_m_s": speed}
        return string_frequencies_Hz(Span(**(parts | running | changed)), 1)[0, 0]

    f = first()
    assert f == pytest.approx(
        exact_hz(Span(**parts, wheel_speed_m_s=speed, travel_speed_m_s=speed)), rel=2e-15
    )
    assert first(free_span_m=1.3 * more) == pytest.approx(f / more, rel=1e-14)
    # All forces times k², all speeds times k: frequencies times k.
    scaled = first(speed=more * speed, preload_N=more**2 * preload, pull_N=more**2 * pull * preload)
    assert scaled == pytest.approx(more * f, rel=1e-11 / (1 - share))
    assert first(preload_N=more * preload) > f
    assert first(speed=0.9 * speed) >= f
    assert first(mounting_factor=0.5 + 0.5 * kappa) >= f


def test_wheels_pressed_apart_with_a_constant_force_have_no_critical_speed(saw):
    free = replace(saw, mounting_factor=1.0)
    assert np.isinf(span_of(whole(free), Side.SLACK).critical_speed_m_s(CLAMPED)).all()
    assert (np.diff(frequencies_Hz(whole(free), Side.SLACK, 1, speed_m_s=[0, 50, 500, 5e4])[:, 0]) < 0).all()


def test_torsion_falls_to_zero_at_its_own_critical_speed():
    parts = {"free_span_m": 1.6, "linear_density_kg_m": STEEL_85_09.linear_density_kg_m, "preload_N": 3412.0}
    # At rest a wave goes there and back at this speed.
    limit = 2.0 * 1.6 * torsion_frequencies_Hz(Span(**parts), STEEL_85_09, 1)[0, 0]
    assert limit > float(Span(**parts).critical_speed_m_s(CLAMPED)[0])
    found = torsion_frequencies_Hz(
        Span(**parts, travel_speed_m_s=[0.0, 80.0, 0.999999 * limit]), STEEL_85_09, 2
    )
    assert (np.diff(found[:, 0]) < 0).all()
    assert found[2, 0] == pytest.approx(2e-6 * found[0, 0], rel=1e-5)
    np.testing.assert_allclose(found[:, 1], 2 * found[:, 0], rtol=1e-15)
    # A strip as thin as paper twists at the string's frequency: nothing but the tension holds it.
    paper = Section(width_m=0.085, thickness_m=1e-7)
    assert torsion_frequencies_Hz(Span(**parts), paper, 1)[0, 0] == pytest.approx(
        string_frequencies_Hz(Span(**parts), 1)[0, 0], rel=1e-7
    )
    with pytest.raises(InputError, match=f"critical speed of torsion is {limit:.6g}"[:38]):
        torsion_frequencies_Hz(Span(**parts, travel_speed_m_s=102.0), STEEL_85_09)


GOOD = {"free_span_m": 1.6, "linear_density_kg_m": 0.5967, "preload_N": 3412.0}


def test_a_span_refuses():
    for changed, words in [
        ({"free_span_m": 0.0}, "free_span_m is 0; it must be finite and positive"),
        ({"linear_density_kg_m": -1.0}, "linear_density_kg_m is -1"),
        ({"mounting_factor": 1.2}, "mounting_factor is 1.2; it must be from 0 to 1"),
        ({"mounting_factor": -0.1}, "mounting_factor is -0.1"),
        ({"travel_speed_m_s": np.nan}, "travel_speed_m_s is nan"),
        ({"bending_stiffness_N_m2": -1.0}, "bending_stiffness_N_m2 is -1"),
        ({"pull_N": -3412.0}, "the tension is 0 N .* raise the preload above 3412 N"),
        ({"pull_N": [0.0, -5000.0]}, "the tension is -1588 N .* at case 1"),
        ({"pull_N": [0.0, 1.0], "preload_N": [1.0, 2.0, 3.0]}, "pull_N has 2"),
        ({"preload_N": [[1.0]]}, "2 axes"),
    ]:
        with pytest.raises(InputError, match=words):
            Span(**(GOOD | changed))


def test_refusals_name_the_critical_speed(saw):
    c = float(Span(**GOOD).wave_speed_m_s[0])
    with pytest.raises(InputError, match=f"its critical speed is {c:.9g} m/s at case 1"):
        string_frequencies_Hz(Span(**GOOD, travel_speed_m_s=[10.0, c * 1.001]))
    half = replace(saw, mounting_factor=0.75)
    limit = float(span_of(whole(half), Side.SLACK).critical_speed_m_s(PINNED)[0])
    assert limit == pytest.approx(2 * 74.4401, abs=1e-3)
    assert frequencies_Hz(whole(half), Side.SLACK, 1, speed_m_s=0.999 * limit)[0, 0] > 0
    with pytest.raises(InputError, match=f"critical speed is {limit:.9g} m/s"):
        frequencies_Hz(whole(half), Side.SLACK, 1, speed_m_s=1.001 * limit)


def test_functions_refuse():
    for call, words in [(lambda: torque_N_m(7500.0, 0.0), "wheel_speed_rad_s is 0"),
                        (lambda: torque_N_m(-1.0, 1.0), "power_W is -1"),
                        (lambda: tension_difference_N(1.0, 0.0), "wheel_radius_m is 0"),
                        (lambda: Section(width_m=0.001, thickness_m=0.1), "0.1 m thick"),
                        (lambda: Section(width_m=0.0, thickness_m=0.1), "width_m is 0")]:  # fmt: skip
        with pytest.raises(InputError, match=words):
            call()


@settings(max_examples=60, deadline=None)
@given(st.floats(-1e8, 1e8), st.floats(-1e8, 1e8), st.floats(-1e8, 1e8))
def test_pairs_hold_32_digits(a, b, c):
    # Products below 1e-290 are outside what pairs promise.
    a, b, c = (0.0 if abs(x) < 1e-90 else x for x in (a, b, c))
    with mpmath.workdps(60):
        wanted = mpmath.mpf(a) * mpmath.mpf(b) * mpmath.mpf(c) - mpmath.mpf(a)
        found = Pair(a) * Pair(b) * Pair(c) - Pair(a)
        size = abs(mpmath.mpf(a) * mpmath.mpf(b) * mpmath.mpf(c)) + abs(a)
        error = abs(mpmath.mpf(float(found.high)) + mpmath.mpf(float(found.low)) - wanted)
        assert error <= size * mpmath.mpf(2) ** -98
    assert float(found.total()) == float(found.high)
