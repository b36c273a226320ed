"""All figures of a campaign: one a condition."""

from collections.abc import Callable
from concurrent.futures import Executor, as_completed
from pathlib import Path
from typing import TYPE_CHECKING

from ropefric.plotting.condition import draw_condition
from ropefric.plotting.labels import name_condition, name_files
from ropefric.plotting.save import save_figure

if TYPE_CHECKING:
    from ropefric.trials.result import ConditionSummary, Extraction, TrialResult

__all__ = ["write_condition_figures"]


def write_condition_figures(
    extraction: "Extraction",
    folder: Path,
    *,
    formats: tuple[str, ...] = ("png",),
    executor: Executor | None = None,
    progress: Callable[[int, int, str], None] | None = None,
) -> tuple[Path, ...]:
    """Draw each condition of an extraction into `folder`; return the paths written, condition by condition.

    Parameters
    ----------
    extraction : Extraction
        Conditions and trials.
    folder : Path
        Made where it is missing.
    formats : tuple of str
        "png", "svg", "pdf".
    executor : concurrent.futures.Executor, optional
        Draws in parallel; one after the other by default.
    progress : callable, optional
        Called with done, total and the name of the figure just finished.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> write_condition_figures(SimpleNamespace(conditions=(), trials=()), Path("nowhere"))
    ()
    """
    by_name = {trial.trial: trial for trial in extraction.trials}
    groups = [(summary, [by_name[name] for name in summary.trials]) for summary in extraction.conditions]
    stems = name_files(
        name_condition(summary, measures_slack=any(trial.measures_slack for trial in trials))
        for summary, trials in groups
    )
    jobs = [(*group, folder, stem, formats) for group, stem in zip(groups, stems, strict=True)]
    written: list[tuple[Path, ...]] = [()] * len(jobs)
    if executor is None:
        for place, job in enumerate(jobs):
            written[place] = _write_one(*job)
            if progress is not None:
                progress(place + 1, len(jobs), job[3])
    else:
        places = {executor.submit(_write_one, *job): place for place, job in enumerate(jobs)}
        for done, future in enumerate(as_completed(places), start=1):
            written[places[future]] = future.result()
            if progress is not None:
                progress(done, len(jobs), jobs[places[future]][3])
    return tuple(path for paths in written for path in paths)


def _write_one(
    summary: "ConditionSummary",
    trials: "list[TrialResult]",
    folder: Path,
    stem: str,
    formats: tuple[str, ...],
) -> tuple[Path, ...]:
    return save_figure(draw_condition(summary, trials), folder, stem, formats=formats)
