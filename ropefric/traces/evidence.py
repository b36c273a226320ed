"""What speaks for a slip and what for a motor: whether a fall stands out, swings, is loaded again, is quiet after it.

And why a recording may not show its peak: the converter was at its limit, stuck, cut off, or left samples out.
"""

import math
from itertools import pairwise

import numpy as np

from ropefric.arrays import FloatArray, median
from ropefric.traces.breakaway import Status
from ropefric.traces.clock import GAP_STEPS
from ropefric.traces.events import (
    GROWTH,
    LEAST_PEAK,
    STICKS,
    TINY,
    UNLOADED,
    Fall,
    Pull,
    as_loaded,
    half_climb,
    loading_rate,
)
from ropefric.traces.noise import noise_std, runs_of
from ropefric.traces.segments import PIECE_BLOCKS, Prepared, Sliding, roughness_N, sliding_after
from ropefric.traces.slips import (
    FEW_BLOCKS,
    FEWEST_TEETH,
    HALF,
    LARGER,
    LEAST_DROP,
    SMALL_GROWTH,
    TALL,
    Candidate,
    rate_of,
)
from ropefric.traces.trace import ForceTrace

RESOLVED_SIGMAS = 4.0
FEWEST_PIECES, WANDER = 5, 3.0
"""A force wanders that leaves a line by so many times more than it did at rest and in the climb, in so many pieces."""
HIGHER, ENOUGH = 1.25, 0.25
"""A peak is so much higher than any wiggle of what slides, in a stretch of at least this part of the climb."""
QUIET_SIGMAS = 1.5
SWING, SETTLES, DAMPED, UNDAMPED, HALF_PERIODS = 2.0, 3.0, 0.1, 1.1, 5.0
"""A swing passes its level as fast up as down, falls below it, hardly further than it rose, and follows a load that
comes on within few periods; up faster where the load still comes on."""
BACK_AGAIN = 1.5
"""It comes back half way within this part of the time in which it came down."""
SLOW_SWING, OVERSHOOT = 2.0, 2.0
"""A mass that was loaded at a rate r and is stopped swings by r/ω, no more than so many times that, and
so many half periods take no longer than its climb."""
BENT, FEWEST_TO_BEND = 0.58, 8
"""So much of the last rise of a swing lies in its first half, where a climb that goes straight on has half; it takes so
many blocks to tell."""
DIES = 0.25
"""What swings on falls by this part of the first swing again; slow waves are smooth, but no noise."""
WAVES, LARGE_WAVES, SLOWEST, FASTEST = (0.1, 0.05, 0.02), 0.06, 0.4, 1.25
"""One wave, two or more that are slips are this part of the force at least, and rise as fast as the machine loads."""
GENTLE, SLOWER_THAN_LOADED, ALIKE = 0.25, 0.75, 0.18
"""Rounded ones rise as fast in their steepest part only, never so fast on the whole, and are alike."""
LONG_TRAIN, REGULAR = 5, 0.2
"""Fewer waves are alike by chance."""
SMOOTH, CHANCE = 8, 2.0
"""What a sliding force goes up and down by, in means of so many blocks: so many times what noise does."""
TOOTH = 0.3
"""Smaller against the typical one, a fall is the creep or the echo of a tooth."""
LARGEST = 1.5
CLEAR = 0.1
SWINGS_OUT = 8
"""A rope that comes off swings out at nothing: seen over so many times the first fall."""
LASTS = 0.25
"""What stays at its level for less than this part of the climb is no evidence that the motor still turns."""
TURNS, STRAIGHT, CREEPS = 0.02, (0.55, 1.2), 0.08
"""A peak turns at once that falls by more than this part of its height, where the last part of the climb, as high as
that fall, was loaded at this part of the machine's rate; a held rope creeps at this part of it."""
OTHER_RATE = 2.0
"""A motor lets loads down at much the same rate, within this factor."""
AT_ONCE = 8
"""A machine that turns on is seen within this part of the climb after a fall."""
GIVEN, SAGS, SLOWS, LET_DOWN = (0.2, 0.5), 0.1, 1.1, 0.4
"""A rope that slides gives way by more than creep takes and less than a motor; half way it has given so much more than
half of that, in the last quarter less than before, and far more slowly than a motor lets down."""
SAWTOOTH, LONGEST_RISE = 0.4, 4.0
"""A slip takes less than the first part of the time in which the machine loads again; in a train no such time is so
many times as long as they usually are."""


