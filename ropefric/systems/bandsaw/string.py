"""The blade as a string that travels along itself, eqs. (7)-(12)."""

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from ropefric.errors import InputError
from ropefric.friction.condition import FloatArray
from ropefric.systems.bandsaw.ends import PINNED
from ropefric.systems.bandsaw.span import Span, refuse_overspeed

__all__ = [
    "frequency_Hz",
    "frequency_at_shortfall_Hz",
    "running_mode",
    "string_frequencies_Hz",
    "wave_times_s",
]


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

    Parameters
    ----------
    place_m : array_like, shape (k,)
        Places x along the span [m], from 0 to l, x growing the way the blade runs for v > 0.
    time_s : array_like, shape (j,)
        Times [s].
    mode : int
        n = 1, 2, …
    free_span_m, wave_speed_m_s, speed_m_s : float
        l [m], c [m/s] and v [m/s], as in `frequency_Hz`.

    Returns
    -------
    ndarray, shape (j, k)
        Deflections, a row a frame of the film.

    Raises
    ------
    InputError
        If a place lies outside the span, or as `frequency_Hz`.

    Examples
    --------
    >>> blade = {"free_span_m": 1.6, "wave_speed_m_s": 75.6, "speed_m_s": 0.0}
    >>> frames = running_mode([0.0, 0.8, 1.6], [0.0, 0.01], mode=1, **blade)
    >>> frames.round(4).tolist()
    [[0.0, 1.0, 0.0], [0.0, 0.0863, 0.0]]
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
    """Return f_n = n (c − v)(c + v)/(2 l c) [Hz], eq. (8); eq. (7) at rest.

    Parameters
    ----------
    mode : array_like
        n = 1, 2, …
    free_span_m : array_like
        l [m], positive.
    wave_speed_m_s : array_like
        c = √(F/ρA) [m/s], positive.
    speed_m_s : array_like
        Speed of the blade v [m/s], below c in amount.

    Returns
    -------
    ndarray
        Frequencies with the broadcast shape. For v → c the difference c − v of two floats is exact, so the answer is
        as good as c and v are; where these are rounded themselves, give the shortfall instead.

    Raises
    ------
    InputError
        If an argument is outside its range.

    Examples
    --------
    >>> frequency_Hz([1, 2], 1.6, 75.6182, 35.5524).round(3).tolist()
    [18.407, 36.814]
    """
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
    """Return the frequency at v = (1 − δ) c, f_n = n c δ (2 − δ)/(2 l) [Hz], as exact as δ is.

    Parameters
    ----------
    mode, free_span_m, wave_speed_m_s : array_like
        As in `frequency_Hz`.
    shortfall : array_like
        δ = 1 − v/c [-], above 0, at rest 1.

    Raises
    ------
    InputError
        If an argument is outside its range.

    Examples
    --------
    >>> float(frequency_at_shortfall_Hz(1, 0.5, 80.0, 1e-14) / 1.6e-12)
    0.999999999999995
    """
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

    Examples
    --------
    >>> forward, backward = wave_times_s(1.6, 75.0, 35.0)
    >>> float(1 / (forward + backward)) == float(frequency_Hz(1, 1.6, 75.0, 35.0))
    True
    """
    frequency_Hz(1, free_span_m, wave_speed_m_s, speed_m_s)
    length, c, v = (np.asarray(value, dtype=np.float64) for value in (free_span_m, wave_speed_m_s, speed_m_s))
    return np.asarray(length / (c + v)), np.asarray(length / (c - v))


def string_frequencies_Hz(span: Span, n_modes: int = 6) -> FloatArray:
    """Return the first frequencies of spans as strings; a stiffness they have is left out.

    Written with the net tension, f_n = n (F − ρA v²)/(2 l √(F ρA)), which `Span` knows to full relative precision
    where F and ρA v² all but cancel, and for κ = 1, where they never do.

    Parameters
    ----------
    span : Span
        m cases.
    n_modes : int
        1 or more.

    Returns
    -------
    ndarray, shape (m, n_modes)
        Frequencies [Hz].

    Raises
    ------
    InputError
        If a blade travels at its critical speed or above, or `n_modes` is below 1.

    Examples
    --------
    >>> blade = Span(free_span_m=1.6, linear_density_kg_m=0.59670, preload_N=3412)
    >>> string_frequencies_Hz(blade, 2).round(4).tolist()
    [[23.6307, 47.2614]]
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
