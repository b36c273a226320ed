"""Figures of a press: tensions, slip and maps over speed, preload or load, and the histories of a start-up."""

from typing import TYPE_CHECKING, Any

import numpy as np

from ropefric.errors import InputError
from ropefric.plotting.figure import DataTable, FigureWithData, drawing, say_instead
from ropefric.plotting.style import BLUE, GREY, INK, LINE_STYLES, ORANGE, shades, span_of, typeset

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from matplotlib.axes import Axes

    from ropefric.arrays import FloatArray
    from ropefric.systems.press.critical import PressSweep
    from ropefric.systems.press.transient.start_up import StartUp


MEASURE_LABELS = {
    "utilisation": "Utilisation U of the friction [-]",
    "log": "Share of the friction needed ln(T'_hi/T'_lo)/M [-]",
    "mu_required": "Coefficient required [-]",
    "as_printed": "Slip factor Λ as printed, eq. (38) [-]",
    "as_plotted": "Slip factor Λ, inverted ratio [-]",
}
_SPEED_LABEL = "Belt speed v [m/s]"
_PRELOAD_LABEL = "Preload of the tensioners F [N]"
# Below this a measure that is 0 without torque shows rounding.
_NOTHING = 1e-9
_LEVELS = 12
_LEFT_BEHIND = 0.02
"""A roller whose rim differs from the drive by this share of its highest speed at the end is drawn by itself."""
_FLOOR = 1e-16


def draw_press_tension(sweep: "PressSweep") -> FigureWithData:
    """Return the figure of the effective tensions T' of all spans, a line each; equal ones share a line."""
    column, label, across = _line_axis(sweep)
    tensions_N = sweep.effective_tension_N.reshape(across.size, -1)
    lines = _same_lines(sweep.spans, tensions_N, "T")
    with drawing(9.0, 6.0, margins={"left": 0.09, "right": 0.83, "top": 0.92, "bottom": 0.1}) as figure:
        axes = figure.subplots()
        _draw_lines(axes, across, lines.values())
        axes.set(xlabel=label, ylabel="Effective tension T' = T − ρAv² [N]", xlim=(across[0], across[-1]))
        axes.set_ylim(bottom=min(0.0, float(tensions_N.min())))
        axes.set_title("Tension of every span, all its belts together")
        name_lines(axes, [(name, float(line[-1])) for name, line in lines.items()])
    fallen = ", ".join(f"{name.replace('_', '')} {span_of(line)} N" for name, line in lines.items())
    return FigureWithData(
        figure=figure,
        tables=(_line_table(column, across, "effective_tension_N", tensions_N, span=sweep.spans),),
        alt=f"Effective tensions over {label} from {span_of(across)}: {fallen}.",
    )


def draw_press_slip(
    sweep: "PressSweep", *, measure: str = "utilisation", rollers: "Sequence[str] | None" = None
) -> FigureWithData:
    """Return the figure of one measure of slip, a line a roller, on a logarithmic axis with the limit drawn across.

    Rollers without torque have no place on it where the measure is 0; the title names them.
    """
    column, label, across = _line_axis(sweep)
    chosen = tuple(sweep.rollers if rollers is None else rollers)
    values = np.column_stack([sweep.slip.of(roller, measure).reshape(-1) for roller in chosen])
    idle = [roller for roller, line in zip(chosen, values.T, strict=True) if line.max() < _NOTHING]
    lines = {
        f"roller {name.replace('roller_', '')}": line
        for name, line in _same_lines(chosen, values, "roller").items()
        if line.max() >= _NOTHING
    }
    title = "Slip of the rollers" + (f"; without torque: {', '.join(idle)}" if idle else "")
    with drawing(9.0, 6.0, margins={"left": 0.09, "right": 0.86, "top": 0.92, "bottom": 0.1}) as figure:
        axes = figure.subplots()
        drawn = (np.where(np.isfinite(line) & (line > 0.0), line, np.nan) for line in lines.values())
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
        name_lines(axes, [(name, float(line[-1])) for name, line in lines.items() if np.isfinite(line[-1])])
    told = ", ".join(f"{name} {span_of(line)}" for name, line in lines.items())
    return FigureWithData(
        figure=figure,
        tables=(_line_table(column, across, measure, values, roller=chosen),),
        alt=f"{MEASURE_LABELS[measure]} over {label} from {span_of(across)}: {told}. {title}.",
    )


