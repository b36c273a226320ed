"""One recording, one break-away: F_A is the largest force from the onset of macroscopic slip to its first fall.

Macroscopic is the first slip that goes on, as sliding or as a train of stick-slip; partial slips and bumps before it are
listed. The force alone does not always tell a rope that slides from a motor that was stopped. What speaks for sliding: a
fall faster than a motor lets down, a force that is loaded again at the machine's rate or is rougher than before. What
speaks for a motor: a top at which the force was held, a corner without rounding before a slow fall. Where nothing
decides, the result is `doubtful`, with the candidates.
"""

from dataclasses import replace
from itertools import pairwise
from math import inf

import numpy as np

from ropefric.arrays import FloatArray, median
from ropefric.traces.breakaway import Breakaway, ForceEvent, PickSettings, Status
from ropefric.traces.doubts import with_its_top
from ropefric.traces.events import (
    FAST,
    GROWTH,
    LEAST_PEAK,
    SHORTEST_HOLD,
    TINY,
    UNLOADED,
    Fall,
    Pull,
    bends_to_its_level,
    flat_top,
    half_climb,
    motor_starts,
)
from ropefric.traces.evidence import (
    LASTS,
    OTHER_RATE,
    SWINGS_OUT,
    comes_off,
    comes_on,
    fall_blocks,
    gives_way,
    hidden,
    is_let_down_later,
    is_quiet,
    left_after_N,
    loads_again,
    passes_away,
    rate_after,
    stands_out,
    swings,
    wanders,
)
from ropefric.traces.peak import peak_result
from ropefric.traces.results import (
    FLAT_BLOCKS,
    doubtful,
    event_of,
    held_rope,
    levels_off,
    measured,
    no_peak,
    too_short,
    without_force,
)
from ropefric.traces.segments import (
    Blocks,
    Prepared,
    Sliding,
    phases_of,
    prepare,
    sliding_after,
)
from ropefric.traces.slips import (
    FAR_FASTER,
    FEW_BLOCKS,
    LARGER,
    LEAST_DROP,
    TALL,
    Candidate,
    bumps_of,
    found_pulls,
    least_fall_N,
    loaded_so_fast,
    macroscopic,
    rate_of,
    smallest_drop_N,
)
from ropefric.traces.trace import ForceTrace
from ropefric.traces.zero import with_its_zero

SWING_S = 0.05
"""What swings around a level is at rest in the mean over so long [s]."""
LEAST_SHARE = 0.55
"""Part of the peak that the force keeps where nothing but the fall speaks for a slip."""
STEPS = 3
"""A fall of fewer steps of the converter has no shape."""
SETTLING = 0.1
"""What is let down goes on at its rate, a slip slows down: in the last quarter of its time it falls by less of it."""
BENT, FAR_BENT = 0.25, 0.1
LONGEST_FALL_S = 0.3
BRIEF = 0.25
"""A fall that takes less than this part of the upper half of the climb is faster than a motor lets down."""
NO_MOTOR = 5.0
"""What creeps when the motor stops falls no faster than it was loaded, and a motor lets down not so many times faster
to a level that is still high."""
RELAXES, RELAXED, CREPT = 0.4, 0.2, 0.08
"""A held rope relaxes from a corner on, far more slowly than it was loaded, and by no more than a fifth; where the motor
stopped little by little it has relaxed by less, as half of that is over while it stops."""
FAR_SHARE, NO_MOTOR_AT_ALL = 0.4, 15.0
"""Nor is a load let down so many times faster and stopped before less than this part of it is left."""
RELOADED = 0.5
"""What the machine loads again comes to this part of the force at least, at as much as this part of the rate."""
BRIEFLY = 0.2
"""What stood at its top for less than the machine loads by this part of the fall may have slipped there."""
STOOD = 0.1
"""A rounded top withholds less than this part of the climb from the rope."""
LEVELLED = 0.5
"""A fifth of a climb takes a quarter of the time of the other four, and twice that at a round top."""
COARSER, SLIPPED = (5.0, 15.0), 0.2
"""How many times larger falls are looked at, where no smaller one before them is more than this part of theirs."""
MUCH = 1.5
SOON = 4.0
"""A rope slides for longer than so many times the climb."""
LEVEL = 0.3
"""Part of a pull during which a force that slides without a peak stays near its largest."""
BEGINS = 0.8
"""A recording that begins above this part of its largest force, and not at rest, shows no loading."""
AS_LONG = 0.9
"""The first climb to a train of stick-slip is longer than the later ones; one of them is so much as long at least."""
WANDERS = 2.0
"""Of all that a sliding rope wanders: a fall that is so much larger is no wander."""
EQUAL = 0.01
"""Two candidates that differ by less are no doubt about the force."""


