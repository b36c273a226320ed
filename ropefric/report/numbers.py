"""Numbers as people read them."""

import math
from collections.abc import Sequence

from ropefric.fitting.extrapolation import REGRESSORS

__all__ = ["interval", "plain", "shorthand", "tested_range"]


def plain(value: float | None, form: str = ".4g") -> str:
    """Return a number as text, a dash where there is none.

    Examples
    --------
    >>> plain(0.46117), plain(None), plain(float("inf"))
    ('0.4612', '–', '∞')
    """
    if value is None or math.isnan(value):
        return "–"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    return format(value, form)


def shorthand(value: float, std: float) -> str:
    """Return a value with its standard error in units of its last digits, as in 0.1192(12).

    Parameters
    ----------
    value, std : float
        Estimate and standard error; two digits of the latter are kept. Where there is none, the value stands alone.

    Examples
    --------
    >>> shorthand(0.119234, 0.00123), shorthand(-323.93, 12.3), shorthand(5.0, 0.0), shorthand(0.5, 0.0999)
    ('0.1192(12)', '-324(12)', '5', '0.50(10)')
    """
    if not (math.isfinite(value) and math.isfinite(std)) or std <= 0.0:
        return plain(value, ".5g")
    # Rounded first, because 0.0999 becomes 0.10 and has a digit less.
    exponent = math.floor(math.log10(float(f"{std:.1e}"))) - 1
    if exponent >= 0:
        scale = 10.0**exponent
        return f"{scale * round(value / scale):.0f}({scale * round(std / scale):.0f})"
    return f"{value:.{-exponent}f}({round(std * 10.0**-exponent):d})"


def interval(ends: Sequence[float], form: str = ".4g") -> str:
    """Return an interval as text.

    Examples
    --------
    >>> interval((0.4572, 0.4652))
    '0.4572 … 0.4652'
    """
    low, high = (plain(float(end), form) for end in ends)
    return f"{low} … {high}" if (low, high) != ("–", "–") else "–"


def tested_range(name: str, ends: tuple[float, float]) -> str:
    """Return the range of a regressor in words, in the unit people set it in.

    Examples
    --------
    >>> tested_range("wheel_radius_m", (0.015, 0.06)), tested_range("rope_radius_m", (0.0049, 0.0049))
    ('wheel radius 15 to 60 mm', 'rope radius 4.9 mm')
    """
    title, unit, factor = REGRESSORS[name]
    low, high = (plain(factor * end) for end in ends)
    return f"{title} {low} {unit}" if low == high else f"{title} {low} to {high} {unit}"
