"""A campaign's recordings -> trial table: in parallel, and one bad recording ends nothing.

What one recording gives is the second half.
"""

import math
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import closing, nullcontext, suppress
from dataclasses import dataclass, fields, replace
from functools import partial
from itertools import chain
from math import nan
from pathlib import Path
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import DataError, InputError, Problem, RopefricError, known_error
from ropefric.executors import spread
from ropefric.files import disk
from ropefric.files.disk import FileChangedError, InputFile
from ropefric.glossary import counted
from ropefric.registry import did_you_mean
from ropefric.traces.assemble import assemble_trace
from ropefric.traces.breakaway import Breakaway, PickSettings, Status
from ropefric.traces.calibration import OVERLOAD, Calibration, cell_std_N, end_tension_std_N, force_std_N
from ropefric.traces.noise import MAX_SPIKE_SAMPLES, runs_of
from ropefric.traces.protocols import PROTOCOLS, pick_at
from ropefric.traces.readers import READERS, TEXT_FORMATS, find_reader, read_recordings
from ropefric.traces.readers.profile import RawRecording
from ropefric.traces.segments import upright
from ropefric.traces.trace import ForceTrace
from ropefric.trials.campaign_model import Campaign, TrialRow, TrialSpec
from ropefric.trials.result import Extraction, TrialResult, draw_outline, summarised
from ropefric.trials.trial_list import free_name
from ropefric.trials.workers import START_S, Lost, guarded

Results = tuple[tuple[TrialResult, ...], ...]
"""Of a recording's rows, each with one or more."""
Progress = Callable[[int, int, str], None]
_Rows = tuple[TrialSpec, ...]


def extract_campaign(campaign: Campaign, **how: Any) -> Extraction:
    """Return the break-away forces of all recordings of a campaign, and what the rejection rule keeps.

    One bad recording never ends the run: it gives a trial with a status and a problem. Results do not depend on `how`
    they are come by, which is as of `extract_rows`.
    """
    by_row = extract_rows(campaign, **how)
    return summarised(campaign, [trial for _, trial in in_list_order(campaign, by_row)])


ByRow = Mapping[str, tuple[TrialResult, ...]]
"""The results of each row of a trial list, by the row's name."""


def extract_rows(
    campaign: Campaign,
    *,
    jobs: int = 1,
    progress: Progress | None = None,
    executor: Any = None,
    trusted: bool = False,
) -> ByRow:
    """Return what the recording of every row gives by itself.

    Recordings that are `trusted`, since they were read before, are read at once, in this process.
    """
    if jobs < 1:
        raise InputError(f"{jobs} processes cannot work", code="RF110", key="jobs", fix="use 1 or more")
    by_file: dict[Path, list[TrialSpec]] = {}  # so that a wide file is read once
    for spec in campaign.trials:
        by_file.setdefault(spec.path, []).append(spec)
    files = tuple(map(tuple, by_file.values()))
    done: list[Results] = [()] * len(files)
    work = _Work(campaign=campaign.model_copy(update={"trials": (), "warnings": ()}), files=files)
    running: Generator[tuple[int, Results]]
    if trusted:
        running = ((place, work(place)) for place in range(len(files)))
    else:
        _preload(work)
        running = _results(work, jobs, executor)
    with closing(running):  # ends its processes
        for count, (place, results) in enumerate(running, start=1):
            done[place] = results
            if progress is not None:
                found = [trial for row in results for trial in row]
                worst = next((t for t in found if t.breakaway.status != "ok"), found[0])
                progress(count, len(files), f"{worst.trial} {worst.breakaway.status.value}")
    return {
        spec.trial: found
        for rows, of_file in zip(files, done, strict=True)
        for spec, found in zip(rows, of_file, strict=True)
    }


def in_list_order(campaign: Campaign, by_row: ByRow) -> list[tuple[TrialSpec, TrialResult]]:
    """Return each row of the trial list with each of its results, which has a name of its own."""
    taken = set(by_row)
    placed = []
    for row in campaign.trials:
        for result in by_row[row.trial]:
            # A row may be called as the block or tooth of another: "w#2".
            name = row.trial if result.trial == row.trial else free_name(result.trial, taken)
            taken.add(name)
            placed.append((row, result if name == result.trial else replace(result, trial=name)))
    return placed


