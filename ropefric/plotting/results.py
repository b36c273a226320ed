"""The figure behind `plot()` of every result: which of the house's figures it is, and the plain ones of its own."""

from collections import Counter
from collections.abc import Callable, Sequence
from functools import singledispatch
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ropefric.errors import InputError
from ropefric.fitting.compare import Comparison
from ropefric.fitting.design import Design
from ropefric.fitting.diagnose import Diagnosis
from ropefric.fitting.export import FrictionTable
from ropefric.fitting.next_tests import LabPlan
from ropefric.fitting.predict import Prediction
from ropefric.fitting.result import FitResult
from ropefric.given import as_trace
from ropefric.glossary import GLOSSARY, counted
from ropefric.pipeline.run import CampaignRun
from ropefric.plotting import style
from ropefric.plotting.campaign import draw_overview
from ropefric.plotting.design import draw_budget, draw_ladder
from ropefric.plotting.figure import drawing
from ropefric.plotting.fits import draw_fit_band
from ropefric.plotting.machines import draw_explanation, draw_layout, draw_sweep, scene_figures
from ropefric.scenes.draws import Draws
from ropefric.scenes.plan import Explanation
from ropefric.scenes.scene import Scene
from ropefric.scenes.solve import Solution
from ropefric.scenes.sweep import Sweep
from ropefric.traces.breakaway import Breakaway, PickSettings, Status
from ropefric.traces.decision import pick_breakaway
from ropefric.traces.smoothing import SmoothedForce
from ropefric.traces.trace import ForceTrace
from ropefric.trials.campaign_model import Campaign
from ropefric.trials.outliers import Repeatability
from ropefric.trials.result import Extraction
from ropefric.trials.table import TrialTable
from ropefric.uncertainty.budget import Statement

_WORDS = {"yes": 1.0, "no": -1.0}


@singledispatch
def draw(result: Any, *_args: Any, **_options: Any) -> Figure:
    """Return the figure of a result; a fit takes `over`, a sweep or draws `quantity`, a break-away its trace."""
    raise InputError(f"there is no figure of {type(result).__name__}", fix="use to_frame()")


def _simple(
    x_label: str, y_label: str, paint: Callable[[Axes], None], *, names: Sequence[str] = (), title: str = ""
) -> Figure:
    """Return a figure with one panel; `names` are the words of the rows from above."""
    with drawing(8.0, 4.5 if not names else 1.6 + 0.4 * len(names)) as figure:
        axes = figure.subplots()
        paint(axes)
        axes.set(xlabel=x_label, ylabel=y_label)
        axes.set_title(style.figure_text(title))
        if names:
            axes.set_yticks(range(len(names)), [style.figure_text(name) for name in names])
            axes.set_ylim(len(names) - 0.5, -0.5)
        elif axes.get_legend_handles_labels()[0]:
            axes.legend()
    return figure


@draw.register
def _(drawn: Draws, *, quantity: str = "") -> Figure:
    name = quantity or next(iter(drawn.numbers))
    if name not in drawn.numbers:
        raise InputError(f"the draws have no {name!r}", fix=f"they have {', '.join(drawn.numbers)}")
    values, told = drawn.columns[name], drawn.numbers[name]

    def paint(axes: Axes) -> None:
        axes.hist(values[np.isfinite(values)], bins=60, color=style.GREY)
        axes.axvline(told.value, color=style.BLUE, label="as given")
        for end in told.quantiles[::2]:
            label = f"{100.0 * drawn.level:g} % lie between" if end == told.quantiles[0] else ""
            axes.axvline(end, color=style.ORANGE, linestyle="--", label=label)

    label = style.figure_label(name) if name in GLOSSARY else name
    return _simple(label, "draws", paint)


@draw.register
def _(trace: ForceTrace, found: Breakaway | None = None) -> Figure:
    pull = pick_breakaway(trace, PickSettings())[0] if found is None else found

    def paint(axes: Axes) -> None:
        axes.plot(trace.time_s, trace.force_N, color=style.GREY, linewidth=0.6, label="recorded")
        if pull.status is Status.OK:
            axes.axhline(pull.kinetic_N, color=style.BLUE, linestyle="--", label="kinetic")
            label = f"break-away {pull.peak_N:.4g} N"
            axes.errorbar(
                pull.peak_time_s,
                pull.peak_N,
                2.0 * pull.peak_std_N,
                fmt="o",
                color=style.ORANGE,
                label=label,
                zorder=4,
            )

    title = trace.name if pull.status is Status.OK else f"{trace.name}: {pull.status}"
    return _simple("Time [s]", "Force [N]", paint, title=title)


