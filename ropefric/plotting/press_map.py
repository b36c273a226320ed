"""Maps over preload and speed: where a press slips, one roller's slip (figure 7 of the paper), one span's tension."""

from typing import TYPE_CHECKING

import numpy as np

from ropefric.errors import UnknownNameError
from ropefric.plotting.figure import DataTable, FigureWithData, new_figure
from ropefric.plotting.press_axes import PRELOAD_LABEL, SPEED_LABEL, grid_of, span_of
from ropefric.plotting.press_slip import MEASURE_LABELS
from ropefric.plotting.style import INK, ORANGE, house_style
from ropefric.registry import did_you_mean

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ropefric.friction.condition import FloatArray
    from ropefric.systems.press.sweep import PressSweep

__all__ = ["draw_press_map", "draw_roller_maps", "draw_tension_maps"]

_LEVELS = 12


def draw_press_map(sweep: "PressSweep") -> FigureWithData:
    """Return the map of the largest utilisation of all rollers, with the line 1 where the first one slips.

    Parameters
    ----------
    sweep : PressSweep
        Over preload and speed.

    Returns
    -------
    FigureWithData
        With a row a point: the largest utilisation, the roller that has it, and whether a span is slack.

    Raises
    ------
    InputError
        If the sweep is not over both quantities.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> use = np.array([[[0.5, 1.5], [0.6, 1.8]], [[0.4, 0.7], [0.5, 0.8]]])
    >>> sweep = SimpleNamespace(preload_N=np.array([1e3, 2e3]), speed_m_s=np.array([0.0, 1.0]), rollers=("1", "2"),
    ...     margin=use.max(axis=-1), slip=SimpleNamespace(utilisation=use), slack=np.zeros((2, 2), dtype=bool),
    ...     effective_tension_N=np.ones((2, 2, 2)))
    >>> draw_press_map(sweep).tables[0].rows[0]
    (1000.0, 0.0, 1.5, '2', False)
    """
    speed, preload = grid_of(sweep)
    margin, nearest = sweep.margin, sweep.slip.utilisation.argmax(axis=-1)
    lowest_N = sweep.effective_tension_N.min(axis=-1)
    with house_style():
        figure = new_figure(9.0, 6.0)
        axes = figure.subplots()
        levels = np.linspace(0.0, 2.0, 11)
        _fill(
            axes, sweep, np.minimum(margin, 2.0), "Largest utilisation of all rollers [-], cut at 2", levels
        )
        _limit(axes, sweep, margin)
        if lowest_N.min() < 0.0:
            levels_N = [lowest_N.min() - 1.0, 0.0]
            axes.contourf(speed, preload, lowest_N, levels=levels_N, colors="white", hatches=["///"])
        axes.set_title("Where the first roller slips (thick line); hatched: a belt goes slack")
    rows = tuple(
        (
            *(float(preload[i]), float(speed[j]), float(margin[i, j])),
            *(sweep.rollers[int(nearest[i, j])], bool(sweep.slack[i, j])),
        )
        for i in range(preload.size)
        for j in range(speed.size)
    )
    slipping = 100.0 * float((margin >= 1.0).mean())
    return FigureWithData(
        figure=figure,
        tables=(DataTable(header=("preload_N", "speed_m_s", "utilisation", "roller", "slack"), rows=rows),),
        alt=f"Largest utilisation over preloads of {span_of(preload)} N and speeds of {span_of(speed)} m/s: "
        f"a roller slips at {slipping:.3g} % of the points.",
    )


def draw_roller_maps(
    sweep: "PressSweep", rollers: "Sequence[str]", *, measure: str = "as_plotted"
) -> FigureWithData:
    """Return maps of one measure of slip for some rollers side by side: figure 7.

    Parameters
    ----------
    sweep : PressSweep
        Over preload and speed.
    rollers : sequence of str
        Which; the paper shows 2 and 5.
    measure : str
        A key of `ropefric.plotting.press_slip.MEASURE_LABELS`.

    Returns
    -------
    FigureWithData
        With a row a point and roller.

    Raises
    ------
    InputError
        If the sweep is not over both quantities.
    UnknownNameError
        For an unknown measure or roller.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> slip = SimpleNamespace(of=lambda roller, measure: np.array([[0.5, 0.6], [0.4, 0.5]]))
    >>> sweep = SimpleNamespace(preload_N=np.array([1e3, 2e3]), speed_m_s=np.array([0.0, 1.0]), slip=slip)
    >>> [axes.get_title() for axes in draw_roller_maps(sweep, ["2"]).figure.axes][0]
    'Roller 2'
    """
    grid_of(sweep)
    values = {roller: sweep.slip.of(roller, measure) for roller in rollers}
    panels = {f"Roller {name}": each for name, each in values.items()}
    figure = _panels(sweep, panels, MEASURE_LABELS[measure], limit=measure != "mu_required")
    return _with_table(figure, sweep, values, ("roller", measure), MEASURE_LABELS[measure])


