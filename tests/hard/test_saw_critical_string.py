"""v → c⁻: a string's frequencies vanish and keep their digits; at c and above they are refused with its value."""

import math

import mpmath as mp
import pytest
from hard_regime import Regime, once, relative
from hard_saw import first_of_string_Hz

from ropefric.systems.bandsaw.saw import Saw, Side, frequencies_Hz
from ropefric.systems.bandsaw.span import PINNED, Span, string_frequencies_Hz

REGIME = Regime(
    name="v → c⁻, string",
    statement="1 − v/c = 1e-3 … 1e-15: frequencies from tension, mass, mounting and speed",
    accuracy=1e-14,
)
SHORTFALLS = [10.0**-k for k in range(3, 16)]
LENGTH = 1.6
BLADE = {"free_span_m": LENGTH, "linear_density_kg_m": 0.5967, "preload_N": 3412.0, "pull_N": -105.475}


def of_span(span):
    """Return f_1 of a span's own floats."""
    m, F_0, pull, kappa, w, v = (
        mp.mpf(float(getattr(span, name)[0]))
        for name in (
            "linear_density_kg_m", "preload_N", "pull_N", "mounting_factor", "wheel_speed_m_s",
            "travel_speed_m_s",
        )
    )  # fmt: skip
    c = mp.sqrt((F_0 + pull + kappa * m * w**2) / m)
    return first_of_string_Hz(c=c, v=v, length=mp.mpf(LENGTH))


def near_critical(kappa, shortfall):
    limit = float(Span(**BLADE, mounting_factor=kappa).critical_speed_m_s(PINNED)[0])
    v = limit * (1.0 - shortfall)
    return Span(**BLADE, mounting_factor=kappa, wheel_speed_m_s=v, travel_speed_m_s=v)


@once(REGIME)
def measured():
    errors = []
    with mp.workdps(60):
        for shortfall in SHORTFALLS:
            for kappa in (0.0, 0.3, 0.75):
                span = near_critical(kappa, shortfall)
                found = string_frequencies_Hz(span, 6)[0]
                errors += [
                    relative(hertz, n * of_span(span)) for n, hertz in zip(range(1, 7), found, strict=True)
                ]
    return max(errors)


def test_nothing_is_lost():
    assert measured() <= REGIME.accuracy


def test_the_last_speed_below_is_answered_and_the_next_is_refused_with_the_critical_speed(refused):
    """√(100/0.25) = 20 exactly."""
    blade = {"free_span_m": 1.0, "linear_density_kg_m": 0.25, "preload_N": 100.0}
    below = math.nextafter(20.0, 0.0)
    found = string_frequencies_Hz(Span(**blade, travel_speed_m_s=below), 1)[0, 0]
    with mp.workdps(60):
        truth = first_of_string_Hz(c=mp.mpf(20), v=mp.mpf(below), length=1)
    assert relative(found, truth) <= REGIME.accuracy
    for speed in (20.0, math.nextafter(20.0, 21.0), 1e3, 1e30, -20.0):
        refused(
            lambda speed=speed: string_frequencies_Hz(Span(**blade, travel_speed_m_s=speed), 1),
            "its critical speed is 20 m/s: there its first frequency is zero",
        )


@pytest.mark.parametrize("kappa", [0.0, 0.5, 0.99])
def test_a_saw_above_is_refused_with_the_critical_speed_of_its_mounting(kappa, refused):
    limit = math.sqrt((3412.0 - 105.475) / (0.5967 * (1.0 - kappa)))
    saw = Saw(
        free_span_m=LENGTH,
        linear_density_kg_m=0.5967,
        preload_N=3412.0,
        wheel_radius_m=0.35,
        wheel_speed_rad_s=limit * (1.0 + 1e-9) / 0.35,
        tension_difference_N=210.95,
        mounting_factor=kappa,
    )
    refused(lambda: frequencies_Hz(saw, Side.SLACK, 1), f"its critical speed is {limit:.9g} m/s")
    assert frequencies_Hz(saw, Side.TIGHT, 1)[0, 0] > 0.0
