"""ln(F_A/F_B) against the wrap: a straight line through the origin is the capstan equation."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib import colormaps

from ropefric.errors import InputError
from ropefric.friction.condition import levels
from ropefric.glossary import counted
from ropefric.plotting.condition_points import ConditionPoints, answered, condition_points, settings_of, swept
from ropefric.plotting.figure import DataTable, FigureWithData, new_figure
from ropefric.plotting.labels import typeset
from ropefric.plotting.legend import legend_of_figure
from ropefric.plotting.style import INK, MARKERS, TRACE_COLORS, house_style, line_look
from ropefric.plotting.words import regressor_label, say_instead, shown_regressor

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from ropefric.fitting.result import FitResult


HEADER = (
    "wheel_radius_m",
    "rope_radius_m",
    "wrap_angle_rad",
    "end_tension_N",
    "n",
    "log_ratio",
    "log_ratio_std",
)
_COVERAGE = 2.0
_STEPS = 81


def euler_mu(points: ConditionPoints) -> float:
    """Return the slope of the straight line through the origin that fits ln(F_A/F_B) over φ best; NaN without one.

    Each condition counts once, Σ φ ln(F_A/F_B) / Σ φ².
    """
    wrap = points.conditions.wrap_angle_rad
    total = float(wrap @ wrap)
    return float(wrap @ points.log_rise) / total if total > 0.0 else float("nan")


def draw_capstan(fits: "Sequence[FitResult]") -> FigureWithData:
    """Return ln(F_A/F_B) of every condition against the wrap, Euler's straight line and the curves of fitted laws.

    The straight line is the law `constant` if it is among the fits, else the line through the origin that fits the
    conditions best. Wheels differ in marker and colour; bars are ±2 standard uncertainties of the mean.
    The laws are drawn for the settings that most conditions share.
    """
    if not fits:
        raise InputError("there is no fit to draw", key="fits", fix="give at least one")
    points = condition_points(fits[0])
    settings = settings_of(fits[0], "wrap_angle_rad", None)
    constant = next((fit for fit in fits if fit.law == "constant"), None)
    slope = euler_mu(points) if constant is None else constant["mu"].value
    with house_style():
        figure = new_figure(10.0, 5.6)
        axes = figure.subplots()
        farthest = max(
            fits[0].validity["wrap_angle_rad"][1], float(points.conditions.wrap_angle_rad.max(initial=0.0))
        )
        grid = np.linspace(0.0, 1.05 * farthest, _STEPS)
        rows: list[tuple[object, ...]] = []
        if np.isfinite(slope):
            axes.plot(
                np.degrees(grid),
                slope * grid,
                color=INK,
                linewidth=1.2,
                label=f"straight line, μ = {slope:.3g}",
            )
            rows += [("straight line", float(x), slope * float(x)) for x in grid]
        for place, fit in enumerate(fit for fit in fits if fit is not constant):
            rows += _draw_law(axes, fit, settings, grid, place)
        if len(points):
            _draw_points(axes, points)
        else:
            say_instead(axes, "no trials stored with the fit")
        axes.set(xlabel=regressor_label("wrap_angle_rad"), ylabel=typeset("ln(F_A/F_B) [-]"))
        axes.set_xlim(0.0, float(np.degrees(grid[-1])))
        axes.set_ylim(bottom=0.0)
        held = typeset(
            ", ".join(shown_regressor(name, settings[name]) for name in ("wheel_radius_m", "end_tension_N"))
        )
        n = int(points.n.sum())
        axes.set_title(
            f"{counted(n, 'trial')}, {counted(len(points), 'condition')}; bars: ±2 u (k = 2); laws drawn for {held}"
        )
        legend_of_figure(figure, columns=5)
    return FigureWithData(
        figure=figure,
        tables=(
            DataTable(header=HEADER, rows=_rows(points)),
            DataTable(name="laws", header=("law", "wrap_angle_rad", "log_ratio"), rows=tuple(rows)),
        ),
        alt=_alt(points, slope, fits),
    )


def _draw_law(
    axes: "Axes", fit: "FitResult", settings: dict[str, float], grid: np.ndarray, place: int
) -> list[tuple[object, ...]]:
    conditions = swept(settings, "wrap_angle_rad", grid)
    rise = np.full(grid.size, np.nan)
    good = answered(fit, conditions)
    if good.any():
        chosen = conditions.select(good)
        rise[good] = fit.friction_law.log_lift(fit.theta, chosen) - chosen.log_end_tension
    look = line_look(place + 1)
    axes.plot(np.degrees(grid), rise, linewidth=1.8, label=fit.law, **look)
    return [(fit.law, float(x), float(y)) for x, y in zip(grid, rise, strict=True)]


def _draw_points(axes: "Axes", points: ConditionPoints) -> None:
    radii_m = points.conditions.wheel_radius_m
    wheel = levels(radii_m)
    scale = colormaps[TRACE_COLORS]
    for place in range(int(wheel.max(initial=-1)) + 1):
        mask = wheel == place
        color = scale(0.85 * place / max(int(wheel.max()), 1))
        axes.errorbar(
            np.degrees(points.conditions.wrap_angle_rad[mask]),
            points.log_rise[mask],
            yerr=_COVERAGE * np.nan_to_num(points.std_log[mask]),
            fmt=MARKERS[place % len(MARKERS)],
            color=color,
            markeredgecolor="black",
            markeredgewidth=0.6,
            markersize=6,
            elinewidth=1.0,
            capsize=2.0,
            zorder=4,
            label=typeset(shown_regressor("wheel_radius_m", float(radii_m[mask][0]))),
        )


def _rows(points: ConditionPoints) -> tuple[tuple[object, ...], ...]:
    at = points.conditions
    arrays = (at.wheel_radius_m, at.rope_radius_m, at.wrap_angle_rad, at.end_tension_N, points.n)
    columns = [array.tolist() for array in (*arrays, points.log_rise, points.std_log)]
    return tuple(zip(*columns, strict=True))


def _alt(points: ConditionPoints, slope: float, fits: "Sequence[FitResult]") -> str:
    laws = ", ".join(fit.law for fit in fits)
    if not len(points):
        return f"ln(F_A/F_B) against the wrap angle by the laws {laws}; no trials are stored with the fit."
    off = points.log_rise - slope * points.conditions.wrap_angle_rad
    worst = float(np.abs(off).max())
    return (
        f"ln(F_A/F_B) of {counted(len(points), 'condition')} against the wrap angle, with the laws {laws}. The "
        f"straight line through the origin has slope {slope:.4g}; points lie up to {worst:.3g} off it, a factor of "
        f"{np.exp(worst):.3g} in force."
    )
