"""How well the data know each parameter, and which parameters they cannot tell apart."""

import math
from typing import TYPE_CHECKING

import numpy as np

from ropefric.glossary import counted
from ropefric.plotting.figure import DataTable, FigureWithData, new_figure
from ropefric.plotting.legend import legend_of_figure
from ropefric.plotting.style import BLUE, GREY, INK, ORANGE, house_style
from ropefric.plotting.words import say_instead, shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ropefric.fitting.profile import ProfileCurve, ProfileResult
    from ropefric.fitting.result import FitResult


_COLUMNS = 3
_ROOM = 0.3
_PARABOLA_STEPS = 61


def draw_profiles(profile: "ProfileResult", fit: "FitResult") -> FigureWithData:
    """Return Δχ² over each fitted parameter, with its interval and the parabola of the same width.

    Where curve and parabola part, the interval is skew and ± one standard error says too little. There is no parabola
    where the interval ends at a bound or nowhere.
    """
    place_of = {name: place for place, name in enumerate(fit.friction_law.parameter_names)}
    intervals: list[tuple[object, ...]] = []
    n_rows = max(1, math.ceil(len(profile.curves) / _COLUMNS))
    n_columns = min(_COLUMNS, max(1, len(profile.curves)))
    with house_style():
        figure = new_figure(10.0, 0.9 + 2.6 * n_rows)
        panels = figure.subplots(n_rows, n_columns, squeeze=False).ravel()
        for axes, curve in zip(panels, profile.curves, strict=False):
            place = place_of[curve.name]
            low, high = (float(end) for end in profile.ci[place])
            value, std = float(profile.theta[place]), fit.parameters[place].std
            _draw_curve(axes, curve, (low, value, high), symmetric=not profile.at_bound[place].any())
            axes.set_xlabel(f"{curve.name} [{fit.friction_law.parameters[place].unit}]")
            intervals.append((curve.name, value, low, high, float(std), curve.threshold))
        for axes in panels[len(profile.curves) :]:
            axes.remove()
        if profile.curves:
            for axes in panels[: len(profile.curves) : n_columns]:
                axes.set_ylabel("Δχ² [-]")
        else:
            figure.suptitle(f"Law {fit.law}: no parameter was fitted")
        if profile.curves:
            n = fit.statistics.n
            figure.suptitle(
                f"Law {fit.law}: {100 * profile.level:g} % profile intervals, {counted(n, 'trial')}"
            )
        legend_of_figure(figure)
    rows = [
        (curve.name, float(value), float(delta))
        for curve in profile.curves
        for value, delta in zip(curve.value, curve.delta_chi2, strict=True)
        if math.isfinite(delta)
    ]
    return FigureWithData(
        figure=figure,
        tables=(
            DataTable(header=("parameter", "value", "delta_chi2"), rows=tuple(rows)),
            DataTable(
                name="intervals",
                header=("parameter", "value", "low", "high", "std", "threshold"),
                rows=tuple(intervals),
            ),
        ),
        alt=_alt(profile, fit, intervals),
    )


def _draw_curve(
    axes: "Axes", curve: "ProfileCurve", interval: tuple[float, float, float], *, symmetric: bool
) -> None:
    low, value, high = interval
    seen = np.isfinite(curve.delta_chi2)
    axes.plot(curve.value[seen], curve.delta_chi2[seen], "-", color=BLUE, linewidth=1.8, label="profile")
    axes.axhline(curve.threshold, color=INK, linewidth=1.0, linestyle=":", label="threshold")
    for end in (low, high):
        if math.isfinite(end):
            axes.axvline(end, color=ORANGE, linewidth=1.0, linestyle="--", label="ends of the interval")
    axes.plot([value], [0.0], "o", color=INK, markersize=5, label="estimate")
    ends = [end if math.isfinite(end) else value for end in (low, high)]
    room = _ROOM * (ends[1] - ends[0])
    half = 0.5 * (high - low)
    if symmetric and math.isfinite(half) and half > 0.0 and curve.threshold > 0.0:
        x = np.linspace(value - 1.4 * half, value + 1.4 * half, _PARABOLA_STEPS)
        parabola = curve.threshold * ((x - value) / half) ** 2
        axes.plot(x, parabola, "-.", color=GREY, linewidth=1.2, label="parabola of the same width")
    if room > 0.0:
        axes.set_xlim(ends[0] - room, ends[1] + room)
        axes.set_ylim(-0.06 * curve.threshold, 2.0 * curve.threshold)
    axes.locator_params(axis="x", nbins=5)


