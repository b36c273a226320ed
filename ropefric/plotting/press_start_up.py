"""The start-up of a press: tensions, speeds, slips and the energy balance over one time axis."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib import colormaps

from ropefric.plotting.figure import DataTable, FigureWithData, new_figure
from ropefric.plotting.press_axes import name_lines, same_lines, span_of
from ropefric.plotting.style import BLUE, GREY, LINE_STYLES, ORANGE, TRACE_COLORS, house_style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ropefric.friction.condition import FloatArray
    from ropefric.systems.press.transient.result import StartUp

__all__ = ["draw_press_start_up"]

_LEFT_BEHIND = 0.02
"""A roller whose rim differs from the drive by this share of its highest speed at the end is drawn by itself."""
_FLOOR = 1e-16


def draw_press_start_up(found: "StartUp") -> FigureWithData:
    """Return the figure of a start-up.

    From above: the tension of every span; the rim speed of every roller; when the belt slips on which roller, forward
    (it runs ahead, as on a driven roller) or backward (it lags, as on a driver); what does not add up in the energy
    balance, against the greatest of its parts.

    Parameters
    ----------
    found : StartUp
        From `ropefric.systems.press.transient.start_up`.

    Returns
    -------
    FigureWithData
        With a row a time; a second table, "slips", has a row a slip.

    Examples
    --------
    >>> from types import SimpleNamespace as Any
    >>> energy = Any(residual=np.array([0.0, 1e-9]), drive=np.array([0.0, 5.0]))
    >>> press = Any(rollers=(Any(name="1", radius_m=0.1),), spans=(Any(name="1"),))
    >>> found = Any(press=press, time_s=np.array([0.0, 1.0]), tension_N=np.array([[500.0], [510.0]]), slips=(),
    ...     drive_speed_m_s=np.array([0.0, 1.0]), roller_speed_rad_s=np.array([[0.0], [10.0]]), energy=energy)
    >>> draw_press_start_up(found).tables[0].rows[1]
    (1.0, 1.0, 510.0, 1.0, 1e-09)
    """
    rims_m_s = found.roller_speed_rad_s * [roller.radius_m for roller in found.press.rollers]
    with house_style():
        figure = new_figure(
            9.0, 11.0, margins={"left": 0.13, "right": 0.84, "top": 0.96, "bottom": 0.05, "hspace": 0.16}
        )
        tension, speed, slip, energy = figure.subplots(
            4, 1, sharex=True, gridspec_kw={"height_ratios": [3.2, 2.0, 1.2, 1.0]}
        )
        tension.set_xlim(found.time_s[0], found.time_s[-1])
        tension.set_title("Start-up: tension of every span, all its belts together")
        _draw_tensions(tension, found)
        _draw_speeds(speed, found, rims_m_s)
        _draw_slips(slip, found)
        _draw_balance(energy, found)
        energy.set_xlabel("Time t [s]")
        figure.align_ylabels()
    return FigureWithData(figure=figure, tables=_tables(found, rims_m_s), alt=_in_words(found))


def _draw_tensions(axes: "Axes", found: "StartUp") -> None:
    lines = same_lines([span.name for span in found.press.spans], found.tension_N, "T")
    scale = colormaps[TRACE_COLORS]
    for i, (_, line) in enumerate(lines):
        color = scale(0.85 * i / max(len(lines) - 1, 1))
        axes.plot(found.time_s, line, color=color, linestyle=LINE_STYLES[i % 4], linewidth=1.3)
    axes.set_ylabel("Tension T [N]")
    axes.set_ylim(bottom=0.0)
    name_lines(axes, [(name, float(line[-1])) for name, line in lines])


def _draw_speeds(axes: "Axes", found: "StartUp", rims_m_s: "FloatArray") -> None:
    least = _LEFT_BEHIND * float(np.abs(found.drive_speed_m_s).max())
    slipped = {slip.roller for slip in found.slips}
    ends = [("drive", float(found.drive_speed_m_s[-1]))]
    for i, roller in enumerate(found.press.rollers):
        apart = abs(rims_m_s[-1, i] - found.drive_speed_m_s[-1]) > least
        color = ORANGE if roller.name in slipped else GREY
        axes.plot(found.time_s, rims_m_s[:, i], color=color, linewidth=1.2 if roller.name in slipped else 0.7)
        if apart:
            ends.append((f"roller {roller.name}", float(rims_m_s[-1, i])))
    axes.plot(found.time_s, found.drive_speed_m_s, color=BLUE, linewidth=1.6, linestyle="--")
    axes.set_ylabel("Rim speed Rθ' [m/s]")
    name_lines(axes, ends, gap=0.07)


def _draw_slips(axes: "Axes", found: "StartUp") -> None:
    names = list(dict.fromkeys(slip.roller for slip in found.slips))
    for slip in found.slips:
        color = ORANGE if slip.direction > 0 else BLUE
        row = names.index(slip.roller)
        axes.barh(row, slip.end_s - slip.start_s, left=slip.start_s, height=0.6, color=color)
        # A slip shorter than a pixel still gets its mark.
        axes.plot([slip.start_s], [row], marker="|", markersize=9.0, color=color)
    axes.set_ylabel("Slip on")
    axes.set_yticks(range(len(names)), [f"roller {name}" for name in names])
    axes.set_ylim(max(len(names), 1) - 0.5, -0.5)
    if not names:
        axes.text(0.5, 0.5, "no belt slips", transform=axes.transAxes, ha="center", va="center", color=GREY)
        return
    for place, color, direction, word in ((0.7, ORANGE, 1, "forward"), (0.3, BLUE, -1, "backward")):
        if any(slip.direction == direction for slip in found.slips):
            axes.text(1.03, place, word, transform=axes.transAxes, va="center", color=color, fontsize=9.0)


def _draw_balance(axes: "Axes", found: "StartUp") -> None:
    axes.semilogy(found.time_s, np.maximum(_relative_residual(found), _FLOOR), color=GREY, linewidth=1.0)
    axes.set_ylabel("Energy residual [-]")


def _relative_residual(found: "StartUp") -> "FloatArray":
    largest = float(np.abs(found.energy.drive).max())
    return np.asarray(np.abs(found.energy.residual) / (largest or 1.0))


def _tables(found: "StartUp", rims_m_s: "FloatArray") -> tuple[DataTable, ...]:
    spans = tuple(f"tension_{span.name}_N" for span in found.press.spans)
    rollers = tuple(f"rim_speed_{roller.name}_m_s" for roller in found.press.rollers)
    columns = np.column_stack(
        [found.time_s, found.drive_speed_m_s, found.tension_N, rims_m_s, found.energy.residual]
    )
    header = ("time_s", "drive_speed_m_s", *spans, *rollers, "energy_residual_J")
    slips = tuple((slip.roller, slip.start_s, slip.end_s, slip.direction) for slip in found.slips)
    return (
        DataTable(header=header, rows=tuple(tuple(row) for row in columns.tolist())),
        DataTable(name="slips", header=("roller", "start_s", "end_s", "direction"), rows=slips),
    )


def _in_words(found: "StartUp") -> str:
    first: dict[str, float] = {}
    for slip in found.slips:
        first.setdefault(slip.roller, slip.start_s)
    slips = ", ".join(f"roller {name} from {start_s:.3g} s" for name, start_s in first.items())
    return f"Start-up over {found.time_s[-1]:.4g} s: tensions {span_of(found.tension_N)} N; " + (
        f"the belt slips on {slips}." if slips else "no belt slips."
    )
