"""Which of the falls of a pull is the break-away: the first slip that is macroscopic, that is, no partial one."""

from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ropefric.arrays import FloatArray, median
from ropefric.traces.breakaway import PickSettings
from ropefric.traces.events import (
    FAR,
    FAST,
    GROWTH,
    SAME_KIND,
    SLIDES,
    STICKS,
    TINY,
    UNLOADED,
    Fall,
    Pull,
    half_climb,
    is_bump,
    loading_rate,
    passes_by,
    pulls_of,
    rate_above,
    rate_below,
)
from ropefric.traces.segments import DROP_SIGMAS, Prepared

FEWEST_TEETH = 3
FEW_BLOCKS = 4
TRAIN, KIN, SMALLER, EARLY, LEAST_TOOTH = 6, 0.005, 0.75, 0.25, 0.1
"""So many teeth show a trend and scatter by this part of the force at least; a partial slip is smaller, and stops above
where they do by this part of theirs."""
TALL = 0.1
"""What is lower, of a pull or of the highest pull, is a wiggle of the unloaded rope."""
OBSTACLE, SWUNG, SWUNG_BACK, SLOWER = 0.2, 0.55, 2, 1.25
"""An obstacle lifts the force by this part of it at least; a slip swings as far below the force of sliding as it began
above it, and back within twice the time; a partial one is loaded again at the rate of before."""
FAR_ABOVE, FAR_LARGER, ROW = 0.5, 2.0, 0.15
"""Partial slips in a row lead to a force so much higher and a slip so many times larger."""
HALF = 0.5
"""What falls again at once by less than this part of the last fall is its swing, however fast."""
FULL, MORE, SMALLISH = 0.16, 0.85, 0.2
"""A slip by which the force falls by more than this part is no partial one, where it does not grow by so much more; nor
by more than the last, though all that the motor turns loads the rope on."""
AGAIN, LITTLE, STILL, ALIKE = 0.05, 0.1, 0.015, 0.02
SWINGS, MANY_TIMES = 4, 3.0
GIVES, COMES_BACK, LONG = 0.8, 3.0, 0.2
"""A rope that slides and wears in gives way: the force grows that much slower, after a climb that took some time."""
ARRIVED = 0.9
"""A force that comes to a rest is there, when it has come so far."""
BACK, ABOUT, FAR_FASTER = 0.6, 0.8, 5.0
SMALL_GROWTH, SMALL, CLEAR, LARGER_SLIP = 0.03, 0.25, 0.02, 1.4
LEAST_DROP = 0.04
"""The force of a rope that is held and creeps falls by some per cent."""
LARGER = 1.2
STOPPED = 0.4
"""What a partial slip takes off is less than this part of what a full one would."""
TAKEN = 0.45
"""A swing that nothing damps goes twice as far down as what it takes off."""
AS_FAST = 0.5
"""A bump rises more than twice as fast as the machine loads."""
_RANGE = 0.004


class Candidate(NamedTuple):
    """A fall that may be the break-away, the pull it lies in, and the rate at which it was loaded [N per block]."""

    pull: Pull
    fall: Fall
    rate: float
    later: list[Fall]

    @property
    def height_N(self) -> float:
        """Return by how much the pull was loaded [N]."""
        return self.fall.top_N - self.pull.base_N

    @property
    def share(self) -> float:
        """Return which part of that stays after the fall."""
        return (self.fall.level_N - self.pull.base_N) / max(self.height_N, TINY)


def smallest_drop_N(prepared: Prepared, settings: PickSettings) -> float:
    """Return the smallest drop of the block means that may be more than noise [N]."""
    return max(DROP_SIGMAS * prepared.blocks.noise_N, 0.5 * (settings.min_step_N or 0.0))


def least_fall_N(prepared: Prepared, settings: PickSettings) -> float:
    """Return the smallest fall that is looked at [N]."""
    force_N = prepared.blocks.force_N
    # So far apart are the largest and the smallest of many values that are noise alone.
    noise_N = (2.0 * np.sqrt(2.0 * np.log(force_N.size)) + 1.0) * prepared.blocks.noise_N
    return max(TINY, smallest_drop_N(prepared, settings), float(noise_N), _RANGE * float(np.ptp(force_N)))


def rate_of(force_N: FloatArray, pull: Pull) -> float:
    """Return the rate at which the machine loads a pull up to its top [N per block]."""
    return loading_rate(force_N, pull.start, pull.start + int(np.argmax(force_N[pull.start : pull.stop])))


