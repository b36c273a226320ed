"""The basis of a law and its design: laws by AICc, budgets, sensitivities, and lift force over the wrap."""

import math
from collections.abc import Sequence
from textwrap import wrap
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ropefric.arrays import FloatArray
from ropefric.fitting.compare import Comparison, ComparisonEntry
from ropefric.fitting.design import DesignChart
from ropefric.fitting.predict import Prediction
from ropefric.glossary import counted
from ropefric.plotting import style
from ropefric.plotting.figure import DataTable, FigureWithData, drawing
from ropefric.uncertainty.budget import Statement

_LADDER = ("law", "k", "delta_aicc", "weight", "chi2", "loco_error", "status", "counted", "note")
_EVEN = 2.0
_CLEAR = 10.0


def draw_ladder(comparison: Comparison) -> FigureWithData:
    """Return ΔAICc of each law as a dot, best on top, with its Akaike weight and its error at unseen conditions.

    Laws within 2 of the best fit about as well (shaded); beyond 10 there is almost no support. Laws that are not
    ranked are crosses below, with the reason. The axis is linear to 10 and logarithmic beyond.
    """
    entries = comparison.ranking
    conditions = counted(comparison.n, comparison.unit.removesuffix("s"))
    laws = f"{counted(len(entries), 'law')} on {counted(comparison.n_trials, 'trial')}"
    with drawing(10.0, 1.5 + 0.29 * max(len(entries), 2)) as (figure, axes):
        axes.axvspan(-0.4, _EVEN, color=style.BLUE, alpha=0.12, linewidth=0)
        axes.axvline(_CLEAR, color=style.GREY, linewidth=1.0, linestyle=":")
        largest = max([entry.delta_aicc for entry in entries if _is_ranked(entry)], default=_CLEAR)
        axes.set_xscale("symlog", linthresh=_CLEAR, linscale=1.2)
        axes.set_xlim(-0.4, 1.3 * max(largest, 1.2 * _CLEAR))
        ticks = [0, 2, 5, 10, *(tick for power in range(1, 6) for tick in (3 * 10**power, 10 ** (power + 1)))]
        axes.set_xticks([tick for tick in ticks if tick <= 1.3 * largest], minor=False)
        axes.set_xticks([], minor=True)
        axes.xaxis.set_major_formatter("{x:g}")
        for row, entry in enumerate(entries):
            _draw_entry(axes, row, entry)
        name_rows(axes, [entry.law for entry in entries])
        axes.set_xlabel("ΔAICc [-];  shaded: as good as the best;  right of the dotted line: no support")
        axes.set_title(f"{laws}, {conditions}", loc="left")
        for x, text in ((1.02, "weight"), (1.12, "error,\nunseen")):
            axes.text(x, 1.0, text, transform=axes.transAxes, fontsize=9, va="bottom")
    return FigureWithData(figure, (DataTable.of(entries, _LADDER),), _ladder_in_words(comparison, laws))


def name_rows(axes: Axes, names: Sequence[str]) -> None:
    """Write a name at each row, the first on top."""
    axes.set_yticks(range(len(names)), list(names))
    axes.set_ylim(max(len(names), 1) - 0.4, -0.6)
    axes.grid(visible=False, axis="y")


def _is_ranked(entry: ComparisonEntry) -> bool:
    return entry.counted and math.isfinite(entry.delta_aicc)


def _draw_entry(axes: Axes, row: int, entry: ComparisonEntry) -> None:
    beside = axes.get_yaxis_transform()
    if not _is_ranked(entry):
        axes.plot([0.0], [row], "x", color=style.GREY, markersize=7, markeredgewidth=1.6)
        # Whole, in as many lines as it needs.
        note = "\n".join(wrap(entry.note or "not ranked", 105))
        axes.text(0.05, row, note, transform=beside, va="center", fontsize=7, color=style.GREY)
        return
    best = entry.delta_aicc == 0.0
    color = style.law_look(entry.law)["color"]
    axes.plot([0.0, entry.delta_aicc], [row, row], color=color, linewidth=1.4)
    axes.plot([entry.delta_aicc], [row], "D" if best else "o", color=color, markersize=8)
    weight = "–" if math.isnan(entry.weight) else f"{entry.weight:.3f}"
    error = f"{100 * entry.loco_error:.2g} %" if math.isfinite(entry.loco_error) else "–"
    for x, text in ((1.02, weight), (1.12, error)):
        axes.text(x, row, text, transform=beside, va="center", fontsize=9)


