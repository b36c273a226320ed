"""Figures of a press: tensions, slip and maps over speed, preload or load, and the histories of a start-up."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib import colormaps

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.plotting.figure import DataTable, FigureWithData, new_figure
from ropefric.plotting.labels import typeset
from ropefric.plotting.style import BLUE, GREY, INK, LINE_STYLES, ORANGE, TRACE_COLORS, house_style

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from ropefric.systems.press.critical import PressSweep
    from ropefric.systems.press.transient.start_up import StartUp


def draw_press_tension(sweep: "PressSweep") -> FigureWithData:
    """Return the figure of the effective tensions T' of all spans, a line each; equal ones share a line."""
    column, label, across = line_axis(sweep)
    tensions_N = sweep.effective_tension_N.reshape(across.size, -1)
    lines = same_lines(sweep.spans, tensions_N, "T")
    with house_style():
        figure = new_figure(9.0, 6.0, margins={"left": 0.09, "right": 0.83, "top": 0.92, "bottom": 0.1})
        axes = figure.subplots()
        _draw_lines(axes, across, [line for _, line in lines])
        axes.set(xlabel=label, ylabel="Effective tension T' = T − ρAv² [N]", xlim=(across[0], across[-1]))
        axes.set_ylim(bottom=min(0.0, float(tensions_N.min())))
        axes.set_title("Tension of every span, all its belts together")
        name_lines(axes, [(name, float(line[-1])) for name, line in lines])
    fallen = ", ".join(f"{name.replace('_', '')} {span_of(line)} N" for name, line in lines)
    return FigureWithData(
        figure=figure,
        tables=(_line_table((column, "span", "effective_tension_N"), across, sweep.spans, tensions_N),),
        alt=f"Effective tensions over {label} from {span_of(across)}: {fallen}.",
    )


def _draw_lines(axes: "Axes", across: "FloatArray", lines: "list[FloatArray]", width: float = 1.6) -> None:
    scale = colormaps[TRACE_COLORS]
    for i, line in enumerate(lines):
        color = scale(0.85 * i / max(len(lines) - 1, 1))
        axes.plot(across, line, color=color, linestyle=LINE_STYLES[i % 4], linewidth=width)


def _line_table(
    header: tuple[str, ...], across: "FloatArray", names: "Sequence[str]", values: "FloatArray"
) -> DataTable:
    rows = tuple(
        (x, name, value)
        for x, row in zip(across.tolist(), values.tolist(), strict=True)
        for name, value in zip(names, row, strict=True)
    )
    return DataTable(header=header, rows=rows)


MEASURE_LABELS = {
    "utilisation": "Utilisation U of the friction [-]",
    "log": "Share of the friction needed ln(T'_hi/T'_lo)/M [-]",
    "mu_required": "Coefficient required [-]",
    "as_printed": "Slip factor Λ as printed, eq. (38) [-]",
    "as_plotted": "Slip factor Λ, inverted ratio [-]",
}
# Below this a measure that is 0 without torque shows rounding.
_NOTHING = 1e-9


def draw_press_slip(
    sweep: "PressSweep", *, measure: str = "utilisation", rollers: "Sequence[str] | None" = None
) -> FigureWithData:
    """Return the figure of one measure of slip, a line a roller, on a logarithmic axis with the limit drawn across.

    Rollers without torque have no place on it where the measure is 0; the title names them.
    """
    column, label, across = line_axis(sweep)
    chosen = tuple(sweep.rollers if rollers is None else rollers)
    values = np.column_stack([sweep.slip.of(roller, measure).reshape(-1) for roller in chosen])
    idle = [roller for roller, line in zip(chosen, values.T, strict=True) if line.max() < _NOTHING]
    lines = [
        (name.replace("roller_", ""), line)
        for name, line in same_lines(chosen, values, "roller")
        if line.max() >= _NOTHING
    ]
    title = "Slip of the rollers" + (f"; without torque: {', '.join(idle)}" if idle else "")
    with house_style():
        figure = new_figure(9.0, 6.0, margins={"left": 0.09, "right": 0.86, "top": 0.92, "bottom": 0.1})
        axes = figure.subplots()
        drawn = [np.where(np.isfinite(line) & (line > 0.0), line, np.nan) for _, line in lines]
        _draw_lines(axes, across, drawn)
        axes.set_yscale("log")
        axes.yaxis.set_major_formatter("{x:g}")
        words = MEASURE_LABELS[measure].replace("T'_hi/T'_lo", r"$T'_{\mathrm{hi}}/T'_{\mathrm{lo}}$")
        axes.set(xlabel=label, ylabel=words, xlim=(across[0], across[-1]))
        if measure != "mu_required":
            axes.axhline(1.0, color=ORANGE, linewidth=1.5)
            limit = " slip begins" if measure in {"utilisation", "log"} else " 1"
            axes.text(across[0], 1.0, limit, va="bottom")
        axes.set_title(title)
        ends = [(f"roller {name}", float(line[-1])) for name, line in lines if np.isfinite(line[-1])]
        name_lines(axes, ends)
    told = ", ".join(f"roller {name} {span_of(line)}" for name, line in lines)
    return FigureWithData(
        figure=figure,
        tables=(_line_table((column, "roller", measure), across, chosen, values),),
        alt=f"{MEASURE_LABELS[measure]} over {label} from {span_of(across)}: {told}. {title}.",
    )


