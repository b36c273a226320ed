"""The figures of scenes: charts, sweeps as lines or a map, a press's start-up, a saw's Campbell chart."""

import math
from collections.abc import Callable, Iterable, Iterator
from itertools import cycle
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from scipy.optimize import isotonic_regression

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.fitting.predict import EXTRAPOLATED
from ropefric.glossary import GLOSSARY, answer_label
from ropefric.plotting import style
from ropefric.plotting.figure import DataTable, FigureWithData, draw_chart, drawing
from ropefric.scenes.explain import Explanation
from ropefric.scenes.solve import Solution
from ropefric.scenes.sweep import Axis as SweepAxis
from ropefric.scenes.sweep import Sweep
from ropefric.systems.bandsaw.resonance import SawChart
from ropefric.systems.bandsaw.saw import Excitation, Side
from ropefric.systems.press.transient.start_up import StartUp

_MOST_LINES = 6
_DRAWN_POINTS, _DRAWN_CELLS = 2000, 250
"""Most points of a line, and of each side of a map, that a page can show; a finer sweep is thinned evenly."""


def scene_figures(solution: Solution) -> Iterator[tuple[str, FigureWithData]]:
    """Yield file name without ending and figure of everything that a solved scene has to show."""
    for stem, figure in solution.scene.kind.figures.items():
        data = figure.data(solution.answer, solution.scene.problem)
        if data is not None:
            yield stem, _DRAWN[figure.drawn_by](data)


def draw_sweep(sweep: Sweep, *, quantity: str = "") -> FigureWithData:
    """Return the figure of one number of a sweep over one or two axes: lines for few values of the first, else a map."""
    if len(sweep.axes) > 2:
        text = f"a figure shows one or two axes, this sweep has {len(sweep.axes)}"
        raise InputError(text, fix="use its CSV file")
    name = quantity or next(iter(sweep.columns))
    if name not in sweep.columns:
        raise InputError(f"the sweep has no {name!r}", fix=f"it has {', '.join(sweep.columns)}")
    *outer, across = sweep.axes
    shown = _shown_part(sweep, name)
    label = style.figure_label(name) if name in GLOSSARY else answer_label(name)
    with drawing(9.0, 6.0) as (figure, axes):
        axes.set(xlabel=across.label, ylabel=label)
        if not outer:
            axes.plot(shown.places[0], shown.grid, color="black")
        elif shown.as_lines:
            _draw_lines(axes, outer[0], shown)
        else:
            values = np.ma.masked_invalid(shown.grid)
            drawn = axes.pcolormesh(*shown.places[::-1], values, cmap="cividis", shading="nearest")
            axes.set_ylabel(outer[0].label)
            axes.figure.colorbar(drawn, ax=axes).set_label(label)
        _mark_outside(axes, shown)
    meshes = zip(sweep.axes, np.meshgrid(*shown.places, indexing="ij"), strict=True)
    columns = {axis.key: each.ravel() for axis, each in meshes} | {name: shown.grid.ravel()}
    marked = {EXTRAPOLATED: shown.outside.ravel()} if sweep.extrapolated_at else {}
    return FigureWithData(figure, (DataTable(columns | marked),))


class _Shown(NamedTuple):
    """The points of a sweep that a figure can show: places along each axis, values, and where the law is untested."""

    places: tuple[FloatArray, ...]
    grid: FloatArray
    outside: FloatArray
    as_lines: bool


