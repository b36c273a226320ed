"""The cost of accuracy in time: one panel a case, a line a method, and the settings that no other beats."""

import math
import re
import textwrap
from typing import Any

from matplotlib.axes import Axes

from ropefric.accuracy.study import ROUNDING, Case, Measured, StudyResult, in_case, time_text
from ropefric.plotting import style
from ropefric.plotting.figure import DataTable, FigureWithData, drawing

_COLUMNS = (
    *("case", "method", "setting", "error", "seconds", "spread_s", "evaluations"),
    *("lower_s", "upper_s", "repeats", "loops", "bias", "noise"),
)
_NO_ERROR = 1e-13
"""Below this an error is rounding, which differs from setting to setting."""
_BEFORE_UNIT = re.compile(r"(?<=\d) (?=\S)")


def draw_work_precision(result: StudyResult) -> FigureWithData:
    """Return time over error, both logarithmic, for every case of a study; more accurate is further right.

    A thick grey line joins the settings that no other beats in both error and time. Bars reach from the least time to
    the upper quartile. A setting without an answer is in the table only. Cases whose settings do not differ share a
    panel of times.
    """
    alike = [case for case in result.study.cases if _is_pile(in_case(result.points, case.name))]
    alike = alike if len(alike) > 1 else []
    cases: list[Case | None] = [case for case in result.study.cases if case not in alike]
    cases += [None] * bool(alike)
    methods = list(dict.fromkeys(point.method for point in result.points))
    looks = {method: _look(place) for place, method in enumerate(methods)}
    n_columns = 1 if len(cases) == 1 else 2
    n_rows = math.ceil(len(cases) / n_columns)
    columns = 3 if n_columns == 2 else 2
    title = _folded(result.study.title, 58 * n_columns)
    above, below = title.count("\n"), math.ceil((len(methods) + 1) / columns)
    width, height, margins = _frame(n_rows, n_columns, above, below)
    grid: dict[str, Any] = {"nrows": n_rows, "ncols": n_columns, "squeeze": False}
    with drawing(width, height, margins=margins, **grid) as (figure, rows):
        panels = rows.ravel()
        for axes, case in zip(panels, cases, strict=False):
            if case is None:
                _draw_times(axes, [(one.name, in_case(result.points, one.name)) for one in alike], looks)
                continue
            _draw_case(axes, in_case(result.points, case.name), result.front(case.name), looks)
            axes.set_title(_folded(f"{case.name}: {case.title}"), loc="left", fontsize=9.5)
        for axes in panels[len(cases) :]:
            axes.remove()
        figure.suptitle(title, y=0.995, va="top")
        style.legend_of_figure(figure, columns=columns)
    return FigureWithData(figure, (_table(result),), _alt(result))


def _frame(
    n_rows: int, n_columns: int, more_title: int, legend_lines: int
) -> tuple[float, float, dict[str, float]]:
    """Return width, height and margins: panels of one size, two lines of title over each, the legend below."""
    wide, high, between_columns, between_rows = 4.7, 2.8, 0.95, 1.1
    left, right, top, bottom = 0.85, 0.15, 0.75 + 0.2 * more_title, 0.75 + 0.21 * legend_lines
    width = left + right + n_columns * wide + (n_columns - 1) * between_columns
    height = top + bottom + n_rows * high + (n_rows - 1) * between_rows
    ends = {"left": left / width, "right": 1.0 - right / width, "top": 1.0 - top / height}
    between = {"wspace": between_columns / wide, "hspace": between_rows / high}
    return width, height, ends | between | {"bottom": bottom / height}


def _look(place: int) -> dict[str, Any]:
    look = style.line_look(place) | {"marker": style.MARKERS[place % len(style.MARKERS)]}
    if place >= len(style.LINE_STYLES):  # a second round would repeat line and colour together
        look["linestyle"] = style.LINE_STYLES[(place + 1) % len(style.LINE_STYLES)]
    return look


