"""What a recording without a usable static peak shows instead: still loading, held, let down, or sliding."""

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.traces.breakaway import Breakaway, Status
from ropefric.traces.loading import climb_to
from ropefric.traces.noise import noise_std
from ropefric.traces.prepare import Prepared, failed
from ropefric.traces.settings import PickSettings
from ropefric.traces.sliding import PIECE_BLOCKS, Sliding, roughness_N
from ropefric.traces.slips import SLIP_SIGMAS, fast_drop_N, is_slip, slips
from ropefric.traces.trace import ForceTrace

SATURATED_SAMPLES = 3
"""A run at the converter's limit longer than any spike."""
RESOLVED_SIGMAS = 4.0
QUIET_SIGMAS = 1.5
FLAT_BLOCKS = 8
LET_DOWN = 0.05
FAR_DOWN = 0.1
_LEAST_CLIMB = 30
_LANDING = 5


def saturation_detail(trace: ForceTrace, prepared: Prepared, block: int | None) -> str:
    """Return where the converter sat at its ceiling up to the break; empty where it did not."""
    if trace.saturation is None:
        return ""
    end_s = prepared.time_s[-1]
    if block is not None and block + 2 < prepared.view.time_s.size:
        end_s = prepared.view.time_s[block + 2]
    begin_s = prepared.time_s[0]
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


def stuck_detail(prepared: Prepared, block: int, fallen: int) -> str:
    """Return where the converter stuck between half the climb to a break and the fall after it; empty if nowhere.

    What the force did meanwhile nobody knows: the peak may lie in the stretch, and what is found be a later tooth.
    """
    view, n = prepared.view, prepared.force_N.size
    begin = view.first_sample(climb_to(view.force_N, block).start)
    end = view.last_sample(fallen + 1, n)
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
    before, after = (
        force_N[max(0, start - max(lasted, _LEAST_CLIMB)) : start],
        force_N[stop : stop + _LANDING],
    )
    if before.size < _LEAST_CLIMB or not after.size:
        return False
    rise_N = lasted * float(np.polyfit(np.arange(before.size), before, 1)[0])
    return float(after.mean() - force_N[start]) >= 0.5 * rise_N - 2.0 * prepared.noise_N


