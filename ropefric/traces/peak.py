"""The height of one static peak, measured on the samples around it: raw and smoothed.

The smoothing window is the one whose bias on a ramp, against the noise it leaves, is smallest.
"""

import math
from dataclasses import replace
from math import nan
from typing import NamedTuple

import numpy as np

from ropefric.arrays import FloatArray, median
from ropefric.traces.breakaway import Breakaway, PickSettings, Status
from ropefric.traces.clock import GAP_STEPS
from ropefric.traces.segments import TINY, Prepared, Sliding, half_climb, kinetic, phases_of
from ropefric.traces.smoothing import average_over_samples, window_samples

LONGEST_WINDOW_S = 0.02
"""A window longer than a tooth is short would smooth the peak itself away [s]."""

LONGEST_WINDOW = 0.02
"""The same as a part of the upper half of the climb, for slow recordings."""
SHORTEST_TOP, FEWEST_ON_A_LINE, FEWEST_BELOW_A_TOP, SPARSE = 8, 3, 5, 0.005
"""Between two samples of a sparse recording the force climbs by more than the last part of F_A."""
TOP_SIGMAS = 10.0
"""Rise of the climb, in standard deviations of the noise, over which the slope at a top is read."""

JUMPED, JUMP = 3.0, 0.1
"""A part that is this many times steeper than the climb before it, and this share of its upper half, is another load."""

STEPS_LOOKED_AT = 500
NOISE_ABOVE_MEAN = 4.0
"""The highest of a few noisy samples is seldom more standard deviations above their mean."""
EARLY_SIGMAS, LONGEST_EARLY_S = 4.0, 0.1
"""The highest sample precedes the top by at most the time of a climb by this much noise, and at most this time [s]."""
FEWEST_WINDOWS, PUSHED = 8, 20.0
ROUND = 0.2
"""Ratio by which the slope at the very top may be smaller than that of the last stretch, without a bend."""
# The largest of values with noise 1 that lie on a slope of 10^x from one to the next: how far it lies above the top, and
# its standard deviation, from the product of their distribution functions.
_APART = (-2.0, -1.523, -1.0, -0.523, -0.222, 0.0, 0.176, 0.301, 0.477, 0.699)
_MEAN_OF_MAXIMUM = (2.128, 1.715, 1.210, 0.718, 0.418, 0.226, 0.108, 0.049, 0.007, 0.0)
_STD_OF_MAXIMUM = (0.443, 0.496, 0.577, 0.684, 0.771, 0.845, 0.906, 0.946, 0.987, 1.0)


class Neighbourhood(NamedTuple):
    """Where a peak lies, in samples: where the climb begins, and from where up to `stop` the peak itself."""

    loading: int
    first: int
    stop: int


