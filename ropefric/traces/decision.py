"""One recording, one break-away: whether the rope slipped and a static peak stands out, or what is there instead."""

from dataclasses import replace
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.traces.breakaway import Breakaway, PickSettings, Status
from ropefric.traces.noise import noise_std
from ropefric.traces.peak import peak_result
from ropefric.traces.segments import (
    DROP_SIGMAS,
    FAST_BLOCKS,
    MIN_SAMPLES,
    PIECE_BLOCKS,
    SLIP_SIGMAS,
    Blocks,
    Prepared,
    Sliding,
    climb_to,
    fast_drop_N,
    first_static_break,
    flattened,
    is_slip,
    kinetic,
    phases_of,
    prepare,
    roughness_N,
    sliding_after,
    slips,
    slow_break,
)
from ropefric.traces.trace import ForceTrace

SATURATED_SAMPLES = 3
"""A run at the converter's limit longer than any spike."""
SAME_KIND = 0.3
"""A fall smaller than this part of the first slip is no tooth but the creep of one."""
RESOLVED_SIGMAS = 4.0
QUIET_SIGMAS = 1.5
FLAT_BLOCKS = 8
LET_DOWN = 0.05
FAR_DOWN = 0.1
_LEAST_CLIMB = 30
_LANDING = 5


def pick_breakaway(trace: ForceTrace, settings: PickSettings) -> tuple[Breakaway, ...]:
    """Return the break-away of a recording in which the load is raised once until the rope slides."""
    prepared = prepare(trace, settings)
    return (too_short(trace, settings) if prepared is None else pick_prepared(trace, prepared, settings),)


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


def smallest_drop_N(prepared: Prepared, settings: PickSettings) -> float:
    """Return the smallest drop of the block means that may be more than noise [N]."""
    return max(DROP_SIGMAS * prepared.blocks.noise_N, 0.5 * (settings.min_step_N or 0.0))


def _before_separation(trace: ForceTrace, prepared: Prepared, settings: PickSettings) -> Breakaway:
    """Find the highest force of a recording that ends with the rope or specimen coming off."""
    force_N = prepared.blocks.force_N
    block = int(np.argmax(force_N))
    if hidden := _hidden(trace, prepared, block, None):
        return hidden
    if float(force_N[block]) - float(force_N[block:].min()) <= smallest_drop_N(prepared, settings):
        return _without_break(prepared)
    return _measured(prepared, block, None, settings)


def _before_sliding(trace: ForceTrace, prepared: Prepared, settings: PickSettings) -> Breakaway:
    """Find the static peak of a recording that goes on to slide."""
    blocks = prepared.blocks
    block = first_static_break(blocks, smallest_drop_N(prepared, settings))
    sliding = None if block is None else sliding_after(blocks, block)
    if hidden := _hidden(trace, prepared, block, sliding):
        return hidden
    if block is None:
        return _without_break(prepared)
    from_N, at_s = blocks.force_N[block], blocks.time_s[block]
    if sliding is None:
        before = _without_break(prepared, block)
        detail = (
            f"the force falls from {from_N:.4g} N at {at_s:.4g} s without a stretch of sliding: motor stopped, or "
            'rope off. If these recordings end in a pull-off, set [protocol] ending = "separation".'
        )
        return (
            before
            if before.status is Status.NO_PEAK
            else without_force(Status.NO_BREAKAWAY, detail, prepared)
        )
    slipped = is_slip(blocks, block)
    if not slipped and flattened(blocks.force_N, block):
        return _without_break(prepared, block)
    no_slip = _no_slip(prepared, block, sliding, settings)
    slow = slow_break(blocks, block)
    if slow is not None and slow.drop_N >= (settings.min_step_N or 0.0) and (no_slip or slow.outlasts_slip):
        note = (
            f"the force falls by {slow.drop_N:.3g} N within {1000 * slow.fall_s:.2g} ms, slower than a slip, and stays "
            f"at {slow.share:.0%} of the peak: a break-away, unless the motor was let back at that moment"
        )
        noted = replace(prepared, notes=(*prepared.notes, note))
        return _measured(noted, block, slow.sliding, settings)
    if no_slip is None and slow is None and not slipped:
        detail = (
            f"the force falls from {from_N:.4g} N to {sliding.onset_N:.4g} N slower than a rope slips, and the "
            f"recording ends {prepared.time_s[-1] - at_s:.2g} s later"
        )
        no_slip = without_force(Status.NO_BREAKAWAY, detail, prepared)
    return no_slip or _measured(prepared, block, sliding, settings)


