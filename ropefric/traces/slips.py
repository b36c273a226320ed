"""Which of the falls of a pull is the break-away: the first slip that is macroscopic, that is, no partial one."""

from typing import NamedTuple

import numpy as np

from ropefric.arrays import FloatArray, median
from ropefric.traces.breakaway import PickSettings
from ropefric.traces.events import (
    FAST,
    GROWTH,
    SAME_KIND,
    SLIDES,
    STICKS,
    UNLOADED,
    Fall,
    Pull,
    is_sudden,
    loading_rate,
    pulls_of,
)
from ropefric.traces.segments import DROP_SIGMAS, Prepared

FEWEST_TEETH = 3
FEW_BLOCKS = 4
TALL = 0.1
"""What is lower, of a pull or of the highest pull, is a wiggle of the unloaded rope."""
FAR = 0.95
"""A force that is loaded to about the double has not slipped before."""
FULL = 0.16
"""A slip by which the force falls by more than this part of itself is no partial one."""
AGAIN, LITTLE, STILL = 0.05, 0.1, 0.015
SWINGS = 4
BACK, ABOUT, FAR_FASTER = 0.6, 0.8, 5.0
SMALL_GROWTH = 0.03
LARGER = 1.2
_RANGE = 0.004
TINY = 1e-300
"""Nothing is divided by less."""


class Candidate(NamedTuple):
    """A fall that may be the break-away, the pull it lies in, and the rate at which it was loaded [N per block]."""

    pull: Pull
    fall: Fall
    rate: float
    later: list[Fall]


def smallest_drop_N(prepared: Prepared, settings: PickSettings) -> float:
    """Return the smallest drop of the block means that may be more than noise [N]."""
    return max(DROP_SIGMAS * prepared.blocks.noise_N, 0.5 * (settings.min_step_N or 0.0))


def least_fall_N(prepared: Prepared, settings: PickSettings) -> float:
    """Return the smallest fall that is looked at [N]."""
    force_N = prepared.blocks.force_N
    # So far apart are the largest and the smallest of many values that are noise alone.
    noise_N = (2.0 * np.sqrt(2.0 * np.log(force_N.size)) + 1.0) * prepared.blocks.noise_N
    return max(
        smallest_drop_N(prepared, settings), float(noise_N), _RANGE * float(force_N.max() - force_N.min())
    )


def rate_of(force_N: FloatArray, pull: Pull) -> float:
    """Return the rate at which the machine loads a pull up to its top [N per block]."""
    return loading_rate(force_N, pull.start, pull.start + int(np.argmax(force_N[pull.start : pull.stop])))


def macroscopic(force_N: FloatArray, pull: Pull, falls: list[Fall]) -> list[Candidate]:
    """Return the first fall of a pull that is no partial slip; two where it may be one; none where all are."""
    whole = rate_of(force_N, pull)
    for i, fall in enumerate(falls):
        if fall.top_N - pull.base_N < TALL * (pull.top_N - pull.base_N):
            continue
        # Weights hung on at first are loaded faster than by the motor.
        climb_N, rate = fall.top_N - float(force_N[fall.start]), whole
        if climb_N > LITTLE * (fall.top_N - pull.base_N):
            rate = min(rate, loading_rate(force_N, fall.start, fall.top))
        higher = next((j for j in range(i + 1, len(falls)) if falls[j].top_N > fall.top_N), None)
        rivals = _rivals(force_N, pull, _Place(falls, i, higher), rate)
        if rivals is not None:
            return [Candidate(pull, falls[j], rate, falls[j + 1 :]) for j in (i, *rivals)]
    return []


class _Place(NamedTuple):
    """A fall among the falls of its pull, and the next one from a higher force."""

    falls: list[Fall]
    i: int
    higher: int | None


