"""One recording file -> the results of the trials it holds."""

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import replace
from math import nan

from ropefric.errors import DataError, Problem, RopefricError
from ropefric.files.read import FileChangedError, InputFile, open_file
from ropefric.registry import did_you_mean
from ropefric.traces.breakaway import Breakaway, Status
from ropefric.traces.budget import end_tension_std_N, force_std_N
from ropefric.traces.calibration import Calibration
from ropefric.traces.protocols import PROTOCOLS
from ropefric.traces.readers import read_recordings
from ropefric.traces.readers.profile import RawRecording
from ropefric.traces.settings import PickSettings
from ropefric.traces.trace import ForceTrace
from ropefric.trials.campaign_model import Campaign
from ropefric.trials.outline import draw_outline
from ropefric.trials.result import TrialResult
from ropefric.trials.tared import tared_trace
from ropefric.trials.trial_spec import TrialSpec

STATUS_CODES = {
    Status.SATURATED: "RF230",
    Status.NO_BREAKAWAY: "RF231",
    Status.NO_PEAK: "RF232",
    Status.TOO_SHORT: "RF233",
}
RATE_TOLERANCE = 0.01


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
    return tuple((_unreadable(campaign, spec, error, sha256),) for spec in specs)


def _extract_row(
    campaign: Campaign, spec: TrialSpec, raws: Sequence[RawRecording], sha256: str
) -> list[TrialResult]:
    try:
        chosen = blocks_of(spec, raws)
    except DataError as error:
        return [_unreadable(campaign, spec, error, sha256)]
    results: list[TrialResult] = []
    for raw in chosen:
        named = spec if len(chosen) == 1 else replace(spec, trial=f"{spec.trial}#{raw.sample}")
        results.extend(_extract_raw(campaign, replace(named, sample=raw.sample), raw, sha256))
    return results


def blocks_of(spec: TrialSpec, raws: Sequence[RawRecording]) -> Sequence[RawRecording]:
    """Return the recordings of a file that a row of the trial list names."""
    if spec.sample == "*":
        return raws
    if not spec.sample and len(raws) == 1:
        return raws
    names = [raw.sample for raw in raws]
    if spec.sample in names:
        return [raws[names.index(spec.sample)]]
    if not spec.sample:
        raise DataError(
            f"the file holds {len(raws)} recordings side by side",
            code="RF123",
            path=spec.file,
            key="sample",
            fix=f"name one in the column 'sample', for example '{names[0]}', or write '*' for all",
        )
    raise DataError(
        f"the file has no recording '{spec.sample}'",
        code="RF123",
        path=spec.file,
        key="sample",
        fix=did_you_mean(spec.sample, names),
    )


def _extract_raw(campaign: Campaign, spec: TrialSpec, raw: RawRecording, sha256: str) -> list[TrialResult]:
    protocol = PROTOCOLS[campaign.protocol.name]
    settings = PickSettings(
        window_s=campaign.smoothing.window_s,
        peak=campaign.smoothing.peak,
        start_s=spec.start_s,
        stop_s=spec.stop_s,
        min_step_N=campaign.protocol.min_step_N,
        ending=campaign.protocol.ending,
        side=campaign.protocol.side,
    )
    try:
        tared = tared_trace(campaign, spec, raw)
        found = protocol.pick(tared.trace, settings)
    except RopefricError as error:
        return [_unreadable(campaign, spec, error, sha256)]
    many = campaign.protocol.name != "breakaway"
    outline = draw_outline(tared.trace)
    problems = (*tared.problems, *_rate_problem(campaign, spec, tared.trace))
    results = []
    for number, breakaway in enumerate(found, start=1):
        named = replace(spec, trial=f"{spec.trial}#{number}") if many else spec
        if breakaway.status is Status.OK and not breakaway.peak_N > 0:
            refused = _unreadable(campaign, named, _not_pulling(named, breakaway), sha256)
            told = (*(problems if number == 1 else ()), *refused.problems)
            results.append(replace(refused, outline=outline, tare_N=tared.tare_N, problems=told))
            continue
        result = _result(campaign, named, breakaway, tared.trace.calibration)
        flagged = _status_problem(named, breakaway)
        saturation = tared.trace.saturation
        results.append(
            replace(
                result,
                sha256=sha256,
                calibration=tared.trace.calibration,
                outline=outline,
                tare_N=tared.tare_N,
                saturated_samples=saturation.n_high if saturation is not None else 0,
                problems=(*(problems if number == 1 else ()), *flagged, *result.problems),
            )
        )
    return results