def pick_breakaway(trace: ForceTrace, settings: PickSettings) -> tuple[Breakaway, ...]:
    """Return the break-away of a recording in which the load is raised once until the rope slides."""
    prepared = prepare(trace, settings)
    return (too_short(trace, settings) if prepared is None else pick_prepared(trace, prepared, settings),)


def pick_prepared(trace: ForceTrace, prepared: Prepared, settings: PickSettings) -> Breakaway:
    """Return the break-away of a recording that is prepared already, see `pick_breakaway`."""
    force_N = prepared.blocks.force_N
    rise_N = float(force_N.max() - force_N[0])
    if rise_N <= 2 * smallest_drop_N(prepared, settings):
        detail = (
            f"the force rises by {rise_N:.3g} N only, with {prepared.noise_N:.3g} N of noise on a sample: "
            "the recording shows no loading"
        )
        if float(force_N[0] - force_N.min()) > 10 * max(rise_N, prepared.noise_N):
            detail = (
                'the force only goes down: a pull that reads negative needs [import.derived] force = "-…"'
            )
        return without_force(Status.NO_BREAKAWAY, detail, prepared)
    if settings.ending == "separation":
        return _before_separation(trace, prepared, settings)
    return _before_sliding(trace, prepared, settings)


def _before_separation(trace: ForceTrace, prepared: Prepared, settings: PickSettings) -> Breakaway:
    """Find the highest force of a recording that ends with the rope or specimen coming off."""
    force_N = prepared.blocks.force_N
    block = int(np.argmax(force_N))
    if unseen := hidden(trace, prepared, block, block + 1):
        return without_force(*unseen, prepared)
    if float(force_N[block]) - float(force_N[block:].min()) <= smallest_drop_N(prepared, settings):
        return levels_off(prepared, force_N)
    return peak_result(
        prepared,
        settings,
        climb=half_climb(force_N, 0, block),
        block=block,
        fallen=min(block + 2, force_N.size - 1),
        sliding=None,
        phases=phases_of(prepared, block, None),
    )


def _before_sliding(trace: ForceTrace, prepared: Prepared, settings: PickSettings) -> Breakaway:
    """Find the static peak of a recording that goes on to slide: at the finest scale, or where that is in doubt, wider.

    Ripples on the way down part a fall, of which the first piece says little. Slips before it say more at the finest.
    """
    found = _at_scale(trace, prepared, settings, 1.0)
    blocks, one = prepared.blocks, inf
    if len(found.candidates) == 1:
        one = found.candidates[0].force_N
    elif found.status in {Status.NO_BREAKAWAY, Status.NO_PEAK}:
        one = float(blocks.force_N.max())
    slips_N = [event.drop_N for event in found.events if event.kind == "partial-slip"]
    for scale in COARSER if np.isfinite(one) else ():
        wider = _at_scale(trace, prepared, settings, scale)
        if found.status is Status.NO_PEAK and _is_let_down(blocks, wider):
            continue
        slipped = max(slips_N, default=0.0) > SLIPPED * np.nan_to_num(wider.drop_N)
        if (
            wider.status is Status.OK
            and not slipped
            and abs(wider.peak_N - one) <= LEAST_PEAK * one + 4.0 * blocks.noise_N
        ):
            found = wider
            break
    return with_its_zero(trace, prepared, with_its_top(prepared, found), settings)


