"""The laws of a comparison on a ladder: how far each lies behind the best."""

import math
from typing import TYPE_CHECKING

from ropefric.glossary import counted
from ropefric.plotting.figure import DataTable, FigureWithData, new_figure
from ropefric.plotting.style import BLUE, GREY, INK, house_style
from ropefric.plotting.words import shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ropefric.fitting.compare import Comparison, ComparisonEntry


HEADER = ("law", "k", "delta_aicc", "weight", "chi2", "loco_error", "status", "counted", "note")
_EVEN = 2.0
_CLEAR = 10.0


def draw_ladder(comparison: "Comparison") -> FigureWithData:
    """Return ΔAICc of each law as a dot, best on top, with its Akaike weight and its error at unseen conditions.

    Laws within 2 of the best can hardly be told from it (shaded); beyond 10 there is next to no support. Laws that
    are not counted stand below as crosses with their reason. The axis is linear to 10 and logarithmic beyond.
    """
    entries = comparison.ranking
    with house_style():
        figure = new_figure(10.0, 1.7 + 0.36 * max(len(entries), 2))
        axes = figure.subplots()
        axes.axvspan(-0.4, _EVEN, color=BLUE, alpha=0.12, linewidth=0)
        axes.axvline(_CLEAR, color=GREY, linewidth=1.0, linestyle=":")
        largest = max([entry.delta_aicc for entry in entries if _known(entry)], default=_CLEAR)
        axes.set_xscale("symlog", linthresh=_CLEAR, linscale=1.2)
        axes.set_xlim(-0.4, 1.3 * max(largest, 1.2 * _CLEAR))
        ticks = [0, 2, 5, 10, *(tick for power in range(1, 6) for tick in (3 * 10**power, 10 ** (power + 1)))]
        axes.set_xticks([tick for tick in ticks if tick <= 1.3 * largest], minor=False)
        axes.set_xticks([], minor=True)
        axes.xaxis.set_major_formatter("{x:g}")
        for row, entry in enumerate(entries):
            _draw_entry(axes, row, entry)
        axes.set_yticks(range(len(entries)), [entry.law for entry in entries])
        axes.set_ylim(max(len(entries), 1) - 0.4, -0.6)
        axes.grid(visible=False, axis="y")
        axes.set_xlabel(
            "ΔAICc [-];  shaded: as good as the best;  beyond the dotted line: hardly any support"
        )
        k = counted(comparison.n, comparison.unit.removesuffix("s"))
        axes.set_title(
            f"{counted(len(entries), 'law')} on {counted(comparison.n_trials, 'trial')}, {k}", loc="left"
        )
        for x, text in ((1.02, "weight"), (1.12, "error,\nunseen")):
            axes.text(x, 1.0, text, transform=axes.transAxes, fontsize=9, va="bottom")
    return FigureWithData(figure=figure, tables=(_table(comparison),), alt=_alt(comparison))


def _known(entry: "ComparisonEntry") -> bool:
    return entry.counted and math.isfinite(entry.delta_aicc)


def _draw_entry(axes: "Axes", row: int, entry: "ComparisonEntry") -> None:
    beside = axes.get_yaxis_transform()
    if not _known(entry):
        axes.plot([0.0], [row], "x", color=GREY, markersize=7, markeredgewidth=1.6)
        note = entry.note or "not counted"
        axes.text(0.04, row, f"  {note[:95]}", transform=beside, va="center", fontsize=8, color=GREY)
        return
    best = entry.delta_aicc == 0.0
    axes.plot([0.0, entry.delta_aicc], [row, row], color=BLUE, linewidth=1.4)
    axes.plot([entry.delta_aicc], [row], "D" if best else "o", color=INK if best else BLUE, markersize=8)
    axes.text(
        1.02,
        row,
        "–" if math.isnan(entry.weight) else f"{entry.weight:.3f}",
        transform=beside,
        va="center",
        fontsize=9,
    )
    error = f"{100 * entry.loco_error:.2g} %" if math.isfinite(entry.loco_error) else "–"
    axes.text(1.12, row, error, transform=beside, va="center", fontsize=9)


def _table(comparison: "Comparison") -> DataTable:
    return DataTable(
        header=HEADER,
        rows=tuple(tuple(getattr(entry, name) for name in HEADER) for entry in comparison.ranking),
    )


def _alt(comparison: "Comparison") -> str:
    ranked = [entry for entry in comparison.ranking if _known(entry)]
    if not comparison.ranking:
        return "No law was compared."
    if not ranked:
        return f"{counted(len(comparison.ranking), 'law')} compared; none can be counted."
    text = f"{counted(len(comparison.ranking), 'law')} on {counted(comparison.n_trials, 'trial')} by AICc: "
    text += f"{ranked[0].law} is best "
    weighed = comparison.conclusive
    text += (
        f"with a weight of {shown(ranked[0].weight, digits=3)}" if weighed else "of too few to choose from"
    )
    if len(ranked) > 1:
        text += f", then {ranked[1].law}, {shown(ranked[1].delta_aicc, digits=3)} behind"
    return f"{text}."