_LEVELS = 12


def draw_press_map(sweep: "PressSweep") -> FigureWithData:
    """Return the map of the largest utilisation of all rollers, with the line 1 where the first one slips."""
    speed, preload = grid_of(sweep)
    margin, nearest = sweep.margin, sweep.slip.utilisation.argmax(axis=-1)
    lowest_N = sweep.effective_tension_N.min(axis=-1)
    with house_style():
        figure = new_figure(9.0, 6.0)
        axes = figure.subplots()
        label = "Largest utilisation of all rollers [-], cut at 2"
        _fill(axes, sweep, np.minimum(margin, 2.0), label, np.linspace(0.0, 2.0, 11))
        _limit(axes, sweep, margin)
        if lowest_N.min() < 0.0:
            levels_N = [lowest_N.min() - 1.0, 0.0]
            axes.contourf(speed, preload, lowest_N, levels=levels_N, colors="white", hatches=["///"])
        axes.set_title("Where the first roller slips (thick line); hatched: a belt goes slack")
    rows = tuple(
        (force, rim, float(margin[i, j]), sweep.rollers[int(nearest[i, j])], bool(sweep.slack[i, j]))
        for i, force in enumerate(preload.tolist())
        for j, rim in enumerate(speed.tolist())
    )
    slipping = 100.0 * float((margin >= 1.0).mean())
    return FigureWithData(
        figure=figure,
        tables=(DataTable(header=("preload_N", "speed_m_s", "utilisation", "roller", "slack"), rows=rows),),
        alt=f"Largest utilisation over preloads of {span_of(preload)} N and speeds of {span_of(speed)} m/s: "
        f"a roller slips at {slipping:.3g} % of the points.",
    )


def draw_roller_maps(
    sweep: "PressSweep", rollers: "Sequence[str]", *, measure: str = "as_plotted"
) -> FigureWithData:
    """Return maps of one measure of slip for some rollers side by side: figure 7."""
    speed, preload = grid_of(sweep)
    values = {roller: sweep.slip.of(roller, measure) for roller in rollers}
    label = MEASURE_LABELS[measure]
    with house_style():
        figure = new_figure(1.0 + 5.0 * len(values), 5.0)
        panels = figure.subplots(1, len(values), squeeze=False)[0]
        for axes, (name, each) in zip(panels, values.items(), strict=True):
            _fill(axes, sweep, each, label)
            if measure != "mu_required":
                _limit(axes, sweep, each)
            axes.set_title(f"Roller {name}")
    rows = tuple(
        (force, rim, name, float(each[i, j]))
        for name, each in values.items()
        for i, force in enumerate(preload.tolist())
        for j, rim in enumerate(speed.tolist())
    )
    told = ", ".join(f"roller {name} {span_of(each)}" for name, each in values.items())
    return FigureWithData(
        figure=figure,
        tables=(DataTable(header=("preload_N", "speed_m_s", "roller", measure), rows=rows),),
        alt=f"{label} over preloads of {span_of(preload)} N and speeds of {span_of(speed)} m/s: {told}.",
    )


def _fill(
    axes: "Axes", sweep: "PressSweep", values: "FloatArray", label: str, levels: "FloatArray | int" = _LEVELS
) -> None:
    shown = np.ma.masked_invalid(values)
    filled = axes.contourf(sweep.speed_m_s, sweep.preload_N, shown, levels=levels, cmap="cividis")
    axes.set(xlabel=SPEED_LABEL, ylabel=PRELOAD_LABEL)
    axes.figure.colorbar(filled, ax=axes).set_label(label)


def _limit(axes: "Axes", sweep: "PressSweep", values: "FloatArray") -> None:
    """Draw the line 1, where there is one; beyond 2 the values are cut, so that infinity does not bend it."""
    cut = np.minimum(values, 2.0)
    if cut.min() < 1.0 < cut.max():
        where = (sweep.speed_m_s, sweep.preload_N, cut)
        line = axes.contour(*where, levels=[1.0], colors=[ORANGE], linewidths=2.5)
        axes.clabel(line, fmt={1.0: "1"}, colors=[INK])


