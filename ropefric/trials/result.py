"""The result of an extraction: trials, their conditions after a rule, problems; and their three CSV files."""

import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from math import isfinite, nan
from pathlib import Path, PurePath
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import DataError, Problem
from ropefric.files.folder import Folder, as_folder
from ropefric.files.plain_text import csv_cell, csv_text, parquet_bytes, significant
from ropefric.friction.condition import condition_groups
from ropefric.shown import Shown
from ropefric.traces.breakaway import Breakaway, Status
from ropefric.traces.calibration import Calibration
from ropefric.traces.trace import ForceTrace
from ropefric.traces.zero import MATTERS
from ropefric.trials import numbers
from ropefric.trials.campaign_model import Campaign, TrialRow
from ropefric.trials.cells import QUANTITIES, stem_of
from ropefric.trials.outliers import scaled, summarise

OUTCOMES = ("kept", "rejected", "excluded", "without a force")
"""Fates of a trial, each has one of these: it counts; the rule rejected it; it was excluded, by hand or because
its F_A is not above its F_B; or its recording gave no usable force."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Outline:
    """A recording reduced for drawing: no peak is lost, because each bin keeps its smallest and largest sample."""

    time_s: FloatArray
    low_N: FloatArray
    high_N: FloatArray
    smoothed_N: FloatArray


BINS, DIGITS = 300, 6
"""Of an outline, and of its numbers."""


def draw_outline(trace: ForceTrace) -> Outline | None:
    """Return the min-max envelope and the means of about 300 bins; None where no sample is there.

    Numbers are rounded to six digits: no eye sees more.
    """
    present = np.isfinite(trace.force_N)
    time_s, force_N = trace.time_s[present], trace.force_N[present]
    if force_N.size == 0:
        return None
    n_bins = min(BINS, force_N.size)
    starts = np.arange(n_bins) * force_N.size // n_bins
    counts = np.diff(np.append(starts, force_N.size))
    return Outline(
        time_s=_to_digits(0.5 * (time_s[starts] + time_s[starts + counts - 1])),
        low_N=_to_digits(np.minimum.reduceat(force_N, starts)),
        high_N=_to_digits(np.maximum.reduceat(force_N, starts)),
        smoothed_N=_to_digits(np.add.reduceat(force_N, starts) / counts),
    )


def _to_digits(values: FloatArray) -> FloatArray:
    largest = float(np.abs(values).max())
    if largest == 0.0:
        return values + 0.0  # no negative zeros
    return np.round(values, DIGITS - 1 - int(np.floor(np.log10(largest)))) + 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialResult(TrialRow, Shown):
    """One trial: its condition, what was picked, and whether it counts."""

    _said = (
        *("trial", "status=breakaway.status", "outcome", "peak_N ± peak_std_N"),
        *("wheel_radius_m", "wrap_angle_rad", "end_tension_N"),
    )

    end_tension_N: float
    end_tension_std_N: float = nan
    peak_N: float = nan
    peak_std_N: float = nan
    cell_std_N: float = nan
    wheel_radius_std_m: float = 0.0
    rope_radius_std_m: float = 0.0
    wrap_std_rad: float = 0.0
    end_tension_set_N: float = nan
    end_tension_set_std_N: float = 0.0
    kinetic_mean_std_N: float = nan
    breakaway: Breakaway
    kept: bool = False
    excluded: str = ""
    decision: str = ""
    rejected_by: str = ""
    measures_slack: bool = False
    dwell_s: float = nan
    tare_N: float = nan
    saturated_samples: int = 0
    sha256: str = ""
    calibration: Calibration | None = None
    outline: Outline | None = None
    problems: tuple[Problem, ...] = field(default=())

    @property
    def measured_N(self) -> float:
        """Return the force the sensor measured [N]: the break-away force, or the plateau."""
        return self.breakaway.peak_N

    @property
    def usable(self) -> bool:
        """Return whether the trial gave a force and nobody set it aside by hand."""
        return self.breakaway.status is Status.OK and not self.excluded

    @property
    def outcome(self) -> str:
        """Return which of `OUTCOMES` the trial has."""
        if self.usable:
            return "rejected" if self.rejected_by else "kept"
        return "excluded" if self.excluded else "without a force"

    @property
    def known_N(self) -> float:
        """Return the force that was set, the same for repeats [N]: F_B, or F_A where the slack side is measured."""
        known_N = self.peak_N if self.measures_slack else self.end_tension_N
        return known_N if math.isnan(self.end_tension_set_N) else self.end_tension_set_N

    @property
    def mu(self) -> float:
        """Return the apparent coefficient ln(F_A/F_B)/φ [-]."""
        return self._mu(self.peak_N)

    @property
    def mu_kinetic(self) -> float:
        """Return the apparent coefficient of sliding, ln(F_k/F_B)/φ [-]."""
        return nan if self.measures_slack else self._mu(self.breakaway.kinetic_N)

    def _mu(self, lift_N: float) -> float:
        good = lift_N > 0.0 and self.end_tension_N > 0.0
        return math.log(lift_N / self.end_tension_N) / self.wrap_angle_rad if good else nan

    @property
    def mu_std(self) -> float:
        """Return the standard uncertainty of `mu` by the two forces [-]."""
        relative = self.peak_std_N / self.peak_N, self.end_tension_std_N / self.end_tension_N
        return math.hypot(*relative) / self.wrap_angle_rad

    @property
    def why_no_force(self) -> str:
        """Return why the recording gave no usable force, with the forces that it may have been."""
        candidates = numbers.candidates_in_words(self.breakaway)
        return self.breakaway.detail + (f"; candidates: {candidates}" if candidates else "")

    def to_dict(self) -> dict[str, Any]:
        """Return the trial's row; a number that is not there is None."""
        row: dict[str, Any] = {column.name: column.taken(self) for column in numbers.COLUMNS}
        # What a fit would take for a number of the tool's own gets another name.
        taken = {*stems(), *QUANTITIES} if self.own else ()
        row |= {f"given_{name}" if stem_of(name) in taken else name: cell for name, cell in self.own}
        row["sha256"] = self.sha256  # last, and of known length: a table that was cut off shows it
        return {key: _finite_or_none(value) for key, value in row.items()}


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionSummary(Shown):
    """The repeats of one condition, before and after rejection."""

    _said = (
        *("wheel_radius_m", "wrap_angle_rad", "end_tension_N", "n_recorded", "n_kept"),
        *("mean_kept_N", "std_kept_N", "rejected"),
    )

    wheel_radius_m: float
    rope_radius_m: float
    wrap_angle_rad: float
    end_tension_N: float
    lift_force_N: float
    end_tension_measured_N: float
    wheel: str
    n_recorded: int
    n: int
    n_kept: int
    rejected: tuple[str, ...]
    mean_all_N: float
    std_all_N: float
    mean_kept_N: float
    std_kept_N: float
    rule: str
    notes: tuple[str, ...]
    trials: tuple[str, ...]
    of_kept: Mapping[str, tuple[float, float, int]] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Return the condition's row; a number that is not there is None."""
        row = {name: getattr(self, name) for name in self.__slots__ if name not in {"trials", "of_kept"}}
        for name, (mean, std, n) in self.of_kept.items():
            row |= {f"mean_{name}": mean, f"std_{name}": std, f"n_{numbers.column(name).stem}": n}
        row |= {key: list(value) for key, value in row.items() if isinstance(value, tuple)}
        return {key: _finite_or_none(value) for key, value in row.items()}