def _shown_part(sweep: Sweep, name: str) -> _Shown:
    """Return every n-th point along each axis, so that a page can show them; of few lines all."""
    *outer, across = sweep.axes
    as_lines = not outer or outer[0].values.size <= _MOST_LINES
    most = _DRAWN_POINTS if as_lines else _DRAWN_CELLS
    steps = [1 if as_lines and axis is not across else -(-axis.values.size // most) for axis in sweep.axes]
    part = tuple(slice(None, None, step) for step in steps)
    grid, outside = (
        sweep.columns[one].reshape(sweep.shape)[part]
        for one in (name, EXTRAPOLATED if sweep.extrapolated_at else name)
    )
    places = tuple(axis.values[one] / axis.factor for axis, one in zip(sweep.axes, part, strict=True))
    return _Shown(places, grid, outside if sweep.extrapolated_at else np.zeros(grid.shape), as_lines)


def _draw_lines(axes: Axes, outer: SweepAxis, shown: _Shown) -> None:
    lines = _same_lines(map("{:.4g}".format, shown.places[0]), shown.grid)
    for place, (values, row) in enumerate(lines.items()):
        look: dict[str, Any] = {
            "linestyle": style.LINE_STYLES[place],
            "color": str(0.65 * place / _MOST_LINES),
        }
        axes.plot(shown.places[1], row, label=f"{outer.key} = {values} {outer.unit}".rstrip(), **look)
    style.legend_below(axes)


def _mark_outside(axes: Axes, shown: _Shown) -> None:
    """Hatch where the law is used outside its tested range; a single line outside it has a pale band."""
    places, grid, outside = shown.places, shown.grid, shown.outside > 0.0
    if not outside.any():
        return
    if not shown.as_lines:
        look: dict[str, Any] = {"colors": "none", "hatches": ["", "///"], "levels": [-0.5, 0.5, 1.5]}
        if min(grid.shape) > 1:
            axes.contourf(places[1], places[0], outside.astype(float), **look)
        return
    masks = np.atleast_2d(outside)
    everywhere = np.asarray(masks.all(axis=0))
    style.hatch_untested(axes, places[-1], everywhere)
    pale: dict[str, Any] = {"color": (style.ORANGE, 0.4), "linewidth": 6.0, "marker": "o", "markersize": 3.0}
    for row, mask in zip(np.atleast_2d(grid), masks & ~everywhere, strict=True):
        if mask.any():
            axes.plot(
                places[-1], np.where(mask, row, np.nan), zorder=0.5, label="this line not tested", **pale
            )
    style.legend_below(axes)


def draw_explanation(told: Explanation) -> FigureWithData:
    """Return the influence of every effect of a scene, against the accuracy wanted, and beside it its computing time."""
    shown = [one for one in told.plan.decisions if one.fate != "not applicable"]
    rows, inside = np.arange(len(shown)), np.array([one.fate == "simulated" for one in shown])
    columns = {name: np.array([getattr(one, name) for one in shown]) for name in ("bound", "worth", "time_s")}
    worths, bounds = columns["worth"], columns["bound"]
    least = 1e-3 * min([told.plan.accuracy, *worths[worths > 0.0]])
    side: dict[str, Any] = {"ncols": 2, "sharey": True, "width_ratios": (3, 1 + told.is_measured)}
    with drawing(9.0, 1.6 + 0.35 * len(shown), **side) as (figure, (worth, takes)):
        # A worth that is no number, as another answer is, reaches to the edge.
        most = 3.0 * max([1.0, *worths[np.isfinite(worths)]])
        bars = np.clip(np.nan_to_num(worths, nan=most, posinf=most), least, most)
        for words, some, color in (("simulated", inside, style.BLUE), ("left out", ~inside, style.GREY)):
            worth.barh(rows[some], bars[some], color=color, height=0.6, label=words if some.any() else "")
            takes.barh(rows[some], 1e3 * np.nan_to_num(columns["time_s"])[some], color=color, height=0.6)
        if np.isfinite(bounds).any():
            worth.plot(np.maximum(bounds, least), rows, "|", color=style.INK, markersize=14, label="bound")
        worth.axvline(told.plan.accuracy, color=style.ORANGE, linestyle="--", label="accuracy wanted")
        worth.set(xscale="log", xlim=(least, most), xlabel="Largest influence on the answer [-]")
        worth.set_yticks(rows, [one.name for one in shown])
        worth.invert_yaxis()
        takes.set_xlabel("Time [ms]" if told.is_measured else "Time: not measured")
        figure.suptitle(f"Effects of this {told.system} scene: influence and computing time")
        style.legend_of_figure(figure, columns=4)
    alt = ", ".join(f"{one.name} {one.worth:.2g} ({one.fate})" for one in shown)
    named: dict[str, Any] = {"effect": [one.name for one in shown], "fate": [one.fate for one in shown]}
    table = DataTable({**named, **columns})
    return FigureWithData(figure, (table,), f"Largest influence of each effect: {alt}.")


_LEFT_BEHIND = 0.02
"""A roller whose rim differs from the drive by this share of its highest speed at the end is drawn by itself."""


def _same_lines(names: Iterable[str], lines: FloatArray) -> dict[str, FloatArray]:
    """Return each different line once, under all its names: none is drawn on another."""
    groups: list[tuple[list[str], FloatArray]] = []
    for name, line in zip(names, lines, strict=True):
        alike = (
            members for members, other in groups if np.allclose(line, other, 1e-9, 1e-12, equal_nan=True)
        )
        if (members := next(alike, None)) is None:
            groups.append((members := [], line))
        members.append(name)
    return {", ".join(members): line for members, line in groups}


def name_lines(axes: Axes, ends: Iterable[tuple[str, float]], *, gap: float = 0.042) -> None:
    """Write names at the right end of lines, pushed apart where they would touch; call it with the limits set."""
    to_axes = axes.transData + axes.transAxes.inverted()
    right = axes.get_xlim()[1]
    wanted = sorted((float(to_axes.transform((right, value))[1]), name) for name, value in ends)
    # As near to their lines as a gap between them lets them, by least squares.
    steps = gap * np.arange(len(wanted))
    spread = isotonic_regression([place for place, _ in wanted] - steps).x + steps
    arrow = {"arrowstyle": "-", "color": style.GREY, "linewidth": 0.6, "shrinkA": 0.0, "shrinkB": 0.0}
    for (true, name), place in zip(wanted, spread, strict=True):
        look: dict[str, Any] = {"va": "center", "fontsize": 9.0, "arrowprops": arrow}
        look["annotation_clip"] = False
        axes.annotate(style.typeset(name), (1.0, true), (1.03, place), xycoords="axes fraction", **look)


def draw_press_start_up(found: StartUp) -> FigureWithData:
    """Return the figure of a start-up.

    From above: the tension of every span; the rim speed of every roller; when the belt slips on which roller, forward
    (it runs ahead, as on a driven roller) or backward (it lags, as on a driver).
    """
    spans, rollers = ([part.name for part in parts] for parts in (found.press.spans, found.press.rollers))
    rims_m_s = found.roller_speed_rad_s * [roller.radius_m for roller in found.press.rollers]
    margins = {"left": 0.13, "right": 0.84, "top": 0.96, "bottom": 0.05, "hspace": 0.16}
    rows: dict[str, Any] = {"nrows": 3, "sharex": True, "height_ratios": [3.2, 2.0, 1.2]}
    with drawing(9.0, 9.6, margins=margins, **rows) as (figure, (tension, speed, slip)):
        tension.set_xlim(found.time_s[0], found.time_s[-1])
        tension.set(title="Start-up: tension of every span, all its belts together", ylabel="Tension T [N]")
        lines = _same_lines((f"T_{name}" for name in spans), found.tension_N.T)
        for i, (line, color) in enumerate(zip(lines.values(), style.shades(len(lines)), strict=True)):
            tension.plot(found.time_s, line, color=color, linestyle=style.LINE_STYLES[i % 4], linewidth=1.3)
        tension.set_ylim(bottom=0.0)
        name_lines(tension, [(name, float(line[-1])) for name, line in lines.items()])
        _draw_speeds(speed, found, rims_m_s)
        _draw_slips(slip, found)
        slip.set_xlabel("Time t [s]")
        figure.align_ylabels()
    columns = {"time_s": found.time_s, "drive_speed_m_s": found.drive_speed_m_s}
    columns |= {f"tension_{name}_N": line for name, line in zip(spans, found.tension_N.T, strict=True)}
    columns |= {f"rim_speed_{name}_m_s": line for name, line in zip(rollers, rims_m_s.T, strict=True)}
    histories = DataTable(columns)
    first = {slip.roller: slip.start_s for slip in reversed(found.slips)}
    ones = ", ".join(f"roller {name} from {first[name]:.3g} s" for name in _slipped(found))
    alt = f"Start-up over {found.time_s[-1]:.4g} s: tensions {style.span_of(found.tension_N)} N; " + (
        f"the belt slips on {ones}." if ones else "no belt slips."
    )
    slips = DataTable.of(found.slips, ("roller", "start_s", "end_s", "direction"), "slips")
    return FigureWithData(figure, (histories, slips), alt)


def _slipped(found: StartUp) -> list[str]:
    """Return the rollers on which a belt slips, in the order in which it begins to."""
    return list(dict.fromkeys(slip.roller for slip in found.slips))


def _draw_speeds(axes: Axes, found: StartUp, rims_m_s: FloatArray) -> None:
    drive_m_s, slipped = found.drive_speed_m_s, _slipped(found)
    least = _LEFT_BEHIND * float(np.abs(drive_m_s).max())
    ends = [("drive", float(drive_m_s[-1]))]
    for roller, rim_m_s in zip(found.press.rollers, rims_m_s.T, strict=True):
        look = (style.ORANGE, 1.2) if roller.name in slipped else (style.GREY, 0.7)
        axes.plot(found.time_s, rim_m_s, color=look[0], linewidth=look[1])
        if abs(rim_m_s[-1] - drive_m_s[-1]) > least:
            ends.append((f"roller {roller.name}", float(rim_m_s[-1])))
    axes.plot(found.time_s, drive_m_s, color=style.BLUE, linewidth=1.6, linestyle="--")
    axes.set_ylabel("Rim speed Rθ' [m/s]")
    name_lines(axes, ends, gap=0.07)


def _draw_slips(axes: Axes, found: StartUp) -> None:
    names = _slipped(found)
    for slip in found.slips:
        color = style.ORANGE if slip.direction > 0 else style.BLUE
        row = names.index(slip.roller)
        axes.barh(row, slip.end_s - slip.start_s, left=slip.start_s, height=0.6, color=color)
        # A slip shorter than a pixel still gets its mark.
        axes.plot([slip.start_s], [row], marker="|", markersize=9.0, color=color)
    axes.set_ylabel("Slip on")
    axes.set_yticks(range(len(names)), [f"roller {name}" for name in names])
    axes.set_ylim(max(len(names), 1) - 0.5, -0.5)
    if not names:
        style.say_instead(axes, "no belt slips")
    ways = (0.7, style.ORANGE, 1, "forward"), (0.3, style.BLUE, -1, "backward")
    for place, color, direction, word in ways:
        if any(slip.direction == direction for slip in found.slips):
            axes.text(1.03, place, word, transform=axes.transAxes, va="center", color=color, fontsize=9.0)


_CROSSING = ("side", "mode", "excitation", "harmonic", "speed_m_s", "frequency_Hz", "speed_margin")

_LOOK = {Side.TIGHT: (style.BLUE, "-"), Side.SLACK: (style.ORANGE, "--")}
_SHAKES = ((0, (1, 1)), (0, (4, 2, 1, 2)), (0, (6, 2)), (0, (3, 1, 1, 1, 1, 1)))
_MODE_LABELS_AT = 0.12
_BACKGROUND = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.4}


def draw_saw_chart(chart: SawChart) -> FigureWithData:
    """Return a Campbell chart: frequencies of the modes of both sides over the blade's speed, and the excitations.

    Where a mode meets an excitation there is a circle; the table says by how much the speed at work would have to
    change to get there.
    """
    top_Hz = 1.08 * max(float(found.max()) for found in chart.mode_Hz.values())
    fastest_m_s = float(chart.speed_m_s[-1])
    with drawing(9.0, 6.5) as (figure, axes):
        axes.set(xlim=(float(chart.speed_m_s[0]), fastest_m_s), ylim=(0.0, top_Hz))
        axes.set(xlabel="Blade speed v [m/s]", ylabel="Frequency f [Hz]")
        axes.set_title("Modes of the blade and what excites them; circles: resonance", pad=18.0)
        _draw_modes(axes, chart)
        for excitation, dashes in zip(chart.excitations, cycle(_SHAKES), strict=False):
            _draw_excitation(axes, excitation, chart, dashes, top_Hz)
        if chart.work_m_s > 0.0:
            axes.axvline(chart.work_m_s, color="black", linewidth=1.2, label="speed at work")
        for one in chart.crossings:
            ring: dict[str, Any] = {"markeredgecolor": _LOOK[one.side][0], "markerfacecolor": "none"}
            axes.plot(one.speed_m_s, one.frequency_Hz, "o", markersize=6.0, markeredgewidth=1.3, **ring)
        style.legend_below(axes, columns=4)
    rows = [
        (str(side), mode, *point)
        for side, found in chart.mode_Hz.items()
        for mode, values in enumerate(found.T.tolist(), start=1)
        for point in zip(chart.speed_m_s.tolist(), values, strict=True)
    ]
    modes = DataTable.of_rows(("side", "mode", "speed_m_s", "frequency_Hz"), rows)
    crossings = {name: [getattr(one, name) for one in chart.crossings] for name in _CROSSING}
    crossings["side"] = [str(side) for side in crossings["side"]]
    crossings["speed_margin"] = [x if math.isfinite(x) else math.nan for x in crossings["speed_margin"]]
    return FigureWithData(figure, (modes, DataTable(crossings, "crossings")))


def _draw_modes(axes: Axes, chart: SawChart) -> None:
    """Draw the modes, and write their numbers."""
    speeds = chart.speed_m_s
    case = int(np.searchsorted(speeds, float(speeds[0]) + _MODE_LABELS_AT * float(np.ptp(speeds))))
    for side, frequencies in chart.mode_Hz.items():
        color, dashes = _LOOK[side]
        for mode, values in enumerate(frequencies.T, start=1):
            axes.plot(speeds, values, dashes, color=color, linewidth=1.6, label=f"{side} side")
            if side is Side.SLACK:
                point = (float(speeds[case]), float(values[case]))
                style.note_at(axes, f"mode {mode}", point, up=-6.0, va="top", bbox=_BACKGROUND, zorder=5)


def _draw_excitation(
    axes: Axes, excitation: Excitation, chart: SawChart, dashes: object, top_Hz: float
) -> None:
    lines = excitation.frequencies_Hz(chart.speed_m_s).T
    if float(lines.min(axis=1).min()) >= top_Hz:
        axes.plot([], [], color=style.GREY, linestyle=dashes, label=f"{excitation.name} (above the chart)")
        return
    for harmonic, values in zip(excitation.harmonics, lines, strict=True):
        look: dict[str, Any] = {"color": style.GREY, "linestyle": dashes, "linewidth": 1.1}
        axes.plot(chart.speed_m_s, values, label=excitation.name, **look)
        at_right = bool(values[-1] <= top_Hz)
        if not at_right and values[0] >= top_Hz:
            continue
        # Beyond the last speed that is this one.
        point = (float(np.interp(top_Hz, values, chart.speed_m_s)), min(float(values[-1]), top_Hz))
        where = {"right": 4.0, "ha": "left", "va": "center"} if at_right else {"up": 3.0}
        style.note_at(axes, f"{harmonic}×", point, color=style.GREY, annotation_clip=False, **where)


_DRAWN: dict[str, Callable[[Any], FigureWithData]] = {
    draw.__name__: draw for draw in (draw_chart, draw_press_start_up, draw_saw_chart)
}
"""Functions that a kind of scene may name to draw its figures."""
