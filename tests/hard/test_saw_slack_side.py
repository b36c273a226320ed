"""F_0 − ΔF/2 → 0⁺: the slack side hangs by a hair; at zero and below it is refused by name."""

import math

import mpmath as mp
import pytest
from hard_regime import Regime, once, relative
from hard_saw import beam_of_span_Hz, first_of_string_Hz

from ropefric.systems.bandsaw.beam import beam_frequencies_Hz
from ropefric.systems.bandsaw.saw import Saw, Side, frequencies_Hz, span_of
from ropefric.systems.bandsaw.span import CLAMPED, Span, string_frequencies_Hz

REGIME = Regime(
    name="slack tension → 0⁺",
    statement="tension over preload of 1e-3 … 1e-15, at rest and at half the speed of its waves, the wheels' inertia "
    "in it or not: the frequencies of string and beam",
    accuracy=1e-12,
)
LENGTH, DENSITY, PRELOAD = 1.6, 0.5967, 3412.0


def truth_Hz(span):
    m, F_0, pull, kappa, w, v = (
        mp.mpf(float(getattr(span, name)[0]))
        for name in (
            "linear_density_kg_m", "preload_N", "pull_N", "mounting_factor", "wheel_speed_m_s",
            "travel_speed_m_s",
        )
    )  # fmt: skip
    c = mp.sqrt((F_0 + pull + kappa * m * w**2) / m)
    return first_of_string_Hz(c=c, v=v, length=mp.mpf(LENGTH))


def spans():
    """Yield spans whose tension is all but used up; the last kind by inertia that holds up a negative rest."""
    parts = {"free_span_m": LENGTH, "linear_density_kg_m": DENSITY}
    for k in range(3, 16):
        pull = -PRELOAD * (1.0 - 10.0**-k)
        wave = math.sqrt((PRELOAD + pull) / DENSITY)
        yield Span(**parts, preload_N=PRELOAD, pull_N=pull)
        yield Span(
            **parts, preload_N=PRELOAD, pull_N=pull, wheel_speed_m_s=0.5 * wave, travel_speed_m_s=0.5 * wave
        )
        yield Span(**parts, preload_N=PRELOAD, pull_N=pull, mounting_factor=0.9, wheel_speed_m_s=35.0)
        wheels = math.sqrt(900.1 * (1.0 + 10.0**-k) / DENSITY)
        yield Span(**parts, preload_N=100.0, pull_N=-1000.1, mounting_factor=1.0, wheel_speed_m_s=wheels)


@once(REGIME)
def measured():
    with mp.workdps(60):
        errors = [relative(string_frequencies_Hz(span, 1)[0, 0], truth_Hz(span)) for span in spans()]
    for k in (3, 9, 15):
        # As the tension goes, the stiffness takes over.
        span = Span(
            free_span_m=LENGTH,
            linear_density_kg_m=DENSITY,
            preload_N=PRELOAD,
            pull_N=-PRELOAD * (1.0 - 10.0**-k),
            bending_stiffness_N_m2=1.0637,
        )
        found = beam_frequencies_Hz(span, CLAMPED, 1, accuracy=1e-13)[0, 0]
        errors.append(relative(found, beam_of_span_Hz(found, span, CLAMPED)))
    return max(errors)


def test_nothing_is_lost():
    assert measured() <= REGIME.accuracy


@pytest.mark.parametrize("more", [0.0, 1e-15, 1e-3, 10.0])
def test_no_tension_is_refused_by_name(more, refused):
    pull = -math.nextafter(PRELOAD, math.inf) * (1.0 + more) if more else -PRELOAD
    refused(
        lambda: Span(free_span_m=LENGTH, linear_density_kg_m=DENSITY, preload_N=PRELOAD, pull_N=pull),
        "the tension is (-|0 N).*it must be positive: a slack blade is no string.*raise the preload above",
    )


def test_a_blade_that_only_inertia_tightens_holds_at_no_speed(refused):
    """At κ = 1 the wheels tighten it, but its own motion takes all of that."""
    parts = {"free_span_m": LENGTH, "linear_density_kg_m": DENSITY, "preload_N": 100.0, "pull_N": -1000.0}
    for kappa in (0.9, 1.0):
        span = Span(**parts, mounting_factor=kappa, wheel_speed_m_s=100.0, travel_speed_m_s=100.0)
        assert span.critical_speed_m_s(CLAMPED)[0] == 0.0
        refused(
            lambda span=span: string_frequencies_Hz(span, 1), "at 100 m/s and its critical speed is 0 m/s"
        )


@pytest.mark.parametrize("side", [Side.TIGHT, Side.REST])
def test_a_saw_that_pulls_twice_its_preload_has_a_tight_side_only(side, refused):
    saw = Saw(
        free_span_m=LENGTH,
        linear_density_kg_m=DENSITY,
        preload_N=PRELOAD,
        wheel_radius_m=0.35,
        wheel_speed_rad_s=50.0,
        tension_difference_N=2.0 * PRELOAD,
    )
    assert frequencies_Hz(saw, side, 1)[0, 0] > 0.0
    refused(lambda: span_of(saw, Side.SLACK), "the tension is 0 N .*a slack blade is no string")
