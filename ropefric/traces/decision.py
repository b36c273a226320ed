"""One recording, one break-away: the trained picker names the place and its probability, the force is measured there.

F_A is the largest force from the onset of macroscopic slip to its first fall. The picker looks twice: at the whole
recording, and at a few climbs' time around every place it takes for possible. The second look distributes the
probability that the first gives to a place, so looks that disagree leave a doubt. Rules cover the physics: a converter
at its limit, a gap in the samples, how high the top is (`peak`) and where its zero lies (`zero`).
"""

from collections.abc import Iterator
from dataclasses import replace
from math import nan
from typing import NamedTuple

import numpy as np

from ropefric.arrays import BoolArray, FloatArray, IntArray, median
from ropefric.traces.breakaway import SURE, Breakaway, ForceEvent, PickSettings, Status
from ropefric.traces.clock import GAP_STEPS
from ropefric.traces.coherence import incoherence, sudden_steps
from ropefric.traces.noise import runs_of
from ropefric.traces.peak import gap_beside, peak_result
from ropefric.traces.picker import Look, State, Weights, closer, look
from ropefric.traces.segments import (
    DROP_SIGMAS,
    MIN_SAMPLES,
    TINY,
    Prepared,
    half_climb,
    prepare,
    sliding_after,
    wanted,
)
from ropefric.traces.smoothing import average_over_samples, window_samples
from ropefric.traces.trace import ForceTrace
from ropefric.traces.zero import either, with_its_zero

SEEN = 0.05
"""Candidates have at least this probability."""
SAME = 0.01
"""Candidates whose forces agree within this fraction count as one force."""
LOOKS = 3
"""Number of places that get a second look."""
CLOSER = 0.5
"""Largest part of the recording's time that a second look covers: a longer one would see the same again. Where a sudden
step may be damage, its other bins are a second opinion."""
FAINT, APART = 1e-3, 2
"""Smallest probability of a bin that counts as a place; largest distance of two bins of one place."""
FALL = 0.005
"""Falls smaller than this fraction of the force are not listed."""
LARGE, TOOTH = 0.1, 0.15
"""Slips larger than the first fraction of the largest give the typical (median) slip; a tooth of a train is larger than
the second fraction of that."""
STILL = (State.REST, State.HUNG, State.HELD, State.LET_DOWN, State.DISTURBED)
SATURATED_SAMPLES, CUT_OFF = 3, 4
"""The converter is at its limit if more samples than this in a row are equal, and this many times more than at any
lower force."""
STEEP, ENOUGH_TO_BEND = 0.75, 12
"""The climb beside a gap is fitted from this fraction of the peak on. With fewer samples the curvature is not
significant, and only the uncertainty grows."""
CLIMBS_ON = 0.6
"""Smallest rate, relative to that before, at which a climb is taken to go on while the converter is stuck."""
ENOUGH = 6
"""Number of blocks after which a fall of one block may have ended."""
USUAL_WINDOW_S = 0.005
"""Default width of the moving average [s]."""
HIDES = 0.02
"""Largest fraction of the force that a gap may hide without a doubt."""


class Place(NamedTuple):
    """A stretch of time that a look names: its most probable bin, first and last time, and probability."""

    bin: int
    first_s: float
    last_s: float
    probability: float


class Candidate(NamedTuple):
    """A candidate for the break-away: block, force, probability, first and last time."""

    block: int
    force_N: float
    probability: float
    first_s: float
    last_s: float


class Judgement(NamedTuple):
    """The candidates, most probable first, the probability of each reason for no break-away, and the first look."""

    candidates: list[Candidate]
    reasons: dict[Status, float]
    whole: Look


def pick_breakaway(trace: ForceTrace, settings: PickSettings) -> tuple[Breakaway, ...]:
    """Return the break-away of a recording in which the load is raised once until the rope slides."""
    prepared = usable(trace, settings)
    return (prepared if isinstance(prepared, Breakaway) else pick_prepared(trace, prepared, settings),)