def _measured(prepared: Prepared, block: int, sliding: Sliding | None, settings: PickSettings) -> Breakaway:
    blocks = prepared.blocks
    force_N = blocks.force_N
    result = peak_result(
        prepared,
        settings,
        climb=climb_to(force_N, block).start,
        block=block,
        fallen=sliding.first if sliding else min(block + 2, force_N.size - 1),
        sliding=sliding,
        phases=phases_of(prepared, block, sliding),
    )
    if sliding is None or not is_slip(blocks, block):
        return result
    stretch = force_N[sliding.first : sliding.stop + FAST_BLOCKS]
    falls = slips(stretch, blocks.noise_N, most=stretch.size)
    typical_N = float(np.median([fall_N for _, fall_N in falls])) if falls else 0.0
    # Small against the typical one, a fall is the creep of a tooth; the first slip is no measure of those that follow.
    found = sorted(sliding.first + tooth for tooth, fall_N in falls if fall_N >= SAME_KIND * typical_N)
    teeth = [block, *found]
    apart_s = np.diff(blocks.time_s[teeth])
    return replace(
        result, n_slips=len(teeth), recurrence_s=float(np.median(apart_s)) if apart_s.size else np.nan
    )


def teeth_of(blocks: Blocks, block: int, sliding: Sliding, settings: PickSettings) -> list[int]:
    """Return the blocks of the sudden falls of a sliding force that are of the kind of the first, in order."""
    smallest_N = max(SAME_KIND * fast_drop_N(blocks.force_N, block), settings.min_step_N or 0.0)
    stretch = blocks.force_N[sliding.first : sliding.stop + FAST_BLOCKS]
    found = slips(stretch, blocks.noise_N, most=stretch.size)
    return sorted(sliding.first + tooth for tooth, fall_N in found if fall_N >= smallest_N)


def _hidden(
    trace: ForceTrace, prepared: Prepared, block: int | None, sliding: Sliding | None
) -> Breakaway | None:
    """Say why the converter did not show the peak; None if it did, or nothing broke away."""
    if saturated := _saturation_detail(trace, prepared, block):
        return without_force(Status.SATURATED, saturated, prepared)
    if block is None:
        return None
    stuck = _stuck_detail(prepared, block, sliding.first if sliding else block + 1)
    return without_force(Status.NO_PEAK, stuck, prepared) if stuck else None


def _saturation_detail(trace: ForceTrace, prepared: Prepared, block: int | None) -> str:
    """Return where the converter sat at its ceiling up to the break; empty where it did not."""
    if trace.saturation is None:
        return ""
    begin_s, end_s = prepared.time_s[0], prepared.time_s[-1]
    if block is not None and block + 2 < prepared.blocks.time_s.size:
        end_s = prepared.blocks.time_s[block + 2]
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


def _stuck_detail(prepared: Prepared, block: int, fallen: int) -> str:
    """Return where the converter stuck between half the climb to a break and the fall after it; empty if nowhere.

    What the force did meanwhile nobody knows: the peak may lie in the stretch, and what is found be a later tooth.
    """
    blocks, n = prepared.blocks, prepared.force_N.size
    begin = blocks.first_sample(climb_to(blocks.force_N, block).start)
    end = blocks.last_sample(fallen + 1, n)
    for start, stop in prepared.stuck.tolist():
        if stop > begin and start <= end and not _climbed_on(prepared, start, stop):
            lasted_s = float(prepared.time_s[stop - 1] - prepared.time_s[start])
            return (
                f"the force reads exactly {prepared.force_N[start]:.4g} N for {lasted_s:.2g} s ({stop - start} "
                f"samples) from {prepared.time_s[start]:.4g} s on, between loading and sliding: the converter "
                "or the sensor stuck, and what the force did meanwhile is unknown"
            )
    return ""


def _climbed_on(prepared: Prepared, start: int, stop: int) -> bool:
    """Return whether the force stands after a stretch where the climb before it leads to: no peak lies within."""
    force_N, lasted = prepared.force_N, stop - start
    before = force_N[max(0, start - max(lasted, _LEAST_CLIMB)) : start]
    after = force_N[stop : stop + _LANDING]
    if before.size < _LEAST_CLIMB or not after.size:
        return False
    rise_N = lasted * float(np.polyfit(np.arange(before.size), before, 1)[0])
    return float(after.mean() - force_N[start]) >= 0.5 * rise_N - 2.0 * prepared.noise_N