def _draw_case(
    axes: Axes, points: tuple[Measured, ...], front: tuple[Measured, ...], looks: dict[str, dict[str, Any]]
) -> None:
    shown = [point for point in points if math.isfinite(point.error)]
    axes.set_xscale("log")
    axes.set_yscale("log")
    if front:
        thick: dict[str, Any] = {"linewidth": 7, "solid_capstyle": "round", "solid_joinstyle": "round"}
        look = thick if len(front) > 1 else {"marker": "o", "linestyle": "none", "markersize": 14}
        place = [p.shown_error for p in front], [p.seconds for p in front]
        axes.plot(*place, color="#B9B9B9", alpha=0.6, zorder=1, label="fastest for its error", **look)
    bar: dict[str, Any] = {"linewidth": 1.3, "markersize": 5, "elinewidth": 0.8, "capsize": 1.5, "zorder": 2}
    for method, look in looks.items():
        mine = [point for point in shown if point.method == method]
        if not mine:
            continue
        times = [point.seconds for point in mine]
        bars = [[p.seconds - p.lower_s for p in mine], [p.upper_s - p.seconds for p in mine]]
        errors = [point.shown_error for point in mine]
        axes.errorbar(errors, times, yerr=bars, markerfacecolor="white", label=method, **look | bar)
    axes.invert_xaxis()
    _few_decades(axes, shown)
    axes.set(xlabel="Relative error [-], more accurate to the right", ylabel="Time of one call [s]")


def _is_pile(points: tuple[Measured, ...]) -> bool:
    """Return whether a case has two different errors at most: with everything in, and with something left out."""
    errors = [max(point.error, _NO_ERROR) for point in points if math.isfinite(point.error)]
    places = {round(math.log10(error), 1) for error in errors}
    return len(errors) > len(places) and len(places) <= 2


def _draw_times(
    axes: Axes, cases: list[tuple[str, tuple[Measured, ...]]], looks: dict[str, dict[str, Any]]
) -> None:
    """Draw a row a case with the time of each method's quickest setting, and its quartiles."""
    for method, look in looks.items():
        rows = [(row, [p for p in points if p.method == method]) for row, (_, points) in enumerate(cases)]
        quickest = [(row, min(mine, key=lambda point: point.seconds)) for row, mine in rows if mine]
        times = [point.seconds for _, point in quickest]
        bars = [[p.seconds - p.lower_s for _, p in quickest], [p.upper_s - p.seconds for _, p in quickest]]
        mark: dict[str, Any] = {name: look[name] for name in ("color", "marker")} | {"linestyle": "none"}
        mark |= {"markersize": 5, "elinewidth": 0.8, "capsize": 1.5, "markerfacecolor": "white"}
        axes.errorbar(times, [row for row, _ in quickest], xerr=bars, label=method, **mark)
    axes.set_xscale("log")
    axes.set_yticks(range(len(cases)), [name for name, _ in cases])
    axes.set_ylim(len(cases) - 0.5, -0.5)
    axes.set_xlabel("Time of one call [s]")
    axes.set_title("the error does not depend on the accuracy wanted", loc="left", fontsize=9.5)


def _few_decades(axes: Axes, points: list[Measured]) -> None:
    """Mark no more decades than can be read, and where rounding ends all accuracy."""
    if not points:
        return
    errors = [point.shown_error for point in points]
    low, high = math.floor(math.log10(min(errors))), math.ceil(math.log10(max(errors)))
    step = max(1, math.ceil((high - low) / 8))
    axes.set_xticks([10.0**n for n in range(high, low - 1, -step)])
    axes.set_xticks([], minor=True)
    if min(errors) < 10 * ROUNDING:
        axes.axvline(ROUNDING, color="#8A8A8A", linewidth=0.8, linestyle=(0, (2, 3)), zorder=0)
        corner: dict[str, Any] = {"xycoords": ("data", "axes fraction"), "ha": "right", "va": "top"}
        style.note_at(axes, "rounding", (ROUNDING, 1.0), -3.0, -2.0, color=style.GREY, rotation=90, **corner)


def _folded(title: str, width: int = 62) -> str:
    """Return a title in lines, none of which ends between a number and its unit."""
    return "\n".join(textwrap.wrap(_BEFORE_UNIT.sub("\u00a0", title), width))


def _table(result: StudyResult) -> DataTable:
    fronts = {case.name: set(result.front(case.name)) for case in result.study.cases}
    columns = {name: [getattr(point, name) for point in result.points] for name in _COLUMNS}
    for name in dict.fromkeys(name for point in result.points for name in point.shares):
        columns[name] = [point.shares.get(name, math.nan) for point in result.points]
    return DataTable(columns | {"on_front": [p in fronts[p.case] for p in result.points]})


def _alt(result: StudyResult) -> str:
    parts = []
    for case in result.study.cases:
        reached = [(accuracy, point) for accuracy, point in result.cheapest(case.name) if point is not None]
        if reached:
            accuracy, point = reached[-1]
            parts.append(
                f"{case.name}: {accuracy:.0e} is cheapest by {point.name} in {time_text(point.seconds)}"
            )
    return f"{result.study.title}: time over error. " + "; ".join(parts) + "."
