"""A campaign from its recordings to the answer, with everything written that others can check."""

import csv
import io
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ropefric.errors import DataError
from ropefric.files.folder import Folder, as_folder
from ropefric.files.plain_text import json_document
from ropefric.fitting.compare import Comparison
from ropefric.fitting.store import fit_text
from ropefric.pipeline.answer import CampaignAnswer, Progress, answer_trials
from ropefric.traces.breakaway import Status
from ropefric.trials.campaign_model import Campaign
from ropefric.trials.conditions import set_aside_impossible
from ropefric.trials.extract import extract_campaign
from ropefric.trials.result import Extraction, count_trials, write_tables
from ropefric.trials.table import read_trial_table

_RANKING = (
    "law",
    "status",
    "counted",
    "n",
    "k",
    "chi2",
    "aicc",
    "delta_aicc",
    "weight",
    "bic",
    "loco_error",
    "note",
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CampaignRun:
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

    campaign: Campaign
    extraction: Extraction
    answer: CampaignAnswer
    written: tuple[Path, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return counts of the extraction, ranking, fit, prediction and diagnosis as a JSON tree."""
        return {
            "campaign": self.campaign.name,
            "extraction": count_trials(self.extraction),
        } | self.answer.to_dict()


def run_campaign(
    campaign: Campaign,
    folder: Folder | str | os.PathLike[str],
    *,
    law: str = "",
    jobs: int = 1,
    cache_dir: Path | None = None,
    extract_progress: Callable[[int, int, str], None] | None = None,
    fit_progress: Progress | None = None,
    on_extracted: Callable[[Extraction], None] | None = None,
) -> CampaignRun:
    """Return the result of a campaign, and write its tables, fits, comparison and prediction into a folder.

    Writes trials.csv, conditions.csv, problems.csv, fits/LAW.json for every law fitted, comparison.csv and
    prediction.json; the same campaign gives the same bytes, whatever `jobs` and the cache.
    """
    found = extract_campaign(campaign, jobs=jobs, cache_dir=cache_dir, progress=extract_progress)
    extraction = set_aside_impossible(found, campaign)
    target = as_folder(folder)
    tables = write_tables(extraction, target)
    target.publish("tables")
    if on_extracted is not None:
        on_extracted(extraction)
    _require_a_force(extraction, campaign)
    # From the file, so that every fit names its data, with its hash, and can be made again.
    answer = answer_trials(
        read_trial_table(tables[0]),
        design=campaign.design,
        rope_radius_m=campaign.rope.radius_m,
        law=law,
        progress=fit_progress,
    )
    return CampaignRun(
        campaign=campaign,
        extraction=extraction,
        answer=answer,
        written=(*tables, *write_answer(answer, target)),
    )


def write_answer(answer: CampaignAnswer, folder: Folder | str | os.PathLike[str]) -> tuple[Path, ...]:
    """Write fits/LAW.json for every law, comparison.csv and, if there is one, prediction.json; return their paths."""
    target = as_folder(folder)
    texts = {f"fits/{fit.law}.json": fit_text(fit, target.path / "fits") for fit in answer.fits}
    texts["comparison.csv"] = _ranking_text(answer.comparison)
    if answer.prediction is not None:
        texts["prediction.json"] = json_document(answer.prediction.to_dict())
    return target.write(texts)


def _require_a_force(extraction: Extraction, campaign: Campaign) -> None:
    if any(trial.breakaway.status == Status.OK for trial in extraction.trials):
        return
    raise DataError(
        f"none of the {len(extraction.trials)} recordings gave a usable force",
        code="RF301",
        path=campaign.path,
        fix="problems.csv says why for each; `ropefric inspect FILE` shows what a file holds",
    )


def _ranking_text(comparison: Comparison) -> str:
    stream = io.StringIO()
    writer = csv.DictWriter(stream, _RANKING, lineterminator="\n")
    writer.writeheader()
    for entry in comparison.ranking:
        row = entry.to_dict()
        writer.writerow({name: _cell(row[name]) for name in _RANKING})
    return stream.getvalue()


def _cell(value: Any) -> Any:
    return str(value).lower() if isinstance(value, bool) else value
