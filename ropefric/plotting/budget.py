"""An uncertainty budget as a Pareto chart: which quantity is worth measuring better."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ropefric.errors import InputError
from ropefric.plotting.figure import DataTable, FigureWithData, new_figure
from ropefric.plotting.labels import typeset
from ropefric.plotting.style import BLUE, INK, ORANGE, house_style
from ropefric.plotting.words import say_instead, shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes


HEADER = ("quantity", "contribution", "share", "cumulative_share")


def draw_budget(
    rows: Sequence[tuple[str, float]], *, unit: str = "", title: str = "", combined: float | None = None
) -> FigureWithData:
    """Return the contributions |c u| of a budget as bars, largest first, with their shares and the line of their sum."""
    for name, value in (*rows, ("combined", combined or 0.0)):
        if math.isinf(value):
            raise InputError(
                f"the contribution of {name} is infinite", key=name, fix="leave it out or bound it"
            )
    ranked = sorted(((name, abs(value)) for name, value in rows), key=lambda row: _rank(row[1]))
    total = math.fsum(value**2 for _, value in ranked if not math.isnan(value))
    root = math.sqrt(total) if combined is None else combined
    table: list[tuple[str, float, float, float]] = []
    summed = 0.0
    for name, value in ranked:
        share = value**2 / total if total > 0.0 and not math.isnan(value) else math.nan
        summed += 0.0 if math.isnan(share) else share
        table.append((name, value, share, math.nan if math.isnan(share) else summed))
    label = f" [{unit}]" if unit else " [-]"
    with house_style():
        figure = new_figure(10.0, 1.9 + 0.38 * max(len(table), 2))
        axes = figure.subplots()
        axes.set_xlabel(f"Contribution to the standard uncertainty{label}")
        if total > 0.0:
            _draw(axes, table)
        else:
            say_instead(axes, "no contribution is known")
        axes.set_title(
            typeset(
                f"{title}{': ' if title else ''}u = {shown(root, unit)} (k = 1), n = {len(table)} quantities"
            )
        )
    return FigureWithData(
        figure=figure,
        tables=(DataTable(header=HEADER, rows=tuple(table)),),
        alt=_alt(table, root, unit, title),
    )


def _rank(value: float) -> float:
    return math.inf if math.isnan(value) else -value


def _draw(axes: "Axes", table: list[tuple[str, float, float, float]]) -> None:
    places = range(len(table))
    widths = [0.0 if math.isnan(value) else value for _, value, _, _ in table]
    axes.barh(places, widths, height=0.62, color=BLUE, alpha=0.75, edgecolor=INK, linewidth=0.6)
    # Beside the axes, where the line of the sum cannot cross them.
    beside = axes.get_yaxis_transform()
    for place, (_, value, share, _) in enumerate(table):
        words = "unknown" if math.isnan(value) else f"{value:.3g}  ({100 * share:.3g} %)"
        axes.text(1.01, place, words, transform=beside, va="center", fontsize=9)
    axes.set_yticks(list(places), [typeset(name) for name, *_ in table])
    axes.set_ylim(len(table) - 0.4, -0.6)
    axes.set_xlim(0.0, 1.04 * max(widths))
    axes.grid(visible=False, axis="y")
    above = axes.twiny()
    known = [
        (cumulative, place) for place, (*_, cumulative) in enumerate(table) if not math.isnan(cumulative)
    ]
    above.plot(
        [100 * share for share, _ in known], [place for _, place in known], "o--", color=ORANGE, markersize=4
    )
    above.set_xlim(0.0, 104.0)
    above.set_xticks([0, 20, 40, 60, 80, 100])
    above.set_xlabel("Cumulative share of the variance [%] (dashed)")
    above.spines["top"].set_visible(True)
    above.grid(visible=False)


def _alt(table: list[tuple[str, float, float, float]], root: float, unit: str, title: str) -> str:
    what = f"Uncertainty budget{' of ' + title if title else ''}"
    known = [row for row in table if not math.isnan(row[2])]
    if not known:
        return f"{what}: no contribution is known."
    parts = ", ".join(
        f"{name} {shown(value, unit, 3)} ({100 * share:.3g} %)" for name, value, share, _ in known[:3]
    )
    return (
        f"{what}: combined standard uncertainty {shown(root, unit)}; the largest contributions are {parts}."
    )
