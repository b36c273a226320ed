"""How well the force of one condition repeats, as a figure of its own."""

from typing import TYPE_CHECKING

from ropefric.plotting.condition import condition_alt, trial_colors, trial_table, trials_of
from ropefric.plotting.figure import FigureWithData, new_figure
from ropefric.plotting.labels import name_condition
from ropefric.plotting.strip import draw_strip
from ropefric.plotting.style import house_style

if TYPE_CHECKING:
    from collections.abc import Iterable

    from ropefric.trials.result import ConditionSummary, TrialResult


def draw_repeatability(summary: "ConditionSummary", trials: "Iterable[TrialResult]") -> FigureWithData:
    """Return the repeatability strip of one condition: force by trial, mean and ±2s band, what was set aside and why."""
    chosen = trials_of(summary, trials)
    name = name_condition(summary, measures_slack=any(trial.measures_slack for trial in chosen))
    with house_style():
        figure = new_figure(10.0, 5.0)
        draw_strip(figure.subplots(), summary, chosen, trial_colors(len(chosen)))
        figure.suptitle(f"{name.title}   —   {summary.n_kept} of {summary.n_recorded} trials kept")
    return FigureWithData(
        figure=figure, tables=(trial_table(chosen),), alt=condition_alt(summary, name, chosen)
    )
