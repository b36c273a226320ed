"""Words for figures: axis labels in the units people read, numbers with units, plain text of what is typeset."""

import math
import re
from typing import TYPE_CHECKING

from ropefric.fitting.predict import REGRESSORS
from ropefric.glossary import axis_label
from ropefric.plotting.labels import typeset
from ropefric.plotting.style import GREY

if TYPE_CHECKING:
    from matplotlib.axes import Axes


TYPESET = re.compile(r"\$([A-Za-zφμρσ]++)_\{\\mathrm\{([A-Za-z0-9,]++)\}\}\$")
"""A symbol with its index, as `ropefric.plotting.labels.typeset` sets it."""


def shown(value: float, unit: str = "", digits: int = 4) -> str:
    """Return a number with its unit, or "unknown" where there is none."""
    if math.isnan(value):
        return "unknown"
    number = f"{value:.{digits}g}"
    return f"{number} {unit}" if unit else number


def regressor_label(name: str) -> str:
    r"""Return the axis label of a regressor in the unit people set it in."""
    return typeset(f"{axis_label(name).rsplit(' [', 1)[0]} [{REGRESSORS[name][1]}]")


def shown_regressor(name: str, value: float) -> str:
    """Return a regressor's symbol and value in the unit people set it in."""
    _title, unit, factor = REGRESSORS[name]
    symbol = axis_label(name).rsplit(" [", 1)[0].rsplit(" ", 1)[1]
    return f"{symbol} = {factor * value:.4g} {unit}"


def plain_text(text: str) -> str:
    r"""Return typeset text as it was before, for readers who cannot see it."""
    return TYPESET.sub(r"\1_\2", text)


def say_instead(axes: "Axes", text: str) -> None:
    """Write on empty axes why nothing is drawn."""
    axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", color=GREY)
