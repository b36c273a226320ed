"""The conditions of a campaign: the recordings of each, and how well their forces repeat; one file a condition."""

import math
import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor, as_completed
from pathlib import Path
from textwrap import shorten
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.ticker import MaxNLocator

from ropefric.errors import UnknownNameError
from ropefric.files.folder import Folder, as_folder
from ropefric.glossary import counted
from ropefric.plotting.figure import (
    DataTable,
    FigureWithData,
    figure_files,
    forget_fonts,
    legend_below,
    new_figure,
    say_instead,
)
from ropefric.plotting.labels import figure_label, plain_text, typeset
from ropefric.plotting.style import BLUE, DARK_ORANGE, GREY, ORANGE, TRACE_COLORS, house_style
from ropefric.registry import did_you_mean
from ropefric.traces.breakaway import Status
from ropefric.trials.outliers import RULES
from ropefric.trials.result import ConditionSummary, Extraction, Outline, TrialResult

if TYPE_CHECKING:
    from matplotlib.axes import Axes


# Room for six-digit forces on the left and for three rows of legend below.
_MARGINS = {"left": 0.09, "right": 0.985, "top": 0.86, "bottom": 0.27, "wspace": 0.24}
_LONGEST_REASON = 24
_CROWDED = 6
"""Trials above which a reason is written upright, so that it does not run into its neighbours."""

Condition = tuple[str, ConditionSummary, list[TrialResult]]
Progress = Callable[[int, int, str], None]


def conditions_of(extraction: Extraction) -> list[Condition]:
    """Return each condition of an extraction with a file name (without suffix), all different, and its trials."""
    by_name = {trial.trial: trial for trial in extraction.trials}
    seen: dict[str, int] = {}
    found = []
    for summary in extraction.conditions:
        trials = [by_name[name] for name in summary.trials]
        stem = condition_stem(summary, measures_slack=_measures_slack(trials))
        seen[stem] = seen.get(stem, 0) + 1
        found.append((stem if seen[stem] == 1 else f"{stem}_{seen[stem]}", summary, trials))
    return found


def condition_stem(summary: ConditionSummary, *, measures_slack: bool) -> str:
    """Return a condition as a file name without suffix, in the units people use at the rig."""
    wheel_mm, _, wrap_deg, tension_N, symbol = _settings(summary, measures_slack=measures_slack)
    return f"Rw{wheel_mm}mm_phi{wrap_deg}deg_{symbol.replace('_', '')}{tension_N}N"


def condition_title(summary: ConditionSummary, *, measures_slack: bool) -> str:
    """Return a condition for a figure's title, in the units people use at the rig."""
    wheel_mm, rope_mm, wrap_deg, tension_N, symbol = _settings(summary, measures_slack=measures_slack)
    return typeset(f"R_w = {wheel_mm} mm,  R_r = {rope_mm} mm,  φ = {wrap_deg}°,  {symbol} = {tension_N} N")


def _settings(summary: ConditionSummary, *, measures_slack: bool) -> tuple[str, ...]:
    known_N = summary.lift_force_N if measures_slack else summary.end_tension_N
    values = (
        1e3 * summary.wheel_radius_m,
        1e3 * summary.rope_radius_m,
        math.degrees(summary.wrap_angle_rad),
        known_N,
    )
    return (*(f"{value:.6g}" for value in values), "F_A" if measures_slack else "F_B")


def _measures_slack(trials: Iterable[TrialResult]) -> bool:
    return any(trial.measures_slack for trial in trials)


