"""Segments of a recording: samples, block means, and on these climbs, breaks, slips and sliding.

Phases are found on means over 4 ms before the peak is measured finely. A *record* is a force never reached before;
a *break* is a record followed by a drop of more than the noise; a *slip* is a break as sudden as a rope slips.
"""

from dataclasses import dataclass, replace
from math import nan
from typing import NamedTuple

import numpy as np

from ropefric.arrays import BoolArray, FloatArray, IntArray, median
from ropefric.traces.breakaway import Phase, PickSettings
from ropefric.traces.calibration import Saturation
from ropefric.traces.clock import GAP_STEPS
from ropefric.traces.noise import (
    MAX_SPIKE_SAMPLES,
    find_stuck,
    noise_std,
    remove_spikes,
    resolution,
    without_hum,
)
from ropefric.traces.trace import ForceTrace

TINY = 1e-300
MIN_SAMPLES = 50
"""Fewer samples cannot show idle, loading, a peak and sliding."""
FALLS = 5.0
"""A force that falls this many times as far as it rises only goes down [-]."""
BLOCK_S = 0.004
"""Length of a block [s]: a fifth of the shortest stick-slip tooth of such rigs, long enough to average noise."""
DROP_SIGMAS = 6.0
"""A drop of fewer noise standard deviations is noise."""
SHORTEST_BLOCKS = 4
SHORTEST_IDLE = 12
"""Blocks at rest that the drift of the force needs to be measured."""
AT_REST = 0.3
"""A recording that begins above this part of its range does not begin at rest."""
FEW_PIECES, ROUGHER = 4, 3.0
PIECE_BLOCKS = 25
"""A tenth of a second at three kilohertz: drift is slow against it."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Blocks:
    """Block means of a recording, on which phases are distinguished."""

    force_N: FloatArray
    time_s: FloatArray
    size: int
    noise_N: float
    resolution_N: float
    n_rest: int = 0

    def first_sample(self, block: int) -> int:
        """Return the first sample of a block, or of the first block if there is no such block before it."""
        return max(0, block) * self.size

    def last_sample(self, block: int, n_samples: int) -> int:
        """Return the last sample of a block of a recording of `n_samples`; the last block holds the rest."""
        return n_samples - 1 if block >= self.force_N.size - 1 else max(0, block + 1) * self.size - 1


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Prepared:
    """The part of a trace that is wanted, without missing samples and spikes; noise, and what was met on the way."""

    time_s: FloatArray
    force_N: FloatArray
    noise_N: float
    blocks: Blocks
    notes: tuple[str, ...]
    stuck: IntArray


class Sliding(NamedTuple):
    """The blocks after a break in which the rope slides, up to `stop`."""

    first: int
    stop: int


def wanted(trace: ForceTrace, settings: PickSettings) -> slice:
    """Return the part of a trace between the times of the settings."""
    start, stop = 0, trace.time_s.size
    if settings.start_s is not None:
        start = int(np.searchsorted(trace.time_s, settings.start_s, side="left"))
    if settings.stop_s is not None:
        stop = int(np.searchsorted(trace.time_s, settings.stop_s, side="right"))
    return slice(start, stop)


def prepare(trace: ForceTrace, settings: PickSettings) -> Prepared | None:
    """Return the samples to pick from, or None if there are too few."""
    part = wanted(trace, settings)
    time_s, force_N = trace.time_s[part], trace.force_N[part]
    present = np.isfinite(force_N)
    n_missing = int(force_N.size - np.count_nonzero(present))
    if n_missing:
        time_s, force_N = time_s[present], force_N[present]
    if force_N.size < MIN_SAMPLES:
        return None
    step_N = resolution(force_N)
    noise_N = _noise_before_sliding(force_N, noise_std(force_N, step_N), step_N)
    stuck = _between_limits(find_stuck(force_N, step_N, noise_N), force_N, trace)
    if len(stuck):
        noise_N = noise_std(np.delete(force_N, np.concatenate([np.arange(*run) for run in stuck])))
    steps_s = np.diff(time_s)
    cleaned = remove_spikes(force_N, noise_N, steps_s > GAP_STEPS * median(steps_s))
    step_N = resolution(cleaned.values) if cleaned.bad.size else step_N
    hum = without_hum(time_s, cleaned.values)
    noise_N = noise_std(hum.force_N, step_N) if hum.amplitude_N else noise_N
    notes = [
        *trace.notes,
        *(
            f"the force reads exactly {force_N[first]:.4g} N for {time_s[end - 1] - time_s[first]:.2g} s "
            f"({end - first} samples) from {time_s[first]:.4g} s on: the converter or the sensor stuck"
            for first, end in stuck.tolist()
        ),
    ]
    if n_missing:
        notes.append(f"{n_missing} of {present.size} samples are missing")
    if cleaned.bad.size:
        places = ", ".join(f"{time_s[i]:.4g} s" for i in cleaned.bad[:3])
        more = ", …" if cleaned.bad.size > 3 else ""
        notes.append(f"{cleaned.bad.size} samples left out as spikes or dropouts (at {places}{more})")
    if hum.amplitude_N:
        notes.append(f"hum of {hum.amplitude_N:.2g} N at {hum.frequency_Hz:.4g} Hz was taken out")
    return Prepared(
        time_s=time_s,
        force_N=hum.force_N,
        noise_N=noise_N,
        blocks=_block_means(time_s, hum.force_N, step_N),
        notes=tuple(notes),
        stuck=stuck,
    )


def _noise_before_sliding(force_N: FloatArray, noise_N: float, step_N: float) -> float:
    """Return the noise of a recording, or up to its highest force where that is far less: sliding is rough itself."""
    before = force_N[: int(np.argmax(force_N)) + 1]
    if before.size < MIN_SAMPLES:
        return noise_N
    own_N = noise_std(before, step_N)
    return own_N if noise_N > ROUGHER * own_N > 0.0 else noise_N


def _between_limits(stuck: IntArray, force_N: FloatArray, trace: ForceTrace) -> IntArray:
    """Return the stuck stretches that are not at a limit of the converter, which is another matter."""
    if trace.saturation is None or not len(stuck):
        return stuck
    limits_N = np.array([np.nanmax(trace.force_N) if trace.saturation.n_high else np.inf,
                         np.nanmin(trace.force_N) if trace.saturation.low_runs.size else -np.inf])  # fmt: skip
    return stuck[~np.isin(force_N[stuck[:, 0]], limits_N)]


def _block_means(time_s: FloatArray, force_N: FloatArray, step_N: float) -> Blocks:
    n = force_N.size
    span_s = float(time_s[-1] - time_s[0])
    size = int(np.clip(round(BLOCK_S * (n - 1) / span_s), 1, max(1, n // 16))) if span_s > 0 else 1
    m = n // size
    body = force_N[: (m - 1) * size].reshape(m - 1, size).mean(axis=1)
    means = np.append(body, force_N[(m - 1) * size :].mean())
    # A converter coarser than its noise repeats itself, so that averaging helps less than by the square root; hum and
    # slow noise hardly average out at all, which a rope at rest shows.
    floor_N = float(step_N / np.sqrt(12.0 * size))
    noise_N = max(_noise_before_sliding(means, noise_std(means), floor_N), floor_N)
    away = np.abs(means - median(means[:SHORTEST_IDLE])) > DROP_SIGMAS * noise_N
    away[:-2] &= away[1:-1] & away[2:]
    idle = int(np.argmax(away)) if away.any() else 0
    low_N = float(means.min() + AT_REST * (means.max() - means.min()))
    n_rest = max(0, idle - 2) * size if idle >= SHORTEST_IDLE and median(means[:idle]) < low_N else 0
    if n_rest:
        noise_N = max(noise_N, roughness_N(means[: idle - 2]))
    return Blocks(
        force_N=means,
        time_s=time_s[: m * size : size],
        size=size,
        noise_N=noise_N,
        resolution_N=step_N,
        n_rest=n_rest,
    )


def sliding_after(prepared: Prepared, top: int, fallen: int, rests: BoolArray) -> Sliding | None:
    """Return the stretch of sliding after a fall, as blocks; None if the force falls away without one.

    It ends where the rope rests or is held again (`rests`, block by block), or the force leaves its level for good:
    motor off, direction reversed, rope gone.
    """
    force_N, first = prepared.blocks.force_N, fallen
    base_N, start = float(force_N[: top + 1].min()), half_climb(force_N, top)
    n_first = int(np.clip((top - start) // 4, PIECE_BLOCKS, 4 * PIECE_BLOCKS))
    stretch = force_N[first:]
    if stretch.size < SHORTEST_BLOCKS or (level_N := median(stretch[:n_first])) <= base_N:
        return None
    gone = (stretch < base_N + 0.4 * (level_N - base_N)) | rests[first:]
    ends = np.flatnonzero(gone[:-1] & gone[1:])  # a single block may be noise
    stretch = stretch[: int(ends[0])] if ends.size else stretch
    if stretch.size < SHORTEST_BLOCKS:
        return None
    level_N, scatter_N = _level_and_scatter(stretch[:n_first])
    # Sliding passes its level again and again; a released rope never does. It may come to it little by little.
    apart_N, later_N = (
        max(scatter_N, 0.03 * abs(level_N - base_N)),
        median(stretch[: max(4 * (first - top), 1)]),
    )
    stays = np.flatnonzero(stretch >= min(level_N - apart_N, later_N - 0.5 * apart_N))
    stretch = stretch[: int(stays[-1]) + 1]
    return None if stretch.size < SHORTEST_BLOCKS else Sliding(first, first + stretch.size)


def half_climb(force_N: FloatArray, top: int, start: int = 0) -> int:
    """Return the first block of the upper half of what leads from a start to a top."""
    before_N = force_N[start : top + 1]
    below = np.flatnonzero(before_N < 0.5 * (float(before_N.min()) + float(force_N[top])))
    return start + min(int(below[-1]) + 1, top - start) if below.size else start


def _level_and_scatter(stretch: FloatArray) -> tuple[float, float]:
    """Median, and robust standard deviation around the line through the medians of both halves."""
    half = stretch.size // 2
    x = np.arange(stretch.size) - (stretch.size - 1) / 2
    slope = 0.0
    if half >= SHORTEST_BLOCKS:
        slope = (median(stretch[-half:]) - median(stretch[:half])) / (stretch.size - half)
    flat = stretch - slope * x
    return median(stretch), 1.4826 * median(np.abs(flat - median(flat)))


def roughness_N(stretch: FloatArray, length: int = PIECE_BLOCKS) -> float:
    """Return the standard deviation around a straight line within pieces of this many blocks [N].

    The median of the pieces counts, of four or fewer the quietest.
    """
    length = min(length, stretch.size)
    n_pieces = stretch.size // length
    pieces = stretch[: n_pieces * length].reshape(n_pieces, length)
    x = np.arange(length) - (length - 1) / 2
    flat = pieces - pieces.mean(axis=1, keepdims=True)
    if length > 1:
        flat -= np.outer(flat @ x / float(x @ x), x)
    stds = np.sort(np.sqrt(np.mean(flat**2, axis=1)))
    # Half of a short stretch may be the release at its end.
    return float(stds[(n_pieces - 1) // 2 if n_pieces > FEW_PIECES else 0])


def kinetic(prepared: Prepared, sliding: Sliding | None) -> tuple[float, float]:
    """Return mean and sample standard deviation of the force while sliding [N]; NaN where nothing slid."""
    if sliding is None:
        return nan, nan
    blocks, n = prepared.blocks, prepared.force_N.size
    samples = slice(blocks.first_sample(sliding.first), blocks.last_sample(sliding.stop - 1, n) + 1)
    return float(prepared.force_N[samples].mean()), float(prepared.force_N[samples].std(ddof=1))


def phases_of(prepared: Prepared, block: int, sliding: Sliding | None) -> tuple[Phase, ...]:
    """Return what happened when: idle, loading, break-away, sliding, unloading."""
    blocks = prepared.blocks
    before = blocks.force_N[: block + 1]
    base_N = float(before.min())
    idle_N = base_N + max(DROP_SIGMAS * blocks.noise_N, 0.05 * (float(blocks.force_N[block]) - base_N))
    idle = np.flatnonzero(before <= idle_N)
    start_s, peak_s, end_s = (float(t) for t in (blocks.time_s[0], blocks.time_s[block], prepared.time_s[-1]))
    loading_s = float(blocks.time_s[idle[-1]]) if idle.size else start_s
    ends = [("idle", loading_s), ("loading", peak_s)]
    if sliding is not None:
        stops_s = float(blocks.time_s[sliding.stop]) if sliding.stop < blocks.time_s.size else end_s
        ends += [("break-away", float(blocks.time_s[sliding.first])), ("sliding", stops_s)]
    ends.append(("unloading", end_s))
    starts = [start_s, *(end for _, end in ends)]
    # Nothing need be idle, nor be unloaded after sliding.
    optional = {"idle"} if sliding is None else {"idle", "unloading"}
    return tuple(
        Phase(name=name, start_s=begin, end_s=end)
        for begin, (name, end) in zip(starts, ends, strict=False)
        if begin < end or name not in optional
    )


def upright(trace: ForceTrace) -> tuple[ForceTrace, str]:
    """Return a trace turned round if its sign was reversed, that is if its force goes down, and what to say."""
    if not (lowest_N := _falls_to(trace.force_N)):
        return trace, ""
    saturation = trace.saturation
    if saturation is not None:
        saturation = Saturation(high_runs=saturation.low_runs, low_runs=saturation.high_runs)
    said = f"the force goes down, to {lowest_N:.4g} N: its sign is taken as reversed"
    return replace(trace, force_N=-trace.force_N, saturation=saturation), said


def _falls_to(force_N: FloatArray) -> float:
    """Return the lowest force of a recording that falls far below zero and never rises above; 0 for any other."""
    present_N = force_N[np.isfinite(force_N)]
    if present_N.size < MIN_SAMPLES or not present_N.min() < -FALLS * max(float(present_N.max()), 0.0):
        return 0.0
    few = max(MAX_SPIKE_SAMPLES + 1, present_N.size // 200)  # no spike makes a pull
    low_N, high_N = np.partition(present_N, (few, -few - 1))[[few, -few - 1]]
    start_N = float(np.median(present_N[: max(few, present_N.size // 50)]))
    fall_N, rise_N = start_N - low_N, high_N - start_N
    # One that begins within the climb may rise to nothing at its end.
    ends = np.argmin(present_N) < np.argmax(present_N) and FALLS**2 * abs(high_N) < -low_N
    is_fall = (ends or fall_N > FALLS * rise_N) and fall_N > 20.0 * noise_std(present_N)
    return float(low_N) if is_fall and low_N < -FALLS * max(high_N, 0.0) else 0.0
