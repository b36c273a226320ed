"""A break-away that takes longer than a slip, as on a soft machine, told from a load that is let down."""

from dataclasses import dataclass, replace
from math import inf

import numpy as np

from ropefric.arrays import FloatArray, median
from ropefric.traces.blocks import Glance
from ropefric.traces.loading import Climb, climb_to
from ropefric.traces.sliding import Sliding, sliding_after
from ropefric.traces.slips import FAST_BLOCKS

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


@dataclass(frozen=True, slots=True, kw_only=True)
class SlowBreak:
    """A fall of the force that is slower than a slip and still a break-away."""

    fall_s: float
    drop_N: float
    share: float
    sliding: Sliding
    outlasts_slip: bool


def slow_break(view: Glance, block: int) -> SlowBreak | None:
    """Return the break-away of a force that falls too slowly for a slip; None if it may have been let down.

    A fall is a break-away if the force climbs right up to it, falls within a time that is short against the loading,
    and then stays, steady, at more than 55 % of the peak. A motor that is stopped or reversed holds the force for a
    moment first, or lets it down slowly, or far, or further and further. One that is reversed at once, quickly and
    by little leaves the same recording as a slow break-away.
    """
    force_N = view.force_N
    climb = climb_to(force_N, block)
    loading = block - climb.start
    longest = min(FALL_BLOCKS, int(FALL_SHARE * loading))
    # What the force does after the longest fall shows its level; a part of the fall would not.
    sliding = sliding_after(view, block + longest) if block + longest < force_N.size else None
    if sliding is None:
        return None
    tail, level_N = force_N[block : sliding.stop], sliding.onset_N
    top_N = median(force_N[max(climb.start, block - TOP_BLOCKS + 1) : block + 1])
    drop_N, kept_N = top_N - level_N, level_N - climb.base_N
    if drop_N <= max(
        RESOLVED_SIGMAS * view.noise_N,
        RESOLVED_SIGMAS * sliding.spread_N,
        RESOLVED_COUNTS * view.resolution_N,
        LEAST_DROP * (top_N - climb.base_N),
    ):
        return None
    low = int(np.argmax(tail < level_N + 0.25 * drop_N))
    up = np.flatnonzero(tail[: low + 1] >= level_N + 0.75 * drop_N)
    high = int(up[-1]) if up.size else 0
    # The middle half of the fall, as a straight line, gives the whole.
    fall = 2.0 * (low - high)
    onset, first = block + high - int(0.25 * fall), block + int(np.ceil(high + 0.75 * fall))
    if (
        kept_N < LEAST_SHARE * (top_N - climb.base_N)
        or fall > longest
        or sliding.stop - first < max(STAY_BLOCKS, STAY_FALLS * fall)
        or _drift_N(force_N[first:], level_N - 0.5 * kept_N) > max(STEADY * drop_N, LEVEL_DRIFT * kept_N)
        or _late_rise_N(force_N[first : sliding.stop]) > max(STEADY * drop_N, LEVEL_DRIFT * kept_N)
        or _held_blocks(force_N, climb, onset) > HELD_BLOCKS
    ):
        return None
    block_s = float(view.time_s[-1] - view.time_s[0]) / (view.time_s.size - 1)
    return SlowBreak(
        fall_s=fall * block_s,
        drop_N=drop_N,
        share=kept_N / (top_N - climb.base_N),
        sliding=replace(sliding, first=first),
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


def _held_blocks(force_N: FloatArray, climb: Climb, onset: int) -> float:
    """Return how many blocks later the force is where the line of its loading would have taken it.

    The line is that from half to nine tenths of the height. A loading too short for one counts as held.
    """
    last = force_N[max(climb.start, onset - 2 * (TOP_BLOCKS - 1)) : onset + 1]
    reached_N = float(last.mean())
    high = force_N[climb.start : climb.top + 1] >= climb.base_N + 0.9 * (reached_N - climb.base_N)
    rise = force_N[climb.start : climb.start + int(np.argmax(high))]
    if rise.size < SHORTEST_LINE:
        return inf
    x = np.arange(rise.size) - 0.5 * (rise.size - 1)
    slope = float(x @ rise) / float(x @ x)
    if slope <= 0.0:
        return inf
    arrival = climb.start + 0.5 * (rise.size - 1) + (reached_N - float(rise.mean())) / slope
    return onset - 0.5 * (last.size - 1) - arrival
