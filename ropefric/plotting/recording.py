"""One recording: its phases, the force picked from it, and how near the converter was to its ceiling."""

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.glossary import counted
from ropefric.plotting.figure import DataTable, FigureWithData, new_figure
from ropefric.plotting.labels import figure_label, typeset
from ropefric.plotting.legend import legend_of_figure
from ropefric.plotting.style import BLUE, GREY, INK, ORANGE, house_style
from ropefric.plotting.tracepanel import draw_outline_of, frame_means
from ropefric.plotting.words import say_instead, shown
from ropefric.traces.breakaway import Breakaway, Phase, Status
from ropefric.traces.smoothing import smooth
from ropefric.traces.trace import ForceTrace
from ropefric.trials.recording import draw_outline
from ropefric.trials.result import Outline

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ropefric.traces.calibration import Calibration
    from ropefric.trials.result import TrialResult


# Light, darker, hatched: the phases can be told apart on grey paper too. Hatches are lines, which take little room in
# a file; each phase is named above, or in the legend where it is too short for its name.
_PHASES: dict[str, dict[str, str]] = {
    "idle": {"facecolor": "#FFFFFF", "edgecolor": "#C9C9C9"},
    "loading": {"facecolor": "#DCEBF5"},
    "break-away": {"facecolor": "#F3C3A4"},
    "sliding": {"facecolor": "#EFEFEF", "hatch": "\\\\", "edgecolor": "#C9C9C9"},
    "held": {"facecolor": "#DFF0E8", "hatch": "--", "edgecolor": "#BBD3C7"},
    "unloading": {"facecolor": "#F7F7F7", "hatch": "//", "edgecolor": "#D5D5D5"},
}
# Fixed, with room for six-digit forces and three rows of legend: a campaign has hundreds of recordings, and to find
# the room out takes half the drawing time.
_MARGINS = {"left": 0.085, "right": 0.925, "top": 0.86, "bottom": 0.28, "wspace": 0.42}
_NAMED_FROM = 0.1
_NEAR_CEILING = 0.5
_CLOSE_WINDOWS = 12.0
_CLOSE_SAMPLES = 40
_MOST_CLOSE = 1200


def draw_trial(trial: "TrialResult") -> FigureWithData:
    """Return the figure of a trial's recording from the outline its result carries; see `draw_recording`."""
    return draw_recording(
        trial.outline,
        trial.breakaway,
        name=trial.trial,
        calibration=trial.calibration,
        measures_slack=trial.measures_slack,
    )


def draw_recording(
    recording: ForceTrace | Outline | None,
    found: Breakaway,
    *,
    name: str = "",
    calibration: "Calibration | None" = None,
    measures_slack: bool = False,
) -> FigureWithData:
    """Return a recording with its phases shaded, the peak, the sliding force and the converter's ceiling.

    The recording is drawn as the smallest and largest sample of each of 300 stretches, so no peak is lost. Where the
    calibration is known, the axis on the right counts the converter's steps. With a whole trace, a second panel
    shows the samples around the peak and the smoothed force.
    """
    trace = recording if isinstance(recording, ForceTrace) else None
    outline = draw_outline(recording) if isinstance(recording, ForceTrace) else recording
    called = name or (trace.name if trace is not None else "recording")
    chain = calibration if calibration is not None or trace is None else trace.calibration
    close = _close_part(trace, found)
    force = "plateau F_B" if measures_slack else "break-away force F_A"
    tables = [_outline_table(outline), _phase_table(found), _picked_table(found, chain)]
    with house_style():
        figure = new_figure(10.0, 4.6, margins=_MARGINS)
        panels = figure.subplots(1, 2 if close else 1, squeeze=False, width_ratios=(3, 2) if close else None)[
            0
        ]
        panels[0].set(xlabel=figure_label("time_s"), ylabel=figure_label("force_N"))
        if outline is None:
            say_instead(panels[0], "the recording could not be read")
        else:
            _draw_whole(panels[0], outline, found, force, chain)
        if close:
            tables.append(_draw_close(panels[1], close, found, force))
        status = "" if found.status is Status.OK else f"   —   {found.status}: {found.detail or found.advice}"
        window = "" if np.isnan(found.window_s) else f"   —   smoothed over {1e3 * found.window_s:.3g} ms"
        figure.suptitle(f"{called}{window}{status}"[:110])
        legend_of_figure(figure, columns=4)
    return FigureWithData(figure=figure, tables=tuple(tables), alt=_alt(called, outline, found, force, chain))


def _draw_whole(
    axes: "Axes", outline: Outline, found: Breakaway, force: str, chain: "Calibration | None"
) -> None:
    draw_outline_of(axes, outline, BLUE)
    frame_means(axes, [outline])
    bottom_N, top_N = axes.get_ylim()
    if np.isfinite(found.peak_raw_N):
        top_N = max(top_N, found.peak_raw_N + 0.05 * (found.peak_raw_N - bottom_N))
    _draw_picked(axes, found, force)
    if chain is not None:
        top_N = _draw_ceiling(axes, chain, float(outline.high_N.max()), top_N)
    axes.set_ylim(bottom_N, top_N)
    axes.set_xlim(float(outline.time_s[0]), float(outline.time_s[-1]))
    _shade(axes, found.phases)


def _draw_picked(axes: "Axes", found: Breakaway, force: str) -> None:
    if np.isfinite(found.peak_N) and np.isfinite(found.peak_time_s):
        axes.plot(
            [found.peak_time_s],
            [found.peak_N],
            "o",
            markersize=7,
            markerfacecolor=ORANGE,
            markeredgecolor="black",
            zorder=5,
            label=typeset(f"{force} = {found.peak_N:.4g} N"),
        )
    if np.isfinite(found.kinetic_N):
        label = typeset(f"sliding force F_k = {found.kinetic_N:.4g} N")
        axes.axhline(found.kinetic_N, color=ORANGE, linestyle="--", linewidth=1.2, label=label)