def usable(trace: ForceTrace, settings: PickSettings) -> Prepared | Breakaway:
    """Return the samples to pick from, or the result for too few of them or for numbers that are not one signal.

    Who names the time of the break-away has seen the recording.
    """
    prepared, part = prepare(trace, settings), wanted(trace, settings)
    present = np.isfinite(trace.force_N[part])
    if prepared is None:
        n = int(np.count_nonzero(present))
        inside = " in the part looked at" if present.size < trace.force_N.size else ""
        detail = (
            f"{trace.force_N.size} samples, {n} of them usable{inside}; at least {MIN_SAMPLES} are needed"
        )
        return Breakaway(status=Status.TOO_SHORT, detail=detail)
    if settings.pick_s is None and (
        said := incoherence(trace.time_s[part][present], trace.force_N[part][present])
    ):
        return without_force(Status.DOUBTFUL, said, prepared)
    return prepared


def without_force(status: Status, detail: str, prepared: Prepared, **found: object) -> Breakaway:
    """Return a result without a force, with the reason."""
    return Breakaway(
        status=status,
        detail=detail,
        noise_std_N=prepared.noise_N,
        notes=prepared.notes,
        **found,  # type: ignore[arg-type]
    )


def pick_prepared(
    trace: ForceTrace, prepared: Prepared, settings: PickSettings, weights: Weights | None = None
) -> Breakaway:
    """Return the break-away of a recording that is prepared already, see `pick_breakaway`."""
    force_N = prepared.blocks.force_N
    rise_N = float(force_N.max() - force_N[0])
    if rise_N <= 2.0 * DROP_SIGMAS * prepared.blocks.noise_N:
        detail = (
            f"the force rises by {rise_N:.3g} N only, with {prepared.noise_N:.3g} N of noise on a sample: "
            "the recording shows no loading"
        )
        if float(force_N[0] - force_N.min()) > 10.0 * max(rise_N, prepared.noise_N):
            detail = (
                'the force only goes down: a pull that reads negative needs [import.derived] force = "-…"'
            )
        return without_force(Status.NO_BREAKAWAY, detail, prepared)
    if settings.ending == "separation":
        return _before_separation(trace, prepared, settings)
    if settings.picker == "highest":
        return with_its_zero(trace, prepared, _highest(prepared, settings), settings)
    return _before_sliding(trace, prepared, settings, weights)


def _before_separation(trace: ForceTrace, prepared: Prepared, settings: PickSettings) -> Breakaway:
    """Find the highest force of a recording that ends with the rope or specimen coming off."""
    force_N = prepared.blocks.force_N
    block = int(np.argmax(force_N))
    if cut := _cut_off(trace, prepared, block):
        return without_force(Status.SATURATED, cut, prepared)
    if float(force_N[block] - force_N[block:].min()) <= least_fall_N(prepared, settings):
        detail = f"the force is highest at the end, {force_N[-1]:.4g} N: nothing came off"
        return without_force(Status.NO_BREAKAWAY, detail, prepared)
    return measured(prepared, settings, block, None)


def _highest(prepared: Prepared, settings: PickSettings) -> Breakaway:
    """Return the maximum of the moving average before its first fall by `min_step_N`, or a tenth of its range."""
    step_s = float(np.median(np.diff(prepared.time_s)))
    n = window_samples(USUAL_WINDOW_S if settings.window_s is None else settings.window_s, step_s)
    mean_N = average_over_samples(prepared.force_N, n)
    fall_N = settings.min_step_N or 0.1 * float(np.ptp(mean_N))
    fallen = np.flatnonzero(np.maximum.accumulate(mean_N) - mean_N >= fall_N)
    if not fallen.size:
        return without_force(Status.NO_BREAKAWAY, f"the mean never falls by {fall_N:.4g} N", prepared)
    top = int(np.argmax(mean_N[: fallen[0]]))
    return Breakaway(
        status=Status.OK,
        detail="highest mean before the first fall",
        peak_N=float(mean_N[top]),
        peak_raw_N=float(prepared.force_N[top]),
        peak_time_s=float(prepared.time_s[top]),
        peak_std_N=prepared.noise_N / float(np.sqrt(n)),
        bias_N=0.0,
        window_s=n * step_s,
        noise_std_N=prepared.noise_N,
        drop_N=float(mean_N[top] - mean_N[fallen[0] :].min()),
        notes=prepared.notes,
    )