def _draw_lines(
    axes: "Axes", across: "FloatArray", lines: "Iterable[FloatArray]", width: float = 1.6
) -> None:
    drawn = list(lines)
    for i, (line, color) in enumerate(zip(drawn, shades(len(drawn)), strict=True)):
        axes.plot(across, line, color=color, linestyle=LINE_STYLES[i % 4], linewidth=width)


def _line_table(
    column: str, across: "FloatArray", quantity: str, values: "FloatArray", **names: "Sequence[str]"
) -> DataTable:
    ((of, names_of),) = names.items()
    xs, many = np.repeat(across, len(names_of)), [*names_of] * across.size
    return DataTable.of_columns({column: xs, of: many, quantity: values.ravel()})


def _line_axis(sweep: "PressSweep") -> "tuple[str, str, FloatArray]":
    """Return column name, label and values of the one quantity a sweep goes over."""
    if sweep.speed_m_s.size > 1 and sweep.preload_N.size <= 1:
        return "speed_m_s", _SPEED_LABEL, sweep.speed_m_s
    if sweep.preload_N.size > 1 and sweep.speed_m_s.size == 1:
        return "preload_N", _PRELOAD_LABEL, sweep.preload_N
    raise InputError(
        f"a sweep of {sweep.preload_N.size} preloads and {sweep.speed_m_s.size} speeds is not one line a roller",
        fix="sweep over speeds or preloads alone, or draw a map",
    )


def _same_lines(names: "Iterable[str]", lines: "FloatArray", prefix: str) -> "dict[str, FloatArray]":
    """Return each different line once, under all its names."""
    groups: list[tuple[list[str], FloatArray]] = []
    for name, line in zip(names, lines.T, strict=True):
        alike = (members for members, other in groups if np.allclose(line, other, rtol=1e-9, atol=1e-12))
        if (members := next(alike, None)) is None:
            groups.append((members := [], line))
        members.append(f"{prefix}_{name}")
    return {", ".join(members): line for members, line in groups}


def name_lines(axes: "Axes", ends: "Iterable[tuple[str, float]]", *, gap: float = 0.042) -> None:
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
    arrow = {"arrowstyle": "-", "color": GREY, "linewidth": 0.6, "shrinkA": 0.0, "shrinkB": 0.0}
    for (true, name), place in zip(wanted, spread, strict=True):
        axes.annotate(
            typeset(name),
            xy=(1.0, true),
            xytext=(1.03, place),
            xycoords="axes fraction",
            va="center",
            fontsize=9.0,
            annotation_clip=False,
            arrowprops=arrow,
        )


def _spread(block: "Sequence[float]", gap: float) -> "list[float]":
    middle = sum(block) / len(block)
    return [middle + gap * (i - 0.5 * (len(block) - 1)) for i in range(len(block))]


def draw_press_map(sweep: "PressSweep") -> FigureWithData:
    """Return the map of the largest utilisation of all rollers, with the line 1 where the first one slips."""
    columns, where = _grid(sweep)
    margin, nearest = sweep.margin, sweep.slip.utilisation.argmax(axis=-1)
    lowest_N = sweep.effective_tension_N.min(axis=-1)
    with drawing(9.0, 6.0) as figure:
        axes = figure.subplots()
        label = "Largest utilisation of all rollers [-], cut at 2"
        _fill(axes, sweep, np.minimum(margin, 2.0), label, np.linspace(0.0, 2.0, 11))
        _limit(axes, sweep, margin)
        if lowest_N.min() < 0.0:
            at = (sweep.speed_m_s, sweep.preload_N, lowest_N)
            axes.contourf(*at, levels=[lowest_N.min() - 1.0, 0.0], colors="white", hatches=["///"])
        axes.set_title("Where the first roller slips (thick line); hatched: a belt goes slack")
    first = [sweep.rollers[place] for place in nearest.ravel().tolist()]
    found: dict[str, Any] = {"utilisation": margin.ravel(), "roller": first, "slack": sweep.slack.ravel()}
    slipping = 100.0 * float((margin >= 1.0).mean())
    alt = f"Largest utilisation over {where}: a roller slips at {slipping:.3g} % of the points."
    return FigureWithData(figure=figure, tables=(DataTable.of_columns({**columns, **found}),), alt=alt)