def _draw_ceiling(axes: "Axes", chain: "Calibration", highest_N: float, top_N: float) -> float:
    """Draw the ceiling and the axis of counts; return how far up the frame has to reach."""
    ceiling_N, zero_N, step_N = chain.ceiling_N, chain.floor_N, chain.lsb_N

    def counts(force_N: npt.ArrayLike) -> FloatArray:
        return (np.asarray(force_N, dtype=np.float64) - zero_N) / step_N

    def forces(count: npt.ArrayLike) -> FloatArray:
        return np.asarray(count, dtype=np.float64) * step_N + zero_N

    right = axes.secondary_yaxis("right", functions=(counts, forces))
    right.set_ylabel(figure_label("counts"))
    label = f"converter's ceiling, {ceiling_N:.4g} N"
    if highest_N < _NEAR_CEILING * ceiling_N:
        axes.plot([], [], color=INK, linestyle=":", linewidth=1.6, label=f"{label}, far above")
        return top_N
    axes.axhline(ceiling_N, color=INK, linestyle=":", linewidth=1.6, label=label)
    return max(top_N, ceiling_N * 1.04)


def _shade(axes: "Axes", phases: tuple[Phase, ...]) -> None:
    left_s, right_s = axes.get_xlim()
    for phase in phases:
        look = _PHASES.get(phase.name, {"facecolor": "#FFFFFF"})
        named = phase.end_s - phase.start_s > _NAMED_FROM * (right_s - left_s)
        label = None if named else phase.name
        axes.axvspan(phase.start_s, phase.end_s, zorder=0.1, linewidth=0, label=label, **look)  # type: ignore[arg-type]
        if named:
            axes.text(
                0.5 * (phase.start_s + phase.end_s),
                1.01,
                phase.name,
                transform=axes.get_xaxis_transform(),
                ha="center",
                va="bottom",
                fontsize=8,
                color=GREY,
            )


def _close_part(
    trace: ForceTrace | None, found: Breakaway
) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """Return time, force and smoothed force around the peak; None where there is no peak to look at."""
    if trace is None or not np.isfinite(found.peak_time_s) or not np.isfinite(found.window_s):
        return None
    rate_Hz = trace.sampling_rate_Hz or 1.0
    reach_s = min(max(_CLOSE_WINDOWS * found.window_s, _CLOSE_SAMPLES / rate_Hz), _MOST_CLOSE / rate_Hz)
    near = np.abs(trace.time_s - found.peak_time_s) <= reach_s
    smoothed_N = smooth(trace, found.window_s).force_N
    return trace.time_s[near], trace.force_N[near], smoothed_N[near]


def _draw_close(
    axes: "Axes", close: tuple[FloatArray, FloatArray, FloatArray], found: Breakaway, force: str
) -> DataTable:
    time_s, force_N, smoothed_N = close
    axes.plot(time_s, force_N, ".", color=GREY, markersize=3, label="samples")
    axes.plot(time_s, smoothed_N, "-", color=BLUE, linewidth=1.4, label="smoothed")
    _draw_picked(axes, found, force)
    axes.set(xlabel=figure_label("time_s"), title="around the peak")
    return DataTable(
        name="close",
        header=("time_s", "force_N", "smoothed_N"),
        rows=tuple(zip(time_s.tolist(), force_N.tolist(), smoothed_N.tolist(), strict=True)),
    )


def _outline_table(outline: Outline | None) -> DataTable:
    header = ("time_s", "low_N", "high_N", "mean_N")
    if outline is None:
        return DataTable(header=header, rows=())
    columns = (outline.time_s, outline.low_N, outline.high_N, outline.smoothed_N)
    return DataTable(header=header, rows=tuple(zip(*(column.tolist() for column in columns), strict=True)))


def _phase_table(found: Breakaway) -> DataTable:
    rows = tuple((phase.name, phase.start_s, phase.end_s) for phase in found.phases)
    return DataTable(name="phases", header=("phase", "start_s", "end_s"), rows=rows)


def _picked_table(found: Breakaway, chain: "Calibration | None") -> DataTable:
    header = (
        "status",
        "peak_time_s",
        "peak_N",
        "peak_raw_N",
        "peak_std_N",
        "kinetic_N",
        "window_s",
        "ceiling_N",
    )
    numbers = tuple(float(getattr(found, name)) for name in header[1:-1])
    ceiling_N = np.nan if chain is None else chain.ceiling_N
    return DataTable(name="picked", header=header, rows=((str(found.status), *numbers, float(ceiling_N)),))


def _alt(
    called: str, outline: Outline | None, found: Breakaway, force: str, chain: "Calibration | None"
) -> str:
    if found.status is not Status.OK:
        why = f"{found.status}, {found.detail or found.advice}".rstrip(".")
        return f"Recording {called}: {why}." + ("" if outline is not None else " There is nothing to draw.")
    text = f"Recording {called}: {force} = {shown(found.peak_N, 'N')} at {shown(found.peak_time_s, 's')}"
    if np.isfinite(found.kinetic_N):
        text += f", sliding force {shown(found.kinetic_N, 'N')}"
    text += f"; {counted(len(found.phases), 'phase')}: {', '.join(phase.name for phase in found.phases) or 'none'}."
    return text if chain is None else f"{text} The converter's ceiling is at {shown(chain.ceiling_N, 'N')}."
