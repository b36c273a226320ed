"""The zero of a recording: its drift while the rope is at rest, and a level at rest that is none."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ropefric.arrays import FloatArray, IntArray, median
from ropefric.traces.breakaway import Breakaway, PickSettings, Status
from ropefric.traces.clock import GAP_STEPS
from ropefric.traces.events import LEAST, half_climb, least_squares, parted, still
from ropefric.traces.noise import runs_of
from ropefric.traces.results import as_read, either
from ropefric.traces.segments import AT_REST, PIECE_BLOCKS, Blocks, Prepared
from ropefric.traces.trace import ForceTrace

SMALL_ZERO, UNKNOWN, LARGE_ZERO = 0.02, 0.08, 0.12
"""Parts of F_A: a level at rest that matters, a drift that must be excluded, and what can only be a pretension."""
JUMP_BLOCKS, JUMP_SIGMAS, SWINGS_BY, LARGE_JUMP = 6, 5.0, 0.1, 0.4
"""A rope swings by more than the last part of a load that comes on at once."""
STEPS_BY = 0.5
"""A jump leaves so much less of the squares than a climb that begins in between."""
SIDE, WORSE, LONGER = 40, 4.0, (2, 4, 8, 16, 32)
"""Blocks of a level on either side of a change; what is more likely leaves less by so many variances; and in how many
samples a change that is no jump may be made, of which the last must be less likely."""
CAME_BACK = 0.25
"""A rope that rests again as at first, but for this part of a jump in between, was loaded there."""
BELOW_SIGMAS = 3.0
BURST_SIGMAS, SHORT_REST = 4.0, 0.5
"""What leaves so many times the noise for less than this part of the longest rest is a burst of it."""
PIECES = 8
"""A stretch at rest is looked at in so many pieces."""
BRIEF = 2 * PIECE_BLOCKS
"""A drift is slow: what slopes within so few blocks settles, or begins to be loaded."""
FEWEST, CLIMB_SIGMAS = 3, 2.0
DRIFT_SIGMAS, SEEN_SIGMAS, MAY_BE_SIGMAS = 4.0, 3.0, 2.0
COLOURED, COLOUR = 1.5, 2.0
"""Noise that leaves so many times more than white one would makes a slope by chance so many times more often."""
WALK_SIGMAS = 4.0
LEFT_OF_DRIFT = 0.5 / np.sqrt(3.0)
"""Standard uncertainty of what is taken off for a drift, which may be half or one and a half times that."""
RETURNED = 0.1
"""A zero that seemed to drift and stands, when the rope rests again, at less than this part of it, did not."""
ASK = 'say whether {} (a [tare] interval, or [protocol] rest = "zero") or {} (rest = "pretension")'
FROM_ZERO = 0.5
"""What drifts from the first sample on is most of the level at rest, or the rope was not at zero there."""
BUMP, AGREE = 3.0, 3.0
"""A bump is so many times higher than the levels differ, and two slopes that agree differ by so many errors."""


def with_its_zero(
    trace: ForceTrace, prepared: Prepared, result: Breakaway, settings: PickSettings
) -> Breakaway:
    """Return a result with what the rope at rest says of the zero: its drift, and a level that is none.

    A recording in newtons that was not tared may begin at a pretension, which belongs to F_A, or at an error of the
    zero, which does not.
    """
    if result.status is not Status.OK or (result.peak_N <= 0.0 and settings.rest != "zero"):
        return result
    n, blocks = prepared.blocks.n_rest, prepared.blocks
    is_tared = trace.calibration is not None or settings.rest == "pretension"
    rest_N = 0.0 if is_tared or not n else float(blocks.force_N[: n // blocks.size].mean())
    if rest_N < min(0.0, -2.0 * LARGE_ZERO * max(result.peak_N, result.peak_N - rest_N)):
        if settings.rest != "zero":
            return _may_push(result, rest_N)
        result = _taken_off(result, rest_N, f"{rest_N:.4g} N at rest were taken off as the error of the zero")
        blocks = replace(blocks, force_N=blocks.force_N - rest_N)
        prepared = replace(prepared, force_N=prepared.force_N - rest_N, blocks=blocks)
        is_tared, settings = True, replace(settings, rest="pretension")
    elif not n and settings.rest == "zero" and not is_tared and blocks.force_N[0] > AT_REST * result.peak_N:
        why = "the recording begins under load, so that it shows no zero to take off"
        return either(result, [as_read(result)], why)
    return result if result.peak_N <= 0.0 else _with_level(prepared, result, settings, is_tared=is_tared)


def _may_push(result: Breakaway, rest_N: float) -> Breakaway:
    """Return a result in doubt over a level far below nothing before the climb."""
    read = as_read(result)
    events = [replace(read, force_N=result.peak_N - rest_N, evidence="from the level at rest"), read]
    asked = ASK.format("that is an error of the zero", "the machine pushes")
    return either(result, events, f"before the climb it reads {rest_N:.3g} N: {asked}")


def _with_level(
    prepared: Prepared, result: Breakaway, settings: PickSettings, *, is_tared: bool
) -> Breakaway:
    """Return a result with the drift of the zero and a level at rest that lies near it."""
    n, blocks = prepared.blocks.n_rest, prepared.blocks
    top = int(np.searchsorted(blocks.time_s, result.peak_time_s))
    flat = rests_of(blocks, top)
    longest = max((b - a for a, b in flat), default=0)
    rests = [one for one in flat if n and _is_at_rest(prepared, *one, longest)]
    # What was hung on or taken up while the rope was at rest is no zero.
    rest_N = prepared.force_N[: min([n, *(stop * blocks.size for _, stop in rests[:1])])]
    zero_N = 0.0 if is_tared or not n else float(rest_N.mean())
    found = result
    result, why, from_N = _with_drift(blocks, rests, found, zero_N)
    starts_at_zero = from_N != zero_N
    at_rest = rests if rests and result.peak_N == found.peak_N else [(0, n // blocks.size)]
    below_N, left_N, step_N = 0.0, 0.0, 0.0
    if n and not (is_tared or starts_at_zero):
        below_N, wanders_N, left_N = _below_nothing(blocks, at_rest, result.peak_N)
    if below_N and settings.rest != "zero":
        said = (
            f"the rope at rest reads {below_N:.3g} N, less than nothing: taken off as the error of the zero"
        )
        result = _taken_off(result, below_N, said)
        result = replace(result, peak_std_N=math.hypot(result.peak_std_N, wanders_N))
    if settings.rest != "pretension":
        step_N = _shift_N(prepared, result, _jump_N(prepared, top, flat))
        # What was taken off has fallen there already.
        step_N = max(step_N, 0.0) if below_N else step_N
    zero_N = 0.0 if below_N and settings.rest != "zero" else from_N
    if settings.rest == "zero" and not is_tared:
        zero_N, step_N, left_N = left_N or zero_N + step_N, 0.0, 0.0
    if not why and settings.rest == "zero" and not is_tared and n:
        said = f"{zero_N:.4g} N at rest were taken off as the error of the zero"
        return _taken_off(result, zero_N, said)
    events = [read := as_read(result)]
    lowest_N = min((float(blocks.force_N[a:b].mean()) for a, b in rests), default=0.0)
    if not (why or below_N or is_tared) and lowest_N < -2.0 * LARGE_ZERO * result.peak_N:
        return _may_push(result, lowest_N)
    for level_N, largest, origin, what, zero, load in (
        (
            zero_N,
            LARGE_ZERO,
            "at rest",
            f"reads {zero_N:.3g} N",
            "that is an error of the zero",
            "a pretension",
        ),
        (
            left_N,
            LARGE_ZERO,
            "after a load",
            f"reads {left_N:.3g} N after a load",
            "the zero shifted",
            "the load left that",
        ),
        (
            step_N,
            LARGE_JUMP,
            "before a jump",
            f"jumps by {step_N:.3g} N at once",
            "the zero did",
            "a load came on",
        ),
    ):
        if not why and SMALL_ZERO * result.peak_N < abs(level_N) < largest * result.peak_N:
            other_N = result.peak_N - level_N
            events.append(replace(read, force_N=other_N, evidence=f"from the level {origin}"))
            why = f"the rope at rest {what}: {ASK.format(zero, load)}"
    if not why:
        # A small level may be either.
        small_N = zero_N if abs(zero_N) <= SMALL_ZERO * result.peak_N else 0.0
        said = (
            f"the rope at rest reads {zero_N:.3g} N, which counts as a pretension: if that is an error of the zero, "
            'set [protocol] rest = "zero"'
        )
        is_said = zero_N >= LARGE_ZERO * result.peak_N and settings.rest == "unknown"
        u_N = float(np.hypot(result.peak_std_N, small_N / np.sqrt(3.0)))
        return replace(result, peak_std_N=u_N, notes=(*result.notes, *[said] * is_said))
    return either(result, events, why)


def _below_nothing(blocks: Blocks, rests: list[tuple[int, int]], peak_N: float) -> tuple[float, float, float]:
    """Return the level of a rope at rest that reads less than nothing, ± what, and a lower one after a load; 0 for none.

    A rope does not push: what it reads before the climb is the zero, whatever is hung on later. Levels that differ by
    little may be one zero that wanders: their mean counts, not the lowest. After a load it may be what that left, where
    the weights hung when the recording was tared.
    """
    loaded = rests[0][0] + int(np.argmax(blocks.force_N[rests[0][0] :] > AT_REST * peak_N))
    levels_N = np.array([blocks.force_N[a:b].mean() for a, b in rests])
    first, sizes = np.array(rests)[:, 0] <= loaded, np.diff(rests, axis=1)[:, 0]
    near = first & (levels_N < levels_N[first].min() + SMALL_ZERO * peak_N)
    below_N = float(np.average(levels_N[near], weights=sizes[near]))
    std_N = math.sqrt(np.average((levels_N[near] - below_N) ** 2, weights=sizes[near]))
    left_N = float(levels_N.min())
    # A machine that pushes, too, leaves far more.
    white_N = blocks.noise_N / math.sqrt(sizes[near].sum())
    is_below = -2.0 * LARGE_ZERO * peak_N < below_N < -BELOW_SIGMAS * white_N
    is_left = left_N < min(float(levels_N[first].min()), 0.0) - SMALL_ZERO * peak_N
    return below_N if is_below else 0.0, std_N, left_N if is_left else 0.0


def _with_drift(
    blocks: Blocks, rests: list[tuple[int, int]], result: Breakaway, zero_N: float
) -> tuple[Breakaway, str, float]:
    """Return a result without a drift that is seen, why F_A is not known if it is large, and the zero that drifts.

    What may be left of it is in u.
    """
    again = _at_rest_again(blocks, rests, result)
    # So brief a rest says as much as none.
    if again is None and sum(stop - start for start, stop in rests) < BRIEF:
        return result, "", zero_N
    drift_N, std_N, walk_std_N, colour = drift(blocks, rests, result)
    is_seen = 0.0 < max(DRIFT_SIGMAS, SEEN_SIGMAS * colour) * std_N <= abs(drift_N)
    wrong_N = abs(drift_N)
    if abs(zero_N) <= SMALL_ZERO * result.peak_N:
        wrong_N = max(wrong_N, abs(drift_N + zero_N))
    why = ""
    if 0.0 < SEEN_SIGMAS * colour * std_N <= abs(drift_N) and wrong_N + std_N > SMALL_ZERO * result.peak_N:
        why = f"the zero drifts by about {abs(drift_N):.2g} N between the rope at rest and the peak"
    elif wrong_N + 2.0 * std_N > UNKNOWN * result.peak_N:
        why = f"the rope rests too briefly to exclude a drift of the zero of {wrong_N + 2.0 * std_N:.2g} N"
    if (why or is_seen) and again:
        change_N, change_std_N, part, earlier_N = again
        small_N = SMALL_ZERO * result.peak_N
        # A drift that was seen should be there still; a tension that is left may hide a part of it, but not all.
        is_gone = not is_seen or part * change_N * math.copysign(1.0, drift_N) < RETURNED * abs(drift_N)
        # A load that was taken off again may hide all of it: from before that it went on.
        is_gone &= not any(abs(other_N - drift_N) < 0.5 * abs(drift_N) for other_N in earlier_N if is_seen)
        if earlier_N and abs(earlier_N[0]) + 2.0 * change_std_N < min(small_N, RETURNED * wrong_N):
            # What was loaded at rest in between, and creeps, has gone.
            change_N = earlier_N[0]
            is_gone = True
        if is_gone and abs(change_N) + 2.0 * change_std_N < small_N:
            u_N = math.hypot(result.peak_std_N, change_std_N, change_N / math.sqrt(3.0))
            return replace(result, peak_std_N=u_N), "", zero_N
        if why and is_seen and abs(part * change_N - drift_N) + 2.0 * std_N < small_N:
            drift_N, why = part * change_N, ""
    # Whether a drift that is seen went on at one rate is not known, nor one that noise may be.
    may_be = MAY_BE_SIGMAS * colour * std_N <= abs(drift_N)
    left_N = (
        math.hypot(std_N, drift_N * (LEFT_OF_DRIFT if is_seen else 2.0 * LEFT_OF_DRIFT)) if may_be else 0.0
    )
    result = replace(result, peak_std_N=math.hypot(result.peak_std_N, left_N, walk_std_N))
    if is_seen and not why:
        drift_N, zero_N = _from_zero(blocks, rests[0], result, (drift_N, zero_N))
        said = f"the zero drifts by {drift_N:.2g} N until the peak, which was taken off"
        result = _taken_off(result, drift_N, said)
    return result, why, zero_N


def _from_zero(
    blocks: Blocks, rest: tuple[int, int], result: Breakaway, found: tuple[float, float]
) -> tuple[float, float]:
    """Return a drift since the middle of a rest, and the zero there, from the first sample on if that was at zero."""
    level_N, middle_s = (float(some[slice(*rest)].mean()) for some in (blocks.force_N, blocks.time_s))
    since_N = found[0] * (middle_s - float(blocks.time_s[0])) / (result.peak_time_s - middle_s)
    is_at_zero = found[1] != 0.0 and abs(level_N - since_N) < FROM_ZERO * abs(level_N)
    return (found[0] + since_N, level_N - since_N) if is_at_zero else found


def _taken_off(result: Breakaway, zero_N: float, said: str) -> Breakaway:
    """Return a result whose forces are counted from another zero, and say so."""
    return replace(
        result,
        peak_N=result.peak_N - zero_N,
        peak_raw_N=result.peak_raw_N - zero_N,
        kinetic_N=result.kinetic_N - zero_N,
        notes=(*result.notes, said),
    )


def _shift_N(prepared: Prepared, result: Breakaway, jump_N: float) -> float:
    """Return by how much the zero shifts where the level of a rope jumps; 0 where it rests as at first in the end.

    A load that came on or off at once is gone when the rope rests again, a zero that jumped is not.
    """
    blocks, n = prepared.blocks, prepared.blocks.n_rest
    after = _next_rest(blocks, result) if jump_N and n else None
    if after is None:
        return jump_N
    change_N = float(blocks.force_N[slice(*after)].mean() - blocks.force_N[: n // blocks.size].mean())
    return 0.0 if abs(change_N) < CAME_BACK * abs(jump_N) else jump_N


def _jump_N(prepared: Prepared, top: int, rests: list[tuple[int, int]]) -> float:
    """Return by how much the level of a rope at rest jumps before it is loaded to a top; 0 where it does not.

    First where a rest is seen, then up to half of the climb, of which a jump must be more than the machine loads.
    """
    blocks, n = prepared.blocks, JUMP_BLOCKS
    levels_N = [float(blocks.force_N[start:stop].mean()) for start, stop in rests]
    steps_N = [
        step_N
        for (one, two), (before_N, after_N) in zip(pairwise(rests), pairwise(levels_N), strict=True)
        for step_N in [_step_N(prepared, one, two)]
        # What comes back to the first level, or to the last one before it, was a load.
        if min(abs(after_N - levels_N[0]), abs(levels_N[-1] - before_N)) >= CAME_BACK * abs(step_N)
    ]
    half = half_climb(blocks.force_N, 0, top)
    rate = (float(blocks.force_N[top]) - float(blocks.force_N[half])) / max(1, top - half)
    least_N = max(JUMP_SIGMAS * prepared.noise_N, 2.0 * (n + 1) * rate)
    return max(steps_N, key=abs, default=0.0) or _jump_before_N(prepared, top, half, least_N)


def _step_N(prepared: Prepared, before: tuple[int, int], after: tuple[int, int]) -> float:
    """Return by how much a rope rests at another level later, if it came there from one sample to the next; 0 if not.

    In noise larger than the change a single step is not seen, but levels are; a load comes on in longer.
    """
    size = prepared.blocks.size
    start = max(before[0], before[1] - SIDE) * size
    force_N = prepared.force_N[start : min(after[1], after[0] + SIDE) * size]
    n, y = force_N.size, force_N - force_N.mean()
    # Of a change that begins after a sample j and takes w samples, x = (i - j)/w up to 1: twice summed from the end.
    sums = np.cumsum(np.cumsum(y[::-1]))[::-1]
    left_N2, found = [], []
    for w in (1, *LONGER):
        j = np.arange(LEAST, n - w - LEAST)
        if not j.size:
            return 0.0
        x = 0.5 * ((n - 1 - j) * (n - j) - (n - 1 - j - w) * (n - j - w)) / w
        xx = (w - 1) * (2 * w - 1) / (6.0 * w) + n - j - w - x**2 / n
        xy = (sums[j + 1] - sums[j + 1 + w]) / w
        best = int(np.argmax(xy**2 / xx))
        left_N2.append(float(y @ y - xy[best] ** 2 / xx[best]))
        found.append((int(j[best]), float(xy[best] / xx[best])))
    worse_N2 = WORSE * min(left_N2) / n
    at, jump_N = found[0]
    at_once = left_N2[0] <= min(left_N2) + worse_N2 < left_N2[-1]
    return jump_N if at_once and not _is_the_chain(prepared, start + at) else 0.0


def _is_the_chain(prepared: Prepared, at: int) -> bool:
    """Return whether the step after a sample is one of a gap, or of a converter that stuck or holds its values."""
    force_N, steps_s = prepared.force_N, np.diff(prepared.time_s)
    sides = force_N[max(0, at + 1 - LEAST) : at + 1], force_N[at + 1 : at + 1 + LEAST]
    is_gap = steps_s[at] > GAP_STEPS * median(steps_s)  # in which the machine loads on
    return bool(is_gap or min(map(np.ptp, sides)) == 0.0 or _is_stuck(prepared, at, at + 2))


def _jump_before_N(prepared: Prepared, top: int, stop: int, least_N: float) -> float:
    """Return the largest jump of a low force before a block, if it is more than so much; 0 if not.

    From one sample to the next and without a swing no load comes on: a rope with some mass carries it.
    """
    blocks, n = prepared.blocks, JUMP_BLOCKS
    if stop < 2 * n + 1:
        return 0.0
    means = sliding_window_view(blocks.force_N[:stop], n).mean(axis=1)
    jumps_N = means[n + 1 :] - means[: -n - 1]
    is_low = np.abs(means[: -n - 1] - means[0]) < LARGE_ZERO * float(blocks.force_N[top])
    at = int(np.argmax(np.abs(jumps_N) * is_low))
    jump_N = float(jumps_N[at])
    part = prepared.force_N[at * blocks.size : (at + 2 * n + 1) * blocks.size]
    steps = np.diff(part) * np.sign(jump_N)
    k = int(np.argmax(steps)) + 1
    if _is_the_chain(prepared, at * blocks.size + k - 1):
        return 0.0
    beside = np.minimum(np.arange(part.size) // k, 1)
    left_N = np.abs(part - np.where(beside, means[at + n + 1], means[at]))
    # What comes back to the first level was a load.
    back = abs(float(means[at + n + 1] - means[0])) < CAME_BACK * abs(jump_N) and at > 0
    sudden = steps[k - 1] > (1.0 - SWINGS_BY) * abs(jump_N) - 3.0 * prepared.noise_N
    stays = np.count_nonzero(left_N > SWINGS_BY * abs(jump_N) + 3.0 * prepared.noise_N) <= 0.02 * part.size
    if back or not (sudden and stays and abs(jump_N) > least_N):
        return 0.0
    # Nor is it a climb that begins there.
    x = np.arange(part.size)
    bends = np.maximum(x - x[: -2 : blocks.size, None], 0.0)
    climbs_N2, _ = least_squares(np.stack([np.ones_like(bends), bends], axis=-1), part)
    stands_N2 = sum(float(((side - side.mean()) ** 2).sum()) for side in (part[:k], part[k:]))
    return jump_N if stands_N2 < STEPS_BY * climbs_N2 else 0.0


def rests_of(blocks: Blocks, top: int) -> list[tuple[int, int]]:
    """Return the stretches before the climb to a top in which the rope is at rest, in blocks.

    A slack that is taken up, weights that are hung on and a snag part them.
    """
    force_N = blocks.force_N
    half, low_N = half_climb(force_N, 0, top), float(force_N[: top + 1].min())
    rate = (float(force_N[top]) - float(force_N[half])) / max(1, top - half)
    if half < 2 * LEAST or rate <= 0.0:
        return []
    low = force_N[:half] < low_N + AT_REST * (float(force_N[top]) - low_N)
    flat = runs_of(still(force_N[:half], rate, blocks.noise_N) & low)
    return [part for start, stop in flat.tolist() for part in parted(force_N, start, stop)]


def _is_at_rest(prepared: Prepared, start: int, stop: int, longest: int) -> bool:
    """Return whether a stretch without a slope is a rope at rest: no converter that stuck, no burst of noise."""
    blocks = prepared.blocks
    if _is_stuck(prepared, start * blocks.size, stop * blocks.size):
        return False
    is_burst = float(blocks.force_N[start:stop].std()) >= BURST_SIGMAS * blocks.noise_N
    return not is_burst or stop - start > SHORT_REST * longest


def _is_stuck(prepared: Prepared, start: int, stop: int) -> bool:
    """Return whether the converter stuck somewhere between two samples."""
    return any(first < stop and last > start for first, last in prepared.stuck.tolist())


def drift(
    blocks: Blocks, rests: list[tuple[int, int]], result: Breakaway
) -> tuple[float, float, float, float]:
    """Return how far the zero drifts from the first of some stretches at rest until the peak, ± what, and wanders [N].

    The last says how many times larger than white noise would have it the uncertainty is.

    Their levels differ by what was hung on, unless a bump lies between; the slope that they share goes on where it
    stands out of the noise, and so does their random walk: the means of pieces differ by more than white noise lets
    them. The force of a sliding rope drifts with it: where that agrees it counts, and one that stays says there is none.
    """
    n = max((stop - start for start, stop in rests), default=0) // PIECES
    if n * blocks.size < LEAST:
        return 0.0, 0.0, 0.0, 1.0
    means, at, bumps = _pieces(blocks, rests, n)
    if not means:
        return 0.0, 0.0, 0.0, 1.0
    white_N = blocks.noise_N / np.sqrt(n)
    while means[-1].size > FEWEST and _begins_to_climb(means[-1], white_N):
        means[-1], at[-1] = means[-1][:-1], at[-1][:-1]
    own = np.repeat(np.arange(len(means)), [each.size for each in means])
    times_s, means_N = np.concatenate(at), np.concatenate(means)
    slope, std, left_N = _common_slope(times_s, means_N, own, white_N)
    colour = COLOUR if left_N > COLOURED * white_N else 1.0
    if any(bumps):
        one = np.cumsum([0, *np.logical_not(bumps)])[own]
        shared, shared_std, _ = _common_slope(times_s, means_N, one, white_N)
        # Where the stretches themselves do not rise, something was taken up in between after all.
        if abs(shared - slope) < AGREE * std:
            slope, std = shared, shared_std
    since_s = float(result.peak_time_s - at[0].mean())
    slope, std = _with_sliding(blocks, result, (slope, std), since_s)
    # The steps of a random walk add up; those of noise that is slow, but no walk, do not.
    near, far = (
        np.concatenate([each[lag:] - each[:-lag] for each in means if each.size > 2] or [np.zeros(1)])
        for lag in (1, 2)
    )
    near_N2 = float(np.mean(near**2))
    walk_N2 = min(near_N2 - 2.0 * white_N**2, float(np.mean(far**2)) - near_N2)
    if walk_N2 < WALK_SIGMAS * white_N**2:
        walk_N2 = 0.0
    since = max(result.peak_time_s - at[0][-1], 0.0) / float(at[0][1] - at[0][0])
    return slope * since_s, std * since_s, float(np.sqrt(walk_N2 * since)), colour


def _pieces(
    blocks: Blocks, rests: list[tuple[int, int]], n: int
) -> tuple[list[FloatArray], list[FloatArray], list[bool]]:
    """Return the means of pieces of stretches at rest, when, and whether a bump lies between a stretch and the last."""
    force_N, ends = blocks.force_N, 0
    means: list[FloatArray] = []
    at: list[FloatArray] = []
    bumps = []
    for start, stop in rests:
        # The ends may belong to what parts it from the next, the last of it to a soft start.
        cut = (stop - start) // 8
        first = start + cut * (start > 0)
        count = (stop - cut - first) // n
        if count < 2:
            continue
        pieces, times = _means(blocks, first, count, n)
        if means:
            edges = float(means[-1][-1]), float(pieces[0])
            bump_N = float(force_N[ends : start + 1].max()) - max(edges)
            bumps.append(bump_N >= BUMP * abs(edges[0] - edges[1]))
        means.append(pieces)
        at.append(times)
        ends = stop
    return means, at, bumps


def _at_rest_again(
    blocks: Blocks, rests: list[tuple[int, int]], result: Breakaway
) -> tuple[float, float, float, list[float]] | None:
    """Return by how much the rope rests at another level at the end, ± what, and the part of it due at the peak.

    Another level may be a tension that was left, or a drift; the same level says that there is no drift. And that part
    of the change since each of the stretches before the last one [N].
    """
    after = _next_rest(blocks, result)
    if not rests or after is None:
        return None
    (start, stop), (begin, end) = rests[-1], after
    parts = (start, stop - (stop - start) // 8), (begin + (end - begin) // 8, end)
    if min(last - first for first, last in parts) < PIECES:
        return None
    (before_N, before_s), (after_N, after_s) = (
        _means(blocks, first, PIECES, (last - first) // PIECES) for first, last in parts
    )
    std_N = math.sqrt((before_N.var(ddof=1) + after_N.var(ddof=1)) / PIECES)
    since_s = result.peak_time_s - float(blocks.time_s[slice(*rests[0])].mean())
    part = since_s / float(after_s.mean() - before_s.mean())
    last_N, last_s = float(after_N.mean()), float(after_s.mean())
    n = blocks.n_rest // blocks.size
    earlier_N = [
        (last_N - float(blocks.force_N[a:b].mean())) * since_s / (last_s - float(blocks.time_s[a:b].mean()))
        for a, b in ([(0, n)] if PIECES <= n <= rests[0][0] else []) + rests[:-1]
    ]
    return last_N - float(before_N.mean()), std_N, part, earlier_N


def _next_rest(blocks: Blocks, result: Breakaway) -> tuple[int, int] | None:
    """Return the stretch in which the rope rests after it was let down, before it is loaded again, in blocks."""
    force_N, slid_N = blocks.force_N, result.kinetic_N if result.kinetic_N > 0.0 else result.peak_N
    is_high = force_N >= 0.5 * min(slid_N, result.peak_N)
    is_high[: int(np.searchsorted(blocks.time_s, result.peak_time_s)) + 1] = True
    for start, stop in runs_of(~is_high).tolist():
        back = replace(blocks, force_N=force_N[start - 1 : stop][::-1])
        begin, end = max(rests_of(back, stop - start), key=lambda one: one[1] - one[0], default=(0, 0))
        if end - begin > PIECES + 1:  # what slips to nothing rests for no time
            return stop - end, stop - begin
    return None


def _means(blocks: Blocks, first: int, count: int, n: int) -> tuple[FloatArray, FloatArray]:
    """Return the force and the time of pieces of `n` blocks."""
    force_N, time_s = (
        some[first : first + count * n].reshape(count, n).mean(axis=1)
        for some in (blocks.force_N, blocks.time_s)
    )
    return force_N, time_s


def _with_sliding(
    blocks: Blocks, result: Breakaway, found: tuple[float, float], since_s: float
) -> tuple[float, float]:
    """Return a slope of the zero and its standard error with what the force of sliding says of it."""
    slid = next((phase for phase in result.phases if phase.name == "sliding"), None)
    start, stop = np.searchsorted(blocks.time_s, (slid.start_s, slid.end_s)).tolist() if slid else (0, 0)
    n = 3 * (stop - start) // (4 * PIECES)  # at first a rope may slide less easily
    if not n:
        return found
    slope, std = found
    pieces_N, times_s = _means(blocks, stop - PIECES * n, PIECES, n)
    other, other_std, _ = _common_slope(
        times_s, pieces_N, np.zeros(PIECES, dtype=np.int64), blocks.noise_N / np.sqrt(n)
    )
    most = abs(other) + 2.0 * other_std
    if most * since_s < SMALL_ZERO * result.peak_N:
        return float(np.clip(slope, -most, most)), min(std, most)
    both = float(np.hypot(std, other_std))
    if abs(slope - other) < 2.0 * both:
        weight = (std / both) ** 2
        return slope + weight * (other - slope), float(std * np.sqrt(1.0 - weight))
    return (other, other_std) if other_std < std and most < abs(slope) + 2.0 * std else found


def _begins_to_climb(means_N: FloatArray, white_N: float) -> bool:
    """Return whether the last mean lies above the line through those before it: the motor starts softly."""
    n = means_N.size - 1
    x = np.arange(n) - 0.5 * (n - 1)
    ahead = n - 0.5 * (n - 1)
    line_N = float(means_N[:-1].mean()) + float(x @ means_N[:-1]) / float(x @ x) * ahead
    return bool(
        means_N[-1] - line_N > CLIMB_SIGMAS * white_N * np.sqrt(1.0 + 1.0 / n + ahead**2 / float(x @ x))
    )


def _common_slope(
    x: FloatArray, y: FloatArray, group: IntArray, white_N: float
) -> tuple[float, float, float]:
    """Return the slope that groups share, each with a level of its own, its standard error, and what is left [N]."""
    x, y = (some - (np.bincount(group, some) / np.bincount(group))[group] for some in (x, y))
    slope = float(x @ y) / float(x @ x)
    left_N = float(np.sqrt(((y - slope * x) ** 2).sum() / max(1, x.size - int(group[-1]) - 2)))
    return slope, float(max(white_N, left_N) / np.sqrt(x @ x)), left_N
