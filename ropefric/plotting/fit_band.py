"""A fitted law over one quantity, with where the law lies, where a new pull lies, and where nothing was tested."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.fitting.predict import REGRESSORS, predict
from ropefric.friction.condition import Conditions
from ropefric.glossary import counted
from ropefric.plotting.condition_points import answered, condition_points, same_settings, settings_of, swept
from ropefric.plotting.figure import DataTable, FigureWithData, new_figure
from ropefric.plotting.labels import figure_label, typeset
from ropefric.plotting.legend import legend_of_figure
from ropefric.plotting.style import BLUE, GREY, INK, ORANGE, house_style
from ropefric.plotting.words import regressor_label, shown, shown_regressor

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ropefric.fitting.result import FitResult


_STEPS = 121
_COVERAGE = 2.0
_BEYOND = 0.25
"""How far beyond the tested range the law is drawn, as a part of that range."""
_COLUMNS = ("lift_force_N", "low_N", "high_N", "new_rope_low_N", "new_rope_high_N")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Band:
    """The law on a grid: x in SI, five columns as in `_COLUMNS`, NaN where it has no answer."""

    x: "FloatArray"
    columns: "FloatArray"
    outside: BoolArray


def draw_fit_band(
    fit: "FitResult",
    *,
    over: str = "wrap_angle_rad",
    at: Mapping[str, float] | None = None,
    level: float = 0.95,
) -> FigureWithData:
    """Return F_A of a fitted law over one quantity with confidence and prediction band, extrapolation hatched.

    The upper panel has the forces on a logarithmic axis, the lower one the same off the mean law, in per cent. The
    inner band holds the mean law, the outer one a single pull with a new rope. Points are the means of the measured
    conditions that have the settings drawn, crosses their trials where the fit still has them.
    """
    settings = settings_of(fit, over, at)
    band = _band(fit, settings, over, level)
    points = condition_points(fit)
    chosen = same_settings(points.conditions, settings)
    measured_x, measured_N = getattr(points.conditions, over)[chosen], np.exp(points.log_lift[chosen])
    spread = np.nan_to_num(points.std_log[chosen])
    factor = REGRESSORS[over][2]
    with house_style():
        figure = new_figure(10.0, 7.0)
        axes, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        for panel, off in ((axes, False), (below, True)):
            lines = _off(band.columns, band.columns[0]) if off else band.columns
            _draw_band(panel, factor * band.x, lines, f"{100 * level:g} %")
            _hatch(panel, fit, over, band.x)
            if fit.problem is not None:
                mine = same_settings(fit.problem.conditions, settings)
                trials = (fit.problem.conditions.select(mine), np.exp(fit.problem.log_lift[mine]))
                x, forces = _placed(fit, *trials, over, off=off)
                panel.plot(x, forces, "x", color=GREY, markersize=4, label="one trial")
            means = points.conditions.select(chosen)
            x, middle = _placed(fit, means, measured_N, over, off=off)
            ends = [
                _placed(fit, means, measured_N * np.exp(side * _COVERAGE * spread), over, off=off)[1]
                for side in (-1.0, 1.0)
            ]
            panel.errorbar(
                x,
                middle,
                yerr=np.stack([middle - ends[0], ends[1] - middle]),
                fmt="o",
                color=INK,
                markersize=5.5,
                elinewidth=1.0,
                capsize=2.0,
                zorder=5,
                label="mean of a condition, ±2 u (k = 2)",
            )
        axes.set(ylabel=figure_label("lift_force_N"), yscale="log")
        axes.yaxis.set_major_formatter("{x:g}")
        axes.yaxis.set_minor_formatter("")
        below.set(xlabel=regressor_label(over), ylabel="Off the mean law [%]")
        if over == "end_tension_N":
            below.set_xscale("log")
            below.xaxis.set_major_formatter("{x:g}")
        axes.set_xlim(factor * band.x[0], factor * band.x[-1])
        held = ",  ".join(shown_regressor(name, value) for name, value in settings.items())
        n = int(points.n[chosen].sum())
        axes.set_title(
            typeset(f"Law {fit.law} at {held};  {counted(n, 'trial')} shown of {fit.statistics.n} fitted")
        )
        legend_of_figure(figure)
    return FigureWithData(
        figure=figure,
        tables=(
            DataTable(header=(over, *_COLUMNS, "extrapolated"), rows=_rows(band)),
            DataTable(
                name="measured",
                header=(over, "lift_force_N", "n", "std_log"),
                rows=tuple(
                    zip(
                        measured_x.tolist(),
                        measured_N.tolist(),
                        points.n[chosen].tolist(),
                        points.std_log[chosen].tolist(),
                        strict=True,
                    )
                ),
            ),
        ),
        alt=_alt(fit, over, band, level, n),
    )


def _band(fit: "FitResult", settings: Mapping[str, float], over: str, level: float) -> _Band:
    low, high = fit.validity[over]
    reach = _BEYOND * (high - low) or _BEYOND * high
    x = np.union1d(np.linspace(max(low - reach, 0.5 * low), high + reach, _STEPS), [low, high])
    conditions = swept(settings, over, x)
    columns = np.full((5, x.size), np.nan)
    good = answered(fit, conditions)
    if good.any():
        found = predict(fit, conditions.select(good), level=level, check=False)
        columns[:, good] = np.vstack([found.lift_force_N, found.interval_N.T, found.prediction_interval_N.T])
    columns[~np.isfinite(columns)] = np.nan
    return _Band(x=x, columns=columns, outside=(x < low * (1 - 1e-9)) | (x > high * (1 + 1e-9)))


def _off(values: "FloatArray", law_N: "FloatArray") -> "FloatArray":
    """Return how far forces lie off the law [%]."""
    return 100.0 * (values / law_N - 1.0)


def _placed(
    fit: "FitResult", conditions: Conditions, forces_N: "FloatArray", over: str, *, off: bool
) -> "tuple[FloatArray, FloatArray]":
    """Return where to draw measured forces: as they are, or off the law."""
    x = REGRESSORS[over][2] * getattr(conditions, over)
    if not off or not x.size:
        return x, forces_N
    return x, _off(forces_N, np.exp(fit.friction_law.log_lift(fit.theta, conditions)))


def _draw_band(axes: "Axes", x: "FloatArray", columns: "FloatArray", level: str) -> None:
    line, low, high, wide_low, wide_high = columns
    axes.fill_between(
        x,
        wide_low,
        wide_high,
        facecolor=(ORANGE, 0.15),
        edgecolor=ORANGE,
        linestyle="--",
        linewidth=1.0,
        label=f"{level} of new pulls",
    )
    axes.fill_between(x, low, high, facecolor=(BLUE, 0.4), linewidth=0, label=f"{level} for the mean law")
    axes.plot(x, line, "-", color=BLUE, linewidth=1.4, label="mean law")


def _hatch(axes: "Axes", fit: "FitResult", over: str, x: "FloatArray") -> None:
    low, high = fit.validity[over]
    factor = REGRESSORS[over][2]
    for start, stop in ((x[0], low), (high, x[-1])):
        if stop > start:
            axes.axvspan(
                factor * start,
                factor * stop,
                facecolor="none",
                edgecolor="#9A9A9A",
                hatch="///",
                linewidth=0.0,
                zorder=0.5,
                label="not tested: extrapolated",
            )


def _rows(band: _Band) -> tuple[tuple[object, ...], ...]:
    return tuple(
        (*row, outside)
        for row, outside in zip(
            np.column_stack([band.x, band.columns.T]).tolist(), band.outside.tolist(), strict=True
        )
    )


def _alt(fit: "FitResult", over: str, band: _Band, level: float, n: int) -> str:
    title, unit, factor = REGRESSORS[over]
    low, high = fit.validity[over]
    top = int(np.searchsorted(band.x, high))
    lift_N, low_N, high_N, wide_low_N, wide_high_N = band.columns[:, top].tolist()
    there = f"{factor * high:.4g} {unit}"
    return (
        f"Lift force of the law {fit.law} over the {title}, tested from {factor * low:.4g} to {there}, with "
        f"{counted(n, 'trial')}. At {there} it is {shown(lift_N, 'N')}, {100 * level:g} % confidence "
        f"{shown(low_N)} to {shown(high_N, 'N')}, new pulls {shown(wide_low_N)} to {shown(wide_high_N, 'N')}."
    )
