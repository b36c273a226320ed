"""A campaign in figures: conditions with their repeatability, one recording, and a selection of them."""

import math
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from functools import partial
from pathlib import Path
from textwrap import shorten
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.ticker import MaxNLocator

from ropefric.arrays import FloatArray
from ropefric.files.folder import Folder, as_folder
from ropefric.glossary import counted
from ropefric.plotting import style
from ropefric.plotting.figure import DataTable, FigureWithData, Progress, drawing, start_drawing
from ropefric.traces.breakaway import Status
from ropefric.trials import numbers
from ropefric.trials.outliers import RULES
from ropefric.trials.result import BINS, ConditionSummary, Extraction, Outline, TrialResult

# Room for six-digit forces on the left and for three rows of legend below.
_MARGINS = {"left": 0.09, "right": 0.985, "top": 0.86, "bottom": 0.27, "wspace": 0.24}
_LONGEST_REASON = 24
_CROWDED = 6
"""Trials above which a reason is written upright, so that it does not run into its neighbours."""
_OF_TRACE = {"time_s": "time_s", "low_N": "low_N", "high_N": "high_N", "mean_N": "smoothed_N"}


def conditions_of(extraction: Extraction) -> dict[str, tuple[ConditionSummary, list[TrialResult]]]:
    """Return each condition of an extraction with its trials, by a file name (without suffix)."""
    by_name = {trial.trial: trial for trial in extraction.trials}
    found: dict[str, tuple[ConditionSummary, list[TrialResult]]] = {}
    for summary in extraction.conditions:
        trials = [by_name[name] for name in summary.trials]
        wheel_mm, _, wrap_deg, tension_N, symbol = _settings(summary, trials)
        stem = plain = f"Rw{wheel_mm}mm_phi{wrap_deg}deg_{symbol.replace('_', '')}{tension_N}N"
        n = 1
        while stem in found:
            stem = f"{plain}_{(n := n + 1)}"
        found[stem] = summary, trials
    return found


def _settings(summary: ConditionSummary, trials: Iterable[TrialResult]) -> tuple[str, ...]:
    """Return radii, wrap, and the tension that is known with its symbol, in the units people use at the rig."""
    slack = _measures_slack(trials)
    radii_mm = 1e3 * summary.wheel_radius_m, 1e3 * summary.rope_radius_m
    known_N = summary.lift_force_N if slack else summary.end_tension_N
    values = (*radii_mm, math.degrees(summary.wrap_angle_rad), known_N)
    return (*(f"{value:.6g}" for value in values), "F_A" if slack else "F_B")


def start_condition_figures(
    extraction: Extraction,
    folder: Folder | str | os.PathLike[str],
    *,
    under: str = "",
    executor: Executor | None = None,
) -> Callable[[Progress | None], dict[str, tuple[str, tuple[Path, ...]]]]:
    """Begin to draw each condition of an extraction, see `start_drawing`; return what writes the figures."""
    drawings = {stem: partial(draw_condition, *item) for stem, item in conditions_of(extraction).items()}
    return start_drawing(drawings, as_folder(folder), executor, under=under)


def draw_condition(summary: ConditionSummary, trials: Sequence[TrialResult]) -> FigureWithData:
    """Return the figure of one condition: its traces on the left, the repeatability of the force on the right.

    The repeatability: force by trial, mean and ±2s band, trials set aside with the reason.
    """
    wheel_mm, rope_mm, wrap_deg, tension_N, symbol = _settings(summary, trials)
    title = style.typeset(
        f"R_w = {wheel_mm} mm,  R_r = {rope_mm} mm,  φ = {wrap_deg}°,  {symbol} = {tension_N} N"
    )
    colors = style.shades(len(trials))
    with drawing(10.0, 5.0, margins=_MARGINS, ncols=2, width_ratios=(3, 2)) as (figure, panels):
        for axes, left in zip(panels, (-0.1, -0.16), strict=True):
            # Where they have room in any case: to look for it, matplotlib sets the numbers at the axes thrice.
            axes.xaxis.set_label_coords(0.5, -0.09)
            axes.yaxis.set_label_coords(left, 0.5)
            axes.set_title("", y=1.0)  # likewise
        _draw_traces(panels[0], trials, colors)
        _draw_strip(panels[1], summary, trials, colors)
        figure.suptitle(f"{title}   —   {summary.n_kept} of {summary.n_recorded} trials kept")
    tables = _trial_table(trials), _trace_table(trials)
    return FigureWithData(figure, tables, _in_words(summary, style.plain_text(title), trials))