def _is_let_down(blocks: Blocks, found: Breakaway) -> bool:
    """Return whether a fall ends a stretch of sliding without a peak: after a level, or to nothing."""
    up_N = blocks.force_N[: int(np.searchsorted(blocks.time_s, found.peak_time_s)) + 1]
    band_N = min(found.drop_N, 0.1 * (found.peak_N - float(up_N.min())))
    top, wide = (np.count_nonzero(up_N > found.peak_N - k * band_N) for k in (1.0, 5.0))
    return bool(np.isnan(found.kinetic_N) or top > LEVELLED * (wide - top))


def _at_scale(trace: ForceTrace, prepared: Prepared, settings: PickSettings, scale: float) -> Breakaway:
    """Find the static peak among the falls of a size."""
    force_N = prepared.blocks.force_N
    pulls = found_pulls(prepared, settings, scale)
    tall_N = TALL * max(pull.top_N - pull.base_N for pull in pulls)
    pulls = [pull for pull in pulls if pull.top_N - pull.base_N >= tall_N]
    found: Breakaway | None = None
    bumps: list[ForceEvent] = []
    for n, pull in enumerate(pulls):
        later = pulls[n + 1 :]
        result = _of_pull(trace, prepared, settings, pull, later)
        found = found or result
        # What was loaded and unloaded without a slip is followed by a pull that goes at least as high, or is loaded as
        # the motor loads: a bump is faster.
        rate = rate_of(force_N, pull)
        # Friction holds a rope that slips: one that comes free of all load has slipped off a snag.
        ok = result.status is Status.OK
        if ok and np.isnan(result.kinetic_N):
            outdone = any(comes_off(force_N, pull, other) for other in later)
        elif ok:
            outdone = any(_slides_above(force_N, pull, result.kinetic_N, other) for other in later)
        elif result.status is Status.DOUBTFUL:
            outdone = any(passes_away(force_N, pull, other) for other in later)
        else:
            outdone = result.status is Status.NO_BREAKAWAY and any(
                high >= 0.98 or rate > (FAST if high >= 0.5 else FAR_FASTER * FAST) * rate_of(force_N, other)
                for other in later
                for high in [other.top_N / max(pull.top_N, TINY)]
            )
        if not outdone:
            found = result if result.status is not Status.NO_BREAKAWAY else found
            break
        fall = pull.falls[-1]
        bumps.append(event_of(prepared, fall, "bump", "the force comes back, and a later pull goes higher"))
    if found is None:  # pragma: no cover - the highest pull is always among those looked at
        return levels_off(prepared, force_N)
    if bumps:
        events = (*bumps, *found.events)
        found = replace(found, events=tuple(sorted(events, key=lambda event: event.time_s)))
    return found


def _slides_above(force_N: FloatArray, pull: Pull, kinetic_N: float, other: Pull) -> bool:
    """Return whether a pull fell off faster than a motor lets down, and a later one slides at more than its top.

    What slides at a higher force had not slid there; nor had what drags at far less than a later, higher one slides at.
    """
    fall = pull.falls[-1]
    fastest = NO_MOTOR * rate_of(force_N, pull) * max(1.0, fall_blocks(force_N, fall))
    if not pull.unloads or not other.falls:
        return False
    first = max(other.falls, key=lambda g: g.top_N)
    slid_N = median(force_N[first.settled : first.settled + (first.top - other.start)])
    dragged_N = max(kinetic_N, UNLOADED * pull.top_N)
    drags = other.top_N > (1.0 + EQUAL) * pull.top_N and slid_N > MUCH * dragged_N
    return drags or (slid_N > pull.top_N and fall.drop_N > fastest)


def _comes_free(candidate: Candidate) -> bool:
    """Return whether nothing holds the rope after a fall, and a far higher force follows: it hung on a snag."""
    fall, base_N = candidate.fall, candidate.pull.base_N
    is_free = fall.bottom_N - base_N < TALL * candidate.height_N
    return is_free and any(g.top_N >= LARGER * fall.top_N for g in candidate.later)


