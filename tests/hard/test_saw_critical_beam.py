"""v → v_c⁻: a stiff blade's first frequency vanishes with the root of the shortfall and keeps its digits."""

import math

import numpy as np
import pytest
from hard_regime import Regime, once, relative
from hard_saw import beam_frequencies, beam_of_span_Hz

from ropefric.systems.bandsaw.beam import ScaledBeam, beam_frequencies_Hz, solve_beam
from ropefric.systems.bandsaw.span import CLAMPED, ENDS, Span

REGIME = Regime(
    name="v → v_c⁻, beam",
    statement="1 − v/v_c = 1e-3 … 1e-15, EI/(F l²) = 1 … 1e-10, pinned and clamped: the frequencies, from scaled "
    "numbers and from newtons and metres",
    accuracy=1e-12,
)
SHORTFALLS = [10.0**-k for k in range(3, 16)]
STIFFNESSES = (1.0, 1e-2, 1e-6, 1e-10)
BLADE = {
    "free_span_m": 1.6,
    "linear_density_kg_m": 0.5967,
    "preload_N": 3412.0,
    "bending_stiffness_N_m2": 1.0637,
}
BOTH = pytest.mark.parametrize("ends", ENDS.values(), ids=list(ENDS))


def at_shortfall(stiffness, shortfall, ends):
    """Return the beam at V = (1 − δ) V_c, as exact as δ is."""
    limit_squared = 1.0 + ends.buckling * stiffness
    margin = limit_squared * shortfall * (2.0 - shortfall)
    speed = math.sqrt(limit_squared) * (1.0 - shortfall)
    net = margin - ends.buckling * stiffness
    return ScaledBeam(stiffness=stiffness, speed=speed, net=net, margin=margin, ends=ends)


@once(REGIME)
def measured():
    errors = []
    # Every shortfall and every stiffness for both ends, not all of their product.
    for number, shortfall in enumerate(SHORTFALLS):
        stiffness = STIFFNESSES[number % len(STIFFNESSES)]
        for ends in ENDS.values():
            beam = at_shortfall(stiffness, shortfall, ends)
            found = solve_beam(beam, 2, accuracy=1e-12).frequencies
            truth = beam_frequencies(found, stiffness, ends, shortfall=shortfall)
            errors += [relative(*pair) for pair in zip(found, truth, strict=True)]
    for kappa in (0.0, 0.5):
        for shortfall in (1e-3, 1e-9, 1e-12):
            v = float(Span(**BLADE, mounting_factor=kappa).critical_speed_m_s(CLAMPED)[0]) * (1 - shortfall)
            span = Span(**BLADE, mounting_factor=kappa, wheel_speed_m_s=v, travel_speed_m_s=v)
            found = beam_frequencies_Hz(span, CLAMPED, 1, accuracy=1e-13)[0, 0]
            errors.append(relative(found, beam_of_span_Hz(found, span, CLAMPED)))
    return max(errors)


def test_nothing_is_lost():
    assert measured() <= REGIME.accuracy


@BOTH
def test_the_first_frequency_vanishes_with_the_root_of_the_margin(ends):
    """ω² (m + gᵀK⁻¹g) = margin · k for the buckling mode, whose inertia the gyroscopic forces only raise."""
    rates = [
        solve_beam(at_shortfall(1e-3, shortfall, ends), 1).frequencies[0] / math.sqrt(shortfall)
        for shortfall in (1e-8, 1e-11, 1e-14)
    ]
    np.testing.assert_allclose(rates[1:], rates[:-1], rtol=1e-4)
    np.testing.assert_allclose(rates[2], rates[1], rtol=1e-7)


@BOTH
@pytest.mark.parametrize("above", [0.0, 1e-12, 1e-3, 10.0])
def test_at_the_critical_speed_and_above_it_is_refused_with_its_value(ends, above, refused):
    limit = math.sqrt((3412.0 + ends.buckling * 1.0637 / 1.6**2) / 0.5967)
    span = Span(**BLADE, travel_speed_m_s=limit * (1.0 + above) * (1.0 + 1e-15))
    refused(lambda: beam_frequencies_Hz(span, ends, 1), f"its critical speed is {limit:.9g} m/s")
    scaled = math.sqrt(1.0 + ends.buckling * 1e-2)
    refused(
        lambda: ScaledBeam.at_speed(1e-2, scaled * (1.0 + above) * (1.0 + 1e-15), ends),
        f"not below the critical {scaled:.9g}",
    )