def _trial_table(trials: Sequence[TrialResult]) -> DataTable:
    """Return the drawn numbers of each trial, as in its row."""
    names = ["trial", "file", "peak_N", "peak_std_N", "end_tension_N", "peak_time_s"]
    names += [column.name for column in numbers.COLUMNS if column.drawn]
    names += ["status", "kept", "rejected_by", "excluded"]
    return DataTable({name: [*map(numbers.column(name).taken, trials)] for name in names})


def _in_words(summary: ConditionSummary, title: str, trials: Sequence[TrialResult]) -> str:
    where, n = title.replace(",  ", ", "), counted(summary.n_recorded, "trial")
    if not math.isfinite(summary.mean_all_N):
        return f"{where}: no usable force in {n}."
    force = "end tension" if _measures_slack(trials) else "break-away force"
    text = f"{where}: {force} {summary.mean_all_N:.4g} N on average over {counted(summary.n, 'usable trial')}"
    if math.isfinite(summary.std_all_N):
        text += f", sample standard deviation {summary.std_all_N:.3g} N"
    text += f"; {summary.n_kept} of {n} kept"
    if summary.rejected:
        text += f", {', '.join(summary.rejected)} set aside by the rule {summary.rule}"
    return f"{text}."


def _measures_slack(trials: Iterable[TrialResult]) -> bool:
    return any(trial.measures_slack for trial in trials)


def _trace_table(trials: Sequence[TrialResult]) -> DataTable:
    shown = _recordings_of(trials)
    columns = {"trial": [trial.trial for trial in shown for _ in trial.outline.time_s]}
    for heading, name in _OF_TRACE.items():
        columns[heading] = [value for trial in shown for value in getattr(trial.outline, name).tolist()]
    return DataTable(columns, "traces")


def _recordings_of(trials: Sequence[TrialResult]) -> list[Any]:
    """Return the first trial of each recording that could be read: stick-slip and held recordings hold several."""
    first = {(trial.file, trial.sample): trial for trial in reversed(trials)}
    return [trial for trial in reversed(first.values()) if trial.outline is not None]


def _is_usable(trial: TrialResult) -> bool:
    return trial.breakaway.status is Status.OK


def _draw_traces(axes: Axes, trials: Sequence[TrialResult], colors: Sequence[Any]) -> None:
    """Draw the recordings with the forces picked from them and the band of their sliding forces."""
    axes.set(xlabel=style.figure_label("time_s"), ylabel=style.figure_label("force_N"))
    recordings = _recordings_of(trials)
    if not recordings:
        style.say_instead(axes, "no recording could be read")
        return
    color_of = {trial.trial: color for trial, color in zip(trials, colors, strict=True)}
    outlines = [trial.outline for trial in recordings]
    _draw_outlines(
        axes, outlines, [color_of[one.trial] if _is_usable(one) else style.GREY for one in recordings]
    )
    if usable := [trial for trial in trials if _is_usable(trial)]:
        _draw_picks(axes, usable, [color_of[one.trial] for one in usable])
    _frame_means(axes, outlines)
    style.legend_below(axes)


def _draw_outlines(axes: Axes, outlines: Sequence[Outline], looks: Sequence[Any]) -> None:
    around = [(np.r_[o.time_s, o.time_s[::-1]], np.r_[o.low_N, o.high_N[::-1]]) for o in outlines]
    envelopes = [np.column_stack(one) for one in around]
    means = [np.column_stack([o.time_s, o.smoothed_N]) for o in outlines]
    label = "recorded, min to max"
    axes.add_collection(PolyCollection(envelopes, facecolors=looks, alpha=0.25, linewidths=0, label=label))
    axes.add_collection(LineCollection(means, colors=looks, linewidths=0.8, label="recorded, mean", zorder=2))
    axes.autoscale_view()


