"""One recording file -> the results of the trials it holds."""

import math
from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from dataclasses import fields, replace
from math import nan
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray, IntArray
from ropefric.errors import DataError, Problem, RopefricError
from ropefric.files.disk import FileChangedError, InputFile, open_file
from ropefric.registry import did_you_mean
from ropefric.traces.assemble import assemble_trace
from ropefric.traces.breakaway import Breakaway, PickSettings, Status
from ropefric.traces.calibration import (
    Calibration,
    Saturation,
    cell_std_N,
    end_tension_std_N,
    force_std_N,
    tare_from_interval,
)
from ropefric.traces.noise import MAX_SPIKE_SAMPLES, noise_std
from ropefric.traces.protocols import PROTOCOLS, pick_at
from ropefric.traces.readers import read_recordings
from ropefric.traces.readers.profile import RawRecording
from ropefric.traces.segments import MIN_SAMPLES
from ropefric.traces.trace import ForceTrace
from ropefric.trials.campaign_model import Campaign, TrialRow, TrialSpec
from ropefric.trials.result import Outline, TrialResult

STATUS_CODES = {
    Status.DOUBTFUL: "RF234",
    Status.SATURATED: "RF230",
    Status.NO_BREAKAWAY: "RF231",
    Status.NO_PEAK: "RF232",
    Status.TOO_SHORT: "RF233",
}
RATE_TOLERANCE = 0.01
LARGEST_N = 1e12
"""More than was ever pulled: such a number is damage, and its square may be none at all."""
PAIR_TOLERANCE = 0.02
"""How far the weight that a pair of raising and lowering gives may be from the one that was hung."""
STATED_SHARE = 0.01
"""Standard uncertainty of a force that a person states, as a fraction of it, where none is stated with it."""
NO_END = "no end tension is known at the break-away; write it into the list of trials"
SLACK_SAMPLES = 20
"""Samples before the break-away, at least, that tell the slack tension at it."""
FALLS = 5.0
"""A force that falls this many times as far as it rises only goes down [-]."""
BINS = 300
DIGITS = 6


def extract_recording(
    campaign: Campaign, specs: Sequence[TrialSpec], *, file: InputFile | None = None
) -> tuple[tuple[TrialResult, ...], ...]:
    """Return the results of all trials that one file holds, row by row; a bad file gives results, not an exception."""
    first, sha256 = specs[0], ""
    try:
        with open_file(first.path, shown=first.file) if file is None else nullcontext(file) as opened:
            sha256 = opened.sha256
            raws = read_recordings(first.path, campaign.profile, shown_as=first.file, file=opened)
    except FileChangedError:
        raise
    except RopefricError as error:
        return unreadable(campaign, specs, error, sha256=sha256)
    return tuple(tuple(_extract_row(campaign, spec, raws, sha256)) for spec in specs)


def unreadable(
    campaign: Campaign, specs: Sequence[TrialSpec], error: RopefricError, *, sha256: str = ""
) -> tuple[tuple[TrialResult, ...], ...]:
    """Return the results of all rows of a file that cannot be read, for the reason the error gives."""
    return tuple((_unreadable(campaign, spec, error, sha256=sha256),) for spec in specs)


def blocks_of(spec: TrialSpec, raws: Sequence[RawRecording]) -> Sequence[RawRecording]:
    """Return the recordings of a file that a row of the trial list names."""
    if spec.sample == "*" or (not spec.sample and len(raws) == 1):
        return raws
    names = [raw.sample for raw in raws]
    if spec.sample in names:
        return [raws[names.index(spec.sample)]]
    message, fix = f"the file has no recording '{spec.sample}'", did_you_mean(spec.sample, names)
    if not spec.sample:
        message = f"the file holds {len(raws)} recordings side by side"
        fix = f"name one in the column 'sample', for example '{names[0]}', or write '*' for all"
    raise DataError(message, code="RF123", path=spec.file, key="sample", fix=fix)


