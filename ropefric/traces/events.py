"""Falls of a force and what they are: slips, partial slips, bumps, a load held or let down.

While the rope sticks, the machine, a spring of stiffness k, loads it with dF/dt = k v. A slip by Δx takes k Δx off the
spring: the loading goes on along a line that lies lower by as much. A *partial slip* stops after a micro-slip length
and the loading goes on to a force well above; *stick-slip* falls by much the same again and again; a rope that *slides*
takes up no load at all, whatever the motor does. A *bump* (a snag, an impact) adds force that goes away again.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ropefric.arrays import BoolArray, FloatArray, median
from ropefric.traces.noise import runs_of

SETTLED = 0.3
"""A fall has ended where in as much time again it falls by less than this part of what it fell so far."""
LEAST_PEAK, GOES_ON = 0.01, 4
"""What falls by less than this part of its height is no static peak; it has not settled if within so many times as long
it falls by as much again."""
FIRST_BLOCKS, LOADED = 2, 0.1
"""A recording that climbs from its first blocks on, and from more than this part of the force, begins within a climb."""
DOWN = 0.1
UNLOADED = 0.2
"""A pull ends where the force has come back to below this part of what it was loaded to."""
STICKS, SLIDES = 0.5, 0.25
"""A rope that sticks is loaded at the machine's rate, half of it for a motor that runs unevenly; one that slides and
hardens takes up load far more slowly."""
SAME_KIND = 0.5
"""A fall of less than this part of the next one is a partial slip, not one of a train of stick-slip."""
GROWTH = 0.3
"""A train of stick-slip grows by no more than this part of its first tooth."""
FAST = 3.0
"""A force that rises or falls so many times faster than the machine loads it: no motor does that."""
SUDDEN = 0.65
"""Part of a slip that happens within two blocks; a release with a time constant of 20 ms does half of it."""
REST, SHORTEST_REST = 0.15, 8
"""A rest stays within this part of the rise that follows, for so many blocks at least."""
BENDS = 0.04
ON_THE_LINE = 0.2
PASSES, SWINGS = 0.1, 0.3
"""What passes by leaves less than this part of its fall, on either side of it; what swings all along the climb more."""
ROUND, KNOCKS = 0.75, 5.0
"""This part of a bump rises so many times faster than the machine loads, however round its top."""
ABOVE = 0.25
"""Part of a climb, in time and force, from which the rate of the machine is read above a jump."""
SLIP_SIGMAS = 8.0
"""A fall of fewer noise standard deviations cannot be timed."""
STANDS, SLOPE_SIGMAS = 0.3, 7.0
"""A rope at rest is loaded at less than this part of the machine's rate, which is so many times its uncertainty."""
LEAST, ONE_LEVEL = 8, 0.8
"""A stretch at rest has so many blocks; a step in it leaves less than this part of what a line leaves."""
TINY = 1e-300
"""Nothing is divided by less."""
UPPER, STEP, AT_ONCE = 0.75, 0.02, 0.5
"""Parts of a climb: above the first only the machine loads, and what is hung on is more than the second; it comes on
in less than the last part of the time until the motor loads."""
FAR = 0.95
"""A force that is loaded to about the double has not slipped before."""
FLAT = 0.75
"""Of the time near the top, the part that is spent at it: a half for a round one, a quarter for a corner."""
SHORTEST_HOLD = 8
NARROWER, WIDER = 0.75, 1.3
"""A parabola is 0.71 times as wide at half the height below its top, and 1.41 times at twice the height."""
_KNOTS = 20
_POINTS = 96
_SLOPES = 24  # pieces of a climb on which its rate is read
_WIDE = [
    np.linspace(0.5 * (1 - wide), 0.5 * (wide - 1), wide)
    for wide in (8, 16, 32, 64, 128, 256, 512, 1024, 2048)
]
_LINES = [(x, float(x @ x)) for x in _WIDE]


class Fall(NamedTuple):
    """A fall of the force, in blocks: the low before it, its top, where it has settled, the low after it."""

    start: int
    top: int
    settled: int
    bottom: int
    top_N: float
    level_N: float
    bottom_N: float
    has_settled: bool
    reloads: bool
    sudden: bool = False

    @property
    def drop_N(self) -> float:
        """Return how far it falls [N]."""
        return self.top_N - self.level_N

    @property
    def slips(self) -> bool:
        """Return whether the rope is loaded again after it, or it is as sudden as only a slip is."""
        return self.reloads or self.sudden