@draw.register
def _(found: Breakaway, trace: Any = None) -> Figure:
    if trace is None:
        raise InputError(
            "a break-away does not keep its recording", key="trace", fix="write found.plot(trace)"
        )
    return draw(as_trace(trace), found)


@draw.register
def _(smoothed: SmoothedForce) -> Figure:
    label = f"mean over {1e3 * smoothed.window_s:.3g} ms"
    return _simple(
        "Time [s]", "Force [N]", lambda axes: _line(axes, smoothed.time_s, smoothed.force_N, label)
    )


def _line(axes: Axes, x: Any, y: Any, label: str) -> None:
    axes.plot(x, y, linewidth=0.8, label=label)


@draw.register
def _(series: Repeatability) -> Figure:
    means, stds = (series.mean_all, series.mean_kept), (series.std_all, series.std_kept)

    def paint(axes: Axes) -> None:
        axes.errorbar(means, (0, 1), xerr=np.array(stds), fmt="o", capsize=3)

    names = (f"all {series.n}", f"kept {series.n_kept}")
    return _simple("Mean ± s", "", paint, names=names, title=series.rule)


@draw.register
def _(campaign: Campaign) -> Figure:
    slack = campaign.protocol.needs_lift_force
    known, label = (
        ("lift_force_N", "Known force F_A [N]")
        if slack
        else ("end_tension_N", style.regressor_label("end_tension_N"))
    )
    names = ("wheel_radius_m", "wrap_angle_rad", known)
    repeats = Counter(tuple(getattr(trial, name) for name in names) for trial in campaign.trials)
    settings = sorted(repeats)
    radius_m, wrap_rad, force_N = np.array(settings, dtype=np.float64).reshape(-1, 3).T
    # Conditions that differ in their tension alone stand beside each other.
    alike = [[one for one in settings if one[:2] == own[:2]] for own in settings]
    beside = [group.index(own) - 0.5 * (len(group) - 1) for own, group in zip(settings, alike, strict=True)]
    gap_m = np.diff(np.unique(radius_m)).min(initial=0.1 * radius_m.max(initial=1.0))
    x_mm = 1e3 * (radius_m + 0.7 * gap_m / max(map(len, alike), default=1) * np.array(beside))

    def paint(axes: Axes) -> None:
        area = 9.0 * np.array([repeats[one] for one in settings])
        drawn = axes.scatter(
            x_mm, np.degrees(wrap_rad), s=area, c=force_N, cmap="cividis", edgecolors="white"
        )
        axes.figure.colorbar(drawn, ax=axes).set_label(label)
        if np.ptp(area) > 0.0:
            axes.legend(
                *drawn.legend_elements("sizes", num=3, func=lambda area: np.asarray(area) / 9.0),
                title="repeats",
            )

    most = max(repeats.values(), default=0)
    title = (
        f"{campaign.name}: {counted(len(settings), 'condition')}, {counted(most, 'repeat')} at most (by area)"
    )
    return _simple(
        style.regressor_label("wheel_radius_m"), style.regressor_label("wrap_angle_rad"), paint, title=title
    )


@draw.register
def _(scene: Scene) -> Figure:
    return draw_layout(scene).figure


@draw.register
def _(table: TrialTable) -> Figure:
    def paint(axes: Axes) -> None:
        radii_m = np.unique(table.wheel_radius_m[table.used])
        for radius_m, color in zip(radii_m.tolist(), style.shades(len(radii_m)), strict=True):
            mine = table.used & (table.wheel_radius_m == radius_m)
            rise = np.log(table.peak_N[mine] / table.end_tension_N[mine])
            label = f"wheel of {1e3 * radius_m:.4g} mm"
            axes.plot(
                np.degrees(table.wrap_angle_rad[mine]), rise, "o", color=color, markersize=4, label=label
            )

    return _simple(style.regressor_label("wrap_angle_rad"), style.typeset("ln(F_A/F_B) [-]"), paint)


@draw.register
def _(prediction: Prediction) -> Figure:
    at, lift_N = prediction.conditions, prediction.lift_force_N

    def paint(axes: Axes) -> None:
        x = np.degrees(at.wrap_angle_rad)
        bands = (
            ("one pull", prediction.prediction_interval_N, 1.0),
            ("mean law", prediction.interval_N, 3.0),
        )
        for words, interval_N, width in bands:
            ends = np.abs(interval_N.T - lift_N)
            label = f"{100 * prediction.level:g} % of the {words}"
            axes.errorbar(
                x, lift_N, ends, fmt="o", color=style.BLUE, elinewidth=width, capsize=3, label=label
            )

    title = f"Law {prediction.law}"
    return _simple(
        style.regressor_label("wrap_angle_rad"), style.figure_label("lift_force_N"), paint, title=title
    )


