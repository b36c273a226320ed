"""What may be wrong with a force that was found: what the samples right before its top show."""

from dataclasses import replace

import numpy as np

from ropefric.traces.breakaway import Breakaway, Status
from ropefric.traces.noise import MAX_SPIKE_SAMPLES, REJOINS, SPIKE_SIGMAS, STANDS_OUT
from ropefric.traces.peak import early_s, gap_beside, line_through
from ropefric.traces.results import as_read, either
from ropefric.traces.segments import Prepared

BEFORE = 20
"""So many steps before a jump tell how far the force goes from one sample to the next."""
MATTERS, HIDES = 0.01, 0.02
"""Parts of F_A by which a jump at the top matters, and what a gap beside it may hide."""
JUMP_SAMPLES, LOADED = 8, 0.1
"""A jump is looked for above this part of F_A, and stays for so many samples."""
STRAIGHT = 0.5
"""A climb that has not begun to turn keeps this part of its rate."""


def with_its_top(prepared: Prepared, result: Breakaway) -> Breakaway:
    """Return a result that is in doubt where its very top is: hidden in a gap, or no step of the climb."""
    if result.status is not Status.OK:
        return result
    gap_s, last = gap_beside(prepared.time_s, result)
    hidden_N = max(result.loading_rate_N_s, 0.0) * gap_s
    hidden_N = (
        min(hidden_N, result.peak_N - result.kinetic_N) if result.kinetic_N < result.peak_N else hidden_N
    )
    if hidden_N > HIDES * abs(result.peak_N) and _climbs_on(prepared, result, last + 1):
        highest = replace(as_read(result), force_N=result.peak_N + hidden_N, evidence="climbed on in the gap")
        why = "there is a gap in the samples next to the peak, in which the force may have been higher"
        return either(result, [as_read(result), highest], why)
    return _with_its_jump(prepared, result)


def _climbs_on(prepared: Prepared, result: Breakaway, stop: int) -> bool:
    """Return whether the force climbs straight up to the very end of a stretch: it has not begun to turn."""
    # Of few noisy samples a slope says nothing.
    first = int(np.searchsorted(prepared.time_s, result.peak_time_s - 2.0 * early_s(result)))
    last = slice(max(0, min(first, stop - BEFORE)), stop)
    time_s, force_N = prepared.time_s[last], prepared.force_N[last]
    rising = force_N > 0.5 * result.peak_N
    if np.count_nonzero(rising) < BEFORE:
        return False
    slopes = [
        line_through(time_s[part], force_N[part])[2] for part in (slice(None), slice(time_s.size // 2, None))
    ]
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
