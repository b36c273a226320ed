"""Recordings of one condition over each other: what was measured, what was picked, the sliding force."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ropefric.plotting.labels import figure_label, typeset
from ropefric.plotting.legend import legend_below
from ropefric.plotting.style import GREY, ORANGE
from ropefric.traces.breakaway import Status

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ropefric.trials.result import Outline, TrialResult


def draw_traces(axes: "Axes", trials: "Sequence[TrialResult]", colors: Sequence[Any]) -> None:
    """Draw the recordings of `trials` with the forces picked from them and the band of their sliding forces."""
    axes.set(xlabel=figure_label("time_s"), ylabel=figure_label("force_N"))
    color_of = {trial.trial: color for trial, color in zip(trials, colors, strict=True)}
    outlines = []
    for trial in recordings_of(trials):
        if trial.outline is not None:
            outlines.append(trial.outline)
            usable = trial.breakaway.status == Status.OK
            draw_outline_of(axes, trial.outline, color_of[trial.trial] if usable else GREY)
    if not outlines:
        axes.text(0.5, 0.5, "no recording could be read", transform=axes.transAxes, ha="center", color=GREY)
        return
    for trial in trials:
        if trial.breakaway.status == Status.OK:
            _draw_picked(axes, trial, color_of[trial.trial])
    _draw_kinetic_band(axes, trials)
    frame_means(axes, outlines)
    legend_below(axes)


def recordings_of(trials: "Sequence[TrialResult]") -> "list[TrialResult]":
    """Return the first trial of each recording: stick-slip and held recordings hold several."""
    first = {(trial.file, trial.sample): trial for trial in reversed(trials)}
    return list(reversed(first.values()))


def draw_outline_of(axes: "Axes", outline: "Outline", color: Any) -> None:
    """Draw the min-max envelope and the means of one recording."""
    axes.fill_between(
        outline.time_s,
        outline.low_N,
        outline.high_N,
        color=color,
        alpha=0.25,
        linewidth=0,
        label="recorded, min to max",
    )
    axes.plot(outline.smoothed_time_s, outline.smoothed_N, color=color, linewidth=0.8, label="recorded, mean")


def _draw_picked(axes: "Axes", trial: "TrialResult", color: Any) -> None:
    axes.plot(
        trial.breakaway.peak_time_s,
        trial.measured_N,
        "o",
        markersize=6,
        markerfacecolor=color,
        markeredgecolor="black",
        markeredgewidth=0.8,
        zorder=5,
        label=typeset("plateau F_B" if trial.measures_slack else "break-away force F_A"),
    )


def _draw_kinetic_band(axes: "Axes", trials: "Sequence[TrialResult]") -> None:
    kinetic_N = np.array([t.breakaway.kinetic_N for t in trials if t.breakaway.status == Status.OK])
    kinetic_N = kinetic_N[np.isfinite(kinetic_N)]
    if kinetic_N.size == 0:
        return
    low_N, high_N = float(kinetic_N.min()), float(kinetic_N.max())
    limits = f"{low_N:.4g} N" if kinetic_N.size == 1 else f"{low_N:.4g} to {high_N:.4g} N"
    axes.axhspan(
        low_N,
        high_N,
        color=ORANGE,
        alpha=0.25,
        linewidth=0.8,
        zorder=0.5,
        label=typeset(f"sliding force F_k, {limits}"),
    )


def frame_means(axes: "Axes", outlines: "Sequence[Outline]") -> None:
    """Frame the means: a spike of one sample must not squeeze everything else flat, nor go unsaid."""
    means_N = np.concatenate([outline.smoothed_N for outline in outlines])
    low_N, high_N = float(means_N.min()), float(means_N.max())
    margin_N = 0.08 * (high_N - low_N) or 1.0
    bottom_N, top_N = low_N - margin_N, high_N + 2.0 * margin_N
    axes.set_ylim(bottom_N, top_N)
    lowest_N = min(float(outline.low_N.min()) for outline in outlines)
    highest_N = max(float(outline.high_N.max()) for outline in outlines)
    beyond = [f"{force:.4g} N" for force in (lowest_N, highest_N) if not bottom_N <= force <= top_N]
    if beyond:
        text = f"single samples as far as {' and '.join(beyond)} lie outside the frame"
        axes.set_title(text, fontsize=9, color=GREY, loc="left")
