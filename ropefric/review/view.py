"""What the page shows: a trial in the list and by itself, its recording as it is drawn, what all trials say."""

from dataclasses import asdict, replace
from functools import partial
from math import isfinite
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import DataError
from ropefric.files.plain_text import GIVEN_DIGITS, rounded_tree
from ropefric.pipeline import CampaignAnswer
from ropefric.traces.breakaway import Status
from ropefric.traces.readers import read_recordings
from ropefric.traces.smoothing import smooth
from ropefric.trials.campaign_model import Campaign, TrialSpec
from ropefric.trials.recording import blocks_of, tared_trace
from ropefric.trials.result import TrialResult

NUMBERS = ("kinetic_N", "kinetic_std_N", "drop_N", "noise_std_N", "window_s", "loading_rate_N_s", "n_slips")
"""Of a break-away, beside the force itself."""
Curves = tuple[FloatArray, FloatArray, FloatArray | None]
"""Time, force and smoothed force of a recording, samples that are missing left out."""

_plain = partial(rounded_tree, digits=GIVEN_DIGITS)


def row_of(trial: TrialResult, condition: str) -> dict[str, Any]:
    """Return what the list of trials shows of one."""
    told = {name: getattr(trial, name) for name in ("file", "outcome", "excluded", "decision", "why", "by")}
    force = {"force_N": trial.measured_N, "std_N": _std_of(trial)}
    known = {name: value if isfinite(value) else None for name, value in force.items()}
    return {**told, "condition": condition, "status": trial.breakaway.status.value, **known}


def facts_of(spec: TrialSpec, result: TrialResult) -> dict[str, Any]:
    """Return what is known of a trial but its samples."""
    found = result.breakaway
    tree = {name: getattr(found, name) for name in (*NUMBERS, "detail", "notes")}
    tree |= {"start_s": spec.start_s, "stop_s": spec.stop_s, "mu": result.mu}
    for name in ("phases", "events", "candidates"):
        tree[name] = [asdict(one) for one in getattr(found, name)]
    tree["advice"] = "" if found.status is Status.OK else found.advice
    tree["problems"] = [f"{one.code}: {one.message}" for one in result.problems]
    return {**_plain(tree), **pick_of(result)}


def pick_of(result: TrialResult) -> dict[str, Any]:
    """Return the force of a trial, its standard uncertainty, and when it was reached."""
    return {"picked": _plain([result.measured_N, _std_of(result), result.breakaway.peak_time_s])}


def _std_of(trial: TrialResult) -> float:
    return trial.end_tension_std_N if trial.measures_slack else trial.peak_std_N


def curves_of(campaign: Campaign, spec: TrialSpec, result: TrialResult) -> Curves:
    """Return a recording as it was picked from: calibrated, tared, and smoothed where that was done."""
    raws = read_recordings(spec.path, campaign.profile, shown_as=spec.file)
    raw = blocks_of(replace(spec, sample=result.sample), raws)[0]
    trace, _, _ = tared_trace(campaign, spec, raw)
    window_s, present = result.breakaway.window_s, np.isfinite(trace.force_N)
    smoothed_N = smooth(trace, window_s).force_N[present] if isfinite(window_s) else None
    return trace.time_s[present], trace.force_N[present], smoothed_N


def decimated(curves: Curves, start_s: float, stop_s: float, columns: int) -> dict[str, Any]:
    """Return time, lowest, highest and smoothed force for each column of a picture that has a sample.

    A column holds all samples in its stretch of time, so no peak is lost; where there are fewer samples than
    two in a column, each stands for itself.
    """
    time_s, force_N, smoothed_N = curves
    if not time_s.size:
        raise DataError("no sample is there", fix="exclude the trial")
    begin_s, end_s = float(time_s[0]), float(time_s[-1])
    start_s = start_s if isfinite(start_s) else begin_s
    stop_s = stop_s if isfinite(stop_s) else end_s
    columns = min(max(int(columns), 10), 5000)
    if not start_s < stop_s:
        stop_s = start_s + 1e-9 * max(1.0, abs(start_s))
    first, last = np.searchsorted(time_s, start_s, "left"), np.searchsorted(time_s, stop_s, "right")
    if last - first <= 2 * columns:
        inside = slice(max(0, int(first) - 1), int(last) + 1)
        drawn = [time_s[inside], force_N[inside], force_N[inside]]
        middle = np.arange(time_s.size)[inside]
    else:
        time, force = time_s[first:last], force_N[first:last]
        column = np.minimum(((time - start_s) * (columns / (stop_s - start_s))).astype(np.int64), columns - 1)
        starts = np.flatnonzero(np.diff(column, prepend=-1))
        counts = np.diff(np.append(starts, column.size))
        low, high = np.minimum.reduceat(force, starts), np.maximum.reduceat(force, starts)
        drawn = [0.5 * (time[starts] + time[starts + counts - 1]), low, high]
        middle = first + starts + counts // 2
    if smoothed_N is not None:
        drawn.append(smoothed_N[middle])
    names = ("time_s", "low_N", "high_N", "smoothed_N")
    tree = {name: _plain(values.tolist()) for name, values in zip(names, drawn, strict=False)}
    return {"start_s": start_s, "stop_s": stop_s, "begin_s": begin_s, "end_s": end_s} | tree


def answer_of(answer: CampaignAnswer) -> dict[str, Any]:
    """Return what all trials say, as few numbers as tell one answer from another."""
    parameters = [[one.name, one.value, one.std] for one in answer.fit.parameters if one.vary]
    lift, found = None, answer.prediction
    if found is not None:
        ends = dict(zip(("low_N", "high_N"), found.interval_N[0].tolist(), strict=True))
        lift = _plain({"force_N": float(found.lift_force_N[0]), **ends, "level": found.level})
    said = {"law": answer.fit.law, "verdict": answer.verdict.word, "reason": answer.verdict.reason}
    return {**said, "parameters": _plain(parameters), "lift": lift}