def _before_sliding(
    trace: ForceTrace, prepared: Prepared, settings: PickSettings, weights: Weights | None
) -> Breakaway:
    """Find the static peak of a recording in which the rope slides afterwards."""
    found = judge(prepared, weights)
    best = found.candidates[0] if found.candidates else None
    cut = _cut_off(trace, prepared, best.block if best else None)
    if cut or (stuck := _stuck(prepared, best.block if best else int(np.argmax(prepared.blocks.force_N)))):
        return without_force(Status.SATURATED if cut else Status.NO_PEAK, cut or stuck, prepared)
    reason = max(found.reasons, key=lambda status: found.reasons[status])
    if best is None or sum(found.reasons.values()) >= SURE:  # none for certain, whichever the reason
        is_damaged = reason is Status.DOUBTFUL
        return _in_doubt(prepared, found) if is_damaged else _with_reason(prepared, reason, found)
    same = share_near(found, best)
    if same < SURE:
        return _in_doubt(prepared, found)
    result = measured(prepared, settings, best.block, rests_of(prepared, found.whole))
    events = tuple(_events(prepared, found.whole, best.block, settings))
    result = replace(result, probability=round(same, 2), events=events)
    if settings.min_step_N is not None and not result.drop_N >= settings.min_step_N:
        detail = (
            f"the force falls by {result.drop_N:.3g} N only, less than min_step = {settings.min_step_N:g} N"
        )
        return without_force(Status.NO_PEAK, detail, prepared)
    result = with_its_zero(trace, prepared, _with_its_gap(prepared, result), settings)
    found_at = f"break-away at {result.peak_time_s:.4g} s, {result.peak_N:.4g} N"
    return replace(result, detail=result.detail or f"{found_at}, probability {result.probability:.2f}")


# --- two looks ------------------------------------------------------------------------------------------------------


def judge(prepared: Prepared, weights: Weights | None = None) -> Judgement:
    """Return the candidates and reasons with their probabilities: one look at the whole, one around each place."""
    whole = look(prepared.time_s, prepared.force_N, weights)
    places, reasons = _answers(whole)
    tops: dict[int, Candidate] = {}
    has_step = _sudden(prepared).size > 0
    longest = 1.0 if has_step else CLOSER
    for number, place in enumerate(places):
        near = [Place(0, place.first_s, place.last_s, 1.0)]
        is_likely = number < LOOKS and place.probability >= SEEN
        if is_likely and (part := _closer(prepared, whole, place, longest)):
            near, none = _answers(look(prepared.time_s[part], prepared.force_N[part], weights))
            for reason, one in none.items():
                reasons[reason] += place.probability * one
        for seen in near:
            found = _candidate(prepared, seen.first_s, seen.last_s, place.probability * seen.probability)
            before = tops.get(found.block)
            tops[found.block] = found if before is None else _both(before, found)
    left = 1.0 - reasons[Status.DOUBTFUL]
    if SEEN < left < 1.0 and not has_step:  # no damage is without a step
        reasons = {reason: one / left for reason, one in reasons.items()} | {Status.DOUBTFUL: 0.0}
        tops = {block: one._replace(probability=one.probability / left) for block, one in tops.items()}
    rounded = [one._replace(probability=round(one.probability, 2)) for one in tops.values()]
    candidates = sorted(
        (one for one in rounded if one.probability), key=lambda one: (-one.probability, one.block)
    )
    return Judgement(candidates, {reason: round(one, 2) for reason, one in reasons.items()}, whole)


def _closer(prepared: Prepared, whole: Look, place: Place, longest: float) -> slice | None:
    """Return the samples of a second look around a place; None if they are too few, or too large a part of all."""
    time_s = prepared.time_s
    from_s, until_s = closer(place.bin, whole.states.argmax(axis=1), whole.edges_s)
    part = slice(*np.searchsorted(time_s, (from_s, until_s)))
    longest_s = longest * float(time_s[-1] - time_s[0])
    return part if until_s - from_s <= longest_s and part.stop - part.start >= MIN_SAMPLES else None


def _sudden(prepared: Prepared) -> IntArray:
    """Return the samples at which the force steps suddenly, across no gap in time."""
    steps, steps_s = sudden_steps(prepared.force_N), np.diff(prepared.time_s)
    return steps[steps_s[steps - 1] <= GAP_STEPS * median(steps_s)]


