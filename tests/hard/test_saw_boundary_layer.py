"""EI → 0: layers at the ends as thin as floats go; the string comes out with what they take of its length."""

import math
from dataclasses import replace

import mpmath as mp
import numpy as np
import pytest
from hard_regime import Regime, once, relative
from hard_saw import beam_frequencies

from ropefric.systems.bandsaw.beam import (
    ScaledBeam,
    beam_frequencies_Hz,
    galerkin_modes,
    order_for,
    solve_beam,
    widths_for,
)
from ropefric.systems.bandsaw.span import CLAMPED, ENDS, PINNED, Span, string_frequencies_Hz

REGIME = Regime(
    name="EI → 0",
    statement="EI/(F l²) = 1e-1 … 1e-14 against the characteristic equation, 1e-15 … 5e-324 against the string with "
    "what the layers add; v/c = 0, 0.47, 0.99, pinned and clamped",
    accuracy=1e-12,
)
SPEEDS = (0.0, 0.47, 0.99)
BOTH = pytest.mark.parametrize("ends", ENDS.values(), ids=list(ENDS))


def with_layers(mode, stiffness, speed, ends):
    """Return ω_n to second order in η = ε/√S.

    S n π (1 + 2η + (4 + n²π²(1 + 6V² + V⁴)/2) η²) clamped; pinned without the 2η and the 4. The inner wave numbers
    m ± q have q = nπ + arctan((q + 2m)/κ) + arctan((q − 2m)/κ) between clamps, with layers e^{−κx}, κ → 1/η.
    """
    V = mp.mpf(speed)
    S = 1 - V**2
    eta = mp.sqrt(mp.mpf(stiffness) / S)
    waves = (mode * mp.pi) ** 2 * (1 + 6 * V**2 + V**4) / 2
    turned = 0 if ends.turns else 2 * eta + 4 * eta**2
    return S * mode * mp.pi * (1 + turned + waves * eta**2)


@once(REGIME)
def measured():
    errors = []
    for ends in ENDS.values():
        for speed in SPEEDS:
            for stiffness in (1e-1, 1e-3, 1e-6, 1e-10, 1e-14):
                found = solve_beam(ScaledBeam.at_speed(stiffness, speed, ends), accuracy=1e-12).frequencies
                some = found[[0, 5]]
                truth = beam_frequencies(some, stiffness, ends, speed=speed)
                errors += [relative(*pair) for pair in zip(some, truth, strict=True)]
            # The third order is below 1e-14 from here on.
            for stiffness in (1e-15, 1e-18, 1e-24, 1e-40, 1e-160, 1e-300, 5e-324):
                found = solve_beam(ScaledBeam.at_speed(stiffness, speed, ends), accuracy=1e-12).frequencies
                with mp.workdps(60):
                    truth = [with_layers(n, stiffness, speed, ends) for n in range(1, 7)]
                errors += [relative(*pair) for pair in zip(found, truth, strict=True)]
    return max(errors)


def test_nothing_is_lost():
    assert measured() <= REGIME.accuracy


@BOTH
@pytest.mark.parametrize("stiffness", [1e-1, 1e-6, 1e-10])
@pytest.mark.parametrize("speed", SPEEDS)
def test_an_order_is_as_good_as_foreseen_and_no_waste(ends, stiffness, speed):
    """Down to a boundary layer of a hundred-thousandth of the span."""
    beam = ScaledBeam.at_speed(stiffness, speed, ends)
    wanted = solve_beam(beam, accuracy=1e-12).frequencies
    assert (np.diff(wanted) > 0.05 * wanted[0]).all()
    for accuracy in (1e-4, 1e-8):
        order = order_for(beam, 6, accuracy)
        found = galerkin_modes(beam, widths_for(beam, order), order, 6).frequencies
        assert np.abs(found / wanted - 1.0).max() < accuracy
        # It is no waste either: four orders less do not suffice, or the layout needs them.
        short = order - 4
        if len(widths_for(beam, short)) == len(widths_for(beam, order)) and short > 9:
            coarse = galerkin_modes(beam, widths_for(beam, short), short, 6).frequencies
            assert np.abs(coarse / wanted - 1.0).max() > accuracy


@BOTH
@pytest.mark.parametrize("speed", [0.0, 0.5, 0.9])
def test_the_string_with_its_layers_is_left_at_the_third_order(ends, speed):
    """What is left falls with ε³: −8 n²π²V²η³ between pins, which have ε⁴ at rest."""
    left = []
    for eps in (4e-4, 2e-4, 1e-4):
        beam = ScaledBeam.at_speed(eps**2, speed, ends)
        found = solve_beam(beam, 3, accuracy=1e-13).frequencies
        eta = eps / math.sqrt(1.0 - speed**2)
        with mp.workdps(30):
            truth = [with_layers(n, eps**2, speed, ends) for n in (1, 2, 3)]
            left.append([float(mp.mpf(float(w)) / t - 1) / eta**3 for w, t in zip(found, truth, strict=True)])
    pi_n = math.pi * np.arange(1, 4)
    if ends.turns:
        np.testing.assert_allclose(left[2], -8.0 * (speed * pi_n) ** 2, rtol=0.05, atol=0.2)
    else:
        np.testing.assert_allclose(left[1], left[0], rtol=0.05)
        np.testing.assert_allclose(left[2], left[1], rtol=0.05)


@BOTH
def test_a_blade_of_no_stiffness_is_the_string_to_the_last_bit(ends):
    parts = {"free_span_m": 1.6, "linear_density_kg_m": 0.5967, "preload_N": 3412.0, "travel_speed_m_s": 35.0}
    string = string_frequencies_Hz(Span(**parts), 6)
    np.testing.assert_array_equal(beam_frequencies_Hz(Span(**parts), ends, 6), string)
    faint = Span(**parts, bending_stiffness_N_m2=[1e-30, 1e-300])
    np.testing.assert_allclose(
        beam_frequencies_Hz(faint, ends, 6), np.repeat(string, 2, axis=0), rtol=REGIME.accuracy
    )


def test_no_stiffness_is_no_beam(refused):
    beam = ScaledBeam.at_speed(1e-6, 0.5, PINNED)
    for stiffness in (0.0, -1e-6, math.nan, math.inf):
        refused(
            lambda stiffness=stiffness: replace(beam, stiffness=stiffness),
            "the stiffness ratio is .*a blade without stiffness is a string",
        )
    for stiffness in (-1e-300, math.nan):
        refused(
            lambda stiffness=stiffness: Span(
                free_span_m=1.6,
                linear_density_kg_m=0.5967,
                preload_N=3412.0,
                bending_stiffness_N_m2=stiffness,
            ),
            "bending_stiffness_N_m2 is .* it must be finite and zero or more",
        )
    # What is left of it beside the tension is no float.
    nothing = Span(
        free_span_m=1.6, linear_density_kg_m=0.5967, preload_N=3412.0, bending_stiffness_N_m2=5e-324
    )
    refused(lambda: beam_frequencies_Hz(nothing, CLAMPED, 1), "a blade without stiffness is a string")
