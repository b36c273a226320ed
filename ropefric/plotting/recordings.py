"""Single recordings in figures: a typical one with its pick, and all of a campaign as small multiples."""

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.collections import LineCollection

from ropefric.arrays import FloatArray
from ropefric.glossary import counted
from ropefric.plotting import style
from ropefric.plotting.figure import DataTable, FigureWithData, drawing
from ropefric.trials.result import Outline, TrialResult

if TYPE_CHECKING:
    from matplotlib.axes import Axes


ACROSS, DOWN = 8, 12
"""Small multiples beside and above each other in one figure."""
MOST = 960
"""Recordings that are drawn at most: beyond, a page takes long to open, and nobody looks through it."""
_BINS = 44
_WIDE = 0.9
"""Of its cell of one by one, what a recording is wide."""
_FATES: dict[str, Any] = {
    "kept": {"color": style.BLUE, "marker": "o"},
    "rejected": {"color": style.DARK_ORANGE, "marker": "D"},
    "excluded": {"color": style.DARK_ORANGE, "marker": "s"},
    "without a force": {"color": style.GREY, "marker": "x"},
}


def draw_recording(trial: TrialResult) -> FigureWithData:
    """Return one recording: what was recorded, its mean, the break-away force picked from it, the force of sliding."""
    outline, found = trial.outline, trial.breakaway
    with drawing(5.2, 4.3) as figure:
        axes = figure.subplots()
        axes.set(xlabel=style.figure_label("time_s"), ylabel=style.figure_label("force_N"))
        if outline is None:
            style.say_instead(axes, "the recording could not be read")
        else:
            _draw_trace(axes, outline)
        if math.isfinite(found.kinetic_N):
            text = f"sliding force F_k = {found.kinetic_N:.4g} N"
            look: dict[str, Any] = {"color": style.DARK_ORANGE, "linestyle": "--", "linewidth": 1.2}
            axes.axhline(found.kinetic_N, label=style.typeset(text), **look)
        if math.isfinite(found.peak_N):
            symbol = "F_B" if trial.measures_slack else "F_A"
            label = style.typeset(f"picked: {symbol} = {found.peak_N:.4g} N")
            at = (found.peak_time_s, found.peak_N)
            axes.plot(*at, "o", color=style.ORANGE, markeredgecolor="black", label=label, zorder=5)
        axes.set_title(f"{trial.trial}, {trial.outcome}", fontsize=9)
        style.legend_of_figure(figure, columns=2)
    names = ("time_s", "low_N", "high_N", "smoothed_N")
    columns = {name: getattr(outline, name, ()) for name in names}
    alt = (
        f"The recording {trial.trial}: picked {style.shown(found.peak_N, 'N')} at "
        f"{style.shown(found.peak_time_s, 's')}, sliding at {style.shown(found.kinetic_N, 'N')}."
    )
    return FigureWithData(figure=figure, tables=(DataTable(columns),), alt=alt)


def _draw_trace(axes: "Axes", outline: Outline) -> None:
    label: dict[str, Any] = {"label": "recorded, min to max", "color": style.BLUE, "alpha": 0.25}
    axes.fill_between(outline.time_s, outline.low_N, outline.high_N, linewidth=0, **label)
    axes.plot(outline.time_s, outline.smoothed_N, color=style.BLUE, linewidth=1.0, label="its mean")


def pages_of_recordings(trials: Sequence[TrialResult]) -> Iterator[tuple[TrialResult, ...]]:
    """Give the trials that are drawn, in their order, as many at once as one figure shows.

    Of more than `MOST` those that do not count come first, then the first of the others.
    """
    chosen = [*trials]
    if len(chosen) > MOST:
        first = sorted(range(len(chosen)), key=lambda i: chosen[i].outcome == "kept")[:MOST]
        chosen = [chosen[i] for i in sorted(first)]
    for start in range(0, len(chosen), ACROSS * DOWN):
        yield tuple(chosen[start : start + ACROSS * DOWN])


