"""One condition on one page: the recordings of its trials, and how well their forces repeat."""

import math
from typing import TYPE_CHECKING

from matplotlib import colormaps

from ropefric.errors import UnknownNameError
from ropefric.glossary import counted
from ropefric.plotting.figure import DataTable, FigureWithData, new_figure
from ropefric.plotting.labels import ConditionName, name_condition
from ropefric.plotting.strip import draw_strip
from ropefric.plotting.style import TRACE_COLORS, house_style
from ropefric.plotting.tracepanel import draw_traces, recordings_of
from ropefric.plotting.words import plain_text
from ropefric.registry import did_you_mean

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from ropefric.trials.result import ConditionSummary, TrialResult


# Room for six-digit forces on the left and for three rows of legend below.
_MARGINS = {"left": 0.09, "right": 0.985, "top": 0.86, "bottom": 0.27, "wspace": 0.24}


def draw_condition(summary: "ConditionSummary", trials: "Iterable[TrialResult]") -> FigureWithData:
    """Return the figure of one condition: its traces on the left, the repeatability of the force on the right."""
    chosen = trials_of(summary, trials)
    colors = trial_colors(len(chosen))
    name = name_condition(summary, measures_slack=any(trial.measures_slack for trial in chosen))
    with house_style():
        figure = new_figure(margins=_MARGINS)
        left, right = figure.subplots(1, 2, width_ratios=(3, 2))
        draw_traces(left, chosen, colors)
        draw_strip(right, summary, chosen, colors)
        figure.suptitle(f"{name.title}   —   {summary.n_kept} of {summary.n_recorded} trials kept")
    return FigureWithData(
        figure=figure,
        tables=(trial_table(chosen), _trace_table(chosen)),
        alt=condition_alt(summary, name, chosen),
    )


def trials_of(summary: "ConditionSummary", trials: "Iterable[TrialResult]") -> "list[TrialResult]":
    """Return the results of a condition's trials, in its order."""
    by_name = {trial.trial: trial for trial in trials}
    missing = [name for name in summary.trials if name not in by_name]
    if missing:
        raise UnknownNameError(
            f"the condition has a trial {missing[0]!r} without a result",
            fix=did_you_mean(missing[0], by_name),
        )
    return [by_name[name] for name in summary.trials]


def condition_alt(summary: "ConditionSummary", name: ConditionName, trials: "Sequence[TrialResult]") -> str:
    """Return what the figure of a condition shows, in words."""
    where = plain_text(name.title).replace(",  ", ", ")
    if not math.isfinite(summary.mean_all_N):
        return f"{where}: no usable force in {counted(summary.n_recorded, 'trial')}."
    force = "end tension" if any(trial.measures_slack for trial in trials) else "break-away force"
    text = f"{where}: {force} {summary.mean_all_N:.4g} N on average over {counted(summary.n, 'usable trial')}"
    if math.isfinite(summary.std_all_N):
        text += f", sample standard deviation {summary.std_all_N:.3g} N"
    kept = f"{summary.n_kept} of {counted(summary.n_recorded, 'trial')} kept"
    aside = (
        f", {', '.join(summary.rejected)} set aside by the rule {summary.rule}" if summary.rejected else ""
    )
    return f"{text}; {kept}{aside}."


def trial_colors(n: int) -> list[tuple[float, float, float, float]]:
    """Return n colours in order; the palest end of the map is left out, it drowns on white paper."""
    scale = colormaps[TRACE_COLORS]
    return [scale(0.85 * i / max(n - 1, 1)) for i in range(n)]


def trial_table(trials: "Sequence[TrialResult]") -> DataTable:
    """Return the table of a condition's trials, a row each."""
    header = (
        *("trial", "file", "peak_N", "peak_std_N", "end_tension_N", "peak_time_s", "kinetic_N"),
        *("status", "kept", "rejected_by", "excluded"),
    )
    return DataTable(
        header=header,
        rows=tuple(
            (
                *(trial.trial, trial.file, trial.peak_N, trial.peak_std_N, trial.end_tension_N),
                *(trial.breakaway.peak_time_s, trial.breakaway.kinetic_N, str(trial.breakaway.status)),
                *(trial.kept, trial.rejected_by, trial.excluded),
            )
            for trial in trials
        ),
    )


def _trace_table(trials: "Sequence[TrialResult]") -> DataTable:
    rows: list[tuple[object, ...]] = []
    for trial in recordings_of(trials):
        if trial.outline is not None:
            columns = (
                trial.outline.time_s,
                trial.outline.low_N,
                trial.outline.high_N,
                trial.outline.smoothed_N,
            )
            rows += [(trial.trial, *map(float, row)) for row in zip(*columns, strict=True)]
    return DataTable(name="traces", header=("trial", "time_s", "low_N", "high_N", "mean_N"), rows=tuple(rows))
