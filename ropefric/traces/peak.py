"""The height of one static peak, measured on the samples around it."""

from dataclasses import dataclass
from math import nan

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.traces.smoothing import average_over_samples, window_samples
from ropefric.traces.window import choose_window, peak_uncertainty_N, window_bias_N

LONGEST_WINDOW_S = 0.02
"""A window longer than a tooth is short would smooth the peak itself away [s]."""

STEPS_LOOKED_AT = 500
LONG_CLIMB = 200
JUMP = 0.05
NOISE_ABOVE_MEAN = 4.0
"""The highest of a few noisy samples is seldom more standard deviations above their mean."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Neighbourhood:
    """Where a peak lies, in samples, as the glance at the whole recording found it."""

    loading: int
    first: int
    stop: int
    fallen: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Peak:
    """One static peak; fields as in `Breakaway`."""

    peak_N: float
    peak_raw_N: float
    time_s: float
    std_N: float
    two_line_N: float
    bias_N: float
    window_s: float
    loading_rate_N_s: float


def measure_peak(
    time_s: FloatArray,
    force_N: FloatArray,
    where: Neighbourhood,
    *,
    noise_std_N: float,
    window_s: float | None = None,
) -> Peak:
    """Return the height of a static peak three ways: raw, smoothed, and as the corner of two lines."""
    step_s = _step_s(time_s, where)
    force_N = _without_outliers_at_the_top(time_s, force_N, where, noise_std_N)
    rate_N_s = _loading_rate_N_s(time_s, force_N, where)
    if window_s is None:
        longest = window_samples(
            choose_window(rate_N_s, noise_std_N, step_s, longest_s=LONGEST_WINDOW_S), step_s
        )
        n_window = _window_that_keeps_the_peak(force_N, where, longest, rate_N_s * step_s, noise_std_N)
    else:
        n_window = window_samples(window_s, step_s)
    index, peak_N = _smoothed_top(force_N, where, n_window)
    used_s = n_window * step_s
    return Peak(
        peak_N=peak_N,
        peak_raw_N=_raw_top_N(force_N, where, index, n_window),
        time_s=float(time_s[index]),
        std_N=peak_uncertainty_N(rate_N_s, noise_std_N, used_s, step_s),
        two_line_N=_corner_N(time_s, force_N, where, noise_std_N),
        bias_N=window_bias_N(rate_N_s, used_s, step_s),
        window_s=used_s if n_window > 1 else 0.0,
        loading_rate_N_s=rate_N_s,
    )


def _without_outliers_at_the_top(
    time_s: FloatArray, force_N: FloatArray, where: Neighbourhood, noise_std_N: float
) -> FloatArray:
    """Return the force with samples cut down that a well-sampled climb cannot have reached.

    Several spikes in the very moment of the slip look like no spike; but a rope that was loaded over hundreds of
    samples does not jump above the line of its loading.
    """
    if where.first - where.loading < LONG_CLIMB:
        return force_N
    climb = slice((where.loading + where.first) // 2, where.first)
    t0, f0, slope = _line(time_s[climb], force_N[climb])
    near = slice(where.first, where.stop)
    line_N = f0 + max(slope, 0.0) * (time_s[near] - t0)
    height_N = float(line_N[-1]) - float(force_N[where.loading])
    above = force_N[near] > line_N + max(10.0 * noise_std_N, JUMP * abs(height_N))
    if not above.any() or above.all():
        return force_N
    places = np.arange(where.first, where.stop)
    mended = force_N.copy()
    mended[places[above]] = np.interp(places[above], places[~above], force_N[near][~above])
    return mended


def _smoothed_top(force_N: FloatArray, where: Neighbourhood, n_window: int) -> tuple[int, float]:
    """Sample and height of the maximum of the smoothed force: up to half a window before the drop."""
    first = max(where.loading, where.first - n_window // 2)
    start = max(0, first - n_window)
    smoothed = average_over_samples(force_N[start : where.stop + n_window], n_window)
    smoothed = smoothed[first - start : where.stop - start]
    top = int(np.argmax(smoothed))
    return first + top, float(smoothed[top])


def _raw_top_N(force_N: FloatArray, where: Neighbourhood, index: int, n_window: int) -> float:
    return float(force_N[max(where.first, index - n_window) : min(where.stop, index + n_window + 1)].max())


def _window_that_keeps_the_peak(
    force_N: FloatArray, where: Neighbourhood, longest: int, rise_N: float, noise_std_N: float
) -> int:
    """Return the longest window, in samples, that lowers the peak by no more than ramp and noise explain.

    The ramp-and-drop model behind the choice of the window does not know how narrow a peak is.
    """
    n_window = longest
    while n_window > 1:
        index, peak_N = _smoothed_top(force_N, where, n_window)
        explained_N = max(rise_N, 0.0) * (n_window - 1) / 2 + NOISE_ABOVE_MEAN * noise_std_N
        if _raw_top_N(force_N, where, index, n_window) - peak_N <= explained_N:
            break
        n_window -= 2
    return n_window


def _step_s(time_s: FloatArray, where: Neighbourhood) -> float:
    around = time_s[max(where.loading, where.stop - STEPS_LOOKED_AT) : where.stop + 1]
    if around.size < 2:
        around = time_s
    return float(np.median(np.diff(around))) if around.size > 1 else 1.0


def _line(time_s: FloatArray, force_N: FloatArray) -> tuple[float, float, float]:
    """Least-squares line: mean time, mean force, slope."""
    t0, f0 = float(time_s.mean()), float(force_N.mean())
    dt = time_s - t0
    spread = float(dt @ dt)
    return t0, f0, float(dt @ (force_N - f0)) / spread if spread > 0 else 0.0


def _loading_rate_N_s(time_s: FloatArray, force_N: FloatArray, where: Neighbourhood) -> float:
    """Slope of the last half of the climb [N/s]; the first half may still bend."""
    top = where.first + int(np.argmax(force_N[where.first : where.stop]))
    first = min((where.loading + top) // 2, top - 1)
    if first < 0:
        return 0.0
    return _line(time_s[first : top + 1], force_N[first : top + 1])[2]


def _corner_N(time_s: FloatArray, force_N: FloatArray, where: Neighbourhood, noise_std_N: float) -> float:
    """Return the force where the line of the loading meets the line of the drop; NaN where either is too short.

    The loading line uses the last quarter of the climb (at least four samples) up to where the samples leave it;
    the drop line the samples on the way down. Where the drop happens between two samples, the corner lies half
    a step after the last one on the loading line.
    """
    top = where.first + int(np.argmax(force_N[where.first : where.stop]))
    fallen_N = float(force_N[where.fallen])
    height_N = float(force_N[top]) - fallen_N
    if height_N <= 4 * noise_std_N:
        return nan
    # The last sample that is still clearly up: beyond it the force only falls.
    up = np.flatnonzero(force_N[where.first : where.fallen + 1] > fallen_N + 0.75 * height_N)
    if up.size == 0:  # the drop is the last digit of the numbers
        return nan
    last = where.first + int(up[-1])
    first = min(top - 3, top - (top - where.loading) // 4)
    if first < where.loading:
        return nan
    t0, f0, slope = _line(time_s[first : top + 1], force_N[first : top + 1])
    going_down = force_N[last : where.fallen + 1]
    on_the_way = (going_down > fallen_N + 0.1 * height_N) & (going_down < fallen_N + 0.9 * height_N)
    steps = last + np.flatnonzero(on_the_way)
    if steps.size >= 2:
        t1, f1, fall = _line(time_s[steps], force_N[steps])
        if fall < min(0.0, slope) - 1e-12 * abs(slope):
            corner_s = (f1 - f0 + slope * t0 - fall * t1) / (slope - fall)
            if time_s[top] - 2 * (time_s[top] - time_s[first]) <= corner_s <= time_s[where.fallen]:
                return f0 + slope * (corner_s - t0)
    after = min(last + 1, time_s.size - 1)
    return f0 + slope * (0.5 * float(time_s[last] + time_s[after]) - t0)
