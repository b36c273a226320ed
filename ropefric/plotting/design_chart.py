"""Lift force over the wrap, a line a wheel: where a required load crosses, the wrap can be read off."""

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ropefric.errors import InputError
from ropefric.glossary import counted
from ropefric.plotting.figure import DataTable, FigureWithData, drawing, legend_below, note_at
from ropefric.plotting.style import INK, MARKERS, ORANGE, figure_label, regressor_label, shades, typeset

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ropefric.fitting.design import DesignChart


_MARKERS_A_LINE = 8


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
    n_wheels, n_wraps = chart.wheel_radius_m.size, chart.wrap_angle_rad.size
    radii_mm = [f"{1e3 * radius_m:.4g} mm" for radius_m in chart.wheel_radius_m.tolist()]
    wraps_rad: list[float] = []
    with drawing(9.0, 6.0) as figure:
        axes = figure.subplots()
        for row, color in enumerate(shades(n_wheels)):
            _draw_wheel(axes, chart, row, color, typeset(f"R_w = {radii_mm[row]}"))
        if required_N is not None:
            wraps_rad = [_smallest_wrap(chart, row, safety * required_N) for row in range(n_wheels)]
            _draw_load(axes, wraps_rad, required_N, safety)
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
    forces_N = {name: getattr(chart, name).ravel() for name in ("lift_force_N", "lower_bound_N")}
    columns: dict[str, Any] = {
        "wheel_radius_m": np.repeat(chart.wheel_radius_m, n_wraps),
        "wrap_angle_rad": np.tile(chart.wrap_angle_rad, n_wheels),
        "end_tension_N": np.full(n_wheels * n_wraps, chart.end_tension_N),
        **{name: np.where(np.isfinite(found), found, np.nan) for name, found in forces_N.items()},
        "extrapolated": chart.extrapolated.ravel(),
    }
    tables = [DataTable.of_columns(columns)]
    low_deg, high_deg = np.degrees(chart.wrap_angle_rad[[0, -1]])
    alt = (
        f"Lift force over the wrap from {low_deg:.4g} to {high_deg:.4g} deg for {counted(n_wheels, 'wheel')} of radius "
        f"{', '.join(radii_mm).replace(' mm', '')} mm at an end tension of {chart.end_tension_N:.4g} N."
    )
    if required_N is not None:
        asked = {"required_N": [float(required_N)] * n_wheels, "safety": [float(safety)] * n_wheels}
        needed = {"wheel_radius_m": chart.wheel_radius_m} | asked | {"wrap_angle_rad": wraps_rad}
        tables.append(DataTable.of_columns(needed, "smallest_wrap"))
        found = [
            f"{radius} needs {math.degrees(wrap):.4g} deg"
            if math.isfinite(wrap)
            else f"{radius} does not reach it"
            for radius, wrap in zip(radii_mm, wraps_rad, strict=True)
        ]
        load = f"{required_N:.4g} N" + (f" times {safety:g}" if safety != 1.0 else "")
        alt += f" For {load}, lifted with probability {chart.probability:g}: {'; '.join(found)}."
    return FigureWithData(figure=figure, tables=tuple(tables), alt=alt)


def _turns(degrees: Any) -> Any:
    return degrees / 360.0


def _degrees(turns: Any) -> Any:
    return turns * 360.0


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
    share = (math.log(needed_N) - low) / (high - low)
    return float(wrap_rad[i - 1] + share * (wrap_rad[i] - wrap_rad[i - 1]))


def _draw_load(axes: "Axes", wraps_rad: list[float], required_N: float, safety: float) -> None:
    needed_N = safety * required_N
    wraps_deg = np.degrees([wrap for wrap in wraps_rad if math.isfinite(wrap)])
    axes.plot(wraps_deg, np.full(wraps_deg.size, needed_N), "v", color=INK, markersize=8, zorder=6)
    for place, wrap_deg in enumerate(sorted(wraps_deg.tolist())):
        note_at(axes, f"{wrap_deg:.0f}°", (wrap_deg, needed_N), up=7.0 + 10.0 * (place % 3), zorder=6)
    line: dict[str, Any] = {"color": ORANGE, "linewidth": 1.5}
    if safety != 1.0:
        axes.axhline(needed_N, label=f"required × {safety:g}: {needed_N:.4g} N", linestyle="-.", **line)
    axes.axhline(required_N, label=f"required: {required_N:.4g} N", **line)


def _draw_wheel(axes: "Axes", chart: "DesignChart", row: int, color: object, label: str) -> None:
    wrap_deg = np.degrees(chart.wrap_angle_rad)
    marked: dict[str, Any] = {"marker": MARKERS[row % len(MARKERS)], "label": label, "markersize": 4.5}
    every = max(1, wrap_deg.size // _MARKERS_A_LINE)
    for found_N, style, look in (
        (chart.lift_force_N[row], "-", marked | {"markevery": every}),
        (chart.lower_bound_N[row], "--", {}),
    ):
        force_N = np.where(np.isfinite(found_N), found_N, np.nan)
        tested_N = np.where(chart.extrapolated[row], np.nan, force_N)
        axes.plot(wrap_deg, force_N, style, color=color, alpha=0.3, linewidth=1.0)
        axes.plot(wrap_deg, tested_N, style, color=color, linewidth=1.5, **look)
