"""Lift force over the wrap, a line a wheel: where a required load crosses, the wrap can be read off."""

import math
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import colormaps

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.glossary import counted
from ropefric.plotting.figure import DataTable, FigureWithData, legend_below, new_figure
from ropefric.plotting.labels import figure_label, regressor_label, typeset
from ropefric.plotting.style import INK, MARKERS, ORANGE, TRACE_COLORS, house_style

if TYPE_CHECKING:
    import numpy.typing as npt
    from matplotlib.axes import Axes

    from ropefric.fitting.design import DesignChart


_MARKERS_A_LINE = 8
HEADER = (
    "wheel_radius_m",
    "wrap_angle_rad",
    "end_tension_N",
    "lift_force_N",
    "lower_bound_N",
    "extrapolated",
)


def draw_design_chart(
    chart: "DesignChart", *, required_N: float | None = None, safety: float = 1.0
) -> FigureWithData:
    """Return the chart of a design: F_A over the wrap for each wheel, on a logarithmic force axis.

    Solid lines are the mean law, dashed ones what a pull with a new rope exceeds with the chart's probability; where
    the line is pale, the wheel or wrap lies outside what was tested. A triangle marks the smallest wrap whose dashed
    line reaches the required load times the safety factor.
    """
    for name, value in (("required_N", required_N), ("safety", safety)):
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise InputError(f"{name} is {value:g}; it must be positive and finite", key=name)
    scale = colormaps[TRACE_COLORS]
    n_wheels = chart.wheel_radius_m.size
    needed_N = None if required_N is None else safety * required_N
    wraps_rad = [
        math.nan if needed_N is None else _smallest_wrap(chart, row, needed_N) for row in range(n_wheels)
    ]
    with house_style():
        figure = new_figure(9.0, 6.0)
        axes = figure.subplots()
        for row, radius_m in enumerate(chart.wheel_radius_m):
            color = scale(0.85 * row / max(n_wheels - 1, 1))
            _draw_wheel(axes, chart, row, color, typeset(f"R_w = {1e3 * float(radius_m):.4g} mm"))
        if required_N is not None and needed_N is not None:
            _draw_load(axes, wraps_rad, required_N, needed_N, safety)
        axes.set_yscale("log")
        axes.yaxis.set_major_formatter("{x:g}")
        axes.set(xlabel=regressor_label("wrap_angle_rad"), ylabel=figure_label("lift_force_N"))
        turns = axes.secondary_xaxis("top", functions=(_turns, _degrees))
        turns.set_xlabel("Wrap [turns]")
        axes.set_title(
            typeset(f"Lift force at F_B = {chart.end_tension_N:.4g} N; dashed: exceeded by ")
            + f"{100 * chart.probability:g} % of pulls with a new rope; pale: not tested"
        )
        legend_below(axes, columns=4)
    tables = [_table(chart)]
    if required_N is not None:
        rows = [
            (float(radius_m), float(required_N), float(safety), float(wrap_rad))
            for radius_m, wrap_rad in zip(chart.wheel_radius_m, wraps_rad, strict=True)
        ]
        header = ("wheel_radius_m", "required_N", "safety", "wrap_angle_rad")
        tables.append(DataTable(name="smallest_wrap", header=header, rows=tuple(rows)))
    return FigureWithData(figure=figure, tables=tuple(tables), alt=_alt(chart, wraps_rad, required_N, safety))


def _turns(degrees: "npt.ArrayLike") -> "FloatArray":
    return np.asarray(degrees, dtype=np.float64) / 360.0


def _degrees(turns: "npt.ArrayLike") -> "FloatArray":
    return np.asarray(turns, dtype=np.float64) * 360.0


def _smallest_wrap(chart: "DesignChart", row: int, needed_N: float) -> float:
    """Return the first wrap whose lower bound reaches a force [rad], straight in ln F between the chart's columns."""
    bound_N, wrap_rad = chart.lower_bound_N[row], chart.wrap_angle_rad
    with np.errstate(invalid="ignore"):
        (reached,) = np.nonzero(bound_N >= needed_N)
    if not reached.size:
        return math.nan
    i = int(reached[0])
    if i == 0 or not math.isfinite(bound_N[i - 1]) or not math.isfinite(bound_N[i]):
        return float(wrap_rad[i])
    low, high = math.log(bound_N[i - 1]), math.log(bound_N[i])
    return float(
        wrap_rad[i - 1] + (math.log(needed_N) - low) / (high - low) * (wrap_rad[i] - wrap_rad[i - 1])
    )


