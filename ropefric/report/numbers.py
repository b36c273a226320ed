"""Numbers as people read them."""

import math
from collections.abc import Sequence

__all__ = ["interval", "plain"]


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
