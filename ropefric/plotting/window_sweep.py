"""What the smoothing window does to the peak: a long one cuts it, none leaves the noise on it."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ropefric.errors import InputError
from ropefric.glossary import counted
from ropefric.plotting.figure import DataTable, FigureWithData, new_figure
from ropefric.plotting.labels import figure_label
from ropefric.plotting.legend import legend_of_figure
from ropefric.plotting.style import BLUE, GREY, INK, ORANGE, house_style
from ropefric.plotting.words import say_instead, shown
from ropefric.traces.breakaway import Breakaway, Status
from ropefric.traces.protocols.breakaway import pick_breakaway
from ropefric.traces.settings import PickSettings

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ropefric.traces.trace import ForceTrace

__all__ = ["WINDOWS_S", "draw_window_sweep", "sweep_windows"]

WINDOWS_S = (0.0, 0.001, 0.002, 0.003, 0.005, 0.01, 0.015, 0.02, 0.03, 0.05, 0.075, 0.1, 0.15, 0.2, 0.3)
"""Windows to look at [s], unless told otherwise."""
HEADER = ("window_s", "status", "peak_N", "peak_std_N", "bias_N", "first_order_N")


def sweep_windows(
    trace: "ForceTrace", settings: PickSettings | None = None, windows_s: Sequence[float] = WINDOWS_S
) -> tuple[Breakaway, ...]:
    """Return what is picked from a recording with each of several smoothing windows.

    Parameters
    ----------
    trace : ForceTrace
        The recording.
    settings : PickSettings, optional
        How to pick otherwise.
    windows_s : sequence of float
        Windows [s]; 0 does not smooth.

    Examples
    --------
    >>> from ropefric.traces.trace import ForceTrace
    >>> time_s = np.arange(2500) / 1000
    >>> trace = ForceTrace(time_s=time_s, force_N=np.interp(time_s, [0.3, 1.3, 1.32], [0, 100, 80]))
    >>> [round(found.peak_N, 1) for found in sweep_windows(trace, windows_s=(0.0, 0.101))]
    [100.0, 95.4]
    """
    chosen = settings or PickSettings()
    return tuple(pick_breakaway(trace, replace(chosen, window_s=window_s))[0] for window_s in windows_s)


def draw_window_sweep(
    sweep: Sequence[Breakaway], chosen: Breakaway, *, name: str = "recording"
) -> FigureWithData:
    """Return the break-away force over the smoothing window, the window in use marked.

    The dotted line is what a ramp that ends in a sudden drop would show to first order, the force of the two-line fit
    less rate · window/2; the dashed one is the two-line fit itself, which has no bias of the window.

    Parameters
    ----------
    sweep : sequence of Breakaway
        From `sweep_windows`; those without a force are left out of the line.
    chosen : Breakaway
        What was picked with the window in use.
    name : str
        What the recording is called.

    Returns
    -------
    FigureWithData
        With one table: a row a window.

    Raises
    ------
    InputError
        If there is no window in the sweep.

    Examples
    --------
    >>> draw_window_sweep([Breakaway(status=Status.NO_PEAK)], Breakaway(status=Status.NO_PEAK)).alt
    'Break-away force of recording over the smoothing window: no window gives a force.'
    """
    if not sweep:
        raise InputError("there is no window to draw", key="sweep", fix="make one with sweep_windows")
    usable = sorted(
        (found for found in sweep if found.status is Status.OK and np.isfinite(found.peak_N)),
        key=lambda found: found.window_s,
    )
    with house_style():
        figure = new_figure(10.0, 4.6)
        axes = figure.subplots()
        axes.set(xlabel="Smoothing window w [ms]", ylabel=figure_label("peak_N"))
        if usable:
            _draw(axes, usable, chosen)
        else:
            say_instead(axes, "no window gives a force")
        axes.set_title(f"{name}: {counted(len(usable), 'window')}, bars ±1 u (k = 1) of picking")
        legend_of_figure(figure)
    rows = tuple(
        (
            float(found.window_s),
            str(found.status),
            float(found.peak_N),
            float(found.peak_std_N),
            float(found.bias_N),
            float(chosen.two_line_N + found.bias_N),
        )
        for found in sweep
    )
    return FigureWithData(
        figure=figure, tables=(DataTable(header=HEADER, rows=rows),), alt=_alt(name, usable, chosen)
    )


def _draw(axes: "Axes", usable: list[Breakaway], chosen: Breakaway) -> None:
    window_ms = np.array([1e3 * found.window_s for found in usable])
    peak_N = np.array([found.peak_N for found in usable])
    std_N = np.nan_to_num([found.peak_std_N for found in usable])
    first_order_N = chosen.two_line_N + np.array([found.bias_N for found in usable])
    axes.errorbar(
        window_ms,
        peak_N,
        yerr=std_N,
        fmt="o-",
        color=BLUE,
        markersize=5,
        linewidth=1.4,
        elinewidth=0.8,
        capsize=2.0,
        label="peak of the smoothed force",
    )
    axes.plot(window_ms, first_order_N, ":", color=INK, linewidth=1.4, label="two-line fit less rate · w/2")
    if np.isfinite(chosen.two_line_N):
        axes.axhline(
            chosen.two_line_N, color=GREY, linestyle="--", linewidth=1.2, label="two-line fit, no bias"
        )
    if chosen.status is Status.OK:
        label = f"in use: {1e3 * chosen.window_s:.3g} ms, {chosen.peak_N:.4g} N"
        axes.axvline(1e3 * chosen.window_s, color=ORANGE, linewidth=1.0, linestyle="-.")
        axes.plot(
            [1e3 * chosen.window_s],
            [chosen.peak_N],
            "D",
            color=ORANGE,
            markeredgecolor="black",
            zorder=5,
            label=label,
        )
    axes.set_xscale("symlog", linthresh=1.0, linscale=0.6)
    axes.set_xlim(-0.1, 1.15 * max(float(window_ms.max()), 1.0))
    axes.set_xticks(
        [tick for tick in (0, 1, 2, 5, 10, 20, 50, 100, 200, 500) if tick <= 1.15 * window_ms.max()]
    )
    axes.set_xticks([], minor=True)
    axes.xaxis.set_major_formatter("{x:g}")


def _alt(name: str, usable: list[Breakaway], chosen: Breakaway) -> str:
    start = f"Break-away force of {name} over the smoothing window"
    if not usable:
        return f"{start}: no window gives a force."
    first, last = usable[0], usable[-1]
    text = (
        f"{start}, from {shown(first.peak_N, 'N')} at {1e3 * first.window_s:.3g} ms to {shown(last.peak_N, 'N')} at "
        f"{1e3 * last.window_s:.3g} ms."
    )
    if chosen.status is not Status.OK:
        return text
    used = f"In use: {1e3 * chosen.window_s:.3g} ms, {shown(chosen.peak_N, 'N')}"
    return f"{text} {used}, first-order bias {shown(chosen.bias_N, 'N', 2)}."