def macroscopic(force_N: FloatArray, pull: Pull, falls: list[Fall], hung: int = 0) -> list[Candidate]:
    """Return the first fall of a pull that is no partial slip; two where it may be one; none where all are.

    Each weight that was `hung` on before, and at rest, counts as a partial slip: it swung.
    """
    own = {fall.top: fall for fall in falls}
    found = _first_full(force_N, pull, own, hung)
    return [one._replace(fall=own[one.fall.top], later=[own[g.top] for g in one.later]) for one in found]


def _that_stays(force_N: FloatArray, pull: Pull, fall: Fall, rate: float) -> Fall:
    """Return a fall as far as it took the load off the spring: what springs back by itself did not.

    It comes back at once, far faster than the machine loads, and stays; or the machine is soon as high again: by what it
    loads until then the spring was relieved.
    """
    if not fall.reloads:
        return fall
    fell_N = fall.top_N - fall.bottom_N
    back = force_N[fall.bottom : fall.bottom + SWUNG_BACK * (fall.bottom - fall.top) + 3]
    excess_N = back - fall.bottom_N - FAST * rate * np.arange(back.size)
    k = int(np.argmax(excess_N))
    stays = (
        float(force_N[fall.bottom + k : fall.bottom + 2 * k + FEW_BLOCKS].min())
        >= float(back[k]) - AGAIN * fell_N
    )
    above = np.flatnonzero(force_N[fall.bottom : pull.stop] > fall.top_N)
    own = max(rate, loading_rate(force_N, pull.start, fall.top))
    taken_N = own * (fall.bottom - fall.top + int(above[0])) if above.size else fell_N
    level_N = float(back[k])
    if stays and excess_N[k] >= HALF * fell_N and level_N < fall.top_N:
        return fall._replace(
            settled=fall.bottom + k, bottom=fall.bottom + k, level_N=level_N, bottom_N=level_N
        )
    if taken_N < TAKEN * fell_N:
        return fall._replace(level_N=fall.top_N - taken_N, bottom_N=fall.top_N - taken_N)
    return fall


def _first_full(force_N: FloatArray, pull: Pull, own_falls: dict[int, Fall], hung: int) -> list[Candidate]:
    """Return the candidates of `macroscopic`, each as far as it stays, among falls by where they begin."""
    whole = rate_of(force_N, pull)
    falls = [_that_stays(force_N, pull, fall, whole) for fall in own_falls.values()]
    passed: list[Fall] = []
    full: Fall | None = None
    for i, fall in enumerate(falls):
        height_N = fall.top_N - pull.base_N
        if height_N < TALL * (pull.top_N - pull.base_N):
            continue
        if (
            full
            and fall.top_N < full.top_N
            and fall.top < full.top
            and _is_stopped(force_N, pull, fall, full)
        ):
            passed += [fall]
            continue
        # Weights hung on at first are loaded faster than by the motor.
        start = _start_of_climb(force_N, falls[: i + 1], LITTLE * height_N)
        own = loading_rate(force_N, start, fall.top)
        rate = min(whole, own) if start == fall.start else whole
        rivals = _rivals(force_N, pull, fall, falls[i + 1 :], (rate, own))
        like_it = [g for g in passed if g.drop_N >= ROW * fall.drop_N]
        springs = len(falls) < 2 * TRAIN and fall is not own_falls[fall.top]
        above = LITTLE if springs else FAR_ABOVE
        in_a_row = (springs or len(like_it) >= 2) and _is_loaded_on(pull, fall, falls[i + 1 :], rate, above)
        if rivals is None or in_a_row:
            passed += [fall]
            continue
        first = Candidate(pull, fall, rate_above(force_N, start, fall.top, rate), falls[i + 1 :])
        # What swings back is contested if it is where it stops and where it swings to.
        earlier = [
            g
            for g in passed
            if all(_is_contested(force_N, pull, one, fall) for one in (g, own_falls[g.top]))
            and not _is_far_less(force_N, pull, g, fall)
        ]
        if earlier:
            return [Candidate(pull, earlier[0], rate, falls[falls.index(earlier[0]) + 1 :]), first]
        rivals = (
            rivals
            or (_far_larger(pull, fall, falls[i + 1 :]) if len(like_it) + hung >= 2 else [])
            or _loaded_on_to(force_N, pull, own_falls, falls[i:], whole)
        )
        if not rivals:
            return [first]
        # The first from so high a force may be partial, too.
        high = [j for j, g in enumerate(rivals) if g.top_N >= rivals[0].top_N]
        largest_N = max(rivals[j].drop_N for j in high)
        at = next(j for j in high if rivals[j].drop_N >= HALF * largest_N)
        rival, far = rivals[at], rivals[at].top_N > fall.top_N + LITTLE * height_N
        if far and _is_stopped(force_N, pull, fall, rival):
            passed, full = [*passed, fall], rival
            continue
        if _is_far_less(force_N, pull, fall, rival):
            passed += [fall]
            continue
        return [first, Candidate(pull, rival, rate, rivals[at + 1 :])]
    return []