def _without_break(prepared: Prepared, last_block: int | None = None) -> Breakaway:
    """Return what a force that did not drop up to `last_block` means: still loading, held, or slid without a peak."""
    blocks = prepared.blocks
    force_N = blocks.force_N if last_block is None else blocks.force_N[: last_block + 1]
    base_N, top_N = float(force_N[0]), float(force_N.max())
    flat = force_N[int(np.argmax(force_N >= base_N + 0.9 * (top_N - base_N))) :]
    if flat.size < FLAT_BLOCKS or _rises_to_the_end(flat, blocks.noise_N):
        detail = f"the force is still rising at the end, {force_N[-1]:.4g} N: the rope never slipped"
        return without_force(Status.NO_BREAKAWAY, detail, prepared)
    level = flat[flat.size // 3 :]
    rough_N = roughness_N(level)
    if rough_N <= _quiet_N(prepared, int(np.argmax(force_N))):
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


def _no_slip(prepared: Prepared, block: int, sliding: Sliding, settings: PickSettings) -> Breakaway | None:
    """Say what a break means that is no static peak; None if it is one."""
    blocks = prepared.blocks
    top_N = float(blocks.force_N[block])
    if _was_let_down(prepared, block, sliding):
        detail = (
            f"the force is let down from {top_N:.4g} N to a quiet {sliding.level_N:.4g} N: "
            "the motor stopped before the rope slipped"
        )
        return without_force(Status.NO_BREAKAWAY, detail, prepared)
    above_N = top_N - sliding.onset_N
    is_small = settings.min_step_N is not None and above_N < settings.min_step_N
    if not is_small and _stands_out(prepared, block, sliding, above_N):
        return None
    if not is_slip(blocks, block) and _is_quiet(prepared, block, sliding):
        detail = (
            f"the force stays at a quiet {sliding.level_N:.4g} N without a sudden drop: held, not slipping"
        )
        return without_force(Status.NO_BREAKAWAY, detail, prepared)
    why = f"less than min_step = {settings.min_step_N:.3g} N" if is_small else "no static peak stands out"
    kinetic_N, kinetic_std_N = kinetic(prepared, sliding)
    return without_force(
        Status.NO_PEAK,
        f"the largest force before sliding, {top_N:.4g} N, stands {above_N:.2g} N above the sliding force of "
        f"{sliding.onset_N:.4g} ± {sliding.scatter_N:.2g} N: {why}",
        prepared,
        kinetic_N=kinetic_N,
        kinetic_std_N=kinetic_std_N,
        phases=phases_of(prepared, block, sliding),
    )


def _was_let_down(prepared: Prepared, block: int, sliding: Sliding) -> bool:
    """Return whether the force was let down slowly onto a quiet level instead of slipping."""
    blocks = prepared.blocks
    top_N, base_N = float(blocks.force_N[block]), float(blocks.force_N[: block + 1].min())
    if is_slip(blocks, block) or top_N - sliding.onset_N < LET_DOWN * (top_N - base_N):
        return False
    below = np.flatnonzero(blocks.force_N[block:] < 0.5 * (top_N + sliding.onset_N))
    if not below.size or int(below[0]) <= 2:
        return False
    settled = blocks.force_N[block + int(below[0]) :]
    if settled.size < FLAT_BLOCKS or slips(settled, blocks.noise_N, most=1):
        return False
    # A release dies away smoothly: whatever its curve, neighbouring blocks differ by noise only.
    quiet_N = _quiet_N(prepared, block)
    return noise_std(settled) <= quiet_N and (
        top_N - sliding.onset_N > FAR_DOWN * (top_N - base_N) or roughness_N(settled) <= quiet_N
    )


def _stands_out(prepared: Prepared, block: int, sliding: Sliding, above_N: float) -> bool:
    """Return whether a break is a static peak, not the highest wiggle of a force that merely levels off."""
    blocks = prepared.blocks
    fast_N = fast_drop_N(blocks.force_N, block)
    slipped = is_slip(blocks, block)
    if fast_N <= SLIP_SIGMAS * blocks.noise_N or not (slipped or fast_N > 0.5 * above_N):
        return False
    if above_N > RESOLVED_SIGMAS * sliding.scatter_N:
        return True
    # In stick-slip the scatter is that of the teeth: they are slips themselves, and the first one counts.
    if not slipped or above_N < 0.1 * fast_N or not 3.0 * blocks.noise_N < sliding.scatter_N < 0.8 * fast_N:
        return False
    falls = slips(blocks.force_N[sliding.first : sliding.stop], blocks.noise_N, most=2)
    return len(falls) == 0 or fast_N > 1.5 * falls[0][1] or (len(falls) == 2 and falls[1][1] > 0.3 * fast_N)


def _is_quiet(prepared: Prepared, block: int, sliding: Sliding) -> bool:
    """Return whether the force after a break wanders no more than its noise: a rope at rest; sliding is rough."""
    stretch = prepared.blocks.force_N[sliding.first : sliding.stop]
    if stretch.size < 2 * PIECE_BLOCKS:
        # So short a stretch may be a rope held for a moment and the start of its release.
        stretch = prepared.blocks.force_N[block : block + PIECE_BLOCKS // 2]
    return roughness_N(stretch) <= _quiet_N(prepared, block)


def _quiet_N(prepared: Prepared, block: int) -> float:
    """Return the largest roughness of a rope at rest [N]: noise, or a slow creep through the converter's steps.

    The noise is that of the loading, for sliding itself is rough. A loading too short to tell gives 0.
    """
    blocks = prepared.blocks
    force_N = blocks.force_N[: block + 1]
    base_N = float(force_N.min())
    loading = int(np.argmax(force_N >= base_N + 0.8 * (float(force_N[block]) - base_N)))
    if loading < PIECE_BLOCKS:
        return 0.0
    floor_N = blocks.resolution_N / np.sqrt(12.0 * blocks.size)
    noise_N = max(noise_std(force_N[:loading]), float(floor_N))
    return max(QUIET_SIGMAS * noise_N, 0.35 * blocks.resolution_N)
