"""What may be wrong with a force that was found: what the samples right at the top show, and how a doubt is told."""

from dataclasses import replace

import numpy as np

from ropefric.traces.breakaway import Breakaway, ForceEvent, Status
from ropefric.traces.noise import MAX_SPIKE_SAMPLES, REJOINS, SPIKE_SIGMAS, STANDS_OUT
from ropefric.traces.peak import gap_beside_s
from ropefric.traces.segments import Prepared

BEFORE = 20
"""So many steps before a jump tell how far the force goes from one sample to the next."""
MATTERS, HIDES = 0.01, 0.02
"""Parts of F_A by which a jump at the top matters, and what a gap beside it may hide."""
STRAIGHT = 0.5
"""A climb that has not begun to turn keeps this part of its rate."""


def with_its_top(prepared: Prepared, result: Breakaway) -> Breakaway:
    """Return a result that is in doubt where its very top is: hidden in a gap, or no step of the climb."""
    if result.status is not Status.OK:
        return result
    hidden_N = max(result.loading_rate_N_s, 0.0) * gap_beside_s(prepared.time_s, result)
    hidden_N = min(hidden_N, result.peak_N - result.kinetic_N) if result.kinetic_N < result.peak_N else hidden_N
    if hidden_N > HIDES * abs(result.peak_N) and _climbs_on(prepared, result):
        highest = replace(as_read(result), force_N=result.peak_N + hidden_N, evidence="climbed on in the gap")
        why = "there is a gap in the samples next to the peak, in which the force may have been higher"
        return either(result, [as_read(result), highest], why)
    return _with_its_jump(prepared, result)


def _climbs_on(prepared: Prepared, result: Breakaway) -> bool:
    """Return whether the force climbs straight up to the very top: it has not begun to turn."""
    half = 0.5 * result.window_s
    top = int(np.searchsorted(prepared.time_s, result.peak_time_s + half, side="right"))
    last = slice(max(0, top - BEFORE), top)
    time_s, force_N = prepared.time_s[last], prepared.force_N[last]
    rising = force_N > 0.5 * result.peak_N
    if np.count_nonzero(rising) < BEFORE:
        return False
    slopes = [np.polyfit(time_s[part], force_N[part], 1)[0] for part in (slice(None), slice(BEFORE // 2, None))]
    return min(slopes) > STRAIGHT * result.loading_rate_N_s


def _with_its_jump(prepared: Prepared, result: Breakaway) -> Breakaway:
    """Return a result that is in doubt where the force jumped to its top and was back before its fall could begin.

    A machine climbs to the top in many steps alike. What jumps there in one and is gone within a few samples is a spike
    or a blow, and whether the rope slipped at that height, or below it, the force does not tell.
    """
    force_N = prepared.force_N
    top = int(np.searchsorted(prepared.time_s, result.peak_time_s))
    first = max(BEFORE, top - MAX_SPIKE_SAMPLES)
    steps_N = np.diff(force_N[first : top + 2])
    if not steps_N.size:
        return result
    at, jump_N = first + int(np.argmax(steps_N)), float(steps_N.max())
    usual_N = float(np.abs(np.diff(force_N[at - BEFORE : at + 1])).max())
    after = force_N[at + 1 : at + 2 + MAX_SPIKE_SAMPLES]
    if (
        jump_N <= max(STANDS_OUT * usual_N, SPIKE_SIGMAS * prepared.noise_N, MATTERS * abs(result.peak_N))
        or float(after.min()) > force_N[at] + REJOINS * jump_N
    ):
        return result
    before = replace(
        as_read(result),
        time_s=float(prepared.time_s[at]),
        force_N=float(force_N[at]),
        evidence="before the jump",
    )
    why = f"the force jumps by {jump_N:.3g} N at its very top, and is back at once: a blow, a spike, or its last climb"
    return either(result, [before, as_read(result)], why)


def as_read(result: Breakaway) -> ForceEvent:
    """Return the break-away of a result as a candidate."""
    return ForceEvent(
        kind="break-away",
        time_s=result.peak_time_s,
        force_N=result.peak_N,
        drop_N=result.drop_N,
        fall_s=0.0,
        evidence="as read",
    )


def either(result: Breakaway, events: list[ForceEvent], why: str) -> Breakaway:
    """Return a result that leaves open which of some forces is F_A."""
    return Breakaway(
        status=Status.DOUBTFUL,
        detail=f"{' or '.join(f'{event.force_N:.4g} N' for event in events)}: {why}",
        noise_std_N=result.noise_std_N,
        candidates=tuple(events),
        events=result.events,
        notes=result.notes,
        phases=result.phases,
    )
