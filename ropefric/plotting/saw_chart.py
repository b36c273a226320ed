"""A Campbell chart: the blade's modes and what shakes it over the blade's speed, meetings circled."""

import math
from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np

from ropefric.plotting.figure import DataTable, FigureWithData, legend_below, new_figure
from ropefric.plotting.style import BLUE, GREY, ORANGE, house_style
from ropefric.systems.bandsaw.saw import Side

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ropefric.systems.bandsaw.resonance import Crossing, Excitation, SawChart


MODE_HEADER = ("side", "mode", "speed_m_s", "frequency_Hz")
CROSSING_HEADER = ("side", "mode", "excitation", "harmonic", "speed_m_s", "frequency_Hz", "speed_margin")

_LOOK = {Side.TIGHT: (BLUE, "-"), Side.SLACK: (ORANGE, "--")}
_DASHES = ((0, (1, 1)), (0, (4, 2, 1, 2)), (0, (6, 2)), (0, (3, 1, 1, 1, 1, 1)))
# A written margin takes so much of the chart's width and height.
_LABEL_WIDTH, _LABEL_HEIGHT = 0.066, 0.032
_LABEL_OFFSET = 0.03
_MODE_LABELS_AT = 0.12
_BACKGROUND = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.4}


def draw_saw_chart(chart: "SawChart") -> FigureWithData:
    """Return a Campbell chart: frequencies of the modes of both sides over the blade's speed, and the excitations.

    Where a mode meets an excitation there is a circle; the number beside it says by how much the speed at work would
    have to change to get there. Where circles crowd, the numbers nearest to the speed at work are written; the
    table has all.
    """
    top_Hz = 1.08 * max(float(found.max()) for found in chart.mode_Hz.values())
    fastest_m_s = float(chart.speed_m_s[-1])
    with house_style():
        figure = new_figure(9.0, 6.5)
        axes = figure.subplots()
        axes.set(xlim=(float(chart.speed_m_s[0]), fastest_m_s), ylim=(0.0, top_Hz))
        axes.set(xlabel="Blade speed v [m/s]", ylabel="Frequency f [Hz]")
        axes.set_title(
            "Modes of the blade and what excites them; circles: resonance, at this change of speed", pad=18.0
        )
        _draw_modes(axes, chart)
        for excitation, dashes in zip(chart.excitations, cycle(_DASHES), strict=False):
            _draw_excitation(axes, excitation, chart, dashes, top_Hz)
        if chart.saw.speed_m_s > 0.0:
            axes.axvline(chart.saw.speed_m_s, color="black", linewidth=1.2, label="speed at work")
        _draw_crossings(axes, chart, top_Hz)
        legend_below(axes, columns=4)
    return FigureWithData(figure=figure, tables=(_modes_table(chart), _crossings_table(chart)))


def _draw_modes(axes: "Axes", chart: "SawChart") -> None:
    for side, frequencies in chart.mode_Hz.items():
        color, style = _LOOK[side]
        for mode, values in enumerate(frequencies.T, start=1):
            axes.plot(chart.speed_m_s, values, style, color=color, linewidth=1.6, label=f"{side} side")
            if side is Side.SLACK:
                case = int(np.searchsorted(chart.speed_m_s, _mode_label_place(chart)))
                axes.annotate(
                    f"mode {mode}",
                    (float(chart.speed_m_s[case]), float(values[case])),
                    xytext=(0, -6),
                    textcoords="offset points",
                    fontsize=8.0,
                    ha="center",
                    va="top",
                    bbox=_BACKGROUND,
                    zorder=5,
                )


def _mode_label_place(chart: "SawChart") -> float:
    slowest, fastest = float(chart.speed_m_s[0]), float(chart.speed_m_s[-1])
    return slowest + _MODE_LABELS_AT * (fastest - slowest)


