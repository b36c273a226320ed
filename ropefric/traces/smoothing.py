"""Centred moving average, with its window in seconds, honest edges and gaps.

The paper filters with the arithmetic mean (rope_wheel §2). Every average is taken in float64: on integer input
`scipy.ndimage.uniform_filter1d` answers with truncated integers, up to one count low.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.ndimage import uniform_filter1d

from ropefric.arrays import FloatArray, frozen_array
from ropefric.errors import InputError
from ropefric.shown import Shown
from ropefric.traces.trace import ForceTrace

_MOST_SAMPLES = 2**52
_PIECE = 2**22
_SUCH_AS = 'give a window such as "10 ms"'


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SmoothedForce(Shown):
    """A smoothed force and how it was smoothed.

    Attributes
    ----------
    time_s, force_N : ndarray, shape (n,)
        Time stamps [s] and averages [N]; NaN where a window holds no sample.
    window_s : float
        Full width of the window [s]; 0 = not smoothed.
    n_missing : int
        Samples missing in the trace (NaN).
    """

    _said = ("time_s", "force_N", "window_s", "n_missing")
    _framed = ("time_s", "force_N")

    time_s: FloatArray
    force_N: FloatArray
    window_s: float
    n_missing: int


def window_samples(window_s: float, step_s: float) -> int:
    """Return the odd number of samples that lie within half a window of their middle."""
    if not (0 <= window_s < np.inf and 0 < step_s < np.inf):
        why = f"a smoothing window of {window_s} s at a step of {step_s} s makes no sense"
        raise InputError(why, code="RF220", fix=_SUCH_AS)
    n_half = float(window_s) / float(step_s) / 2 if step_s >= 1e-300 else np.inf
    if not n_half < _MOST_SAMPLES:
        why = f"a smoothing window of {window_s:g} s holds too many steps of {step_s:g} s to be counted"
        raise InputError(why, code="RF220", fix=_SUCH_AS)
    return 2 * int(n_half + 1e-9) + 1


def average_over_samples(values: npt.ArrayLike, n_window: int) -> FloatArray:
    """Return the centred mean over `n_window` samples, an odd number.

    Near the ends the window shrinks on both sides alike, so a straight line stays a straight line up to its last
    sample; nothing is padded. Missing samples (NaN) are left out of the means.
    """
    values = np.asarray(values, dtype=np.float64)
    missing = np.isnan(values)
    if n_window == 1 or missing.all():
        return values.copy()
    if not missing.any():
        return _centred_mean(values, n_window)
    # The mean of what is there = smoothed values / smoothed presence; relative to a level, so that large common
    # offsets do not eat the digits.
    level = float(values[~missing][0])
    summed = _centred_mean(np.where(missing, 0.0, values - level), n_window)
    present = _centred_mean(np.where(missing, 0.0, 1.0), n_window)
    # Below half a sample's share, presence is only rounding of the running sum.
    empty = present < 0.5 / n_window
    result = np.full(values.shape, np.nan)
    np.divide(summed, present, out=result, where=~empty)
    return result + level


def _centred_mean(values: FloatArray, n_window: int) -> FloatArray:
    """Centred mean of finite values, the window shrinking symmetrically at the ends."""
    n = values.size
    half = min(n_window // 2, (n - 1) // 2)
    level = float(values[0])
    if not half:
        return values.copy()
    result = np.empty(n)
    # Piece by piece, so that a long recording needs no second copy and its running sum does not drift.
    piece = max(_PIECE, 8 * half)
    for first in range(0, n, piece):
        start = max(first - half, 0)
        shifted = values[start : first + piece + half] - level
        means = uniform_filter1d(shifted, 2 * half + 1, mode="nearest")
        result[first : first + piece] = means[first - start : first - start + piece]
    sizes = 2 * np.arange(half) + 1
    result[:half] = np.cumsum(values[: 2 * half] - level)[::2] / sizes
    result[n - half :] = (np.cumsum((values[n - 2 * half :] - level)[::-1])[::2] / sizes)[::-1]
    result += level
    return result


def average_over_time(time_s: FloatArray, values: FloatArray, window_s: float) -> FloatArray:
    """Return the centred mean over a time window, for samples at irregular times, which increase.

    A window that would reach beyond the first or last sample shrinks on both sides alike.
    """
    missing = np.isnan(values)
    if missing.all():
        return values.copy()
    half = np.minimum(window_s / 2, np.minimum(time_s - time_s[0], time_s[-1] - time_s))
    half *= 1 + 1e-9  # stamps that lie on the window's edge up to rounding belong to it
    level = float(values[~missing][0])
    first = np.searchsorted(time_s, time_s - half, side="left")
    stop = np.searchsorted(time_s, time_s + half, side="right")
    total = np.concatenate(([0.0], np.cumsum(np.where(missing, 0.0, values - level))))
    count = np.concatenate(([0], np.cumsum(~missing)))
    result = np.full(values.shape, np.nan)
    n_present = count[stop] - count[first]
    np.divide(total[stop] - total[first], n_present, out=result, where=n_present > 0)
    return result + level


def smooth(trace: ForceTrace, window_s: float) -> SmoothedForce:
    """Return a trace's force under a centred moving average."""
    n_missing = int(np.isnan(trace.force_N).sum())
    rate_Hz = trace.sampling_rate_Hz
    n_window = window_samples(window_s, 1.0 / rate_Hz) if rate_Hz else 1
    if n_window == 1:
        force_N, used_s = trace.force_N, 0.0
    elif is_uniform(trace.time_s):
        force_N, used_s = average_over_samples(trace.force_N, n_window), n_window / rate_Hz
    else:
        force_N, used_s = average_over_time(trace.time_s, trace.force_N, window_s), window_s
    return SmoothedForce(
        time_s=trace.time_s, force_N=frozen_array(force_N), window_s=used_s, n_missing=n_missing
    )


def is_uniform(time_s: FloatArray) -> bool:
    """Return whether no time step differs from the mean step by more than half of it."""
    if time_s.size < 3:
        return True
    steps_s = np.diff(time_s)
    mean_s = float(time_s[-1] - time_s[0]) / steps_s.size
    return bool(steps_s.max() < 1.5 * mean_s and steps_s.min() > 0.5 * mean_s)
