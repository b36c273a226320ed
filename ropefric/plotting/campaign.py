"""All figures of a campaign: one a condition."""

import os
from collections.abc import Callable
from concurrent.futures import Executor, as_completed
from pathlib import Path
from typing import TYPE_CHECKING

from ropefric.files.folder import Folder, as_folder
from ropefric.plotting.condition import draw_condition
from ropefric.plotting.labels import name_condition, name_files
from ropefric.plotting.save import figure_files

if TYPE_CHECKING:
    from ropefric.trials.result import ConditionSummary, Extraction, TrialResult


def write_condition_figures(
    extraction: "Extraction",
    folder: Folder | str | os.PathLike[str],
    *,
    under: str = "",
    formats: tuple[str, ...] = ("png",),
    executor: Executor | None = None,
    progress: Callable[[int, int, str], None] | None = None,
) -> tuple[Path, ...]:
    """Draw each condition of an extraction into `folder`; return the paths written, condition by condition."""
    by_name = {trial.trial: trial for trial in extraction.trials}
    groups = [(summary, [by_name[name] for name in summary.trials]) for summary in extraction.conditions]
    stems = name_files(
        name_condition(summary, measures_slack=any(trial.measures_slack for trial in trials))
        for summary, trials in groups
    )
    target = as_folder(folder)
    jobs = [(*group, f"{under}{stem}", formats) for group, stem in zip(groups, stems, strict=True)]
    written: list[tuple[Path, ...]] = [()] * len(jobs)
    if executor is None:
        for place, job in enumerate(jobs):
            written[place] = target.write(_draw_one(*job))
            if progress is not None:
                progress(place + 1, len(jobs), stems[place])
    else:
        places = {executor.submit(_draw_one, *job): place for place, job in enumerate(jobs)}
        for done, future in enumerate(as_completed(places), start=1):
            # Workers draw, and this process alone writes.
            written[places[future]] = target.write(future.result())
            if progress is not None:
                progress(done, len(jobs), stems[places[future]])
    return tuple(path for paths in written for path in paths)


def _draw_one(
    summary: "ConditionSummary", trials: "list[TrialResult]", stem: str, formats: tuple[str, ...]
) -> dict[str, bytes]:
    return figure_files(draw_condition(summary, trials), stem, formats=formats)
