"""How many digits of a number are kept: those that mean something, which every machine agrees on.

Sine, logarithm and linear algebra differ in the last bits from processor to processor and from one version of a
library to the next. Measured numbers are known to four digits at best; rounded far below that, but far above the
last bits, the same input gives the same files everywhere. A number may still lie on the edge between two roundings:
with differences of 1e-15 and nine digits that is one number in a million.
"""

import math
from collections.abc import Mapping
from typing import Any

MEASURED_DIGITS = 9
"""Significant digits of forces, and of whatever else follows from measurements."""
GIVEN_DIGITS = 12
"""Significant digits of numbers that only arithmetic was done on."""
STD_DIGITS = 4
"""Significant digits of a standard error."""
_SHARE = 1e-4
"""Part of a standard error that rounding may be as large as."""


def significant(
    value: float, digits: int = MEASURED_DIGITS, *, smallest: float = 0.0, size: float = 0.0
) -> float:
    """Return a number with so many significant digits; zero where it is below `smallest`, the rest of a difference.

    Where it is the rest of a difference of numbers of a certain `size`, the digits count from that.
    """
    if abs(value) < smallest:
        return 0.0
    if abs(value) < size < math.inf:
        return round(value, digits - 1 - math.floor(math.log10(size))) + 0.0
    return float(f"{value:.{digits - 1}e}") + 0.0  # never -0.0


def to_share(value: float, std: float) -> float:
    """Return an estimate to a decimal between 1e-5 and 1e-4 of its standard error, and to twelve digits at most."""
    if not (math.isfinite(value) and value != 0.0 and 0.0 < std < math.inf):
        return significant(value, GIVEN_DIGITS)
    place = math.floor(math.log10(std * _SHARE))
    return round(value, -max(place, math.floor(math.log10(abs(value))) - GIVEN_DIGITS + 1)) + 0.0


def rounded_tree(tree: Any, digits: int = MEASURED_DIGITS) -> Any:
    """Return a JSON tree with its numbers to so many significant digits, standard errors (`std`, `std_*`) to four.

    A number that is not there or infinite is None.
    """
    if isinstance(tree, float):
        return significant(tree, digits) if math.isfinite(tree) else None
    if isinstance(tree, Mapping):
        return {
            key: rounded_tree(item, min(digits, STD_DIGITS) if f"{key}_".startswith("std_") else digits)
            for key, item in tree.items()
        }
    return [rounded_tree(item, digits) for item in tree] if isinstance(tree, list | tuple) else tree