def draw_roller_maps(
    sweep: "PressSweep", rollers: "Sequence[str]", *, measure: str = "as_plotted"
) -> FigureWithData:
    """Return maps of one measure of slip for some rollers side by side: figure 7."""
    columns, where = _grid(sweep)
    values = {roller: sweep.slip.of(roller, measure) for roller in rollers}
    with drawing(1.0 + 5.0 * len(values), 5.0) as figure:
        panels = figure.subplots(1, len(values), squeeze=False)[0]
        for axes, (name, each) in zip(panels, values.items(), strict=True):
            _fill(axes, sweep, each, MEASURE_LABELS[measure], _LEVELS)
            if measure != "mu_required":
                _limit(axes, sweep, each)
            axes.set_title(f"Roller {name}")
    table = {name: np.tile(column, len(values)) for name, column in columns.items()}
    table["roller"] = np.repeat([*values], sweep.margin.size)
    table[measure] = np.ravel([*values.values()])
    told = ", ".join(f"roller {name} {span_of(each)}" for name, each in values.items())
    alt = f"{MEASURE_LABELS[measure]} over {where}: {told}."
    return FigureWithData(figure=figure, tables=(DataTable.of_columns(table),), alt=alt)


def _grid(sweep: "PressSweep") -> "tuple[dict[str, FloatArray], str]":
    """Return preload and speed of every point of a sweep over both as columns, and their ranges in words."""
    if min(sweep.speed_m_s.size, sweep.preload_N.size) < 2:
        raise InputError(
            "a map needs several preloads and speeds; "
            f"the sweep has {sweep.preload_N.size} and {sweep.speed_m_s.size}",
            fix="sweep over both",
        )
    preload, speed = np.meshgrid(sweep.preload_N, sweep.speed_m_s, indexing="ij")
    where = f"preloads of {span_of(preload)} N and speeds of {span_of(speed)} m/s"
    return {"preload_N": preload.ravel(), "speed_m_s": speed.ravel()}, where


def _fill(
    axes: "Axes", sweep: "PressSweep", values: "FloatArray", label: str, levels: "FloatArray | int"
) -> None:
    shown = np.ma.masked_invalid(values)
    filled = axes.contourf(sweep.speed_m_s, sweep.preload_N, shown, levels=levels, cmap="cividis")
    axes.set(xlabel=_SPEED_LABEL, ylabel=_PRELOAD_LABEL)
    axes.figure.colorbar(filled, ax=axes).set_label(label)


def _limit(axes: "Axes", sweep: "PressSweep", values: "FloatArray") -> None:
    """Draw the line 1, where there is one; beyond 2 the values are cut, so that infinity does not bend it."""
    cut = np.minimum(values, 2.0)
    if cut.min() < 1.0 < cut.max():
        where = (sweep.speed_m_s, sweep.preload_N, cut)
        line = axes.contour(*where, levels=[1.0], colors=[ORANGE], linewidths=2.5)
        axes.clabel(line, fmt={1.0: "1"}, colors=[INK])


