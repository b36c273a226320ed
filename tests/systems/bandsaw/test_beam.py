"""The travelling beam: against printed values, another discretisation, closed forms; its limits are in tests/hard."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from paper import whole

from ropefric.accuracy.studies.blade_modes import chebyshev_frequencies
from ropefric.errors import InputError, SolverError
from ropefric.systems.bandsaw.answer import frequencies_Hz, span_of
from ropefric.systems.bandsaw.beam import (
    ScaledBeam,
    beam_frequencies_Hz,
    galerkin_modes,
    order_for,
    scaled_beams,
    solve_beam,
    waves_of,
    widths_for,
)
from ropefric.systems.bandsaw.saw import Side
from ropefric.systems.bandsaw.span import CLAMPED, ENDS, PINNED, Span, string_frequencies_Hz

# Scaled reference values: ends, V -> first two frequencies at eps² = 1e-2.
REFERENCE = {(PINNED, 0.0): (3.29297666427, 7.420503498402),
             (PINNED, 0.5): (2.647332317678, 6.567103155113),
             (CLAMPED, 0.0): (4.099316099897, 9.126431110071),
             (CLAMPED, 0.5): (3.445561083223, 8.337819919385)}  # fmt: skip
BOTH = pytest.mark.parametrize("ends", ENDS.values(), ids=list(ENDS))


@pytest.mark.parametrize("case", REFERENCE, ids=lambda case: f"{case[0].name}-{case[1]}")
def test_reference_values(case):
    ends, speed = case
    beam = ScaledBeam.at_speed(1e-2, speed, ends)
    for found in (solve_beam(beam, 2).frequencies, chebyshev_frequencies(beam, 40, 2)):
        np.testing.assert_allclose(found, REFERENCE[case], rtol=1e-12)


def test_closed_forms_at_rest():
    """Pinned ω² = (nπ)² + ε²(nπ)⁴; a clamped beam without tension has cos μ cosh μ = 1."""
    for stiffness in [1e-14, 1e-4, 1.0, 1e6]:
        n_pi = math.pi * np.arange(1, 7)
        pinned = solve_beam(ScaledBeam.at_speed(stiffness, 0.0, PINNED), accuracy=1e-13).frequencies
        np.testing.assert_allclose(pinned, n_pi * np.sqrt(1.0 + stiffness * n_pi**2), rtol=1e-13)
        if stiffness == 1e6:
            clamped = solve_beam(ScaledBeam.at_speed(stiffness, 0.0, CLAMPED), 3).frequencies
            mu = np.array([4.730040744862704, 7.853204624095838, 10.995607838001671])
            # The tension still has its share of 1e-6/40.
            np.testing.assert_allclose(clamped, 1e3 * mu**2, rtol=2e-8)


@BOTH
@settings(max_examples=8, deadline=None)
@given(log_stiffness=st.floats(-5, 0), speed=st.floats(0, 0.98))
def test_two_discretisations_agree(ends, log_stiffness, speed):
    beam = ScaledBeam.at_speed(10.0**log_stiffness, speed, ends)
    other = chebyshev_frequencies(beam, 120, 4)
    np.testing.assert_allclose(solve_beam(beam, 4).frequencies, other, rtol=2e-9)


@BOTH
def test_error_halves_with_the_expected_power(ends):
    """Polynomials of degree p, a fourth-order operator: h^2(p-1)."""
    beam = ScaledBeam.at_speed(1e-2, 0.5, ends)
    exact_ = solve_beam(beam, 3, accuracy=1e-13).frequencies
    for order, power in ((3, 4), (4, 6)):
        errors = [np.abs(galerkin_modes(beam, (1.0 / n,) * n, order, 3).frequencies / exact_ - 1.0)
                  for n in (16, 32)]  # fmt: skip
        np.testing.assert_allclose(np.log2(errors[0] / errors[1]), power, atol=0.12)


def test_clamped_at_rest_follows_its_expansion_to_third_order():
    """f_n = (n/2l) √(F/ρA) (1 + 2e + (4 + n²π²/2) e²) with e = √(EI/F l²); the error goes with e³."""
    parts = {"free_span_m": 1.6, "linear_density_kg_m": 0.5967, "preload_N": 3412.0}
    e = np.array([4e-3, 2e-3, 1e-3])
    span = Span(**parts, bending_stiffness_N_m2=e**2 * 3412.0 * 1.6**2)
    n, e = np.arange(1.0, 4.0), e[:, np.newaxis]
    expanded = string_frequencies_Hz(span, 3) * (1.0 + 2.0 * e + (4.0 + 0.5 * (n * np.pi) ** 2) * e**2)
    left = beam_frequencies_Hz(span, CLAMPED, 3, accuracy=1e-13) - expanded
    np.testing.assert_allclose(np.log2(left[:-1] / left[1:]), 3.0, atol=0.1)


@BOTH
def test_frequencies_fall_with_speed_and_rise_with_stiffness(saw, stiffness, ends):
    stiff = replace(saw, bending_stiffness_N_m2=stiffness, ends=ends)
    limit = float(span_of(whole(stiff), Side.SLACK).critical_speed_m_s(ends)[0])
    speeds = limit * np.array([0.0, 0.2, 0.6, 0.9, 0.99, 0.9999, 1 - 1e-8])
    found = frequencies_Hz(whole(stiff), Side.SLACK, 4, speed_m_s=speeds)
    assert (np.diff(found, axis=0) < 0).all()
    assert found[-1, 0] < 1e-3 * found[0, 0]
    slow = speeds[:4]
    assert (found[:4] > frequencies_Hz(whole(saw), Side.SLACK, 4, speed_m_s=slow)).all()
    with pytest.raises(InputError, match="critical speed is"):
        frequencies_Hz(whole(stiff), Side.SLACK, 4, speed_m_s=limit * (1 + 1e-9))


@BOTH
def test_critical_speeds_are_buckling_loads(ends):
    q = math.sqrt(ends.buckling)
    wanted = math.sin(q) if ends.turns else 2 - 2 * math.cos(q) - q * math.sin(q)
    assert wanted == pytest.approx(0.0, abs=1e-11)
    x = np.linspace(0, 1, 11)
    shape, slope, curvature = ends.buckled(x)
    assert abs(shape[[0, -1]]).max() < 1e-15
    assert abs((curvature if ends.turns else slope)[[0, -1]]).max() < 1e-14
    span = Span(free_span_m=2.0, linear_density_kg_m=0.5, preload_N=100.0, bending_stiffness_N_m2=3.0)
    speed = float(span.critical_speed_m_s(ends)[0])
    assert 0.5 * speed**2 == pytest.approx(100.0 + ends.buckling * 3.0 / 4.0, rel=1e-14)


def at_shortfall(stiffness, shortfall, ends):
    """Return the beam at V = (1 − δ) V_c, as exact as δ is."""
    limit_squared = 1.0 + ends.buckling * stiffness
    margin = limit_squared * shortfall * (2.0 - shortfall)
    speed = math.sqrt(limit_squared) * (1.0 - shortfall)
    net = margin - ends.buckling * stiffness
    return ScaledBeam(stiffness=stiffness, speed=speed, net=net, margin=margin, ends=ends)


@BOTH
@settings(max_examples=25, deadline=None)
@given(log_stiffness=st.floats(-12, 0), shortfall=st.floats(1e-6, 1), mode=st.integers(1, 8))
def test_the_waves_solve_the_dispersion_relation(ends, log_stiffness, shortfall, mode):
    beam = at_shortfall(10.0**log_stiffness, shortfall, ends)
    waves = waves_of(beam, mode)
    m = 0.5 * (waves.shortest - waves.longest)
    ks = np.array([waves.shortest, -waves.longest, -m + 1j * waves.layer_rate, -m - 1j * waves.layer_rate])
    _, _, second, third, fourth = np.poly(ks)
    assert second.real == pytest.approx(beam.net / beam.stiffness, rel=1e-6, abs=1e-6 * waves.shortest**2)
    omega_squared = -fourth.real * beam.stiffness
    if beam.speed > 1e-3:
        omega = -third.real * beam.stiffness / (2 * beam.speed)
        assert omega**2 == pytest.approx(omega_squared, rel=1e-5)


def test_strings_among_beams_and_the_scaled_form():
    parts = {"free_span_m": 1.6, "linear_density_kg_m": 0.5967, "preload_N": [3000.0, 3412.0, 4000.0],
             "travel_speed_m_s": [0.0, -35.0, 35.0]}  # fmt: skip
    mixed = Span(**parts, bending_stiffness_N_m2=[0.0, 1.06, 1.06])
    found = beam_frequencies_Hz(mixed, CLAMPED, 3)
    strings = string_frequencies_Hz(mixed, 3)
    np.testing.assert_array_equal(found[0], strings[0])
    assert (found[1:] > strings[1:]).all()
    forward = beam_frequencies_Hz(replace(mixed, travel_speed_m_s=[0.0, 35.0, 35.0]), CLAMPED, 3)
    np.testing.assert_allclose(found, forward, rtol=1e-14)
    beam = scaled_beams(mixed.select([2]), CLAMPED)[0]
    assert beam.net == pytest.approx(1 - beam.speed**2, rel=1e-14)
    assert beam.margin == pytest.approx(beam.net + CLAMPED.buckling * beam.stiffness, rel=1e-14)


@pytest.mark.parametrize("ends", [CLAMPED, pytest.param(PINNED, marks=pytest.mark.slow)])
def test_many_beams_are_read_off_between_a_few_and_each_is_what_it_is_alone(ends, monkeypatch):
    """Boxes of stiffness and speed from narrow to wide, up to the wave speed, at every accuracy a scene asks for."""
    calls, rng = [], np.random.default_rng(4)

    def counted(*given, **named):
        calls.append(given)
        return solve_beam(*given, **named)

    monkeypatch.setattr("ropefric.systems.bandsaw.beam.solve_beam", counted)
    between = 0
    for accuracy, width in [(2.5e-4, 3.0), (2.5e-6, 0.02), (2.5e-10, 0.01)]:
        for fast in (0.0, 0.4, 0.93):
            n = 60
            stiff = 10.0 ** rng.uniform(-6.0, 2.0) * np.exp(width * rng.random(n))
            fastest = min(fast * (1.0 + 0.1 * width), 0.99)
            parts = {"free_span_m": 1.0, "linear_density_kg_m": 1.0, "preload_N": 1.0}
            many = Span(**parts, bending_stiffness_N_m2=stiff, travel_speed_m_s=rng.uniform(fast, fastest, n))
            calls.clear()
            found = beam_frequencies_Hz(many, ends, 4, accuracy=accuracy)
            between += len(calls) < n
            for i in range(0, n, 29):
                alone = beam_frequencies_Hz(many.select([i]), ends, 4, accuracy=1e-2 * accuracy)[0]
                np.testing.assert_allclose(found[i], alone, rtol=2.0 * accuracy)
    assert between >= 4
    calls.clear()
    beam_frequencies_Hz(many.select(range(9)), ends, 4)
    assert len(calls) == 9, "of few each is solved"


def test_refusals():
    beam = ScaledBeam.at_speed(1e-2, 0.5, PINNED)
    with pytest.raises(SolverError, match="above 400"):
        order_for(beam, 600, 1e-6)
    with pytest.raises(InputError, match="16 or more"):
        chebyshev_frequencies(beam, 10, 6)


def drawn_beams(count, seed):
    """Beams from strings with thin layers to stiff ones, half of them near the critical speed, with what is asked."""
    rng = np.random.default_rng(seed)
    for one in range(count):
        ends, shortfall = ((PINNED, CLAMPED)[one % 2],
                           10.0 ** rng.uniform(-7, 0) if one % 4 < 2 else rng.random())  # fmt: skip
        asked = int(rng.choice([1, 2, 3, 6, 12])), float(rng.choice([2.5e-4, 1e-6, 1e-10]))
        yield at_shortfall(10.0 ** rng.uniform(-9, 0), shortfall, ends), *asked


def test_every_mode_is_as_accurate_as_its_own_estimate_says():
    """No mode of drawn beams uses half of the accuracy, against 14 orders more."""
    for beam, n_modes, accuracy in drawn_beams(12, 3):
        found = solve_beam(beam, n_modes, accuracy=accuracy)
        order = int(found.orders.max())
        wanted = galerkin_modes(beam, widths_for(beam, order), order + 14, n_modes).frequencies
        assert np.abs(found.frequencies / wanted - 1.0).max() < 0.5 * accuracy, beam


def test_the_estimate_of_a_mode_is_its_error():
    """Of the mode that errs most to a third; one that errs by next to nothing errs by three times that at most."""
    for beam, n_modes, _ in drawn_beams(8, 5):
        order = order_for(beam, n_modes, 1e-3)
        widths = widths_for(beam, order)
        rough = galerkin_modes(beam, widths, order, n_modes, 3)
        wanted = galerkin_modes(beam, widths, order + 14, n_modes).frequencies
        errors = rough.frequencies / wanted - 1.0
        assert rough.errors.max() == pytest.approx(errors.max(), rel=0.35)
        assert (rough.errors <= 1.05 * errors + 1e-12).all()
        assert (errors <= 3.0 * rough.errors + 1e-12).all()


def test_the_order_is_raised_for_the_modes_that_need_it_alone(monkeypatch):
    beam = ScaledBeam.at_speed(1e-4, 0.6, CLAMPED)
    wanted = solve_beam(beam, 8, accuracy=1e-12).frequencies
    monkeypatch.setattr("ropefric.systems.bandsaw.beam.order_for", lambda *_: 13)
    found = solve_beam(beam, 8, accuracy=1e-6)
    assert found.orders[0] == 13 < found.orders[-1]
    assert (np.diff(found.orders) >= 0).all()
    assert (found.errors <= 1e-6).all()
    assert not found.frequencies.flags.writeable
    np.testing.assert_allclose(found.frequencies, wanted, rtol=1e-6)
