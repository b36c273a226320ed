"""From a trace as read to samples a peak can be picked from: the part wanted, without gaps and spikes."""

from dataclasses import dataclass

import numpy as np

from ropefric.arrays import FloatArray, IntArray
from ropefric.traces.blocks import Glance, glance
from ropefric.traces.breakaway import Breakaway, Status
from ropefric.traces.noise import noise_std, remove_spikes, resolution
from ropefric.traces.saturation import find_stuck
from ropefric.traces.settings import PickSettings
from ropefric.traces.trace import ForceTrace

MIN_SAMPLES = 50
"""Fewer samples cannot show idle, loading, a peak and sliding."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Prepared:
    """Samples to pick from."""

    time_s: FloatArray
    force_N: FloatArray
    noise_N: float
    view: Glance
    bad: IntArray
    notes: tuple[str, ...]
    stuck: IntArray


def prepare(trace: ForceTrace, settings: PickSettings) -> Prepared | None:
    """Return the samples to pick from, or None if there are too few."""
    time_s, force_N = trace.time_s, trace.force_N
    if settings.start_s is not None or settings.stop_s is not None:
        start = 0 if settings.start_s is None else int(np.searchsorted(time_s, settings.start_s, side="left"))
        stop = time_s.size
        if settings.stop_s is not None:
            stop = int(np.searchsorted(time_s, settings.stop_s, side="right"))
        time_s, force_N = time_s[start:stop], force_N[start:stop]
    present = np.isfinite(force_N)
    n_missing = int(force_N.size - np.count_nonzero(present))
    if n_missing:
        time_s, force_N = time_s[present], force_N[present]
    if force_N.size < MIN_SAMPLES:
        return None
    noise_N = noise_std(force_N)
    stuck = _between_limits(find_stuck(force_N, resolution(force_N), noise_N), force_N, trace)
    if len(stuck):
        noise_N = noise_std(np.delete(force_N, np.concatenate([np.arange(*run) for run in stuck])))
    cleaned = remove_spikes(force_N, noise_N)
    notes = [*trace.notes, *(_stuck_note(time_s, force_N, *run) for run in stuck.tolist())]
    if n_missing:
        notes.append(f"{n_missing} of {present.size} samples are missing")
    if cleaned.bad.size:
        places = ", ".join(f"{time_s[i]:.4g} s" for i in cleaned.bad[:3])
        more = ", …" if cleaned.bad.size > 3 else ""
        notes.append(f"{cleaned.bad.size} samples left out as spikes or dropouts (at {places}{more})")
    return Prepared(
        time_s=time_s,
        force_N=cleaned.values,
        noise_N=noise_N,
        view=glance(time_s, cleaned.values),
        bad=cleaned.bad,
        notes=tuple(notes),
        stuck=stuck,
    )


def _between_limits(stuck: IntArray, force_N: FloatArray, trace: ForceTrace) -> IntArray:
    """Return the stuck stretches that are not at a limit of the converter, which is another matter."""
    if trace.saturation is None or not len(stuck):
        return stuck
    limits_N = np.array([np.nanmax(trace.force_N) if trace.saturation.high else np.inf,
                         np.nanmin(trace.force_N) if trace.saturation.low else -np.inf])  # fmt: skip
    return stuck[~np.isin(force_N[stuck[:, 0]], limits_N)]


def _stuck_note(time_s: FloatArray, force_N: FloatArray, start: int, stop: int) -> str:
    return (
        f"the force reads exactly {force_N[start]:.4g} N for {time_s[stop - 1] - time_s[start]:.2g} s "
        f"({stop - start} samples) from {time_s[start]:.4g} s on: the converter or the sensor stuck"
    )


def failed(status: Status, detail: str, prepared: Prepared | None = None) -> Breakaway:
    """Return a result without a force, with the reason."""
    if prepared is None:
        return Breakaway(status=status, detail=detail)
    return Breakaway(status=status, detail=detail, noise_std_N=prepared.noise_N, notes=prepared.notes)


def too_short(trace: ForceTrace, settings: PickSettings) -> Breakaway:
    """Return the result for a recording that `prepare` refused."""
    n = int(np.isfinite(trace.force_N).sum())
    part = " in the part looked at" if settings.start_s is not None or settings.stop_s is not None else ""
    return failed(
        Status.TOO_SHORT,
        f"{trace.force_N.size} samples, {n} of them usable{part}; at least {MIN_SAMPLES} are needed",
    )