def _extract_row(
    campaign: Campaign, spec: TrialSpec, raws: Sequence[RawRecording], sha256: str
) -> Iterator[TrialResult]:
    try:
        chosen = blocks_of(spec, raws)
    except DataError as error:
        yield _unreadable(campaign, spec, error, sha256=sha256)
        return
    for raw in chosen:
        name = spec.trial if len(chosen) == 1 else f"{spec.trial}#{raw.sample}"
        named = replace(spec, trial=name, sample=raw.sample)
        try:
            yield from _extract_raw(campaign, named, raw, sha256)
        except RopefricError as error:
            yield _unreadable(campaign, named, error, sha256=sha256)


def _extract_raw(
    campaign: Campaign, spec: TrialSpec, raw: RawRecording, sha256: str
) -> Sequence[TrialResult]:
    asked = {key: getattr(campaign.protocol, key) for key in ("min_step_N", "ending", "side", "rest")}
    asked |= {"window_s": campaign.smoothing.window_s, "peak": campaign.smoothing.peak}
    settings = PickSettings(start_s=spec.start_s, stop_s=spec.stop_s, **asked)
    trace, tare_N, problems = tared_trace(campaign, spec, raw)
    found = PROTOCOLS[campaign.protocol.name].pick(trace, settings)
    if spec.pick_s is not None:
        found = (_beside(pick_at(trace, replace(settings, pick_s=spec.pick_s)), found[0]),)
    elif spec.peak_N is not None:
        found = (_beside(_given(spec), found[0]),)
    found = tuple(_with_end_tension(trace, one, calibrations(campaign, spec)[1]) for one in found)
    common: dict[str, Any] = {"sha256": sha256, "outline": draw_outline(trace), "tare_N": tare_N}
    n_high = trace.saturation.n_high if trace.saturation is not None else 0
    wanted_Hz, found_Hz = campaign.sampling_rate_Hz, trace.sampling_rate_Hz
    if wanted_Hz is not None and found_Hz and abs(found_Hz / wanted_Hz - 1) > RATE_TOLERANCE:
        message = f"the time stamps say {found_Hz:.6g} Hz, the campaign {wanted_Hz:.6g} Hz"
        fix = "correct the unit of the time column or the rate; the time stamps were used"
        problems += (_warning(spec, "RF203", message, fix, "[sampling] rate"),)
    results = []
    for number, one in enumerate(found, start=1):
        many = campaign.protocol.name in {"stick-slip", "held"}
        named = replace(spec, trial=f"{spec.trial}#{number}") if many else spec
        if one.status is Status.OK and not one.peak_N > 0:
            message = f"the force at break-away reads {one.peak_N:.4g} N: a rope cannot push"
            fix = 'check the zero of the cell ([tare]) and the sign of the force ([import.derived] force = "-...")'
            refusal = DataError(message, code="RF240", path=spec.file, fix=fix)
            results.append(_unreadable(campaign, named, refusal, problems, **common))
        else:
            if one.status is not Status.OK:
                message = f"{named.trial}: {one.status.value}: {one.detail}"
                problems += (_warning(named, STATUS_CODES[one.status], message, one.advice),)
            common |= {"calibration": trace.calibration, "saturated_samples": n_high}
            results.append(_result(campaign, named, one, problems, **common))
        problems = ()  # those of the recording are told once
    return results


def _with_end_tension(trace: ForceTrace, found: Breakaway, calibration: Calibration | None) -> Breakaway:
    """Return a break-away with the measured slack tension at its time: a line through the samples just before it.

    With the slip the slack side changes too, so what follows does not count.
    """
    if trace.end_tension_N is None or found.status is not Status.OK or not math.isnan(found.end_tension_N):
        return found
    time_s, peak_s = trace.time_s, found.peak_time_s
    stop = int(np.searchsorted(time_s, peak_s, side="right")) if math.isfinite(peak_s) else 0
    first = min(stop - SLACK_SAMPLES, int(np.searchsorted(time_s, peak_s - found.window_s)))
    x_s, y_N = time_s[max(first, 0) : stop] - peak_s, trace.end_tension_N[max(first, 0) : stop]
    x_s, y_N = x_s[np.isfinite(y_N)], y_N[np.isfinite(y_N)]
    if x_s.size < 3:
        if not math.isfinite(peak_s):
            return found  # stated by a person, without a time: the end tension of the list
        raise _slack_error(trace, f"no end tension was measured before the break-away at {peak_s:.6g} s")
    slope, value_N = np.polyfit(x_s, y_N, 1).tolist()
    scatter_N = math.sqrt(float(((y_N - value_N - slope * x_s) ** 2).sum()) / (x_s.size - 2))
    middle_s = float(x_s.mean())
    share = math.sqrt(1.0 / x_s.size + middle_s**2 / float(((x_s - middle_s) ** 2).sum()))
    if value_N <= 0.0:
        raise _slack_error(trace, f"the end tension at break-away reads {value_N:.4g} N: a rope cannot push")
    std_N = force_std_N(value_N, calibration, picking_std_N=scatter_N * share)
    return replace(found, end_tension_N=value_N, end_tension_std_N=std_N)