def without_break(prepared: Prepared, last_block: int | None = None) -> Breakaway:
    """Return what a force that did not drop up to `last_block` means: still loading, held, or slid without a peak."""
    view = prepared.view
    force_N = view.force_N if last_block is None else view.force_N[: last_block + 1]
    base_N, top_N = float(force_N[0]), float(force_N.max())
    flat = force_N[int(np.argmax(force_N >= base_N + 0.9 * (top_N - base_N))) :]
    if flat.size < FLAT_BLOCKS or _rises_to_the_end(flat, view.noise_N):
        detail = f"the force is still rising at the end, {force_N[-1]:.4g} N: the rope never slipped"
        return failed(Status.NO_BREAKAWAY, detail, prepared)
    level = flat[flat.size // 3 :]
    wander_N = roughness_N(level)
    if wander_N <= _quiet_N(prepared, int(np.argmax(force_N))):
        detail = f"the force stays at a quiet {np.median(level):.4g} N without a drop: held, not slipping"
        return failed(Status.NO_BREAKAWAY, detail, prepared)
    return Breakaway(
        status=Status.NO_PEAK,
        detail=(
            f"the force bends into a wandering {np.median(level):.4g} ± {wander_N:.2g} N without a drop: "
            "the rope slides, but had no static peak"
        ),
        kinetic_N=float(level.mean()),
        kinetic_std_N=float(level.std(ddof=1)),
        noise_std_N=prepared.noise_N,
        notes=prepared.notes,
    )


def _rises_to_the_end(flat: FloatArray, noise_N: float) -> bool:
    third = max(2, flat.size // 3)
    gain_N = float(np.median(flat[-third:]) - np.median(flat[:third]))
    late_N = float(np.median(flat[-third // 2 :]) - np.median(flat[-third : -third // 2]))
    return gain_N > 3 * noise_N and late_N > 0.15 * gain_N


def _quiet_N(prepared: Prepared, block: int) -> float:
    """Return the largest roughness of a rope at rest [N]: noise, or a slow creep through the converter's steps.

    The noise is that of the loading, for sliding itself is rough. A loading too short to tell gives 0.
    """
    view = prepared.view
    force_N = view.force_N[: block + 1]
    base_N = float(force_N.min())
    loading = int(np.argmax(force_N >= base_N + 0.8 * (float(force_N[block]) - base_N)))
    if loading < PIECE_BLOCKS:
        return 0.0
    floor_N = view.resolution_N / np.sqrt(12.0 * view.size)
    noise_N = max(noise_std(force_N[:loading]), float(floor_N))
    return max(QUIET_SIGMAS * noise_N, 0.35 * view.resolution_N)


def is_quiet(prepared: Prepared, block: int, sliding: Sliding) -> bool:
    """Return whether the force after a break wanders no more than its noise: a rope at rest; sliding is rough."""
    roughest_N = _quiet_N(prepared, block)
    if sliding.stop - sliding.first < 2 * PIECE_BLOCKS:
        # So short a stretch may be a rope held for a moment and the start of its release.
        return roughness_N(prepared.view.force_N[block : block + PIECE_BLOCKS // 2]) <= roughest_N
    return roughness_N(prepared.view.force_N[sliding.first : sliding.stop]) <= roughest_N


def was_let_down(prepared: Prepared, block: int, sliding: Sliding) -> bool:
    """Return whether the force was let down slowly onto a quiet level instead of slipping."""
    view = prepared.view
    top_N, base_N = float(view.force_N[block]), float(view.force_N[: block + 1].min())
    if is_slip(view, block) or top_N - sliding.onset_N < LET_DOWN * (top_N - base_N):
        return False
    below = np.flatnonzero(view.force_N[block:] < 0.5 * (top_N + sliding.onset_N))
    if not below.size or int(below[0]) <= 2:
        return False
    settled = view.force_N[block + int(below[0]) :]
    if settled.size < FLAT_BLOCKS or slips(settled, view.noise_N, most=1):
        return False
    # A release dies away smoothly: whatever its curve, neighbouring blocks differ by noise only.
    quiet_N = _quiet_N(prepared, block)
    return noise_std(settled) <= quiet_N and (
        top_N - sliding.onset_N > FAR_DOWN * (top_N - base_N) or roughness_N(settled) <= quiet_N
    )


def unresolved_detail(prepared: Prepared, block: int, sliding: Sliding, settings: PickSettings) -> str:
    """Return why the highest force before sliding is no static peak; empty if it is one."""
    force_N = float(prepared.view.force_N[block])
    above_N = force_N - sliding.onset_N
    text = (
        f"the largest force before sliding, {force_N:.4g} N, stands {above_N:.2g} N above the sliding force of "
        f"{sliding.onset_N:.4g} ± {sliding.spread_N:.2g} N"
    )
    if settings.min_step_N is not None and above_N < settings.min_step_N:
        return f"{text}: less than min_step = {settings.min_step_N:.3g} N"
    return "" if _stands_out(prepared, block, sliding, above_N) else f"{text}: no static peak stands out"


def _stands_out(prepared: Prepared, block: int, sliding: Sliding, above_N: float) -> bool:
    """Return whether a break is a static peak, not the highest wiggle of a force that merely levels off."""
    view = prepared.view
    fast_N = fast_drop_N(view.force_N, block)
    slipped = is_slip(view, block)
    if fast_N <= SLIP_SIGMAS * view.noise_N or not (slipped or fast_N > 0.5 * above_N):
        return False
    if above_N > RESOLVED_SIGMAS * sliding.spread_N:
        return True
    # In stick-slip the spread is that of the teeth: they are slips themselves, and the first one counts.
    if not slipped or above_N < 0.1 * fast_N or not 3.0 * view.noise_N < sliding.spread_N < 0.8 * fast_N:
        return False
    falls = slips(view.force_N[sliding.first : sliding.stop], view.noise_N, most=2)
    return len(falls) == 0 or fast_N > 1.5 * falls[0][1] or (len(falls) == 2 and falls[1][1] > 0.3 * fast_N)
