"""κ → 1: the wheels' inertia tension and the motion all but cancel; at κ = 1 no speed is critical."""

import math

import mpmath as mp
import numpy as np
import pytest
from hard_regime import Regime, once, relative
from hard_saw import beam_of_span_Hz, first_of_string_Hz

from ropefric.systems.bandsaw.beam import beam_frequencies_Hz
from ropefric.systems.bandsaw.span import CLAMPED, ENDS, PINNED, Span, string_frequencies_Hz

REGIME = Regime(
    name="κ → 1",
    statement="1 − κ = 1e-3 … 1e-16 and 0, v up to 1e6 m/s and to 1e-13 below the critical speed: the string's "
    "frequencies and the critical speed; a beam's at 35 … 1000 m/s",
    accuracy=1e-12,
)
BLADE = {"free_span_m": 1.6, "linear_density_kg_m": 0.5967, "preload_N": 3412.0, "pull_N": -105.475}
MOUNTINGS = [1.0 - 10.0**-k for k in range(3, 17)] + [1.0]


def running(kappa, v, **more):
    return Span(**BLADE, mounting_factor=kappa, wheel_speed_m_s=v, travel_speed_m_s=v, **more)


@once(REGIME)
def measured():
    errors = []
    with mp.workdps(60):
        length, m, F_0, pull = (mp.mpf(value) for value in BLADE.values())
        for kappa in MOUNTINGS:
            limit = float(Span(**BLADE, mounting_factor=kappa).critical_speed_m_s(PINNED)[0])
            if kappa < 1.0:
                errors.append(relative(limit, mp.sqrt((F_0 + pull) / m / (1 - mp.mpf(kappa)))))
            for v in {min(limit * (1.0 - shortfall), 1e6) for shortfall in (1e-2, 1e-9, 1e-13)} | {35.0}:
                c = mp.sqrt((F_0 + pull) / m + mp.mpf(kappa) * mp.mpf(v) ** 2)
                truth = first_of_string_Hz(c=c, v=mp.mpf(v), length=length)
                errors.append(relative(string_frequencies_Hz(running(kappa, v), 1)[0, 0], truth))
    for kappa in (1.0 - 1e-3, 1.0 - 1e-9, 1.0):
        for v in (35.0, 1000.0):
            span = running(kappa, v, bending_stiffness_N_m2=1.0637)
            found = beam_frequencies_Hz(span, CLAMPED, 1, accuracy=1e-13)[0, 0]
            errors.append(relative(found, beam_of_span_Hz(found, span, CLAMPED)))
    return max(errors)


def test_nothing_is_lost():
    assert measured() <= REGIME.accuracy


@pytest.mark.parametrize("ends", ENDS.values(), ids=list(ENDS))
def test_a_constant_force_has_no_critical_speed(ends):
    span = running(1.0, np.array([1.0, 1e3, 1e6, 1e9]), bending_stiffness_N_m2=1.0637)
    assert np.isinf(span.critical_speed_m_s(ends)).all()
    # What holds the string is F_0 ± ΔF/2 at any speed.
    np.testing.assert_allclose(span.net_tension_N, 3412.0 - 105.475, rtol=1e-15)


@pytest.mark.parametrize("k", [3, 9, 15])
def test_a_hair_below_one_has_a_critical_speed_and_above_it_is_refused(k, refused):
    kappa = 1.0 - 10.0**-k
    limit = math.sqrt((3412.0 - 105.475) / (0.5967 * (1.0 - kappa)))
    refused(
        lambda: string_frequencies_Hz(running(kappa, limit * (1.0 + 1e-9)), 1),
        f"its critical speed is {limit:.9g} m/s".replace("+", r"\+"),
    )


def test_a_mounting_beyond_constant_force_is_refused(refused):
    for kappa in (math.nextafter(1.0, 2.0), 2.0, math.nan):
        refused(
            lambda kappa=kappa: Span(**BLADE, mounting_factor=kappa),
            r"mounting_factor is .*from 0 \(fixed wheel axles\) to 1",
        )