_LEFT_BEHIND = 0.02
"""A roller whose rim differs from the drive by this share of its highest speed at the end is drawn by itself."""
_FLOOR = 1e-16


def draw_press_start_up(found: "StartUp") -> FigureWithData:
    """Return the figure of a start-up.

    From above: the tension of every span; the rim speed of every roller; when the belt slips on which roller, forward
    (it runs ahead, as on a driven roller) or backward (it lags, as on a driver); what does not add up in the energy
    balance, against the greatest of its parts.
    """
    rims_m_s = found.roller_speed_rad_s * [roller.radius_m for roller in found.press.rollers]
    with house_style():
        figure = new_figure(
            9.0, 11.0, margins={"left": 0.13, "right": 0.84, "top": 0.96, "bottom": 0.05, "hspace": 0.16}
        )
        tension, speed, slip, energy = figure.subplots(
            4, 1, sharex=True, gridspec_kw={"height_ratios": [3.2, 2.0, 1.2, 1.0]}
        )
        tension.set_xlim(found.time_s[0], found.time_s[-1])
        tension.set_title("Start-up: tension of every span, all its belts together")
        _draw_tensions(tension, found)
        _draw_speeds(speed, found, rims_m_s)
        _draw_slips(slip, found)
        _draw_balance(energy, found)
        energy.set_xlabel("Time t [s]")
        figure.align_ylabels()
    return FigureWithData(figure=figure, tables=_tables(found, rims_m_s), alt=_in_words(found))


def _draw_tensions(axes: "Axes", found: "StartUp") -> None:
    lines = same_lines([span.name for span in found.press.spans], found.tension_N, "T")
    _draw_lines(axes, found.time_s, [line for _, line in lines], 1.3)
    axes.set_ylabel("Tension T [N]")
    axes.set_ylim(bottom=0.0)
    name_lines(axes, [(name, float(line[-1])) for name, line in lines])


def _draw_speeds(axes: "Axes", found: "StartUp", rims_m_s: "FloatArray") -> None:
    least = _LEFT_BEHIND * float(np.abs(found.drive_speed_m_s).max())
    slipped = {slip.roller for slip in found.slips}
    ends = [("drive", float(found.drive_speed_m_s[-1]))]
    for i, roller in enumerate(found.press.rollers):
        apart = abs(rims_m_s[-1, i] - found.drive_speed_m_s[-1]) > least
        color = ORANGE if roller.name in slipped else GREY
        axes.plot(found.time_s, rims_m_s[:, i], color=color, linewidth=1.2 if roller.name in slipped else 0.7)
        if apart:
            ends.append((f"roller {roller.name}", float(rims_m_s[-1, i])))
    axes.plot(found.time_s, found.drive_speed_m_s, color=BLUE, linewidth=1.6, linestyle="--")
    axes.set_ylabel("Rim speed Rθ' [m/s]")
    name_lines(axes, ends, gap=0.07)


def _draw_slips(axes: "Axes", found: "StartUp") -> None:
    names = list(dict.fromkeys(slip.roller for slip in found.slips))
    for slip in found.slips:
        color = ORANGE if slip.direction > 0 else BLUE
        row = names.index(slip.roller)
        axes.barh(row, slip.end_s - slip.start_s, left=slip.start_s, height=0.6, color=color)
        # A slip shorter than a pixel still gets its mark.
        axes.plot([slip.start_s], [row], marker="|", markersize=9.0, color=color)
    axes.set_ylabel("Slip on")
    axes.set_yticks(range(len(names)), [f"roller {name}" for name in names])
    axes.set_ylim(max(len(names), 1) - 0.5, -0.5)
    if not names:
        axes.text(0.5, 0.5, "no belt slips", transform=axes.transAxes, ha="center", va="center", color=GREY)
        return
    for place, color, direction, word in ((0.7, ORANGE, 1, "forward"), (0.3, BLUE, -1, "backward")):
        if any(slip.direction == direction for slip in found.slips):
            axes.text(1.03, place, word, transform=axes.transAxes, va="center", color=color, fontsize=9.0)


def _draw_balance(axes: "Axes", found: "StartUp") -> None:
    axes.semilogy(found.time_s, np.maximum(_relative_residual(found), _FLOOR), color=GREY, linewidth=1.0)
    axes.set_ylabel("Energy residual [-]")


def _relative_residual(found: "StartUp") -> "FloatArray":
    largest = float(np.abs(found.energy.drive).max())
    return np.asarray(np.abs(found.energy.residual) / (largest or 1.0))