def _of_pull(
    trace: ForceTrace, prepared: Prepared, settings: PickSettings, pull: Pull, later: list[Pull]
) -> Breakaway:
    force_N, time_s = prepared.blocks.force_N, prepared.blocks.time_s
    swing = max(1, round(SWING_S / max(median(np.diff(time_s)), TINY)))
    whole, (begins, hung) = pull.falls, motor_starts(force_N, pull, prepared.blocks.noise_N, swing)
    # A single load is hardly part of the climb, but of many it is most.
    start = begins if hung > 1 else pull.start
    left = [fall._replace(start=max(fall.start, start)) for fall in whole if fall.top >= begins]
    pull = pull._replace(start=start, falls=left)
    bumps = bumps_of(force_N, time_s, pull)
    falls = [fall for fall in pull.falls if fall not in bumps]
    height_N = pull.top_N - pull.base_N
    loaded = least_fall_N(prepared, settings) < pull.base_N - float(force_N.min()) > height_N
    # One that slides wanders, and falls no further than it wanders later on; it is loaded from far below.
    wanders = not prepared.blocks.n_rest and float(force_N[: pull.start + 1].min()) > BEGINS * pull.top_N
    later_N = WANDERS * float(np.ptp(force_N[falls[0].settled :])) if falls else 0.0
    wanders = wanders and all(fall.drop_N < later_N for fall in falls)
    if (loaded and pull.start < FEW_BLOCKS) or wanders:
        detail = f"the recording begins at {force_N[0]:.4g} N, loaded or sliding already: it shows no loading"
        return without_force(Status.NO_PEAK, detail, prepared)
    candidates = macroscopic(force_N, pull, falls, hung)
    if candidates and (loaded_on := loaded_so_fast(force_N, bumps, candidates[0])):
        bumps = [fall for fall in bumps if fall not in loaded_on]
        falls = [fall for fall in pull.falls if fall not in bumps]
        candidates = macroscopic(force_N, pull, falls, hung)
    while candidates and (comes_on(prepared, candidates[0]) or _comes_free(candidates[0])):
        bumps.append(candidates[0].fall)
        candidates = macroscopic(force_N, pull, candidates[0].later, hung)
    first = candidates[0].fall if candidates else None
    if unseen := hidden(trace, prepared, first.top if first else None, first.settled if first else 0):
        return without_force(*unseen, prepared)
    if first is None and pull.unloads and bumps:
        detail = f"what rises to {pull.top_N:.4g} N passes by and leaves no load"
        return without_force(Status.NO_BREAKAWAY, detail, prepared)
    if first is None:
        return levels_off(prepared, force_N[pull.start : pull.stop])
    events = [
        event_of(prepared, fall, "bump", "the force comes back to the line of its loading")
        if fall in bumps or fall.top < begins
        else event_of(prepared, fall, "partial-slip", "the loading goes on to a force well above")
        for fall in whole
        if fall.top < first.top
    ]
    if len(candidates) > 1 and candidates[1].fall.top_N > (1 + EQUAL) * first.top_N:
        result = doubtful(prepared, candidates, "either the first full slip or a partial one before it")
    elif _may_be_later(force_N, pull, falls):
        why = (
            f"the recording begins at {force_N[0]:.4g} N within a climb, as long as those of the later slips"
        )
        result = doubtful(prepared, candidates[:1], why)
    else:
        result = _assessed(prepared, settings, candidates[0], later)
        if result.status is Status.OK and _stood(prepared.blocks, candidates[0]):
            why = "the force stands at its top before it falls: it was held, or the sensor is at its limit"
            result = doubtful(prepared, candidates[:1], why)
    return replace(result, events=(*events, *result.events)) if events else result


def _may_be_later(force_N: FloatArray, pull: Pull, falls: list[Fall]) -> bool:
    """Return whether a recording begins within a climb that is no longer than those between its slips."""
    seen_N = falls[0].top_N - float(force_N[pull.start])
    rises_N = [after.top_N - fall.bottom_N for fall, after in pairwise(falls)]
    return pull.begun and max(rises_N, default=0.0) > AS_LONG * seen_N


