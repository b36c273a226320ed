"""What each input does to the answer between its low and its high value, the widest on top."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ropefric.errors import InputError
from ropefric.plotting.figure import DataTable, FigureWithData, new_figure
from ropefric.plotting.labels import figure_label, typeset
from ropefric.plotting.legend import legend_of_figure
from ropefric.plotting.style import BLUE, INK, ORANGE, house_style
from ropefric.plotting.words import plain_text, say_instead, shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes


HEADER = ("quantity", "low_N", "high_N", "base_N", "swing_N")


def draw_tornado(
    rows: Sequence[tuple[str, float, float, float]], *, quantity: str = "lift_force_N"
) -> FigureWithData:
    """Return a tornado chart: the force at the low and the high value of each input, all others as in the base case."""
    bases = {row[3] for row in rows}
    if len(bases) > 1 or not all(map(math.isfinite, bases)):
        raise InputError(
            f"the base cases are {', '.join(f'{base:g} N' for base in sorted(bases, key=str))}",
            key="base_N",
            fix="give every row the force of one and the same base case, a finite number",
        )
    ranked = sorted(((*row, _swing(row)) for row in rows), key=lambda row: -row[4])
    with house_style():
        figure = new_figure(10.0, 1.7 + 0.42 * max(len(ranked), 2))
        axes = figure.subplots()
        axes.set_xlabel(figure_label(quantity))
        if ranked:
            _draw(axes, ranked)
            legend_of_figure(figure)
            axes.set_title(f"base case {ranked[0][3]:.4g} N; n = {len(ranked)} inputs, one changed at a time")
        else:
            say_instead(axes, "no input was changed")
    return FigureWithData(
        figure=figure, tables=(DataTable(header=HEADER, rows=tuple(ranked)),), alt=_alt(ranked, quantity)
    )


def _swing(row: tuple[str, float, float, float]) -> float:
    reached = [value for value in row[1:] if not math.isnan(value)]
    return max(reached) - min(reached)


def _draw(axes: "Axes", ranked: list[tuple[str, float, float, float, float]]) -> None:
    base_N = ranked[0][3]
    widest = max(row[4] for row in ranked) or 1.0
    for place, (_, low_N, high_N, _, _) in enumerate(ranked):
        for value_N, color, hatch, label in (
            (low_N, ORANGE, "///", "input at its low value"),
            (high_N, BLUE, "", "input at its high value"),
        ):
            if math.isnan(value_N):
                continue
            axes.barh(
                place,
                value_N - base_N,
                left=base_N,
                height=0.6,
                edgecolor=INK,
                linewidth=0.6,
                facecolor=color,
                hatch=hatch,
                label=label,
            )
            side = 1.0 if value_N >= base_N else -1.0
            axes.annotate(
                f"{value_N:.4g}",
                (value_N, place),
                xytext=(4.0 * side, 0.0),
                textcoords="offset points",
                ha="left" if side > 0 else "right",
                va="center",
                fontsize=9,
            )
    axes.axvline(base_N, color=INK, linewidth=1.2)
    reached = [value for row in ranked for value in row[1:4] if not math.isnan(value)]
    axes.set_xlim(min(reached) - 0.12 * widest, max(reached) + 0.12 * widest)
    axes.set_yticks(range(len(ranked)), [typeset(row[0]) for row in ranked])
    axes.set_ylim(len(ranked) - 0.4, -0.6)
    axes.grid(visible=False, axis="y")


def _alt(ranked: list[tuple[str, float, float, float, float]], quantity: str) -> str:
    if not ranked:
        return "No input was changed."
    what = plain_text(figure_label(quantity)).split(" [")[0]
    parts = "; ".join(f"{name}: {shown(low)} to {shown(high, 'N')}" for name, low, high, _, _ in ranked[:4])
    return f"{what}, {shown(ranked[0][3], 'N')} in the base case, when one input changes at a time: {parts}."
