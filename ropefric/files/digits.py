"""How many digits of a number are kept: those that mean something, which every machine agrees on.

Sine, logarithm and linear algebra differ in the last bits from processor to processor and from one version of a
library to the next. Measured numbers are known to four digits at best; rounded far below that, but far above the
last bits, the same input gives the same files everywhere. A number may still lie on the edge between two roundings:
with differences of 1e-15 and nine digits that is one number in a million.
"""

import math
from collections.abc import Mapping
from typing import Any

__all__ = ["GIVEN_DIGITS", "MEASURED_DIGITS", "STD_DIGITS", "rounded_tree", "significant", "to_share"]

MEASURED_DIGITS = 9
"""Significant digits of forces, and of whatever else follows from measurements."""
GIVEN_DIGITS = 12
"""Significant digits of numbers that only arithmetic was done on."""
STD_DIGITS = 4
"""Significant digits of a standard error."""
_SHARE = 1e-4
"""Part of a standard error that rounding may be as large as."""


def significant(value: float, digits: int = MEASURED_DIGITS, *, smallest: float = 0.0) -> float:
    """Return a number with so many significant digits; zero where it is below `smallest`, the rest of a difference.

    Examples
    --------
    >>> significant(227.32153804702236), significant(0.0123456, 4), significant(-3e-17, smallest=1e-12)
    (227.321538, 0.01235, 0.0)
    """
    if abs(value) < smallest:
        return 0.0
    return float(f"{value:.{digits - 1}e}") + 0.0  # never -0.0


def to_share(value: float, std: float) -> float:
    """Return an estimate to a decimal between 1e-5 and 1e-4 of its standard error, and to twelve digits at most.

    Parameters
    ----------
    value, std : float
        The estimate and its standard error. Of estimates that make up for each other it is the error of each with
        the others held, or rounding one would move what they give together. Where there is none, or an infinite one,
        the twelve digits alone count.

    Examples
    --------
    >>> to_share(0.1192345678, 0.0012), to_share(-32393.456, 12345.0), to_share(0.1192345678912345, 0.0)
    (0.1192346, -32393.0, 0.119234567891)
    """
    if not (math.isfinite(value) and value != 0.0 and 0.0 < std < math.inf):
        return significant(value, GIVEN_DIGITS)
    place = math.floor(math.log10(std * _SHARE))
    return round(value, -max(place, math.floor(math.log10(abs(value))) - GIVEN_DIGITS + 1)) + 0.0


def rounded_tree(tree: Any, digits: int = MEASURED_DIGITS) -> Any:
    """Return a JSON tree with its numbers to so many significant digits, standard errors (`std`, `std_*`) to four.

    Examples
    --------
    >>> rounded_tree({"std_N": 0.325969734, "ends": [1.0, 123.4567890123], "n": 12, "note": None})
    {'std_N': 0.326, 'ends': [1.0, 123.456789], 'n': 12, 'note': None}
    """
    if isinstance(tree, float):
        return significant(tree, digits)
    if isinstance(tree, Mapping):
        return {
            key: rounded_tree(item, min(digits, STD_DIGITS) if _is_std(str(key)) else digits)
            for key, item in tree.items()
        }
    return [rounded_tree(item, digits) for item in tree] if isinstance(tree, list | tuple) else tree


def _is_std(key: str) -> bool:
    return key == "std" or key.startswith("std_")