def _ladder_in_words(comparison: Comparison, laws: str) -> str:
    ranked = [entry for entry in comparison.ranking if _is_ranked(entry)]
    if not comparison.ranking:
        return "No law was compared."
    if not ranked:
        return f"{counted(len(comparison.ranking), 'law')} compared; none can be counted."
    weight = f"with a weight of {style.shown(ranked[0].weight, digits=3)}"
    text = f"{laws} by AICc: {ranked[0].law} is best "
    text += weight if comparison.conclusive else "of too few to choose from"
    if len(ranked) > 1:
        text += f", then {ranked[1].law}, {style.shown(ranked[1].delta_aicc, digits=3)} behind"
    return f"{text}."


def draw_statement(stated: Statement, *, least_share: float = 0.0) -> FigureWithData:
    """Return the contributions of a statement of uncertainty, those with more than `least_share` of the variance."""
    model, budget = stated.model, stated.budget
    rows = [(line.label, line.contribution) for line in budget.lines if line.share >= least_share]
    return draw_budget(rows, unit=model.unit, title=model.name, combined=budget.combined)


def draw_budget(
    rows: Sequence[tuple[str, float]], *, unit: str, title: str, combined: float
) -> FigureWithData:
    """Return the contributions |c u| of a budget as bars, largest first, with their shares."""
    # Unknown contributions come last.
    ranked = sorted(rows, key=lambda row: (math.isnan(row[1]), -abs(row[1])))
    names, values = [name for name, _ in ranked], np.abs([value for _, value in ranked])
    total = math.fsum(values[~np.isnan(values)] ** 2)
    shares = values**2 / (total or math.nan)
    parts = np.stack([values, shares, np.cumsum(shares)])
    columns = dict(zip(("contribution", "share", "cumulative_share"), parts, strict=True))
    with drawing(10.0, 1.8 + 0.3 * max(len(names), 2)) as (figure, axes):
        axes.set_xlabel(f"Contribution to the standard uncertainty [{unit or '-'}]")
        if total > 0.0:
            _draw_contributions(axes, names, parts)
        else:
            style.say_instead(axes, "no contribution is known")
        sum_of_all = style.shown(combined, unit)
        axes.set_title(style.typeset(f"{title}: u = {sum_of_all} (k = 1), n = {len(names)} quantities"))
    said = "no contribution is known"
    if total > 0.0:
        largest = [one for one in zip(names, values, shares, strict=True) if not math.isnan(one[1])][:3]
        told = [f"{name} {style.shown(u, unit, 3)} ({100 * share:.3g} %)" for name, u, share in largest]
        said = f"combined standard uncertainty {sum_of_all}; the largest contributions are {', '.join(told)}"
    table = DataTable({"quantity": names, **columns})
    return FigureWithData(figure, (table,), f"Uncertainty budget of {title}: {said}.")


def _draw_contributions(axes: Axes, names: Sequence[str], parts: FloatArray) -> None:
    widths = np.nan_to_num(parts[0])
    places = range(len(names))
    axes.barh(places, widths, height=0.62, color=style.BLUE, alpha=0.75, edgecolor=style.INK, linewidth=0.6)
    beside = axes.get_yaxis_transform()
    for place, value, share in zip(places, *parts[:2], strict=True):
        words = "unknown" if math.isnan(value) else f"{value:.3g}  ({100 * share:.3g} %)"
        axes.text(1.01, place, words, transform=beside, va="center", fontsize=9)
    name_rows(axes, [style.typeset(name) for name in names])
    axes.set_xlim(0.0, 1.04 * max(widths))


