"""Samples of a drawn force: the sensor's filter, noise, hum, zero, spikes, converter, lost and damaged lines."""

from dataclasses import dataclass

import numpy as np
import scipy.signal

from ropefric.arrays import FloatArray, IntArray
from ropefric.rig.damage import damaged
from ropefric.traces.picker import State

Rng = np.random.Generator


def spread(rng: Rng, low: float, high: float) -> float:
    """Return a number between two limits, each decade as likely as the next."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def maybe(rng: Rng, chance: float) -> bool:
    """Return True with a probability."""
    return bool(rng.random() < chance)


def coloured(rng: Rng, n: int, length: float, steep: float) -> FloatArray:
    """Return noise of standard deviation 1, correlated over this many samples."""
    if n < 4:
        return np.zeros(n)
    frequency = np.fft.rfftfreq(n)
    wave = np.fft.irfft(
        np.fft.rfft(rng.standard_normal(n)) / (1.0 + (frequency * n / length) ** 2) ** steep, n
    )
    return np.asarray(wave / (wave.std() + 1e-12))


_MOST_SAMPLES, _FEWEST_SAMPLES = 30_000, 40


@dataclass(slots=True, eq=False)
class Samples:
    """The samples of a force: times, the force with and without faults, standard deviation of the noise, zero error."""

    rng: Rng
    time_s: FloatArray
    clean: FloatArray
    force: FloatArray
    noise: float
    zero: float = 0.0


def sampled(rng: Rng, knot_s: FloatArray, knot_force: FloatArray, climb_s: float) -> Samples | None:
    """Return samples of a force behind the filter of a sensor; None if they are too few."""
    end_s = float(knot_s[-1])
    if end_s <= 0.0:
        return None
    rate_Hz = max(spread(rng, 40.0, 5000.0), spread(rng, 8.0, 80.0) / climb_s, 60.0 / end_s)
    rate_Hz = min(rate_Hz, _MOST_SAMPLES / end_s)
    n = int(end_s * rate_Hz)
    if n < _FEWEST_SAMPLES:
        return None
    finer = int(np.clip(2e3 / rate_Hz, 1, 2e5 / n)) if maybe(rng, 0.2) else 1
    fine_s = np.arange(n * finer) / (rate_Hz * finer)
    force = np.interp(fine_s, knot_s, knot_force)
    corner_Hz = max(spread(rng, 8.0, 80.0), 20.0 / climb_s)
    if finer > 1 and corner_Hz < 0.4 * rate_Hz * finer:
        sections = scipy.signal.butter(int(rng.integers(1, 4)), corner_Hz, fs=rate_Hz * finer, output="sos")
        force = scipy.signal.sosfilt(sections, force - force[0]) + force[0]
    clean = force[::finer]
    return Samples(rng, fine_s[::finer], clean, clean.copy(), spread(rng, 1e-4, 1.5e-2))


def _noise(one: Samples) -> None:
    rng, n = one.rng, one.force.size
    one.force += one.noise * rng.standard_normal(n)
    if maybe(rng, 0.15):
        one.force += one.noise * rng.uniform(1.0, 3.0) * coloured(rng, n, n / rng.uniform(3.0, 20.0), 0.7)
    if maybe(rng, 0.2):
        mains_Hz, size = rng.choice((50.0, 60.0)), spread(rng, 5e-4, 0.03)
        one.force += size * np.sin(2.0 * np.pi * mains_Hz * one.time_s + rng.uniform(0.0, 6.3))


def _wrong_zero(one: Samples) -> None:
    rng = one.rng
    if maybe(rng, 0.2):
        one.zero = float(rng.choice((-1.0, 1.0)) * spread(rng, 0.003, 0.15))
        one.force += one.zero
    if maybe(rng, 0.15):
        one.force += rng.choice((-1.0, 1.0)) * rng.uniform(0.01, 0.1) * one.time_s / one.time_s[-1]


def _spikes(one: Samples) -> None:
    rng, n = one.rng, one.force.size
    for _ in range(int(rng.integers(1, 6)) if maybe(rng, 0.12) else 0):
        at = int(rng.integers(0, n))
        one.force[at : at + int(rng.integers(1, 5))] += rng.choice((-1.0, 1.0)) * rng.uniform(0.05, 1.3)


def _converter(one: Samples) -> None:
    rng = one.rng
    if maybe(rng, 0.2):
        step = rng.uniform(1.1, 4.0) / 2.0 ** int(rng.integers(8, 15))
        one.force = np.rint(one.force / step) * step


def _held_values(one: Samples) -> None:
    """Let the sensor be slower than the logger, or let its converter stick for a while."""
    rng, n = one.rng, one.force.size
    if maybe(rng, 0.05):
        every = int(rng.integers(2, 12))
        if n > 60 * every:
            one.force = one.force[np.arange(n) // every * every]
    if maybe(rng, 0.03):
        length = int(rng.integers(3, max(4, n // 40)))
        at = int(rng.integers(0, n - length))
        one.force[at : at + length] = one.force[at]


def seen_top(one: Samples, broke_s: float) -> int:
    """Return the sample at which the sensor, which lags behind, shows the force highest: the last before, or later."""
    last = max(int(np.searchsorted(one.time_s, broke_s, side="right")) - 1, 0)
    lags = np.flatnonzero(np.diff(one.clean[last:]) <= 0.0)
    return last + int(lags[0]) if lags.size else last


def visible_fall(one: Samples, at: int) -> bool:
    """Return whether a person would see the fall: beyond what noise does within a few milliseconds."""
    n = one.clean.size
    if not 3 <= at <= n - 3:
        return False
    later = one.clean[at:]
    higher = np.flatnonzero(later > 1.0005 * one.clean[at])
    fall = one.clean[at] - later[: max(int(higher[0]) if higher.size else later.size, 1)].min()
    rate_Hz = (n - 1) / one.time_s[-1]
    return bool(fall >= max(0.012, 4.0 * one.noise / np.sqrt(max(1.0, 0.004 * rate_Hz))))


def kept(one: Samples, broke_s: float) -> FloatArray:
    """Return which samples are written: now and then some are lost, though never those of the break-away."""
    rng, n = one.rng, one.force.size
    keep = np.ones(n, dtype=bool)
    if maybe(rng, 0.06):
        length = int(rng.integers(3, max(4, n // 30)))
        at = int(rng.integers(0, n - length - 1))
        near = 0.01 * one.time_s[-1]
        if not one.time_s[at] - near < broke_s < one.time_s[at + length] + near:
            keep[at : at + length] = False
    return keep


DAMAGED = 0.07
"""Share of recordings to learn from whose file is damaged."""


def damaged_state(one: Samples, state: IntArray) -> IntArray | None:
    """Damage the file while the rope is pulled; return the states then, or None where nothing would show."""
    pulled = np.flatnonzero(np.isin(state, (State.LOADING, State.PARTIAL_SLIP, State.SLIP, State.SLIDING)))
    if not pulled.size:
        return None
    # Sliding may go on for ever: more often before, where a force is taken.
    last = int(pulled[int((pulled.size - 1) * one.rng.random() ** 0.5)])
    found = damaged(one.rng, one.force, state, (int(pulled[0]), last))
    if found is None:
        return None
    step_s = float(one.time_s[1] - one.time_s[0])
    one.force, one.time_s = found.force_N, np.arange(float(found.force_N.size)) * step_s
    spoilt = state[found.source]
    spoilt[found.at :] = State.DAMAGED
    return spoilt


def spoil(one: Samples) -> None:
    """Add noise, a wrong zero and spikes, and pass the samples through a converter."""
    for add in (_noise, _wrong_zero, _spikes, _converter, _held_values):
        add(one)