def peak_result(
    prepared: Prepared,
    settings: PickSettings,
    block: int,
    *,
    start: int,
    fallen: int,
    sliding: Sliding | None,
) -> Breakaway:
    """Return the result `ok` for the peak at a block whose climb begins after a start, with what was met on the way."""
    blocks, n = prepared.blocks, prepared.force_N.size
    where = Neighbourhood(
        loading=blocks.first_sample(half_climb(blocks.force_N, block, start)),
        first=blocks.first_sample(block - 1),
        stop=blocks.last_sample(min(fallen - 1, block + 1), n) + 1 if fallen > block else n,
    )
    peak = measure_peak(
        prepared.time_s,
        prepared.force_N,
        where,
        noise_std_N=prepared.noise_N,
        window_s=settings.window_s,
        n_rest=blocks.n_rest,
    )
    kinetic_N, kinetic_std_N = kinetic(prepared, sliding)
    phases = phases_of(prepared, block, sliding)
    trough_N = float(blocks.force_N[block : fallen + 2].min()) if sliding else nan
    block_s = float(blocks.time_s[-1] - blocks.time_s[0]) / max(1, blocks.time_s.size - 1)
    notes = [*prepared.notes]
    std_N = math.hypot(peak.peak_std_N, hidden_by_steps_N(blocks.resolution_N, prepared.noise_N))
    gap_s, _ = gap_beside(prepared.time_s, peak)
    if gap_s:
        notes.append(
            f"there is a gap of {1000 * gap_s:.3g} ms in the samples next to the peak: the force may have been "
            "higher in it"
        )
        # It may have climbed on at its rate, but hardly by more than the whole step to the sliding force.
        missed_N = max(peak.loading_rate_N_s, 0.0) * gap_s
        if np.isfinite(kinetic_N):
            missed_N = min(missed_N, max(peak.peak_N - kinetic_N, 0.0))
        std_N = float(np.hypot(std_N, missed_N / np.sqrt(3.0)))
    return replace(
        peak,
        detail=""
        if sliding
        else "the force falls away after the peak: no sliding phase, kinetic force unknown",
        peak_std_N=std_N,
        kinetic_N=kinetic_N,
        kinetic_std_N=kinetic_std_N,
        dwell_s=next((phase.end_s - phase.start_s for phase in phases if phase.name == "idle"), nan),
        kinetic_s=(sliding.stop - sliding.first) * block_s if sliding else nan,
        drop_N=peak.peak_N - trough_N,
        trough_N=trough_N,
        phases=phases,
        notes=tuple(notes),
    )


def gap_beside(time_s: FloatArray, peak: Breakaway, first: int | None = None) -> tuple[float, int]:
    """Return the length of a gap in the samples next to a peak or the end of its window [s], and the sample before it.

    The length is 0 without a gap. Samples are next to a peak from `first` on, or two before it.
    """
    index = int(np.searchsorted(time_s, peak.peak_time_s))
    usual_s = np.median(np.diff(time_s[max(0, index - 250) : index + 250]))
    early_s = min(LONGEST_EARLY_S, EARLY_SIGMAS * peak.noise_std_N / max(TINY, peak.loading_rate_N_s))
    half = round((0.5 * peak.window_s + early_s) / max(usual_s, TINY))
    first = min(max(0, index - 2), index if first is None else first)
    steps_s = np.diff(time_s[first : index + half + 4], append=-np.inf)
    at = int(np.argmax(steps_s))
    return (float(steps_s[at]) if steps_s[at] > GAP_STEPS * usual_s else 0.0), first + at