def draw_tornado(rows: Sequence[tuple[str, float, float, float]]) -> FigureWithData:
    """Return a tornado chart: the force at the low and the high value of each input, all others as in the base case."""
    swings = ((*row, float(np.nanmax(row[1:]) - np.nanmin(row[1:]))) for row in rows)
    ranked = sorted(swings, key=lambda row: -row[4])
    base_N = rows[0][3]
    with drawing(10.0, 1.5 + 0.34 * max(len(ranked), 2)) as (figure, axes):
        axes.set_xlabel(style.figure_label("lift_force_N"))
        _draw_swings(axes, ranked, base_N)
        style.legend_of_figure(figure)
        axes.set_title(f"base case {base_N:.4g} N; n = {len(ranked)} inputs, one changed at a time")
    spans = [f"{row[0]}: {style.shown(row[1])} to {style.shown(row[2], 'N')}" for row in ranked[:4]]
    alt = f"Lift force F_A, {style.shown(base_N, 'N')} in the base case, when one input changes at a time: "
    alt += f"{'; '.join(spans)}."
    header = ("quantity", "low_N", "high_N", "base_N", "swing_N")
    return FigureWithData(figure, (DataTable.of_rows(header, ranked),), alt)


def _draw_swings(axes: Axes, ranked: Sequence[tuple[str, float, float, float, float]], base_N: float) -> None:
    """Draw rows of name, force at the low and the high value, in the base case, and their width."""
    low, high = "input at its low value", "input at its high value"
    for column, color, hatch, label in ((1, style.ORANGE, "///", low), (2, style.BLUE, "", high)):
        forces_N = [float(row[column]) for row in ranked]
        ends = {place: force_N for place, force_N in enumerate(forces_N) if not math.isnan(force_N)}
        widths = [value_N - base_N for value_N in ends.values()]
        look: dict[str, Any] = {"edgecolor": style.INK, "linewidth": 0.6, "facecolor": color, "hatch": hatch}
        axes.barh([*ends], widths, left=base_N, height=0.6, label=label if ends else "", **look)
        for place, value_N in ends.items():
            side, ha = (4.0, "left") if value_N >= base_N else (-4.0, "right")
            style.note_at(axes, f"{value_N:.4g}", (value_N, place), side, ha=ha, va="center", fontsize=9)
    axes.axvline(base_N, color=style.INK, linewidth=1.2)
    widest = ranked[0][4] or 1.0
    reached = [value for row in ranked for value in row[1:4] if not math.isnan(value)]
    axes.set_xlim(min(reached) - 0.12 * widest, max(reached) + 0.12 * widest)
    name_rows(axes, [style.typeset(row[0]) for row in ranked])


_MARKERS_A_LINE = 8