def _far_larger(pull: Pull, fall: Fall, later: list[Fall]) -> list[Fall]:
    """Return the falls from the one on that begins higher than a small one and is far larger, yet no unloading."""
    height_N = fall.top_N - pull.base_N
    if fall.drop_N > FULL * height_N:
        return []
    for j, g in enumerate(later):
        far = g.top_N > fall.top_N + LITTLE * height_N and g.drop_N > MANY_TIMES * fall.drop_N
        if far and _slides_or_reloads(pull, g):
            return later[j:]
    return []


def _loaded_on_to(
    force_N: FloatArray, pull: Pull, own_falls: dict[int, Fall], falls: list[Fall], rate: float
) -> list[Fall]:
    """Return the falls from the highest on, if it is far larger than the first and all between only loaded it."""
    fall, *later = falls
    height_N = fall.top_N - pull.base_N
    at = max(range(len(later)), key=lambda j: later[j].top_N, default=TRAIN)
    if at >= TRAIN or fall.drop_N > SMALLISH * height_N or not _slides_or_reloads(pull, later[at]):
        return []
    # What slips again from no higher a force has slid before; teeth that swing are as large as each other.
    no_higher_N = fall.top_N + SMALL_GROWTH * height_N
    swings = echoes(force_N, fall, later, rate)
    again = any(g.top_N <= no_higher_N and g.drop_N >= ROW * fall.drop_N for g in later[swings:at])
    first_N, last_N = (own.top_N - own.bottom_N for own in (own_falls[g.top] for g in (fall, later[at])))
    on = not again and last_N > FAR_LARGER * first_N and _is_loaded_on(pull, fall, later, rate, AGAIN)
    return later[at:] if on else []


def _slid_after_N(force_N: FloatArray, pull: Pull, fall: Fall) -> float:
    """Return the force at which a rope slides after a fall, once it has settled [N]."""
    return max(fall.level_N, median(force_N[fall.settled : pull.stop]))


def _is_stopped(force_N: FloatArray, pull: Pull, fall: Fall, rival: Fall) -> bool:
    """Return whether a fall ends not half way to where the rope slides after a far larger one from a higher force.

    A full slip goes on until the spring pulls no more than friction does: what still sticks has stopped it.
    """
    larger = rival.drop_N > MANY_TIMES * fall.drop_N
    return larger and fall.top_N - fall.bottom_N < STOPPED * (
        fall.top_N - _slid_after_N(force_N, pull, rival)
    )


def _is_far_less(force_N: FloatArray, pull: Pull, fall: Fall, rival: Fall) -> bool:
    """Return whether a fall is far smaller than one from a higher force that slides above it, or is small at all."""
    part = (fall.top_N - fall.bottom_N) / max(rival.top_N - rival.bottom_N, TINY)
    if part < SMALL and fall.drop_N < LITTLE * (fall.top_N - pull.base_N):
        return True
    on = _turned_on(force_N[: rival.top + 1], fall)
    return part < HALF and _slid_after_N(force_N, pull, rival) > fall.top_N and on < COMES_BACK


def _start_of_climb(force_N: FloatArray, falls: list[Fall], little_N: float) -> int:
    """Return where the force began to rise to the last of some falls; it rose by more than little from there."""
    last = falls[-1]
    rising = (fall.start for fall in reversed(falls) if last.top_N - float(force_N[fall.start]) > little_N)
    return next(rising, last.start)


