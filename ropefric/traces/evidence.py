"""What speaks for a slip and what for a motor: whether a fall stands out, swings, is loaded again, is quiet after it."""

from itertools import pairwise

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.traces.events import SAME_KIND, Fall, as_loaded
from ropefric.traces.noise import noise_std
from ropefric.traces.segments import PIECE_BLOCKS, Prepared, Sliding, roughness_N, sliding_after
from ropefric.traces.slips import FEWEST_TEETH, LEAST_DROP, SMALL_GROWTH, TINY, Candidate

RESOLVED_SIGMAS = 4.0
QUIET_SIGMAS = 1.5
SWING, DAMPED, HALF_PERIODS = 2.0, 0.2, 5.0
"""A swing passes its level as fast up as down, falls below it, and follows a load that comes on within few periods."""
WAVES, SLOWEST, FASTEST = 0.06, 0.4, 1.25
"""Waves that are slips are this part of the force at least, and rise as fast as the machine loads."""
LONG_TRAIN, REGULAR = 5, 0.2
"""Fewer waves are alike by chance."""
LEAST_PEAK = 0.01
TOOTH = 0.3
"""Smaller against the typical one, a fall is the creep or the echo of a tooth."""
LARGEST = 1.5
CLEAR = 0.1


def stands_out(noise_N: float, force_N: FloatArray, candidate: Candidate, sliding: Sliding) -> bool:
    """Return whether a fall is that of a static peak, not the highest wiggle of a force that merely levels off."""
    fall = candidate.fall
    above_N = fall.top_N - sliding.onset_N
    if above_N > RESOLVED_SIGMAS * max(sliding.scatter_N, noise_N):
        return True
    # In stick-slip the scatter is that of the teeth: they are slips themselves, and the first one counts.
    height_N = candidate.height_N
    if fall.sudden:
        return fall.drop_N > LEAST_PEAK * height_N
    teeth = [g for g in candidate.later if g.reloads]
    before = [g for g in candidate.pull.falls if g.top < fall.top and g.top_N > 0.9 * fall.top_N]
    largest_N = max((g.drop_N for g in (*teeth, *before)), default=0.0)
    fast = fall.drop_N > 1.5 * candidate.rate * fall_blocks(force_N, fall)
    if fast and (
        fall.drop_N > LARGEST * largest_N
        or (fall.drop_N > CLEAR * height_N and loads_again(force_N, candidate))
    ):
        return True
    if fall.drop_N <= max(LEAST_DROP * height_N, SAME_KIND * largest_N):
        return False
    if len(teeth) >= LONG_TRAIN and _is_regular(teeth):
        return True
    return fall.drop_N > WAVES * height_N and _is_loaded_by_the_machine(candidate, teeth)


def _is_loaded_by_the_machine(candidate: Candidate, teeth: list[Fall]) -> bool:
    """Return whether all rises between slips are as a machine loads: a force that only wanders rises at any rate."""
    falls = [candidate.fall, *(g for g in teeth if g.drop_N >= TOOTH * candidate.fall.drop_N)]
    rates = [
        (after.top_N - fall.bottom_N) / max(candidate.rate * max(1, after.top - fall.bottom), TINY)
        for fall, after in pairwise(falls)
    ]
    return len(rates) >= 2 and min(rates[:FEWEST_TEETH]) >= SLOWEST and max(rates) <= FASTEST


def _is_regular(teeth: list[Fall]) -> bool:
    """Return whether falls come again and again at the same time and by the same amount, as those of stick-slip."""
    drops = np.array([tooth.drop_N for tooth in teeth])
    apart = np.diff([float(tooth.top) for tooth in teeth])
    return all(float(np.abs(x - np.median(x)).mean()) < REGULAR * float(np.median(x)) for x in (drops, apart))


def loads_again(force_N: FloatArray, candidate: Candidate) -> bool:
    """Return whether the force is loaded again at the machine's rate after a fall, so that the motor still turned."""
    fall = candidate.fall
    # The echo of a slip is not the next one.
    later = next((g for g in candidate.later if g.drop_N >= TOOTH * fall.drop_N), None)
    again = slice(fall.bottom, candidate.pull.stop if later is None else later.top + 1)
    top = fall.bottom + int(np.argmax(force_N[again]))
    rise_N = float(force_N[top]) - fall.bottom_N
    much = rise_N >= 0.15 * (fall.top_N - fall.bottom_N)
    return fall.reloads and much and as_loaded(rise_N, candidate.rate, top - fall.bottom)


