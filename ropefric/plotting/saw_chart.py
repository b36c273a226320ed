"""A Campbell chart: the blade's modes and what shakes it over the blade's speed, meetings circled."""

import math
from itertools import cycle
from typing import TYPE_CHECKING, Any

import numpy as np

from ropefric.plotting.figure import DataTable, FigureWithData, drawing, legend_below, note_at
from ropefric.plotting.style import BLUE, GREY, ORANGE
from ropefric.systems.bandsaw.saw import Side

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ropefric.systems.bandsaw.resonance import Excitation, SawChart


_CROSSING = ("side", "mode", "excitation", "harmonic", "speed_m_s", "frequency_Hz", "speed_margin")

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
    with drawing(9.0, 6.5) as figure:
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
    speeds, n_modes = chart.speed_m_s, chart.mode_Hz[Side.TIGHT].shape[1]
    modes: dict[str, Any] = {
        "side": [str(side) for side in chart.mode_Hz for _ in range(n_modes * speeds.size)],
        "mode": [*np.repeat(np.arange(1, n_modes + 1), speeds.size).tolist()] * len(chart.mode_Hz),
        "speed_m_s": np.tile(speeds, n_modes * len(chart.mode_Hz)),
        "frequency_Hz": np.concatenate([found.T.ravel() for found in chart.mode_Hz.values()]),
    }
    crossings = {name: [getattr(one, name) for one in chart.crossings] for name in _CROSSING}
    crossings["side"] = [str(side) for side in crossings["side"]]
    crossings["speed_margin"] = [x if math.isfinite(x) else math.nan for x in crossings["speed_margin"]]
    tables = DataTable.of_columns(modes), DataTable.of_columns(crossings, "crossings")
    return FigureWithData(figure=figure, tables=tables)


def _draw_modes(axes: "Axes", chart: "SawChart") -> None:
    for side, frequencies in chart.mode_Hz.items():
        color, style = _LOOK[side]
        for mode, values in enumerate(frequencies.T, start=1):
            axes.plot(chart.speed_m_s, values, style, color=color, linewidth=1.6, label=f"{side} side")
            if side is Side.SLACK:
                case = int(np.searchsorted(chart.speed_m_s, _mode_label_place(chart)))
                point = (float(chart.speed_m_s[case]), float(values[case]))
                note_at(axes, f"mode {mode}", point, up=-6.0, va="top", bbox=_BACKGROUND, zorder=5)


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
        where = {"right": 4.0, "ha": "left", "va": "center"} if at_right else {"up": 3.0}
        point = (leaves_m_s, min(float(values[-1]), top_Hz))
        note_at(axes, f"{harmonic}×", point, color=GREY, annotation_clip=False, **where)


def _draw_crossings(axes: "Axes", chart: "SawChart", top_Hz: float) -> None:
    slowest_m_s, span_m_s = float(chart.speed_m_s[0]), float(np.ptp(chart.speed_m_s))
    slack = chart.mode_Hz[Side.SLACK][int(np.searchsorted(chart.speed_m_s, _mode_label_place(chart)))]
    written = [(_MODE_LABELS_AT, float(value) / top_Hz - _LABEL_OFFSET) for value in slack]
    for crossing in sorted(chart.crossings, key=lambda crossing: abs(crossing.speed_margin)):
        color, point = _LOOK[crossing.side][0], (crossing.speed_m_s, crossing.frequency_Hz)
        ring: dict[str, Any] = {"markersize": 6.0, "markerfacecolor": "none", "markeredgewidth": 1.3}
        axes.plot(*point, "o", markeredgecolor=color, **ring)
        up = 1.0 if crossing.side is Side.TIGHT else -1.0
        x = (crossing.speed_m_s - slowest_m_s) / span_m_s
        y = crossing.frequency_Hz / top_Hz + up * _LABEL_OFFSET
        crowded = any(
            abs(x - other) < _LABEL_WIDTH and abs(y - there) < _LABEL_HEIGHT for other, there in written
        )
        outside = y < 0.5 * _LABEL_HEIGHT or x < 0.5 * _LABEL_WIDTH
        if not (crowded or outside) and math.isfinite(crossing.speed_margin):
            written.append((x, y))
            words = f"{100.0 * crossing.speed_margin:+.0f} %".replace("-", "\N{MINUS SIGN}")
            look: dict[str, Any] = {"va": "bottom" if up > 0.0 else "top", "bbox": _BACKGROUND, "zorder": 5}
            note_at(axes, words, point, up=6.0 * up, color=color, **look)
