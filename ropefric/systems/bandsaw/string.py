"""The blade as a string that travels along itself, eqs. (7)-(12)."""

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.bandsaw.ends import PINNED
from ropefric.systems.bandsaw.span import Span, refuse_overspeed


def running_mode(
    place_m: npt.ArrayLike,
    time_s: npt.ArrayLike,
    *,
    mode: int,
    free_span_m: float,
    wave_speed_m_s: float,
    speed_m_s: float,
) -> FloatArray:
    """Return the deflection of a running mode, sin(nπx/l) cos(2π f_n t + nπ v x/(l c)), with amplitude 1.

    The sum of a wave with the blade and one against it, w = ½ Σ ± sin(…), that vanishes at both ends. At rest it
    is a standing wave; on a running blade crests enter at one end and leave at the other.
    """
    x = np.atleast_1d(np.asarray(place_m, dtype=np.float64))
    t = np.atleast_1d(np.asarray(time_s, dtype=np.float64))
    f = float(frequency_Hz(mode, free_span_m, wave_speed_m_s, speed_m_s))
    if not ((x >= 0.0) & (x <= free_span_m)).all():
        raise InputError(f"a place lies outside the span from 0 to {free_span_m:g} m", key="place_m")
    share = x / free_span_m
    # sin(n pi) is not zero in floats; sin(n pi (1 - x/l)) is, there, and equal up to the sign.
    inner = np.minimum(share, 1.0 - share)
    sign = np.where((share > 0.5) & (mode % 2 == 0), -1.0, 1.0)
    envelope = sign * np.sin(mode * math.pi * inner)
    phase = 2.0 * math.pi * f * t[:, np.newaxis] + mode * math.pi * (speed_m_s / wave_speed_m_s) * share
    return np.asarray(envelope * np.cos(phase))


def frequency_Hz(
    mode: npt.ArrayLike,
    free_span_m: npt.ArrayLike,
    wave_speed_m_s: npt.ArrayLike,
    speed_m_s: npt.ArrayLike = 0.0,
) -> FloatArray:
    """Return f_n = n (c − v)(c + v)/(2 l c) [Hz], eq. (8); eq. (7) at rest."""
    n, length = _positive("mode", mode), _positive("free_span_m", free_span_m)
    c, v = _positive("wave_speed_m_s", wave_speed_m_s), np.asarray(speed_m_s, dtype=np.float64)
    slow, c_too = np.broadcast_arrays(np.abs(v) < c, c)
    if not slow.all():
        limit = c_too.ravel()[int(np.argmin(slow.ravel()))]
        raise InputError(
            f"the speed is not below the critical speed c = {limit:.9g} m/s, where the frequency is zero",
            code="RF530",
            key="speed_m_s",
            fix="run slower, or raise the tension",
        )
    return np.asarray(n * ((c - v) * (c + v)) / (2.0 * length * c))


def frequency_at_shortfall_Hz(
    mode: npt.ArrayLike, free_span_m: npt.ArrayLike, wave_speed_m_s: npt.ArrayLike, shortfall: npt.ArrayLike
) -> FloatArray:
    """Return the frequency at v = (1 − δ) c, f_n = n c δ (2 − δ)/(2 l) [Hz], as exact as δ is."""
    n, length = _positive("mode", mode), _positive("free_span_m", free_span_m)
    c, delta = _positive("wave_speed_m_s", wave_speed_m_s), _positive("shortfall", shortfall)
    if (delta >= 2.0).any():
        raise InputError("the shortfall is 2 or more: the blade runs backwards above its critical speed")
    return np.asarray(n * c * delta * (2.0 - delta) / (2.0 * length))


def wave_times_s(
    free_span_m: npt.ArrayLike, wave_speed_m_s: npt.ArrayLike, speed_m_s: npt.ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Return how long a wave takes along the span with the blade, l/(c + v), and against it, l/(c − v) [s].

    Their sum is the period of the first mode. Refusals are those of `frequency_Hz`.
    """
    frequency_Hz(1, free_span_m, wave_speed_m_s, speed_m_s)
    length, c, v = (np.asarray(value, dtype=np.float64) for value in (free_span_m, wave_speed_m_s, speed_m_s))
    return np.asarray(length / (c + v)), np.asarray(length / (c - v))


def string_frequencies_Hz(span: Span, n_modes: int = 6) -> FloatArray:
    """Return the first frequencies of spans as strings; a stiffness they have is left out.

    Written with the net tension, f_n = n (F − ρA v²)/(2 l √(F ρA)), which `Span` knows to full relative precision
    where F and ρA v² all but cancel, and for κ = 1, where they never do.
    """
    if n_modes < 1:
        raise InputError(f"{n_modes} modes were asked for", key="n_modes", fix="ask for 1 or more")
    limp = replace(span, bending_stiffness_N_m2=np.zeros(1)) if span.bending_stiffness_N_m2.any() else span
    net_N = refuse_overspeed(limp, PINNED)
    first = net_N / (2.0 * span.free_span_m * np.sqrt(span.tension_N * span.linear_density_kg_m))
    return np.asarray(first[:, np.newaxis] * np.arange(1.0, n_modes + 1.0))


def _positive(name: str, value: npt.ArrayLike) -> FloatArray:
    array = np.asarray(value, dtype=np.float64)
    fine = np.isfinite(array) & (array > 0.0)
    if not fine.all():
        raise InputError(
            f"{name} is {array[~fine].ravel()[0]:g}; it must be finite and positive",
            key=name,
            fix="correct this value",
        )
    return array