def measure_peak(
    time_s: FloatArray,
    force_N: FloatArray,
    where: Neighbourhood,
    *,
    noise_std_N: float,
    window_s: float | None = None,
    n_rest: int = 0,
) -> Breakaway:
    """Return the height of a static peak, raw and smoothed."""
    around = time_s[max(where.loading, where.stop - STEPS_LOOKED_AT) : where.stop + 1]
    around = time_s if around.size < 2 else around
    step_s = float(np.median(np.diff(around))) if around.size > 1 else 1.0
    top = where.first + int(np.argmax(force_N[where.first : where.stop]))
    # The slope of the last half of the climb; the first half may still bend.
    first = max(min((where.loading + top) // 2, top - 1), 0)
    rate_N_s = line_through(time_s[first : top + 1], force_N[first : top + 1])[2]
    # A weight that is hung on, or a jerk, rises in no time after a long rest.
    rise_N = max(TOP_SIGMAS * noise_std_N, JUMP * float(np.ptp(force_N[min(where.loading, top) : top + 1])))
    begins = first + _last_rise(force_N[first : top + 1], rise_N)
    steep_N_s = line_through(time_s[begins : top + 1], force_N[begins : top + 1])[2]
    below = float(force_N[first : begins + 1].max()) < float(force_N[top]) - 0.5 * rise_N
    if below and steep_N_s > JUMPED * max(rate_N_s, 0.0):
        first, rate_N_s, where = begins, steep_N_s, where._replace(loading=max(begins, where.loading))
    top_rate_N_s = _rate_at_the_top(time_s[first : top + 1], force_N[first : top + 1], rate_N_s, noise_std_N)
    if window_s is None:
        climb_s = float(time_s[top] - time_s[min(where.loading, top)])
        longest_s = choose_window(
            top_rate_N_s,
            noise_std_N,
            step_s,
            longest_s=min(max(LONGEST_WINDOW_S, LONGEST_WINDOW * climb_s), max(climb_s, step_s)),
        )
        longest, rise_N = window_samples(longest_s, step_s), top_rate_N_s * step_s
        n_window = _window_that_keeps_the_peak(force_N, where, longest, rise_N, noise_std_N)
    else:
        n_window = window_samples(window_s, step_s)
    index, peak_N = _smoothed_top(force_N, where, n_window)
    used_s = n_window * step_s
    noise_N = _smoothed_noise_N(force_N[:n_rest], noise_std_N, n_window)
    above_N, std_N = _of_a_maximum_N(
        (rate_N_s * step_s, top_rate_N_s * step_s),
        noise_std_N / math.sqrt(n_window),
        noise_N,
        n_window,
        is_line=n_window == 1
        and top - where.loading >= FEWEST_BELOW_A_TOP
        and rate_N_s * step_s > SPARSE * peak_N,
    )
    if window_s is not None:  # what was asked for is given
        above_N, std_N = 0.0, math.hypot(std_N, above_N)
    return Breakaway(
        status=Status.OK,
        peak_N=peak_N - above_N,
        peak_raw_N=_raw_top_N(force_N, where, index, n_window),
        peak_time_s=float(time_s[index]),
        peak_std_N=std_N,
        bias_N=window_bias_N(rate_N_s, used_s, step_s),
        window_s=used_s if n_window > 1 else 0.0,
        noise_std_N=noise_std_N,
        loading_rate_N_s=rate_N_s,
    )


def _last_rise(force_N: FloatArray, rise_N: float) -> int:
    """Return the index from which a force rises by this much to its last sample, or the first one."""
    below = np.flatnonzero(force_N < force_N[-1] - rise_N)
    return int(below[-1]) if below.size else 0


def _rate_at_the_top(time_s: FloatArray, force_N: FloatArray, rate_N_s: float, noise_std_N: float) -> float:
    """Return the slope right before a top [N/s]: less than that of the climb where slip begins little by little."""
    if rate_N_s <= 0.0 or time_s.size < 2 * SHORTEST_TOP:
        return max(rate_N_s, 0.0)
    last_s = time_s[-1] - TOP_SIGMAS * noise_std_N / rate_N_s
    n = int(np.clip(time_s.size - np.searchsorted(time_s, last_s), FEWEST_ON_A_LINE, time_s.size))
    return min(max(line_through(time_s[-n:], force_N[-n:])[2], 0.0), rate_N_s)


def _smoothed_noise_N(rest_N: FloatArray, noise_std_N: float, n_window: int) -> float:
    """Return the noise a moving average leaves: what it leaves of a rope at rest, where hum and slow noise remain."""
    white_N = noise_std_N / math.sqrt(n_window)
    if rest_N.size < FEWEST_WINDOWS * n_window:
        return white_N
    smoothed = average_over_samples(rest_N, n_window)
    x = np.arange(smoothed.size) - 0.5 * (smoothed.size - 1)
    flat = smoothed - smoothed.mean() - x * float(x @ smoothed) / float(x @ x)
    # What pushes on the rope meanwhile is no noise.
    return max(white_N, float(flat[np.abs(flat) <= PUSHED * median(np.abs(flat))].std()))


def _of_a_maximum_N(
    rises_N: tuple[float, float], white_N: float, noise_N: float, n_window: int, *, is_line: bool
) -> tuple[float, float]:
    """Return how far the maximum of a smoothed ramp that ends in a fall lies above its top, and its uncertainty [N].

    The maximum of noisy values lies above that of their means, for noise that changes along the top; the window and the
    time since the last sample put it below, but less where the top is rounder than the stretch that leads to it: the
    more the climb bends, the rounder. The middle of the two is taken off where it lies above, or where the samples are
    sparse and the climb is known as a line; the rest is uncertain.
    """
    climb_N, rise_N = (max(rise, 0.0) for rise in rises_N)
    if white_N <= 0.0 and not is_line:
        return 0.0, rise_N * math.sqrt(n_window**2 / 4.0 + 1.0 / 12.0)
    bends = rise_N / climb_N if climb_N > 0.0 else 1.0
    sharp_N, round_N = (_above_N(part * rise_N, white_N, n_window) for part in (1.0, ROUND * bends))
    above_N = 0.5 * (sharp_N + round_N)
    above_N = above_N if is_line else max(above_N, 0.0)
    left_N = max(abs(sharp_N - above_N), abs(round_N - above_N) / math.sqrt(3.0))
    std_N = noise_N * _at(rise_N, white_N, n_window, _STD_OF_MAXIMUM)
    return above_N, math.hypot(std_N, left_N, rise_N / math.sqrt(12.0))


def _above_N(rise_N: float, white_N: float, n_window: int) -> float:
    return white_N * _at(rise_N, white_N, n_window, _MEAN_OF_MAXIMUM) - 0.5 * n_window * rise_N


def _at(rise_N: float, white_N: float, n_window: int, table: tuple[float, ...]) -> float:
    apart = math.log10(min(max(n_window * rise_N / max(white_N, TINY), 1e-3), 1e1))
    return float(np.interp(apart, _APART, table))


def hidden_by_steps_N(step_N: float, noise_N: float) -> float:
    """Return the standard uncertainty of a mean of values rounded to steps, which noise larger than those takes away.

    Rounded, noise σ leaves σ² + q²/12; of the error of rounding, u = q/√12, e^(−2π²σ²/q²) is in the mean, too, but for
    its harmonics (Widrow and Kollar, Quantization Noise, 2008).
    """
    if step_N <= 0.0:
        return 0.0
    dither = max((noise_N / step_N) ** 2 - 1.0 / 12.0, 0.0)
    return step_N / math.sqrt(12.0) * math.exp(-2.0 * math.pi**2 * dither)


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


def line_through(time_s: FloatArray, force_N: FloatArray) -> tuple[float, float, float]:
    """Least-squares line: mean time, mean force, slope."""
    t0, f0 = float(time_s.mean()), float(force_N.mean())
    dt = time_s - t0
    squares = float(dt @ dt)
    return t0, f0, float(dt @ (force_N - f0)) / squares if squares > 0 else 0.0


def window_bias_N(loading_rate_N_s: float, window_s: float, step_s: float) -> float:
    """Return by how much a centred window lowers the top of a ramp that ends in a sudden drop [N].

    The window that lies wholly on the ramp and ends at its top has its mean half a window earlier:
    −rate (w − step)/2, to first order. Zero for a window of one sample.
    """
    return -max(loading_rate_N_s, 0.0) * (max(window_s - step_s, 0.0) / 2.0)


def choose_window(loading_rate_N_s: float, noise_std_N: float, step_s: float, *, longest_s: float) -> float:
    """Return the window with the smallest uncertainty of the peak [s].

    Minimises (rate·w/2)² + σ²·step/w, whose minimum is at w³ = 2 σ² step / rate².
    """
    wanted_s = longest_s
    if loading_rate_N_s > 0:
        noise_s = noise_std_N / loading_rate_N_s  # squares of the two alone may leave the range of a float
        wanted_s = min(longest_s, math.cbrt(2.0 * noise_s * noise_s * step_s))
    return window_samples(wanted_s, step_s) * step_s
