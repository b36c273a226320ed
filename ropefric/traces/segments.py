"""What the force did: samples to pick from, their block means, and on these climbs, breaks, slips and sliding.

Phases are told apart on means over 4 ms before the peak is measured finely. A *record* is a force never reached before;
a *break* is a record followed by a drop of more than the noise; a *slip* is a break as sudden as a rope slips.
"""

from dataclasses import dataclass
from math import inf, nan
from typing import NamedTuple

import numpy as np

from ropefric.arrays import FloatArray, IntArray, median
from ropefric.traces.breakaway import Phase, PickSettings
from ropefric.traces.hum import without_hum
from ropefric.traces.noise import find_stuck, noise_std, remove_spikes, resolution
from ropefric.traces.trace import ForceTrace

MIN_SAMPLES = 50
"""Fewer samples cannot show idle, loading, a peak and sliding."""
BLOCK_S = 0.004
"""Length of a block [s]: a fifth of the shortest stick-slip tooth of such rigs, long enough to average noise."""
DROP_SIGMAS = 6.0
"""A drop of fewer noise standard deviations is noise."""
SLIP_SIGMAS = 8.0
"""The same for a fall that is to be timed as well."""
SUDDEN = 0.65
"""Part of a slip that happens within two blocks; a release with a time constant of 20 ms does half of it."""
FAST_BLOCKS = 6
STILL_CLIMBING = 0.1
SHORTEST_BLOCKS = 4
FEW_PIECES = 4
PIECE_BLOCKS = 25
"""A tenth of a second at three kilohertz: drift is slow against it."""

GROWTH = 1.15
SLIP_GROWTH = 1.3
"""A slip, or any other break, after which the force still grows by more than this was a jolt of the loading."""
TALL = 0.3

# Of a break-away that takes longer than a slip, as on a soft machine, told from a load that is let down:
LEAST_SHARE = 0.55
"""Part of the peak that the force keeps; a load let down to half is not sliding."""
FALL_BLOCKS = 75
FALL_SHARE = 0.25
"""A fall is short against the upper half of the climb, and shorter than 0.3 s."""
HELD_BLOCKS = 10
"""A motor that is stopped holds the force for a moment, some 60 ms or more, before it is let down."""
STAY_BLOCKS = 125
STAY_FALLS = 4.0
"""The motor pulls on: the force stays for half a second, and four times as long as it fell."""
STEADY = 0.25
"""The level moves by less than this part of the fall, or by less than the next part of itself."""
LEVEL_DRIFT = 0.03
LEAST_DROP = 0.04
"""The force of a rope that is held and creeps falls by some per cent."""
RESOLVED_SIGMAS = 4.0
RESOLVED_COUNTS = 3.0
TOP_BLOCKS = 5
SHORTEST_LINE = 3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Blocks:
    """Block means of a recording, on which phases are told apart."""

    force_N: FloatArray
    time_s: FloatArray
    size: int
    noise_N: float
    resolution_N: float

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


class Climb(NamedTuple):
    """The way up to a block: lowest force before it [N], and the first block of the upper half."""

    base_N: float
    start: int


class Sliding(NamedTuple):
    """The blocks after a break in which the rope slides, up to `stop`; their level, that at the onset, and scatter."""

    first: int
    stop: int
    level_N: float
    onset_N: float
    scatter_N: float


class SlowBreak(NamedTuple):
    """A fall of the force that is slower than a slip and still a break-away."""

    fall_s: float
    drop_N: float
    share: float
    sliding: Sliding
    outlasts_slip: bool


def prepare(trace: ForceTrace, settings: PickSettings) -> Prepared | None:
    """Return the samples to pick from, or None if there are too few."""
    start, stop = 0, trace.time_s.size
    if settings.start_s is not None:
        start = int(np.searchsorted(trace.time_s, settings.start_s, side="left"))
    if settings.stop_s is not None:
        stop = int(np.searchsorted(trace.time_s, settings.stop_s, side="right"))
    time_s, force_N = trace.time_s[start:stop], trace.force_N[start:stop]
    present = np.isfinite(force_N)
    n_missing = int(force_N.size - np.count_nonzero(present))
    if n_missing:
        time_s, force_N = time_s[present], force_N[present]
    if force_N.size < MIN_SAMPLES:
        return None
    step_N = resolution(force_N)
    noise_N = noise_std(force_N, step_N)
    stuck = _between_limits(find_stuck(force_N, step_N, noise_N), force_N, trace)
    if len(stuck):
        noise_N = noise_std(np.delete(force_N, np.concatenate([np.arange(*run) for run in stuck])))
    cleaned = remove_spikes(force_N, noise_N)
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