def _draw_picks(axes: Axes, usable: Sequence[TrialResult], inks: Sequence[Any]) -> None:
    """Draw the forces picked, and the band of each level that a trial's numbers have."""
    time_s, force_N = [one.breakaway.peak_time_s for one in usable], [one.measured_N for one in usable]
    label = style.typeset("plateau F_B" if usable[0].measures_slack else "break-away force F_A")
    axes.scatter(time_s, force_N, s=36, c=inks, label=label, edgecolors="black", linewidths=0.8, zorder=5)
    levels: dict[str, list[float]] = {}
    for trial in usable:
        for column, one_N in numbers.levels_drawn(trial):
            levels.setdefault(f"{column.drawn} force {column.symbol}", []).append(one_N)
    for words, level_N in levels.items():
        low_N, high_N = min(level_N), max(level_N)
        limits = f"{low_N:.4g} N" if len(level_N) == 1 else f"{low_N:.4g} to {high_N:.4g} N"
        label = style.typeset(f"{words}, {limits}")
        axes.axhspan(low_N, high_N, color=style.ORANGE, alpha=0.25, linewidth=0.8, zorder=0.5, label=label)


def _frame_means(axes: Axes, outlines: Sequence[Outline]) -> None:
    """Frame the means: a spike of one sample must not squeeze everything else flat, nor go unsaid."""
    low_N = min(float(outline.smoothed_N.min()) for outline in outlines)
    high_N = max(float(outline.smoothed_N.max()) for outline in outlines)
    margin_N = 0.08 * (high_N - low_N) or 1.0
    bottom_N, top_N = low_N - margin_N, high_N + 2.0 * margin_N
    axes.set_ylim(bottom_N, top_N)
    ends_N = min(float(o.low_N.min()) for o in outlines), max(float(o.high_N.max()) for o in outlines)
    beyond = [f"{force:.4g} N" for force in ends_N if not bottom_N <= force <= top_N]
    if beyond:
        text = f"single samples as far as {' and '.join(beyond)} lie outside the frame"
        axes.set_title(text, fontsize=9, color=style.GREY, loc="left")


def _draw_strip(
    axes: Axes, summary: ConditionSummary, trials: Sequence[TrialResult], colors: Sequence[Any]
) -> None:
    r"""Draw the measured force of each trial in order, the mean and the ±2s band of all of them.

    Rejected trials are hollow, trials the user excluded are hollow diamonds, both with the reason; flagged
    recordings are crosses on the axis with their status. A banner warns if too few trials were measured to
    reject any.
    """
    quantity = "end_tension_N" if _measures_slack(trials) else "peak_N"
    axes.set(xlabel="Trial, in order of recording", ylabel=style.figure_label(quantity))
    axes.set_xlim(0.4, max(len(trials), 1) + 0.6)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.margins(y=0.15)
    mean_N, std_N = summary.mean_all_N, summary.std_all_N
    if math.isfinite(mean_N):
        axes.axhline(mean_N, color=style.BLUE, linewidth=1.2, label=f"mean of all, {mean_N:.4g} N")
    if math.isfinite(std_N) and std_N > 0:
        label = f"±2s of all, s = {std_N:.3g} N"
        axes.axhspan(
            mean_N - 2 * std_N, mean_N + 2 * std_N, color=style.BLUE, alpha=0.10, linewidth=0, label=label
        )
    numbered = list(zip(range(1, len(trials) + 1), trials, colors, strict=True))
    usable = [one for one in numbered if _is_usable(one[1])]
    _draw_values(axes, usable)
    for order, trial, _ in usable:
        if trial.kept:
            continue
        why = trial.excluded or RULES[trial.rejected_by].label
        reason = shorten(why, _LONGEST_REASON, placeholder=" …")
        point = (order, trial.measured_N)
        upright: dict[str, Any] = {"right": 9.0, "va": "center", "rotation": 90}
        where = upright if len(trials) > _CROWDED else {"up": 10.0}
        style.note_at(axes, reason, point, color=style.GREY, zorder=6, **where)
    _draw_flags(axes, {order: trial for order, trial, _ in numbered if not _is_usable(trial)})
    if not usable:
        axes.text(0.5, 0.5, "no usable force", transform=axes.transAxes, ha="center", color=style.GREY)
    elif warning := RULES[summary.rule].warning(summary.n):
        ink = {"facecolor": "#FFF3D6", "edgecolor": style.ORANGE, "linewidth": 0.8}
        banner = ink | {"boxstyle": "round,pad=0.2"}
        axes.set_title(warning.split(" (")[0], fontsize=9, loc="left", bbox=banner)
    style.legend_below(axes)


