"""Lift force over the wrap, a line a wheel: where a required load crosses, the wrap can be read off."""

import math
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import colormaps

from ropefric.plotting.figure import DataTable, FigureWithData, new_figure
from ropefric.plotting.labels import figure_label, typeset
from ropefric.plotting.legend import legend_below
from ropefric.plotting.style import ORANGE, TRACE_COLORS, house_style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ropefric.fitting.design import DesignChart

__all__ = ["draw_design_chart"]

HEADER = (
    "wheel_radius_m",
    "wrap_angle_rad",
    "end_tension_N",
    "lift_force_N",
    "lower_bound_N",
    "extrapolated",
)


def draw_design_chart(chart: "DesignChart", *, required_N: float | None = None) -> FigureWithData:
    """Return the chart of a design: F_A over the wrap for each wheel, on a logarithmic force axis.

    Solid lines are the mean law, dashed ones what a pull with a new rope exceeds with the chart's probability; where
    the line is pale, the wheel or wrap lies outside what was tested.

    Parameters
    ----------
    chart : DesignChart
        From `ropefric.fitting.design.design_chart`.
    required_N : float, optional
        A load to draw across [N].

    Examples
    --------
    >>> from ropefric.fitting.design import DesignChart
    >>> grid = np.array([[10.0, 20.0]])
    >>> chart = DesignChart(
    ...     wheel_radius_m=np.array([0.04]), wrap_angle_rad=np.array([1.0, 2.0]), rope_radius_m=0.005,
    ...     end_tension_N=5.0, lift_force_N=grid, lower_bound_N=0.9 * grid, probability=0.95,
    ...     extrapolated=np.zeros((1, 2), dtype=bool))
    >>> draw_design_chart(chart).tables[0].rows[1][:4]
    (0.04, 2.0, 5.0, 20.0)
    """
    scale = colormaps[TRACE_COLORS]
    n_wheels = chart.wheel_radius_m.size
    with house_style():
        figure = new_figure(9.0, 6.0)
        axes = figure.subplots()
        for row, radius_m in enumerate(chart.wheel_radius_m):
            color = scale(0.85 * row / max(n_wheels - 1, 1))
            _draw_wheel(axes, chart, row, color, typeset(f"R_w = {1e3 * float(radius_m):.4g} mm"))
        if required_N is not None:
            axes.axhline(required_N, color=ORANGE, linewidth=1.5, label=f"required: {required_N:.4g} N")
        axes.set_yscale("log")
        axes.yaxis.set_major_formatter("{x:g}")
        axes.set(xlabel=typeset("Wrap angle φ [deg]"), ylabel=figure_label("lift_force_N"))
        axes.set_title(
            typeset(f"Lift force at F_B = {chart.end_tension_N:.4g} N; dashed: exceeded by ")
            + f"{100 * chart.probability:g} % of pulls with a new rope; pale: not tested"
        )
        legend_below(axes, columns=4)
    return FigureWithData(figure=figure, tables=(_table(chart),))


def _draw_wheel(axes: "Axes", chart: "DesignChart", row: int, color: object, label: str) -> None:
    wrap_deg = np.degrees(chart.wrap_angle_rad)
    outside = chart.extrapolated[row]
    for forces_N, style, name in (
        (chart.lift_force_N[row], "-", label),
        (chart.lower_bound_N[row], "--", None),
    ):
        shown_N = np.where(np.isfinite(forces_N), forces_N, np.nan)
        axes.plot(wrap_deg, shown_N, style, color=color, alpha=0.3, linewidth=1.0)
        axes.plot(wrap_deg, np.where(outside, np.nan, shown_N), style, color=color, linewidth=1.5, label=name)


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
