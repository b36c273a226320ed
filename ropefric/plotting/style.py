"""How all figures look: readable at A4 width, by colour-blind eyes and on a grey printer, same bytes each time."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib.style

# Okabe and Ito's palette, chosen so that the three also differ in lightness; the darker orange is for words.
BLUE = "#0072B2"
ORANGE = "#D55E00"
DARK_ORANGE = "#A34700"
GREY = "#6E6E6E"
INK = "#1A1A1A"
_GREEN = "#009E73"
_PURPLE = "#AA4499"
LINE_STYLES: tuple[Any, ...] = ("-", "--", "-.", ":", (0, (6, 1, 1, 1, 1, 1)), (0, (1, 3)), (0, (8, 3)))
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">", "p")
"""What tells lines and points apart where colour does not: on grey paper and for colour-blind eyes."""
TRACE_COLORS = "viridis"
"""Colour map for things in an order; its lightness rises steadily, so grey prints keep the order."""

_STYLE = {
    "figure.dpi": 110.0,
    "savefig.dpi": 110.0,
    "font.family": "DejaVu Sans",  # comes with matplotlib, so that every machine sets the same letters
    "font.size": 10.0,
    "axes.titlesize": 11.0,
    "figure.titlesize": 12.0,
    "axes.labelsize": 10.0,
    "legend.fontsize": 9.0,
    "xtick.labelsize": 9.0,
    "ytick.labelsize": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#DDDDDD",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "svg.hashsalt": "ropefric",
    "svg.fonttype": "path",
    "pdf.fonttype": 42,
    "path.simplify": True,
}
_ONE_AT_A_TIME = threading.RLock()


def line_look(place: int) -> dict[str, Any]:
    """Return colour and line style of the nth line of a figure; no two of the first seven share a style."""
    colors = (BLUE, ORANGE, INK, _GREEN, _PURPLE)
    return {"color": colors[place % len(colors)], "linestyle": LINE_STYLES[place % len(LINE_STYLES)]}


@contextmanager
def house_style() -> Iterator[None]:
    """Apply the style for the time of a `with` block, whatever the user's matplotlibrc says.

    The style of matplotlib is one for the whole process, so threads draw one after the other.
    """
    with _ONE_AT_A_TIME, matplotlib.style.context(["default", _STYLE]):
        yield