def _is_contested(force_N: FloatArray, pull: Pull, fall: Fall, first: Fall) -> bool:
    """Return whether a fall that was taken for a partial slip may be the break-away, and a later one an obstacle.

    A macroscopic slip falls to the force of sliding or, where nothing damps it, as far below; a partial one does not.
    """
    height_N = fall.top_N - pull.base_N
    again = (first.top_N - fall.bottom_N) / max(1, first.top - fall.bottom)
    if fall.drop_N < LEAST_DROP * height_N or STICKS * loading_rate(force_N, fall.start, fall.top) > again:
        return False
    growth = (first.top_N - fall.top_N) / max(height_N, TINY)
    if growth < FAR and fall.drop_N >= (ABOUT if growth < LITTLE else 1.0 / ABOUT) * first.drop_N:
        return True
    if not LITTLE <= growth < FAR or fall.drop_N < 0.5 * FULL * height_N:
        return False
    over = (median(force_N[first.settled : pull.stop]) - fall.bottom_N) / max(
        fall.top_N - fall.bottom_N, TINY
    )
    return growth > OBSTACLE and 0.0 < over < SWUNG


class _Place(NamedTuple):
    """A fall of a pull and those after it: all, those before the next from a higher force, that one and all after it.

    And where the force is highest then, by how much, and the rates at which the machine and this rise loaded.
    """

    pull: Pull
    fall: Fall
    later: list[Fall]
    between: list[Fall]
    higher: list[Fall]
    top: int
    growth: float
    rate: float
    own_rate: float


def _rivals(  # noqa: PLR0911  (a cascade: every line decides one case)
    force_N: FloatArray, pull: Pull, fall: Fall, later: list[Fall], rates: tuple[float, float]
) -> list[Fall] | None:
    """Return the falls from the one that may be the break-away instead of this one; None for a partial slip."""
    rate, height_N = rates[0], fall.top_N - pull.base_N
    n_lower = next((j for j, g in enumerate(later) if g.top_N > fall.top_N), len(later))
    higher, last = later[n_lower:], pull.falls[-1].bottom
    top = higher[0].top if higher else last + int(np.argmax(force_N[last : pull.stop]))
    above_N = float(force_N[top]) - fall.top_N
    if above_N <= 0.0:
        return []
    growth = above_N / max(height_N, 1e-12 * above_N, TINY)
    # What is held or slides afterwards is highest anywhere.
    came = fall.bottom + int(np.argmax(force_N[fall.bottom : top + 1] >= fall.top_N + ARRIVED * above_N))
    slid = _slid_on(force_N, pull, fall, top, rates[1])
    between = [g for g in later[:n_lower] if g.drop_N >= AGAIN * fall.drop_N]
    place = _Place(pull, fall, later, between, higher, came if not higher else top, growth, *rates)
    if _wears_in(force_N, place):
        return []
    loaded = [g for g in later if g.reloads and not _is_echo(force_N, g, rates[1])]
    kin = _is_of_the_train(force_N, place, loaded)
    if kin is False or (not slid and _is_passed(force_N, place)) or _stops_early(place, loaded):
        return None
    # A rope that slides and hardens passes its first force slowly, one that sticks at the machine's rate.
    passed = came - _passes(force_N[: came + 1], fall)
    hardens = passed > FEW_BLOCKS and above_N < SLIDES * rate * passed
    # It slips again before it is loaded as high, or has slipped by far more than partially: that has weakened it.
    after = later[echoes(force_N, fall, later, rates[1]) :]
    if sum(g.reloads and g.drop_N >= SAME_KIND * fall.drop_N for g in after) < FEWEST_TEETH:
        between = [g for g in between if g in after]
    alike = [g for g in between if _is_alike(fall, g, pull)]
    weaker = bool(between) and (growth <= LITTLE or len(between) >= FEWEST_TEETH or len(alike) >= 2)
    weaker |= len(later) >= 2 and all(_is_alike(fall, g, pull, ALIKE) for g in later[:2])
    # Loaded again along the machine's line to a far higher force, at which nothing slips, it has not slid.
    held = all(g.drop_N < LEAST_DROP * height_N for g in higher)
    sticks = growth > GROWTH and held and _turned_on(force_N[: top + 1], fall) < SLOWER
    if _is_small_below(fall, higher) and _turned_on(force_N[: top + 1], fall) < SLOWER:
        return None
    if kin or slid or hardens:
        return []
    # The next slip, from a higher force and as large, may be the first full one as well.
    full = higher if _is_next_one(force_N, place, after) else []
    if weaker or (fall.drop_N > FULL * height_N and not sticks and growth < MORE):
        return full
    if growth > GROWTH or not higher:
        return None
    # A rope that slides is not loaded again as one that sticks.
    slides = float(force_N[came]) - fall.bottom_N < STICKS * rate * (came - fall.bottom)
    against = False if slides else _against_the_higher(force_N, pull, fall, higher, growth)
    return higher if against else None if against is None else full