@draw.register
def _(table: FrictionTable) -> Figure:
    end_N = float(np.median(table.end_tension_N))
    radii_m = np.unique(table.wheel_radius_m)

    def paint(axes: Axes) -> None:
        for radius_m, color in zip(radii_m.tolist(), style.shades(len(radii_m)), strict=True):
            mine = (table.wheel_radius_m == radius_m) & (table.end_tension_N == end_N)
            label = f"wheel of {1e3 * radius_m:.4g} mm"
            axes.plot(
                np.degrees(table.wrap_angle_rad[mine]), table.mu_average[mine], color=color, label=label
            )
        label = f"constant, {100 * table.constant_error:.3g} % off at most"
        axes.axhline(table.constant_mu, color=style.ORANGE, linestyle="--", label=label)

    labels = (style.regressor_label("wrap_angle_rad"), style.figure_label("mu_average"))
    return _simple(*labels, paint, title=f"Law {table.law} at F_B = {end_N:.4g} N")


@draw.register
def _(design: Design) -> Figure:
    names = {"wrap": "wrap_angle_rad", "radius": "wheel_radius_m", "end_tension": "end_tension_N"}
    over = names[design.solve_for]
    factor = {"wrap": np.degrees(1.0), "radius": 1e3, "end_tension": 1.0}[design.solve_for]

    def paint(axes: Axes) -> None:
        axes.plot(factor * design.value, design.lift_force_N, "o", label="mean law lifts")
        if design.probability is not None:
            label = f"{100 * design.probability:g} % of pulls lift"
            axes.plot(factor * design.value, design.lower_bound_N, "v", label=label)
        axes.plot(
            factor * design.value, design.required_N, "_", color=style.ORANGE, markersize=14, label="load"
        )

    return _simple(style.regressor_label(over), style.figure_label("lift_force_N"), paint)


@draw.register
def _(found: Diagnosis) -> Figure:
    bars = [_WORDS.get(cause.supported, 0.0) for cause in found.causes]

    def paint(axes: Axes) -> None:
        axes.barh(range(len(bars)), bars, color=[style.BLUE if bar > 0.0 else style.GREY for bar in bars])
        axes.set_xticks((-1, 0, 1), ("not supported", "undecided", "supported"))

    return _simple("", "", paint, names=[cause.cause for cause in found.causes])


@draw.register
def _(plan: LabPlan) -> Figure:
    at = plan.conditions

    def paint(axes: Axes) -> None:
        drawn = axes.scatter(
            np.degrees(at.wrap_angle_rad), at.end_tension_N, c=1e3 * at.wheel_radius_m, cmap="cividis"
        )
        axes.figure.colorbar(drawn, ax=axes).set_label(style.regressor_label("wheel_radius_m"))

    title = f"{len(plan)} conditions, {plan.repeats} pulls each"
    labels = (style.regressor_label("wrap_angle_rad"), style.regressor_label("end_tension_N"))
    return _simple(*labels, paint, title=title)


@draw.register
def _(solution: Solution) -> Figure:
    for _, figure in scene_figures(solution):
        return figure.figure
    rows = solution.to_frame()
    certain = (rows["value"] == 0.0).to_numpy()
    off, half = 100.0 * rows[["low", "high"]].to_numpy().T, 100.0 * rows["value"].to_numpy()
    ends = np.divide(np.abs(off - half), np.abs(half), out=np.zeros_like(off), where=~certain)

    def paint(axes: Axes) -> None:
        axes.errorbar(
            np.zeros(len(rows)), range(len(rows)), xerr=100.0 * np.nan_to_num(ends), fmt="o", capsize=3
        )

    names = [f"{row.quantity} = {row.value:.4g}" for row in rows.itertuples()]
    return _simple(f"{100 * solution.level:g} % interval [%]", "", paint, names=names)


@draw.register
def _(stated: Statement) -> Figure:
    rows = [(line.label, line.contribution) for line in stated.budget.lines]
    model = stated.model
    combined = stated.budget.combined
    return draw_budget(rows, unit=model.unit, title=model.name, combined=combined).figure


@draw.register
def _(fit: FitResult, *, over: str = "wrap_angle_rad") -> Figure:
    return draw_fit_band(fit, over=over).figure


@draw.register
def _(sweep: Sweep, *, quantity: str = "") -> Figure:
    return draw_sweep(sweep, quantity=quantity).figure


@draw.register
def _(comparison: Comparison) -> Figure:
    return draw_ladder(comparison).figure


@draw.register
def _(extraction: Extraction) -> Figure:
    return draw_overview(extraction).figure


@draw.register
def _(run: CampaignRun) -> Figure:
    return draw_overview(run.extraction).figure


@draw.register
def _(told: Explanation) -> Figure:
    return draw_explanation(told).figure