def draw_tension_maps(sweep: "PressSweep", spans: "Sequence[str]") -> FigureWithData:
    """Return maps of the effective tension of some spans side by side.

    Parameters
    ----------
    sweep : PressSweep
        Over preload and speed.
    spans : sequence of str
        Which.

    Returns
    -------
    FigureWithData
        With a row a point and span.

    Raises
    ------
    InputError
        If the sweep is not over both quantities.
    UnknownNameError
        For an unknown span.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> sweep = SimpleNamespace(preload_N=np.array([1e3, 2e3]), speed_m_s=np.array([0.0, 1.0]), spans=("1",),
    ...     effective_tension_N=np.array([[[500.0], [490.0]], [[900.0], [890.0]]]))
    >>> draw_tension_maps(sweep, ["1"]).tables[0].rows[0]
    (1000.0, 0.0, '1', 500.0)
    """
    grid_of(sweep)
    for span in spans:
        if span not in sweep.spans:
            raise UnknownNameError(f"unknown span '{span}'", fix=did_you_mean(span, sweep.spans))
    values = {span: sweep.effective_tension_N[..., sweep.spans.index(span)] for span in spans}
    label = "Effective tension T' [N]"
    figure = _panels(sweep, {f"Span {name}": each for name, each in values.items()}, label, limit=False)
    return _with_table(figure, sweep, values, ("span", "effective_tension_N"), label)


def _panels(sweep: "PressSweep", values: "dict[str, FloatArray]", label: str, *, limit: bool) -> "Figure":
    with house_style():
        figure = new_figure(1.0 + 5.0 * len(values), 5.0)
        for axes, (title, each) in zip(
            figure.subplots(1, len(values), squeeze=False)[0], values.items(), strict=True
        ):
            _fill(axes, sweep, each, label)
            if limit:
                _limit(axes, sweep, each)
            axes.set_title(title)
    return figure


def _fill(
    axes: "Axes",
    sweep: "PressSweep",
    values: "FloatArray",
    label: str,
    levels: "FloatArray | int" = _LEVELS,
) -> None:
    shown = np.ma.masked_invalid(values)
    filled = axes.contourf(sweep.speed_m_s, sweep.preload_N, shown, levels=levels, cmap="cividis")
    axes.set(xlabel=SPEED_LABEL, ylabel=PRELOAD_LABEL)
    axes.figure.colorbar(filled, ax=axes).set_label(label)


def _limit(axes: "Axes", sweep: "PressSweep", values: "FloatArray") -> None:
    """Draw the line 1, where there is one; beyond 2 the values are cut, so that infinity does not bend it."""
    cut = np.minimum(values, 2.0)
    if cut.min() < 1.0 < cut.max():
        line = axes.contour(
            sweep.speed_m_s, sweep.preload_N, cut, levels=[1.0], colors=[ORANGE], linewidths=2.5
        )
        axes.clabel(line, fmt={1.0: "1"}, colors=[INK])


def _with_table(
    figure: "Figure",
    sweep: "PressSweep",
    values: "dict[str, FloatArray]",
    columns: tuple[str, str],
    label: str,
) -> FigureWithData:
    rows = tuple(
        (float(preload), float(speed), name, float(each[i, j]))
        for name, each in values.items()
        for i, preload in enumerate(sweep.preload_N)
        for j, speed in enumerate(sweep.speed_m_s)
    )
    told = ", ".join(f"{columns[0]} {name} {span_of(each)}" for name, each in values.items())
    return FigureWithData(
        figure=figure,
        tables=(DataTable(header=("preload_N", "speed_m_s", *columns), rows=rows),),
        alt=f"{label} over preloads of {span_of(sweep.preload_N)} N and speeds of {span_of(sweep.speed_m_s)} m/s: "
        f"{told}.",
    )