def _is_next_one(force_N: FloatArray, place: _Place, after: list[Fall]) -> bool:
    """Return whether all that the motor turns after a slip goes into the spring, up to a larger slip from higher."""
    if not place.higher or place.growth < CLEAR or place.higher[0] is not next(iter(after), None):
        return False
    fall, rival = place.fall, place.higher[0]
    as_large = rival.top_N - rival.bottom_N > LARGER_SLIP * (fall.top_N - fall.bottom_N)
    return as_large and _turned_on(force_N[: place.top + 1], fall, place.own_rate) < SLOWER


def _is_of_the_train(force_N: FloatArray, place: _Place, loaded: list[Fall]) -> bool | None:
    """Return whether a fall begins at the force of the teeth after it, along their trend; None where few are alike.

    The teeth of a train are of one strength; a partial slip lies below them, an obstacle above.
    """
    fall, height_N = place.fall, place.fall.top_N - place.pull.base_N
    teeth = [g for g in loaded if g.drop_N >= SAME_KIND * typical_drop_N(place.later)]
    # As many as tell a trend from an obstacle among them.
    if len(teeth) < FEWEST_TEETH:
        return None
    teeth = teeth[:TRAIN]
    tops_N, drops_N, at = np.array([(g.top_N, g.top_N - g.bottom_N, g.top) for g in teeth]).T
    one, two = np.triu_indices(len(teeth), 1)
    slope = median((tops_N[two] - tops_N[one]) / (at[two] - at[one]))
    level_N = tops_N - slope * (at - fall.top)
    apart_N = max(1.4826 * median(np.abs(level_N - median(level_N))), KIN * height_N)
    off_N = median(level_N) - fall.top_N
    smaller = fall.top_N - fall.bottom_N < min(SMALLER * median(drops_N), BACK * height_N)
    if apart_N > ALIKE * height_N:
        return None
    if off_N > 6.0 * apart_N:
        # A force that grows with the way slid goes on to grow; having slipped it would be weaker.
        steady = abs(slope) * (teeth[0].top - fall.top) < LITTLE * off_N
        weaker = any(
            g.top_N < (1.0 - SMALL_GROWTH) * fall.top_N and g.drop_N > LEAST_TOOTH * fall.drop_N
            for g in loaded
        )
        return False if (smaller or steady) and not weaker else None
    obstacle = float(level_N.max()) - median(level_N) > 3.0 * apart_N
    # Where the force grows on as before the first of them, nothing has slid: they swing as weights do that are hung on.
    half = half_climb(force_N, place.pull.start, fall.top)
    loads_on = slope * (fall.top - half) > STICKS * float(fall.top_N - force_N[half])
    if abs(off_N) >= 3.0 * apart_N or obstacle:
        return None
    return not loads_on


def _stops_early(place: _Place, loaded: list[Fall]) -> bool:
    """Return whether a slip stops far above where those of the train after it do, before a higher and larger one.

    A full slip goes on until the spring pulls less than friction; a partial one is stopped by what still sticks.
    """
    fall = place.fall
    teeth = [g for g in loaded if g.drop_N >= SAME_KIND * typical_drop_N(loaded)]
    if len(teeth) < FEWEST_TEETH or not place.higher:
        return False
    fell_N, typical_N = fall.top_N - fall.bottom_N, median(np.array([g.top_N - g.bottom_N for g in teeth]))
    above_N = fall.bottom_N - median(np.array([g.bottom_N for g in teeth]))
    next_N = place.higher[0].top_N - place.higher[0].bottom_N
    return above_N > EARLY * typical_N and fell_N < SMALLER * min(typical_N, next_N)


def bumps_of(force_N: FloatArray, time_s: FloatArray, pull: Pull) -> list[Fall]:
    """Return the falls of a pull that took nothing off the spring: snags, blows, and what swings on after them."""
    at = time_s / max(median(np.diff(time_s)), TINY)
    bumps: list[Fall] = []
    swung, largest_N = 0, 0.0
    for n, f in enumerate(pull.falls[:-1]):
        rate = rate_below(force_N, pull.start, f.top) if n >= swung else 0.0
        passed = passes_by(force_N, f, rate) if n >= swung and f.drop_N > largest_N else 0
        if n >= swung and (passed or is_bump(force_N, at, f, rate)):
            # It swings on, unless it is a swing itself, of a slip before it.
            swings_on = echoes(force_N, f, pull.falls[n + 1 : -1], rate) if f.drop_N > largest_N else 0
            swung = max(n + 1 + swings_on, sum(g.bottom < passed for g in pull.falls[:-1]))
            bumps += pull.falls[n:swung]
        elif n >= swung:
            largest_N = max(largest_N, f.drop_N)
    return bumps