def _assessed(  # noqa: PLR0911  (a cascade: every line decides one case)
    prepared: Prepared, settings: PickSettings, candidate: Candidate, later: list[Pull]
) -> Breakaway:
    """Return what the first macroscopic fall of a pull is: a break-away, a load that is let down, or not clear."""
    blocks = prepared.blocks
    force_N, pull, fall = blocks.force_N, candidate.pull, candidate.fall
    from_N, at_s, much = (
        fall.top_N,
        float(blocks.time_s[fall.top]),
        fall.drop_N >= LEAST_DROP * candidate.height_N,
    )
    sliding = sliding_after(blocks, fall, pull.base_N)
    if _is_unloaded(force_N, candidate, sliding):
        return _fell_away(prepared, settings, candidate, later)
    lasts = 0 if sliding is None else min(sliding.stop, pull.stop) - sliding.first
    if what := _is_outdone(force_N, candidate, later, lasts):
        detail = f"the force falls from {from_N:.4g} N at {at_s:.4g} s: {what}"
        return without_force(Status.NO_BREAKAWAY, detail, prepared)
    if sliding is None:
        if not fall.reloads:
            detail = f"the force falls from {from_N:.4g} N at {at_s:.4g} s and the recording ends before its level shows"
            return without_force(Status.NO_BREAKAWAY, detail, prepared)
        return measured(prepared, settings, candidate, None)
    above_N = from_N - sliding.onset_N
    if settings.min_step_N is not None and max(above_N, fall.drop_N) < settings.min_step_N:
        return no_peak(prepared, candidate, sliding, f"less than min_step = {settings.min_step_N:.3g} N")
    low = fall.drop_N < LEAST_PEAK * candidate.height_N
    if low or not stands_out(blocks.noise_N, force_N, candidate, sliding):
        return _without_peak(prepared, candidate, sliding)
    # A motor that stops lets the masses swing: not faster than it loaded them, and around a quiet level.
    times = _times_loaded(force_N, candidate)
    stops = times < 1.0 and is_quiet(prepared, candidate, sliding)
    if fall.sudden and not stops:
        return measured(prepared, settings, candidate, sliding)
    if much and swings(prepared, fall, sliding, candidate.rate):
        why = f"the force swings to {from_N:.4g} N and dies away: a load that comes on or stops, or a slip"
        return doubtful(prepared, [candidate], why)
    # Nor is it one that goes so far down, at such a multiple of the rate of loading, as a motor may let it.
    let_down = candidate.share < LEAST_SHARE and 1.0 < times <= NO_MOTOR
    if much and not stops and not let_down and loads_again(force_N, candidate):
        return measured(prepared, settings, candidate, sliding)
    return _of_slow_fall(prepared, settings, candidate, sliding)


def _is_unloaded(force_N: FloatArray, candidate: Candidate, sliding: Sliding | None) -> bool:
    """Return whether next to nothing of the load stays after a fall: motor off, or rope off, however that swings."""
    fall, pull = candidate.fall, candidate.pull
    if fall.reloads:
        base_N = min(pull.base_N, float(force_N[pull.start : fall.top].min()))
        low_N = base_N + TALL * (fall.top_N - base_N)
        # A strong slip is loaded again, one that is let down soon has slid before.
        windows = SWINGS_OUT * (fall.settled - fall.top), fall.top - fall.start
        return all(
            median(force_N[fall.settled : fall.settled + max(FLAT_BLOCKS, n)]) < low_N for n in windows
        )
    if not fall.has_settled:
        return True
    slid_N = fall.level_N if sliding is None else sliding.level_N
    return min(fall.level_N, slid_N) - pull.base_N < UNLOADED * candidate.height_N


def _without_peak(prepared: Prepared, candidate: Candidate, sliding: Sliding) -> Breakaway:
    """Return what a fall is that hardly stands out: of a held rope, of one that slides without a peak, or not clear."""
    fall, higher_N = candidate.fall, LARGER * candidate.fall.top_N
    if (
        not fall.slips
        and is_quiet(prepared, candidate, sliding)
        and not wanders(prepared, candidate, sliding)
    ):
        return held_rope(prepared, sliding)
    if higher := next((g for g in candidate.later if g.top_N > higher_N), None):
        # What slides is not loaded on so far.
        two = [candidate, Candidate(candidate.pull, higher, candidate.rate, [])]
        return doubtful(prepared, two, "the first hardly stands out, and a far higher force follows")
    return no_peak(prepared, candidate, sliding, "no static peak stands out")


