"""The shape of a running mode, whose phase travels along the span: what shakes and wobbles before the eye."""

import math

import numpy as np
import numpy.typing as npt

from ropefric.errors import InputError
from ropefric.friction.condition import FloatArray
from ropefric.systems.bandsaw.string import frequency_Hz

__all__ = ["running_mode"]


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
