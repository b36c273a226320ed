"""The figures of a scene: what its kind gives as a chart or names here, its effects, its sweeps as lines or a map."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from ropefric.errors import InputError
from ropefric.glossary import GLOSSARY
from ropefric.plotting.figure import DataTable, FigureWithData, drawing, legend_below, legend_of_figure
from ropefric.plotting.style import BLUE, GREY, INK, LINE_STYLES, ORANGE, figure_label

if TYPE_CHECKING:
    from collections.abc import Iterator

    from ropefric.scenes.kind import Chart
    from ropefric.scenes.plan import Explanation
    from ropefric.scenes.solve import Solution
    from ropefric.scenes.sweep import Axis, Sweep

_MARKERS = "os^Dv*"
_MOST_LINES = 6
_DASHES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 3)))
_DRAWN_POINTS, _DRAWN_CELLS = 2000, 250
"""Most points of a line, and of each side of a map, that a page can show; a finer sweep is thinned evenly."""


def scene_figures(solution: "Solution") -> "Iterator[tuple[str, FigureWithData]]":
    """Yield file name without ending and figure of everything that a solved scene has to show."""
    for stem, figure in solution.scene.kind.figures.items():
        data = figure.data(solution.answer, solution.scene.problem)
        if data is not None:
            module, _, name = figure.drawn_by.partition(".")
            yield stem, getattr(import_module(f"ropefric.plotting.{module}"), name)(data)


def draw_chart(chart: "Chart") -> FigureWithData:
    """Return the figure of a chart: its lines, thin grey ones for limits, a point where a line has one value."""
    with drawing(9.0, 6.0) as figure:
        axes = figure.subplots()
        drawn = 0
        for line in chart.lines:
            if line.limit:
                axes.plot(line.x, line.y, color=GREY, linewidth=1.0, label=line.name)
                continue
            dot: dict[str, Any] = {"marker": _MARKERS[drawn % 6], "linestyle": "none"}
            look = dot if line.x.size == 1 else {"linestyle": LINE_STYLES[drawn % 4]}
            axes.plot(line.x, line.y, label=line.name, **look)
            drawn += 1
        axes.set(xlabel=chart.x_label, ylabel=chart.y_label)
        axes.set_title(chart.title)
        legend_below(axes)
    names = [line.name for line in chart.lines]
    columns = {
        "line": np.repeat(names, [line.x.size for line in chart.lines]),
        chart.x_column: np.concatenate([line.x for line in chart.lines], dtype=np.float64),
        chart.y_column: np.concatenate([line.y for line in chart.lines], dtype=np.float64),
    }
    alt = f"{chart.title}: {chart.y_label} over {chart.x_label} of {', '.join(names)}."
    return FigureWithData(figure=figure, tables=(DataTable.of_columns(columns),), alt=alt)


def draw_sweep(sweep: "Sweep", *, quantity: str = "") -> FigureWithData:
    """Return the figure of one number of a sweep over one or two axes: lines for few values of the first, else a map."""
    if len(sweep.axes) > 2:
        raise InputError(
            f"a figure shows one or two axes, this sweep has {len(sweep.axes)}", fix="use its CSV file"
        )
    name = quantity or next(iter(sweep.columns))
    if name not in sweep.columns:
        raise InputError(f"the sweep has no {name!r}", fix=f"it has {', '.join(sweep.columns)}")
    *outer, across = kept = sweep.kept
    lines = not outer or outer[0].values.size <= _MOST_LINES
    most = _DRAWN_POINTS if lines else _DRAWN_CELLS
    steps = [1 if lines else -(-axis.values.size // most) for axis in outer]
    steps.append(-(-across.values.size // most))
    grid = sweep.columns[name].reshape([axis.values.size for axis in kept])
    grid = grid[tuple(slice(None, None, step) for step in steps)]
    places = [axis.values[::step] / axis.factor for axis, step in zip(kept, steps, strict=True)]
    path, _, last = name.rpartition(".")
    label = (f"{path}: " if path else "") + (figure_label(last) if last in GLOSSARY else last)
    with drawing(9.0, 6.0) as figure:
        axes = figure.subplots()
        axes.set_xlabel(_axis_words(across))
        if not outer:
            axes.plot(places[0], grid, color="black")
            axes.set_ylabel(label)
        elif lines:
            for place, (value, row) in enumerate(zip(places[0], grid, strict=True)):
                look: dict[str, Any] = {"linestyle": _DASHES[place], "color": str(0.65 * place / _MOST_LINES)}
                words = f"{outer[0].key} = {value:.4g} {outer[0].unit}".rstrip()
                axes.plot(places[1], row, label=words, **look)
            axes.set_ylabel(label)
            legend_below(axes)
        else:
            shown = np.ma.masked_invalid(grid)
            drawn = axes.pcolormesh(places[1], places[0], shown, cmap="cividis", shading="nearest")
            axes.set_ylabel(_axis_words(outer[0]))
            axes.figure.colorbar(drawn, ax=axes).set_label(label)
    columns = {
        axis.key: each.ravel()
        for axis, each in zip(sweep.axes, np.meshgrid(*places, indexing="ij"), strict=True)
    }
    table = DataTable.of_columns(columns | {name: grid.ravel()})
    return FigureWithData(figure=figure, tables=(table,))


def draw_explanation(told: "Explanation") -> FigureWithData:
    """Return what every effect of a scene is worth, against the accuracy wanted, and beside it the time it takes."""
    shown = [one for one in told.plan.decisions if one.fate != "not applicable"]
    rows, inside = np.arange(len(shown)), np.array([one.fate == "simulated" for one in shown])
    columns = {name: np.array([getattr(one, name) for one in shown]) for name in ("bound", "worth", "time_s")}
    least = 1e-3 * min(told.plan.accuracy, *columns["bound"][columns["bound"] > 0.0])
    with drawing(9.0, 1.6 + 0.35 * len(shown)) as figure:
        worth, takes = figure.subplots(1, 2, sharey=True, width_ratios=(3, 1 + told.is_measured))
        # A worth without a bound reaches to the edge.
        most = 3.0 * max(1.0, *columns["bound"][np.isfinite(columns["bound"])])
        bars = np.clip(np.nan_to_num(columns["bound"], nan=0.0, posinf=most), least, most)
        for words, some, color in (("simulated", inside, BLUE), ("left out", ~inside, GREY)):
            worth.barh(rows[some], bars[some], color=color, height=0.6, label=words if some.any() else "")
            takes.barh(rows[some], 1e3 * np.nan_to_num(columns["time_s"])[some], color=color, height=0.6)
        worth.plot(np.maximum(columns["worth"], least), rows, "o", color=INK, label="measured worth")
        worth.axvline(told.plan.accuracy, color=ORANGE, linestyle="--", label="accuracy wanted")
        worth.set(xscale="log", xlim=(least, most), xlabel="Worth at most, of the answer [-]")
        worth.set_yticks(rows, [one.name for one in shown])
        worth.invert_yaxis()
        takes.set_xlabel("Takes [ms]" if told.is_measured else "Time: --measure")
        figure.suptitle(f"What the effects of this {told.system} scene are worth, and what they take")
        legend_of_figure(figure, columns=4)
    alt = ", ".join(f"{one.name} {one.bound:.2g} ({one.fate})" for one in shown)
    table = DataTable.of_columns(
        {"effect": [one.name for one in shown], "fate": [one.fate for one in shown], **columns}
    )
    return FigureWithData(figure=figure, tables=(table,), alt=f"What effects are worth at most: {alt}.")


def _axis_words(axis: "Axis") -> str:
    return f"{axis.key} [{axis.unit}]" if axis.unit else axis.key