def _slack_error(trace: ForceTrace, message: str) -> DataError:
    fix = "check the channel end_tension, its unit and its zero"
    return DataError(message, code="RF242", path=trace.source, key="end_tension", fix=fix)


def _given(spec: TrialSpec) -> Breakaway:
    """Return the break-away force that a person states."""
    peak_N, std_N, notes = nan if spec.peak_N is None else spec.peak_N, spec.peak_std_N, tuple[str, ...]()
    if std_N is None:
        std_N = STATED_SHARE * peak_N
        notes = (f"no peak_std_N is given: taken as {STATED_SHARE:.0%} of peak_N",)
    return Breakaway(status=Status.OK, peak_N=peak_N, peak_std_N=std_N, notes=notes)


def _beside(chosen: Breakaway, found: Breakaway) -> Breakaway:
    """Return what a person decided, with what the picker would have said of it."""
    says = f"{found.peak_N:.6g} N at {found.peak_time_s:.6g} s" if found.status is Status.OK else found.detail
    return replace(chosen, notes=(*chosen.notes, f"without the decision: {found.status.value}, {says}"))


def _result(
    campaign: Campaign, spec: TrialSpec, breakaway: Breakaway, problems: tuple[Problem, ...], **more: Any
) -> TrialResult:
    measures_slack, is_ok = campaign.protocol.needs_lift_force, breakaway.status is Status.OK
    known_N = spec.lift_force_N if measures_slack else spec.end_tension_N
    known, set_N = (nan, nan), nan
    if known_N is not None:
        known = (known_N, end_tension_std_N(known_N, campaign.weights_tolerance))
    if not math.isnan(breakaway.end_tension_N):
        known, set_N = (breakaway.end_tension_N, breakaway.end_tension_std_N), known[0]
    calibration, measured = more.get("calibration"), (nan, nan)
    if is_ok:
        std_N = force_std_N(breakaway.peak_N, calibration, picking_std_N=breakaway.peak_std_N)
        if campaign.protocol.name == "two-way":  # half of each force's share, see `traces.protocols`
            top_N, low_N = breakaway.peak_N, breakaway.trough_N
            up_N, down_N = force_std_N(top_N, calibration), force_std_N(low_N, calibration)
            std_N = math.hypot(breakaway.peak_std_N, 0.5 * up_N, 0.5 * (top_N / low_N) * down_N)
        measured = (breakaway.peak_N, std_N)
    (peak_N, peak_std_N), (end_N, end_std_N) = (known, measured) if measures_slack else (measured, known)
    hung_N, apart_N = known[0] if math.isnan(set_N) else set_N, 0.0
    if campaign.protocol.name == "two-way" and is_ok:
        apart_N = abs(end_N - hung_N) - 3.0 * end_N * peak_std_N / peak_N
    if apart_N > PAIR_TOLERANCE * hung_N:
        message = f"the geometric mean of raising and lowering is {end_N:.4g} N, the weight of the list {hung_N:.4g} N"
        fix = "check the zero of the cell, the weight, and what the rope itself weighs"
        problems += (_warning(spec, "RF243", message, fix, "end_tension"),)
    wheel, rope = campaign.wheels.get(spec.wheel), campaign.rope
    # Noise averages out; wander beyond it counts whole, for nobody knows how slow it is, but with every event of
    # stick-slip it begins anew.
    wander_N = math.sqrt(max(breakaway.kinetic_std_N**2 - breakaway.noise_std_N**2, 0.0))
    kinetic_N = wander_N / math.sqrt(max(breakaway.n_slips - 1, 1))
    excluded = spec.exclude or (NO_END if is_ok and math.isnan(end_N) else "")
    if peak_N <= end_N:
        message = f"the tight side ({peak_N:.4g} N) does not pull harder than the slack side ({end_N:.4g} N)"
        fix = "check whether the sides, the units or the sign of the force are swapped"
        problems += (_warning(spec, "RF240", message, fix, "end_tension"),)
    return TrialResult(
        **{item.name: getattr(spec, item.name) for item in fields(TrialRow)},
        end_tension_N=end_N,
        end_tension_std_N=end_std_N,
        peak_N=peak_N,
        peak_std_N=peak_std_N,
        wheel_radius_std_m=wheel.radius_std_m if wheel else 0.0,
        rope_radius_std_m=rope.radius_std_m if rope.radius_m == spec.rope_radius_m else 0.0,
        wrap_std_rad=campaign.protocol.wrap_tolerance_rad / math.sqrt(3.0),
        cell_std_N=cell_std_N(breakaway.peak_N, calibration) if is_ok else nan,
        end_tension_set_N=set_N,
        kinetic_mean_std_N=force_std_N(breakaway.kinetic_N, calibration, picking_std_N=kinetic_N),
        breakaway=breakaway,
        kept=is_ok and not excluded,
        excluded=excluded,
        decision=spec.decision,
        measures_slack=measures_slack,
        dwell_s=nan if spec.dwell_s is None else spec.dwell_s,
        problems=problems,
        **more,
    )