@dataclass(frozen=True, slots=True, kw_only=True)
class _Work:
    """The data that every process gets once: the campaign without its rows, the files with theirs."""

    campaign: Campaign
    files: tuple[_Rows, ...]

    def __call__(self, place: int) -> Results:
        """Return the results of a file."""
        rows = self.files[place]
        try:
            return disk.use_file(
                rows[0].path,
                lambda file: extract_recording(self.campaign, rows, file=file),
                shown=rows[0].file,
            )
        except MemoryError:
            raise
        except Exception as error:  # noqa: BLE001  (whatever a recording brings about, it ends that recording)
            known = known_error(error, report_with="the recording", path=rows[0].file)
            return unreadable(self.campaign, rows, known)

    def lost(self, place: int, why: Lost) -> Results:
        """Return the results of a file that could not be read to its end."""
        rows = self.files[place]
        error = DataError(why.reason, code="RF101", path=rows[0].file, fix=why.fix)
        sha256 = ""
        with suppress(DataError):
            sha256 = disk.hash_file(rows[0].path)
        return unreadable(self.campaign, rows, error, sha256=sha256)


_PIECE = 16
"""Files that a worker elsewhere is handed at a time."""


def _results(work: _Work, jobs: int, executor: Any = None) -> Generator[tuple[int, Results]]:
    """Yield place and results of each file: read by processes of this one, or where an executor says."""
    if executor is None:
        for place, done in guarded(work, len(work.files), jobs=jobs, limits=work.campaign.limits):
            yield place, work.lost(place, done) if isinstance(done, Lost) else done
        return
    # Elsewhere another folder is the present one.
    files = [tuple(replace(row, path=row.path.absolute()) for row in rows) for rows in work.files]
    starts = range(0, len(files), _PIECE)
    pieces = (replace(work, files=tuple(files[start : start + _PIECE])) for start in starts)
    patience_s = _PIECE * work.campaign.limits.time_s + START_S
    with closing(spread(_all_of, pieces, executor, again=_again, patience_s=patience_s)) as running:
        for start, found in zip(starts, running, strict=True):
            yield from enumerate(found, start)


def _all_of(work: _Work) -> list[Results]:
    """Return the results of all files, read in this process."""
    for rows in work.files:
        rows[0].path.stat()
    return [work(place) for place in range(len(work.files))]


def _again(work: _Work, error: BaseException) -> list[Results]:
    """Return the results of files that another process did not come to the end of: one of them may be to blame."""
    if isinstance(error, FileNotFoundError) and Path(path := str(error.filename)).exists():
        fix = "keep the recordings in a folder that all machines have under the same name"
        raise DataError("a worker does not find this file", code="RF101", path=path, fix=fix) from None
    found = dict(_results(work, jobs=1))
    return [found[place] for place in range(len(found))]


def check_recordings(campaign: Campaign) -> tuple[tuple[str, ...], tuple[Problem, ...]]:
    """Return what was recognised in one recording of every kind, and why such a one cannot be read.

    Recordings are of one kind if their names end alike, in one of the endings that readers know. Where the first cannot
    be read, the last is tried before the kind is given up: a single bad recording ends no campaign.
    """
    kinds: dict[str, list[TrialSpec]] = {}
    endings = [ending for reader in READERS.values() for ending in reader.suffixes]
    for spec in campaign.trials:
        if not spec.exclude:
            name = spec.path.name.lower()
            kinds.setdefault(next(filter(name.endswith, endings), ""), []).append(spec)
    found: list[_Looked] = [((), ())] * len(kinds)
    with closing(guarded(partial(_look, campaign, kinds), len(kinds), limits=campaign.limits)) as running:
        for place, looked in running:
            if isinstance(looked, Lost):
                path = [*kinds.values()][place][0].file
                problem = Problem(code="RF101", message=looked.reason, path=path, fix=looked.fix)
                looked = (), (problem,)  # noqa: PLW2901
            found[place] = looked
    return tuple(chain(*(said for said, _ in found))), tuple(chain(*(problems for _, problems in found)))


_Looked = tuple[tuple[str, ...], tuple[Problem, ...]]