def draw_press_start_up(found: "StartUp") -> FigureWithData:
    """Return the figure of a start-up.

    From above: the tension of every span; the rim speed of every roller; when the belt slips on which roller, forward
    (it runs ahead, as on a driven roller) or backward (it lags, as on a driver); what does not add up in the energy
    balance, against the greatest of its parts.
    """
    spans, rollers = ([part.name for part in parts] for parts in (found.press.spans, found.press.rollers))
    rims_m_s = found.roller_speed_rad_s * [roller.radius_m for roller in found.press.rollers]
    margins = {"left": 0.13, "right": 0.84, "top": 0.96, "bottom": 0.05, "hspace": 0.16}
    with drawing(9.0, 11.0, margins=margins) as figure:
        panels = figure.subplots(4, 1, sharex=True, height_ratios=[3.2, 2.0, 1.2, 1.0])
        tension, speed, slip, energy = panels
        tension.set_xlim(found.time_s[0], found.time_s[-1])
        tension.set(title="Start-up: tension of every span, all its belts together", ylabel="Tension T [N]")
        lines = _same_lines(spans, found.tension_N, "T")
        _draw_lines(tension, found.time_s, lines.values(), 1.3)
        tension.set_ylim(bottom=0.0)
        name_lines(tension, [(name, float(line[-1])) for name, line in lines.items()])
        _draw_speeds(speed, found, rims_m_s)
        _draw_slips(slip, found)
        residual = np.abs(found.energy.residual) / (float(np.abs(found.energy.drive).max()) or 1.0)
        energy.semilogy(found.time_s, np.maximum(residual, _FLOOR), color=GREY, linewidth=1.0)
        energy.set(xlabel="Time t [s]", ylabel="Energy residual [-]")
        figure.align_ylabels()
    columns = {"time_s": found.time_s, "drive_speed_m_s": found.drive_speed_m_s}
    columns |= {f"tension_{name}_N": line for name, line in zip(spans, found.tension_N.T, strict=True)}
    columns |= {f"rim_speed_{name}_m_s": line for name, line in zip(rollers, rims_m_s.T, strict=True)}
    histories = DataTable.of_columns(columns | {"energy_residual_J": found.energy.residual})
    slips = tuple((slip.roller, slip.start_s, slip.end_s, slip.direction) for slip in found.slips)
    header = ("roller", "start_s", "end_s", "direction")
    first = {slip.roller: slip.start_s for slip in reversed(found.slips)}
    ones = ", ".join(f"roller {name} from {first[name]:.3g} s" for name in _slipped(found))
    alt = f"Start-up over {found.time_s[-1]:.4g} s: tensions {span_of(found.tension_N)} N; " + (
        f"the belt slips on {ones}." if ones else "no belt slips."
    )
    tables = histories, DataTable(name="slips", header=header, rows=slips)
    return FigureWithData(figure=figure, tables=tables, alt=alt)


def _slipped(found: "StartUp") -> list[str]:
    """Return the rollers on which a belt slips, in the order in which it begins to."""
    return list(dict.fromkeys(slip.roller for slip in found.slips))


def _draw_speeds(axes: "Axes", found: "StartUp", rims_m_s: "FloatArray") -> None:
    drive_m_s, slipped = found.drive_speed_m_s, _slipped(found)
    least = _LEFT_BEHIND * float(np.abs(drive_m_s).max())
    ends = [("drive", float(drive_m_s[-1]))]
    for roller, rim_m_s in zip(found.press.rollers, rims_m_s.T, strict=True):
        look = (ORANGE, 1.2) if roller.name in slipped else (GREY, 0.7)
        axes.plot(found.time_s, rim_m_s, color=look[0], linewidth=look[1])
        if abs(rim_m_s[-1] - drive_m_s[-1]) > least:
            ends.append((f"roller {roller.name}", float(rim_m_s[-1])))
    axes.plot(found.time_s, drive_m_s, color=BLUE, linewidth=1.6, linestyle="--")
    axes.set_ylabel("Rim speed Rθ' [m/s]")
    name_lines(axes, ends, gap=0.07)


def _draw_slips(axes: "Axes", found: "StartUp") -> None:
    names = _slipped(found)
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
        say_instead(axes, "no belt slips")
    for place, color, direction, word in ((0.7, ORANGE, 1, "forward"), (0.3, BLUE, -1, "backward")):
        if any(slip.direction == direction for slip in found.slips):
            axes.text(1.03, place, word, transform=axes.transAxes, va="center", color=color, fontsize=9.0)