def _draw_excitation(
    axes: "Axes", excitation: "Excitation", chart: "SawChart", dashes: object, top_Hz: float
) -> None:
    lines = excitation.frequencies_Hz(chart.speed_m_s).T
    if float(lines.min(axis=1).min()) >= top_Hz:
        axes.plot([], [], color=GREY, linestyle=dashes, label=f"{excitation.name} (above the chart)")
        return
    fastest_m_s = float(chart.speed_m_s[-1])
    for harmonic, values in zip(excitation.harmonics, lines, strict=True):
        axes.plot(chart.speed_m_s, values, color=GREY, linestyle=dashes, linewidth=1.1, label=excitation.name)
        at_right = bool(values[-1] <= top_Hz)
        if not at_right and values[0] >= top_Hz:
            continue
        leaves_m_s = float(np.interp(top_Hz, values, chart.speed_m_s)) if not at_right else fastest_m_s
        axes.annotate(
            f"{harmonic}×",
            (leaves_m_s, min(float(values[-1]), top_Hz)),
            xytext=(4, 0) if at_right else (0, 3),
            textcoords="offset points",
            fontsize=8.0,
            color=GREY,
            ha="left" if at_right else "center",
            va="center" if at_right else "bottom",
            annotation_clip=False,
        )


def _draw_crossings(axes: "Axes", chart: "SawChart", top_Hz: float) -> None:
    slowest_m_s, span_m_s = float(chart.speed_m_s[0]), float(np.ptp(chart.speed_m_s))
    slack = chart.mode_Hz[Side.SLACK][int(np.searchsorted(chart.speed_m_s, _mode_label_place(chart)))]
    written = [(_MODE_LABELS_AT, float(value) / top_Hz - _LABEL_OFFSET) for value in slack]
    for crossing in sorted(chart.crossings, key=lambda crossing: abs(crossing.speed_margin)):
        axes.plot(
            crossing.speed_m_s,
            crossing.frequency_Hz,
            "o",
            markersize=6.0,
            markerfacecolor="none",
            markeredgecolor=_LOOK[crossing.side][0],
            markeredgewidth=1.3,
        )
        up = 1.0 if crossing.side is Side.TIGHT else -1.0
        x = (crossing.speed_m_s - slowest_m_s) / span_m_s
        y = crossing.frequency_Hz / top_Hz + up * _LABEL_OFFSET
        crowded = any(
            abs(x - other) < _LABEL_WIDTH and abs(y - there) < _LABEL_HEIGHT for other, there in written
        )
        outside = y < 0.5 * _LABEL_HEIGHT or x < 0.5 * _LABEL_WIDTH
        if not (crowded or outside) and math.isfinite(crossing.speed_margin):
            written.append((x, y))
            _write_margin(axes, crossing, up)


def _write_margin(axes: "Axes", crossing: "Crossing", up: float) -> None:
    axes.annotate(
        f"{100.0 * crossing.speed_margin:+.0f} %".replace("-", "\N{MINUS SIGN}"),
        (crossing.speed_m_s, crossing.frequency_Hz),
        xytext=(0, 6.0 * up),
        textcoords="offset points",
        fontsize=8.0,
        color=_LOOK[crossing.side][0],
        ha="center",
        va="bottom" if up > 0.0 else "top",
        bbox=_BACKGROUND,
        zorder=5,
    )


def _modes_table(chart: "SawChart") -> DataTable:
    rows = tuple(
        (str(side), mode, speed, frequency_Hz)
        for side, frequencies in chart.mode_Hz.items()
        for mode, line in enumerate(frequencies.T.tolist(), start=1)
        for speed, frequency_Hz in zip(chart.speed_m_s.tolist(), line, strict=True)
    )
    return DataTable(header=MODE_HEADER, rows=rows)


def _crossings_table(chart: "SawChart") -> DataTable:
    rows = tuple(
        (str(one.side), one.mode, one.excitation, one.harmonic, one.speed_m_s, one.frequency_Hz, margin)
        for one in chart.crossings
        for margin in (one.speed_margin if math.isfinite(one.speed_margin) else math.nan,)
    )
    return DataTable(name="crossings", header=CROSSING_HEADER, rows=rows)
