"""Which preload gives a mode a wanted frequency."""

import math
from dataclasses import replace

from scipy.optimize import brentq

from ropefric.errors import InputError
from ropefric.systems.bandsaw.saw import Saw, Side, frequencies_Hz


def preload_for_N(saw: Saw, side: Side, frequency_Hz: float, mode: int = 1) -> float:
    """Return the preload F_0 at which a mode of one side has a frequency, at the saw's speed [N].

    For a string c = a + √(a² + v²) with a = f l/n, from eq. (8), and F_0 = ρA c² ∓ ΔF/2 − κ ρA v². A stiff blade
    needs less, which is found by bracketing.
    """
    if not (math.isfinite(frequency_Hz) and frequency_Hz > 0.0):
        raise InputError(
            f"the frequency is {frequency_Hz:g} Hz; it must be finite and positive", key="frequency_Hz"
        )
    if mode < 1:
        raise InputError(f"the mode is {mode}; modes count from 1", key="mode")
    v = 0.0 if side is Side.REST else saw.speed_m_s
    a = frequency_Hz * saw.free_span_m / mode
    c = a + math.hypot(a, v)
    inertia_N = saw.linear_density_kg_m * v**2
    apart_N = 0.5 * side.sign * saw.tension_difference_N + saw.mounting_factor * inertia_N
    string_N = saw.linear_density_kg_m * c**2 - apart_N
    if saw.bending_stiffness_N_m2 == 0.0:
        return string_N

    # Without ΔF and κ in the way, the total tension is what is looked for; its sign is then the only limit.
    plain = replace(saw, tension_difference_N=0.0, mounting_factor=0.0)

    def surplus_Hz(total_N: float) -> float:
        found = frequencies_Hz(plain, side, mode, preload_N=total_N, accuracy=1e-12)
        return float(found[0, -1]) - frequency_Hz

    buckling_N = saw.ends.buckling * saw.bending_stiffness_N_m2 / saw.free_span_m**2
    lowest_N = max(inertia_N - buckling_N * (1.0 - 1e-9), 1e-6 * buckling_N)
    highest_N = string_N + apart_N
    if highest_N <= lowest_N or surplus_Hz(lowest_N) >= 0.0:
        raise InputError(
            f"mode {mode} of the {side} side has {frequency_Hz:g} Hz only below a tension of {lowest_N:.4g} N",
            key="frequency_Hz",
            fix="ask for a higher frequency or a lower mode",
        )
    return float(brentq(surplus_Hz, lowest_N, highest_N, xtol=1e-9 * highest_N, rtol=1e-12)) - apart_N
