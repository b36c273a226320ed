"""The figure behind `plot()` of every result: which of the house's figures it is, and the plain ones of its own."""

import inspect
import io
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import partial, singledispatch
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError, Kind, UnknownNameError
from ropefric.fitting.compare import Comparison
from ropefric.fitting.design import QUANTITIES, Design
from ropefric.fitting.diagnose import Diagnosis
from ropefric.fitting.next_tests import LabPlan
from ropefric.fitting.predict import REGRESSORS, Prediction
from ropefric.fitting.result import FitResult
from ropefric.given import as_trace
from ropefric.glossary import GLOSSARY, counted
from ropefric.pipeline import CampaignRun
from ropefric.plotting import style
from ropefric.plotting.campaign import draw_extraction, draw_recording
from ropefric.plotting.design import draw_ladder, draw_statement, name_rows
from ropefric.plotting.figure import FigureWithData, drawing, on_axes, panels_of
from ropefric.plotting.fits import OTHERS, draw_fit_band
from ropefric.plotting.machines import draw_explanation, draw_sweep, scene_figures
from ropefric.scenes.draws import Draws
from ropefric.scenes.explain import Explanation
from ropefric.scenes.solve import Solution
from ropefric.scenes.sweep import Sweep
from ropefric.traces.breakaway import Breakaway, PickSettings, Status
from ropefric.traces.decision import pick_breakaway
from ropefric.traces.smoothing import SmoothedForce
from ropefric.traces.trace import ForceTrace
from ropefric.trials.campaign_model import Campaign
from ropefric.trials.outliers import Repeatability
from ropefric.trials.result import Extraction, TrialResult
from ropefric.trials.table import TrialTable
from ropefric.uncertainty.budget import Statement

_HOUSE: dict[type, Callable[..., FigureWithData]] = {
    FitResult: draw_fit_band,
    Sweep: draw_sweep,
    Comparison: draw_ladder,
    Extraction: draw_extraction,
    TrialResult: draw_recording,
    CampaignRun: lambda run: draw_extraction(run.extraction),
    Explanation: draw_explanation,
    Statement: draw_statement,
}
"""Results that the house has a figure of."""


def draw(result: Any, *args: Any, ax: Axes | None = None, **options: Any) -> Axes:
    """Return the axes a result is drawn on: `ax`, where they are given, else the first of a figure of its own.

    A fit takes `over`, a sweep or draws `quantity`, a break-away its trace. The axes may come first without a name.
    """
    if ax is None and args and isinstance(args[0], Axes):
        ax, args = args[0], args[1:]
    Kind((Axes,), "matplotlib axes").check_given(ax=ax)
    with on_axes(ax):
        axes = panels_of(_figure_of(result, *args, **options).figure)[0]
    if ax is None:
        # By this a notebook shows the figure, whatever backend it has: nothing is kept in a global list of figures.
        axes._repr_png_ = partial(_png, axes.figure)  # type: ignore[attr-defined]
    return axes


def _png(figure: Any) -> bytes:
    stream = io.BytesIO()
    with style.house_style():
        figure.savefig(stream, format="png")
    return stream.getvalue()


def _figure_of(result: Any, *args: Any, **options: Any) -> FigureWithData:
    made_by = _HOUSE.get(type(result))
    _refuse_strangers(made_by or paint.dispatch(type(result)), result, args, options)
    if made_by is not None:
        return made_by(result, *args, **options)
    if isinstance(result, Solution):
        for _, made in scene_figures(result):
            return made
    with drawing(8.0, 4.5) as (figure, axes):
        paint(result, axes, *args, **options)
        if axes.get_legend() is None and axes.get_legend_handles_labels()[0]:
            axes.legend()
    return FigureWithData(figure, ())


def _refuse_strangers(
    function: Callable[..., Any], result: Any, args: Sequence[Any], options: Mapping[str, Any]
) -> None:
    """Refuse arguments that the figure of a result does not take, by the name that the user gave them."""
    allowed = [one for one in [*inspect.signature(function).parameters.values()][1:] if one.name != "axes"]
    names = [one.name for one in allowed]
    places = sum(one.kind is one.POSITIONAL_OR_KEYWORD for one in allowed)
    unknown = [*(name for name in options if name not in names), *map(repr, args[places:])]
    if unknown:
        fix = f"plot() of a {type(result).__name__} takes {', '.join(['ax', *names])}"
        raise UnknownNameError(f"there is no argument {unknown[0]:.40}", key="plot", fix=fix)


@singledispatch
def paint(result: Any, _axes: Axes, *_args: Any, **_options: Any) -> None:
    """Draw a result on axes of its own."""
    raise InputError(f"there is no figure of {type(result).__name__}", fix="use to_frame()")


def _name_rows(axes: Axes, names: Sequence[str]) -> None:
    """Name the rows, the first on top, and make the figure as high as they need."""
    name_rows(axes, names)
    figure: Any = axes.figure
    if len(figure.axes) == 1:  # not one of the user's with other axes
        figure.set_figheight(1.6 + 0.4 * len(names))


