"""How all figures look: readable at A4 width, by colour-blind eyes and on a grey printer, same bytes each time."""

from collections.abc import Iterator
from contextlib import contextmanager

import matplotlib.style

__all__ = ["BLUE", "GREY", "ORANGE", "TRACE_COLORS", "house_style"]

# Okabe and Ito's palette, chosen so that the three also differ in lightness.
BLUE = "#0072B2"
ORANGE = "#D55E00"
GREY = "#6E6E6E"
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


@contextmanager
def house_style() -> Iterator[None]:
    """Apply the style for the time of a `with` block, whatever the user's matplotlibrc says.

    Examples
    --------
    >>> import matplotlib
    >>> before = matplotlib.rcParams["font.size"]
    >>> with house_style():
    ...     matplotlib.rcParams["svg.hashsalt"]
    'ropefric'
    >>> matplotlib.rcParams["font.size"] == before
    True
    """
    with matplotlib.style.context(["default", _STYLE]):
        yield