def _look(campaign: Campaign, kinds: Mapping[str, Sequence[TrialSpec]], place: int) -> _Looked:
    ending, specs = [*kinds.items()][place]
    failed: list[Problem] = []
    for spec in (specs[0], specs[-1])[: len(specs)]:
        try:
            raws = blocks_of(spec, read_recordings(spec.path, campaign.profile, shown_as=spec.file))
            trace, problems = tared_trace(campaign, spec, raws[0])
        except RopefricError as error:
            failed += error.problems
            continue
        facts = f"{spec.file}: {counted(trace.force_N.size, 'sample')}, {trace.sampling_rate_Hz:.5g} Hz"
        told = (replace(problem, severity="warning") for problem in failed)
        return ("; ".join([facts, *trace.notes]),), (*told, *problems)
    more = f"; so it is with others of the {len(specs)} that end in {ending!r}" if len(specs) > 1 else ""
    return (), (replace(failed[0], message=f"{failed[0].message}{more}"),)


def _preload(work: _Work) -> None:
    """Load what every process will need once, before they are forked."""
    if work.files:
        with suppress(RopefricError):
            if find_reader(work.files[0][0].path, work.campaign.profile).name in TEXT_FORMATS:
                import pandas  # noqa: ICN001, F401, PLC0415


# --- what one recording gives ---

STATUS_CODES = {
    Status.DOUBTFUL: "RF234",
    Status.SATURATED: "RF230",
    Status.NO_BREAKAWAY: "RF231",
    Status.NO_PEAK: "RF232",
    Status.TOO_SHORT: "RF233",
}
LARGEST_N = 1e12
"""More than was ever pulled: such a number is damage, and its square may be none at all."""
STATED_SHARE = 0.01
"""Standard uncertainty of a force that a person states, as a fraction of it, where none is stated with it."""
NO_END = "no end tension is known at the break-away; write it into the list of trials"
SLACK_SAMPLES = 20
"""Fewest samples before the break-away that give the slack tension at it."""


def extract_recording(
    campaign: Campaign, specs: Sequence[TrialSpec], *, file: InputFile | None = None
) -> tuple[tuple[TrialResult, ...], ...]:
    """Return the results of all trials that one file holds, row by row; a bad file gives results, not an exception."""
    first, sha256 = specs[0], ""
    try:
        with disk.open_file(first.path, shown=first.file) if file is None else nullcontext(file) as opened:
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
    asked = {
        key: getattr(campaign.protocol, key) for key in ("min_step_N", "ending", "side", "rest", "picker")
    }
    window_s = campaign.smoothing.window_s
    settings = PickSettings(window_s=window_s, start_s=spec.start_s, stop_s=spec.stop_s, **asked)
    trace, problems = tared_trace(campaign, spec, raw)
    found = PROTOCOLS[campaign.protocol.name].pick(trace, settings)
    if spec.pick_s is not None:
        found = (_beside(pick_at(trace, replace(settings, pick_s=spec.pick_s)), found[0]),)
    elif spec.peak_N is not None:
        found = (_beside(_given(spec), found[0]),)
    found = tuple(_with_end_tension(trace, one) for one in found)
    common: dict[str, Any] = {"sha256": sha256, "outline": draw_outline(trace), "tare_N": trace.tare_N}
    n_high = trace.saturation.n_high if trace.saturation is not None else 0
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


def _with_end_tension(trace: ForceTrace, found: Breakaway) -> Breakaway:
    """Return a break-away with the measured slack tension at its time: a line through the samples just before it.

    With the slip the slack side changes too, so what follows does not count.
    """
    if trace.end_tension_N is None or found.status is not Status.OK or not math.isnan(found.end_tension_N):
        return found
    time_s, peak_s = trace.time_s, found.peak_time_s
    place: dict[str, Any] = {"code": "RF242", "path": trace.source, "key": "end_tension"}
    place["fix"] = (
        "check the channel end_tension, its unit and its zero; where the weights hung in the tare interval already, "
        'give it tare = "none" or an interval of its own'
    )
    stop = int(np.searchsorted(time_s, peak_s, side="right")) if math.isfinite(peak_s) else 0
    there = np.flatnonzero(np.isfinite(trace.end_tension_N[:stop]))
    window = int(np.count_nonzero(time_s[there] >= peak_s - found.window_s))
    there = there[max(there.size - max(window, SLACK_SAMPLES), 0) :]
    x_s, y_N = time_s[there] - peak_s, trace.end_tension_N[there]
    if x_s.size < 3:
        if not math.isfinite(peak_s):
            return found  # stated by a person, without a time: the end tension of the list
        raise DataError(f"no end tension was measured before the break-away at {peak_s:.6g} s", **place)
    slope, value_N = np.polyfit(x_s, y_N, 1).tolist()
    scatter_N = math.sqrt(float(((y_N - value_N - slope * x_s) ** 2).sum()) / (x_s.size - 2))
    middle_s = float(x_s.mean())
    share = math.sqrt(1.0 / x_s.size + middle_s**2 / float(((x_s - middle_s) ** 2).sum()))
    if value_N <= 3.0 * scatter_N * share:
        why = "a rope cannot push" if value_N <= 0.0 else "no more than its noise"
        raise DataError(f"the end tension at break-away reads {value_N:.4g} N: {why}", **place)
    std_N = force_std_N(value_N, trace.end_calibration, picking_std_N=scatter_N * share)
    return replace(found, end_tension_N=value_N, end_tension_std_N=std_N)


