"""Mains hum: found in the stretches where the force is smooth, and taken out as what it is, a steady oscillation.

A moving average as long as a period would take it out as well, and round every peak. Here frequency, amplitude and phase
are fitted by least squares, window by window, and only what keeps its phase throughout is hum.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray

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