def _warning(spec: TrialSpec, code: str, message: str, fix: str, key: str = "") -> Problem:
    return Problem(code=code, message=message, path=spec.file, key=key, fix=fix, severity="warning")


def _unreadable(
    campaign: Campaign, spec: TrialSpec, error: RopefricError, problems: tuple[Problem, ...] = (), **more: Any
) -> TrialResult:
    problem = error.problem
    detail = f"{problem.message} ({problem.where})" if problem.where else problem.message
    breakaway, of_error = Breakaway(status=Status.UNREADABLE, detail=detail), error.problems
    if spec.peak_N is not None:  # a stated force needs no recording
        breakaway = _beside(_given(spec), breakaway)
        of_error = tuple(replace(problem, severity="warning") for problem in of_error)
    return _result(campaign, spec, breakaway, (*problems, *of_error), **more)


def calibrations(campaign: Campaign, spec: TrialSpec) -> tuple[Calibration | None, Calibration | None]:
    """Return how the counts of both sides become forces; the slack side is never unloaded, so it has no tare."""
    adc = campaign.adc
    of_pull, of_slack = (
        Calibration(cell=campaign.cells[name], adc=adc) if name and adc is not None else None
        for name in (spec.cell, spec.end_cell)
    )
    return of_pull, of_slack


def tared_trace(
    campaign: Campaign, spec: TrialSpec, raw: RawRecording
) -> tuple[ForceTrace, float, tuple[Problem, ...]]:
    """Return a recording calibrated and tared as its campaign says, what was taken off [N], and what is doubtful.

    A force that only goes down was recorded with its sign reversed; it is turned round, which is told.
    """
    trace, tare_N, problems = _tared_trace(campaign, spec, raw)
    if not (lowest_N := _falls_to(trace.force_N)):
        return trace, tare_N, problems
    saturation = trace.saturation
    if saturation is not None:
        saturation = Saturation(high_runs=saturation.low_runs, low_runs=saturation.high_runs)
    message = f"the force only goes down, to {lowest_N:.4g} N: its sign is taken as reversed"
    fix = 'say so with [import.derived] force = "-force", or check the wiring of the cell'
    problems += (_warning(spec, "RF241", message, fix, "force"),)
    return replace(trace, force_N=-trace.force_N, saturation=saturation), tare_N, problems


