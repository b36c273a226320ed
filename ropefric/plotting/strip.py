"""The repeatability strip: the measured force trial after trial, what was set aside and why."""

from collections.abc import Sequence
from textwrap import shorten
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.ticker import MaxNLocator

from ropefric.plotting.labels import figure_label
from ropefric.plotting.legend import legend_below
from ropefric.plotting.style import BLUE, DARK_ORANGE, GREY, ORANGE
from ropefric.traces.breakaway import Status
from ropefric.trials.outliers import RULES

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ropefric.trials.result import ConditionSummary, TrialResult


_LONGEST_REASON = 24
_CROWDED = 6
"""Trials above which a reason is written upright, so that it does not run into its neighbours."""


def draw_strip(
    axes: "Axes", summary: "ConditionSummary", trials: "Sequence[TrialResult]", colors: Sequence[Any]
) -> None:
    r"""Draw the measured force of each trial in order, the mean and the ±2s band of all of them.

    Rejected trials are hollow, trials the user excluded are hollow diamonds, both with the reason; flagged
    recordings stand as crosses on the axis with their status. A banner says where too few were measured to reject
    any.
    """
    measured = "end_tension_N" if any(trial.measures_slack for trial in trials) else "peak_N"
    axes.set(xlabel="Trial, in order of recording", ylabel=figure_label(measured))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_xlim(0.4, max(len(trials), 1) + 0.6)
    axes.margins(y=0.15)
    _draw_mean(axes, summary)
    for order, (trial, color) in enumerate(zip(trials, colors, strict=True), start=1):
        if trial.breakaway.status == Status.OK:
            _draw_value(axes, order, trial, color, crowded=len(trials) > _CROWDED)
        else:
            _draw_flag(axes, order, trial)
    if not any(trial.breakaway.status == Status.OK for trial in trials):
        axes.text(0.5, 0.5, "no usable force", transform=axes.transAxes, ha="center", color=GREY)
    elif warning := RULES[summary.rule].warning(summary.n):
        banner = {"facecolor": "#FFF3D6", "edgecolor": ORANGE, "boxstyle": "round,pad=0.2", "linewidth": 0.8}
        axes.set_title(warning.split(" (")[0], fontsize=9, loc="left", bbox=banner)
    legend_below(axes)


def _draw_mean(axes: "Axes", summary: "ConditionSummary") -> None:
    mean_N = summary.mean_all_N
    if not np.isfinite(mean_N):
        return
    axes.axhline(mean_N, color=BLUE, linewidth=1.2, label=f"mean of all, {mean_N:.4g} N")
    std_N = summary.std_all_N
    if np.isfinite(std_N) and std_N > 0:
        axes.axhspan(
            mean_N - 2 * std_N,
            mean_N + 2 * std_N,
            color=BLUE,
            alpha=0.10,
            linewidth=0,
            label=f"±2s of all, s = {std_N:.3g} N",
        )


def _draw_value(axes: "Axes", order: int, trial: "TrialResult", color: Any, *, crowded: bool) -> None:
    std_N = trial.end_tension_std_N if trial.measures_slack else trial.peak_std_N
    axes.errorbar(
        order,
        trial.measured_N,
        yerr=std_N if np.isfinite(std_N) else None,
        fmt="D" if trial.excluded else "o",
        markersize=6,
        color=color,
        markerfacecolor=color if trial.kept else "white",
        markeredgecolor="black" if trial.kept else color,
        markeredgewidth=0.8 if trial.kept else 1.6,
        elinewidth=1.0,
        capsize=2.0,
        zorder=5,
        label="excluded" if trial.excluded else "kept" if trial.kept else "rejected",
    )
    reason = trial.excluded or (
        RULES[trial.rejected_by].label if trial.rejected_by in RULES else trial.rejected_by
    )
    if reason and not trial.kept:
        axes.annotate(
            shorten(reason, _LONGEST_REASON, placeholder=" …"),
            (order, trial.measured_N),
            xytext=(9.0, 0.0) if crowded else (0.0, 10.0),
            textcoords="offset points",
            ha="center",
            va="center" if crowded else "bottom",
            fontsize=8,
            color=GREY,
            rotation=90 if crowded else 0,
            zorder=6,
        )


def _draw_flag(axes: "Axes", order: int, trial: "TrialResult") -> None:
    on_axis = axes.get_xaxis_transform()
    axes.plot(
        order,
        0.03,
        "x",
        markersize=7,
        color=DARK_ORANGE,
        markeredgewidth=1.6,
        clip_on=False,
        transform=on_axis,
        label="flagged",
    )
    status = str(trial.breakaway.status)
    axes.text(
        order,
        0.07,
        status,
        rotation=90,
        fontsize=8,
        color=DARK_ORANGE,
        ha="center",
        va="bottom",
        transform=on_axis,
    )
