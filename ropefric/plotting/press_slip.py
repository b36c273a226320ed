"""Slip of the rollers of a press over speed or preload: figures 5 and 6 of the paper, by any measure."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib import colormaps

from ropefric.plotting.figure import DataTable, FigureWithData, new_figure
from ropefric.plotting.press_axes import line_axis, name_lines, same_lines, span_of
from ropefric.plotting.style import LINE_STYLES, ORANGE, TRACE_COLORS, house_style

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ropefric.friction.condition import FloatArray
    from ropefric.systems.press.sweep import PressSweep

__all__ = ["MEASURE_LABELS", "draw_press_slip"]

MEASURE_LABELS = {
    "utilisation": "Utilisation U of the friction [-]",
    "log": "Share of the friction needed ln(T'_hi/T'_lo)/M [-]",
    "mu_required": "Coefficient required [-]",
    "as_printed": "Slip factor Λ as printed, eq. (38) [-]",
    "as_plotted": "Slip factor Λ, inverted ratio [-]",
}
# Below this a measure that is 0 without torque shows rounding.
_NOTHING = 1e-9


def draw_press_slip(
    sweep: "PressSweep", *, measure: str = "utilisation", rollers: "Sequence[str] | None" = None
) -> FigureWithData:
    """Return the figure of one measure of slip, a line a roller, on a logarithmic axis with the limit drawn across.

    Rollers without torque have no place on it where the measure is 0; the title names them.

    Parameters
    ----------
    sweep : PressSweep
        Over speed or over preload.
    measure : str
        A key of `MEASURE_LABELS`.
    rollers : sequence of str, optional
        Which to draw; all by default.

    Returns
    -------
    FigureWithData
        With a row a point and roller.

    Raises
    ------
    InputError
        If the sweep goes over both quantities.
    UnknownNameError
        For an unknown measure or roller.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> slip = SimpleNamespace(of=lambda roller, measure: np.array([[0.5, 0.6]]))
    >>> sweep = SimpleNamespace(preload_N=np.empty(0), speed_m_s=np.array([0.0, 1.0]), rollers=("2",), slip=slip)
    >>> draw_press_slip(sweep).tables[0].rows[1]
    (1.0, '2', 0.6)
    """
    column, label, across = line_axis(sweep)
    chosen = tuple(sweep.rollers if rollers is None else rollers)
    values = np.column_stack([sweep.slip.of(roller, measure).reshape(-1) for roller in chosen])
    idle = [roller for roller, line in zip(chosen, values.T, strict=True) if line.max() < _NOTHING]
    lines = [
        (name.replace("roller_", ""), line)
        for name, line in same_lines(chosen, values, "roller")
        if line.max() >= _NOTHING
    ]
    scale = colormaps[TRACE_COLORS]
    with house_style():
        figure = new_figure(9.0, 6.0, margins={"left": 0.09, "right": 0.86, "top": 0.92, "bottom": 0.1})
        axes = figure.subplots()
        for i, (_, line) in enumerate(lines):
            color = scale(0.85 * i / max(len(lines) - 1, 1))
            axes.plot(across, _drawable(line), color=color, linestyle=LINE_STYLES[i % 4], linewidth=1.6)
        axes.set_yscale("log")
        axes.yaxis.set_major_formatter("{x:g}")
        axes.set(xlabel=label, ylabel=_typeset_label(measure), xlim=(across[0], across[-1]))
        if measure != "mu_required":
            axes.axhline(1.0, color=ORANGE, linewidth=1.5)
            axes.text(
                across[0], 1.0, " slip begins" if measure in {"utilisation", "log"} else " 1", va="bottom"
            )
        axes.set_title(_title(idle))
        ends = [(f"roller {name}", float(line[-1])) for name, line in lines if np.isfinite(line[-1])]
        name_lines(axes, ends)
    rows = tuple(
        (float(x), roller, float(values[i, j]))
        for i, x in enumerate(across)
        for j, roller in enumerate(chosen)
    )
    told = ", ".join(f"roller {name} {span_of(line)}" for name, line in lines)
    return FigureWithData(
        figure=figure,
        tables=(DataTable(header=(column, "roller", measure), rows=rows),),
        alt=f"{MEASURE_LABELS[measure]} over {label} from {span_of(across)}: {told}. {_title(idle)}.",
    )


def _drawable(line: "FloatArray") -> "FloatArray":
    return np.where(np.isfinite(line) & (line > 0.0), line, np.nan)


def _typeset_label(measure: str) -> str:
    return MEASURE_LABELS[measure].replace("T'_hi/T'_lo", r"$T'_{\mathrm{hi}}/T'_{\mathrm{lo}}$")


def _title(idle: list[str]) -> str:
    return f"Slip of the rollers; without torque: {', '.join(idle)}" if idle else "Slip of the rollers"
