"""One condition on one page: the recordings of its trials, and how well their forces repeat."""

from typing import TYPE_CHECKING

from matplotlib import colormaps

from ropefric.errors import UnknownNameError
from ropefric.plotting.figure import DataTable, FigureWithData, new_figure
from ropefric.plotting.labels import name_condition
from ropefric.plotting.strip import draw_strip
from ropefric.plotting.style import TRACE_COLORS, house_style
from ropefric.plotting.tracepanel import draw_traces, recordings_of
from ropefric.registry import did_you_mean

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from ropefric.trials.result import ConditionSummary, TrialResult

__all__ = ["draw_condition"]

# Room for six-digit forces on the left and for three rows of legend below.
_MARGINS = {"left": 0.09, "right": 0.985, "top": 0.86, "bottom": 0.27, "wspace": 0.24}


def draw_condition(summary: "ConditionSummary", trials: "Iterable[TrialResult]") -> FigureWithData:
    """Return the figure of one condition: its traces on the left, the repeatability of the force on the right.

    Parameters
    ----------
    summary : ConditionSummary
        The condition; its `trials` say which results belong to it and in which order.
    trials : iterable of TrialResult
        These results; others are passed over.

    Returns
    -------
    FigureWithData
        With a main table (a row a trial) and the table `traces` (the envelopes drawn, each under the
        name of its recording's first trial).

    Raises
    ------
    UnknownNameError
        If a trial of the condition is missing from `trials`.

    Examples
    --------
    >>> from ropefric.trials.result import ConditionSummary
    >>> nan = float("nan")
    >>> summary = ConditionSummary(
    ...     wheel_radius_m=0.04, rope_radius_m=0.0049, wrap_angle_rad=3.0, end_tension_N=80.0, lift_force_N=nan,
    ...     n_recorded=0, n=0, n_kept=0, rejected=(), mean_all_N=nan, std_all_N=nan, mean_kept_N=nan,
    ...     std_kept_N=nan, rule="two-sigma", notes=(), trials=())
    >>> [axes.get_ylabel() for axes in draw_condition(summary, ()).figure.axes][0]
    'Force F [N]'
    """
    by_name = {trial.trial: trial for trial in trials}
    missing = [name for name in summary.trials if name not in by_name]
    if missing:
        raise UnknownNameError(
            f"the condition has a trial {missing[0]!r} without a result",
            fix=did_you_mean(missing[0], by_name),
        )
    chosen = [by_name[name] for name in summary.trials]
    colors = _colors(len(chosen))
    name = name_condition(summary, measures_slack=any(trial.measures_slack for trial in chosen))
    with house_style():
        figure = new_figure(margins=_MARGINS)
        left, right = figure.subplots(1, 2, width_ratios=(3, 2))
        draw_traces(left, chosen, colors)
        draw_strip(right, summary, chosen, colors)
        figure.suptitle(f"{name.title}   —   {summary.n_kept} of {summary.n_recorded} trials kept")
    return FigureWithData(figure=figure, tables=(_trial_table(chosen), _trace_table(chosen)))


def _colors(n: int) -> list[tuple[float, float, float, float]]:
    """Return n colours in order; the palest end of the map is left out, it drowns on white paper."""
    scale = colormaps[TRACE_COLORS]
    return [scale(0.85 * i / max(n - 1, 1)) for i in range(n)]


def _trial_table(trials: "Sequence[TrialResult]") -> DataTable:
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