def _rivals(force_N: FloatArray, pull: Pull, place: _Place, rate: float) -> list[int] | None:
    """Return which later falls may be the break-away instead of this one; None where it is a partial slip."""
    falls, i, higher = place
    fall, last = falls[i], pull.falls[-1].bottom
    top = falls[higher].top if higher is not None else last + int(np.argmax(force_N[last : pull.stop]))
    above_N = float(force_N[top]) - fall.top_N
    if above_N <= 0.0:
        return None if i + 1 < len(falls) and _is_partial(pull, fall, falls[i + 1], rate) else []
    growth = above_N / max(fall.top_N - pull.base_N, 1e-12 * above_N, TINY)
    if _is_passed(force_N, pull, place, (top, growth, rate)):
        return None
    # A rope that slides and hardens passes its first force slowly, one that sticks at the machine's rate.
    passed = top - int(np.flatnonzero(force_N[fall.top : top + 1] <= fall.top_N)[-1]) - fall.top
    hardens = passed > FEW_BLOCKS and above_N < SLIDES * rate * passed
    # It slips again before it is loaded as high, or has slipped by far more than partially: that has weakened it.
    between = [g for g in falls[i + 1 : higher] if g.drop_N >= AGAIN * fall.drop_N]
    alike = [g for g in between if _is_alike(fall, g, pull)]
    weaker = bool(between) and (growth <= LITTLE or len(between) >= FEWEST_TEETH or len(alike) >= 2)
    if hardens or weaker or fall.drop_N > FULL * (fall.top_N - pull.base_N):
        return []
    if growth > GROWTH or higher is None:
        return None
    # It is not loaded again as a rope that sticks.
    if float(force_N[top]) - fall.bottom_N < STICKS * rate * (top - fall.bottom):
        return []
    against = _against_the_higher(pull, fall, falls[higher:], growth)
    return [higher] if against else None if against is None else []


def _is_alike(fall: Fall, other: Fall, pull: Pull) -> bool:
    """Return whether two falls are teeth of one train: much the same, from much the same force."""
    near = abs(other.top_N - fall.top_N) <= AGAIN * (fall.top_N - pull.base_N)
    return near and SAME_KIND <= other.drop_N / max(fall.drop_N, TINY) <= 1.0 / SAME_KIND


def _is_passed(force_N: FloatArray, pull: Pull, place: _Place, seen: tuple[int, float, float]) -> bool:
    """Return whether the loading clearly goes on after a fall: a bump, a swing of the weights, a partial slip."""
    falls, i, higher = place
    fall, (top, growth, rate) = falls[i], seen
    # A snag or an impact rises faster than the motor loads later on, and comes back.
    low = fall.top + int(np.argmin(force_N[fall.top : top + 1]))
    comes_back = float(force_N[low]) - pull.base_N < BACK * (fall.top_N - pull.base_N)
    if comes_back and loading_rate(force_N, fall.start, fall.top) > FAST * loading_rate(force_N, low, top):
        return True
    if _is_before_the_ramp(force_N, fall, falls[i + 1 :]):
        return True
    if _goes_on(force_N[fall.top : pull.stop], fall, pull.base_N, rate):
        return True
    # Hung weights bounce and come to rest, and later the motor loads on.
    swings = [g for g in falls[i + 1 : higher] if g.drop_N >= AGAIN * fall.drop_N]
    ends = higher is None and growth > SMALL_GROWTH  # while it still climbs
    few = (growth > LITTLE or ends) and len(swings) <= SWINGS
    if few and any(
        _rests(force_N[start:top], fall, pull, ends=ends) for start in (fall.settled, fall.bottom)
    ):
        return True
    # Or without a rest, to a slip that is larger.
    return (
        growth > GROWTH
        and higher is not None
        and _slides_or_reloads(pull, falls[higher])
        and falls[higher].drop_N >= fall.drop_N
        and fall.drop_N <= FULL * (fall.top_N - pull.base_N)
    )


def _against_the_higher(pull: Pull, fall: Fall, higher: list[Fall], growth: float) -> bool | None:
    """Compare a fall with those from a higher force: True if not clear, None for a partial slip, False for a slip."""
    rival = higher[0]
    # Where the force hardly grows, a fall after which it is not loaded again may be the end of the pull.
    ends = growth > SMALL_GROWTH
    largest_N = max(
        (g.drop_N for g in higher if g.reloads or (ends and _slides_or_reloads(pull, g))), default=0.0
    )
    if fall.drop_N < SAME_KIND * largest_N or _is_small_for(fall, higher):
        return None
    # What slides at a force above the top of a slip had not slid in it.
    later = [0.5 * (g.top_N + g.bottom_N) for g in higher[1:] if g.reloads]
    if (median(np.array(later)) if len(later) >= FEWEST_TEETH else rival.level_N) > fall.top_N:
        return None
    least_N = SAME_KIND * max(fall.drop_N, largest_N)
    alike = [g for g in higher if least_N <= g.drop_N <= fall.drop_N / SAME_KIND and g.reloads]
    if len(alike) >= 2:
        return False
    # Sliding, or teeth of another kind, follow the higher one: the rope would not have stuck again after sliding.
    if _slides_or_reloads(pull, rival) and (ends or rival.reloads) and fall.drop_N < LARGER * rival.drop_N:
        return None
    return True