@paint.register
def _(drawn: Draws, axes: Axes, *, quantity: str = "") -> None:
    name = quantity or next(iter(drawn.numbers))
    if name not in drawn.numbers:
        raise InputError(f"the draws have no {name!r}", fix=f"they have {', '.join(drawn.numbers)}")
    values, told = drawn.columns[name], drawn.numbers[name]
    axes.hist(values[np.isfinite(values)], bins=60, color=style.GREY)
    axes.axvline(told.value, color=style.BLUE, label="as given")
    for end in told.quantiles[::2]:
        label = f"{100.0 * drawn.level:g} % lie between" if end == told.quantiles[0] else ""
        axes.axvline(end, color=style.ORANGE, linestyle="--", label=label)
    axes.set(xlabel=style.figure_label(name) if name in GLOSSARY else name, ylabel="draws")


@paint.register
def _(trace: ForceTrace, axes: Axes, found: Breakaway | None = None) -> None:
    pull = pick_breakaway(trace, PickSettings())[0] if found is None else found
    axes.plot(trace.time_s, trace.force_N, color=style.GREY, linewidth=0.6, label="recorded")
    title = trace.name if pull.status is Status.OK else f"{trace.name}: {pull.status}"
    if pull.status is Status.OK:
        axes.axhline(pull.kinetic_N, color=style.BLUE, linestyle="--", label="kinetic")
        look: dict[str, Any] = {"fmt": "o", "color": style.ORANGE, "label": f"break-away {pull.peak_N:.4g} N"}
        axes.errorbar(pull.peak_time_s, pull.peak_N, 2.0 * pull.peak_std_N, zorder=4, **look)
    axes.set(xlabel="Time [s]", ylabel="Force [N]", title=title)


@paint.register
def _(found: Breakaway, axes: Axes, trace: Any = None) -> None:
    trace = found.trace if trace is None else trace
    if trace is None:
        text = "a break-away of a campaign does not keep its recording"
        raise InputError(text, key="trace", fix="write found.plot(trace)")
    paint(as_trace(trace), axes, found)


@paint.register
def _(smoothed: SmoothedForce, axes: Axes) -> None:
    label = f"mean over {1e3 * smoothed.window_s:.3g} ms" if smoothed.window_s else "as recorded"
    axes.plot(smoothed.time_s, smoothed.force_N, linewidth=0.8, label=label)
    axes.set(xlabel="Time [s]", ylabel="Force [N]")


@paint.register
def _(series: Repeatability, axes: Axes) -> None:
    means, stds = (series.mean_all, series.mean_kept), (series.std_all, series.std_kept)
    axes.errorbar(means, (0, 1), xerr=np.array(stds), fmt="o", capsize=3)
    axes.set(xlabel="Mean ± s", title=series.rule)
    _name_rows(axes, (f"all {series.n}", f"kept {series.n_kept}"))


@paint.register
def _(campaign: Campaign, axes: Axes) -> None:
    slack = campaign.protocol.needs_lift_force
    known = "lift_force_N" if slack else "end_tension_N"
    names = ("wheel_radius_m", "wrap_angle_rad", known)
    repeats = Counter(tuple(getattr(trial, name) for name in names) for trial in campaign.trials)
    settings = sorted(repeats)
    radius_m, wrap_rad, force_N = np.array(settings, dtype=np.float64).reshape(-1, 3).T
    # Conditions that differ in their tension alone stand beside each other.
    alike = [[one for one in settings if one[:2] == own[:2]] for own in settings]
    beside = [group.index(own) - 0.5 * (len(group) - 1) for own, group in zip(settings, alike, strict=True)]
    gap_m = np.diff(np.unique(radius_m)).min(initial=0.1 * radius_m.max(initial=1.0))
    x_mm = 1e3 * (radius_m + 0.7 * gap_m / max(map(len, alike), default=1) * np.array(beside))
    area = 9.0 * np.array([repeats[one] for one in settings])
    drawn = axes.scatter(x_mm, np.degrees(wrap_rad), s=area, c=force_N, cmap="cividis", edgecolors="white")
    axes.figure.colorbar(drawn, ax=axes).set_label(style.figure_label(known))
    if np.ptp(area) > 0.0:
        sizes = drawn.legend_elements("sizes", num=3, func=lambda area: np.asarray(area) / 9.0)
        axes.legend(*sizes, title="repeats")
    most = counted(max(repeats.values(), default=0), "repeat")
    axes.set_title(f"{campaign.name}: {counted(len(settings), 'condition')}, {most} at most (by area)")
    axes.set(xlabel=style.regressor_label(names[0]), ylabel=style.regressor_label(names[1]))