def write_condition_figures(
    extraction: Extraction,
    folder: Folder | str | os.PathLike[str],
    *,
    under: str = "",
    formats: tuple[str, ...] = ("png",),
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> tuple[Path, ...]:
    """Draw each condition of an extraction into `folder`; return the paths written, condition by condition."""
    return start_condition_figures(extraction, folder, under=under, formats=formats, executor=executor)(
        progress
    )


def start_condition_figures(
    extraction: Extraction,
    folder: Folder | str | os.PathLike[str],
    *,
    under: str = "",
    formats: tuple[str, ...] = ("png",),
    executor: Executor | None = None,
) -> Callable[[Progress | None], tuple[Path, ...]]:
    """Begin to draw each condition of an extraction, if there is an executor; return what writes the figures."""
    target = as_folder(folder)
    jobs = [
        (summary, trials, f"{under}{stem}", formats) for stem, summary, trials in conditions_of(extraction)
    ]
    if executor is not None:
        forget_fonts()  # the executor may fork here, and this process goes on drawing
    places = {executor.submit(_draw_one, *job): place for place, job in enumerate(jobs)} if executor else {}

    def write(progress: Progress | None = None) -> tuple[Path, ...]:
        drawn = (
            ((places[future], future.result()) for future in as_completed(places))
            if executor
            else ((place, _draw_one(*job)) for place, job in enumerate(jobs))
        )
        written: list[tuple[Path, ...]] = [()] * len(jobs)
        for done, (place, files) in enumerate(drawn, start=1):
            # Workers draw, and this process alone writes.
            written[place] = target.write(files)
            if progress is not None:
                progress(done, len(jobs), jobs[place][2].removeprefix(under))
        return tuple(path for paths in written for path in paths)

    return write


def _draw_one(
    summary: ConditionSummary, trials: list[TrialResult], stem: str, formats: tuple[str, ...]
) -> dict[str, bytes]:
    return figure_files(draw_condition(summary, trials), stem, formats=formats)


def draw_condition(summary: ConditionSummary, trials: Iterable[TrialResult]) -> FigureWithData:
    """Return the figure of one condition: its traces on the left, the repeatability of the force on the right."""
    return _draw(summary, trials, with_traces=True)


def draw_repeatability(summary: ConditionSummary, trials: Iterable[TrialResult]) -> FigureWithData:
    """Return the repeatability strip of one condition: force by trial, mean and ±2s band, what was set aside and why."""
    return _draw(summary, trials, with_traces=False)


def _draw(summary: ConditionSummary, trials: Iterable[TrialResult], *, with_traces: bool) -> FigureWithData:
    chosen = _trials_of(summary, trials)
    scale = colormaps[TRACE_COLORS]
    # The palest end of the map is left out, it drowns on white paper.
    colors = [scale(0.85 * i / max(len(chosen) - 1, 1)) for i in range(len(chosen))]
    title = condition_title(summary, measures_slack=_measures_slack(chosen))
    with house_style():
        figure = new_figure(margins=_MARGINS if with_traces else None)
        panels = figure.subplots(1, 2, width_ratios=(3, 2)) if with_traces else [figure.subplots()]
        if with_traces:
            for axes, left in zip(panels, (-0.1, -0.16), strict=True):
                # Where they have room in any case: to look for it, matplotlib sets the numbers at the axes thrice.
                axes.xaxis.set_label_coords(0.5, -0.09)
                axes.yaxis.set_label_coords(left, 0.5)
            _draw_traces(panels[0], chosen, colors)
        _draw_strip(panels[-1], summary, chosen, colors)
        figure.suptitle(f"{title}   —   {summary.n_kept} of {summary.n_recorded} trials kept")
    tables = (_trial_table(chosen), *([_trace_table(chosen)] if with_traces else []))
    return FigureWithData(figure=figure, tables=tables, alt=_in_words(summary, title, chosen))


def _trials_of(summary: ConditionSummary, trials: Iterable[TrialResult]) -> list[TrialResult]:
    """Return the results of a condition's trials, in its order."""
    by_name = {trial.trial: trial for trial in trials}
    for name in summary.trials:
        if name not in by_name:
            raise UnknownNameError(
                f"the condition has a trial {name!r} without a result", fix=did_you_mean(name, by_name)
            )
    return [by_name[name] for name in summary.trials]


def _in_words(summary: ConditionSummary, title: str, trials: Sequence[TrialResult]) -> str:
    where = plain_text(title).replace(",  ", ", ")
    if not math.isfinite(summary.mean_all_N):
        return f"{where}: no usable force in {counted(summary.n_recorded, 'trial')}."
    force = "end tension" if _measures_slack(trials) else "break-away force"
    text = f"{where}: {force} {summary.mean_all_N:.4g} N on average over {counted(summary.n, 'usable trial')}"
    if math.isfinite(summary.std_all_N):
        text += f", sample standard deviation {summary.std_all_N:.3g} N"
    text += f"; {summary.n_kept} of {counted(summary.n_recorded, 'trial')} kept"
    if summary.rejected:
        text += f", {', '.join(summary.rejected)} set aside by the rule {summary.rule}"
    return f"{text}."


def _trial_table(trials: Sequence[TrialResult]) -> DataTable:
    own = ("trial", "file", "peak_N", "peak_std_N", "end_tension_N", "kept", "rejected_by", "excluded")
    found = {name: [getattr(trial, name) for trial in trials] for name in own}
    picked = {
        name: [getattr(trial.breakaway, name) for trial in trials] for name in ("peak_time_s", "kinetic_N")
    }
    columns = found | picked | {"status": [str(trial.breakaway.status) for trial in trials]}
    order = (*own[:5], *picked, "status", *own[5:])
    return DataTable.of_columns({name: columns[name] for name in order})


def _trace_table(trials: Sequence[TrialResult]) -> DataTable:
    rows: list[tuple[object, ...]] = []
    for trial, found in _recordings_of(trials):
        columns = np.column_stack([found.time_s, found.low_N, found.high_N, found.smoothed_N])
        rows += [(trial.trial, *row) for row in columns.tolist()]
    return DataTable(name="traces", header=("trial", "time_s", "low_N", "high_N", "mean_N"), rows=tuple(rows))


def _recordings_of(trials: Sequence[TrialResult]) -> list[tuple[TrialResult, Outline]]:
    """Return the first trial of each recording that could be read: stick-slip and held recordings hold several."""
    first = {(trial.file, trial.sample): trial for trial in reversed(trials)}
    return [(trial, trial.outline) for trial in reversed(first.values()) if trial.outline is not None]


def _is_usable(trial: TrialResult) -> bool:
    return trial.breakaway.status is Status.OK


def _draw_traces(axes: "Axes", trials: Sequence[TrialResult], colors: Sequence[Any]) -> None:
    """Draw the recordings with the forces picked from them and the band of their sliding forces."""
    axes.set(xlabel=figure_label("time_s"), ylabel=figure_label("force_N"))
    recordings = _recordings_of(trials)
    if not recordings:
        say_instead(axes, "no recording could be read")
        return
    color_of = {trial.trial: color for trial, color in zip(trials, colors, strict=True)}
    shades = [color_of[trial.trial] if _is_usable(trial) else GREY for trial, _ in recordings]
    outlines = [outline for _, outline in recordings]
    envelopes = [
        np.column_stack([np.r_[o.time_s, o.time_s[::-1]], np.r_[o.low_N, o.high_N[::-1]]]) for o in outlines
    ]
    means = [np.column_stack([o.time_s, o.smoothed_N]) for o in outlines]
    axes.add_collection(
        PolyCollection(envelopes, facecolors=shades, alpha=0.25, linewidths=0, label="recorded, min to max")
    )
    axes.add_collection(
        LineCollection(means, colors=shades, linewidths=0.8, label="recorded, mean", zorder=2)
    )
    axes.autoscale_view()
    usable = [trial for trial in trials if _is_usable(trial)]
    if usable:
        axes.scatter(
            [trial.breakaway.peak_time_s for trial in usable],
            [trial.measured_N for trial in usable],
            s=36,
            c=[color_of[trial.trial] for trial in usable],
            edgecolors="black",
            linewidths=0.8,
            zorder=5,
            label=typeset("plateau F_B" if usable[0].measures_slack else "break-away force F_A"),
        )
    _draw_kinetic_band(axes, usable)
    _frame_means(axes, outlines)
    legend_below(axes)


def _draw_kinetic_band(axes: "Axes", usable: Sequence[TrialResult]) -> None:
    kinetic_N = np.array([trial.breakaway.kinetic_N for trial in usable])
    kinetic_N = kinetic_N[np.isfinite(kinetic_N)]
    if kinetic_N.size == 0:
        return
    low_N, high_N = float(kinetic_N.min()), float(kinetic_N.max())
    limits = f"{low_N:.4g} N" if kinetic_N.size == 1 else f"{low_N:.4g} to {high_N:.4g} N"
    label = typeset(f"sliding force F_k, {limits}")
    axes.axhspan(low_N, high_N, color=ORANGE, alpha=0.25, linewidth=0.8, zorder=0.5, label=label)


def _frame_means(axes: "Axes", outlines: Sequence[Outline]) -> None:
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


def _draw_strip(
    axes: "Axes", summary: ConditionSummary, trials: Sequence[TrialResult], colors: Sequence[Any]
) -> None:
    r"""Draw the measured force of each trial in order, the mean and the ±2s band of all of them.

    Rejected trials are hollow, trials the user excluded are hollow diamonds, both with the reason; flagged
    recordings stand as crosses on the axis with their status. A banner says where too few were measured to reject
    any.
    """
    axes.set(
        xlabel="Trial, in order of recording",
        ylabel=figure_label("end_tension_N" if _measures_slack(trials) else "peak_N"),
        xlim=(0.4, max(len(trials), 1) + 0.6),
    )
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.margins(y=0.15)
    _draw_mean(axes, summary)
    numbered = list(zip(range(1, len(trials) + 1), trials, colors, strict=True))
    usable = [one for one in numbered if _is_usable(one[1])]
    if usable:
        _draw_values(axes, usable)
        _draw_reasons(axes, usable, crowded=len(trials) > _CROWDED)
    _draw_flags(axes, [(order, trial) for order, trial, _ in numbered if not _is_usable(trial)])
    if not usable:
        axes.text(0.5, 0.5, "no usable force", transform=axes.transAxes, ha="center", color=GREY)
    elif warning := RULES[summary.rule].warning(summary.n):
        banner = {"facecolor": "#FFF3D6", "edgecolor": ORANGE, "boxstyle": "round,pad=0.2", "linewidth": 0.8}
        axes.set_title(warning.split(" (")[0], fontsize=9, loc="left", bbox=banner)
    legend_below(axes)


def _draw_mean(axes: "Axes", summary: ConditionSummary) -> None:
    mean_N, std_N = summary.mean_all_N, summary.std_all_N
    if not np.isfinite(mean_N):
        return
    axes.axhline(mean_N, color=BLUE, linewidth=1.2, label=f"mean of all, {mean_N:.4g} N")
    if np.isfinite(std_N) and std_N > 0:
        label = f"±2s of all, s = {std_N:.3g} N"
        axes.axhspan(mean_N - 2 * std_N, mean_N + 2 * std_N, color=BLUE, alpha=0.10, linewidth=0, label=label)


def _draw_values(axes: "Axes", usable: Sequence[tuple[int, TrialResult, Any]]) -> None:
    """Draw the measured forces with their standard uncertainties; trials that are treated alike in one go."""
    for label, marker in (("kept", "o"), ("rejected", "o"), ("excluded", "D")):
        mine = [(order, trial, color) for order, trial, color in usable if _fate(trial) == label]
        if not mine:
            continue
        colors, kept = [color for *_, color in mine], label == "kept"
        axes.scatter(
            [order for order, *_ in mine],
            [trial.measured_N for _, trial, _ in mine],
            s=36,
            marker=marker,
            facecolors=colors if kept else "white",
            edgecolors="black" if kept else colors,
            linewidths=0.8 if kept else 1.6,
            zorder=5,
            label=label,
        )
    bars = [
        (order, trial.measured_N, std_N, color)
        for order, trial, color in usable
        if np.isfinite(std_N := trial.end_tension_std_N if trial.measures_slack else trial.peak_std_N)
    ]
    if bars:
        order, force_N, half_N, ink = (list(column) for column in zip(*bars, strict=True))
        low_N, high_N = np.subtract(force_N, half_N), np.add(force_N, half_N)
        axes.vlines(order, low_N, high_N, colors=ink, linewidth=1.0, zorder=4.9)
        axes.scatter(2 * order, [*low_N, *high_N], s=16, c=2 * ink, marker="_", linewidths=1.0, zorder=4.9)


def _fate(trial: TrialResult) -> str:
    return "excluded" if trial.excluded else "kept" if trial.kept else "rejected"


def _draw_reasons(axes: "Axes", usable: Sequence[tuple[int, TrialResult, Any]], *, crowded: bool) -> None:
    for order, trial, _ in usable:
        rule = RULES[trial.rejected_by].label if trial.rejected_by in RULES else trial.rejected_by
        reason = trial.excluded or rule
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


def _draw_flags(axes: "Axes", flagged: Sequence[tuple[int, TrialResult]]) -> None:
    if not flagged:
        return
    on_axis = axes.get_xaxis_transform()
    axes.plot(
        [order for order, _ in flagged],
        [0.03] * len(flagged),
        "x",
        markersize=7,
        color=DARK_ORANGE,
        markeredgewidth=1.6,
        clip_on=False,
        transform=on_axis,
        label="flagged",
    )
    look: dict[str, Any] = {
        "rotation": 90,
        "fontsize": 8,
        "color": DARK_ORANGE,
        "ha": "center",
        "va": "bottom",
    }
    for order, trial in flagged:
        axes.text(order, 0.07, str(trial.breakaway.status), transform=on_axis, **look)