def stands_out(noise_N: float, force_N: FloatArray, candidate: Candidate, sliding: Sliding) -> bool:
    """Return whether a fall is that of a static peak, not the highest wiggle of a force that merely levels off."""
    fall = candidate.fall
    above_N = fall.top_N - sliding.onset_N
    if above_N > RESOLVED_SIGMAS * max(sliding.scatter_N, noise_N):
        return True
    # The first of many wiggles is seldom the highest, and by so much never.
    slid = force_N[sliding.first : sliding.stop]
    if fall.top_N - float(slid.max()) > LEAST_DROP * candidate.height_N:
        return True
    long = slid.size >= ENOUGH * (fall.top - fall.start)
    if long and above_N > max(RESOLVED_SIGMAS * noise_N, HIGHER * _wanders_by_N(slid)):
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
    waves = [g for g in candidate.later if g.top < sliding.stop]
    return (
        (fall.drop_N > LEAST_DROP * height_N and len(teeth) >= LONG_TRAIN and _is_regular(teeth))
        or (fall.drop_N > LEAST_PEAK * height_N and _is_sawtooth(force_N, [fall, *waves]))
        or _is_loaded_by_the_machine(force_N, candidate, waves)
        or _turns_at_once(force_N, candidate)
    )


def _wanders_by_N(force_N: FloatArray) -> float:
    """Return how far a force of sliding rises above the line through it, at most."""
    x = np.arange(force_N.size) - 0.5 * (force_N.size - 1)
    return float((force_N - force_N.mean() - x * _slope(force_N)).max())


def _slope(force_N: FloatArray) -> float:
    """Return the slope of the line through a force [N per sample]."""
    x = np.arange(force_N.size) - 0.5 * (force_N.size - 1)
    return float(x @ (force_N - force_N.mean())) / max(float(x @ x), TINY)


def _is_loaded_by_the_machine(force_N: FloatArray, candidate: Candidate, teeth: list[Fall]) -> bool:
    """Return whether all rises between slips are as a machine loads: a force that only wanders rises at any rate."""
    first = candidate.fall
    falls = [first, *(g for g in teeth if g.drop_N >= TOOTH * first.drop_N)]
    if first.drop_N <= WAVES[min(len(falls), FEWEST_TEETH) - 1] * candidate.height_N:
        return False
    rates, steepest = (
        np.array([rate(fall, after) / max(candidate.rate, TINY) for fall, after in pairwise(falls)])
        for rate in (
            lambda fall, after: (after.top_N - fall.bottom_N) / max(1, after.top - fall.bottom),
            lambda fall, after: loading_rate(force_N, fall.bottom, after.top),
        )
    )
    if not rates.size:
        return True
    if first.drop_N > LARGE_WAVES * candidate.height_N and rates[:FEWEST_TEETH].min() >= SLOWEST:
        return bool(rates.max() <= FASTEST)
    # Rounded ones are loaded at the machine's rate for a part of the time only.
    high_N, low_N = (np.array([getattr(fall, end) for fall in falls]) for end in ("top_N", "bottom_N"))
    low_N = low_N if falls[-1].reloads else low_N[:-1]
    apart_N = max(median(np.abs(x - median(x))) for x in (high_N, low_N))
    rounded = rates.max() <= SLOWER_THAN_LOADED and GENTLE <= median(steepest) <= FASTEST
    return bool(rounded and apart_N < ALIKE * first.drop_N)


