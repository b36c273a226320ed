"""Words on figures: the glossary's, typeset, in the units people read; names that nobody takes for mathematics."""

import math
import re

from ropefric.files.plain_text import visible
from ropefric.fitting.predict import REGRESSORS
from ropefric.glossary import axis_label

_SUBSCRIPT = re.compile(r"(?<![A-Za-zφμρσ])([A-Za-zφμρσ]++)_([A-Za-z0-9]++(?:,[A-Za-z0-9]++)*+)")
_OWN_MATHEMATICS = re.compile(r"(\$(?:[A-Za-zφμρσ']++_\{\\mathrm\{[A-Za-z0-9,]++\}\}/?)++\$)")
_LONGEST_WORD = 60  # beyond, nothing else has room
_DOLLAR = re.compile(r"(?<!\\)\$")
TYPESET = re.compile(r"\$([A-Za-zφμρσ]++)_\{\\mathrm\{([A-Za-z0-9,]++)\}\}\$")
"""A symbol with its index, as `typeset` sets it."""


def typeset(text: str) -> str:
    r"""Return text with plain symbols such as F_A set as mathematics."""
    return _SUBSCRIPT.sub(r"$\1_{\\mathrm{\2}}$", text)


def plain_text(text: str) -> str:
    r"""Return typeset text as it was before, for readers who cannot see it."""
    return TYPESET.sub(r"\1_\2", text)


def figure_text(text: str) -> str:
    r"""Return text as it may stand in a figure: what is not our own mathematics is none, and all of it shows."""
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
