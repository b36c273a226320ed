"""What a fitted law leaves over: against the fitted force, in the order of the trials, and against the normal law."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import ndtri

from ropefric.arrays import FloatArray
from ropefric.glossary import counted
from ropefric.plotting.condition_points import condition_points
from ropefric.plotting.figure import DataTable, FigureWithData, new_figure
from ropefric.plotting.labels import figure_label
from ropefric.plotting.legend import legend_of_figure
from ropefric.plotting.style import BLUE, INK, ORANGE, house_style
from ropefric.plotting.words import say_instead

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ropefric.fitting.result import FitResult


_LIMIT = 2.0
HEADER = ("order", "lift_force_N", "log_residual", "standardised", "normal_quantile")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Residuals:
    """Measured less fitted ln F_A, and that over its standard deviation; `noun` is what a point is."""

    noun: str
    lift_force_N: "FloatArray"
    log_residual: "FloatArray"
    standardised: "FloatArray"

    @property
    def quantile(self) -> "FloatArray":
        """Return the normal quantile of each, by rank (i − 1/2)/n."""
        n = self.standardised.size
        rank = np.empty(n)
        rank[np.argsort(self.standardised, kind="stable")] = np.arange(n)
        return np.asarray(ndtri((rank + 0.5) / n)) if n else np.empty(0)


def draw_residuals(fit: "FitResult") -> FigureWithData:
    """Return the standardised residuals of a fit, measured less fitted ln F_A, in three panels.

    A fit just made shows its trials in the order of the table; a loaded one only knows the means of its conditions
    and shows these, over their standard uncertainty, without the panel of the order. Points beyond ±2 are crosses.
    """
    found = _residuals(fit)
    z, quantile = found.standardised, found.quantile
    order = np.arange(1.0, z.size + 1.0)
    by_trial = fit.problem is not None
    beyond = int((np.abs(z) > _LIMIT).sum())
    with house_style():
        figure = new_figure(10.0, 4.2)
        panels = figure.subplots(1, 3 if by_trial else 2, sharey=True)
        panels[0].set(xlabel=figure_label("lift_force_N").replace(" [", ", fitted ["), xscale="log")
        panels[0].xaxis.set_major_formatter("{x:g}")
        _scatter(panels[0], found.lift_force_N, z)
        if by_trial:
            panels[1].set_xlabel("Trial, in the order of the table")
            _scatter(panels[1], order, z)
        panels[-1].set_xlabel("Normal quantile [-]")
        reach = float(np.abs(quantile).max(initial=1.0))
        panels[-1].plot([-reach, reach], [-reach, reach], "--", color=INK, linewidth=1.0, label="normal law")
        _scatter(panels[-1], quantile, z)
        panels[0].set_ylabel("Residual of ln F, standardised [-]")
        share = f"{beyond} of {z.size} beyond ±2" if z.size else "no trials stored with the fit"
        figure.suptitle(f"Law {fit.law}: {counted(z.size, found.noun)}, {share}")
        legend_of_figure(figure)
    columns = (order.astype(np.int64), found.lift_force_N, found.log_residual, z, quantile)
    rows = tuple(zip(*(column.tolist() for column in columns), strict=True))
    return FigureWithData(
        figure=figure, tables=(DataTable(header=HEADER, rows=rows),), alt=_alt(fit, found, beyond)
    )


def _residuals(fit: "FitResult") -> _Residuals:
    if fit.problem is not None:
        problem = fit.problem
        measured, std, noun = problem.log_lift, problem.std, "trial"
        fitted = fit.friction_law.log_lift(fit.theta, problem.conditions)
    else:
        points = condition_points(fit)
        measured, std, noun = points.log_lift, points.std_log, "condition mean"
        fitted = fit.friction_law.log_lift(fit.theta, points.conditions) if len(points) else np.empty(0)
    residual = measured - fitted
    usable = np.isfinite(residual) & np.isfinite(std) & (std > 0.0)
    return _Residuals(
        noun=noun,
        lift_force_N=np.exp(fitted[usable]),
        log_residual=residual[usable],
        standardised=residual[usable] / std[usable],
    )


def _scatter(axes: "Axes", x: "FloatArray", z: "FloatArray") -> None:
    axes.axhline(0.0, color=INK, linewidth=0.8)
    for limit in (-_LIMIT, _LIMIT):
        axes.axhline(limit, color=INK, linewidth=1.0, linestyle=":", label="±2 standard deviations")
    if not z.size:
        say_instead(axes, "nothing to show")
        return
    far = np.abs(z) > _LIMIT
    axes.plot(x[~far], z[~far], "o", color=BLUE, markersize=3.5, alpha=0.7, label="within ±2")
    axes.plot(x[far], z[far], "X", color=ORANGE, markersize=6, label="beyond ±2")


def _alt(fit: "FitResult", found: _Residuals, beyond: int) -> str:
    z = found.standardised
    if not z.size:
        return f"Residuals of the law {fit.law}: no trials are stored with the fit."
    worst = float(np.abs(z).max())
    rms = float(np.sqrt(np.mean(found.log_residual**2)))
    return (
        f"Standardised residuals of {counted(z.size, found.noun)} about the law {fit.law}: {beyond} lie beyond ±2, "
        f"the largest is {worst:.3g}. In force the residuals are {100 * rms:.3g} % (root mean square)."
    )
