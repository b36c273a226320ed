"""Numbers as people read them."""

import math
from collections.abc import Sequence

from ropefric.fitting.predict import REGRESSORS


def plain(value: float | None, form: str = ".4g") -> str:
    """Return a number as text, a dash where there is none."""
    if value is None or math.isnan(value):
        return "–"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    return format(value, form)


def shorthand(value: float, std: float) -> str:
    """Return a value with its standard error in units of its last digits, as in 0.1192(12)."""
    if not (math.isfinite(value) and math.isfinite(std)) or std <= 0.0:
        return plain(value, ".5g")
    # Rounded first, because 0.0999 becomes 0.10 and has a digit less.
    exponent = math.floor(math.log10(float(f"{std:.1e}"))) - 1
    if exponent >= 0:
        scale = 10.0**exponent
        return f"{scale * round(value / scale):.0f}({scale * round(std / scale):.0f})"
    return f"{value:.{-exponent}f}({round(std * 10.0**-exponent):d})"


def interval(ends: Sequence[float], form: str = ".4g") -> str:
    """Return an interval as text."""
    low, high = (plain(float(end), form) for end in ends)
    return f"{low} … {high}" if (low, high) != ("–", "–") else "–"


def tested_range(name: str, ends: tuple[float, float]) -> str:
    """Return the range of a regressor in words, in the unit people set it in."""
    title, unit, factor = REGRESSORS[name]
    low, high = (plain(factor * end) for end in ends)
    return f"{title} {low} {unit}" if low == high else f"{title} {low} to {high} {unit}"