def loaded_so_fast(force_N: FloatArray, bumps: list[Fall], first: Candidate) -> list[Fall]:
    """Return the bumps that rise higher than what comes after them, and no faster than it is loaded: by the machine."""
    again, base_N = loading_rate(force_N, first.fall.start, first.fall.top), first.pull.base_N
    found = []
    for bump in bumps:
        half_N = 0.5 * bump.drop_N
        low = np.flatnonzero(force_N[bump.start : bump.top] <= bump.top_N - half_N)
        up = half_N / max(1, bump.top - bump.start - (int(low[-1]) if low.size else 0))
        is_higher = bump.top < first.fall.top and bump.top_N > first.fall.top_N
        # What comes back to nothing was struck.
        part = bump.drop_N / max(bump.top_N - base_N, TINY)
        found += [bump] * (is_higher and LITTLE < part < 1.0 - UNLOADED and again > AS_FAST * up)
    return found


def echoes(force_N: FloatArray, fall: Fall, later: list[Fall], rate: float) -> int:
    """Return how many falls right after one are its swings, each smaller than the one before and as soon again."""
    for n, (last, g) in enumerate(pairwise([fall, *later])):
        soon = g.top - last.settled <= SWUNG_BACK * (last.settled - last.top) + 2
        part = (g.top_N - g.bottom_N) / max(last.top_N - last.bottom_N, TINY)
        if not (soon and (part < HALF or (part < 1.0 and _is_echo(force_N, g, rate)))):
            return n
    return len(later)


def _is_echo(force_N: FloatArray, fall: Fall, rate: float) -> bool:
    """Return whether a fall is the swing of a slip before it, which rises faster than the machine loads."""
    return loading_rate(force_N, fall.start, fall.top) > FAST * rate


def _slid_on(force_N: FloatArray, pull: Pull, fall: Fall, top: int, own_rate: float) -> bool:
    """Return whether a rope slid on after a fall before the force was as high again; a held one only creeps."""
    height_N, rate = fall.top_N - pull.base_N, loading_rate(force_N, fall.bottom, top)
    is_far_below = pull.top_N - fall.top_N >= FAR * height_N
    if is_far_below or fall.drop_N < LEAST_DROP * height_N or not STICKS * rate <= own_rate <= rate / STICKS:
        return False
    return _turned_on(force_N[: top + 1], fall, rate) > 1.0 / STICKS


def _wears_in(force_N: FloatArray, place: _Place) -> bool:
    """Return whether a rope slides on after a fall though the force grows: it does so more slowly than it was loaded."""
    pull, fall, top = place.pull, place.fall, place.top
    after = place.later[echoes(force_N, fall, place.later, place.own_rate) :]
    again = [g for g in after if g.drop_N >= SAME_KIND * fall.drop_N and _slides_or_reloads(pull, g)]
    # What slips again by no more, after it has slid on to a higher force, says nothing of that.
    if any(g.top_N <= fall.top_N or g.drop_N > fall.drop_N for g in again):
        return False
    # What was loaded for long was neither hit nor hung on, and one that sticks is loaded again at the machine's rate.
    end = again[0].top if again else top
    slides = loading_rate(force_N, fall.bottom, end) < STICKS * place.own_rate
    long = 2 * (fall.top - half_climb(force_N, fall.start, fall.top)) > LONG * (top - fall.top)
    # Friction holds what slides; what falls nearly to where it was loaded from hung on a snag.
    part = fall.drop_N / max(fall.top_N - pull.base_N, TINY)
    fell = LEAST_DROP <= part < 1.0 - BACK
    if slides and long and fell and place.growth < MORE:
        return True
    if again:
        return False
    # A bump, or weights hung on, rise faster than the motor loads, which takes longer to come to the same force.
    passed = _passes(force_N[: top + 1], fall)
    back = _turned_on(force_N[: top + 1], fall, place.own_rate)
    if place.higher and all(g.drop_N < LEAST_DROP * (g.top_N - pull.base_N) for g in place.higher):
        top = fall.bottom + int(np.argmax(force_N[fall.bottom : pull.stop]))
    return top > passed and back < COMES_BACK and loading_rate(force_N, passed, top) < GIVES * place.own_rate


