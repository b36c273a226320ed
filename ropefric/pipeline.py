"""A campaign from recordings to the lift force of a wheel, with its evidence and its inputs.

Recordings to forces, forces to a law, the law to the lift force, written so that others can check it; for a report
budgets, sensitivities and next tests; a manifest by which the result can be made again.
"""

import json
import math
import os
import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from ropefric.errors import DataError, RopefricError
from ropefric.files.disk import hash_file, read_file
from ropefric.files.folder import Folder, OutputFolder, as_folder
from ropefric.files.plain_text import csv_cell, csv_text, json_document, rounded_tree
from ropefric.fitting import budgets, next_tests, resolution
from ropefric.fitting.compare import Choice, Comparison, choose_law, compare_laws
from ropefric.fitting.design import DesignChart, design_chart
from ropefric.fitting.diagnose import Diagnosis, diagnose
from ropefric.fitting.fit import fit_law
from ropefric.fitting.predict import REGRESSORS, Prediction, predict
from ropefric.fitting.result import FitResult, Verdict
from ropefric.fitting.store import fit_text
from ropefric.friction.condition import Conditions, distinct, one_condition
from ropefric.friction.laws import ALL_LAWS, LAWS
from ropefric.plugins import provenance
from ropefric.shown import Shown
from ropefric.trials.campaign_model import Campaign, DesignWheel
from ropefric.trials.extract import extract_campaign
from ropefric.trials.outliers import RULES
from ropefric.trials.result import Extraction, count_trials, no_force, set_aside_impossible, write_tables
from ropefric.trials.table import TrialTable, read_trial_table
from ropefric.uncertainty.budget import LinearBudget, Statement, linear_budget, state_uncertainty

