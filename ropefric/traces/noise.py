"""How much of a recording is noise, and what is only a spike."""

from dataclasses import dataclass

import numpy as np

from ropefric.arrays import FloatArray, IntArray, median

MAX_SAMPLES_FOR_NOISE = 4096
MAX_SPIKE_SAMPLES = 2
MAX_DROPOUT_SAMPLES = 40
SPIKE_SIGMAS = 8.0
REJOINS = 0.4
"""A spike comes back to within this part of its height: it may fall into the very moment of a slip."""
NEIGHBOURS = 5


def _windows(values: FloatArray) -> FloatArray:
    """At most `MAX_SAMPLES_FOR_NOISE` second differences, from stretches spread over the recording."""
    if values.size <= MAX_SAMPLES_FOR_NOISE:
        return np.asarray(np.diff(values, 2))
    n_stretches, length = 64, MAX_SAMPLES_FOR_NOISE // 64
    starts = np.linspace(0, values.size - length, n_stretches).astype(np.intp)
    index = starts[:, None] + np.arange(length)
    return np.asarray(np.diff(values[index], 2, axis=1).ravel())


def resolution(values: FloatArray) -> float:
    """Return the smallest step between neighbouring samples, 0 for a constant signal.

    For a converter's output this is the force of one count.
    """
    first = values[:MAX_SAMPLES_FOR_NOISE]
    if first.size < 2:
        return 0.0
    steps = np.abs(np.diff(first))
    low, high = float(first.min()), float(first.max())
    # Steps of rounding are none: those of the numbers themselves, which an offset makes larger, and of arithmetic.
    steps = steps[steps > max(1e-9 * (high - low), 8.0 * float(np.spacing(max(abs(low), abs(high)))))]
    return float(steps.min()) if steps.size else 0.0


def noise_std(values: FloatArray) -> float:
    """Return the standard deviation of the white noise on a signal that is smooth between corners.

    From the median of the absolute second differences, which straight lines do not touch and a few corners, slips
    and spikes do not move: σ = 1.4826 median|x_{i-1} − 2 x_i + x_{i+1}| / √6. A coarse converter hides noise
    smaller than its step, so the result is never below step/√12.
    """
    if values.size < 4:
        return 0.0
    sigma = 1.4826 * median(np.abs(_windows(values))) / np.sqrt(6.0)
    return float(max(sigma, resolution(values) / np.sqrt(12.0)))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Cleaned:
    """A signal without its isolated spikes and frozen stretches."""

    values: FloatArray
    bad: IntArray


def remove_spikes(values: FloatArray, noise: float) -> Cleaned:
    """Return a signal without spikes of one or two samples and without short dropouts.

    A spike leaves the signal in one step, stays away for at most two samples and comes back to where the signal
    went on; its step is larger than eight times the noise and larger than four times any step before it.
    A narrow static peak, climbed in several steps, is none. A dropout is a stretch of up to 40 identical samples that
    leaves and rejoins the signal the same way.
    """
    steps = np.diff(values)
    bad: list[int] = []
    last_bad = -1
    for start in _candidates(values, steps, SPIKE_SIGMAS * noise):
        if start > last_bad:
            stop = _excursion_end(values, steps, start, noise)
            if stop:
                bad.extend(range(start, stop))
                last_bad = stop - 1
                steps[start - 1 : stop] = 0.0  # so that a spike does not hide the next one
    if not bad:
        return Cleaned(values=values, bad=np.empty(0, dtype=np.int64))
    index = np.array(bad, dtype=np.int64)
    good = np.ones(values.size, dtype=bool)
    good[index] = False
    cleaned = values.copy()
    cleaned[index] = np.interp(index, np.flatnonzero(good), values[good])
    return Cleaned(values=cleaned, bad=index)


def _candidates(values: FloatArray, steps: FloatArray, smallest: float) -> list[int]:
    """First samples of what may be excursions: large steps that are nearly undone soon, or lead to a frozen value."""
    starts = np.flatnonzero((steps > smallest) | (steps < -smallest)) + 1
    # A trace whose noise is far from white jumps everywhere: then nothing stands out, and nothing is removed.
    if starts.size > max(50, values.size // 20):
        return []
    out = np.abs(steps[starts - 1])
    last = values.size - 1
    maybe = starts + MAX_SPIKE_SAMPLES > last
    for length in range(1, MAX_SPIKE_SAMPLES + 1):
        stops = np.minimum(starts + length, last)
        gap = np.abs(values[stops] - values[starts - 1])
        # The step is at least four times any usual one, so a spike rejoins to well within its own size.
        size = np.maximum(out, np.abs(values[stops] - values[stops - 1]))
        maybe |= gap <= np.maximum(0.75 * size, smallest)
    maybe |= values[np.minimum(starts + MAX_SPIKE_SAMPLES, last)] == values[starts]
    return [int(start) for start in starts[maybe]]


def _excursion_end(values: FloatArray, steps: FloatArray, start: int, noise: float) -> int:
    """Return the first sample after an excursion that begins at `start`, or 0 if it is none."""
    out = float(steps[start - 1])
    frozen = start
    while frozen < values.size and values[frozen] == values[start] and frozen - start < MAX_DROPOUT_SAMPLES:
        frozen += 1
    lengths = [*range(1, MAX_SPIKE_SAMPLES + 1)]
    if frozen - start > MAX_SPIKE_SAMPLES:
        lengths.append(frozen - start)
    for length in lengths:
        stop = start + length
        if stop >= values.size:
            # A last sample that jumps away cannot be told from the first one of something new: leave it out.
            return int(stop) if stop == values.size and length <= MAX_SPIKE_SAMPLES else 0
        back = float(steps[stop - 1])
        # A peak is climbed in steps of its own size; what comes after it may be flat.
        nearby = (
            steps[max(0, start - 1 - NEIGHBOURS) : start - 1]
            if start > 1
            else steps[stop : stop + NEIGHBOURS]
        )
        usual = float(np.abs(nearby).max(initial=0.0))
        gap = abs(float(values[stop] - values[start - 1]))
        middle = 0.5 * float(values[stop] + values[start - 1])
        height = float(np.abs(values[start:stop] - middle).max())
        rejoins = gap <= max(6.0 * noise, (length + 1) * usual, REJOINS * height)
        if rejoins and min(abs(out), abs(back)) > 4.0 * usual:
            return int(stop)
    return 0