def _is_loaded_on(pull: Pull, fall: Fall, later: list[Fall], rate: float, above: float) -> bool:
    """Return whether all that the motor turns until a far higher and larger fall goes into the spring: nothing slid.

    What a partial slip takes off the spring the motor has to turn again.
    """
    highest = max(later, key=lambda g: g.top_N, default=fall)
    above_N = highest.top_N - fall.top_N
    partial_N = [g.top_N - g.bottom_N for g in (fall, *later) if g.top < highest.top]
    if above_N <= above * (fall.top_N - pull.base_N) or highest.drop_N < FAR_LARGER * max(partial_N):
        return False
    return rate * (highest.top - fall.top) < SLOWER * (above_N + sum(partial_N))


def _passes(force_N: FloatArray, fall: Fall) -> int:
    """Return where the force is last no higher than the top of a fall."""
    return int(np.flatnonzero(force_N <= fall.top_N)[-1])


def _turned_on(force_N: FloatArray, fall: Fall, rate: float | None = None) -> float:
    """Return how far the motor turned until the force was as high again, against what the fall took off the spring.

    A partial slip is loaded again along the machine's line, so that it is one.
    """
    rate = loading_rate(force_N, fall.start, fall.top) if rate is None else rate
    return rate * (_passes(force_N, fall) - fall.bottom - 1) / max(fall.top_N - fall.bottom_N, TINY)


def _is_alike(fall: Fall, other: Fall, pull: Pull, apart: float = AGAIN) -> bool:
    """Return whether two falls are teeth of one train: much the same, from much the same force."""
    near = abs(other.top_N - fall.top_N) <= apart * (fall.top_N - pull.base_N)
    return near and SAME_KIND <= other.drop_N / max(fall.drop_N, TINY) <= 1.0 / SAME_KIND


def _is_passed(force_N: FloatArray, place: _Place) -> bool:
    """Return whether the loading clearly goes on after a fall: a bump, a swing of the weights, a partial slip."""
    pull, fall, later, between, higher, top, growth, rate, own_rate = place
    height_N = fall.top_N - pull.base_N
    # A snag or an impact rises faster than the motor loads later on, and comes back.
    low = fall.top + int(np.argmin(force_N[fall.top : top + 1]))
    comes_back = float(force_N[low]) - pull.base_N < BACK * height_N
    # What goes hardly higher may be the next pull, and the jump before this one that of weights hung on.
    jumped = own_rate if growth > SMALL_GROWTH else rate_above(force_N, fall.start, fall.top, own_rate)
    if comes_back and jumped > FAST * loading_rate(force_N, low, top):
        return True
    if _is_before_the_ramp(force_N, fall, later, own_rate):
        return True
    # What slipped again and again at no higher a force slid, whatever came on later; what swings dies away.
    again = [g for g in between if g.reloads and not _is_echo(force_N, g, own_rate)]
    slid = len(again) >= TRAIN and again[-1].drop_N >= SAME_KIND * again[0].drop_N
    if not slid and _goes_on(force_N[fall.top : pull.stop], fall, pull.base_N, rate):
        return True
    # Hung weights bounce and come to rest, and later the motor loads on.
    ends = not higher and growth > SMALL_GROWTH  # while it still climbs
    few = (growth > LITTLE or ends) and len(between) <= SWINGS
    # A rope that is held creeps, one that is loaded by hand or weights swings; one that fell further has slid.
    creeps = fall.drop_N < LEAST_DROP * height_N or own_rate > FAST * loading_rate(force_N, low, top)
    if (
        few
        and creeps
        and any(_rests(force_N[start:top], fall, pull, ends=ends) for start in (fall.settled, fall.bottom))
    ):
        return True
    # Or without a rest, to a slip that is larger.
    return (
        growth > GROWTH
        and bool(higher)
        and _slides_or_reloads(pull, higher[0])
        and higher[0].drop_N >= fall.drop_N
        and fall.drop_N <= FULL * height_N
    )


def _against_the_higher(
    force_N: FloatArray, pull: Pull, fall: Fall, higher: list[Fall], growth: float
) -> bool | None:
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
    slid_N = median(force_N[max(higher, key=lambda g: g.top_N).settled : pull.stop])
    if (median(np.array(later)) if len(later) >= FEWEST_TEETH else max(rival.level_N, slid_N)) > fall.top_N:
        return None
    least_N = SAME_KIND * max(fall.drop_N, largest_N)
    alike = [g for g in higher if least_N <= g.drop_N <= fall.drop_N / SAME_KIND and g.reloads]
    if len(alike) >= 2:
        return False
    # Sliding, or teeth of another kind, follow the higher one: the rope would not have stuck again after sliding.
    if _slides_or_reloads(pull, rival) and (ends or rival.reloads) and fall.drop_N < LARGER * rival.drop_N:
        return None
    return True