def _between_limits(stuck: IntArray, force_N: FloatArray, trace: ForceTrace) -> IntArray:
    """Return the stuck stretches that are not at a limit of the converter, which is another matter."""
    if trace.saturation is None or not len(stuck):
        return stuck
    limits_N = np.array([np.nanmax(trace.force_N) if trace.saturation.high else np.inf,
                         np.nanmin(trace.force_N) if trace.saturation.low else -np.inf])  # fmt: skip
    return stuck[~np.isin(force_N[stuck[:, 0]], limits_N)]


def _block_means(time_s: FloatArray, force_N: FloatArray, step_N: float) -> Blocks:
    n = force_N.size
    span_s = float(time_s[-1] - time_s[0])
    size = int(np.clip(round(BLOCK_S * (n - 1) / span_s), 1, max(1, n // 16))) if span_s > 0 else 1
    m = n // size
    body = force_N[: (m - 1) * size].reshape(m - 1, size).mean(axis=1)
    means = np.append(body, force_N[(m - 1) * size :].mean())
    # A converter coarser than its noise repeats itself, so that averaging helps less than by the square root.
    return Blocks(
        force_N=means,
        time_s=time_s[: m * size : size],
        size=size,
        noise_N=max(noise_std(means), step_N / np.sqrt(12.0 * size)),
        resolution_N=step_N,
    )


def climb_to(force_N: FloatArray, block: int) -> Climb:
    """Return how the force climbed to a block."""
    before = force_N[: block + 1]
    base_N = float(before.min())
    below = np.flatnonzero(before < 0.5 * (base_N + float(force_N[block])))
    return Climb(base_N, min(int(below[-1]) + 1, block) if below.size else 0)


def flattened(force_N: FloatArray, block: int) -> bool:
    """Return whether the force had stopped climbing well before the block was reached.

    True if the slope over the last quarter of the climb is below a tenth of its average.
    """
    base_N, start = climb_to(force_N, block)
    late = start + 3 * (block - start) // 4
    if block - late < 3:
        return False
    average = 0.5 * (float(force_N[block]) - base_N) / (block - start)
    return float(force_N[block] - force_N[late]) / (block - late) < STILL_CLIMBING * average


def fast_drop_N(force_N: FloatArray, block: int) -> float:
    """Return how far the force falls within a few blocks after `block` [N]."""
    return float(force_N[block] - force_N[block : block + FAST_BLOCKS + 1].min())


def is_slip(blocks: Blocks, block: int) -> bool:
    """Return whether the force drops after `block` as when a rope slips: far beyond the noise, within two blocks.

    A bounce of the weights or a motor that is switched off takes longer.
    """
    ahead = blocks.force_N[block : block + 3 * FAST_BLOCKS]
    if ahead.size < 3:
        return False
    fall = ahead[:-2] - np.minimum(ahead[1:-1], ahead[2:])
    steepest = int(np.argmax(fall[:FAST_BLOCKS]))
    fall_N = float(fall[steepest])
    whole_N = float(ahead[: steepest + 1].max() - ahead[steepest : steepest + 2 * FAST_BLOCKS].min())
    return fall_N > SLIP_SIGMAS * blocks.noise_N and fall_N > SUDDEN * whole_N


def slips(stretch: FloatArray, noise_N: float, *, most: int) -> list[tuple[int, float]]:
    """Return the sudden falls of a sliding force, largest first: block before the fall, and its height [N]."""
    if stretch.size <= FAST_BLOCKS:
        return []
    lowest = np.lib.stride_tricks.sliding_window_view(stretch, FAST_BLOCKS + 1).min(axis=1)
    fall = stretch[: lowest.size] - lowest
    steepest = stretch[: lowest.size] - np.minimum(stretch[1 : lowest.size + 1], stretch[2 : lowest.size + 2])
    highest = np.maximum.reduce([np.roll(stretch, shift) for shift in range(FAST_BLOCKS + 1)])
    highest[:FAST_BLOCKS] = np.maximum.accumulate(stretch[:FAST_BLOCKS])
    whole = highest[: lowest.size] - lowest
    fall[(fall < DROP_SIGMAS * noise_N) | (steepest < 0.5 * whole)] = 0.0
    found: list[tuple[int, float]] = []
    order = np.argsort(-fall, kind="stable")
    # Neighbouring blocks see the same fall; take the largest of each run.
    for block in order[: np.count_nonzero(fall)]:
        if len(found) >= most:
            break
        if fall[block] > 0:
            found.append((int(block), float(fall[block])))
            fall[max(0, block - FAST_BLOCKS) : block + FAST_BLOCKS + 1] = 0.0
    return found


def first_static_break(blocks: Blocks, drop_N: float) -> int | None:
    """Return the block of the first break that ends the loading; None if the force never breaks.

    That is the first slip after which the force does not go on climbing by more than 30 %: later teeth may be higher
    and the sliding force may drift above it. Where nothing drops as suddenly as a slip, it is the first break that
    stays within 15 % of the largest force and is not followed by a higher level; an earlier jolt, as when the
    weights bounce, is followed by a climb well above it. A recording that goes back and forth is judged by its first
    cycle. Wiggles below 30 % of the largest force do not count.
    """
    force_N = blocks.force_N
    idle_N = float(force_N[: int(np.argmax(force_N)) + 1].min())
    tall_N = idle_N + TALL * (float(force_N.max()) - idle_N)
    first, cycle_end = None, force_N.size
    for record, drop in _breaks(force_N, drop_N):
        if force_N[record] < tall_N:
            continue
        if record >= cycle_end:
            break
        base_N = float(force_N[: record + 1].min())
        # Fallen back for good: unloaded, or the direction reversed.
        stop = record + _stays_below(force_N[record:], base_N + 0.25 * (float(force_N[record]) - base_N))
        climbed_N = max(float(force_N[record]) - base_N, drop_N)
        # Numbers so coarse that they show neither noise nor a climb: whatever comes later has outgrown it.
        growth = (float(force_N[record:stop].max()) - base_N) / climbed_N if climbed_N > 0.0 else inf
        # Noise may put the record well before the slip; the peak is where the slip begins.
        begin = max(record, drop - 2)
        edge = begin + int(np.argmax(force_N[begin : drop + 1]))
        if growth <= SLIP_GROWTH and is_slip(blocks, edge):
            return edge
        if first is None and growth <= GROWTH:
            sliding = sliding_after(blocks, record)
            if sliding is None or sliding.level_N <= force_N[record]:
                first, cycle_end = record, stop
    return first


def _breaks(force_N: FloatArray, drop_N: float) -> list[tuple[int, int]]:
    """Return each record that is followed by a drop of more than `drop_N` before the next one, with that drop."""
    highest = np.maximum.accumulate(force_N)
    dropped = highest - force_N > drop_N
    drops = np.flatnonzero(dropped & ~np.concatenate(([False], dropped[:-1])))
    records = np.maximum.accumulate(np.where(force_N >= highest, np.arange(force_N.size), 0))[drops]
    _, first = np.unique(records, return_index=True)
    return [(int(records[i]), int(drops[i])) for i in first]


def _stays_below(force_N: FloatArray, level_N: float) -> int:
    """Return the first of two blocks in a row below a level, the number of blocks where there is none."""
    low = force_N < level_N
    gone = np.flatnonzero(low[:-1] & low[1:])
    return int(gone[0]) if gone.size else force_N.size


def sliding_after(blocks: Blocks, block: int) -> Sliding | None:
    """Return the stretch of sliding after a break; None if the force falls away without one.

    It ends where the force leaves its level for good: motor off, direction reversed, rope gone.
    """
    force_N = blocks.force_N
    base_N, start = climb_to(force_N, block)
    first = block + 1
    while first + 1 < force_N.size and force_N[first + 1] < force_N[first]:
        first += 1
    if force_N.size - first < SHORTEST_BLOCKS:
        return None
    n_first = int(np.clip((block - start) // 4, PIECE_BLOCKS, 4 * PIECE_BLOCKS))
    level_N = median(force_N[first : first + n_first])
    length = _stays_below(force_N[first:], base_N + 0.4 * (level_N - base_N)) if level_N > base_N else 0
    if length < SHORTEST_BLOCKS:
        return None
    stretch = force_N[first : first + length]
    level_N, scatter_N = _level_and_scatter(stretch[:n_first])
    # Sliding passes its level again and again; a released rope never does.
    stays = np.flatnonzero(stretch >= level_N - max(scatter_N, 0.03 * abs(level_N - base_N)))
    stretch = stretch[: int(stays[-1]) + 1]
    if stretch.size < SHORTEST_BLOCKS:
        return None
    level_N, scatter_N = _level_and_scatter(stretch)
    return Sliding(first, first + stretch.size, level_N, median(stretch[:n_first]), scatter_N)


def _level_and_scatter(stretch: FloatArray) -> tuple[float, float]:
    """Median, and robust standard deviation around the line through the medians of both halves."""
    half = stretch.size // 2
    x = np.arange(stretch.size) - (stretch.size - 1) / 2
    slope = 0.0
    if half >= SHORTEST_BLOCKS:
        slope = (median(stretch[-half:]) - median(stretch[:half])) / (stretch.size - half)
    flat = stretch - slope * x
    return median(stretch), 1.4826 * median(np.abs(flat - median(flat)))


def roughness_N(stretch: FloatArray) -> float:
    """Return the standard deviation around a straight line within pieces of 25 blocks [N].

    The median of the pieces counts, of four or fewer the quietest.
    """
    length = min(PIECE_BLOCKS, stretch.size)
    n_pieces = stretch.size // length
    pieces = stretch[: n_pieces * length].reshape(n_pieces, length)
    x = np.arange(length) - (length - 1) / 2
    flat = pieces - pieces.mean(axis=1, keepdims=True)
    if length > 1:
        flat -= np.outer(flat @ x / float(x @ x), x)
    stds = np.sort(np.sqrt(np.mean(flat**2, axis=1)))
    # Half of a short stretch may be the release at its end.
    return float(stds[(n_pieces - 1) // 2 if n_pieces > FEW_PIECES else 0])


def slow_break(blocks: Blocks, block: int) -> SlowBreak | None:
    """Return the break-away of a force that falls too slowly for a slip; None if it may have been let down.

    A fall is a break-away if the force climbs right up to it, falls within a time that is short against the loading,
    and then stays, steady, at more than 55 % of the peak. A motor that is stopped or reversed holds the force for a
    moment first, or lets it down slowly, or far, or further and further. One that is reversed at once, quickly and
    by little leaves the same recording as a slow break-away.
    """
    force_N = blocks.force_N
    base_N, start = climb_to(force_N, block)
    longest = min(FALL_BLOCKS, int(FALL_SHARE * (block - start)))
    # What the force does after the longest fall shows its level; a part of the fall would not.
    sliding = sliding_after(blocks, block + longest) if block + longest < force_N.size else None
    if sliding is None:
        return None
    tail, level_N = force_N[block : sliding.stop], sliding.onset_N
    top_N = median(force_N[max(start, block - TOP_BLOCKS + 1) : block + 1])
    drop_N, kept_N = top_N - level_N, level_N - base_N
    if drop_N <= max(
        RESOLVED_SIGMAS * blocks.noise_N,
        RESOLVED_SIGMAS * sliding.scatter_N,
        RESOLVED_COUNTS * blocks.resolution_N,
        LEAST_DROP * (top_N - base_N),
    ):
        return None
    low = int(np.argmax(tail < level_N + 0.25 * drop_N))
    up = np.flatnonzero(tail[: low + 1] >= level_N + 0.75 * drop_N)
    high = int(up[-1]) if up.size else 0
    # The middle half of the fall, as a straight line, gives the whole.
    fall = 2.0 * (low - high)
    onset, first = block + high - int(0.25 * fall), block + int(np.ceil(high + 0.75 * fall))
    moved_N = max(STEADY * drop_N, LEVEL_DRIFT * kept_N)
    if (
        kept_N < LEAST_SHARE * (top_N - base_N)
        or fall > longest
        or sliding.stop - first < max(STAY_BLOCKS, STAY_FALLS * fall)
        or _drift_N(force_N[first:], level_N - 0.5 * kept_N) > moved_N
        or _late_rise_N(force_N[first : sliding.stop]) > moved_N
        or _held_blocks(force_N, Climb(base_N, start), block, onset) > HELD_BLOCKS
    ):
        return None
    block_s = float(blocks.time_s[-1] - blocks.time_s[0]) / (blocks.time_s.size - 1)
    return SlowBreak(
        fall_s=fall * block_s,
        drop_N=drop_N,
        share=kept_N / (top_N - base_N),
        sliding=sliding._replace(first=first),
        outlasts_slip=fall > FAST_BLOCKS,
    )


def _drift_N(after: FloatArray, gone_N: float) -> float:
    """Return by how much the level moves from the first third to the middle one, before the force is gone [N].

    The last third may be the end of the pull.
    """
    gone = np.flatnonzero(after < gone_N)
    third = (int(gone[0]) if gone.size else after.size) // 3
    return abs(median(after[:third]) - median(after[third : 2 * third])) if third else inf


def _late_rise_N(stretch: FloatArray) -> float:
    """Return how far the force has risen at its end above its middle third [N]: it was held, not slid."""
    third = stretch.size // 3
    return median(stretch[-TOP_BLOCKS:]) - median(stretch[third : 2 * third])


def _held_blocks(force_N: FloatArray, climb: Climb, block: int, onset: int) -> float:
    """Return how many blocks later the force is where the line of its loading would have taken it.

    The line is that from half to nine tenths of the height. A loading too short for one counts as held.
    """
    last = force_N[max(climb.start, onset - 2 * (TOP_BLOCKS - 1)) : onset + 1]
    reached_N = float(last.mean())
    high = force_N[climb.start : block + 1] >= climb.base_N + 0.9 * (reached_N - climb.base_N)
    rise = force_N[climb.start : climb.start + int(np.argmax(high))]
    if rise.size < SHORTEST_LINE:
        return inf
    x = np.arange(rise.size) - 0.5 * (rise.size - 1)
    slope = float(x @ rise) / float(x @ x)
    if slope <= 0.0:
        return inf
    arrival = climb.start + 0.5 * (rise.size - 1) + (reached_N - float(rise.mean())) / slope
    return onset - 0.5 * (last.size - 1) - arrival


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