def share_near(found: Judgement, top: Candidate) -> float:
    """Return the probability of a candidate's force, the candidates that agree with it included."""
    within_N = SAME * abs(top.force_N)
    return sum(one.probability for one in found.candidates if abs(one.force_N - top.force_N) <= within_N)


def _both(one: Candidate, other: Candidate) -> Candidate:
    first_s, last_s = min(one.first_s, other.first_s), max(one.last_s, other.last_s)
    return one._replace(probability=one.probability + other.probability, first_s=first_s, last_s=last_s)


def _answers(seen: Look) -> tuple[list[Place], dict[Status, float]]:
    """Return the places of a look, most probable first, and the reasons for none.

    Together they have all the probability: bins below FAINT belong to no answer.
    """
    bins = np.flatnonzero(seen.place >= FAINT)
    whole = float(seen.place[bins].sum()) + sum(seen.reasons.values())
    found = []
    for group in np.split(bins, np.flatnonzero(np.diff(bins) > APART) + 1) if bins.size else ():
        share = seen.place[group] / whole
        likely = group[share >= 0.1 * share.max()]
        ends_s = float(seen.edges_s[likely[0]]), float(seen.edges_s[likely[-1] + 1])
        found.append(Place(int(group[int(np.argmax(share))]), *ends_s, float(share.sum())))
    found.sort(key=lambda place: (-round(place.probability, 3), place.bin))
    return found, {reason: share / whole for reason, share in seen.reasons.items()}


def _candidate(prepared: Prepared, first_s: float, last_s: float, probability: float) -> Candidate:
    """Return the highest block within a stretch of time."""
    blocks = prepared.blocks
    first, stop = np.searchsorted(blocks.time_s, (first_s, last_s), side="right")
    first = max(0, int(first) - 1)
    block = first + int(np.argmax(blocks.force_N[first : max(int(stop), first + 1)]))
    return Candidate(block, float(blocks.force_N[block]), probability, first_s, last_s)


# --- what is said of it ---------------------------------------------------------------------------------------------


def _with_reason(prepared: Prepared, reason: Status, found: Judgement) -> Breakaway:
    """Return a result without a force: the most probable reason and the forces that support it."""
    blocks, states = prepared.blocks, found.whole.states.argmax(axis=1)
    top_N, last_N = float(blocks.force_N.max()), float(blocks.force_N[-1])
    words = {
        Status.NO_BREAKAWAY: f"no break-away ({found.reasons[reason]:.2f}): the force comes to {top_N:.4g} N"
        + (" and still rises at the end" if states[-1] == State.LOADING else f" and ends at {last_N:.4g} N"),
        Status.NO_PEAK: f"no static peak ({found.reasons[reason]:.2f}): the rope slides at up to {top_N:.4g} N",
        Status.SATURATED: f"the peak is not to be seen ({found.reasons[reason]:.2f}): the force stops at {top_N:.4g} N",
    }
    more = {}
    if reason is Status.NO_PEAK:
        slides = np.isin(states[_bins_of(found.whole, blocks.time_s)], (State.SLIDING, State.SLIP))
        if np.count_nonzero(slides) > 1:
            more = {
                "kinetic_N": float(blocks.force_N[slides].mean()),
                "kinetic_std_N": float(blocks.force_N[slides].std(ddof=1)),
            }
    others = [
        f" or {'a damaged file' if one is Status.DOUBTFUL else one.value} ({p:.2f})"
        for one, p in found.reasons.items()
        if one is not reason and p >= SEEN
    ]
    detail = words[reason] + "".join(others)
    return without_force(reason, detail, prepared, probability=found.reasons[reason], **more)


def _where_damaged(prepared: Prepared, found: Judgement) -> str:
    """Return in words where the damage of a recording begins: the sudden step nearest to where the picker sees it."""
    states, edges_s = found.whole.states[:, State.DAMAGED], found.whole.edges_s
    begins_s = float(edges_s[int(np.argmax(states >= 0.5 * states.max()))])
    steps = _sudden(prepared)
    if steps.size:
        at = int(steps[int(np.argmin(np.abs(prepared.time_s[steps] - begins_s)))])
    else:
        at = int(np.argmax(np.abs(np.diff(prepared.force_N)))) + 1
    before_N, after_N = prepared.force_N[at - 1 : at + 1].tolist()
    step = (
        f"at {prepared.time_s[at]:.4g} s the force changes from {before_N:.4g} N to {after_N:.4g} N at once"
    )
    return f"{step} and does not continue what was before"