def _is_outdone(force_N: FloatArray, candidate: Candidate, later: list[Pull], lasts: int) -> str:
    """Return what a fall is that is followed by so much sliding, where later pulls show that it is no slip."""
    fall, top_N, climb = candidate.fall, candidate.pull.top_N, candidate.fall.top - candidate.fall.start
    # A snag or an impact rises faster than the motor loads, and is over before anything slides (or soon, if far faster),
    # or is far too low.
    times = FAST if lasts < climb else FAR_FASTER if lasts < SOON * climb else inf
    slower = [p for p in later if times * rate_of(force_N, p) < candidate.rate]
    if any(p.top_N >= MUCH * top_N for p in later) or any(p.top_N >= 0.5 * top_N for p in slower):
        return "a bump, a later pull is loaded more slowly"
    creeps = not fall.sudden and fall.drop_N < LEAST_DROP * candidate.height_N
    higher = any(p.top_N >= LARGER * top_N for p in later)
    return "held, not slipping, a later pull goes far higher" if creeps and higher else ""


def _of_slow_fall(  # noqa: PLR0911  (a cascade, as above)
    prepared: Prepared, settings: PickSettings, candidate: Candidate, sliding: Sliding
) -> Breakaway:
    """Return what a fall is that a motor may have made: by its top, its shape and what follows."""
    blocks = prepared.blocks
    force_N, pull, fall, share = blocks.force_N, candidate.pull, candidate.fall, candidate.share
    long = fall_blocks(force_N, fall)
    fall_s = long * float(blocks.time_s[-1] - blocks.time_s[0]) / (blocks.time_s.size - 1)
    seen = (
        f"the force falls by {fall.drop_N:.3g} N within {1000 * fall_s:.2g} ms, slower than a slip, "
        f"and stays at {share:.0%} of the peak"
    )
    climb = fall.top - half_climb(force_N, pull.start, fall.top)
    flat = flat_top(force_N, fall, blocks.noise_N)
    bends = bends_to_its_level(force_N, fall, blocks.noise_N)
    # A force that bends to its level has shown it; a held one that is let down may do so as well, and so may
    # one that slipped before at much the same force.
    slips = [g for g in pull.falls if g.slips and (1.0 + GROWTH) * g.top_N > fall.top_N]
    slipped = any(LEAST_DROP * candidate.height_N <= g.drop_N < fall.drop_N for g in slips)
    times = _times_loaded(force_N, candidate)
    no_motor = times > NO_MOTOR
    fast = bends and no_motor and flat != "held"
    short = sliding.stop - sliding.first < (
        (BENT if share > 1.0 - RELAXED else FAR_BENT) * (fall.settled - fall.top)
        if bends and flat != "held" and not slipped
        else max(min(LASTS * (fall.top - pull.start), climb), 1.5 * (fall.settled - fall.top))
    )
    quiet = is_quiet(prepared, candidate, sliding)
    lively = fall.reloads or not quiet
    # What a slip takes off swings back.
    slid = max(share, (sliding.level_N - pull.base_N) / candidate.height_N)
    brief = flat == "held" and no_motor and _withheld_N(blocks, candidate) < BRIEFLY * fall.drop_N
    slips_off = times > (NO_MOTOR if bends else NO_MOTOR_AT_ALL) and (flat != "held" or brief)
    deep = share < LEAST_SHARE and slid >= (UNLOADED if bends else FAR_SHARE) and slips_off
    kept = (
        no_motor
        and flat != "held"
        and fall_s <= LONGEST_FALL_S
        and _keeps_its_load(force_N, candidate, slips)
    )
    if kept or (not short and (deep or (share >= LEAST_SHARE and (fast or brief)))):
        return measured(prepared, settings, candidate, sliding)
    if flat == "held" and (short or not (lively and share >= UNLOADED)):
        if share >= LEAST_SHARE and brief:
            return doubtful(prepared, [candidate], f"{seen}, after a moment at its top: a slip, or let down")
        held = f"the force stays at {fall.top_N:.4g} N for a moment and is let down to a quiet {sliding.level_N:.4g} N"
        return without_force(Status.NO_BREAKAWAY, f"{held}: held, not slipping", prepared)
    # It may settle little by little.
    drop_N = max(fall.drop_N, fall.top_N - sliding.onset_N)
    if drop_N < LEAST_DROP * candidate.height_N and quiet:
        faster = flat == "sharp" and times > OTHER_RATE  # than a load is taken back by creep or swings
        if ((faster or flat == "rounded") and not short) or wanders(prepared, candidate, sliding):
            return doubtful(prepared, [candidate], f"{seen}: sliding, or the creep of a held rope")
        return held_rope(prepared, sliding)
    # What a motor lets down goes on to nothing, as fast as it loads; what fell faster and stays, high up, to the end of
    # the recording has slipped.
    stays = not slipped and share >= LEAST_SHARE and sliding.stop >= force_N.size - FEW_BLOCKS
    if short and not (stays and times > 1.0):
        return doubtful(prepared, [candidate], f"{seen} for a moment only")
    # What swings far below where it slides goes back at once; what is let back does so no faster than it was loaded.
    low = share < LEAST_SHARE and times <= (OTHER_RATE if slid >= LEAST_SHARE else NO_MOTOR)
    if lively and slid >= UNLOADED and not low:
        return measured(prepared, settings, candidate, sliding)
    if fall.drop_N < STEPS * blocks.resolution_N:
        return doubtful(prepared, [candidate], f"{seen}, in few steps of the converter")
    soon = fall_s <= LONGEST_FALL_S and long <= BRIEF * climb
    sharp = flat == "sharp" and (soon or bends or is_let_down_later(force_N, fall, sliding, pull.base_N))
    relaxed = RELAXED if flat == "sharp" else CREPT
    relaxes = times < RELAXES and fall_s > LONGEST_FALL_S and share > 1.0 - relaxed
    # Nor does a motor let a load down so that it comes to its level little by little.
    if relaxes or share < (FAR_SHARE if bends else LEAST_SHARE) or not (sharp or flat == "rounded"):
        or_what = "a held rope that relaxes" if relaxes else "a load that was let down"
        return doubtful(prepared, [candidate], f"{seen}, without roughness: sliding, or {or_what}")
    note = f"{seen}: a break-away, unless the motor was let back at that moment"
    return measured(replace(prepared, notes=(*prepared.notes, note)), settings, candidate, sliding)