def _given(spec: TrialSpec) -> Breakaway:
    """Return the break-away force that a person states."""
    peak_N, std_N, notes = nan if spec.peak_N is None else spec.peak_N, spec.peak_std_N, tuple[str, ...]()
    if std_N is None:
        std_N = STATED_SHARE * peak_N
        notes = (f"no peak_std_N is given: taken as {STATED_SHARE:.0%} of peak_N",)
    return Breakaway(status=Status.OK, peak_N=peak_N, peak_std_N=std_N, notes=notes)


def _beside(chosen: Breakaway, found: Breakaway) -> Breakaway:
    """Return a person's decision, with the answer of the picker."""
    says = f"{found.peak_N:.6g} N at {found.peak_time_s:.6g} s" if found.status is Status.OK else found.detail
    return replace(chosen, notes=(*chosen.notes, f"without the decision: {found.status.value}, {says}"))


_Stated = tuple[float, float]
"""A force and its standard uncertainty [N]."""


def _known_force(campaign: Campaign, spec: TrialSpec, breakaway: Breakaway) -> tuple[_Stated, _Stated]:
    """Return the force on the side that the pull does not measure, and what it was set to where a sensor read it."""
    known_N = spec.lift_force_N if campaign.protocol.needs_lift_force else spec.end_tension_N
    stated = (nan, nan)
    if known_N is not None:
        stated = (known_N, end_tension_std_N(known_N, campaign.weights_tolerance))
    if math.isnan(breakaway.end_tension_N):
        return stated, (nan, nan)
    return (breakaway.end_tension_N, breakaway.end_tension_std_N), stated


def _measured_force(campaign: Campaign, breakaway: Breakaway, calibration: Calibration | None) -> _Stated:
    """Return the force that was picked, with the uncertainty of picking and of the measuring chain."""
    if breakaway.status is not Status.OK:
        return nan, nan
    top_N = breakaway.peak_N
    if campaign.protocol.name != "two-way":
        return top_N, force_std_N(top_N, calibration, picking_std_N=breakaway.peak_std_N)
    low_N = breakaway.trough_N  # half of each force's share, see `traces.protocols`
    up_N, down_N = force_std_N(top_N, calibration), force_std_N(low_N, calibration)
    return top_N, math.hypot(breakaway.peak_std_N, 0.5 * up_N, 0.5 * (top_N / low_N) * down_N)


def _doubtful_forces(spec: TrialSpec, peak_N: float, end_N: float) -> Iterator[Problem]:
    """Yield what speaks against the two forces of a trial."""
    if peak_N <= end_N:
        message = f"the tight side ({peak_N:.4g} N) does not pull harder than the slack side ({end_N:.4g} N)"
        fix = "check whether the sides, the units or the sign of the force are swapped"
        yield _warning(spec, "RF240", message, fix, "end_tension")


def _kinetic_std_N(found: Breakaway, calibration: Calibration | None) -> float:
    """Return the standard uncertainty of the mean force while sliding.

    Noise averages out. Drift beyond it counts fully, as its rate is unknown; each stick-slip event starts a new
    independent part.
    """
    wander_N = math.sqrt(max(found.kinetic_std_N**2 - found.noise_std_N**2, 0.0))
    wander_N /= math.sqrt(max(found.n_slips - 1, 1))
    return force_std_N(found.kinetic_N, calibration, picking_std_N=wander_N)