def _is_before_the_ramp(force_N: FloatArray, fall: Fall, later: list[Fall]) -> bool:
    """Return whether a motor that loads far more slowly leads to a higher force, from which it falls as far."""
    highest = max(later, key=lambda g: g.top_N, default=fall)
    if highest.top_N <= (1.0 + SMALL_GROWTH) * fall.top_N or highest.drop_N < ABOUT * fall.drop_N:
        return False
    low = fall.top + int(np.argmin(force_N[fall.top : highest.top + 1]))
    ramp = loading_rate(force_N, low, highest.top)
    return loading_rate(force_N, fall.start, fall.top) > FAR_FASTER * ramp


def _is_small_for(fall: Fall, train: list[Fall]) -> bool:
    """Return whether a fall is smaller than all those of a train of slips, by far more than they differ."""
    drops_N = np.array([g.drop_N for g in train if g.reloads])
    if drops_N.size < FEWEST_TEETH:
        return False
    typical_N = median(drops_N)
    spread_N = 1.4826 * median(np.abs(drops_N - typical_N))
    return fall.drop_N < min(0.75 * typical_N, typical_N - 4.0 * spread_N)


def _rests(force_N: FloatArray, fall: Fall, pull: Pull, *, ends: bool) -> bool:
    """Return whether the force stands still for a while after a fall, as under hung weights, and then climbs."""
    band_N = STILL * (fall.top_N - pull.base_N)
    settled_N = float(np.median(force_N[: max(1, force_N.size // 4)]))
    still = int(np.count_nonzero(np.abs(force_N - settled_N) < band_N))
    climbs = ends or float(force_N[-1]) > settled_N + 10.0 * band_N
    return climbs and still > max(FEW_BLOCKS, 0.15 * force_N.size)


def _goes_on(force_N: FloatArray, fall: Fall, base_N: float, rate: float) -> bool:
    """Return whether the loading goes on, at the machine's rate, to a force that no train of stick-slip grows to."""
    far = np.flatnonzero(force_N > fall.top_N + FAR * (fall.top_N - base_N))
    if not far.size:
        return False
    passed = int(far[0]) - int(np.flatnonzero(force_N[: far[0]] <= fall.top_N)[-1])
    return FAR * (fall.top_N - base_N) >= STICKS * rate * (passed - 1)


def _slides_or_reloads(pull: Pull, fall: Fall) -> bool:
    """Return whether the force stands on a level after a fall, or is loaded again: it was not unloaded."""
    return fall.reloads or (
        fall.has_settled and fall.level_N - pull.base_N > UNLOADED * (fall.top_N - pull.base_N)
    )


def _is_partial(pull: Pull, fall: Fall, after: Fall, rate: float) -> bool:
    """Return whether a fall is small against the one that follows at nearly the same force."""
    return (
        fall.drop_N < SAME_KIND * after.drop_N
        and after.top_N - pull.base_N > 0.9 * (fall.top_N - pull.base_N)
        and _slides_or_reloads(pull, after)
        and is_reload(fall, after, rate)
    )


def is_reload(fall: Fall, after: Fall, rate: float) -> bool:
    """Return whether the force between two falls rises as the machine loads: neither as slowly as sliding nor faster."""
    rise_N, lasting = after.top_N - fall.bottom_N, rate * (after.top - fall.bottom)
    return STICKS * lasting <= rise_N <= FAST * lasting


def slips_of(prepared: Prepared, settings: PickSettings) -> list[Candidate]:
    """Return every fall after which the force is loaded again, and sudden ones, of a recording of stick-slip.

    A small one to which the force rose faster than the machine loads is the echo of the slip before it.
    """
    force_N = prepared.blocks.force_N
    found = [
        Candidate(pull, fall, loading_rate(force_N, fall.start, fall.top), [])
        for pull in pulls_of(force_N, least_fall_N(prepared, settings))
        for fall in pull.falls
        if fall.reloads or is_sudden(force_N, fall, prepared.blocks.noise_N)
    ]
    least_N = SAME_KIND * typical_drop_N([slip.fall for slip in found])
    full = [slip for slip in found if slip.fall.drop_N >= least_N]
    fastest = FAST * median(np.array([slip.rate for slip in full])) if full else 0.0
    return [slip for slip in found if slip.fall.drop_N >= least_N or slip.rate <= fastest]


def typical_drop_N(falls: list[Fall]) -> float:
    """Return the drop that the falls reach which make up half of all that the force fell; 0 for none.

    The echoes of a slip may be as many as the slips themselves, but they are small.
    """
    drops_N = np.sort([fall.drop_N for fall in falls])
    return float(drops_N[int(np.searchsorted(np.cumsum(drops_N), 0.5 * drops_N.sum()))]) if falls else 0.0
