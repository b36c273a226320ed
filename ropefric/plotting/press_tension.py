"""Belt tensions of a press over speed (figure 4 of the paper) or over preload."""

from typing import TYPE_CHECKING

from matplotlib import colormaps

from ropefric.plotting.figure import DataTable, FigureWithData, new_figure
from ropefric.plotting.press_axes import line_axis, name_lines, same_lines, span_of
from ropefric.plotting.style import LINE_STYLES, TRACE_COLORS, house_style

if TYPE_CHECKING:
    from ropefric.systems.press.sweep import PressSweep

__all__ = ["draw_press_tension"]


def draw_press_tension(sweep: "PressSweep") -> FigureWithData:
    """Return the figure of the effective tensions T' of all spans, a line each; equal ones share a line.

    Parameters
    ----------
    sweep : PressSweep
        Over speed or over preload.

    Returns
    -------
    FigureWithData
        With a row a point and span.

    Raises
    ------
    InputError
        If the sweep goes over both.

    Examples
    --------
    >>> import numpy as np
    >>> from types import SimpleNamespace
    >>> sweep = SimpleNamespace(preload_N=np.empty(0), speed_m_s=np.array([0.0, 1.0]), spans=("1", "2"),
    ...     effective_tension_N=np.array([[[500.0, 600.0], [490.0, 590.0]]]))
    >>> draw_press_tension(sweep).tables[0].rows[0]
    (0.0, '1', 500.0)
    """
    column, label, across = line_axis(sweep)
    tensions_N = sweep.effective_tension_N.reshape(across.size, -1)
    lines = same_lines(sweep.spans, tensions_N, "T")
    scale = colormaps[TRACE_COLORS]
    with house_style():
        figure = new_figure(9.0, 6.0, margins={"left": 0.09, "right": 0.83, "top": 0.92, "bottom": 0.1})
        axes = figure.subplots()
        for i, (_, line) in enumerate(lines):
            color = scale(0.85 * i / max(len(lines) - 1, 1))
            axes.plot(across, line, color=color, linestyle=LINE_STYLES[i % 4], linewidth=1.6)
        axes.set(xlabel=label, ylabel="Effective tension T' = T − ρAv² [N]", xlim=(across[0], across[-1]))
        axes.set_ylim(bottom=min(0.0, float(tensions_N.min())))
        axes.set_title("Tension of every span, all its belts together")
        name_lines(axes, [(name, float(line[-1])) for name, line in lines])
    rows = tuple(
        (float(x), span, float(tensions_N[i, j]))
        for i, x in enumerate(across)
        for j, span in enumerate(sweep.spans)
    )
    fallen = ", ".join(f"{name.replace('_', '')} {span_of(line)} N" for name, line in lines)
    return FigureWithData(
        figure=figure,
        tables=(DataTable(header=(column, "span", "effective_tension_N"), rows=rows),),
        alt=f"Effective tensions over {label} from {span_of(across)}: {fallen}.",
    )