def _tables(found: "StartUp", rims_m_s: "FloatArray") -> tuple[DataTable, ...]:
    spans = tuple(f"tension_{span.name}_N" for span in found.press.spans)
    rollers = tuple(f"rim_speed_{roller.name}_m_s" for roller in found.press.rollers)
    columns = np.column_stack(
        [found.time_s, found.drive_speed_m_s, found.tension_N, rims_m_s, found.energy.residual]
    )
    header = ("time_s", "drive_speed_m_s", *spans, *rollers, "energy_residual_J")
    slips = tuple((slip.roller, slip.start_s, slip.end_s, slip.direction) for slip in found.slips)
    return (
        DataTable(header=header, rows=tuple(tuple(row) for row in columns.tolist())),
        DataTable(name="slips", header=("roller", "start_s", "end_s", "direction"), rows=slips),
    )


def _in_words(found: "StartUp") -> str:
    first: dict[str, float] = {}
    for slip in found.slips:
        first.setdefault(slip.roller, slip.start_s)
    slips = ", ".join(f"roller {name} from {start_s:.3g} s" for name, start_s in first.items())
    return f"Start-up over {found.time_s[-1]:.4g} s: tensions {span_of(found.tension_N)} N; " + (
        f"the belt slips on {slips}." if slips else "no belt slips."
    )


SPEED_LABEL = "Belt speed v [m/s]"
PRELOAD_LABEL = "Preload of the tensioners F [N]"


def line_axis(sweep: "PressSweep") -> "tuple[str, str, FloatArray]":
    """Return column name, label and values of the one quantity a sweep goes over."""
    if sweep.speed_m_s.size > 1 and sweep.preload_N.size <= 1:
        return "speed_m_s", SPEED_LABEL, sweep.speed_m_s
    if sweep.preload_N.size > 1 and sweep.speed_m_s.size == 1:
        return "preload_N", PRELOAD_LABEL, sweep.preload_N
    raise InputError(
        f"a sweep of {sweep.preload_N.size} preloads and {sweep.speed_m_s.size} speeds is not one line a roller",
        fix="sweep over speeds or preloads alone, or draw a map",
    )


def grid_of(sweep: "PressSweep") -> "tuple[FloatArray, FloatArray]":
    """Return speeds and preloads of a sweep over both."""
    if min(sweep.speed_m_s.size, sweep.preload_N.size) < 2:
        raise InputError(
            "a map needs several preloads and speeds; "
            f"the sweep has {sweep.preload_N.size} and {sweep.speed_m_s.size}",
            fix="sweep over both",
        )
    return sweep.speed_m_s, sweep.preload_N


def same_lines(names: "Sequence[str]", lines: "FloatArray", prefix: str) -> "list[tuple[str, FloatArray]]":
    """Return each different line once, with all its names."""
    groups: list[tuple[list[str], FloatArray]] = []
    for name, line in zip(names, lines.T, strict=True):
        for members, other in groups:
            if np.allclose(line, other, rtol=1e-9, atol=1e-12):
                members.append(name)
                break
        else:
            groups.append(([name], line))
    return [(", ".join(f"{prefix}_{name}" for name in members), line) for members, line in groups]


def name_lines(axes: "Axes", ends: "Sequence[tuple[str, float]]", *, gap: float = 0.042) -> None:
    """Write names at the right end of lines, pushed apart where they would touch; call it with the limits set."""
    to_axes = axes.transData + axes.transAxes.inverted()
    right = axes.get_xlim()[1]
    wanted = sorted((float(to_axes.transform((right, value))[1]), name) for name, value in ends)
    # Names in order that are too close form a block about its mean; blocks that meet join.
    blocks = [[place] for place, _ in wanted]
    i = 0
    while i < len(blocks) - 1:
        low, high = _spread(blocks[i], gap), _spread(blocks[i + 1], gap)
        if high[0] - low[-1] < gap - 1e-9:
            blocks[i : i + 2] = [blocks[i] + blocks[i + 1]]
            i = max(i - 1, 0)
        else:
            i += 1
    spread = [place for block in blocks for place in _spread(block, gap)]
    for (true, name), place in zip(wanted, spread, strict=True):
        axes.annotate(
            typeset(name),
            xy=(1.0, true),
            xytext=(1.03, place),
            xycoords="axes fraction",
            textcoords="axes fraction",
            va="center",
            fontsize=9.0,
            annotation_clip=False,
            arrowprops={"arrowstyle": "-", "color": GREY, "linewidth": 0.6, "shrinkA": 0.0, "shrinkB": 0.0},
        )


def span_of(values: "FloatArray") -> str:
    """Return the range of some numbers in words."""
    return f"{values.min():.4g} to {values.max():.4g}"


def _spread(block: "Sequence[float]", gap: float) -> "list[float]":
    middle = sum(block) / len(block)
    return [middle + gap * (i - 0.5 * (len(block) - 1)) for i in range(len(block))]