def _keeps_its_load(force_N: FloatArray, candidate: Candidate, slips: list[Fall]) -> bool:
    """Return whether so much of a load stays after a fall faster than a motor lets down as none would leave."""
    fall, height_N, left_N = candidate.fall, candidate.height_N, left_after_N(force_N, candidate)
    share = FAR_SHARE if _times_loaded(force_N, candidate) > NO_MOTOR_AT_ALL else LEAST_SHARE
    # It may be a later slip, where another took half as much before.
    later = any(g.top < fall.top and g.drop_N >= 0.5 * (height_N - left_N) for g in slips)
    return not later and left_N > share * height_N


def _times_loaded(force_N: FloatArray, candidate: Candidate) -> float:
    """Return how many times as fast as the machine loads the force falls."""
    return candidate.fall.drop_N / max(1.0, fall_blocks(force_N, candidate.fall)) / max(candidate.rate, TINY)


def _withheld_N(blocks: Blocks, candidate: Candidate) -> float:
    """Return by how much the machine would have loaded the rope on while it stood at a top [N]."""
    fall, force_N = candidate.fall, blocks.force_N
    band_N = max(4.0 * blocks.noise_N, LEAST_PEAK * candidate.height_N)
    stood = np.count_nonzero(force_N[fall.start : fall.settled] > fall.top_N - band_N)
    return candidate.rate * float(stood) - band_N