def _draw_values(axes: Axes, usable: Sequence[tuple[int, TrialResult, Any]]) -> None:
    """Draw the measured forces with their standard uncertainties; trials that are treated alike in one go."""
    for fate, marker in (("kept", "o"), ("rejected", "o"), ("excluded", "D")):
        mine = [one for one in usable if one[1].outcome == fate]
        if mine:
            order, trials, colors = zip(*mine, strict=True)
            ink: dict[str, Any] = {"facecolors": colors, "edgecolors": "black", "linewidths": 0.8}
            hollow: dict[str, Any] = {"facecolors": "white", "edgecolors": colors, "linewidths": 1.6}
            forces_N = [trial.measured_N for trial in trials]
            look = ink if fate == "kept" else hollow
            axes.scatter(order, forces_N, s=36, marker=marker, zorder=5, label=fate, **look)
    bars = []
    for place, trial, color in usable:
        std_N = trial.end_tension_std_N if trial.measures_slack else trial.peak_std_N
        bars += [(place, trial.measured_N, std_N, color)] if np.isfinite(std_N) else []
    if bars:
        places, force_N, half_N, inks = (list(column) for column in zip(*bars, strict=True))
        low_N, high_N = np.subtract(force_N, half_N), np.add(force_N, half_N)
        axes.vlines(places, low_N, high_N, colors=inks, linewidth=1.0, zorder=4.9)
        tick: dict[str, Any] = {"marker": "_", "linewidths": 1.0, "zorder": 4.9}
        axes.scatter(2 * places, [*low_N, *high_N], s=16, c=2 * inks, **tick)


def _draw_flags(axes: Axes, flagged: dict[int, TrialResult]) -> None:
    if not flagged:
        return
    look: dict[str, Any] = {"color": style.DARK_ORANGE, "transform": axes.get_xaxis_transform()}
    cross = {"markersize": 7, "markeredgewidth": 1.6, "clip_on": False, "label": "flagged"}
    axes.plot([*flagged], [0.03] * len(flagged), "x", **look | cross)
    for order, trial in flagged.items():
        words = str(trial.breakaway.status)
        axes.text(order, 0.07, words, rotation=90, fontsize=8, ha="center", va="bottom", **look)


