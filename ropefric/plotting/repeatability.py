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

__all__ = ["draw_repeatability"]


def draw_repeatability(summary: "ConditionSummary", trials: "Iterable[TrialResult]") -> FigureWithData:
    """Return the repeatability strip of one condition: force by trial, mean and ±2s band, what was set aside and why.

    Parameters
    ----------
    summary : ConditionSummary
        The condition; its `trials` say which results belong to it and in which order.
    trials : iterable of TrialResult
        These results; others are passed over.

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
    >>> draw_repeatability(summary, ()).alt
    'R_w = 40 mm, R_r = 4.9 mm, φ = 171.887°, F_B = 80 N: no usable force in 0 trials.'
    """
    chosen = trials_of(summary, trials)
    name = name_condition(summary, measures_slack=any(trial.measures_slack for trial in chosen))
    with house_style():
        figure = new_figure(10.0, 5.0)
        draw_strip(figure.subplots(), summary, chosen, trial_colors(len(chosen)))
        figure.suptitle(f"{name.title}   —   {summary.n_kept} of {summary.n_recorded} trials kept")
    return FigureWithData(
        figure=figure, tables=(trial_table(chosen),), alt=condition_alt(summary, name, chosen)
    )
