"""How all figures look and the words on them: readable at A4 width, by colour-blind eyes and on a grey printer."""

import math
import re
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib.style
import numpy as np
from matplotlib import colormaps, rc_params_from_file
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.ticker import LogFormatter
from matplotlib.transforms import ScaledTranslation

from ropefric.arrays import BoolArray, FloatArray
from ropefric.files.plain_text import visible
from ropefric.fitting.predict import REGRESSORS
from ropefric.friction.laws import ALL_LAWS
from ropefric.glossary import axis_label

# Okabe and Ito's palette, chosen so that the three also differ in lightness; the darker orange is for words.
BLUE = "#0072B2"
ORANGE = "#D55E00"
DARK_ORANGE = "#A34700"
GREY = "#6E6E6E"
INK = "#1A1A1A"
_COLORS = (BLUE, ORANGE, INK, "#009E73", "#AA4499")
_LAW_COLORS = (INK, ORANGE, "#009E73", "#AA4499", "#8A6D00", "#3D8FC4", BLUE)
LINE_STYLES: tuple[Any, ...] = ("-", "--", "-.", ":", (0, (6, 1, 1, 1, 1, 1)), (0, (1, 3)), (0, (8, 3)))
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">", "p")
"""Line styles and markers that differ without colour: on grey paper and for colour-blind eyes."""

_HOUSE: Any = rc_params_from_file(Path(__file__).with_name("house.mplstyle"), use_default_template=False)
_ONE_AT_A_TIME = threading.RLock()

_SUBSCRIPT = re.compile(r"(?<![A-Za-zφμρσ])([A-Za-zφμρσ]++)_([A-Za-z0-9]++(?:,[A-Za-z0-9]++)*+)")
_OWN_MATHEMATICS = re.compile(r"(\$(?:[A-Za-zφμρσ']++_\{\\mathrm\{[A-Za-z0-9,]++\}\}/?)++\$)")
_LONGEST_WORD = 60  # beyond, nothing else has room
_DOLLAR = re.compile(r"(?<!\\)\$")
TYPESET = re.compile(r"\$([A-Za-zφμρσ]++)_\{\\mathrm\{([A-Za-z0-9,]++)\}\}\$")
"""A symbol with its index, as `typeset` sets it."""


@contextmanager
def house_style() -> Iterator[None]:
    """Apply the style for the time of a `with` block, whatever the user's matplotlibrc says.

    The style of matplotlib is one for the whole process, so threads draw one after the other.
    """
    with _ONE_AT_A_TIME, matplotlib.style.context(["default", _HOUSE]):
        yield


def line_look(place: int) -> dict[str, Any]:
    """Return colour and line style of the nth line of a figure; no two of the first seven share a style."""
    return {"color": _COLORS[place % len(_COLORS)], "linestyle": LINE_STYLES[place % len(LINE_STYLES)]}