def draw_recordings(trials: Sequence[TrialResult]) -> FigureWithData:
    """Return recordings as small multiples, each with its pick, its lowest and highest force, and its length.

    All stand in one pair of axes, a cell of one by one each: a hundred pairs of axes would take a hundred times as long.
    """
    down = max(math.ceil(len(trials) / ACROSS), 1)
    lines: dict[str, list[FloatArray]] = {fate: [] for fate in _FATES}
    picks: dict[str, list[tuple[float, float]]] = {fate: [] for fate in _FATES}
    with drawing(10.0, 0.42 + 0.92 * down, margins=_margins(down)) as figure:
        axes = figure.subplots()
        axes.set(xlim=(0.0, ACROSS), ylim=(down, 0.0))
        axes.set_axis_off()
        for place, trial in enumerate(trials):
            row, column = divmod(place, ACROSS)
            fate = trial.outcome
            usable = fate != "without a force"
            head = f"{trial.measured_N:.4g} N" if usable else str(trial.breakaway.status)
            ink = _FATES[fate]["color"] if fate != "kept" else style.INK
            _write(axes, column, row + 0.13, trial.trial[:16], color=style.INK, fontsize=6.5)
            _write(axes, column + _WIDE, row + 0.27, head, color=ink, fontsize=6.5, ha="right", weight="bold")
            if trial.outline is None:
                continue
            curve, pick, numbers = _in_cell(trial, trial.outline)
            lines[fate].append(curve + np.array([column, row]))
            if usable and pick is not None:
                picks[fate].append((pick[0] + column, pick[1] + row))
            for x, y, text, ha in numbers:
                _write(axes, column + x, row + y, text, ha=ha, color=style.GREY, fontsize=5.5)
        for fate, look in _FATES.items():
            # A label of its own for each, also where nothing has a mark.
            axes.add_collection(LineCollection(lines[fate], colors=look["color"], linewidths=0.7))
            if lines[fate] or picks[fate]:
                at = np.array(picks[fate]).reshape(-1, 2).T
                mark: dict[str, Any] = {"edgecolors": "black"} if look["marker"] != "x" else {}
                axes.scatter(
                    at[0],
                    at[1],
                    s=14,
                    marker=look["marker"],
                    c=look["color"],
                    label=fate,
                    linewidths=0.5,
                    zorder=4,
                    **mark,
                )
        style.legend_of_figure(figure)
    names = ("trial", "file", "measured_N", "outcome")
    columns = {name: [getattr(trial, name) for trial in trials] for name in names}
    columns["peak_time_s"] = [trial.breakaway.peak_time_s for trial in trials]
    without = sum(trial.outcome == "without a force" for trial in trials)
    first, last = (trials[0].trial, trials[-1].trial) if trials else ("", "")
    alt = f"{counted(len(trials), 'recording')}, {first} to {last}, each with its pick; {without} without a force."
    return FigureWithData(figure=figure, tables=(DataTable(columns),), alt=alt)


def _margins(down: int) -> dict[str, float]:
    """Return margins with room for a row of legend, whatever the height."""
    return {"left": 0.005, "right": 0.995, "top": 1.0, "bottom": 0.4 / (0.42 + 0.92 * down)}


def _write(axes: "Axes", x: float, y: float, text: str, **look: Any) -> None:
    axes.text(x, y, text, **{"va": "baseline"} | look)


def _in_cell(
    trial: TrialResult, outline: Outline
) -> tuple[FloatArray, tuple[float, float] | None, list[tuple[float, float, str, str]]]:
    """Return a recording's curve in its cell, its pick, and the numbers at its ends: x, y, text, side."""
    parts = np.array_split(np.arange(outline.time_s.size), min(_BINS, outline.time_s.size))
    # Highest and lowest mean of each stretch in the order they come, so that no peak is lost.
    picked = [
        i
        for part in parts
        for i in sorted(
            {int(part[outline.smoothed_N[part].argmin()]), int(part[outline.smoothed_N[part].argmax()])}
        )
    ]
    time_s, force_N = outline.time_s[picked], outline.smoothed_N[picked]
    low_N, high_N = float(force_N.min()), float(force_N.max())
    start_s, long_s = float(time_s[0]), float(time_s[-1] - time_s[0]) or 1.0

    def placed(at_s: Any, at_N: Any) -> tuple[Any, Any]:
        up = (at_N - low_N) / ((high_N - low_N) or 1.0)
        return 0.02 + (_WIDE - 0.02) * (at_s - start_s) / long_s, 0.86 - 0.5 * up

    found = trial.breakaway
    digits = max(0, 2 - math.floor(math.log10(max(high_N - low_N, 1e-3))))
    inside = start_s <= found.peak_time_s <= start_s + long_s and math.isfinite(found.peak_N)
    numbers = [
        (0.0, 0.97, f"{low_N:.{digits}f} to {high_N:.{digits}f} N", "left"),
        (_WIDE, 0.97, f"{long_s:.3g} s", "right"),
    ]
    pick = placed(found.peak_time_s, min(max(found.peak_N, low_N), high_N)) if inside else None
    return np.column_stack(placed(time_s, force_N)), pick, numbers