def _in_doubt(prepared: Prepared, found: Judgement) -> Breakaway:
    """Return a doubtful result: several candidates, or a candidate and a reason, are possible."""
    time_s = prepared.blocks.time_s
    events = tuple(
        ForceEvent(kind="break-away", time_s=float(time_s[at]), force_N=force_N, probability=share)
        for at, force_N, share, *_ in found.candidates
        if share >= SEEN
    )
    said = [f"{event.force_N:.4g} N at {event.time_s:.4g} s ({event.probability:.2f})" for event in events]
    damaged = Status.DOUBTFUL
    said += [
        f"{it.value} ({one:.2f})" for it, one in found.reasons.items() if one >= SEEN and it is not damaged
    ]
    detail = f"{'either ' if len(said) > 1 else 'perhaps '}{' or '.join(said)}" if said else ""
    if found.reasons[damaged] >= SEEN:
        known = (
            f"the recording may be damaged ({found.reasons[damaged]:.2f}): {_where_damaged(prepared, found)}"
        )
        detail = f"{known}; {detail}" if detail else known
    return without_force(
        Status.DOUBTFUL,
        detail,
        prepared,
        candidates=events,
        probability=max(*(event.probability for event in events), *found.reasons.values()),
    )


def least_fall_N(prepared: Prepared, settings: PickSettings) -> float:
    """Return the smallest fall of the block means that may be more than noise [N]."""
    return max(DROP_SIGMAS * prepared.blocks.noise_N, 0.5 * (settings.min_step_N or 0.0), TINY)


def rests_of(prepared: Prepared, whole: Look) -> BoolArray:
    """Return in which blocks the rope rests, is held or is let down."""
    still = whole.states[:, list(STILL)].sum(axis=1) > 0.5
    return np.asarray(still[_bins_of(whole, prepared.blocks.time_s)])


def measured(
    prepared: Prepared, settings: PickSettings, block: int, rests: BoolArray | None, start: int = 0
) -> Breakaway:
    """Return the result `ok` for a top of a climb from a start, with the slips after it; none if `rests` is None."""
    force_N = prepared.blocks.force_N
    fallen = fallen_from(force_N, block, least_fall_N(prepared, settings))
    sliding = None if rests is None else sliding_after(prepared, block, fallen, rests)
    if sliding is None:
        fallen = min(block + 2, force_N.size - 1)
    result = peak_result(prepared, settings, block, start=start, fallen=fallen, sliding=sliding)
    if sliding is None:
        return result
    teeth = teeth_of(force_N[block : sliding.stop + 1], least_fall_N(prepared, settings)) + block
    apart_s = np.diff(prepared.blocks.time_s[[block, *teeth.tolist()]])
    return replace(
        result,
        n_slips=1 + teeth.size if teeth.size else 0,
        recurrence_s=float(np.median(apart_s)) if teeth.size else nan,
    )


def fallen_from(force_N: FloatArray, top: int, least_N: float) -> int:
    """Return the block at which a fall ends: it turns, or grows by less than a tenth in twice its time."""
    after = force_N[top:]
    lowest_N = np.minimum.accumulate(after)
    fall_N = after[0] - lowest_N
    later_N = lowest_N[np.minimum(3 * np.arange(after.size) + ENOUGH, after.size - 1)]
    ends = (fall_N > least_N) & (lowest_N - later_N <= 0.1 * fall_N)
    ends |= after - lowest_N > np.maximum(least_N, 0.3 * fall_N)
    stop = int(np.argmax(ends)) + 1 if ends.any() else after.size
    lowest = int(np.argmin(after[:stop]))
    return top + lowest if fall_N[lowest] > least_N else top


def swings(force_N: FloatArray, least_N: float) -> tuple[IntArray, FloatArray]:
    """Return the tops whose prominence is at least `least_N`, and their prominence [N]."""
    from scipy.signal import find_peaks  # noqa: PLC0415  (a third of a second, which only those pay who pick)

    tops, more = find_peaks(force_N, prominence=least_N)
    return tops, more["prominences"]