def law_look(law: str) -> dict[str, Any]:
    """Return colour and line style of a law, the same in every figure; the capstan equation is a plain black line."""
    place = list(ALL_LAWS).index(law.removesuffix("-from-zero"))
    n = len(_LAW_COLORS)
    dashes = LINE_STYLES[(place + place // n) % len(LINE_STYLES)]
    return {"color": _LAW_COLORS[place % n], "linestyle": dashes}


def shades(n: int) -> list[tuple[float, ...]]:
    """Return colours for n things in an order; lightness rises steadily, so grey prints keep the order."""
    # The palest end of the map is left out, it drowns on white paper.
    return [colormaps["viridis"](0.85 * place / max(n - 1, 1)) for place in range(n)]


def typeset(text: str) -> str:
    r"""Return text with plain symbols such as F_A set as mathematics."""
    return _SUBSCRIPT.sub(r"$\1_{\\mathrm{\2}}$", text)


def plain_text(text: str) -> str:
    r"""Return typeset text as it was before, for readers who cannot see it."""
    return TYPESET.sub(r"\1_\2", text)


def figure_text(text: str) -> str:
    r"""Return text for a figure: only our own mathematics is typeset; every other character is shown."""
    for word in set(text.split()):
        if len(word) > _LONGEST_WORD:
            text = text.replace(word, f"{word[: _LONGEST_WORD - 1]}…")
    parts = _OWN_MATHEMATICS.split(visible(text))
    return "".join(part if place % 2 else _DOLLAR.sub(r"\$", part) for place, part in enumerate(parts))


def figure_label(name: str) -> str:
    """Return a quantity's axis label with typeset symbol and unit."""
    return typeset(axis_label(name))


def regressor_label(name: str) -> str:
    r"""Return the axis label of a regressor in the unit people set it in."""
    return typeset(f"{axis_label(name).rsplit(' [', 1)[0]} [{REGRESSORS[name][1]}]")


def shown_regressor(name: str, value: float) -> str:
    """Return a regressor's symbol and value in the unit people set it in."""
    _title, unit, factor = REGRESSORS[name]
    symbol = axis_label(name).rsplit(" [", 1)[0].rsplit(" ", 1)[1]
    return f"{symbol} = {factor * value:.4g} {unit}"


def shown(value: float, unit: str = "", digits: int = 4) -> str:
    """Return a number with its unit, or "unknown" where there is none."""
    return "unknown" if math.isnan(value) else f"{value:.{digits}g} {unit}".rstrip()


def span_of(values: Any) -> str:
    """Return the range of some numbers in words."""
    return f"{values.min():.4g} to {values.max():.4g}"


def note_at(
    axes: Axes, text: str, point: tuple[float, float], right: float = 0.0, up: float = 0.0, **look: Any
) -> None:
    """Write a small text beside a point, with its distances to the right and upward in points of print."""
    shown: dict[str, Any] = {"fontsize": 8.0, "ha": "center", "va": "bottom"} | look
    axes.annotate(text, point, xytext=(right, up), textcoords="offset points", **shown)


def plain_log(axes: Axes, axis: str) -> None:
    """Make an axis logarithmic, with plain numbers at its ticks, also where it is shorter than a decade."""
    axes.set(**{f"{axis}scale": "log"})
    ticks = getattr(axes, f"{axis}axis")
    ticks.set_major_formatter("{x:g}")
    ticks.set_minor_formatter(LogFormatter(labelOnlyBase=False, minor_thresholds=(2.0, 0.6)))


def hatch_untested(axes: Axes, x: FloatArray, outside: BoolArray) -> None:
    """Hatch the parts of the x axis that lie outside the tested range; `outside` says it of each of the sorted `x`."""
    look: dict[str, Any] = {"hatch": "///", "facecolor": "none", "edgecolor": "#9A9A9A", "linewidth": 0}
    ends = np.flatnonzero(np.diff(np.r_[False, outside, False].astype(int)))
    for first, stop in ends.reshape(-1, 2):
        # A stretch reaches to the last tested point beside it.
        span = x[max(first - 1, 0)], x[min(stop, x.size - 1)]
        axes.axvspan(*span, **look, zorder=0.5, label="not tested: extrapolated")


def legend_below(axes: Axes, *, columns: int = 2) -> None:
    """Put a legend under the axes with one entry for each label; none where nothing is labelled."""
    if entries := _entries([axes]):
        labels, handles = list(entries), list(entries.values())
        # Below numbers and label of the axis, however high the axes are.
        below = axes.transAxes + ScaledTranslation(0.0, -0.45, axes.figure.dpi_scale_trans)
        place: dict[str, Any] = {"loc": "upper center", "bbox_to_anchor": (0.5, 0.0), "bbox_transform": below}
        axes.legend(handles, labels, ncols=columns, **place)


def legend_of_figure(figure: Figure | SubFigure, *, columns: int = 5) -> None:
    """Put one legend under all axes of a figure, one entry for each label.

    A figure with constrained layout makes room for it; one with margins of its own needs to have it.
    """
    if entries := _entries(figure.axes):
        place: Any = "lower center" if figure.get_layout_engine() is None else "outside lower center"
        figure.legend(list(entries.values()), list(entries), loc=place, ncols=columns)


def _entries(panels: Sequence[Axes]) -> dict[str, Artist]:
    """Return the first artist of each label."""
    entries: dict[str, Artist] = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    return entries


def say_instead(axes: Axes, text: str) -> None:
    """Write on empty axes why nothing is drawn."""
    axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", color=GREY)