@paint.register
def _(table: TrialTable, axes: Axes) -> None:
    with np.errstate(all="ignore"):
        rise = np.log(table.peak_N / table.end_tension_N)
    _draw_wheels(axes, table, rise, table.used, marker="o", linestyle="none", markersize=4)
    axes.set_ylabel(style.typeset("ln(F_A/F_B) [-]"))


def _draw_wheels(axes: Axes, rows: Any, values: FloatArray, chosen: BoolArray, **look: Any) -> None:
    """Draw values of rows with settings over the wrap, a colour for each wheel."""
    radii_m = np.unique(rows.wheel_radius_m[chosen])
    for radius_m, color in zip(radii_m.tolist(), style.shades(len(radii_m)), strict=True):
        mine = chosen & (rows.wheel_radius_m == radius_m)
        label = f"wheel of {1e3 * radius_m:.4g} mm"
        axes.plot(np.degrees(rows.wrap_angle_rad[mine]), values[mine], color=color, label=label, **look)
    axes.set_xlabel(style.regressor_label("wrap_angle_rad"))


@paint.register
def _(prediction: Prediction, axes: Axes) -> None:
    x, lift_N = np.degrees(prediction.conditions.wrap_angle_rad), prediction.lift_force_N
    bands = (
        ("for one pull", prediction.prediction_interval_N, 1.0),
        ("for the mean law", prediction.interval_N, 3.0),
    )
    for words, interval_N, width in bands:
        look: dict[str, Any] = {"fmt": "o", "color": style.BLUE, "elinewidth": width, "capsize": 3}
        label = f"{100 * prediction.level:g} % {words}"
        axes.errorbar(x, lift_N, np.abs(interval_N.T - lift_N), label=label, **look)
    if prediction.trials:
        wraps_deg = np.degrees(prediction.trials["wrap_angle_rad"])
        look = OTHERS | {"label": "measured conditions, all settings", "zorder": 1}
        axes.plot(wraps_deg, np.exp(prediction.trials["mean_log_lift"]), "o", **look)
        style.plain_log(axes, "y")
    axes.set(xlabel=style.regressor_label("wrap_angle_rad"), ylabel=style.figure_label("lift_force_N"))
    axes.set_title(f"Law {prediction.law}")


@paint.register
def _(design: Design, axes: Axes) -> None:
    over = QUANTITIES[design.solve_for][0]
    x = REGRESSORS[over][2] * design.value
    axes.plot(x, design.lift_force_N, "o", label="mean law lifts")
    if design.probability is not None:
        axes.plot(x, design.lower_bound_N, "v", label=f"{100 * design.probability:g} % of pulls lift")
    axes.plot(x, design.required_N, "_", color=style.ORANGE, markersize=14, label="load")
    axes.set(xlabel=style.regressor_label(over), ylabel=style.figure_label("lift_force_N"))


@paint.register
def _(found: Diagnosis, axes: Axes) -> None:
    bars = [{"yes": 1.0, "no": -1.0}.get(cause.supported, 0.0) for cause in found.causes]
    axes.barh(range(len(bars)), bars, color=[style.BLUE if bar > 0.0 else style.GREY for bar in bars])
    axes.set_xticks((-1, 0, 1), ("not supported", "undetermined", "supported"))
    _name_rows(axes, [cause.cause for cause in found.causes])


@paint.register
def _(plan: LabPlan, axes: Axes) -> None:
    at = plan.conditions
    # The larger the wheel, the larger its mark, the smaller ones before it: none hides another.
    order = np.argsort(-at.wheel_radius_m, kind="stable")
    look: dict[str, Any] = {"s": 30.0 * (1.0 + at.wheel_radius_m / at.wheel_radius_m.min())[order]}
    look |= {"c": 1e3 * at.wheel_radius_m[order], "cmap": "cividis"}
    drawn = axes.scatter(np.degrees(at.wrap_angle_rad)[order], at.end_tension_N[order], **look)
    axes.figure.colorbar(drawn, ax=axes).set_label(style.regressor_label("wheel_radius_m"))
    axes.set(xlabel=style.regressor_label("wrap_angle_rad"), ylabel=style.regressor_label("end_tension_N"))
    axes.set_title(f"{len(plan)} conditions, {plan.repeats} pulls each")


@paint.register
def _(solution: Solution, axes: Axes) -> None:
    rows = solution.to_frame()
    certain = (rows["value"] == 0.0).to_numpy()
    off, half = 100.0 * rows[["low", "high"]].to_numpy().T, 100.0 * rows["value"].to_numpy()
    ends = np.divide(np.abs(off - half), np.abs(half), out=np.zeros_like(off), where=~certain)
    look: dict[str, Any] = {"fmt": "o", "capsize": 3}
    axes.errorbar(np.zeros(len(rows)), range(len(rows)), xerr=100.0 * np.nan_to_num(ends), **look)
    axes.set_xlabel(f"{100 * solution.level:g} % interval [%]")
    _name_rows(axes, [f"{row.quantity} = {row.value:.4g}" for row in rows.itertuples()])
