"""Fitted laws against what was measured: average coefficients, the capstan plot, bands over a quantity, residuals."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from scipy.special import ndtri

from ropefric.arrays import BoolArray, FloatArray, IntArray
from ropefric.errors import InputError, UnknownNameError
from ropefric.fitting.predict import REGRESSORS, predict
from ropefric.fitting.result import FitResult
from ropefric.friction.condition import SETTINGS, Conditions, along_one, levels
from ropefric.glossary import counted
from ropefric.plotting import style
from ropefric.plotting.figure import DataTable, FigureWithData, drawing
from ropefric.registry import did_you_mean

FACETS = ("end_tension_N", "wrap_angle_rad", "wheel_radius_m")
"""Quantities against which the average coefficient is drawn."""

_FACET_STEPS, _CAPSTAN_STEPS, _BAND_STEPS = 61, 81, 121
_BEYOND = 0.25
"""How far beyond the tested range a law is drawn, as a part of that range."""
_BAND = ("lift_force_N", "low_N", "high_N", "new_rope_low_N", "new_rope_high_N")
_LIMIT = 2.0
_NO_TRIALS = "no trials stored with the fit"
_BY_2U = "bars: ±2 u (k = 2)"
_BARS: dict[str, Any] = {"fmt": "o", "elinewidth": 1.0, "capsize": 2.0}
OTHERS: dict[str, Any] = {
    "label": "other conditions",
    "color": style.GREY,
    "markerfacecolor": "white",
    "markersize": 3.5,
}
_CHOSEN: dict[str, Any] = {"color": style.INK, "markersize": 5.5}


class ConditionPoints(NamedTuple):
    """The measured conditions behind a fit: how many trials, mean ln F_A and its standard uncertainty.

    `as_set` has the end tension that was set where `conditions` have the one that was measured.
    """

    conditions: Conditions
    as_set: Conditions
    n: IntArray
    log_lift: FloatArray
    std_log: FloatArray

    def table(self, **found: FloatArray) -> DataTable:
        """Return the settings as columns, how many trials rest on each, and what was found of them."""
        return DataTable({name: getattr(self.conditions, name) for name in SETTINGS} | {"n": self.n} | found)

    @property
    def log_rise(self) -> FloatArray:
        """Return ln(F_A/F_B), shape (k,)."""
        return self.log_lift - self.conditions.log_end_tension


def condition_points(fit: FitResult) -> ConditionPoints:
    """Return the conditions a fit rests on, from the summary that a stored fit carries too."""

    def column(name: str) -> FloatArray:
        return np.asarray(fit.trials.get(name, ()), dtype=np.float64)

    n, log_lift = column("n").astype(np.int64), column("mean_log_lift")
    within = fit.statistics.scatter_within
    repeats = np.full(n.size, within) if math.isfinite(within) else column("std_log_lift")
    parts = np.stack([repeats / np.sqrt(n), column("peak_std_N") * np.exp(-log_lift)])
    std = np.where(np.isnan(parts).all(axis=0), np.nan, np.hypot(*np.nan_to_num(parts)))
    conditions = Conditions(**{name: column(name) for name in SETTINGS})
    as_set = conditions
    if "end_tension_set_N" in fit.trials:
        as_set = replace(conditions, end_tension_N=column("end_tension_set_N"))
    return ConditionPoints(conditions=conditions, as_set=as_set, n=n, log_lift=log_lift, std_log=std)


def _settings_of(fit: FitResult, points: ConditionPoints, over: str) -> tuple[dict[str, Any], BoolArray]:
    """Return the settings to hold while one regressor is swept, and the conditions that have them, the largest group.

    The set values define the groups; the settings are the median of the measured values.
    """
    others, chosen = [name for name in SETTINGS if name != over], np.zeros(points.n.size, dtype=np.bool_)
    if not chosen.size:
        held = {name: math.sqrt(max(fit.validity[name][0], 0.0) * fit.validity[name][1]) for name in others}
        return held, chosen
    chosen[along_one(points.as_set, over)[0]] = True
    return {name: float(np.median(getattr(points.conditions, name)[chosen])) for name in others}, chosen


def _held(settings: dict[str, Any], names: Sequence[str] = SETTINGS, comma: str = ",  ") -> str:
    """Return settings that are held while one is swept, for a heading."""
    held = (style.shown_regressor(name, settings[name]) for name in names if name in settings)
    return style.typeset(comma.join(held))


def _evaluated(
    fit: FitResult, conditions: Conditions, law: Callable[[Conditions], npt.ArrayLike], rows: int = 1
) -> FloatArray:
    """Return what a law says of each condition, shape (rows, n), NaN where it has no answer that a float can hold."""
    n = len(conditions)
    values = np.full((rows, n), np.nan)
    try:
        good = fit.friction_law.log_lift(fit.theta, conditions) < math.log(np.finfo(np.float64).max)
    except InputError:
        halves = np.array_split(np.arange(n), 2) if n > 1 else []
        parts = [_evaluated(fit, conditions.select(half), law, rows) for half in halves]
        return np.hstack(parts) if parts else values
    if good.any():
        values[:, good] = law(conditions.select(good))
    values[~np.isfinite(values)] = np.nan
    return values


def _first(fits: Sequence[FitResult]) -> tuple[FitResult, ConditionPoints, str]:
    """Return the fit whose trials are drawn, its conditions, and how many they are in words."""
    if not fits:
        raise InputError("there is no fit to draw", key="fits", fix="give at least one")
    points = condition_points(fits[0])
    return fits[0], points, f"{counted(int(points.n.sum()), 'trial')}, {counted(points.n.size, 'condition')}"


def varied(fit: FitResult, among: Sequence[str] = FACETS) -> list[str]:
    """Return the regressors that the trials varied: over others there is nothing to see."""
    return [name for name in among if fit.validity[name][1] > fit.validity[name][0]]


def draw_mu_facets(fits: Sequence[FitResult]) -> FigureWithData:
    """Return μ̄ of every condition against those of F_B, φ and R_w that were varied, with the lines of fitted laws.

    In each facet the filled points are the largest set of conditions that differ in its quantity alone, and the laws
    are drawn for the settings they share; the other conditions are small and hollow. Bars are ±2 standard
    uncertainties of the mean.
    """
    first, points, counts = _first(fits)
    wrap_rad = points.conditions.wrap_angle_rad
    # μ̄ = ln(F_A/F_B)/φ has no value at a wrap of zero.
    with np.errstate(divide="ignore", invalid="ignore"):
        mu, mu_std = (
            np.where(wrap_rad > 0.0, y / wrap_rad, np.nan) for y in (points.log_rise, points.std_log)
        )
    rows: list[tuple[object, ...]] = []
    facets = varied(first) or [*FACETS]
    with drawing(10.0, 4.0, ncols=len(facets), sharey=True, squeeze=False) as (figure, grid):
        panels = grid[0]
        for axes, over in zip(panels, facets, strict=True):
            settings, chosen = _settings_of(first, points, over)
            axes.set_xlabel(style.regressor_label(over))
            axes.set_title(_held(settings, FACETS), fontsize=9)
            if over == "end_tension_N":
                style.plain_log(axes, "x")
            factor = REGRESSORS[over][2]
            for fit in fits:
                x, values = _average_mu(fit, settings, over)
                axes.plot(factor * x, values, linewidth=1.6, label=fit.law, **style.law_look(fit.law))
                rows += [(over, fit.law, *pair) for pair in zip(x.tolist(), values.tolist(), strict=True)]
            if not mu.size:
                style.say_instead(axes, _NO_TRIALS)
            x = factor * getattr(points.conditions, over)
            heading = _CHOSEN | {"label": "conditions as in the heading", "zorder": 4}
            for mask, look in ((~chosen, OTHERS), (chosen, heading)):
                if mask.any():
                    _draw_means(axes, x[mask], mu[mask], 2.0 * np.nan_to_num(mu_std[mask]), **look)
        panels[0].set_ylabel(style.figure_label("mu_average"))
        figure.suptitle(f"{counts}; {_BY_2U}")
        style.legend_of_figure(figure)
    laws, known = ", ".join(fit.law for fit in fits), mu[np.isfinite(mu)]
    alt = f"Average friction coefficient of the laws {laws}; no trials are stored with the fit."
    if known.size:
        alt = (
            f"Average friction coefficient of {counted(mu.size, 'condition')} against end tension, wrap angle and "
            f"wheel radius, with the laws {laws}. It lies between {known.min():.4g} and {known.max():.4g}, "
            f"mean {known.mean():.4g}."
        )
    drawn = DataTable.of_rows(("against", "law", "x", "mu_average"), rows, "laws")
    return FigureWithData(figure, (points.table(mu_average=mu, mu_std=mu_std), drawn), alt)


def _draw_means(axes: Axes, x: FloatArray, y: FloatArray, bars: FloatArray, **look: Any) -> None:
    """Draw means of conditions with their bars."""
    axes.errorbar(x, y, yerr=bars, **_BARS | look)


def _average_mu(fit: FitResult, settings: dict[str, Any], over: str) -> tuple[FloatArray, FloatArray]:
    space = np.geomspace if over == "end_tension_N" else np.linspace
    grid = space(*fit.validity[over], _FACET_STEPS)
    grid = grid[grid > 0.0]
    conditions = Conditions(**settings | {over: grid})
    if not conditions.wrap_angle_rad.all():
        return grid, np.full(grid.size, np.nan)
    return grid, _evaluated(fit, conditions, lambda at: fit.friction_law.average_mu(fit.theta, at))[0]


def draw_capstan(fits: Sequence[FitResult]) -> FigureWithData:
    """Return ln(F_A/F_B) of every condition against the wrap, Euler's straight line and the curves of fitted laws.

    The straight line is the law `constant` if it is among the fits, else the line through the origin that fits the
    conditions best. Wheels differ in marker and colour; bars are ±2 standard uncertainties of the mean.
    The laws are drawn for the settings that most conditions share.
    """
    first, points, counts = _first(fits)
    settings, _ = _settings_of(first, points, "wrap_angle_rad")
    wrap_rad, rise = points.conditions.wrap_angle_rad, points.log_rise
    constant = next((fit for fit in fits if fit.law == "constant"), None)
    # Through the origin, each condition once: Σ φ ln(F_A/F_B) / Σ φ².
    slope = float(wrap_rad @ rise) / total if (total := float(wrap_rad @ wrap_rad)) > 0.0 else math.nan
    if constant is not None:
        slope = constant["mu"].value
    farthest = max(first.validity["wrap_angle_rad"][1], float(wrap_rad.max(initial=0.0)))
    grid = np.linspace(0.0, 1.05 * farthest, _CAPSTAN_STEPS)
    along = Conditions(**settings | {"wrap_angle_rad": grid})
    curves = {"straight line": slope * grid} if math.isfinite(slope) else {}
    for fit in fits:
        if fit is not constant:
            lift = _evaluated(fit, along, lambda at, fit=fit: fit.friction_law.log_lift(fit.theta, at))  # type: ignore[misc]
            curves[fit.law] = lift[0] - along.log_end_tension
    laws = ", ".join(fit.law for fit in fits)
    alt = f"ln(F_A/F_B) against the wrap angle by the laws {laws}; no trials are stored with the fit."
    with drawing(10.0, 4.4) as (figure, axes):
        for law, curve in curves.items():
            straight = law == "straight line"
            look = style.law_look("constant" if straight else law) | {"linewidth": 1.2 if straight else 1.8}
            label = f"straight line, μ = {slope:.3g}" if straight else law
            axes.plot(np.degrees(grid), curve, label=label, **look)
        if rise.size:
            _draw_wheels(axes, points)
            worst = float(np.abs(rise - slope * wrap_rad).max())
            alt = (
                f"ln(F_A/F_B) of {counted(rise.size, 'condition')} against the wrap angle, with the laws {laws}. The "
                f"straight line through the origin has slope {slope:.4g}; points lie up to {worst:.3g} off it, a factor "
                f"of {math.exp(worst):.3g} in force."
            )
        else:
            style.say_instead(axes, _NO_TRIALS)
        axes.set(xlabel=style.regressor_label("wrap_angle_rad"), ylabel=style.typeset("ln(F_A/F_B) [-]"))
        axes.set_xlim(0.0, float(np.degrees(grid[-1])))
        axes.set_ylim(bottom=0.0)
        held = _held(settings, ("wheel_radius_m", "end_tension_N"), ", ")
        axes.set_title(f"{counts}; {_BY_2U}; laws drawn for {held}")
        style.legend_of_figure(figure)
    drawn = {"law": np.repeat([*curves], grid.size), "wrap_angle_rad": np.tile(grid, len(curves))}
    drawn["log_ratio"] = np.ravel([*curves.values()])
    tables = points.table(log_ratio=rise, log_ratio_std=points.std_log), DataTable(drawn, "laws")
    return FigureWithData(figure, tables, alt)


def _draw_wheels(axes: Axes, points: ConditionPoints) -> None:
    radii_m = points.conditions.wheel_radius_m
    wheel, x = levels(radii_m), np.degrees(points.conditions.wrap_angle_rad)
    edge = {"markersize": 6, "markeredgecolor": "black", "markeredgewidth": 0.6, "zorder": 4}
    for place, color in enumerate(style.shades(int(wheel.max()) + 1)):
        mask = wheel == place
        label = style.typeset(style.shown_regressor("wheel_radius_m", float(radii_m[mask][0])))
        look = {"color": color, "fmt": style.MARKERS[place % len(style.MARKERS)], "label": label} | edge
        _draw_means(axes, x[mask], points.log_rise[mask], 2.0 * np.nan_to_num(points.std_log[mask]), **look)


def draw_fit_band(fit: FitResult, *, over: str = "wrap_angle_rad") -> FigureWithData:
    """Return F_A of a fitted law over one quantity with confidence and prediction band, extrapolation hatched.

    The force axis is logarithmic. The inner band holds the mean law, the outer one a single pull with a new rope.
    Points are the means of the measured conditions that have the settings drawn, crosses their trials where the fit
    still has them.
    """
    if over not in REGRESSORS:
        raise UnknownNameError(
            f"there is no setting {over!r}", key="over", fix=did_you_mean(over, REGRESSORS)
        )
    points, (low, high) = condition_points(fit), fit.validity[over]
    settings, chosen = _settings_of(fit, points, over)
    x, columns = _band(fit, settings, over)
    means, mean_N = points.conditions.select(chosen), np.exp(points.log_lift[chosen])
    n = int(points.n[chosen].sum())
    title, unit, factor = REGRESSORS[over]
    outside = (x < low * (1 - 1e-9)) | (x > high * (1 + 1e-9))
    with drawing(5.2, 4.3) as (figure, axes):
        _draw_band(axes, factor * x, columns, fit.law)
        style.hatch_untested(axes, factor * x, outside)
        if fit.problem is not None:
            mine = chosen[fit.problem.group]
            at, force_N = fit.problem.conditions.select(mine), np.exp(fit.problem.log_lift[mine])
            axes.plot(
                factor * getattr(at, over), force_N, "x", color=style.GREY, markersize=4, label="one trial"
            )
        # The ends of a bar of ±2 u in ln F_A.
        below, above = np.abs(np.expm1(np.outer((-1.0, 1.0), 2.0 * np.nan_to_num(points.std_log[chosen]))))
        label = "mean of a condition, ±2 u (k = 2)"
        bars_N = np.stack([below, above]) * mean_N
        _draw_means(axes, factor * getattr(means, over), mean_N, bars_N, label=label, zorder=5, **_CHOSEN)
        axes.set(xlabel=style.regressor_label(over), ylabel=style.figure_label("lift_force_N"))
        style.plain_log(axes, "y")
        if over == "end_tension_N":
            style.plain_log(axes, "x")
        axes.set_xlim(factor * x[0], factor * x[-1])
        shown_trials = f"{counted(n, 'trial')} shown of {fit.statistics.n} fitted"
        axes.set_title(f"Law {style.typeset(fit.law)} at {_held(settings)}\n{shown_trials}", fontsize=9)
        style.legend_below(axes)
    law = {over: x} | dict(zip(_BAND, columns, strict=True)) | {"extrapolated": outside}
    measured = {over: getattr(means, over), "lift_force_N": mean_N}
    measured |= {"n": points.n[chosen], "std_log": points.std_log[chosen]}
    at_end = zip(columns[:, int(np.searchsorted(x, high))].tolist(), ("N", "", "N", "", "N"), strict=True)
    lift, low_N, high_N, wide_low_N, wide_high_N = (style.shown(force, of) for force, of in at_end)
    there = f"{factor * high:.4g} {unit}"
    alt = (
        f"Lift force of the law {fit.law} over the {title}, tested from {factor * low:.4g} to {there}, with "
        f"{counted(n, 'trial')}. At {there} it is {lift}, 95 % confidence {low_N} to "
        f"{high_N}, new pulls {wide_low_N} to {wide_high_N}."
    )
    return FigureWithData(figure, (DataTable(law), DataTable(measured, "measured")), alt)


def _band(fit: FitResult, settings: dict[str, Any], over: str) -> tuple[FloatArray, FloatArray]:
    """Return a grid in SI and the law on it, five columns as in `_BAND`, NaN where it has no answer."""
    low, high = fit.validity[over]
    beyond = _BEYOND * (high - low) or _BEYOND * high
    x = np.union1d(np.linspace(max(low - beyond, 0.5 * low), high + beyond, _BAND_STEPS), [low, high])

    def law(at: Conditions) -> FloatArray:
        found = predict(fit, at, level=0.95, method="linear")
        return np.vstack([found.lift_force_N, found.interval_N.T, found.prediction_interval_N.T])

    return x, _evaluated(fit, Conditions(**settings | {over: x}), law, len(_BAND))


def _draw_band(axes: Axes, x: FloatArray, columns: FloatArray, law: str) -> None:
    line, low, high, wide_low, wide_high = columns
    look = style.law_look(law)
    ink = look["color"]
    edge: dict[str, Any] = {"edgecolor": ink, "linestyle": "--", "linewidth": 1.0}
    axes.fill_between(x, wide_low, wide_high, facecolor=(ink, 0.13), label="95 % of new pulls", **edge)
    axes.fill_between(x, low, high, facecolor=(ink, 0.4), linewidth=0, label="95 % for the mean law")
    axes.plot(x, line, label="mean law", linewidth=1.4, **look)


def draw_residuals(fit: FitResult) -> FigureWithData:
    """Return the standardised residuals of a fit, measured less fitted ln F_A, in three panels.

    A fit just made shows its trials in the order of the table; a loaded one only knows the means of its conditions
    and shows these, over their standard uncertainty, without the panel of the order. Points beyond ±2 are crosses.
    """
    by_trial = fit.problem is not None
    fitted, residual, std = _residuals(fit)
    z = residual / std
    # The normal quantile of each, by rank (i − 1/2)/n.
    rank = np.argsort(np.argsort(z, kind="stable"), kind="stable")
    quantile = ndtri((rank + 0.5) / max(z.size, 1))
    order = np.arange(1, z.size + 1, dtype=np.int64)
    beyond = int((np.abs(z) > _LIMIT).sum())
    what = counted(z.size, "trial" if by_trial else "condition mean")
    drawn = {
        style.figure_label("lift_force_N").replace(" [", ", fitted ["): np.exp(fitted),
        **({"Trial, in the order of the table": order} if by_trial else {}),
        "Normal quantile [-]": quantile,
    }
    with drawing(10.0, 3.6, ncols=len(drawn), sharey=True) as (figure, panels):
        for axes, (label, x) in zip(panels, drawn.items(), strict=True):
            axes.set_xlabel(label)
            if x is quantile:
                ends = float(np.abs(quantile).max(initial=1.0)) * np.array([-1.0, 1.0])
                axes.plot(ends, ends, "--", color=style.INK, linewidth=1.0, label="normal law")
            _scatter(axes, x, z, fit.law)
        style.plain_log(panels[0], "x")
        panels[0].set_ylabel("Residual of ln F, standardised [-]")
        share = f"{beyond} of {z.size} beyond ±2" if z.size else _NO_TRIALS
        figure.suptitle(f"Law {fit.law}: {what}, {share}")
        style.legend_of_figure(figure)
    columns = {"order": order, "lift_force_N": np.exp(fitted), "log_residual": residual}
    columns |= {"standardised": z, "normal_quantile": quantile}
    alt = f"Residuals of the law {fit.law}: no trials are stored with the fit."
    if z.size:
        rms = float(np.sqrt(np.mean(residual**2)))
        alt = (
            f"Standardised residuals of {what} about the law {fit.law}: {beyond} lie beyond ±2, the largest is "
            f"{np.abs(z).max():.3g}. In force the residuals are {100 * rms:.3g} % (root mean square)."
        )
    return FigureWithData(figure, (DataTable(columns),), alt)


def _residuals(fit: FitResult) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return fitted ln F_A, measured less fitted, and its standard deviation, as far as there is one."""
    if fit.problem is not None:
        conditions, measured, std = fit.problem.conditions, fit.problem.log_lift, fit.problem.std
    else:
        points = condition_points(fit)
        conditions, measured, std = points.conditions, points.log_lift, points.std_log
    fitted = fit.friction_law.log_lift(fit.theta, conditions) if len(conditions) else np.empty(0)
    residual = measured - fitted
    usable = np.isfinite(residual) & np.isfinite(std) & (std > 0.0)
    return fitted[usable], residual[usable], std[usable]


def _scatter(axes: Axes, x: "FloatArray | IntArray", z: FloatArray, law: str) -> None:
    axes.axhline(0.0, color=style.INK, linewidth=0.8)
    for limit in (-_LIMIT, _LIMIT):
        axes.axhline(limit, color=style.INK, linewidth=1.0, linestyle=":", label="±2 standard deviations")
    if not z.size:
        style.say_instead(axes, "nothing to show")
        return
    far = np.abs(z) > _LIMIT
    color = style.law_look(law)["color"]
    axes.plot(x[~far], z[~far], "o", color=color, markersize=3.5, alpha=0.7, label="within ±2")
    axes.plot(x[far], z[far], "X", color=style.DARK_ORANGE, markersize=6, label="beyond ±2")