def _stood(blocks: Blocks, candidate: Candidate) -> bool:
    """Return whether a force stood at its top, after a corner, while the machine would have loaded it on by far."""
    fall, withheld_N = candidate.fall, _withheld_N(blocks, candidate)
    brief = withheld_N + 4.0 * blocks.noise_N < SHORTEST_HOLD * candidate.rate
    # A weight that is hung on stands, too.
    upper = fall.top - half_climb(blocks.force_N, candidate.pull.start, fall.top)
    jumped = candidate.rate * upper > LARGER * candidate.height_N
    if brief or jumped or withheld_N <= STOOD * candidate.height_N:
        return False
    return flat_top(blocks.force_N, fall, blocks.noise_N) == "held"


def _slips_again(force_N: FloatArray, candidate: Candidate, later: list[Pull]) -> bool:
    """Return whether the machine loads on after a fast fall to nothing: at once, or until it slips at no more."""
    rate, top_N = rate_of(force_N, candidate.pull), candidate.fall.top_N
    slow, fast, times = RELOADED * rate, rate / RELOADED, _times_loaded(force_N, candidate)
    if times <= OTHER_RATE or any(p.top_N > (1.0 + EQUAL) * top_N for p in later):
        return False  # it hung on a snag before
    if times > NO_MOTOR_AT_ALL and slow <= rate_after(force_N, candidate) <= fast:
        return True
    # What rests was off.
    return not any(comes_off(force_N, candidate.pull, p) for p in later) and any(
        RELOADED * top_N <= pull.top_N
        and slow <= rate_of(force_N, pull) <= fast
        and any(g.slips and g.drop_N >= LEAST_DROP * (g.top_N - pull.base_N) for g in pull.falls)
        for pull in later
    )


def _fell_away(
    prepared: Prepared, settings: PickSettings, candidate: Candidate, later: list[Pull]
) -> Breakaway:
    """Return what a fall is after which the force stands on no level: motor off, mostly."""
    blocks = prepared.blocks
    force_N, pull, fall = blocks.force_N, candidate.pull, candidate.fall
    height_N, to_the_end = candidate.height_N, pull.stop == force_N.size
    if to_the_end and not fall.sudden and fall.drop_N < LEAST_DROP * height_N:
        return levels_off(prepared, force_N[pull.start :])
    up = force_N[pull.start : fall.top + 1]
    before = levels_off(prepared, up)
    stood = np.count_nonzero(up >= fall.top_N - 0.1 * height_N) >= LEVEL * up.size
    if stood and (before.status is Status.NO_PEAK or not fall.sudden):
        return before
    held = flat_top(force_N, fall, blocks.noise_N) == "held"
    fast, high = _times_loaded(force_N, candidate) > NO_MOTOR, candidate.share >= LEAST_SHARE
    briefly = fast and _withheld_N(blocks, candidate) < BRIEFLY * fall.drop_N
    if to_the_end and (briefly or not held) and (high or (fast and candidate.share > UNLOADED)):
        half = -(-(force_N.size - fall.top) // 8)
        late_N = 2.0 * float(force_N[-2 * half : -half].mean() - force_N[-half:].mean())
        settles = fall.drop_N >= LEAST_DROP * height_N and late_N <= SETTLING * fall.drop_N
        creeps = _times_loaded(force_N, candidate) < RELAXES and candidate.share > 1.0 - RELAXED
        if high and not held and settles and not creeps:
            return measured(prepared, settings, candidate, None)
        return doubtful(prepared, [candidate], "the recording ends before the force has settled")
    if _slips_again(force_N, candidate, later) or gives_way(force_N, candidate):
        return measured(prepared, settings, candidate, None)
    at_s = float(blocks.time_s[fall.top])
    detail = (
        f"the force falls from {fall.top_N:.4g} N at {at_s:.4g} s without a stretch of sliding: motor stopped, or "
        'rope off. If these recordings end in a pull-off, set [protocol] ending = "separation".'
    )
    return without_force(Status.NO_BREAKAWAY, detail, prepared)