def _alt(profile: "ProfileResult", fit: "FitResult", intervals: list[tuple[object, ...]]) -> str:
    if not intervals:
        return f"Profiles of the law {fit.law}: no parameter was fitted."
    spans = "; ".join(
        f"{name} {shown(float(value))} from {shown(float(low))} to {shown(float(high))}"  # type: ignore[arg-type]
        for name, value, low, high, *_ in intervals
    )
    return f"Profiles of Δχ² of the law {fit.law}, with {100 * profile.level:g} % intervals: {spans}."


def draw_correlation(fit: "FitResult") -> FigureWithData:
    """Return the correlation map of the fitted parameters: dark for strong, the number with its sign in the cell."""
    variance = np.diag(fit.covariance)
    kept = np.flatnonzero(np.isfinite(fit.covariance).all(axis=1) & (variance > 0.0))
    names = [fit.friction_law.parameter_names[i] for i in kept]
    std = np.sqrt(variance[kept])
    correlation = fit.covariance[np.ix_(kept, kept)] / np.outer(std, std)
    size = len(names)
    with house_style():
        figure = new_figure(2.4 + 0.8 * max(size, 2), 1.2 + 0.7 * max(size, 2))
        axes = figure.subplots()
        axes.grid(visible=False)
        if not size:
            say_instead(axes, "no parameter with a standard error")
        for row in range(size):
            for column in range(size):
                _cell(axes, row, column, float(correlation[row, column]))
        axes.set(xlim=(-0.5, max(size, 1) - 0.5), ylim=(max(size, 1) - 0.5, -0.5), aspect="equal")
        axes.set_xticks(range(size), names)
        axes.set_yticks(range(size), names)
        axes.tick_params(length=0)
        for spine in axes.spines.values():
            spine.set_visible(False)
        axes.set_title(f"Correlation [-], law {fit.law}")
    rows = tuple((names[i], names[j], float(correlation[i, j])) for i in range(size) for j in range(size))
    return FigureWithData(
        figure=figure,
        tables=(DataTable(header=("parameter", "other", "correlation"), rows=rows),),
        alt=_correlation_alt(fit.law, names, correlation),
    )


def _cell(axes: "Axes", row: int, column: int, r: float) -> None:
    shade = 1.0 - 0.75 * abs(r)
    color = (shade, shade, 1.0 - 0.4 * abs(r)) if r >= 0.0 else (1.0 - 0.15 * abs(r), shade, shade)
    axes.fill(
        [column - 0.49, column + 0.49, column + 0.49, column - 0.49],
        [row - 0.49, row - 0.49, row + 0.49, row + 0.49],
        facecolor=color,
        linewidth=0,
    )
    axes.text(column, row, f"{r:+.2f}", ha="center", va="center", color="white" if abs(r) > 0.6 else INK)


def _correlation_alt(law: str, names: list[str], correlation: "np.ndarray") -> str:
    if len(names) < 2:
        return f"Correlation map of the law {law}: {counted(len(names), 'parameter')} with a standard error."
    upper = np.triu(np.abs(correlation), 1)
    i, j = np.unravel_index(int(np.argmax(upper)), upper.shape)
    return (
        f"Correlation of the {len(names)} fitted parameters of the law {law}. The strongest is "
        f"{correlation[i, j]:+.3f} between {names[i]} and {names[j]}."
    )