def _result(
    campaign: Campaign, spec: TrialSpec, breakaway: Breakaway, calibration: Calibration | None
) -> TrialResult:
    measures_slack = campaign.protocol.needs_lift_force
    measured_std_N = nan
    if breakaway.status is Status.OK:
        measured_std_N = force_std_N(breakaway.peak_N, calibration, picking_std_N=breakaway.peak_std_N)
    known_N = spec.lift_force_N if measures_slack else spec.end_tension_N
    known_N = nan if known_N is None else known_N
    known_std_N = end_tension_std_N(known_N, campaign.weights_tolerance)
    measured = (breakaway.peak_N, measured_std_N)
    (peak_N, peak_std_N), (end_N, end_std_N) = (
        ((known_N, known_std_N), measured) if measures_slack else (measured, (known_N, known_std_N))
    )
    problems: tuple[Problem, ...] = ()
    if peak_N <= end_N:
        problems = (
            Problem(
                code="RF240",
                message=f"the tight side ({peak_N:.4g} N) does not pull harder than the slack side ({end_N:.4g} N)",
                path=spec.file,
                key="end_tension",
                fix="check whether the sides, the units or the sign of the force are swapped",
                severity="warning",
            ),
        )
    return TrialResult(
        trial=spec.trial,
        file=spec.file,
        sample=spec.sample,
        wheel_radius_m=spec.wheel_radius_m,
        rope_radius_m=spec.rope_radius_m,
        wrap_angle_rad=spec.wrap_angle_rad,
        end_tension_N=end_N,
        end_tension_std_N=end_std_N,
        peak_N=peak_N,
        peak_std_N=peak_std_N,
        breakaway=breakaway,
        kept=breakaway.status is Status.OK and not spec.exclude,
        excluded=spec.exclude,
        measures_slack=measures_slack,
        cell=spec.cell,
        rope_id=spec.rope_id,
        dwell_s=nan if spec.dwell_s is None else spec.dwell_s,
        note=spec.note,
        own=spec.own,
        problems=problems,
    )


def _not_pulling(spec: TrialSpec, breakaway: Breakaway) -> DataError:
    return DataError(
        f"the force at break-away reads {breakaway.peak_N:.4g} N: a rope cannot push",
        code="RF240",
        path=spec.file,
        fix='check the zero of the cell ([tare]) and the sign of the force ([import.derived] force = "-...")',
    )


def _status_problem(spec: TrialSpec, breakaway: Breakaway) -> tuple[Problem, ...]:
    if breakaway.status is Status.OK:
        return ()
    return (
        Problem(
            code=STATUS_CODES[breakaway.status],
            message=f"{spec.trial}: {breakaway.status.value}: {breakaway.detail}",
            path=spec.file,
            fix=breakaway.advice,
            severity="warning",
        ),
    )


def _rate_problem(campaign: Campaign, spec: TrialSpec, trace: ForceTrace) -> tuple[Problem, ...]:
    wanted_Hz, found_Hz = campaign.sampling_rate_Hz, trace.sampling_rate_Hz
    if wanted_Hz is None or not found_Hz or abs(found_Hz / wanted_Hz - 1) <= RATE_TOLERANCE:
        return ()
    return (
        Problem(
            code="RF203",
            message=f"the time stamps say {found_Hz:.6g} Hz, the campaign {wanted_Hz:.6g} Hz",
            path=spec.file,
            key="[sampling] rate",
            fix="correct the unit of the time column or the rate; the time stamps were used",
            severity="warning",
        ),
    )


def _unreadable(campaign: Campaign, spec: TrialSpec, error: RopefricError, sha256: str) -> TrialResult:
    problem = error.problem
    detail = f"{problem.message} ({problem.where})" if problem.where else problem.message
    result = _result(campaign, spec, Breakaway(status=Status.UNREADABLE, detail=detail), None)
    return replace(result, sha256=sha256, problems=error.problems)