def teeth_of(force_N: FloatArray, least_N: float) -> IntArray:
    """Return the tops of a stick-slip train, without much smaller ones (creep) and a slow unloading at the end."""
    tops, heights_N = swings(force_N, least_N)
    if not tops.size:
        return tops
    bottoms = np.array([fallen_from(force_N, top, 0.5 * least_N) for top in tops.tolist()])
    is_last = np.array([force_N[low:].max() - force_N[low] < least_N for low in bottoms.tolist()])
    is_slow = bottoms - tops > 3 * np.median(bottoms - tops)
    typical_N = float(np.median(heights_N[heights_N >= LARGE * heights_N.max()]))
    return tops[~(is_last & is_slow) & (heights_N >= max(least_N, TOOTH * typical_N))]


def _bins_of(whole: Look, time_s: FloatArray) -> IntArray:
    return np.clip(np.searchsorted(whole.edges_s, time_s, side="right") - 1, 0, whole.place.size - 1)


def _events(prepared: Prepared, whole: Look, block: int, settings: PickSettings) -> Iterator[ForceEvent]:
    """Yield the falls before the break-away: partial slips and disturbances."""
    blocks = prepared.blocks
    least_N = max(least_fall_N(prepared, settings), FALL * abs(float(blocks.force_N[block])))
    tops, _ = swings(blocks.force_N[: block + 1], least_N)
    for top in tops.tolist():
        bottom = fallen_from(blocks.force_N, top, least_N)
        during = whole.states[np.unique(_bins_of(whole, blocks.time_s[top : bottom + 1]))].sum(axis=0)
        if during.argmax() in {State.HUNG, State.REST}:
            continue
        is_slip = (
            during[State.PARTIAL_SLIP] + during[State.SLIP] + during[State.LOADING] > during[State.DISTURBED]
        )
        yield ForceEvent(
            kind="partial-slip" if is_slip else "bump",
            time_s=float(blocks.time_s[top]),
            force_N=float(blocks.force_N[top]),
            drop_N=float(blocks.force_N[top] - blocks.force_N[bottom]),
            fall_s=float(blocks.time_s[bottom] - blocks.time_s[top]),
        )


# --- what hides a peak ----------------------------------------------------------------------------------------------


def _cut_off(trace: ForceTrace, prepared: Prepared, block: int | None) -> str:
    """Return in words where the converter was at its limit, before a top or anywhere; empty if nowhere."""
    end = prepared.force_N.size
    if block is not None:
        end = prepared.blocks.last_sample(block + 2, end) + 1
    if trace.saturation is None:
        return _held_at_top(prepared, end)
    end_s, begin_s = float(prepared.time_s[end - 1]), float(prepared.time_s[0])
    runs = [
        (start, stop)
        for start, stop in trace.saturation.high_runs.tolist()
        if stop - start >= SATURATED_SAMPLES
        and trace.time_s[start] <= end_s
        and trace.time_s[stop - 1] >= begin_s
    ]
    if not runs:
        return ""
    ceiling_N = float(np.nanmax(trace.force_N))
    samples = sum(stop - start for start, stop in runs)
    longest_s = max(float(trace.time_s[stop - 1] - trace.time_s[start]) for start, stop in runs)
    return (
        f"the converter is at its ceiling ({ceiling_N:.4g} N) for {samples} samples, {1000 * longest_s:.3g} ms at a "
        f"time; the peak is at least {ceiling_N:.4g} N"
    )


def _held_at_top(prepared: Prepared, end: int) -> str:
    """Return in words whether the first `end` samples are held at the largest force; empty if not."""
    force_N = prepared.force_N[:end]
    top_N = float(force_N.max())
    # Noise touches a limit again and again; a converter that sticks at the largest force does so once.
    sticks = any(prepared.force_N[start] == top_N for start, _ in prepared.stuck.tolist())
    again_and_again = prepared.blocks.resolution_N < prepared.noise_N and len(runs_of(force_N == top_N)) > 1
    if top_N < float(prepared.force_N.max()) or (sticks and not again_and_again):
        return ""
    held = runs_of(np.diff(force_N, append=np.inf) == 0.0)
    lengths, held_N = held[:, 1] - held[:, 0] + 1, force_N[held[:, 0]]
    is_top, is_high = held_N == top_N, held_N > 0.5 * (top_N + float(force_N.min()))
    usual, longest = int(lengths[~is_top & is_high].max(initial=1)), int(lengths[is_top].max(initial=0))
    if longest <= SATURATED_SAMPLES or longest < CUT_OFF * usual:
        return ""
    return (
        f"the force stays at exactly {top_N:.4g} N for {longest} samples, {usual} elsewhere: it is cut off there, and "
        f"the peak is at least {top_N:.4g} N"
    )