def comes_on(prepared: Prepared, candidate: Candidate) -> bool:
    """Return whether a fall is that of a load that comes on and swings, before the motor loads on to a higher force."""
    fall = candidate.fall
    higher = any(g.top_N > (1.0 + SMALL_GROWTH) * fall.top_N for g in candidate.later)
    if not higher or fall.sudden:
        return False
    sliding = sliding_after(prepared.blocks, fall, candidate.pull.base_N)
    return sliding is not None and swings(prepared, fall, sliding)


def swings(prepared: Prepared, fall: Fall, sliding: Sliding) -> bool:
    """Return whether a force swings around a level, passing it as fast up as down, until it is quiet or the end.

    A load that comes on does, but only if it comes on within a few periods of the swing.
    """
    force_N, level_N = prepared.blocks.force_N, sliding.level_N
    last = fall.bottom if fall.reloads else min(fall.bottom, 2 * fall.settled - fall.top)
    bottom = fall.settled + int(np.argmin(force_N[fall.settled : last + 1]))
    # The lowest of rough values lies below their level as well: what counts is the mean around it.
    near = max(1, (fall.settled - fall.top) // 4)
    bottom_N = float(force_N[max(fall.top, bottom - near) : bottom + near + 1].mean())
    climb, down = force_N[fall.start : fall.top + 1], force_N[fall.top : bottom + 1]
    if climb[0] > level_N or not 0.0 < DAMPED * (fall.top_N - level_N) < level_N - bottom_N:
        return False
    rising = climb.size - 1 - int(np.flatnonzero(climb <= level_N)[-1])
    falling = int(np.argmax(down <= level_N))
    tenth_N = 0.1 * (fall.top_N - float(climb[0]))
    lasts = int(np.argmax(climb >= fall.top_N - tenth_N)) - int(np.argmax(climb >= float(climb[0]) + tenth_N))
    after = force_N[fall.top + 3 * (bottom - fall.top) : sliding.stop]
    quiet = after.size < PIECE_BLOCKS or (
        roughness_N(after[: 2 * PIECE_BLOCKS]) <= quiet_N(prepared, fall.start, fall.top)
    )
    return quiet and rising <= SWING * falling and lasts <= HALF_PERIODS * (rising + falling)


def fall_blocks(force_N: FloatArray, fall: Fall) -> float:
    """Return how many blocks a fall takes: twice its middle half."""
    tail = force_N[fall.top : fall.settled + 1]
    low = int(np.argmax(tail < fall.level_N + 0.25 * fall.drop_N))
    up = np.flatnonzero(tail[: low + 1] >= fall.level_N + 0.75 * fall.drop_N)
    return 2.0 * (low - (int(up[-1]) if up.size else 0))


def is_quiet(prepared: Prepared, candidate: Candidate, sliding: Sliding) -> bool:
    """Return whether the force after a fall wanders no more than its noise: a rope at rest; sliding is rough."""
    stretch = prepared.blocks.force_N[sliding.first : sliding.stop]
    return roughness_N(stretch) <= quiet_N(prepared, candidate.fall.start, candidate.fall.top)


def quiet_N(prepared: Prepared, start: int, top: int) -> float:
    """Return the largest roughness of a rope at rest [N]: noise, or a slow creep through the converter's steps.

    The noise is that of the loading, for sliding itself is rough. A loading too short to tell gives 0.
    """
    blocks = prepared.blocks
    force_N = blocks.force_N[: top + 1]
    base_N = float(force_N[start:].min())
    loading = start + int(np.argmax(force_N[start:] >= base_N + 0.8 * (float(force_N[top]) - base_N)))
    if loading < PIECE_BLOCKS:
        return 0.0
    floor_N = blocks.resolution_N / np.sqrt(12.0 * blocks.size)
    noise_N = max(noise_std(force_N[:loading]), float(floor_N))
    return max(QUIET_SIGMAS * noise_N, 0.35 * blocks.resolution_N)