def _draw_load(
    axes: "Axes", wraps_rad: list[float], required_N: float, needed_N: float, safety: float
) -> None:
    wraps_deg = np.degrees([wrap for wrap in wraps_rad if math.isfinite(wrap)])
    axes.plot(wraps_deg, np.full(wraps_deg.size, needed_N), "v", color=INK, markersize=8, zorder=6)
    for place, wrap_deg in enumerate(sorted(wraps_deg.tolist())):
        axes.annotate(
            f"{wrap_deg:.0f}°",
            (wrap_deg, needed_N),
            xytext=(0.0, 7.0 + 10.0 * (place % 3)),
            textcoords="offset points",
            ha="center",
            va="bottom",
            fontsize=8,
            zorder=6,
        )
    if safety != 1.0:
        label = f"required × {safety:g}: {needed_N:.4g} N"
        axes.axhline(needed_N, color=ORANGE, linewidth=1.5, linestyle="-.", label=label)
    axes.axhline(required_N, color=ORANGE, linewidth=1.5, label=f"required: {required_N:.4g} N")


def _draw_wheel(axes: "Axes", chart: "DesignChart", row: int, color: object, label: str) -> None:
    wrap_deg = np.degrees(chart.wrap_angle_rad)
    outside = chart.extrapolated[row]
    for forces_N, style, name in (
        (chart.lift_force_N[row], "-", label),
        (chart.lower_bound_N[row], "--", None),
    ):
        shown_N = np.where(np.isfinite(forces_N), forces_N, np.nan)
        axes.plot(wrap_deg, shown_N, style, color=color, alpha=0.3, linewidth=1.0)
        axes.plot(
            wrap_deg,
            np.where(outside, np.nan, shown_N),
            style,
            color=color,
            linewidth=1.5,
            marker=MARKERS[row % len(MARKERS)] if name else "",
            markersize=4.5,
            markevery=max(1, wrap_deg.size // _MARKERS_A_LINE),
            label=name,
        )


def _table(chart: "DesignChart") -> DataTable:
    rows = [
        (
            float(radius_m),
            float(wrap_rad),
            chart.end_tension_N,
            _number(chart.lift_force_N[i, j]),
            _number(chart.lower_bound_N[i, j]),
            bool(chart.extrapolated[i, j]),
        )
        for i, radius_m in enumerate(chart.wheel_radius_m)
        for j, wrap_rad in enumerate(chart.wrap_angle_rad)
    ]
    return DataTable(header=HEADER, rows=tuple(rows))


def _number(value: float) -> float:
    return float(value) if math.isfinite(value) else math.nan


def _alt(chart: "DesignChart", wraps_rad: list[float], required_N: float | None, safety: float) -> str:
    radii_mm = ", ".join(f"{1e3 * float(radius_m):.4g}" for radius_m in chart.wheel_radius_m)
    low_deg, high_deg = np.degrees(chart.wrap_angle_rad[[0, -1]])
    text = (
        f"Lift force over the wrap from {low_deg:.4g} to {high_deg:.4g} deg for {counted(len(wraps_rad), 'wheel')} "
        f"of radius {radii_mm} mm at an end tension of {chart.end_tension_N:.4g} N."
    )
    if required_N is None:
        return text
    found = [
        f"{1e3 * float(radius_m):.4g} mm needs {math.degrees(wrap):.4g} deg"
        if math.isfinite(wrap)
        else f"{1e3 * float(radius_m):.4g} mm does not reach it"
        for radius_m, wrap in zip(chart.wheel_radius_m, wraps_rad, strict=True)
    ]
    load = f"{required_N:.4g} N" + (f" times {safety:g}" if safety != 1.0 else "")
    return f"{text} For {load}, lifted with probability {chart.probability:g}: {'; '.join(found)}."