@dataclass(frozen=True, slots=True, kw_only=True)
class Extraction(Shown):
    """The result of a campaign's recordings.

    Attributes
    ----------
    name : str
        The campaign's.
    trials : tuple of TrialResult
        In the order of the trial list.
    conditions : tuple of ConditionSummary
        By wheel radius, wrap angle, end tension.
    problems : tuple of Problem
        Everything that was wrong or doubtful, in the same order.
    """

    _said = ("name", "trials", "conditions", "problems")
    _framed = "trials"

    name: str
    trials: tuple[TrialResult, ...]
    conditions: tuple[ConditionSummary, ...]
    problems: tuple[Problem, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return `{"counts": {…}, "trials": […], "conditions": […], "problems": […]}`, None for no number."""
        trials = []
        for trial in self.trials:
            calibration, found = trial.calibration, trial.breakaway
            row = trial.to_dict() | {"calibration": None if calibration is None else calibration.to_dict()}
            for name in ("events", "candidates"):
                told = (asdict(event) for event in getattr(found, name))
                row[name] = [{key: _finite_or_none(value) for key, value in event.items()} for event in told]
            trials.append(row)
        return {
            "campaign": self.name,
            "counts": count_trials(self),
            "trials": trials,
            "conditions": [condition.to_dict() for condition in self.conditions],
            "problems": [{"severity": one.severity, **one.to_dict()} for one in self.problems],
        }


def stems() -> frozenset[str]:
    """Return what the columns of a trial's row are called without their units."""
    return frozenset(stem_of(name) for name in (*(column.name for column in numbers.COLUMNS), "sha256"))


NOT_ABOVE = "F_A is not above F_B"
"""Why a trial is set aside that no friction law can explain."""


def summarised(campaign: Campaign, trials: Sequence[TrialResult]) -> Extraction:
    """Return trials as the extraction of their campaign: by condition, with what its rule rejects marked."""
    marked, conditions, doubts = summarise_conditions(trials, campaign.rejection)
    doubts += tuple(_meaning_of_rest(marked)) if campaign.protocol.rest == "unknown" else ()
    problems = (*campaign.warnings, *(problem for trial in marked for problem in trial.problems), *doubts)
    return Extraction(name=campaign.name, trials=marked, conditions=conditions, problems=problems)


def set_aside_impossible(extraction: Extraction, campaign: Campaign) -> Extraction:
    """Return the extraction without kept trials whose tight side does not pull harder than the slack side.

    Such a trial has exchanged sides, units or cells; a fit refuses it. It stays in the tables with the reason, and
    the means of its condition are formed without it.
    """
    impossible = [trial.usable and trial.peak_N <= trial.end_tension_N for trial in extraction.trials]
    if not any(impossible):
        return extraction
    marked = [
        replace(trial, kept=False, excluded=NOT_ABOVE) if wrong else trial
        for trial, wrong in zip(extraction.trials, impossible, strict=True)
    ]
    return summarised(campaign, marked)


def summarise_conditions(
    trials: Sequence[TrialResult], rule: str
) -> tuple[tuple[TrialResult, ...], tuple[ConditionSummary, ...], tuple[Problem, ...]]:
    """Return the trials with the rejected ones marked, a summary per condition, and warnings.

    A condition is a wheel radius, rope radius, wrap angle and known tension, grouped by
    `condition_groups`. The rule runs once over the measured forces of the usable trials of a condition; nothing is
    deleted.
    """
    keys = [
        (one.wheel_radius_m, one.rope_radius_m, one.wrap_angle_rad, np.nan_to_num(one.known_N).item())
        for one in trials
    ]
    groups: dict[int, list[int]] = {}
    for place, group in enumerate(condition_groups(*zip(*keys, strict=True)).tolist() if keys else ()):
        groups.setdefault(group, []).append(place)
    in_order = sorted(groups.values(), key=lambda places: keys[places[0]])
    found = [_summarise([trials[place] for place in places], rule) for places in in_order]
    rejected = {name for summary, _ in found for name in summary.rejected}
    marked = (replace(one, kept=False, rejected_by=rule) if one.trial in rejected else one for one in trials)
    doubts = (problem for _, problems in found for problem in problems)
    return tuple(marked), tuple(summary for summary, _ in found), tuple(doubts)


def _summarise(trials: Sequence[TrialResult], rule: str) -> tuple[ConditionSummary, Iterator[Problem]]:
    """Return the summary of the trials of one condition, and warnings."""
    first, usable = trials[0], [trial for trial in trials if trial.usable]
    series = summarise([trial.breakaway.peak_N for trial in usable], rule)
    rejected = tuple(usable[place].trial for place in series.rejected)
    measured = [one for one in usable if not math.isnan(one.end_tension_set_N)]  # not only hung
    known_N, mean_N = first.known_N, series.mean_kept
    end_N, lift_N = (mean_N, known_N) if first.measures_slack else (known_N, mean_N)
    summary = ConditionSummary(
        wheel_radius_m=first.wheel_radius_m,
        rope_radius_m=first.rope_radius_m,
        wrap_angle_rad=first.wrap_angle_rad,
        end_tension_N=end_N,
        lift_force_N=lift_N,
        end_tension_measured_N=_mean([one.end_tension_N for one in measured]),
        wheel=_NAME_SEPARATOR.join(filter(None, dict.fromkeys(one.wheel for one in trials))),
        n_recorded=len(trials),
        n=series.n,
        n_kept=series.n_kept,
        rejected=rejected,
        mean_all_N=series.mean_all,
        std_all_N=series.std_all,
        mean_kept_N=mean_N,
        std_kept_N=series.std_kept,
        rule=rule,
        notes=(*series.warnings, *series.notes),
        trials=tuple(trial.trial for trial in trials),
        of_kept=_of_kept([trial for trial in usable if trial.trial not in rejected]),
    )
    problems = (*series.problems, *_not_as_hung(measured), *_implausible(usable))
    return summary, (replace(one, message=f"{_settings_of(first)}: {one.message}") for one in problems)


def _settings_of(trial: TrialResult) -> str:
    """Return the condition of a trial in words."""
    force = "F_A" if trial.measures_slack else "F_B"
    size, wrap_deg = f"R_w = {1000 * trial.wheel_radius_m:.4g} mm", np.degrees(trial.wrap_angle_rad)
    return f"{size}, wrap {wrap_deg:.4g} deg, {force} = {trial.known_N:.4g} N"


FEWEST, LEAST_STD = 6, 0.02
"""Trials that say what a force at rest is; the smallest standard error of the power of F_B."""
MU = 0.01, 3.0
"""Smallest and largest coefficient of ropes and belts, those in a groove included."""
CHECK_UNITS = "check the units of the wrap angle, the end tension and the force"
UNSTATED = 0.02
"""How far a measured end tension may be from what was hung, as a part of it, unless both are stated."""


def _not_as_hung(trials: Sequence[TrialResult]) -> Iterator[Problem]:
    """Yield that the end tension measured is not what hung there, by more than both are uncertain."""
    if not trials or trials[0].measures_slack:
        return
    hung_N, measured_N = trials[0].known_N, _mean([one.end_tension_N for one in trials])
    std_N = math.hypot(
        _mean([one.end_tension_std_N for one in trials]), _mean([one.end_tension_set_std_N for one in trials])
    )
    # Of a hung weight a tolerance says how well it is known, of a channel its cell's sheet.
    is_stated = all(one.end_tension_set_std_N > 0.0 and one.end_cell for one in trials)
    if abs(measured_N - hung_N) > 3.0 * std_N + (0.0 if is_stated else UNSTATED * hung_N):
        message = f"the end tension measured is {measured_N:.4g} N, the weight of the list {hung_N:.4g} N"
        fix = "check the zero and the unit of the channel, the weight, and what the rope itself weighs"
        yield Problem(code="RF243", message=message, key="end_tension", fix=fix, severity="warning")


def _implausible(trials: Sequence[TrialResult]) -> Iterator[Problem]:
    """Yield that no rope has the coefficient of a condition: a unit is wrong, or columns are swapped."""
    mu = _mean([abs(one.mu) for one in trials])
    if not (math.isnan(mu) or MU[0] <= mu <= MU[1]):
        message = f"the apparent coefficient ln(F_A/F_B)/φ is {mu:.2g}, outside {MU[0]:g} to {MU[1]:g}"
        yield Problem(code="RF140", message=message, fix=CHECK_UNITS, severity="warning")


def _meaning_of_rest(trials: Sequence[TrialResult]) -> Iterator[Problem]:
    """Yield whether the forces at rest are errors of the zero, alike for all, or pretensions, in step with F_B."""
    there = [one for one in trials if one.breakaway.rest_N > 0.0 and not one.measures_slack]
    rest_N, tension_N = np.array([(one.breakaway.rest_N, one.known_N) for one in there]).reshape(-1, 2).T
    if len(there) < FEWEST or not any(_rest_matters(one.breakaway) for one in there):
        return
    x, y = np.log(tension_N) - np.log(tension_N).mean(), np.log(rest_N)
    if np.ptp(x) < np.log(2.0):
        return
    slope = float(x @ y / (x @ x))
    left = y - y.mean() - slope * x
    std = max(math.sqrt(float(left @ left) / (len(there) - 2) / float(x @ x)), LEAST_STD)
    is_same, grows = (abs(slope - other) < 3.0 * std for other in (0.0, 1.0))
    if is_same == grows:
        return
    seen = f"the rope at rest reads {rest_N.min():.3g} to {rest_N.max():.3g} N in {len(there)} trials"
    how = f"{seen} and follows F_B^{slope:.2f} (standard error {std:.2f})"
    said = (
        "the same for all end tensions: an error of the zero"
        if is_same
        else "as the end tension: a pretension"
    )
    fix = f'set [protocol] rest = "{"zero" if is_same else "pretension"}" in campaign.toml'
    yield Problem(code="RF245", message=f"{how}, {said}", key="rest", fix=fix, severity="warning")


def _rest_matters(found: Breakaway) -> bool:
    """Return whether a force at rest changes F_A by more than may be left open."""
    highest_N = max((one.force_N for one in found.candidates), default=found.peak_N)
    return found.rest_N > MATTERS * highest_N


def _mean(values: Sequence[float]) -> float:
    return math.fsum(values) / len(values) if values else nan


def _of_kept(trials: Sequence[TrialResult]) -> dict[str, tuple[float, float, int]]:
    """Return mean, sample standard deviation and number of what else was measured, of what was at all."""
    found = {}
    for column in numbers.summarised():
        values = np.array([column.taken(trial) for trial in trials], dtype=np.float64)
        series = scaled(values[np.isfinite(values)])
        found[column.name] = (series.mean(), series.std(), series.deviations.size)
    return found


def count_trials(extraction: Extraction) -> dict[str, Any]:
    """Return how many trials have each outcome and each status: the one count that everything else says."""
    outcomes = [trial.outcome for trial in extraction.trials]
    statuses = [trial.breakaway.status for trial in extraction.trials]
    return {
        "n_trials": len(outcomes),
        "n_conditions": len(extraction.conditions),
        "n_ok": statuses.count(Status.OK),
        **{f"n_{name.replace(' a ', '_')}": outcomes.count(name) for name in OUTCOMES},
        "status": {status.value: statuses.count(status) for status in Status if status in statuses},
    }


def alike(trials: Sequence[TrialResult]) -> list[list[TrialResult]]:
    """Return trials without a force in groups that have one reason, but for the file; most in a group first."""
    groups: dict[tuple[str, ...], list[TrialResult]] = {}
    for trial in trials:
        key: tuple[str, ...] = (trial.trial, "")
        if trial.breakaway.status is Status.UNREADABLE and trial.problems:
            problem = trial.problems[-1]
            message = problem.message.replace(PurePath(trial.file).name, "")
            key = (problem.code, message, problem.key, problem.fix)
        groups.setdefault(key, []).append(trial)
    return sorted(groups.values(), key=len, reverse=True)


def problems_by_code(extraction: Extraction, said_of: Iterable[TrialResult]) -> dict[str, list[Problem]]:
    """Return errors and warnings by code, without those that are stated with the trials."""
    said = {problem for trial in said_of for problem in trial.problems}
    found: dict[str, list[Problem]] = {}
    for problem in extraction.problems:
        if problem not in said:
            found.setdefault(problem.code, []).append(problem)
    return found


def no_force(extraction: Extraction, path: Path) -> DataError | None:
    """Return the error that no recording of a campaign gave a force, with their common reason; None where one did."""
    n = len(extraction.trials)
    if any(trial.breakaway.status is Status.OK for trial in extraction.trials):
        return None
    most = next(iter(alike(extraction.trials)), [])
    why = f", {len(most)} of them for one reason: {most[0].breakaway.detail}" if len(most) > 1 else ""
    fix = "problems.csv says why for each; `ropefric inspect FILE` shows what a file holds"
    if why and most[0].problems[-1].fix:
        fix = f"{most[0].problems[-1].fix}; {fix}"
    why = f"none of the {n} recordings gave a usable force{why}"
    return DataError(why, code="RF301", path=path, fix=fix)


def outcome_words(counts: Mapping[str, Any]) -> str:
    """Return in words how many trials of `count_trials` have each outcome; of those that none has, only "kept"."""
    numbers = {name: counts[f"n_{name.replace(' a ', '_')}"] for name in OUTCOMES}
    return ", ".join(f"{n} {name}" for name, n in numbers.items() if n or name == "kept")


def _finite_or_none(value: Any) -> Any:
    return None if isinstance(value, float) and not isfinite(value) else value


_PROBLEM_COLUMNS = ("severity", "code", "path", "line", "key", "message", "fix")
_NAME_SEPARATOR = "; "
_RESIDUE = 1e-12
"""Size of a number in newtons or seconds that should be zero."""


def write_tables(
    extraction: Extraction, folder: Folder | str | os.PathLike[str], *, parquet: bool = False
) -> tuple[Path, ...]:
    """Write trials.csv, conditions.csv and problems.csv, and trials.parquet if it is wanted; return their paths.

    UTF-8, comma, decimal point, one header line with units in the names, empty cells where there is no number;
    what was measured to nine significant digits, so that the same recordings give the same bytes on every machine.
    Files of these names are replaced.
    """
    problems = [asdict(problem) for problem in extraction.problems]
    trials = [
        _rounded(trial.to_dict(), known="peak_N" if trial.measures_slack else "end_tension_N")
        for trial in extraction.trials
    ]
    tables: dict[str, str | bytes] = {
        "trials.csv": _text(trials),
        "conditions.csv": _text([_rounded(condition.to_dict()) for condition in extraction.conditions]),
        "problems.csv": _text(problems, columns=_PROBLEM_COLUMNS),
    }
    if parquet:
        tables["trials.parquet"] = parquet_bytes(trials, key="--parquet")
    return as_folder(folder).write(tables)


def _rounded(row: Mapping[str, Any], *, known: str = "") -> dict[str, Any]:
    """Return a row with what was measured to the digits that mean something; the force that was set is `known`."""
    # What people set stays as it came out of the trial list.
    kept = {known, *(column.name for column in numbers.COLUMNS if column.is_set)}
    return {
        key: significant(value, smallest=_RESIDUE) if isinstance(value, float) and key not in kept else value
        for key, value in row.items()
    }


def _text(rows: Sequence[Mapping[str, Any]], columns: Sequence[str] = ()) -> str:
    heads = columns or list(rows[0] if rows else ())
    cells = (
        [_NAME_SEPARATOR.join(row[h]) if isinstance(row[h], list) else row[h] for h in heads] for row in rows
    )
    return csv_text([heads, *(map(csv_cell, row) for row in cells)])
