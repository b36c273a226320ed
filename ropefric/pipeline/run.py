"""A campaign from its recordings to the lift force of a wheel, with everything written that others can check."""

import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ropefric.errors import RopefricError
from ropefric.files.folder import Folder, OutputFolder, as_folder
from ropefric.files.plain_text import csv_cell, csv_text, json_document
from ropefric.fitting.compare import Choice, Comparison, choose_law, compare_laws
from ropefric.fitting.diagnose import Diagnosis, diagnose
from ropefric.fitting.predict import Prediction, predict
from ropefric.fitting.result import FitResult, Verdict
from ropefric.fitting.store import fit_text
from ropefric.friction.condition import one_condition
from ropefric.friction.laws import ALL_LAWS, LAWS
from ropefric.shown import Shown
from ropefric.trials.campaign_model import Campaign, DesignWheel
from ropefric.trials.extract import extract_campaign
from ropefric.trials.result import Extraction, count_trials, no_force, set_aside_impossible, write_tables
from ropefric.trials.table import TrialTable, read_trial_table

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
    *("overview", "mu_facets", "capstan", "fit_over_", "residuals", "ladder", "corner"),
    *("tornado", "design_chart", "budget_", "typical_recording", "law", "recordings_", "paper_"),
)
_ANSWERED = (
    *("comparison.csv", "prediction.json", "uncertainty.json", "next_tests.csv", "manifest.json"),
    *("report.html", "report.pdf", "summary.txt"),
    *(f"figures/{stem}*.{end}" for stem in _FIGURES for end in ("csv", "png", "svg", "pdf")),
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CampaignAnswer:
    """What a trial table says."""

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
        return self.winner.verdict if self.prediction is None else self.prediction.verdict()

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
    progress: Progress | None = None,
) -> CampaignAnswer:
    """Return which law a trial table asks for, what it supports, and the lift force of a design."""
    laws = [*LAWS, law] if law and law not in LAWS else None
    comparison = compare_laws(table, laws, progress=progress)
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
    cache_dir: Path | None = None,
    executor: Any = None,
    parquet: bool = False,
    extract_progress: Callable[[int, int, str], None] | None = None,
    fit_progress: Progress | None = None,
    on_extracted: Callable[[Extraction], None] | None = None,
) -> CampaignRun:
    """Return the result of a campaign, and write its tables, fits, comparison and prediction into a folder.

    Writes trials.csv, conditions.csv, problems.csv, fits/LAW.json for every law fitted, comparison.csv and
    prediction.json, and trials.parquet if it is wanted; the same campaign gives the same bytes, whatever `jobs`, the
    executor that reads in their stead, and the cache.
    """
    found = extract_campaign(
        campaign, jobs=jobs, cache_dir=cache_dir, progress=extract_progress, executor=executor
    )
    extraction = set_aside_impossible(found, campaign)
    target = as_folder(folder)
    tables = write_tables(extraction, target, parquet=parquet)
    target.publish("tables")
    if on_extracted is not None:
        on_extracted(extraction)
    if (without := no_force(extraction, campaign.path)) is not None:
        raise without
    # From the file, so that every fit names its data, with its hash, and can be made again.
    answer = answer_trials(
        read_trial_table(tables[0]),
        design=campaign.design,
        rope_radius_m=campaign.rope.radius_m,
        law=law,
        progress=fit_progress,
    )
    written = (*tables, *write_answer(answer, target))
    return CampaignRun(campaign=campaign, extraction=extraction, answer=answer, written=written)


def write_answer(answer: CampaignAnswer, folder: Folder | str | os.PathLike[str]) -> tuple[Path, ...]:
    """Write fits/LAW.json for every law, comparison.csv and, if there is one, prediction.json; return their paths."""
    target = as_folder(folder)
    texts = {f"fits/{fit.law}.json": fit_text(fit, target.path / "fits") for fit in answer.fits}
    texts["comparison.csv"] = _ranking_text(answer.comparison)
    if answer.prediction is not None:
        texts["prediction.json"] = json_document(answer.prediction.to_dict())
    return target.write(texts)


def _ranking_text(comparison: Comparison) -> str:
    rows = (entry.to_dict() for entry in comparison.ranking)
    return csv_text([_RANKING, *([csv_cell(row[name]) for name in _RANKING] for row in rows)])


def campaign_folder(
    campaign: Campaign, folder: str | os.PathLike[str], *, answers: bool = True, force: bool = False
) -> OutputFolder:
    """Return the folder of a campaign's results, as a context that keeps it from other runs; see `OutputFolder`."""
    return OutputFolder(
        folder,
        family="campaign",
        names=(*_EXTRACTED, *(_answered() if answers else ())),
        inputs=(campaign.path, campaign.trial_list, *dict.fromkeys(trial.path for trial in campaign.trials)),
        basis="trials.csv",
        force=force,
    )


def table_folder(
    inputs: Iterable[Path], folder: str | os.PathLike[str], *, force: bool = False
) -> OutputFolder:
    """Return the folder of the answer to a trial table, likewise."""
    return OutputFolder(folder, family="trial table", names=_answered(), inputs=inputs, force=force)


def _answered() -> tuple[str, ...]:
    return (*_ANSWERED, *(f"fits/{law}.json" for law in ALL_LAWS))