ACROSS, DOWN = 8, 12
"""Small multiples beside and above each other in one figure."""
MOST = 960
"""Largest number of recordings drawn: a page with more takes long to open."""
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
    with drawing(5.2, 4.3) as (figure, axes):
        axes.set(xlabel=style.figure_label("time_s"), ylabel=style.figure_label("force_N"))
        if outline is None:
            style.say_instead(axes, "the recording could not be read")
        else:
            band: dict[str, Any] = {"label": "recorded, min to max", "color": style.BLUE, "alpha": 0.25}
            axes.fill_between(outline.time_s, outline.low_N, outline.high_N, linewidth=0, **band)
            axes.plot(outline.time_s, outline.smoothed_N, color=style.BLUE, linewidth=1.0, label="its mean")
        for column, level_N in numbers.levels_drawn(trial):
            text = f"{column.drawn} force {column.symbol} = {level_N:.4g} N"
            look: dict[str, Any] = {"color": style.DARK_ORANGE, "linestyle": "--", "linewidth": 1.2}
            axes.axhline(level_N, label=style.typeset(text), **look)
        if math.isfinite(found.peak_N):
            symbol = "F_B" if trial.measures_slack else "F_A"
            label = style.typeset(f"picked: {symbol} = {found.peak_N:.4g} N")
            at = (found.peak_time_s, found.peak_N)
            axes.plot(*at, "o", color=style.ORANGE, markeredgecolor="black", label=label, zorder=5)
        axes.set_title(f"{trial.trial}, {trial.outcome}", fontsize=9)
        style.legend_of_figure(figure, columns=2)
    names = ("time_s", "low_N", "high_N", "smoothed_N")
    columns = {name: getattr(outline, name, ()) for name in names}
    levels = (
        f", {one.drawn} at {style.shown(one.taken(trial), 'N')}" for one in numbers.COLUMNS if one.drawn
    )
    alt = (
        f"The recording {trial.trial}: picked {style.shown(found.peak_N, 'N')} at "
        f"{style.shown(found.peak_time_s, 's')}{''.join(levels)}."
    )
    return FigureWithData(figure, (DataTable(columns),), alt)


def typical_trial(extraction: Extraction, number: int) -> TrialResult | None:
    """Return the kept trial of a condition, or of the first that has one, whose force is closest to their mean.

    One with bumps, spikes or hum is typical only where all have them.
    """
    by_name = {trial.trial: trial for trial in extraction.trials}
    for item in (*extraction.conditions[max(number - 1, 0) : number], *extraction.conditions):
        kept = [by_name[name] for name in item.trials if by_name[name].kept and by_name[name].outline]
        if kept:
            more = {t.trial: bool(t.breakaway.events or t.breakaway.notes) for t in kept}
            return min(kept, key=lambda t: (more[t.trial], abs(t.measured_N - item.mean_kept_N)))
    return None


def selected_trials(extraction: Extraction) -> tuple[TrialResult, ...]:
    """Return the trials that are not kept or have a remark, and a typical one of each condition, in their order."""
    found = (typical_trial(extraction, number + 1) for number in range(len(extraction.conditions)))
    typical = {one.trial for one in found if one is not None}
    return tuple(t for t in extraction.trials if t.trial in typical or not t.kept or t.problems)


