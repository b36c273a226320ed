"""Noise, spikes, stuck converters and mains hum of a recording.

Hum is found where the force is smooth, and taken out as what it is, a steady oscillation: a moving average as long as a
period would take it out as well, and round every peak. Frequency, amplitude and phase are fitted by least squares,
window by window, and only what keeps its phase throughout is hum.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray, IntArray, median

MAX_SAMPLES_FOR_NOISE = 4096
MAX_SPIKE_SAMPLES = 5
MAX_LAST_SAMPLES = 2
CLIMBS = 0.25
MAX_DROPOUT_SAMPLES = 40
SPIKE_SIGMAS, STANDS_OUT = 8.0, 4.0
"""Factors of the noise, and of any step beside it, by which a spike jumps."""
CHANCE_SIGMAS = 5.0
REJOINS = 0.4
"""A spike comes back to within this part of its height: it may fall into the very moment of a slip."""
NEIGHBOURS = 5
CUT_OFF = 0.75
LONG_RUN = 8
"""A signal is at a limit if less than this share of it lies below its largest value, which lasts this long."""

# Of stretches in which the converter stuck:
# As many as a dropout that is mended.
_FEWEST = MAX_DROPOUT_SAMPLES
_LEAST = 8
# Shorter runs say nothing of what is usual.
_SHORT = 16
# Of very many, as of a coarse converter, the longest are looked at.
_MOST = 100
_AROUND = 400
_LEAST_AROUND = 100
_REST = 50
_WIDE = 0.3
# White noise turns back at two of three samples, also when it is rounded; a smooth curve hardly ever does.
_TURNS = 0.4
# From this share of changing samples on, the noise is too large to hide within one step of the converter.
_LIVELY = 0.3
_LEAST_CHANGES = 0.01
_CHANCE = 1e-6
_LONGER = 3.0
_JUMP_SIGMAS = 4.0
_JUMP_STEPS = 2.0


def _second_differences(values: FloatArray) -> FloatArray:
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
    if not steps.any():  # a coarse converter shows none while the rope is at rest
        first, steps = values, np.abs(np.diff(values))
    low, high = float(first.min()), float(first.max())
    # Steps of rounding are none: those of the numbers themselves, which an offset makes larger, and of arithmetic.
    steps = steps[steps > max(1e-9 * (high - low), 8.0 * float(np.spacing(max(abs(low), abs(high)))))]
    return float(steps.min()) if steps.size else 0.0


def noise_std(values: FloatArray, step: float | None = None) -> float:
    """Return the standard deviation of the white noise on a signal that is smooth between corners.

    From the median of the absolute second differences, which straight lines do not touch and a few corners, slips
    and spikes do not move: σ = 1.4826 median|x_{i-1} − 2 x_i + x_{i+1}| / √6. A coarse converter hides noise
    smaller than its step (`resolution`, unless it is given), so the result is never below step/√12. Where much of
    it is cut off, the rest is used.
    """
    if values.size < 4:
        return 0.0
    highest = float(values.max())
    below = values < highest - 1e-12 * (highest - float(values.min()))
    n_below, n_runs = np.count_nonzero(below), np.count_nonzero(below[:-1] & ~below[1:])
    if 4 <= n_below < CUT_OFF * values.size and values.size - n_below >= LONG_RUN * n_runs:
        values = values[below]
    step = resolution(values) if step is None else step
    sigma = 1.4826 * median(np.abs(_second_differences(values))) / np.sqrt(6.0)
    return float(max(sigma, step / np.sqrt(12.0)))


class Cleaned(NamedTuple):
    """A signal without its isolated spikes and frozen stretches."""

    values: FloatArray
    bad: IntArray


def remove_spikes(values: FloatArray, noise: float, is_gap: BoolArray | None = None) -> Cleaned:
    """Return a signal without spikes of up to five samples and without short dropouts.

    A spike leaves the signal in one step, stays away for a few samples and comes back to where the signal
    went on; its step is larger than eight times the noise and larger than four times any step before it.
    A narrow static peak, climbed in several steps, is none. A dropout is a stretch of up to 40 identical samples that
    leaves and rejoins the signal the same way. Across a gap in the samples nothing is known to leave in one step.
    """
    steps = np.diff(values)
    if is_gap is not None:
        steps[is_gap] = 0.0
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
        return Cleaned(values, np.empty(0, dtype=np.int64))
    index = np.array(bad, dtype=np.int64)
    good = np.ones(values.size, dtype=bool)
    good[index] = False
    cleaned = values.copy()
    cleaned[index] = np.interp(index, np.flatnonzero(good), values[good])
    return Cleaned(cleaned, index)


def _candidates(values: FloatArray, steps: FloatArray, smallest: float) -> list[int]:
    """First samples of what may be excursions: large steps that are nearly undone soon, or lead to a frozen value."""
    starts = np.flatnonzero((steps > smallest) | (steps < -smallest)) + 1
    out = np.abs(steps[starts - 1])
    # A trace whose noise is far from white jumps everywhere: then nothing stands out, and nothing is removed. On a steep
    # climb all steps are large, and alike.
    jumps = out > STANDS_OUT * np.abs(steps[np.maximum(starts - 2, 0)])
    if np.count_nonzero(jumps) > max(50, values.size // 20):
        return []
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
    # A peak is climbed in several steps, a spike in one.
    if np.all(steps[start - 1 : start + 2] * np.sign(out) > CLIMBS * abs(out)):
        return 0
    frozen = start
    while frozen < values.size and values[frozen] == values[start] and frozen - start < MAX_DROPOUT_SAMPLES:
        frozen += 1
    lengths = [*range(1, MAX_SPIKE_SAMPLES + 1)]
    if frozen - start > MAX_SPIKE_SAMPLES:
        lengths.append(frozen - start)
    for length in lengths:
        stop = start + length
        if stop >= values.size:
            # A last sample that jumps away may be the first one of something new: it is left out.
            return int(stop) if stop == values.size and length <= MAX_LAST_SAMPLES else 0
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
        # Of white noise alone the steps beside it are as large by chance.
        least = STANDS_OUT * usual if usual > CHANCE_SIGMAS * noise else SPIKE_SIGMAS * noise
        if rejoins and min(abs(out), abs(back)) > least:
            return int(stop)
    return 0


def find_stuck(values: FloatArray, step: float, noise: float) -> IntArray:
    """Return the stretches in which a live signal reads exactly the same: start and stop of each, shape (k, 2).

    The recording shows which samples are live. If around the stretch a share p of the samples differs from the one
    before and the changes go to and fro, at rest if not on a ramp, the noise spans the converter's steps, and n equal
    samples have a probability below (1 − p²)ⁿ: p² and not p, for between two steps the noise changes less than on an
    edge.
    A converter coarser than its noise may well repeat itself, q/r seconds long on a ramp of rate r. There a
    stretch is stuck if it is three times as long as any other around it and the signal then jumps: it went on
    unseen. A signal without noise is never called stuck: it may have been computed, or held.
    """
    same = runs_of(values[1:] == values[:-1])
    runs = np.asarray(same + np.array([0, 1]), dtype=np.int64)
    runs = runs[runs[:, 1] - runs[:, 0] >= _LEAST]
    if not len(runs):
        return runs
    changed = np.diff(values, prepend=values[0])
    longest = np.sort(np.argsort(runs[:, 0] - runs[:, 1], kind="stable")[:_MOST])
    stuck = [run for run in runs[longest] if _is_stuck(values, changed, runs, run, (step, noise))]
    return np.asarray(np.array(stuck, dtype=np.int64).reshape(-1, 2))


def _is_stuck(
    values: FloatArray,
    changed: FloatArray,
    runs: IntArray,
    run: IntArray,
    grain: tuple[float, float],
) -> bool:
    start, stop = int(run[0]), int(run[1])
    length, n_around = stop - start, max(_AROUND, stop - start)
    shares, is_noisy = [], False
    # On one side the force may run up and down so fast that no noise is seen on it.
    for found in (changed[max(0, start - n_around) : start], changed[stop + 1 : stop + n_around]):
        steps = found[found != 0.0]
        if found.size < _LEAST_AROUND:
            continue
        is_quiet = steps.size < max(3.0, _LEAST_CHANGES * found.size)
        turns = not is_quiet and (_turns(steps) >= _TURNS or _rests_noisily(found, grain[0]))
        is_noisy |= turns
        if is_quiet or turns:
            shares.append(steps.size / found.size)
    if not is_noisy:
        return False
    share = min([*shares, 0.95])
    if share >= _LIVELY and values.size * (1.0 - share**2) ** length < _CHANCE:
        return True
    if length < _FEWEST:
        return False
    step, noise = grain
    jump = np.abs(np.append(changed, 0.0)[runs[:, 1]]) > _JUMP_SIGMAS * noise + _JUMP_STEPS * step
    near = (runs[:, 1] > start - n_around) & (runs[:, 0] < stop + n_around) & ~jump
    longest = int((runs[near, 1] - runs[near, 0]).max(initial=_SHORT))
    return length > _LONGER * longest and bool(jump[runs[:, 0] == start][0])


def _turns(steps: FloatArray) -> float:
    """Return the share of the steps that go the other way than the one before."""
    return float(np.mean(np.sign(steps[1:]) != np.sign(steps[:-1])))


def _rests_noisily(changes: FloatArray, step: float) -> bool:
    """Return whether somewhere, as before the load comes on, the noise alone moves the signal by several steps.

    A ramp outruns the noise, so that it only rises; and where it moves by one step only, the converter is coarser
    than its noise and may well stay where it is.
    """
    for start in range(0, changes.size - _REST + 1, _REST):
        part = changes[start : start + _REST]
        steps = part[part != 0.0]
        is_wide = np.count_nonzero(np.abs(part) > 1.5 * step) >= _WIDE * part.size
        if is_wide and _turns(steps) >= _TURNS:
            return True
    return False


def runs_of(mask: BoolArray) -> IntArray:
    """Return the start and stop of every run of True, shape (k, 2), read-only."""
    edges = np.diff(mask, prepend=False, append=False) if mask.any() else mask  # most have none
    runs = np.flatnonzero(edges).astype(np.int64).reshape(-1, 2)
    runs.flags.writeable = False
    return runs


ComplexArray = npt.NDArray[np.complex128]

MAINS_HZ = (50.0, 60.0)
WINDOW_S = 0.1
MOST_WINDOWS = 256
FEWEST_WINDOWS = 6
WANDER_HZ = 0.6
COHERENT = 0.7
"""Part of the windows' mean amplitude that remains when they are added with their phases."""
SIGMAS = 6.0
STRONG = 1.3
HARMONICS = 5
FINE = 41


