"""How what was found is told: a force, a reason why there is none, or a doubt with its candidates."""

from dataclasses import replace
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.traces.breakaway import Breakaway, ForceEvent, PickSettings, Status
from ropefric.traces.events import Fall, half_climb
from ropefric.traces.evidence import TOOTH, quiet_N
from ropefric.traces.peak import peak_result
from ropefric.traces.segments import (
    MIN_SAMPLES,
    Prepared,
    Sliding,
    kinetic,
    phases_of,
    roughness_N,
)
from ropefric.traces.slips import Candidate, typical_drop_N
from ropefric.traces.trace import ForceTrace

FLAT_BLOCKS = 8


def too_short(trace: ForceTrace, settings: PickSettings) -> Breakaway:
    """Return the result for a recording that `prepare` refused."""
    n = int(np.isfinite(trace.force_N).sum())
    part = " in the part looked at" if settings.start_s is not None or settings.stop_s is not None else ""
    detail = f"{trace.force_N.size} samples, {n} of them usable{part}; at least {MIN_SAMPLES} are needed"
    return Breakaway(status=Status.TOO_SHORT, detail=detail)


def without_force(status: Status, detail: str, prepared: Prepared, **found: Any) -> Breakaway:
    """Return a result without a force, with the reason."""
    return Breakaway(
        status=status, detail=detail, noise_std_N=prepared.noise_N, notes=prepared.notes, **found
    )


def event_of(prepared: Prepared, fall: Fall, kind: str, evidence: str = "") -> ForceEvent:
    """Return a fall as an event of a kind."""
    time_s = prepared.blocks.time_s
    return ForceEvent(
        kind=kind,
        time_s=float(time_s[fall.top]),
        force_N=fall.top_N,
        drop_N=fall.drop_N,
        fall_s=float(time_s[min(fall.settled, time_s.size - 1)] - time_s[fall.top]),
        evidence=evidence,
    )


def doubtful(prepared: Prepared, candidates: list[Candidate], why: str) -> Breakaway:
    """Return a result that leaves open whether, or which of, some falls are the break-away."""
    events = tuple(event_of(prepared, candidate.fall, "break-away", why) for candidate in candidates)
    forces = " or ".join(f"{event.force_N:.4g} N at {event.time_s:.4g} s" for event in events)
    return without_force(Status.DOUBTFUL, f"{forces}: {why}", prepared, candidates=events)


def measured(
    prepared: Prepared, settings: PickSettings, candidate: Candidate, sliding: Sliding | None
) -> Breakaway:
    """Return the result `ok` for a fall, with the slips that follow it."""
    blocks, fall = prepared.blocks, candidate.fall
    result = peak_result(
        prepared,
        settings,
        climb=half_climb(blocks.force_N, fall.start, fall.top),
        block=fall.top,
        fallen=fall.settled,
        sliding=sliding,
        phases=phases_of(prepared, fall.top, sliding),
    )
    if sliding is None or not fall.slips:
        return result
    later = [g for g in candidate.pull.falls if fall.top < g.top < sliding.stop and g.slips]
    least_N = TOOTH * typical_drop_N(later)
    teeth = [fall, *(g for g in later if g.drop_N >= least_N)]
    apart_s = np.diff([float(blocks.time_s[tooth.top]) for tooth in teeth])
    return replace(
        result, n_slips=len(teeth), recurrence_s=float(np.median(apart_s)) if apart_s.size else np.nan
    )


def held_rope(prepared: Prepared, sliding: Sliding) -> Breakaway:
    """Return the result for a rope that was held and did not slip."""
    held = f"the force stays at a quiet {sliding.level_N:.4g} N without a sudden drop: held, not slipping"
    return without_force(Status.NO_BREAKAWAY, held, prepared)


def no_peak(prepared: Prepared, candidate: Candidate, sliding: Sliding, why: str) -> Breakaway:
    """Return the result for a rope that slides without a static peak."""
    top_N = candidate.fall.top_N
    kinetic_N, kinetic_std_N = kinetic(prepared, sliding)
    return without_force(
        Status.NO_PEAK,
        f"the largest force before sliding, {top_N:.4g} N, stands {top_N - sliding.onset_N:.2g} N above the sliding "
        f"force of {sliding.onset_N:.4g} ± {sliding.scatter_N:.2g} N: {why}",
        prepared,
        kinetic_N=kinetic_N,
        kinetic_std_N=kinetic_std_N,
        phases=phases_of(prepared, candidate.fall.top, sliding),
    )


def levels_off(prepared: Prepared, force_N: FloatArray) -> Breakaway:
    """Return what a force that did not drop means: still loading, held, or slid without a peak."""
    blocks = prepared.blocks
    base_N, top_N = float(force_N[0]), float(force_N.max())
    flat = force_N[int(np.argmax(force_N >= base_N + 0.9 * (top_N - base_N))) :]
    if flat.size < FLAT_BLOCKS or _rises_to_the_end(flat, blocks.noise_N):
        detail = f"the force is still rising at the end, {force_N[-1]:.4g} N: the rope never slipped"
        return without_force(Status.NO_BREAKAWAY, detail, prepared)
    level = flat[flat.size // 3 :]
    rough_N = roughness_N(level)
    if rough_N <= quiet_N(prepared, 0, int(np.argmax(blocks.force_N))):
        detail = f"the force stays at a quiet {np.median(level):.4g} N without a drop: held, not slipping"
        return without_force(Status.NO_BREAKAWAY, detail, prepared)
    detail = (
        f"the force bends into a wandering {np.median(level):.4g} ± {rough_N:.2g} N without a drop: "
        "the rope slides, but had no static peak"
    )
    return without_force(
        Status.NO_PEAK,
        detail,
        prepared,
        kinetic_N=float(level.mean()),
        kinetic_std_N=float(level.std(ddof=1)),
    )


def _rises_to_the_end(flat: FloatArray, noise_N: float) -> bool:
    third = max(2, flat.size // 3)
    gain_N = float(np.median(flat[-third:]) - np.median(flat[:third]))
    late_N = float(np.median(flat[-third // 2 :]) - np.median(flat[-third : -third // 2]))
    return gain_N > 3 * noise_N and late_N > 0.15 * gain_N


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