def _is_before_the_ramp(force_N: FloatArray, fall: Fall, later: list[Fall], own_rate: float) -> bool:
    """Return whether a motor that loads far more slowly leads to a higher force, from which it falls as far."""
    highest = max(later, key=lambda g: g.top_N, default=fall)
    if highest.top_N <= (1.0 + SMALL_GROWTH) * fall.top_N or highest.drop_N < ABOUT * fall.drop_N:
        return False
    low = fall.top + int(np.argmin(force_N[fall.top : highest.top + 1]))
    return own_rate > FAR_FASTER * loading_rate(force_N, low, highest.top)


def _is_small_for(fall: Fall, train: list[Fall]) -> bool:
    """Return whether a fall is smaller than all those of a train of slips, by far more than they differ."""
    drops_N = np.array([g.drop_N for g in train if g.reloads])
    if drops_N.size < FEWEST_TEETH:
        return False
    typical_N = median(drops_N)
    spread_N = 1.4826 * median(np.abs(drops_N - typical_N))
    return fall.drop_N < min(0.75 * typical_N, typical_N - 4.0 * spread_N)


def _is_small_below(fall: Fall, train: list[Fall]) -> bool:
    """Return whether a fall is smaller than those of a train that slips about a force above its top: it had not slid."""
    teeth = [g for g in train if g.reloads and g.drop_N >= SAME_KIND * typical_drop_N(train)]
    about_N = [0.5 * (g.top_N + g.bottom_N) for g in teeth]
    if len(teeth) < FEWEST_TEETH or fall.drop_N >= SMALL * typical_drop_N(teeth):
        return False
    return median(np.array(about_N)) > fall.top_N


def _rests(force_N: FloatArray, fall: Fall, pull: Pull, *, ends: bool) -> bool:
    """Return whether the force stands still for a while after a fall, as under hung weights, and then climbs."""
    band_N = STILL * (fall.top_N - pull.base_N)
    settled_N = float(np.median(force_N[: max(1, force_N.size // 4)]))
    # A rope that stands where it slides later on slides.
    slid = (g for g in pull.falls if g.top > fall.top and g.drop_N >= fall.drop_N and g.has_settled)
    if not ends and any(abs(settled_N - g.level_N) < 2.0 * band_N for g in slid):
        return False
    still = int(np.count_nonzero(np.abs(force_N - settled_N) < band_N))
    climbs = ends or float(force_N[-1]) > settled_N + 10.0 * band_N
    return climbs and still > max(FEW_BLOCKS, 0.15 * force_N.size)


def _goes_on(force_N: FloatArray, fall: Fall, base_N: float, rate: float) -> bool:
    """Return whether the loading goes on, at the machine's rate, to a force that no train of stick-slip grows to."""
    far = np.flatnonzero(force_N > fall.top_N + FAR * (fall.top_N - base_N))
    if not far.size:
        return False
    return FAR * (fall.top_N - base_N) >= STICKS * rate * (int(far[0]) - _passes(force_N[: far[0]], fall) - 1)


def _slides_or_reloads(pull: Pull, fall: Fall) -> bool:
    """Return whether the force stands on a level after a fall, or is loaded again: it was not unloaded."""
    return fall.reloads or (
        fall.has_settled and fall.level_N - pull.base_N > UNLOADED * (fall.top_N - pull.base_N)
    )


@lru_cache(maxsize=1)  # the first break-away and the teeth after it are looked for in the same pulls
def found_pulls(prepared: Prepared, settings: PickSettings, scale: float = 1.0) -> list[Pull]:
    """Return every pull of a recording, with the falls that are worth a look, or so many times larger ones."""
    blocks = prepared.blocks
    return pulls_of(blocks.force_N, scale * least_fall_N(prepared, settings), blocks.noise_N)


def slips_of(prepared: Prepared, settings: PickSettings) -> list[Candidate]:
    """Return every fall after which the force is loaded again, and sudden ones, of a recording of stick-slip.

    A small one to which the force rose faster than the machine loads is the echo of the slip before it.
    """
    force_N = prepared.blocks.force_N
    found = [
        Candidate(pull, fall, loading_rate(force_N, fall.start, fall.top), [])
        for pull in found_pulls(prepared, settings)
        for fall in pull.falls
        if fall.slips
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