Progress = Callable[[str, int, int], None]
_RANKING = (
    *("law", "status", "counted", "n", "k", "chi2", "aicc"),
    *("delta_aicc", "weight", "bic", "loco_error", "note"),
)
_EXTRACTED = (
    *("trials.csv", "conditions.csv", "problems.csv", "trials.parquet"),
    *(f"figures/Rw*deg_F*.{end}" for end in ("csv", "png", "svg", "pdf")),
)
_FIGURES = (
    *("overview", "mu_facets", "capstan", "fit_over_", "residuals", "ladder"),
    *("tornado", "design_chart", "budget_", "typical_recording", "law", "recordings_"),
)
_ANSWERED = (
    *("comparison.csv", "prediction.json", "uncertainty.json", "next_tests.csv", "manifest.json"),
    *("report.html", "report.pdf", "summary.txt"),
    *(f"figures/{stem}*.{end}" for stem in _FIGURES for end in ("csv", "png", "svg", "pdf")),
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CampaignAnswer:
    """The results of a trial table."""

    table: TrialTable
    comparison: Comparison
    winner: Choice
    diagnosis: Diagnosis
    prediction: Prediction | None
    doubts: tuple[str, ...]

    @property
    def fit(self) -> FitResult:
        """Return the fit of the law that is used."""
        return self.winner.fit

    @property
    def verdict(self) -> Verdict:
        """Return the verdict: on the lift force where there is one, which holds that on the law, else on the law."""
        return self.winner.verdict if self.prediction is None else self.prediction.verdict

    @property
    def forced_law(self) -> str:
        """Return the law that was asked for by its name, "" where the best is used."""
        return self.fit.law if self.winner.forced else ""

    @property
    def fits(self) -> tuple[FitResult, ...]:
        """Return the fits of all laws that have one, best first."""
        return tuple(entry.fit for entry in self.comparison.ranking if entry.fit is not None)

    def to_dict(self) -> dict[str, Any]:
        """Return ranking, fit, prediction and diagnosis as a JSON tree."""
        return {
            **self.comparison.to_dict(),
            "law": self.fit.law,
            "verdict": self.verdict.to_dict(),
            "fit": self.fit.to_dict(),
            "prediction": None if self.prediction is None else self.prediction.to_dict(),
            "diagnosis": self.diagnosis.to_dict(),
            "doubts": list(self.doubts),
        }


def answer_trials(
    table: TrialTable,
    *,
    design: DesignWheel | None = None,
    rope_radius_m: float | None = None,
    law: str = "",
    shared: Mapping[str, str] | None = None,
    progress: Progress | None = None,
) -> CampaignAnswer:
    """Return the law that a trial table supports, with its verdict, and the lift force of a design."""
    laws = [*LAWS, law] if law and law not in LAWS else None
    comparison = compare_laws(table, laws, shared=shared, progress=progress)
    rope_m = float(np.median(table.rope_radius_m[table.used])) if rope_radius_m is None else rope_radius_m
    wheel = prediction = None
    refused: list[str] = []
    try:
        if design is not None:
            settings = (design.wheel_radius_m, rope_m, design.wrap_angle_rad, design.end_tension_N)
            wheel = one_condition(*settings)
        winner = choose_law(comparison, law, wheel)
        if wheel is not None:
            prediction = winner.of(predict(winner.fit, wheel))
    except RopefricError as error:
        refused = [f"no lift force for the design: {error}"]
        winner = choose_law(comparison, law, wheel)
    return CampaignAnswer(
        table=table,
        comparison=comparison,
        winner=winner,
        diagnosis=diagnose(table, comparison),
        prediction=prediction,
        doubts=tuple(dict.fromkeys((*winner.doubts, *winner.fit.advice, *comparison.notes[1:], *refused))),
    )


def answer_campaign(
    campaign: Campaign, table: TrialTable, *, law: str = "", progress: Progress | None = None
) -> CampaignAnswer:
    """Return the law that the trials of a campaign support, and the lift force of its design."""
    asked: dict[str, Any] = {"design": campaign.design, "rope_radius_m": campaign.rope.radius_m}
    shared = {"cell": "cell"} | campaign.uncertainty
    return answer_trials(table, law=law, shared=shared, progress=progress, **asked)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CampaignRun(Shown):
    """A campaign's result.

    Attributes
    ----------
    campaign : Campaign
        What was measured.
    extraction : Extraction
        The forces.
    answer : CampaignAnswer
        What they say.
    written : tuple of Path
        The files, in the order they were written.
    """

    _said = ("name=campaign.name", "law=answer.fit.law", "verdict=answer.verdict.word", "written")
    _framed = "extraction.trials"

    campaign: Campaign
    extraction: Extraction
    answer: CampaignAnswer
    written: tuple[Path, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return counts of the extraction, ranking, fit, prediction and diagnosis as a JSON tree."""
        counts = count_trials(self.extraction)
        return {"campaign": self.campaign.name, "extraction": counts, **self.answer.to_dict()}


def run_campaign(
    campaign: Campaign,
    folder: Folder | str | os.PathLike[str],
    *,
    law: str = "",
    jobs: int = 1,
    executor: Any = None,
    parquet: bool = False,
    extract_progress: Callable[[int, int, str], None] | None = None,
    fit_progress: Progress | None = None,
    on_extracted: Callable[[Extraction], None] | None = None,
) -> CampaignRun:
    """Return the result of a campaign, and write its tables, fits, comparison and prediction into a folder.

    Writes trials.csv, conditions.csv, problems.csv, fits/LAW.json for every law fitted, comparison.csv and
    prediction.json, and trials.parquet if it is wanted; the same campaign gives the same bytes, whatever `jobs` or the
    executor that reads in their stead.
    """
    found = extract_campaign(campaign, jobs=jobs, progress=extract_progress, executor=executor)
    extraction = set_aside_impossible(found, campaign)
    target = as_folder(folder)
    tables = write_tables(extraction, target, parquet=parquet)
    target.publish("tables")
    if on_extracted is not None:
        on_extracted(extraction)
    if (without := no_force(extraction, campaign.path)) is not None:
        raise without
    # From the file, so that every fit names its data, with its hash, and can be made again.
    answer = answer_campaign(campaign, read_trial_table(tables[0]), law=law, progress=fit_progress)
    written = (*tables, *write_answer(answer, target))
    return CampaignRun(campaign=campaign, extraction=extraction, answer=answer, written=written)


def write_answer(answer: CampaignAnswer, folder: Folder | str | os.PathLike[str]) -> tuple[Path, ...]:
    """Write fits/LAW.json for every law, comparison.csv and, if there is one, prediction.json; return their paths."""
    target = as_folder(folder)
    texts = {f"fits/{fit.law}.json": fit_text(fit, target.path / "fits") for fit in answer.fits}
    rows = [entry.to_dict() for entry in answer.comparison.ranking]
    cells = [[csv_cell(row[name]) for name in _RANKING] for row in rows]
    texts["comparison.csv"] = csv_text([_RANKING, *cells])
    if answer.prediction is not None:
        texts["prediction.json"] = json_document(answer.prediction.to_dict())
    return target.write(texts)


def campaign_folder(
    campaign: Campaign, folder: str | os.PathLike[str], *, answers: bool = True, force: bool = False
) -> OutputFolder:
    """Return the folder of a campaign's results, as a context that keeps it from other runs; see `OutputFolder`."""
    names = (*_EXTRACTED, *(_answered() if answers else ()))
    inputs = (
        campaign.path,
        campaign.trial_list,
        campaign.decisions,
        *dict.fromkeys(trial.path for trial in campaign.trials),
    )
    of_campaign: dict[str, Any] = {"family": "campaign", "basis": "trials.csv"}
    return OutputFolder(folder, names=names, inputs=inputs, force=force, **of_campaign)


def table_folder(
    inputs: Iterable[Path], folder: str | os.PathLike[str], *, force: bool = False
) -> OutputFolder:
    """Return the folder of the answer to a trial table, likewise."""
    return OutputFolder(folder, family="trial table", names=_answered(), inputs=inputs, force=force)


def _answered() -> tuple[str, ...]:
    return (*_ANSWERED, *(f"fits/{law}.json" for law in ALL_LAWS))


T = TypeVar("T")

STEP = 0.05
"""Relative change of each setting of a design to find its influence [-]."""

_WHEELS, _WRAPS = 4, 80
_BEYOND = 1.2
_LEVELS = 12
_PLANNED = 6


Measured = tuple[tuple[budgets.MeasuredForce, LinearBudget], ...]
"""The measured force of each condition with its uncertainty, by the budget alone."""


class Evidence(NamedTuple):
    """The uncertainty behind a campaign's answer; None without a design, or where it could not be computed."""

    measured: Measured = ()
    typical: Statement | None = None
    typical_number: int = 0
    lift: Statement | None = None
    swings: tuple[tuple[str, float, float, float], ...] = ()
    chart: DesignChart | None = None
    plan: next_tests.LabPlan | None = None
    hand: tuple[str, ...] = ()
    rejection: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()


def gather_evidence(run: CampaignRun | CampaignAnswer) -> Evidence:
    """Return what a report shows beyond the answer of a campaign, or of a trial table."""
    missing: list[str] = []
    campaign = run if isinstance(run, CampaignRun) else None
    answer = run if isinstance(run, CampaignAnswer) else run.answer

    def attempt(name: str, make: Callable[[], T]) -> T | None:
        try:
            return make()
        except RopefricError as error:
            missing.append(f"no {name}: {error.problem.message}")
            return None

    measured = typical = None
    number = 0
    if campaign is not None:
        measured = attempt("budgets of the measured forces", lambda: _measured(campaign))
    if measured:
        middle = sorted(measured, key=lambda item: item[1].relative)[len(measured) // 2][0]
        number, (_, model, notes) = middle.number, middle
        typical = attempt("budget of a typical force", lambda: state_uncertainty(model, notes=notes))
    prediction, design = answer.prediction, dict[str, Any]()
    if prediction is not None:
        fit, wheel, wished = answer.fit, prediction.conditions, prediction
        design = {
            "lift": attempt("uncertainty budget of the lift force", lambda: state_design(fit, wheel)),
            "swings": attempt("sensitivities", lambda: swings_of_design(fit, wished)) or (),
            "chart": attempt("design chart", lambda: chart_of_design(fit, wheel)),
            "plan": attempt("plan of further tests", lambda: plan_for_design(answer, campaign, wheel)),
            "hand": attempt("hand calculation", lambda: fit.friction_law.calculation(fit.theta, wheel)) or (),
        }
    if campaign is not None:
        words = attempt("result without the outlier rule", lambda: rejection_words(campaign))
        design["rejection"] = words or ()
    return Evidence(
        measured=measured or (), typical=typical, typical_number=number, **design, missing=tuple(missing)
    )


def rejection_words(run: CampaignRun) -> tuple[str, ...]:
    """Return how many good trials the campaign's rule takes on average, and what the result is without it."""
    rule, trials, answer = RULES[run.campaign.rejection], run.extraction.trials, run.answer
    usable = {trial.trial for trial in trials if trial.usable}
    sizes = [len(usable.intersection(item.trials)) for item in run.extraction.conditions]
    rejected = np.array([bool(trial.rejected_by) for trial in trials])
    lost, words = math.fsum(map(rule.good_lost, sizes)), []
    if rule.can_reject(10**6) and math.isfinite(lost):
        n = " to ".join(map(str, sorted({min(sizes), max(sizes)})))
        took = f"{np.count_nonzero(rejected)} of {sum(sizes)}"
        words.append(
            f"with n = {n} {rule.label} rejects {lost:.2g} good trials on average; here it rejected {took}"
        )
    if rejected.any():
        fit = fit_law(replace(answer.table, kept=answer.table.kept | rejected), answer.fit.law)
        shown = [item for item in fit.parameters if item.vary]
        values = ", ".join(f"{item.name} = {item.value:.4g} ± {item.std:.2g}" for item in shown)
        text = f"without the rule {fit.law} has {values}"
        if (asked := answer.prediction) is not None:
            both = (_lift_N(one, asked.conditions, "wrap_angle_rad", 1.0) for one in (answer.fit, fit))
            with_N, without_N = both
            text += f", and F_A of the design is {without_N:.5g} N instead of {with_N:.5g} N"
        words.append(text)
    return tuple(words)


def _measured(run: CampaignRun) -> Measured:
    return tuple((item, linear_budget(item.model)) for item in budgets.measured_forces(run.extraction))


def evidence_files(evidence: Evidence) -> dict[str, str]:
    """Return uncertainty.json and next_tests.csv by name, as far as there are such."""
    texts = {}
    if evidence.lift is not None:
        texts["uncertainty.json"] = json_document(rounded_tree(evidence.lift.to_dict()))
    if evidence.plan is not None:
        texts["next_tests.csv"] = evidence.plan.to_csv()
    return texts


def state_design(fit: FitResult, wheel: Conditions) -> Statement:
    """Return the uncertainty of the lift force of one wheel whose settings are exact.

    Of one pull with one new rope where the fit knows how far they scatter, else of the mean law.
    """
    return budgets.state_lift(fit, wheel, {}, one_pull=fit.scatter.of_pulls)


def swings_of_design(fit: FitResult, prediction: Prediction) -> tuple[tuple[str, float, float, float], ...]:
    """Return the lift force of the first wheel when one input changes: name, low, high, as designed [N].

    Each setting goes `STEP` down and up; the law and the rope go from end to end of the intervals of the prediction.
    NaN where the law has no answer, or the fit knows no scatter.
    """
    at = prediction.conditions.select([0])
    base_N = _lift_N(fit, at, "wrap_angle_rad", 1.0)  # of this law, where the prediction averages several
    rows = []
    for name, (title, _unit, _factor) in REGRESSORS.items():
        low_N, high_N = (_lift_N(fit, at, name, 1.0 + step) for step in (-STEP, STEP))
        rows.append((f"{title} ± {100 * STEP:g} %", low_N, high_N, base_N))
    for words, ends in (
        ("mean law: confidence interval", prediction.interval_N[0]),
        ("new rope: prediction interval", prediction.prediction_interval_N[0]),
    ):
        low_N, high_N = (float(end) if math.isfinite(end) else math.nan for end in ends)
        rows.append((f"{words} {100 * prediction.level:g} %", low_N, high_N, base_N))
    return tuple(rows)


def _lift_N(fit: FitResult, at: Conditions, name: str, factor: float) -> float:
    """Return the lift force with one setting changed; NaN where the law has no answer."""
    try:
        changed = replace(at, **{name: factor * getattr(at, name)})
        return math.exp(float(fit.friction_law.log_lift(fit.theta, changed)[0]))
    except (RopefricError, OverflowError):
        return math.nan


def chart_of_design(fit: FitResult, wheel: Conditions) -> DesignChart:
    """Return the lift force of the tested wheels, and of the one asked for, over wraps up to and beyond the tested."""
    (small_m, large_m), (_, most_rad) = fit.validity["wheel_radius_m"], fit.validity["wrap_angle_rad"]
    own_m, wrap_rad = float(wheel.wheel_radius_m[0]), float(wheel.wrap_angle_rad[0])
    farthest_rad = _BEYOND * max(most_rad, wrap_rad)
    wheels_m = np.unique(np.append(np.linspace(small_m, large_m, _WHEELS), own_m))
    wraps_rad = np.linspace(farthest_rad / _WRAPS, farthest_rad, _WRAPS)
    end_N, rope_m = float(wheel.end_tension_N[0]), float(wheel.rope_radius_m[0])
    return design_chart(fit, wheels_m, wraps_rad, end_N, rope_radius_m=rope_m)


def plan_for_design(answer: CampaignAnswer, run: CampaignRun | None, wheel: Conditions) -> next_tests.LabPlan:
    """Return the tests, within what the campaign's rig has done, that make the lift force of a wheel most certain.

    Wheels are those that were used; wraps and end tensions lie between the smallest and the largest that were; the
    largest force is that of the campaign's largest cell, or the largest measured where it names none.
    """
    fit, table = answer.fit, answer.table
    used = table.used
    wraps_deg = [float(f"{math.degrees(end):.12g}") for end in fit.validity["wrap_angle_rad"]]
    low_N, high_N = fit.validity["end_tension_N"]
    cells_N = [] if run is None else [cell.full_scale_N for cell in run.campaign.cells.values()]
    limits = resolution.RigLimits(
        wheel_radius_m=tuple(distinct(table.wheel_radius_m[used]).tolist()),
        wrap_angle_rad=tuple(math.radians(x) for x in _between(wraps_deg[0], wraps_deg[1], step=45.0)),
        end_tension_N=_between(low_N, high_N),
        rope_radius_m=float(wheel.rope_radius_m[0]),
        largest_force_N=max(cells_N, default=float(np.max(table.peak_N[used]))),
    )
    if run is None:
        repeats = sorted(np.bincount(table.group()).tolist())
    else:
        repeats = sorted(summary.n_recorded for summary in run.extraction.conditions)
    usual, known = repeats[len(repeats) // 2], next_tests.planned_fit(fit)
    return next_tests.plan_tests(known, limits, wheel, n_conditions=_PLANNED, repeats=usual)


def _between(low: float, high: float, step: float | None = None) -> tuple[float, ...]:
    """Return settings from low to high, or the one there is."""
    if not high > low * (1.0 + 1e-9):
        return (low,)
    return resolution.levels(low, high, _LEVELS, step=step)


SCHEMA, TABLE_SCHEMA = "ropefric.run/1", "ropefric.table/1"
MOST_BYTES = 256 * 2**20
"""The manifest of a million recordings is smaller."""
MANIFEST = "manifest.json"
"""Name of the file in a folder of results that says what they were made from."""

_DRAWN_WITH = ("matplotlib", "jinja2")


def trace_provenance(run: CampaignRun, evidence: Evidence) -> dict[str, Any]:
    """Return all that is needed to make a result again, without time or place, as a tree of schema `ropefric.run/1`.

    The inputs are the campaign, the trial list and the recordings, each with its path relative to the campaign's
    folder and the SHA-256 of its bytes, "" if it was not read.
    """
    campaign, law = run.campaign, run.answer.forced_law
    words = ["ropefric", "run", campaign.path.name, "--out", "out", *(("--law", law) if law else ())]
    named_here = [one["file"] for one in provenance() if one["file"] not in campaign.plugins]
    words += [word for file in named_here for word in ("--plugin", file)]
    recordings: dict[str, str] = {}
    for trial in run.extraction.trials:
        recordings.setdefault(trial.file, trial.sha256)
    inputs = {
        campaign.path.name: hash_file(campaign.path),
        **{
            campaign.relative(path): hash_file(path)
            for path in (campaign.trial_list, campaign.decisions)
            if path.exists()
        },
    } | recordings
    return {"schema": SCHEMA, **_traced(run.answer, evidence, words, inputs), "settings": campaign.resolved()}


def trace_table(answer: CampaignAnswer, evidence: Evidence, inputs: Sequence[Path]) -> dict[str, Any]:
    """Return the same for the answer to a trial table: the first input; a second one says more about it."""
    words = ["ropefric", "report", inputs[0].name, "--out", "out"]
    words += [word for path in inputs[1:] for word in ("--about", path.name)]
    words += ("--law", answer.forced_law) if answer.forced_law else ()
    at = None if answer.prediction is None else answer.prediction.conditions
    design = {} if at is None else {name: float(getattr(at, name)[0]) for name in REGRESSORS}
    hashes = {path.name: hash_file(path) for path in inputs}
    traced = _traced(answer, evidence, words, hashes)
    return {"schema": TABLE_SCHEMA, **traced, "settings": {"design": design}}


def _traced(
    answer: CampaignAnswer, evidence: Evidence, words: Sequence[str], inputs: Mapping[str, str]
) -> dict[str, Any]:
    fit = answer.fit
    seeds = {"fit": fit.provenance.get("settings", {}).get("seed", 0)}
    if evidence.lift is not None:
        seeds["uncertainty budget"] = evidence.lift.drawn.seed
    return {
        "command": shlex.join(words),
        "law": answer.forced_law,
        "inputs": [{"path": path, "sha256": sha256} for path, sha256 in inputs.items()],
        "versions": fit.provenance.get("versions", {}) | {name: version(name) for name in _DRAWN_WITH},
        "seeds": seeds,
    }


def manifest(provenance: dict[str, Any], campaign: Path, folder: Path) -> dict[str, str]:
    """Return the manifest, by which a folder of results finds its campaign again."""
    try:
        shown = Path(os.path.relpath(campaign, folder)).as_posix()
    except ValueError:  # another drive on Windows
        shown = campaign.resolve().as_posix()
    return {MANIFEST: json_document(provenance | {"campaign": shown})}


def recorded_run(folder: Path) -> tuple[Path, str]:
    """Return the campaign file that a folder of results was made from, and the law that was asked for."""
    path = (folder / MANIFEST).as_posix()
    try:
        tree = json.loads(read_file(path, limit=MOST_BYTES))
    except DataError:
        fix = "give a folder that `ropefric run` wrote, or the campaign"
        raise DataError("no results stand here", code="RF101", path=path, fix=fix) from None
    except (ValueError, RecursionError):
        tree = None
    known = isinstance(tree, dict) and tree.get("schema") == SCHEMA
    if not known or not all(isinstance(tree.get(key), str) for key in ("campaign", "law")):
        fix = "give the campaign or the table itself"
        raise DataError(f"this is no {SCHEMA}", code="RF101", path=path, fix=fix)
    return Path(os.path.normpath(folder / tree["campaign"])), tree["law"]
