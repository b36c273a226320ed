"""Numbers as people read them."""

import math
from collections.abc import Sequence

from ropefric.fitting.extrapolation import REGRESSORS

__all__ = ["interval", "plain", "tested_range"]


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