def _stuck(prepared: Prepared, block: int) -> str:
    """Return in words where the converter was stuck between half the climb to a top and its fall; empty if nowhere."""
    blocks, n, time_s = prepared.blocks, prepared.force_N.size, prepared.time_s
    begin = blocks.first_sample(half_climb(blocks.force_N, block))
    end = blocks.last_sample(fallen_from(blocks.force_N, block, DROP_SIGMAS * blocks.noise_N) + 1, n)
    for start, stop in prepared.stuck.tolist():
        before_N, after_N = (float(prepared.force_N[i]) for i in (max(start - 1, 0), min(stop, n - 1)))
        lasted_s, climbed_s = float(time_s[stop - 1] - time_s[start]), float(time_s[start] - time_s[begin])
        # A force that gained about what it had to at the rate before climbed on meanwhile, short of the top.
        rate_N_s = (before_N - float(prepared.force_N[begin])) / climbed_s if climbed_s > 0.0 else 0.0
        gains = after_N > before_N and after_N - before_N > CLIMBS_ON * rate_N_s * lasted_s
        if stop > begin and start <= end and not (gains and stop <= blocks.first_sample(block)):
            return (
                f"the force reads exactly {prepared.force_N[start]:.4g} N for {lasted_s:.2g} s ({stop - start} "
                f"samples) from {time_s[start]:.4g} s on, between loading and sliding: the converter "
                "or the sensor stuck, and what the force did meanwhile is unknown"
            )
    return ""


def _with_its_gap(prepared: Prepared, result: Breakaway) -> Breakaway:
    """Return a doubtful result if the force may have been higher in a gap beside its top."""
    index = int(np.searchsorted(prepared.time_s, result.peak_time_s))
    below = np.flatnonzero(prepared.force_N[:index] < (1.0 - HIDES) * result.peak_N)
    gap_s, last = gap_beside(prepared.time_s, result, first=int(below[-1]) if below.size else 0)
    if not gap_s:
        return result
    highest_N = _climbed_to_N(prepared, last, gap_s, result.peak_N)
    if np.isfinite(result.kinetic_N):
        highest_N = min(highest_N, 2.0 * result.peak_N - result.kinetic_N)
    before_N, after_N = prepared.force_N[[last, min(last + 1, prepared.force_N.size - 1)]].tolist()
    is_climb = after_N - before_N > (1.0 - STEEP) * abs(result.peak_N)
    if highest_N - result.peak_N <= HIDES * abs(result.peak_N) and not is_climb:
        return result
    why = f"there is a gap of {gap_s:.3g} s in the samples next to the peak, " + (
        "in which most of the climb lies" if is_climb else "in which the force may have been higher"
    )
    seen_N, higher_N = max(result.peak_N, before_N), max(highest_N, result.peak_N)
    return either(result, why, {"as read": seen_N, "climbed on in the gap": higher_N})


def _climbed_to_N(prepared: Prepared, last: int, gap_s: float, peak_N: float) -> float:
    """Return the largest force a climb may have reached in a gap, by the parabola through its upper part [N]."""
    first = last - int(np.argmax(prepared.force_N[last::-1] < STEEP * peak_N)) + 1
    part = slice(first, last + 1)
    since_s, force_N = prepared.time_s[part] - prepared.time_s[last], prepared.force_N[part]
    if force_N.size < ENOUGH_TO_BEND:
        return float(prepared.force_N[last])
    bend, rate, end_N = np.polyfit(since_s, force_N, 2)
    turns_s = -rate / (2.0 * bend) if bend < 0.0 else gap_s
    on_s = float(np.clip(turns_s, 0.0, gap_s))
    return float(end_N + rate * on_s + min(bend, 0.0) * on_s**2)