def draw_extraction(extraction: Extraction) -> FigureWithData:
    """Return the first page of the selected recordings of a campaign."""
    return draw_recordings(next(pages_of_recordings(selected_trials(extraction)), ()))


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

    All share one pair of axes, each in a cell of one by one: many pairs of axes would take many times as long.
    """
    down = max(math.ceil(len(trials) / ACROSS), 1)
    high_inch = 0.42 + 0.92 * down
    # Room for a row of legend, whatever the height.
    margins = {"left": 0.005, "right": 0.995, "top": 1.0, "bottom": 0.4 / high_inch}
    with drawing(10.0, high_inch, margins=margins) as (figure, axes):
        axes.set(xlim=(0.0, ACROSS), ylim=(down, 0.0))
        axes.set_axis_off()
        corners = [divmod(place, ACROSS) for place in range(len(trials))]
        drawn = [_draw_cell(axes, trial, *corner) for trial, corner in zip(trials, corners, strict=True)]
        for fate, look in _FATES.items():
            alike = [one for one, trial in zip(drawn, trials, strict=True) if trial.outcome == fate]
            curves = [curve for curve, _ in alike if curve.size]
            axes.add_collection(LineCollection(curves, colors=look["color"], linewidths=0.7))
            if curves:  # a label of its own, also where nothing has a mark
                x, y = np.concatenate([pick for _, pick in alike]).T
                edge = {} if look["marker"] == "x" else {"edgecolors": "black"}
                mark = {"marker": look["marker"], "c": look["color"], "linewidths": 0.5, "zorder": 4, **edge}
                axes.scatter(x, y, s=14, label=fate, **mark)
        style.legend_of_figure(figure)
    names = ("trial", "file", "measured_N", "outcome", "breakaway.peak_time_s")
    without = sum(trial.outcome == "without a force" for trial in trials)
    first, last = (trials[0].trial, trials[-1].trial) if trials else ("", "")
    alt = f"{counted(len(trials), 'recording')}, {first} to {last}, each with its pick; {without} without a force."
    return FigureWithData(figure, (DataTable.of(trials, names),), alt)


def _draw_cell(axes: Axes, trial: TrialResult, row: int, column: int) -> tuple[FloatArray, FloatArray]:
    """Write name and numbers of a recording into its cell; return its curve (n, 2) and its pick (0 or 1, 2)."""
    usable = trial.outcome != "without a force"
    head = f"{trial.measured_N:.4g} N" if usable else str(trial.breakaway.status)
    ink = _FATES[trial.outcome]["color"] if trial.outcome != "kept" else style.INK
    axes.text(column, row + 0.13, _short(trial.trial, 18), color=style.INK, fontsize=6.5)
    axes.text(column + _WIDE, row + 0.27, head, color=ink, fontsize=6.5, ha="right", weight="bold")
    if trial.outline is None:
        return np.empty((0, 2)), np.empty((0, 2))
    curve, pick, numbers = _in_cell(trial, trial.outline)
    for x, y, text, ha in numbers:
        axes.text(column + x, row + y, text, ha=ha, color=style.GREY, fontsize=5.5)
    picks = np.array([pick] if usable and pick is not None else []).reshape(-1, 2)
    corner = np.array([column, row])
    return curve + corner, picks + corner


def _short(name: str, most: int) -> str:
    """Return a name that is too long without its middle: names differ at their ends."""
    half = (most - 1) // 2
    return name if len(name) <= most else f"{name[: most - 1 - half]}…{name[-half:]}"


def _in_cell(
    trial: TrialResult, outline: Outline
) -> tuple[FloatArray, tuple[float, float] | None, list[tuple[float, float, str, str]]]:
    """Return a recording's curve in its cell, its pick, and the numbers at its ends: x, y, text, side."""
    parts = np.array_split(np.arange(outline.time_s.size), min(_BINS, outline.time_s.size))
    # Highest and lowest mean of each stretch in the order they come, so that no peak is lost.
    ends = ((force_N.argmin(), force_N.argmax()) for force_N in (outline.smoothed_N[part] for part in parts))
    picked = [int(part[i]) for part, pair in zip(parts, ends, strict=True) for i in sorted({*pair})]
    time_s, force_N = outline.time_s[picked], outline.smoothed_N[picked]
    low_N, high_N = float(force_N.min()), float(force_N.max())
    start_s, long_s = float(outline.time_s[0]), float(np.ptp(outline.time_s)) or 1.0

    def placed(at_s: Any, at_N: Any) -> tuple[Any, Any]:
        up = (at_N - low_N) / ((high_N - low_N) or 1.0)
        return 0.02 + (_WIDE - 0.02) * (at_s - start_s) / long_s, 0.86 - 0.5 * up

    found = trial.breakaway
    digits = max(0, 2 - math.floor(math.log10(max(high_N - low_N, 1e-3))))
    ends_N = (
        round(end_N, digits) + 0.0 for end_N in (float(outline.low_N.min()), float(outline.high_N.max()))
    )
    # The times are those of the middles of the bins: half a bin is missing at each end.
    whole_s = long_s * (1.0 + (outline.time_s.size == BINS) / (BINS - 1))
    inside = start_s <= found.peak_time_s <= start_s + long_s and math.isfinite(found.peak_N)
    numbers = [
        (0.0, 0.97, " to ".join(f"{end_N:.{digits}f}" for end_N in ends_N) + " N", "left"),
        (_WIDE, 0.97, f"{whole_s:.3g} s", "right"),
    ]
    pick = placed(found.peak_time_s, min(max(found.peak_N, low_N), high_N)) if inside else None
    return np.column_stack(placed(time_s, force_N)), pick, numbers
