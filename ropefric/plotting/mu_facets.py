"""The average coefficient against end tension, wrap and wheel: where it is flat, the capstan equation holds."""

from typing import TYPE_CHECKING, Any

import numpy as np

from ropefric.arrays import BoolArray
from ropefric.errors import InputError
from ropefric.fitting.predict import REGRESSORS
from ropefric.glossary import counted
from ropefric.plotting.condition_points import (
    ConditionPoints,
    answered,
    condition_points,
    same_settings,
    settings_of,
    swept,
)
from ropefric.plotting.figure import DataTable, FigureWithData, new_figure
from ropefric.plotting.labels import figure_label, typeset
from ropefric.plotting.legend import legend_of_figure
from ropefric.plotting.style import GREY, INK, house_style, line_look
from ropefric.plotting.words import regressor_label, say_instead, shown_regressor

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from ropefric.fitting.result import FitResult


FACETS = ("end_tension_N", "wrap_angle_rad", "wheel_radius_m")
"""What the coefficient is drawn against."""
HEADER = ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N", "n", "mu_average", "mu_std")
_COVERAGE = 2.0
_STEPS = 61


def draw_mu_facets(fits: "Sequence[FitResult]") -> FigureWithData:
    """Return three facets: μ̄ of every condition against F_B, φ and R_w, with the lines of the fitted laws.

    In each facet the filled points are the largest set of conditions that differ in its quantity alone, and the laws
    are drawn for the settings they share; the other conditions are small and hollow. Bars are ±2 standard
    uncertainties of the mean.
    """
    if not fits:
        raise InputError("there is no fit to draw", key="fits", fix="give at least one")
    points = condition_points(fits[0])
    rows: list[tuple[object, ...]] = []
    with house_style():
        figure = new_figure(10.0, 4.6)
        for axes, over in zip(figure.subplots(1, 3, sharey=True), FACETS, strict=True):
            axes.set_xlabel(regressor_label(over))
            settings = settings_of(fits[0], over, None)
            held = [name for name in FACETS if name != over]
            axes.set_title(
                typeset(",  ".join(shown_regressor(name, settings[name]) for name in held)), fontsize=9
            )
            if over == "end_tension_N":
                axes.set_xscale("log")
                axes.xaxis.set_major_formatter("{x:g}")
            for place, fit in enumerate(fits):
                rows += _draw_law(axes, fit, settings, over, place)
            _draw_points(axes, points, settings, over)
        figure.axes[0].set_ylabel(figure_label("mu_average"))
        n = int(points.n.sum())
        figure.suptitle(f"{counted(n, 'trial')}, {counted(len(points), 'condition')}; bars: ±2 u (k = 2)")
        legend_of_figure(figure)
    return FigureWithData(
        figure=figure,
        tables=(
            DataTable(header=HEADER, rows=_rows(points)),
            DataTable(name="laws", header=("against", "law", "x", "mu_average"), rows=tuple(rows)),
        ),
        alt=_alt(points, fits),
    )


def _draw_points(axes: "Axes", points: ConditionPoints, settings: dict[str, float], over: str) -> None:
    if not len(points):
        say_instead(axes, "no trials stored with the fit")
        return
    x = REGRESSORS[over][2] * getattr(points.conditions, over)
    chosen = same_settings(points.conditions, settings)
    bars = _COVERAGE * np.nan_to_num(points.mu_std)
    looks: tuple[tuple[BoolArray, dict[str, Any], str], ...] = (
        (~chosen, {"color": GREY, "markerfacecolor": "white", "markersize": 3.5}, "other conditions"),
        (chosen, {"color": INK, "markersize": 5.5, "zorder": 4}, "conditions as in the heading"),
    )
    for mask, look, label in looks:
        if mask.any():
            axes.errorbar(
                x[mask],
                points.mu[mask],
                yerr=bars[mask],
                fmt="o",
                elinewidth=1.0,
                capsize=2.0,
                label=label,
                **look,
            )


def _draw_law(
    axes: "Axes", fit: "FitResult", settings: dict[str, float], over: str, place: int
) -> list[tuple[object, ...]]:
    low, high = fit.validity[over]
    grid = np.geomspace(low, high, _STEPS) if over == "end_tension_N" else np.linspace(low, high, _STEPS)
    grid = grid[grid > 0.0]
    conditions = swept(settings, over, grid)
    mu = np.full(grid.size, np.nan)
    good = answered(fit, conditions) & (conditions.wrap_angle_rad > 0.0)
    if good.any():
        mu[good] = fit.friction_law.average_mu(fit.theta, conditions.select(good))
    axes.plot(REGRESSORS[over][2] * grid, mu, linewidth=1.6, label=fit.law, **line_look(place))
    return [(over, fit.law, float(x), float(y)) for x, y in zip(grid, mu, strict=True)]


def _rows(points: ConditionPoints) -> tuple[tuple[object, ...], ...]:
    at = points.conditions
    settings = (at.wheel_radius_m, at.rope_radius_m, at.wrap_angle_rad, at.end_tension_N)
    columns = (
        *(array.tolist() for array in settings),
        points.n.tolist(),
        points.mu.tolist(),
        points.mu_std.tolist(),
    )
    return tuple(zip(*columns, strict=True))


def _alt(points: ConditionPoints, fits: "Sequence[FitResult]") -> str:
    laws = ", ".join(fit.law for fit in fits)
    mu = points.mu[np.isfinite(points.mu)]
    if not mu.size:
        return f"Average friction coefficient of the laws {laws}; no trials are stored with the fit."
    k = counted(len(points), "condition")
    return (
        f"Average friction coefficient of {k} against end tension, wrap angle and wheel radius, with the laws "
        f"{laws}. It lies between {mu.min():.4g} and {mu.max():.4g}, mean {mu.mean():.4g}."
    )