def _result(
    campaign: Campaign, spec: TrialSpec, breakaway: Breakaway, problems: tuple[Problem, ...], **more: Any
) -> TrialResult:
    measures_slack, calibration = campaign.protocol.needs_lift_force, more.get("calibration")
    is_ok = breakaway.status is Status.OK
    known, hung = _known_force(campaign, spec, breakaway)
    measured = _measured_force(campaign, breakaway, calibration)
    peak, (end_N, end_std_N) = (known, measured) if measures_slack else (measured, known)
    excluded = spec.exclude or (NO_END if is_ok and math.isnan(end_N) else "")
    wheel, rope = campaign.wheels.get(spec.wheel), campaign.rope
    return TrialResult(
        **{item.name: getattr(spec, item.name) for item in fields(TrialRow)},
        end_tension_N=end_N,
        end_tension_std_N=end_std_N,
        peak_N=peak[0],
        peak_std_N=peak[1],
        wheel_radius_std_m=wheel.radius_std_m if wheel else 0.0,
        rope_radius_std_m=rope.radius_std_m if rope.radius_m == spec.rope_radius_m else 0.0,
        wrap_std_rad=campaign.protocol.wrap_tolerance_rad / math.sqrt(3.0),
        cell_std_N=cell_std_N(breakaway.peak_N, calibration) if is_ok else nan,
        end_tension_set_N=hung[0],
        end_tension_set_std_N=hung[1],
        kinetic_mean_std_N=_kinetic_std_N(breakaway, calibration),
        breakaway=breakaway,
        kept=is_ok and not excluded,
        excluded=excluded,
        decision=spec.decision,
        measures_slack=measures_slack,
        dwell_s=nan if spec.dwell_s is None else spec.dwell_s,
        problems=(*problems, *_doubtful_forces(spec, peak[0], end_N)),
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


def tared_trace(
    campaign: Campaign, spec: TrialSpec, raw: RawRecording
) -> tuple[ForceTrace, tuple[Problem, ...]]:
    """Return a recording, calibrated and tared as its campaign says, and its warnings.

    A force that only goes down was recorded with its sign reversed; it is reversed, with a note.
    """
    of_pull, of_slack = (
        Calibration(cell=campaign.cells[name], adc=campaign.adc) if name else None
        for name in (spec.cell, spec.end_cell)
    )
    trace = assemble_trace(
        raw, campaign.profile, calibration=of_pull, end_calibration=of_slack, tare_s=campaign.tare_interval_s
    )
    too_large = np.abs(trace.force_N) > LARGEST_N
    if too_large.any():
        force_N, time_s = trace.force_N[too_large][0], trace.time_s[too_large][0]
        message = f"{force_N:.4g} N at {time_s:.6g} s is no force that a cell can read"
        fix = 'correct the unit or the cell, or list its text under [import] missing = ["..."]'
        raise DataError(message, code="RF204", path=spec.file, fix=fix)
    for name, values_N, cell in (
        ("force", trace.force_N, spec.cell),
        ("end_tension", trace.end_tension_N, spec.end_cell),
    ):
        if values_N is not None:
            _refuse_overload(campaign, spec, name, values_N, cell)
    trace, said = upright(trace)
    problems = tuple(replace(doubt, path=spec.file) for doubt in trace.doubts)
    if said:
        fix = 'say so with [import.derived] force = "-force", or check the wiring of the cell'
        problems += (_warning(spec, "RF241", said, fix, "force"),)
    return trace, problems


def _refuse_overload(campaign: Campaign, spec: TrialSpec, name: str, values_N: FloatArray, cell: str) -> None:
    """Refuse a force that its cell, or where the list names none the largest of the campaign, cannot have read."""
    named = {cell} if cell else campaign.cells.keys() - {spec.cell, spec.end_cell}
    cells = {name: campaign.cells[name] for name in campaign.cells if name in named}
    if not cells:
        return
    largest = max(cells.values(), key=lambda one: one.full_scale_N)
    runs = runs_of(np.abs(values_N) > OVERLOAD * largest.full_scale_N)
    if np.diff(runs).max(initial=0) > MAX_SPIKE_SAMPLES:
        said = f"{float(np.nanmax(np.abs(values_N))):.4g} N, but the full scale of [cells.{largest.name}]"
        message = f"the {name} comes to {said} is {largest.full_scale_N:.4g} N"
        fix = "correct the unit of the channel, or the full scale"
        raise DataError(message, code="RF204", path=spec.file, key=f"[import.channels] {name}", fix=fix)