def _falls_to(force_N: FloatArray) -> float:
    """Return the lowest force of a recording that falls far below zero and never rises; 0 for any other."""
    if force_N.size < MIN_SAMPLES or not np.nanmin(force_N) < -FALLS * max(float(np.nanmax(force_N)), 0.0):
        return 0.0
    present_N = force_N[np.isfinite(force_N)]
    few = max(MAX_SPIKE_SAMPLES + 1, present_N.size // 200)  # no spike makes a pull
    low_N, high_N = np.partition(present_N, (few, -few - 1))[[few, -few - 1]]
    start_N = float(np.median(present_N[: max(few, present_N.size // 50)]))
    fall_N, rise_N = start_N - low_N, high_N - start_N
    is_fall = fall_N > FALLS * rise_N and fall_N > 20.0 * noise_std(present_N)
    return float(low_N) if is_fall and low_N < -FALLS * max(high_N, 0.0) else 0.0


def _tared_trace(
    campaign: Campaign, spec: TrialSpec, raw: RawRecording
) -> tuple[ForceTrace, float, tuple[Problem, ...]]:
    calibration, end_calibration = calibrations(campaign, spec)
    interval_s, problems = campaign.tare_interval_s, list[Problem]()

    def tared(time_s: FloatArray, counts: IntArray, untared: Calibration) -> Calibration:
        if interval_s is None or np.count_nonzero(counts >= 0) < MIN_SAMPLES:
            return untared
        found, doubts = tare_from_interval(time_s, counts, untared, *interval_s)
        problems.extend(replace(doubt, path=spec.file) for doubt in doubts)
        return found

    trace = assemble_trace(
        raw, campaign.profile, calibration=calibration, end_calibration=end_calibration, tared=tared
    )
    too_large = np.abs(trace.force_N) > LARGEST_N
    if too_large.any():
        force_N, time_s = trace.force_N[too_large][0], trace.time_s[too_large][0]
        message = f"{force_N:.4g} N at {time_s:.6g} s is no force that a cell can read"
        fix = 'correct the unit or the cell, or list its text under [import] missing = ["..."]'
        raise DataError(message, code="RF204", path=spec.file, fix=fix)
    if interval_s is None:
        return trace, 0.0, ()
    present = np.isfinite(trace.force_N)
    if np.count_nonzero(present) < MIN_SAMPLES:
        return trace, nan, ()  # picking says that it is too short
    if trace.calibration is not None:
        return trace, trace.calibration.tare_N, tuple(problems)
    start_s, stop_s = interval_s
    inside = (trace.time_s >= start_s) & (trace.time_s <= stop_s) & present
    if not inside.any():
        message = f"no sample lies in the tare interval from {start_s:g} s to {stop_s:g} s"
        fix = "name an idle interval inside the recording, or remove [tare]"
        raise DataError(message, code="RF212", path=spec.file, key="[tare] interval", fix=fix)
    tare_N = float(np.median(trace.force_N[inside]))
    return replace(trace, force_N=trace.force_N - tare_N), tare_N, ()


def draw_outline(trace: ForceTrace) -> Outline | None:
    """Return the min-max envelope and the means of about 300 bins; None where no sample is there.

    Numbers are rounded to six digits: no eye sees more, and a stored outline is a third as long.
    """
    time_s, force_N = trace.time_s, trace.force_N
    present = np.isfinite(force_N)
    if not present.all():
        time_s, force_N = time_s[present], force_N[present]
    if force_N.size == 0:
        return None
    n_bins = min(BINS, force_N.size)
    starts = np.arange(n_bins) * force_N.size // n_bins
    counts = np.diff(np.append(starts, force_N.size))
    return Outline(
        time_s=_rounded(0.5 * (time_s[starts] + time_s[starts + counts - 1])),
        low_N=_rounded(np.minimum.reduceat(force_N, starts)),
        high_N=_rounded(np.maximum.reduceat(force_N, starts)),
        smoothed_N=_rounded(np.add.reduceat(force_N, starts) / counts),
    )


def _rounded(values: FloatArray) -> FloatArray:
    largest = float(np.abs(values).max())
    if largest == 0.0:
        return values + 0.0  # no negative zeros in stored files
    return np.round(values, DIGITS - 1 - int(np.floor(np.log10(largest)))) + 0.0