class Hum(NamedTuple):
    """A force without its hum, and what was taken out: frequency [Hz] and amplitude [N]; 0 where there was none."""

    force_N: FloatArray
    frequency_Hz: float
    amplitude_N: float


def without_hum(time_s: FloatArray, force_N: FloatArray) -> Hum:
    """Return a force without 50 or 60 Hz and its harmonics, as far as they are steady."""
    nothing = Hum(force_N, 0.0, 0.0)
    span_s = float(time_s[-1] - time_s[0])
    if span_s <= 0.0 or (force_N.size - 1) / span_s < 2.5 * MAINS_HZ[0]:
        return nothing
    rate_Hz = (force_N.size - 1) / span_s
    m = round(WINDOW_S * rate_Hz)
    n = min(force_N.size // m, MOST_WINDOWS)
    if n < FEWEST_WINDOWS:
        return nothing
    first = int(np.clip(int(np.argmax(force_N)) - n * m // 2, 0, force_N.size - n * m))
    part = slice(first, first + n * m)
    t = (time_s[part] - time_s[first]).reshape(n, m)
    x = force_N[part].reshape(n, m)
    x = x - x.mean(axis=1, keepdims=True)
    u = t - t.mean(axis=1, keepdims=True)
    x = x - u * ((x * u).sum(axis=1) / (u * u).sum(axis=1))[:, None]
    best = nothing
    for mains_Hz in MAINS_HZ:
        if rate_Hz < 2.5 * mains_Hz:
            continue
        at_Hz, wave = _steady(t, u, x, mains_Hz, span_s=n * WINDOW_S)
        if abs(wave) <= best.amplitude_N:
            continue
        waves = [(at_Hz, wave)]
        for harmonic in range(2, HARMONICS + 1):
            if harmonic * at_Hz < 0.45 * rate_Hz:
                again = _amplitudes(t, u, x, harmonic * at_Hz)
                quiet = _quiet(x, again)
                mean = complex(again[quiet].mean())
                if abs(mean) > SIGMAS * _noise(x, again, quiet):
                    waves.append((harmonic * at_Hz, mean))
        since_s = time_s - time_s[first]
        hum_N = sum(np.real(mean * np.exp(2j * np.pi * f_Hz * since_s)) for f_Hz, mean in waves)
        best = Hum(np.asarray(force_N - hum_N), at_Hz, abs(wave))
    return best


def _amplitudes(t: FloatArray, u: FloatArray, x: FloatArray, frequency_Hz: float) -> ComplexArray:
    """Return the complex amplitude in each window, of an oscillation whose line was taken out with that of the force.

    The windows are sampled alike but for the jitter of the clock, so that one oscillation serves them all.
    """
    since = u.mean(axis=0)
    wave = np.exp(-2j * np.pi * frequency_Hz * since)
    wave -= wave.mean()
    wave -= since * (wave @ since) / (since @ since)
    # Real and imaginary part apart: the product of a real matrix and a complex vector would copy the matrix.
    inside = np.einsum("km,m->k", x, wave.real) + 1j * np.einsum("km,m->k", x, wave.imag)
    return np.asarray(2.0 / x.shape[1] * inside * np.exp(-2j * np.pi * frequency_Hz * t.mean(axis=1)))


def _left(x: FloatArray, amplitudes: ComplexArray) -> FloatArray:
    return np.asarray(np.sqrt(np.maximum((x * x).mean(axis=1) - 0.5 * np.abs(amplitudes) ** 2, 0.0)))


def _quiet(x: FloatArray, amplitudes: ComplexArray) -> BoolArray:
    """Return the windows in which little else than the oscillation is left: no slip, no bend."""
    left = _left(x, amplitudes)
    return np.asarray(left <= 2.0 * np.quantile(left, 0.3))


def _noise(x: FloatArray, amplitudes: ComplexArray, quiet: BoolArray) -> float:
    left_N = float(np.sqrt(np.mean(_left(x, amplitudes)[quiet] ** 2)))
    return left_N * float(np.sqrt(2.0 / (x.shape[1] * int(quiet.sum()))))


def _steady(
    t: FloatArray, u: FloatArray, x: FloatArray, mains_Hz: float, *, span_s: float
) -> tuple[float, complex]:
    """Return frequency and complex amplitude of what keeps its phase near the mains' frequency; 0 where nothing does."""
    amplitudes = _amplitudes(t, u, x, mains_Hz)
    quiet = _quiet(x, amplitudes)
    # What is no larger than the noise of one window does not move a peak by more than its noise.
    least = STRONG * _noise(x, amplitudes, quiet) * np.sqrt(int(quiet.sum()))
    if int(quiet.sum()) < FEWEST_WINDOWS or float(np.abs(amplitudes[quiet]).mean()) < least:
        return mains_Hz, 0j
    middle_s, found = t.mean(axis=1)[quiet], amplitudes[quiet]
    off_Hz = np.arange(-WANDER_HZ, WANDER_HZ, 0.2 / span_s)
    for _ in range(2):
        sums = np.exp(-2j * np.pi * np.outer(off_Hz, middle_s)) @ found / found.size
        k = int(np.argmax(np.abs(sums)))
        step_Hz, best_Hz, steady = float(off_Hz[1] - off_Hz[0]), float(off_Hz[k]), float(np.abs(sums[k]))
        off_Hz = best_Hz + np.linspace(-step_Hz, step_Hz, FINE)
    if steady < COHERENT * float(np.abs(found).mean()) or steady < SIGMAS * _noise(x, amplitudes, quiet):
        return mains_Hz, 0j
    at_Hz = mains_Hz + best_Hz
    amplitudes = _amplitudes(t, u, x, at_Hz)
    return at_Hz, complex(amplitudes[_quiet(x, amplitudes)].mean())
