"""The figures of a scene: lines from a chart that its kind gives as data, or what the kind names here."""

from importlib import import_module
from typing import TYPE_CHECKING

from ropefric.plotting.figure import DataTable, FigureWithData, legend_below, new_figure
from ropefric.plotting.style import GREY, LINE_STYLES, house_style

if TYPE_CHECKING:
    from collections.abc import Iterator

    from ropefric.scenes.kind import Chart
    from ropefric.scenes.solve import Solution

_MARKERS = "os^Dv*"


def scene_figures(solution: "Solution") -> "Iterator[tuple[str, FigureWithData]]":
    """Yield file name without ending and figure of everything that a solved scene has to show."""
    for stem, figure in solution.scene.kind.figures.items():
        data = figure.data(solution.answer, solution.scene.problem)
        if data is not None:
            module, _, name = figure.drawn_by.partition(".")
            yield stem, getattr(import_module(f"ropefric.plotting.{module}"), name)(data)


def draw_chart(chart: "Chart") -> FigureWithData:
    """Return the figure of a chart: its lines, thin grey ones for limits, a point where a line has one value."""
    with house_style():
        figure = new_figure(9.0, 6.0)
        axes = figure.subplots()
        drawn = 0
        for line in chart.lines:
            if line.limit:
                axes.plot(line.x, line.y, color=GREY, linewidth=1.0, label=line.name)
                continue
            point = line.x.size == 1
            look = (
                {"marker": _MARKERS[drawn % 6], "linestyle": "none"}
                if point
                else {"linestyle": LINE_STYLES[drawn % 4]}
            )
            axes.plot(line.x, line.y, label=line.name, **look)
            drawn += 1
        axes.set(xlabel=chart.x_label, ylabel=chart.y_label)
        axes.set_title(chart.title)
        legend_below(axes)
    rows = tuple(
        (line.name, float(x), float(y)) for line in chart.lines for x, y in zip(line.x, line.y, strict=True)
    )
    table = DataTable(header=("line", chart.x_column, chart.y_column), rows=rows)
    names = ", ".join(line.name for line in chart.lines)
    return FigureWithData(
        figure=figure, tables=(table,), alt=f"{chart.title}: {chart.y_label} over {chart.x_label} of {names}."
    )