class Pull(NamedTuple):
    """A stretch in which the force goes up from a low, or had `begun` to, and comes back to it or the recording ends."""

    start: int
    stop: int
    base_N: float
    top_N: float
    unloads: bool
    falls: list[Fall]
    begun: bool


def turning_points(force_N: FloatArray, least_N: float) -> list[int]:
    """Return where the force turns by at least `least_N`, low and high in turn, a low first."""
    turns: list[int] = []
    low = high = 0
    values = force_N.tolist()
    low_N = high_N = values[0]
    rising: bool | None = None
    for i, value in enumerate(values):
        if rising is not False:
            if value > high_N:
                high, high_N = i, value
            elif high_N - value >= least_N:
                turns.extend([high] if rising else [high, high])
                rising, low, low_N = False, i, value
                continue
        if rising is not True:
            if value < low_N:
                low, low_N = i, value
            elif value - low_N >= least_N:
                turns.append(low)
                rising, high, high_N = True, i, value
    turns.append(low if rising is False else high)
    if rising is None:
        turns.insert(0, low)
    return turns


def pulls_of(force_N: FloatArray, least_N: float, noise_N: float) -> list[Pull]:
    """Return every pull of a recording with its falls of at least `least_N`."""
    turns = turning_points(force_N, least_N)
    sums = np.concatenate([[0.0], np.cumsum(force_N - force_N[0])])
    lows, highs = turns[0::2], turns[1::2]
    pulls: list[Pull] = []
    # A force that swings below where it rests was not unloaded further.
    rest_N, lowest_N = (
        float(np.partition(force_N, force_N.size // 20)[force_N.size // 20]),
        float(force_N.min()),
    )
    if rest_N > lowest_N + UNLOADED * (float(force_N.max()) - lowest_N):
        rest_N = lowest_N
    first = 0
    while first < len(highs):
        base_N, top_N = float(force_N[lows[first]]), -np.inf
        base_N = max(base_N, rest_N)
        begun = first == 0 and _is_loading_already(force_N, lows[0], highs[0])
        base_N = 0.0 if begun else base_N
        last = first
        for last in range(first, len(highs)):
            top_N = max(top_N, float(force_N[highs[last]]))
            level_N = base_N + UNLOADED * (top_N - base_N)
            if last + 1 == len(lows) or _is_unloaded(
                force_N, level_N, lows[first], highs[last], lows[last + 1]
            ):
                break
        unloads = last + 1 < len(lows)
        stop = lows[last + 1] + 1 if unloads and last + 1 < len(highs) else force_N.size
        falls = [
            fall._replace(sudden=_is_sudden(force_N, fall, noise_N))
            for k in range(first, last + 1)
            if k + 1 < len(lows)
            for fall in [
                _fall(force_N, sums, (lows[k], highs[k], lows[k + 1]), stop, least_N, reloads=k < last)
            ]
        ]
        pulls.append(Pull(lows[first], stop, base_N, top_N, unloads, falls, begun))
        first = last + 1
    return pulls


def _is_loading_already(force_N: FloatArray, start: int, top: int) -> bool:
    """Return whether a recording begins within a climb, so that what the rope was loaded from is not seen."""
    piece = (top - start) // _SLOPES
    little_N = LOADED * float(force_N[top])
    if start > FIRST_BLOCKS or piece < 1 or force_N[start] <= little_N or force_N.min() <= -little_N:
        return False
    return as_loaded(float(force_N[start + piece] - force_N[start]), loading_rate(force_N, start, top), piece)


def _is_unloaded(force_N: FloatArray, level_N: float, start: int, high: int, low: int) -> bool:
    """Return whether the force has come back to where the pull began and rests: a strong slip loads again at once."""
    if force_N[low] > level_N:
        return False
    below = high + int(np.argmax(force_N[high:] <= level_N))
    above = np.flatnonzero(force_N[low:] > level_N)
    if not above.size:
        return True
    again = (level_N - float(force_N[low])) / max(loading_rate(force_N, start, high), 1e-300)
    return low + int(above[0]) - below > 1.5 * again + 4


def _fall(
    force_N: FloatArray,
    sums: FloatArray,
    turns: tuple[int, int, int],
    stop: int,
    least_N: float,
    *,
    reloads: bool,
) -> Fall:
    """Return a fall from the turning points around it: the low before it, its top, the low after it."""
    start, top, bottom = turns
    top_N = float(force_N[top])
    last = bottom if reloads else stop
    step, settled, has_settled = 1, bottom, reloads
    while top + 2 * step + (0 if reloads else 2) < last:
        wide = max(3, step // 3)
        if reloads and top + step + wide > last:  # it was never at rest
            break
        here_N, later_N = (
            float(force_N[0] + (sums[min(at + wide, stop)] - sums[at]) / (min(at + wide, stop) - at))
            for at in (top + step, top + 2 * step)
        )
        if top_N - here_N >= 0.7 * least_N and here_N - later_N < SETTLED * (top_N - here_N):
            # What is no more than noise or a step of the converter may only halt.
            far = min(top + step + max(SHORTEST_HOLD, GOES_ON * step), last - wide)
            on_N = here_N - float(force_N[0] + (sums[far + wide] - sums[far]) / wide)
            small = top_N - here_N < LEAST_PEAK * (top_N - float(force_N[start]))
            if not small or on_N < top_N - here_N:
                settled, has_settled = top + step, True
                break
        step = max(step + 1, int(1.25 * step))
    if not has_settled:
        level_N = float(force_N[min(last, force_N.size) - 1])
    else:
        length = settled - top
        # The steps grow, so that the first half of what follows may still be falling.
        half = 0 if reloads else length // 2
        level_N = (
            float(force_N[settled])
            if reloads and settled + length > bottom
            else median(force_N[min(settled + half, last - 1) : min(settled + half + max(4, length), last)])
        )
        # The steps grow: where it was really down again is seen on the way.
        down = force_N[top : min(settled + length, force_N.size - 1) + 1] <= level_N + DOWN * (
            top_N - level_N
        )
        settled = top + max(1, int(np.argmax(down))) if down.any() else settled
    return Fall(start, top, settled, bottom, top_N, level_N, float(force_N[bottom]), has_settled, reloads)


def loading_rate(force_N: FloatArray, start: int, top: int) -> float:
    """Return the rate at which the machine loads the rope up to a top [N per block].

    Of the pieces of the climb, half of the rise is faster: neither a rest on the way nor a bump counts for much.
    """
    length = max(1, (top - start) // _SLOPES)
    at = np.arange(top - length, start - 1, -length)
    rise = np.sort(np.maximum(force_N[at + length] - force_N[at], 0.0)) if at.size else np.zeros(1)
    up = np.cumsum(rise)
    if up[-1] <= 0.0:
        return float(force_N[top] - force_N[start]) / max(1, top - start)
    return float(rise[int(np.searchsorted(up, 0.5 * up[-1]))]) / length


def rate_below(force_N: FloatArray, start: int, top: int) -> float:
    """Return the rate at which the machine loads the rope up to a top, or to below a jump that ends there."""
    # Of bumps before it nothing stays.
    force_N = np.minimum.accumulate(force_N[start : top + 1][::-1])[::-1]
    rate = loading_rate(force_N, 0, top - start)
    slow = np.flatnonzero(np.diff(force_N) <= 0.5 * rate)
    below = int(slow[-1]) + 1 if slow.size else 0
    loaded = float(force_N[below] - force_N[0]) > LOADED * float(force_N[-1] - force_N[0])
    return min(rate, loading_rate(force_N, 0, below)) if loaded and below > _SLOPES else rate


def rate_above(force_N: FloatArray, start: int, top: int, rate: float) -> float:
    """Return the rate of loading above a jump at which the climb began: weights that are hung on are no motor."""
    length = max(1, (top - start) // _SLOPES)
    at = np.arange(top - length, start - 1, -length)
    jumps = np.flatnonzero(force_N[at + length] - force_N[at] >= rate * length / FAST)
    begins = int(at[jumps[0]]) + length if jumps.size else top
    long = top - begins > ABOVE * (top - start)
    much = float(force_N[top] - force_N[begins]) > ABOVE * float(force_N[top] - force_N[start])
    return loading_rate(force_N, begins, top) if long and much else rate


def as_loaded(rise_N: float, rate: float, n_blocks: int) -> bool:
    """Return whether a force rises as the machine loads: neither as slowly as a rope that slides nor faster."""
    return STICKS * rate * n_blocks <= rise_N <= FAST * rate * n_blocks


def half_climb(force_N: FloatArray, start: int, top: int) -> int:
    """Return the first block of the upper half of a climb."""
    before = force_N[start : top + 1]
    below = np.flatnonzero(before < 0.5 * (float(before.min()) + float(force_N[top])))
    return start + min(int(below[-1]) + 1, top - start) if below.size else start


def still(force_N: FloatArray, rate: float, noise_N: float, shortest: int = 1) -> BoolArray:
    """Return in which blocks a rope is at rest: its force changes by far less than the machine loads."""
    # Means over w blocks that follow each other differ by noise of √(2/w), that is √2 w^-1.5 in slope.
    wide = (SLOPE_SIGMAS * np.sqrt(2.0) * noise_N / (STANDS * rate)) ** (2.0 / 3.0)
    rests = np.zeros(force_N.size, dtype=bool)
    if force_N.size <= 2.0 * max(wide, shortest) + 2.0:
        return rests
    w = max(shortest, int(np.ceil(wide)))
    sums = np.concatenate([[0.0], np.cumsum(force_N - force_N[0])])
    slope = np.abs(sums[2 * w :] - 2.0 * sums[w:-w] + sums[: -2 * w]) / w**2
    rests[w : force_N.size - w + 1] = slope < STANDS * rate
    rests[:w] = rests[w]  # from the beginning on
    return rests


def parted(force_N: FloatArray, start: int, stop: int) -> list[tuple[int, int]]:
    """Return the parts of a stretch between steps, which a line through all of it describes less well."""
    values, n = force_N[start:stop] - force_N[start], stop - start
    if n < 2 * LEAST:
        return [(start, stop)] if n >= LEAST else []
    x, k = np.arange(n) - 0.5 * (n - 1), np.arange(LEAST, n - LEAST + 1)
    up, total = np.cumsum(values)[k - 1], float(values.sum())
    # What is left of the sum of squares: of a line, and of two levels for every place of the step.
    line = float(values @ values) - total**2 / n - float(x @ values) ** 2 / float(x @ x)
    steps = float(values @ values) - up**2 / k - (total - up) ** 2 / (n - k)
    at = int(np.argmin(steps))
    if steps[at] >= ONE_LEVEL * line:
        return [(start, stop)]
    return [*parted(force_N, start, start + int(k[at])), *parted(force_N, start + int(k[at]), stop)]


def motor_starts(force_N: FloatArray, pull: Pull, noise_N: float, swing: int) -> tuple[int, int]:
    """Return where the machine begins to load a rope on which weights were hung, or where the pull starts; and how many.

    They come on at once, one by one, and swing around a level, each swing within `swing` blocks; a rope that had slid
    at it would not be loaded on.
    """
    start, base_N = pull.start, pull.base_N
    top = start + int(np.argmax(force_N[start : pull.stop]))
    height_N = float(force_N[top]) - base_N
    below = np.flatnonzero(force_N[start:top] < base_N + UPPER * height_N)
    if not below.size or height_N <= 0.0:
        return start, 0
    upper = start + int(below[-1])
    rate = float(force_N[top] - force_N[upper]) / (top - upper)
    if not TINY < rate < 1.0 / TINY:
        return start, 0
    # What was as high before, or nearly so, has slipped there.
    levels, most_N = [(base_N, start, start)], base_N + height_N / (1.0 + GROWTH)
    # A swing is none in the mean over one of its periods, whichever that is.
    means = (still(force_N[start:upper], rate, noise_N, wide) for wide in (swing, 2 * swing))
    rests = (runs_of(np.logical_or(*means)) + start).tolist()
    for first, stop in [part for rest in rests for part in parted(force_N, *rest)]:
        level_N = median(force_N[first:stop])
        if stop - first >= swing and base_N < level_N and force_N[start:stop].max() <= most_N:
            same = abs(level_N - levels[-1][0]) < max(SLIP_SIGMAS * noise_N, STEP * height_N)
            levels[-1:] = [(*levels[-1][:2], stop)] if same else [levels[-1], (level_N, first, stop)]
    n = 0
    for (low_N, _, left), (level_N, first, _) in pairwise(levels):
        came = force_N[max(start, left - 1) : first + 1]
        high = int(np.argmax(came >= level_N - REST * (level_N - low_N)))
        low = np.flatnonzero(came[: high + 1] <= low_N + REST * (level_N - low_N))
        long = high - int(low[-1]) if low.size else high + 1
        # A motor that loads on to where the rope slides takes longer.
        at_once = (1.0 - 2.0 * REST) * (level_N - low_N) > rate * long > 0.0
        n += at_once and long < AT_ONCE * (levels[-1][2] - first)
    doubles = height_N > (1.0 + FAR) * (levels[-1][0] - base_N)
    return (levels[-1][2], n) if n > 1 or (n == 1 and doubles) else (start, 0)


def is_bump(force_N: FloatArray, at: FloatArray, fall: Fall, rate: float) -> bool:
    """Return whether the force rose faster than the machine loads and came back to the line it had left.

    When it was measured counts in blocks as they usually are: in a gap the machine loads on.
    """
    climb = slice(fall.start, fall.top + 1)
    slow = np.flatnonzero(np.diff(force_N[climb]) <= FAST * rate * np.maximum(np.diff(at[climb]), 1.0))
    k = fall.start + (int(slow[-1]) + 1 if slow.size else 0)
    from_where = [(k, fall.top_N - float(force_N[k]) >= 0.5 * fall.drop_N)]
    # Its top may be round.
    under = np.flatnonzero(force_N[climb] <= fall.top_N - ROUND * fall.drop_N)
    if under.size:
        k = fall.start + int(under[-1])
        from_where += [(k, ROUND * fall.drop_N > KNOCKS * rate * float(at[fall.top] - at[k]))]
    for k, is_fast in from_where:
        back_N = float(force_N[fall.settled]) - (float(force_N[k]) + rate * (fall.settled - k))
        if is_fast and abs(back_N) < 0.3 * fall.drop_N:
            return True
    if _is_on_the_same_line(force_N, fall):
        return True
    # Or it was loaded from a rest, by a jog of the motor or a snag, and let down to that rest again.
    rest_N = fall.level_N
    rise_N = fall.top_N - rest_N
    low = np.flatnonzero(force_N[: fall.top] <= rest_N + REST * rise_N)
    if not low.size:
        return False
    begins = int(low[-1])
    long = max(SHORTEST_REST, round(float(at[fall.top] - at[begins])))
    before, after = force_N[max(0, begins - 2 * long) : begins], force_N[fall.settled : fall.settled + long]
    half = before.size // 2
    climbed_N = float(before[-half:].mean() - before[:half].mean()) if half else 0.0
    # A recording that begins within the climb shows no rest.
    if climbed_N > STICKS * rise_N * half / long:
        return False
    return all(
        rest.size >= SHORTEST_REST and float(np.abs(rest - rest_N).max()) < REST * rise_N
        for rest in (before, after)
    )


def passes_by(force_N: FloatArray, fall: Fall, rate: float) -> int:
    """Return where the force is back on the line of before a fall, as after a blow or a step on the floor; 0 if never.

    What a slip takes off the spring is missing for good, so that the line goes on below; what swings about the line for
    no longer than this is seen on both sides of it took nothing.
    """
    for x, square in _LINES:
        wide = x.size
        begin = fall.top - wide // 4
        end = begin + wide
        if begin < wide or end + wide > force_N.size:
            return 0
        if fall.settled >= end:
            continue
        before, after = force_N[begin - wide : begin], force_N[end : end + wide]
        one, two = float(x @ before) / square, float(x @ after) / square
        slope = 0.5 * (one + two)
        off_N = float(after.mean()) - float(before.mean()) - 2.0 * wide * slope
        most_N = PASSES * fall.drop_N
        # The climb to a slip goes along the line, a blow leaves it faster than the machine loads.
        above_N = fall.top_N - float(before.mean()) - slope * (fall.top - begin + 0.5 * (wide - 1))
        low = begin + int(np.argmin(force_N[begin : fall.top + 1]))
        rises = fall.top_N - float(force_N[low]) > FAST * rate * (fall.top - low)
        swings_N = max(float((before - slope * x).std()), float((after - slope * x).std()))
        climbs_on = as_loaded(two, one, 1) and slope * wide > fall.drop_N and swings_N < SWINGS * fall.drop_N
        if climbs_on and abs(off_N) < SWINGS * fall.drop_N:
            return end
        even = abs(one - two) * wide < 2.0 * most_N and swings_N < most_N
        if even and swings_N < 0.5 * most_N and abs(off_N) > 0.5 * fall.drop_N:
            return 0
        if not rises and above_N > 2.0 * most_N:
            continue
        if even and abs(off_N) < most_N:
            return end
    return 0


def _is_on_the_same_line(force_N: FloatArray, fall: Fall) -> bool:
    """Return whether a climb goes on after a fall along the line of before it: nothing was taken off the spring."""
    for x, square in _LINES:
        if fall.settled + x.size > force_N.size or fall.settled - 4 * x.size < 0:
            return False
        at_once = _leaves_the_line(force_N, fall, (x, square), 0)
        # What swings after it does so no longer a while later.
        if at_once or _leaves_the_line(force_N, fall, (x, square), x.size):
            return True
        if at_once is not None:
            return False
    return False


def _leaves_the_line(
    force_N: FloatArray, fall: Fall, line: tuple[FloatArray, float], late: int
) -> bool | None:
    """Return whether the climb to a top left the line that is seen so many blocks after the fall; None if not seen."""
    x, square = line
    wide = x.size
    after = force_N[fall.settled + late : fall.settled + late + wide]
    if after.size < wide or fall.top + 1 - (fall.settled - 4 * wide) <= wide:
        return None
    slope = float(x @ after) / square
    line_N = float(after.mean()) + slope * (x[0] - late)
    top_N = fall.top_N - line_N - slope * (fall.top - fall.settled)
    if slope * wide < 0.2 * fall.drop_N or top_N < 0.5 * fall.drop_N:
        return None
    before = np.arange(fall.settled - 4 * wide, fall.top + 1)
    above_N = force_N[before] - (line_N + slope * (before - fall.settled))
    apart_N = ON_THE_LINE * min(float(above_N[-1]), slope * wide)
    on = np.flatnonzero(above_N[:-1] <= apart_N)
    if not on.size or on[-1] < wide or fall.settled - before[on[-1]] > 2 * wide:
        return None
    return float(np.abs(above_N[on[-1] - wide : on[-1]]).max()) < apart_N


def _is_sudden(force_N: FloatArray, fall: Fall, noise_N: float) -> bool:
    """Return whether most of a fall, far beyond the noise, happens within two blocks."""
    if fall.drop_N < SLIP_SIGMAS * noise_N:
        return False
    ahead = force_N[fall.top : max(fall.settled, fall.top + 2) + 2]
    if ahead.size < 3:
        return fall.has_settled
    steepest = float((ahead[:-2] - np.minimum(ahead[1:-1], ahead[2:])).max())
    return steepest > SUDDEN * (
        fall.top_N - min(fall.level_N, fall.bottom_N if fall.reloads else fall.level_N)
    )


def bends_to_its_level(force_N: FloatArray, fall: Fall, noise_N: float) -> bool:
    """Return whether a fall slows down towards its level, as that of friction that weakens with the way slid.

    A motor lets a load down along a line and stops. Where the line through a quarter and three quarters of the fall
    comes to the level, a force that dies away exponentially is 14 % of the fall above it, one between two bends 7 %.
    """
    tail = force_N[fall.top : fall.settled + max(2, fall.settled - fall.top)]
    below = np.minimum.accumulate(tail)
    quarter, most = (int(np.argmax(below <= fall.top_N - part * fall.drop_N)) for part in (0.25, 0.75))
    arrives = most + 0.5 * (most - quarter)
    if most - quarter >= SHORTEST_HOLD:
        x = np.arange(quarter, most + 1) - 0.5 * (quarter + most)
        middle_N = float(tail[quarter : most + 1].mean())
        slope = float(x @ tail[quarter : most + 1]) / float(x @ x)
        arrives = 0.5 * (quarter + most) + (fall.level_N - middle_N) / min(slope, -1e-300)
        arrives = min(max(arrives, most), tail.size - 1)
    around = max(1, (most - quarter) // 10)
    left = tail[max(0, int(arrives) - around) : int(arrives) + around + 1]
    left_N = float(left.mean()) - fall.level_N if left.size else 0.0
    return bool(left_N > BENDS * fall.drop_N + 3.0 * noise_N / np.sqrt(max(1, left.size)))


def flat_top(force_N: FloatArray, fall: Fall, noise_N: float) -> str:
    """Return whether the force was "held" before it fell, is "rounded" as by a slip that begins, or "sharp".

    A motor that stops leaves a climb, a level and a fall, each with a corner; a slip that begins takes over the
    loading little by little, so that the slope goes evenly from that of the climb to that of the fall. Both are
    fitted around the top, and the one that leaves clearly less is taken.
    """
    height_N = fall.top_N - float(force_N[fall.start])
    tail = force_N[fall.top : fall.settled + 1]
    last = fall.top + int(np.argmax(tail <= fall.top_N - 0.5 * fall.drop_N))
    band_N = max(0.1 * fall.drop_N, 4.0 * noise_N)
    near = force_N[fall.start : last + 1] >= fall.top_N - band_N
    begins, ends = (fall.start + int(k) for k in np.flatnonzero(near)[[0, -1]])
    wide = force_N[fall.start : last + 1] > fall.top_N - 4.0 * band_N
    if (
        4.0 * band_N < 0.8 * height_N
        and ends - begins >= FLAT * int(wide.sum())
        and ends - begins >= SHORTEST_HOLD
    ):
        return "held"
    climb = force_N[fall.start : begins + 1]
    first = fall.start + int(np.flatnonzero(climb <= fall.top_N - min(0.35 * height_N, height_N))[-1])
    first = max(first, begins - 2 * (last - begins), fall.start)
    part = force_N[first : last + 1]
    if part.size < 8:
        return "sharp"
    size = -(-part.size // _POINTS)
    n = part.size // size
    values = part[: n * size].reshape(n, size).mean(axis=1)
    t = np.arange(n) / (n - 1)
    grid = np.linspace(0.15, 1.0, _KNOTS)
    one, two = (grid[k] for k in np.triu_indices(_KNOTS, 1))
    t1, t2 = one[:, None], two[:, None]
    inside, beyond, before = np.clip(t - t1, 0, t2 - t1), np.maximum(t - t2, 0), np.minimum(t - t1, 0)
    ones, half = np.ones_like(inside), inside**2 / (2 * (t2 - t1))
    held, at = least_squares(np.stack([ones, before, beyond], axis=2), values)
    lasts = float((t2 - t1)[at, 0]) * (n - 1) * size
    even, _ = least_squares(np.stack([ones, before + inside - half, half + beyond], axis=2), values)
    at_t, apart = np.linspace(0.05, 0.95, 3 * _KNOTS), 0.9 / (3 * _KNOTS - 1)
    for _ in range(2):
        since = t - at_t[:, None]
        corners = np.stack([np.ones_like(since), np.minimum(since, 0), np.maximum(since, 0)], axis=2)
        corner, at = least_squares(corners, values)
        at_t = at_t[at] + np.linspace(-apart, apart, _KNOTS)
    # No motor stops and goes back within less than the fall takes.
    shortest = max(SHORTEST_HOLD, int(2.5 * (last - ends)))
    floor = n * (noise_N**2 / size) + 1e-12 * height_N**2
    long = lasts >= shortest
    if corner < 1.5 * min(held, even) + 10.0 * floor / n:
        return "unclear" if long and held + floor < 0.7 * (corner + floor) else "sharp"
    if long and held + floor < 0.7 * (even + floor):
        # What goes on bending over a round top, so that it is wider and wider below, was not stopped.
        top = force_N[fall.start : last + 1]
        upper, near_top, below = (np.count_nonzero(top >= fall.top_N - k * band_N) for k in (0.5, 1.0, 2.0))
        return "rounded" if upper < NARROWER * near_top and below > WIDER * near_top else "held"
    return "rounded" if not long or even + floor < 0.7 * (held + floor) else "unclear"


def least_squares(columns: FloatArray, values: FloatArray) -> tuple[float, int]:
    """Return the smallest sum of squares that linear models leave, and whose it is; columns (model, point, term)."""
    normal = np.einsum("kni,knj->kij", columns, columns)
    normal += 1e-12 * np.trace(normal, axis1=1, axis2=2)[:, None, None] * np.eye(columns.shape[2])
    right = np.einsum("kni,n->ki", columns, values)
    solved = np.linalg.solve(normal, right[..., None])
    left = values - (columns @ solved)[..., 0]
    squares = np.einsum("kn,kn->k", left, left)
    return float(squares.min()), int(np.argmin(squares))