def _turns_at_once(force_N: FloatArray, candidate: Candidate) -> bool:
    """Return whether a load climbs straight until it falls: a rope that only comes to slide bends long before."""
    fall, height_N = candidate.fall, candidate.height_N
    top = fall.bottom + int(np.argmax(force_N[fall.bottom : candidate.pull.stop]))
    higher = float(force_N[top]) > fall.top_N + GROWTH * height_N
    # Far higher comes what wears in, slowly, or what the motor had not loaded yet.
    if higher and loading_rate(force_N, fall.bottom, top) > STICKS * candidate.rate:
        return False
    climb_N = fall.top_N - force_N[fall.start : fall.top + 1]
    half, most = (int(np.argmax(climb_N <= part * height_N)) for part in (0.5, 0.25))
    last = climb_N.size - 1 - int(np.flatnonzero(climb_N >= min(fall.drop_N, climb_N.max()))[-1])
    if fall.drop_N <= TURNS * height_N or half == 0 or most - half < 2 or not last:
        return False
    upper_N = climb_N[half : most + 1]
    rate = -_slope(upper_N)
    # Where the line through the third quarter of the climb is when the force turns.
    above_N = rate * (climb_N.size - 1 - 0.5 * (half + most)) - float(upper_N.mean())
    slowest, fastest = (part * rate * last for part in STRAIGHT)
    straight = abs(above_N) <= fall.drop_N and slowest <= fall.drop_N <= fastest
    return straight and fall.drop_N > CREEPS * rate * (fall.bottom - fall.top)


def _is_regular(teeth: list[Fall]) -> bool:
    """Return whether falls come again and again at the same time and by the same amount, as those of stick-slip."""
    drops = np.array([tooth.drop_N for tooth in teeth])
    apart = np.diff([float(tooth.top) for tooth in teeth])
    return all(float(np.abs(x - np.median(x)).mean()) < REGULAR * float(np.median(x)) for x in (drops, apart))


def _is_sawtooth(force_N: FloatArray, falls: list[Fall]) -> bool:
    """Return whether falls take far less time than the rises between them: what wanders goes up as fast as down."""
    teeth = [g for g in falls if g.reloads and g.drop_N >= TOOTH * falls[0].drop_N]
    if len(teeth) < LONG_TRAIN or teeth[0] is not falls[0]:
        return False
    rises = np.array([float(max(1, after.top - g.bottom)) for g, after in pairwise(teeth)])
    parts = np.array([fall_blocks(force_N, g) for g in teeth[:-1]]) / rises
    return bool(median(parts) < SAWTOOTH and parts[0] < 1.0 and rises.max() < LONGEST_RISE * median(rises))


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