def draw_design_chart(chart: DesignChart, *, design: Prediction | None = None) -> FigureWithData:
    """Return the chart of a design: F_A over the wrap for each wheel, on a logarithmic force axis.

    Solid lines are the mean law; the band below reaches down to what a pull with a new rope exceeds with the chart's
    probability. Lines are pale where wheel or wrap were not tested, and wraps tested for no wheel are hatched. A star
    marks the design with the interval of one pull.
    """
    n_wheels, n_wraps = chart.wheel_radius_m.size, chart.wrap_angle_rad.size
    radii_mm = [f"{1e3 * radius_m:.4g} mm" for radius_m in chart.wheel_radius_m.tolist()]
    with drawing(10.0, 5.0) as (figure, axes):
        # A law without a size effect has one line, drawn where most of it was tested.
        same = n_wheels > 1 and np.allclose(chart.lift_force_N, chart.lift_force_N[0], equal_nan=True)
        rows = [int(chart.extrapolated.sum(axis=1).argmin())] if same else range(n_wheels)
        sizes = [f"{radii_mm[0][:-3]} to {radii_mm[-1]}, the same"] if same else radii_mm
        for row, color, size in zip(rows, style.shades(len(rows)), sizes, strict=True):
            _draw_wheel(axes, chart, row, color, style.typeset(f"R_w = {size}"))
        style.hatch_untested(
            axes, np.degrees(chart.wrap_angle_rad), np.asarray(chart.extrapolated.all(axis=0))
        )
        if design is not None:
            _draw_design(axes, design)
        style.plain_log(axes, "y")
        axes.set(xlabel=style.regressor_label("wrap_angle_rad"), ylabel=style.figure_label("lift_force_N"))
        turns = axes.secondary_xaxis(
            "top", functions=(lambda deg: np.divide(deg, 360.0), lambda turn: np.multiply(turn, 360.0))
        )
        turns.set_xlabel("Wrap [turns]")
        axes.set_title(
            style.typeset(f"Lift force at F_B = {chart.end_tension_N:.4g} N; band: down to the force that ")
            + f"{100 * chart.probability:g} % of pulls exceed"
        )
        style.legend_below(axes, columns=4)
    forces_N = {name: getattr(chart, name).ravel() for name in ("lift_force_N", "lower_bound_N")}
    columns: dict[str, Any] = {
        "wheel_radius_m": np.repeat(chart.wheel_radius_m, n_wraps),
        "wrap_angle_rad": np.tile(chart.wrap_angle_rad, n_wheels),
        "end_tension_N": np.full(n_wheels * n_wraps, chart.end_tension_N),
        **{name: np.where(np.isfinite(found), found, np.nan) for name, found in forces_N.items()},
        "extrapolated": chart.extrapolated.ravel(),
    }
    low_deg, high_deg = np.degrees(chart.wrap_angle_rad[[0, -1]])
    alt = (
        f"Lift force over the wrap from {low_deg:.4g} to {high_deg:.4g} deg for {counted(n_wheels, 'wheel')} of radius "
        f"{', '.join(radii_mm).replace(' mm', '')} mm at an end tension of {chart.end_tension_N:.4g} N."
    )
    return FigureWithData(figure, (DataTable(columns),), alt)


def _draw_wheel(axes: Axes, chart: DesignChart, row: int, color: object, label: str) -> None:
    wrap_deg = np.degrees(chart.wrap_angle_rad)
    marker, every = style.MARKERS[row % len(style.MARKERS)], max(1, wrap_deg.size // _MARKERS_A_LINE)
    marked: dict[str, Any] = {"marker": marker, "markevery": every, "markersize": 4.5, "label": label}
    mean_N, low_N = (
        np.where(np.isfinite(one), one, np.nan) for one in (chart.lift_force_N[row], chart.lower_bound_N[row])
    )
    axes.fill_between(wrap_deg, low_N, mean_N, color=color, alpha=0.2, linewidth=0)
    axes.plot(wrap_deg, mean_N, color=color, alpha=0.3, linewidth=1.0)
    axes.plot(
        wrap_deg, np.where(chart.extrapolated[row], np.nan, mean_N), color=color, linewidth=1.5, **marked
    )


def _draw_design(axes: Axes, design: Prediction) -> None:
    """Mark the first wheel of a prediction, with the interval of one pull, or of the mean law where there is none."""
    lift_N, one_N = float(design.lift_force_N[0]), design.prediction_interval_N[0]
    ends_N = one_N if np.isfinite(one_N).all() else design.interval_N[0]
    look: dict[str, Any] = {"fmt": "*", "color": style.ORANGE, "markersize": 13, "capsize": 4, "zorder": 6}
    look |= {"markeredgecolor": style.INK, "label": f"design: {lift_N:.4g} N"}
    bars = np.abs(ends_N - lift_N).reshape(2, 1) if np.isfinite(ends_N).all() else None
    axes.errorbar(math.degrees(design.conditions.wrap_angle_rad[0]), lift_N, bars, **look)
