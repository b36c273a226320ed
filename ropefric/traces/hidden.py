"""Why a recording may not show its peak: the converter was at its limit, stuck, cut off, or left samples out."""

import numpy as np

from ropefric.arrays import median
from ropefric.traces.breakaway import Status
from ropefric.traces.events import half_climb
from ropefric.traces.noise import runs_of
from ropefric.traces.peak import WIDE_GAP
from ropefric.traces.segments import Prepared
from ropefric.traces.trace import ForceTrace

SATURATED_SAMPLES = 3
"""A run at the converter's limit longer than any spike."""
CLIPPED = 3
"""A force that is cut off stays the same so many times longer than where it is not."""
HIDDEN = 0.3
"""Part of a climb that a gap may hide."""
_LEAST_CLIMB = 30
_LANDING = 5


def hidden(
    trace: ForceTrace, prepared: Prepared, block: int | None, fallen: int
) -> tuple[Status, str] | None:
    """Say why the converter did not show the peak; None if it did, or nothing broke away."""
    if saturated := _saturation_detail(trace, prepared, block, fallen):
        return Status.SATURATED, saturated
    clipped = _clipped_detail(prepared, block, fallen)
    # Noise finer than the converter's steps touches the limit again and again; a force that sticks keeps still once.
    noisy = prepared.blocks.resolution_N < prepared.noise_N
    if clipped and noisy and runs_of(prepared.force_N == prepared.force_N.max()).shape[0] > 1:
        return Status.SATURATED, clipped
    if block is not None and (stuck := _stuck_detail(prepared, block, fallen)):
        return Status.NO_PEAK, stuck
    if block is not None and (unseen := _unseen_detail(prepared, block)):
        return Status.NO_PEAK, unseen
    return (Status.SATURATED, clipped) if clipped else None


def _saturation_detail(trace: ForceTrace, prepared: Prepared, block: int | None, fallen: int) -> str:
    """Return where the converter sat at its ceiling up to the break; empty where it did not."""
    if trace.saturation is None:
        return ""
    begin_s, end_s = prepared.time_s[0], prepared.time_s[-1]
    if block is not None and (last := max(block + 2, fallen)) < prepared.blocks.time_s.size:
        end_s = prepared.blocks.time_s[last]
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


def _clipped_detail(prepared: Prepared, block: int | None, fallen: int) -> str:
    """Return where a force in newtons is cut off: it stays exactly at its largest, far longer than anywhere else."""
    force_N = prepared.force_N
    stop = (
        force_N.size
        if block is None
        else prepared.blocks.last_sample(max(block + 2, fallen), force_N.size) + 1
    )
    top_N = float(force_N[:stop].max())
    at_top = runs_of(force_N[:stop] == top_N)
    longest = int((at_top[:, 1] - at_top[:, 0]).max())
    if longest <= SATURATED_SAMPLES or top_N < float(force_N.max()):
        return ""
    high = force_N[:stop] > 0.5 * (top_N + float(force_N[:stop].min()))
    same = runs_of((np.diff(force_N[:stop], append=np.inf) == 0.0) & high & (force_N[:stop] < top_N))
    usual = int((same[:, 1] - same[:, 0]).max(initial=0)) + 1
    if longest < CLIPPED * usual:
        return ""
    return (
        f"the force stays at exactly {top_N:.4g} N for {longest} samples, {usual} elsewhere: it is cut off there, and "
        f"the peak is at least {top_N:.4g} N"
    )


def _stuck_detail(prepared: Prepared, block: int, fallen: int) -> str:
    """Return where the converter stuck between half the climb to a break and the fall after it; empty if nowhere.

    What the force did meanwhile nobody knows: the peak may lie in the stretch, and what is found be a later tooth.
    """
    blocks, n = prepared.blocks, prepared.force_N.size
    begin = blocks.first_sample(half_climb(blocks.force_N, 0, block))
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


def _unseen_detail(prepared: Prepared, block: int) -> str:
    """Return where a gap in the samples hides much of the upper half of the climb to a break; empty if nowhere."""
    blocks, time_s, force_N = prepared.blocks, prepared.time_s, prepared.force_N
    begin = max(0, blocks.first_sample(half_climb(blocks.force_N, 0, block)) - 1)
    end = blocks.last_sample(block, force_N.size)
    gaps_s, rises_N = np.diff(time_s[begin : end + 1]), np.diff(force_N[begin : end + 1])
    height_N = float(force_N[begin : end + 1].max()) - float(force_N[: end + 1].min())
    hidden = np.flatnonzero((gaps_s > WIDE_GAP * median(np.diff(time_s))) & (rises_N > HIDDEN * height_N))
    if not hidden.size:
        return ""
    k = int(hidden[-1])
    return (
        f"the force rises by {rises_N[k]:.3g} N within a gap of {1000 * gaps_s[k]:.3g} ms in the samples from "
        f"{time_s[begin + k]:.4g} s on: it may have been higher in it"
    )


def _climbed_on(prepared: Prepared, start: int, stop: int) -> bool:
    """Return whether the force stands after a stretch where the climb before it leads to: no peak lies within."""
    force_N, lasted = prepared.force_N, stop - start
    before = force_N[max(0, start - max(lasted, _LEAST_CLIMB)) : start]
    after = force_N[stop : stop + _LANDING]
    if before.size < _LEAST_CLIMB or not after.size:
        return False
    rise_N = lasted * float(np.polyfit(np.arange(before.size), before, 1)[0])
    return float(after.mean() - force_N[start]) >= 0.5 * rise_N - 2.0 * prepared.noise_N