def rate_after(force_N: FloatArray, candidate: Candidate) -> float:
    """Return how fast the force climbs in the first part of a climb after a fall, per block; 0 if it is not seen."""
    fall = candidate.fall
    n = max(FEW_BLOCKS, (fall.top - fall.start) // AT_ONCE)
    on, quarter = force_N[fall.bottom : fall.bottom + n], n // 4
    return (median(on[-quarter:]) - median(on[:quarter])) / (n - quarter) if on.size == n else 0.0


def gives_way(force_N: FloatArray, candidate: Candidate) -> bool:
    """Return whether a rope slid that gave way little by little for as long as it was loaded, then was let down.

    The corner between the two lies farthest above the straight line from the top down. A held rope creeps by less, and
    what is let down all the way does not slow down before.
    """
    fall, height_N = candidate.fall, candidate.height_N
    down = force_N[fall.top : fall.bottom + 1]
    corner = int(np.argmax(down - np.linspace(down[0], down[-1], down.size)))
    climb = fall.top - half_climb(force_N, candidate.pull.start, fall.top)
    if corner < max(climb, 4):
        return False
    gave_N, quarter = float(down[0] - down[corner]), corner // 4
    middle_N, late_N = (
        median(down[at - quarter // 2 : at + quarter // 2 + 1]) for at in (corner // 2, corner - quarter)
    )
    last_N, let_N = late_N - float(down[corner]), float(down[corner] - down[-1])
    slows = float(down[0]) - middle_N > (0.5 + SAGS) * gave_N and middle_N - late_N > SLOWS * last_N
    fast = last_N / quarter < LET_DOWN * let_N / max(1, down.size - 1 - corner)
    much_N = GIVEN[0] * height_N
    return much_N < min(gave_N, let_N) and gave_N < GIVEN[1] * height_N and slows and fast


def left_after_N(force_N: FloatArray, candidate: Candidate) -> float:
    """Return the load that stays long after a fall, however it swings or slips on [N]; 0 where that is not seen."""
    fall, pull = candidate.fall, candidate.pull
    after = force_N[fall.settled : fall.settled + max(FEW_BLOCKS, int(LASTS * (fall.top - pull.start)))]
    long = after.size >= SWINGS_OUT * (fall.settled - fall.top)
    return median(after[after.size // 2 :]) - pull.base_N if long else 0.0


def comes_off(force_N: FloatArray, pull: Pull, other: Pull) -> bool:
    """Return whether a pull that ended without sliding is followed by a higher one, or by another after a rest.

    What the machine loaded again after its fall was not off, nor what stayed loaded for as long as it was loaded.
    """
    rate, top = rate_of(force_N, pull), max(pull.falls, key=lambda g: g.top_N)
    loaded_again = any(
        g.top > top.top
        and g.top_N - pull.base_N >= HALF * (top.top_N - pull.base_N)
        and as_loaded(g.top_N - float(force_N[g.start]), rate, g.top - g.start)
        for g in pull.falls
    )
    stayed = force_N[top.settled : top.settled + top.top - top.start]
    loaded_again |= median(stayed) > pull.base_N + UNLOADED * (top.top_N - pull.base_N)
    off, again = pull.falls[-1].settled, other.start + int(np.argmax(force_N[other.start : other.stop]))
    base_N = pull.base_N + TALL * (pull.top_N - pull.base_N)
    loaded = int(np.count_nonzero(force_N[pull.start : off] >= base_N))
    rests = int(np.count_nonzero(force_N[off:again] < base_N)) > 0.5 * loaded
    return other.top_N >= (0.5 if rests and not loaded_again else LARGER) * pull.top_N


def passes_away(force_N: FloatArray, pull: Pull, other: Pull) -> bool:
    """Return whether a pull falls off sooner than it was loaded, before a higher one, as from a snag: nothing slid."""
    high = np.flatnonzero(force_N[pull.start : pull.stop] > pull.base_N + HALF * (pull.top_N - pull.base_N))
    top = int(np.argmax(force_N[pull.start : pull.stop]))
    if not pull.unloads or np.count_nonzero(high > top) >= np.count_nonzero(high <= top) + FEW_BLOCKS:
        return False
    return other.top_N > pull.top_N and comes_off(force_N, pull, other)


def is_let_down_later(force_N: FloatArray, fall: Fall, sliding: Sliding, base_N: float) -> bool:
    """Return whether the motor lets the load down after a stretch of sliding, far faster or slower than it fell."""
    down, up_N = force_N[sliding.stop - 1 :], fall.level_N - base_N
    low = np.flatnonzero(down <= base_N + UNLOADED * up_N)
    high = np.flatnonzero(down[: low[0]] >= base_N + (1.0 - UNLOADED) * up_N) if low.size else low
    if not high.size:
        return False
    rate = (1.0 - 2.0 * UNLOADED) * up_N / int(low[0] - high[-1])
    own = fall.drop_N / max(1.0, fall_blocks(force_N, fall))
    return not own / OTHER_RATE < rate < OTHER_RATE * own


def comes_on(prepared: Prepared, candidate: Candidate) -> bool:
    """Return whether a fall is that of a load that comes on and swings, before the motor loads on to a higher force."""
    fall = candidate.fall
    higher = any(g.top_N > (1.0 + SMALL_GROWTH) * fall.top_N for g in candidate.later)
    if not higher or fall.sudden:
        return False
    sliding = sliding_after(prepared.blocks, fall, candidate.pull.base_N)
    return sliding is not None and swings(prepared, fall, sliding)


def swings(prepared: Prepared, fall: Fall, sliding: Sliding, rate: float = 0.0) -> bool:
    """Return whether a force swings around a level, passing it as fast up as down, until it is quiet or the end.

    A load that comes on does, but only if it comes on within a few periods of the swing; and the masses of a machine
    that stops, which fall no faster than it loaded them.
    """
    force_N, level_N = prepared.blocks.force_N, sliding.level_N
    last = fall.bottom if fall.reloads else min(fall.bottom, 2 * fall.settled - fall.top)
    bottom = fall.settled + int(np.argmin(force_N[fall.settled : min(last + 1, sliding.stop)]))
    # The lowest of rough values lies below their level as well: what counts is the mean around it.
    near = max(1, (fall.settled - fall.top) // 4)
    bottom_N = float(force_N[max(fall.top, bottom - near) : min(bottom + near + 1, sliding.stop)].mean())
    climb, down = force_N[fall.start : fall.top + 1], force_N[fall.top : bottom + 1]
    over_N, under_N = fall.top_N - level_N, level_N - bottom_N
    if climb[0] > level_N or not 0.0 < DAMPED * over_N < under_N:
        return False
    # What swings freely comes down no further than it went up, unless it is loaded on.
    if rate and under_N > UNDAMPED * over_N:
        return False
    # Nor further up than what was loading it carries it, nor so slowly that the climb had been one swing.
    carries, half = max(rate, loading_rate(force_N, fall.start, fall.top)), bottom - fall.top
    if rate and (over_N > OVERSHOOT * carries * half / math.pi or SLOW_SWING * half > climb.size):
        return False
    rising = climb.size - 1 - int(np.flatnonzero(climb <= level_N)[-1])
    # Within a quarter of a period it rises by seven tenths in the first half.
    half_N = float(force_N[fall.top - rising // 2]) - level_N
    if rising > FEWEST_TO_BEND and half_N < BENT * over_N:
        return False
    falling = int(np.argmax(down <= level_N))
    # And comes back as fast: what rises again slowly slides, and wears in.
    again = force_N[bottom : bottom + round(BACK_AGAIN * (bottom - fall.top)) + 2]
    if rate and float(again.max()) < bottom_N + 0.5 * under_N:
        return False
    tenth_N = 0.1 * (fall.top_N - float(climb[0]))
    lasts = int(np.argmax(climb >= fall.top_N - tenth_N)) - int(np.argmax(climb >= float(climb[0]) + tenth_N))
    after = force_N[fall.top + 3 * (bottom - fall.top) : sliding.stop]
    quiet = after.size < PIECE_BLOCKS or (
        min(roughness_N(part) for part in (after[: 2 * PIECE_BLOCKS], after[after.size // 2 :]))
        <= quiet_N(prepared, fall.start, fall.top)
        and _largest_fall_N(after[: 6 * (bottom - fall.top)])
        < DIES * (fall.top_N - bottom_N) + RESOLVED_SIGMAS * prepared.blocks.noise_N
    )
    stops = fall.drop_N < rate * (fall_blocks(force_N, fall) + 2)  # which is known to two blocks
    even = rising <= SWING * falling and falling <= SETTLES * rising
    return quiet and even and (stops or lasts <= HALF_PERIODS * (rising + falling))


def _largest_fall_N(force_N: FloatArray) -> float:
    return float((np.maximum.accumulate(force_N) - force_N).max())


def fall_blocks(force_N: FloatArray, fall: Fall) -> float:
    """Return how many blocks a fall takes: twice its middle half."""
    tail = force_N[fall.top : fall.settled + 1]
    low = int(np.argmax(tail < fall.level_N + 0.25 * fall.drop_N))
    up = np.flatnonzero(tail[: low + 1] >= fall.level_N + 0.75 * fall.drop_N)
    return 2.0 * (low - (int(up[-1]) if up.size else 0))


def is_quiet(prepared: Prepared, candidate: Candidate, sliding: Sliding) -> bool:
    """Return whether the force after a fall wanders no more than its noise: a rope at rest; sliding is rough."""
    blocks, fall = prepared.blocks, candidate.fall
    stretch = blocks.force_N[sliding.first : sliding.stop]
    if roughness_N(stretch) > quiet_N(prepared, fall.start, fall.top):
        return False
    # At longer scales, too: sliding may be smooth, but no motor at rest lets the force go up and down.
    earlier = blocks.force_N[: blocks.n_rest // blocks.size], blocks.force_N[fall.start : fall.top]
    length = 2 * PIECE_BLOCKS
    while stretch.size > FEWEST_PIECES * length:
        known_N = [roughness_N(part, length) for part in earlier if part.size > 2 * length]
        if known_N and roughness_N(stretch, length) > WANDER * max(known_N):
            return False
        length *= 2
    return True


def wanders(prepared: Prepared, candidate: Candidate, sliding: Sliding) -> bool:
    """Return whether a force goes up and down again by far more than at rest: no motor that stands does that.

    What creeps only falls, a zero that drifts goes one way. A hand is as uneven while it loads.
    """
    blocks, fall = prepared.blocks, candidate.fall
    rest, climb = blocks.force_N[: blocks.n_rest // blocks.size], blocks.force_N[fall.start : fall.top]
    # At first the masses of a machine that stops swing, and at the end it may be let down.
    stretch = blocks.force_N[sliding.first : sliding.stop]
    late = stretch[stretch.size // 2 : int(0.9 * stretch.size)]
    n = late.size // SMOOTH
    if n < 3 or rest.size < 3 * SMOOTH or float(stretch.max()) > fall.top_N:
        return False
    noise_N = 2.0 * math.sqrt(2.0 * math.log(n)) * blocks.noise_N / math.sqrt(SMOOTH)
    uneven_N = roughness_N(climb, 4 * PIECE_BLOCKS)
    return _up_and_down_N(late) > max(CHANCE * noise_N, WANDER * max(_up_and_down_N(rest), uneven_N))


def _up_and_down_N(force_N: FloatArray) -> float:
    """Return the largest rise of a smoothed force that it falls by again."""
    sums = np.concatenate([[0.0], np.cumsum(force_N - force_N[0])])
    means = (sums[SMOOTH:] - sums[:-SMOOTH]) / SMOOTH
    rise = means - np.minimum.accumulate(means)
    fall = means - np.minimum.accumulate(means[::-1])[::-1]
    return float(np.minimum(rise, fall).max())


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


SATURATED_SAMPLES = 3
"""A run at the converter's limit longer than any spike."""
CLIPPED = 3
"""A force that is cut off stays the same so many times longer than where it is not."""
SQUEEZED, STANDS, AT_LIMIT, FEWEST_AT_LIMIT, MANY_AT_LIMIT = 0.25, 0.1, 0.01, 12, 20
"""So many samples so near the top that have so little of the noise are at the limit of an amplifier: among white noise
one stretch in ten thousand."""
HIDDEN, SLIPPED = 0.3, 0.05
"""Part of a climb that a gap may hide, and of it that is missing where something slipped in a gap."""
_LEAST_CLIMB = 30
_LANDING = 5


def hidden(
    trace: ForceTrace, prepared: Prepared, block: int | None, fallen: int
) -> tuple[Status, str] | None:
    """Say why the converter did not show the peak; None if it did, or nothing broke away."""
    if saturated := _saturation_detail(trace, prepared, block, fallen):
        return Status.SATURATED, saturated
    clipped = _clipped_detail(prepared, block, fallen)
    # Noise finer than the converter's steps touches the limit again and again; a force that sticks keeps still once.
    noisy = prepared.blocks.resolution_N < prepared.noise_N
    if clipped and noisy and runs_of(prepared.force_N == prepared.force_N.max()).shape[0] > 1:
        return Status.SATURATED, clipped
    if block is not None and (squeezed := _squeezed_detail(prepared, block)):
        return Status.SATURATED, squeezed
    if block is not None and (stuck := _stuck_detail(prepared, block, fallen)):
        return Status.NO_PEAK, stuck
    if block is not None and (unseen := _unseen_detail(prepared, block)):
        return Status.NO_PEAK, unseen
    return (Status.SATURATED, clipped) if clipped else None


def _saturation_detail(trace: ForceTrace, prepared: Prepared, block: int | None, fallen: int) -> str:
    """Return where the converter sat at its ceiling up to the break; empty where it did not."""
    if trace.saturation is None:
        return ""
    begin_s, end_s = prepared.time_s[0], prepared.time_s[-1]
    if block is not None and (last := max(block + 2, fallen)) < prepared.blocks.time_s.size:
        end_s = prepared.blocks.time_s[last]
    samples, longest_s = 0, 0.0
    for start, stop in trace.saturation.high_runs:
        first_s, last_s = trace.time_s[start], trace.time_s[stop - 1]
        if stop - start >= SATURATED_SAMPLES and first_s <= end_s and last_s >= begin_s:
            samples += stop - start
            longest_s = max(longest_s, float(last_s - first_s))
    if not samples:
        return ""
    ceiling_N = float(np.nanmax(trace.force_N))
    return (
        f"the converter is at its ceiling ({ceiling_N:.4g} N) for {samples} samples, "
        f"{1000 * longest_s:.3g} ms at a time; the peak is at least {ceiling_N:.4g} N"
    )


def _clipped_detail(prepared: Prepared, block: int | None, fallen: int) -> str:
    """Return where a force in newtons is cut off: it stays exactly at its largest, far longer than anywhere else."""
    force_N = prepared.force_N
    stop = (
        force_N.size
        if block is None
        else prepared.blocks.last_sample(max(block + 2, fallen), force_N.size) + 1
    )
    top_N = float(force_N[:stop].max())
    at_top = runs_of(force_N[:stop] == top_N)
    longest = int((at_top[:, 1] - at_top[:, 0]).max())
    if longest <= SATURATED_SAMPLES or top_N < float(force_N.max()):
        return ""
    high = force_N[:stop] > 0.5 * (top_N + float(force_N[:stop].min()))
    same = runs_of((np.diff(force_N[:stop], append=np.inf) == 0.0) & high & (force_N[:stop] < top_N))
    usual = int((same[:, 1] - same[:, 0]).max(initial=0)) + 1
    if longest < CLIPPED * usual:
        return ""
    return (
        f"the force stays at exactly {top_N:.4g} N for {longest} samples, {usual} elsewhere: it is cut off there, and "
        f"the peak is at least {top_N:.4g} N"
    )


def _squeezed_detail(prepared: Prepared, block: int) -> str:
    """Return where the noise goes at the top: an amplifier at its limit lets neither force nor noise go on."""
    force_N, blocks = prepared.force_N, prepared.blocks
    top, start = blocks.first_sample(block), blocks.first_sample(half_climb(blocks.force_N, 0, block))
    top_N = float(blocks.force_N[block])
    low_N = top_N - AT_LIMIT * (top_N - float(force_N[: top + 1].min())) - 3.0 * prepared.noise_N
    below = np.flatnonzero(force_N < low_N)
    at = int(np.searchsorted(below, top))
    first = int(below[at - 1]) + 1 if at else 0
    high = force_N[first : int(below[at]) if at < below.size else force_N.size]
    n = max(FEWEST_AT_LIMIT, high.size // 3)
    climb_N = noise_std(force_N[start:first], blocks.resolution_N)
    if high.size < n or first - start < n or climb_N <= blocks.resolution_N:
        return ""
    squares = np.cumsum(np.diff(high, 2, prepend=0.0) ** 2)
    left_N = math.sqrt(max(0.0, float((squares[n:] - squares[:-n]).min(initial=np.inf))) / (6.0 * n))
    # Few samples are quiet by chance, but hardly if they do not rise any more, either.
    half, climb = high[-(high.size // 2) :], force_N[start:first]
    stands = abs(_slope(half)) < STANDS * abs(_slope(climb))
    if not 0.0 < left_N <= SQUEEZED * (1.0 if stands else min(1.0, n / MANY_AT_LIMIT)) * climb_N:
        return ""
    return (
        f"at its top, {top_N:.4g} N, the force has a noise of {left_N:.2g} N only, {climb_N:.2g} N below: the sensor or "
        f"its amplifier is at its limit, and the peak is at least {top_N:.4g} N"
    )


def _stuck_detail(prepared: Prepared, block: int, fallen: int) -> str:
    """Return where the converter stuck between half the climb to a break and the fall after it; empty if nowhere.

    What the force did meanwhile nobody knows: the peak may lie in the stretch, and what is found be a later tooth.
    """
    blocks, force_N = prepared.blocks, prepared.force_N
    begin = blocks.first_sample(half_climb(blocks.force_N, 0, block))
    end = blocks.last_sample(fallen + 1, force_N.size)
    for start, stop in prepared.stuck.tolist():
        # What falls from its top to where the converter stuck is no fall of the force.
        fell = start > blocks.first_sample(block) and force_N[start] < 0.5 * force_N[start - 1]
        if stop > begin and start <= end and (fell or not _climbed_on(prepared, start, stop)):
            lasted_s = float(prepared.time_s[stop - 1] - prepared.time_s[start])
            return (
                f"the force reads exactly {prepared.force_N[start]:.4g} N for {lasted_s:.2g} s ({stop - start} "
                f"samples) from {prepared.time_s[start]:.4g} s on, between loading and sliding: the converter "
                "or the sensor stuck, and what the force did meanwhile is unknown"
            )
    return ""


def _unseen_detail(prepared: Prepared, block: int) -> str:
    """Return where a gap in the samples may hide the peak: it hides much of the climb, or a slip; empty if nowhere.

    After a gap in which nothing slipped the force stands where the climb leads to.
    """
    blocks, time_s, force_N = prepared.blocks, prepared.time_s, prepared.force_N
    climb = half_climb(blocks.force_N, 0, block)
    begin = max(0, blocks.first_sample(climb) - 1)
    end = blocks.last_sample(block, force_N.size)
    top = begin + int(np.argmax(force_N[begin : end + 1]))
    base_N, widest_s = float(force_N[: end + 1].min()), GAP_STEPS * median(np.diff(time_s))
    height_N = float(force_N[top]) - base_N
    # Where the force fell in a gap, it slipped there, however far below the top.
    low = np.flatnonzero(force_N[:top] < base_N + SLIPPED * height_N)
    loaded = int(low[-1]) + 1 if low.size else 0
    fell = (np.diff(time_s[loaded : begin + 1]) > widest_s) & (
        np.diff(force_N[loaded : begin + 1]) < -max(SLIPPED * height_N, 6.0 * prepared.noise_N)
    )
    begin = loaded + int(np.argmax(fell)) if fell.any() else begin
    gaps_s, rises_N = np.diff(time_s[begin : top + 1]), np.diff(force_N[begin : top + 1])
    wide = gaps_s > widest_s
    rate_N_s = float(rises_N[~wide].sum()) / max(float(gaps_s[~wide].sum()), TINY)
    # What hides the very top is beside it, and in its uncertainty.
    slipped = rate_N_s * gaps_s - rises_N > max(SLIPPED * height_N, 6.0 * prepared.noise_N)
    slipped &= rate_N_s * gaps_s > SLIPPED * height_N
    hidden = np.flatnonzero(wide & ((rises_N > HIDDEN * height_N) | slipped))
    if not hidden.size:
        return ""
    k = int(hidden[-1])
    return (
        f"the force changes by {rises_N[k]:.3g} N within a gap of {1000 * gaps_s[k]:.3g} ms in the samples from "
        f"{time_s[begin + k]:.4g} s on: it may have been higher in it"
    )


def _climbed_on(prepared: Prepared, start: int, stop: int) -> bool:
    """Return whether the force stands after a stretch where the climb before it leads to: no peak lies within."""
    force_N, lasted = prepared.force_N, stop - start
    before = force_N[max(0, start - max(lasted, _LEAST_CLIMB)) : start]
    after = force_N[stop : stop + _LANDING]
    if before.size < _LEAST_CLIMB or not after.size:
        return False
    rise_N = lasted * _slope(before)
    return float(after.mean() - force_N[start]) >= 0.5 * rise_N - 2.0 * prepared.noise_N
