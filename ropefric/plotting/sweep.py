"""A sweep of a scene as a figure: a line over one axis, a line each for the few values of another, else a map."""

from typing import TYPE_CHECKING

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.glossary import GLOSSARY
from ropefric.plotting.figure import DataTable, FigureWithData, legend_below, new_figure
from ropefric.plotting.labels import figure_label
from ropefric.plotting.style import house_style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ropefric.scenes.sweep import Axis, Sweep


_MOST_LINES = 6
_DASHES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 3)))
_DRAWN_POINTS = 2000
_DRAWN_CELLS = 250
"""Most points of a line, and of each side of a map, that a page can show; a finer sweep is thinned evenly."""


def draw_sweep(sweep: "Sweep", *, quantity: str = "") -> FigureWithData:
    """Return the figure of one number of a sweep over one or two axes."""
    if len(sweep.axes) > 2:
        raise InputError(
            f"a figure shows one or two axes, this sweep has {len(sweep.axes)}", fix="use its CSV file"
        )
    name = quantity or next(iter(sweep.columns))
    if name not in sweep.columns:
        raise InputError(f"the sweep has no {name!r}", fix=f"it has {', '.join(sweep.columns)}")
    grid = sweep.columns[name].reshape(sweep.shape)
    with house_style():
        figure = new_figure(9.0, 6.0)
        axes = figure.subplots()
        across = sweep.axes[-1]
        axes.set_xlabel(_axis_words(across))
        if len(sweep.axes) == 1:
            axes.plot(*_thinned(across, grid), color="black")
            axes.set_ylabel(_label(name))
        elif sweep.axes[0].values.size <= _MOST_LINES:
            for place, row in enumerate(grid):
                value = sweep.axes[0].values[place] / sweep.axes[0].factor
                shade = str(0.65 * place / _MOST_LINES)
                axes.plot(
                    *_thinned(across, row),
                    linestyle=_DASHES[place],
                    color=shade,
                    label=f"{sweep.axes[0].key} = {value:.4g} {sweep.axes[0].unit}".rstrip(),
                )
            axes.set_ylabel(_label(name))
            legend_below(axes)
        else:
            _draw_map(axes, sweep, grid, name)
    header = (*(axis.key for axis in sweep.axes), name)
    table = DataTable(header=header, rows=_rows(sweep, grid))
    return FigureWithData(figure=figure, tables=(table,))


def _draw_map(axes: "Axes", sweep: "Sweep", grid: "FloatArray", name: str) -> None:
    down, across = sweep.axes
    rows, columns = _steps(sweep)
    drawn = axes.pcolormesh(
        across.values[::columns] / across.factor,
        down.values[::rows] / down.factor,
        np.ma.masked_invalid(grid[::rows, ::columns]),
        cmap="cividis",
        shading="nearest",
    )
    axes.set_ylabel(_axis_words(down))
    bar = axes.figure.colorbar(drawn, ax=axes)
    bar.set_label(_label(name))


def _thinned(axis: "Axis", values: "FloatArray") -> "tuple[FloatArray, FloatArray]":
    """Return at most some thousand points of a line: no screen shows more."""
    step = max(1, axis.values.size // _DRAWN_POINTS)
    return axis.values[::step] / axis.factor, values[::step]


def _axis_words(axis: "Axis") -> str:
    return f"{axis.key} [{axis.unit}]" if axis.unit else axis.key


def _label(name: str) -> str:
    path, _, last = name.rpartition(".")
    own = figure_label(last) if last in GLOSSARY else last
    return f"{path}: {own}" if path else own


def _rows(sweep: "Sweep", grid: "FloatArray") -> tuple[tuple[object, ...], ...]:
    if len(sweep.axes) == 1:
        xs, ys = _thinned(sweep.axes[0], grid)
        return tuple((float(x), float(y)) for x, y in zip(xs, ys, strict=True))
    down, across = sweep.axes
    rows, columns = _steps(sweep)
    return tuple(
        (float(down.values[i] / down.factor), float(across.values[j] / across.factor), float(grid[i, j]))
        for i in range(0, down.values.size, rows)
        for j in range(0, across.values.size, columns)
    )


def _steps(sweep: "Sweep") -> tuple[int, int]:
    """Return which rows and columns of a grid of two axes are drawn: every so many."""
    down, across = sweep.axes
    lines = down.values.size <= _MOST_LINES
    most = _DRAWN_POINTS if lines else _DRAWN_CELLS
    return (1 if lines else -(-down.values.size // most)), -(-across.values.size // most)
