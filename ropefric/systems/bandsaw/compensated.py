"""Sums and products that keep what rounding drops, for differences of nearly equal numbers.

A pair (high, low) stands for high + low with about 32 digits. Knuth's sum, Dekker's product; finite numbers whose
products neither overflow nor fall below 1e-290.
"""

import numpy as np
import numpy.typing as npt

from ropefric.friction.condition import FloatArray

__all__ = ["Pair", "add", "as_pair", "divide", "multiply", "negative", "total"]

Pair = tuple[FloatArray, FloatArray]
"""An unevaluated sum of a float and what it lacks."""

_SPLITTER = 134217729.0  # 2^27 + 1


def as_pair(value: npt.ArrayLike) -> Pair:
    """Return a float as a pair.

    Examples
    --------
    >>> [float(part) for part in as_pair(2.0)]
    [2.0, 0.0]
    """
    high = np.asarray(value, dtype=np.float64)
    return high, np.zeros_like(high)


def add(a: Pair, b: Pair) -> Pair:
    """Return a + b.

    Examples
    --------
    >>> tiny = add(add(as_pair(1.0), as_pair(1e-20)), as_pair(-1.0))
    >>> float(total(tiny))
    1e-20
    """
    high, low = _two_sum(a[0], b[0])
    low_high, low_low = _two_sum(a[1], b[1])
    high, low = _quick_two_sum(high, low + low_high)
    return _quick_two_sum(high, low + low_low)


def multiply(a: Pair, b: Pair) -> Pair:
    """Return a b.

    Examples
    --------
    >>> square = multiply(as_pair(1.0 + 2.0**-30), as_pair(1.0 + 2.0**-30))
    >>> float(total(add(square, as_pair(-1.0 - 2.0**-29)))) == 2.0**-60
    True
    """
    high, low = _two_product(a[0], b[0])
    return _quick_two_sum(high, low + (a[0] * b[1] + a[1] * b[0]))


def divide(a: Pair, b: Pair) -> Pair:
    """Return a / b for b ≠ 0.

    Examples
    --------
    >>> third = divide(as_pair(1.0), as_pair(3.0))
    >>> float(total(add(multiply(third, as_pair(3.0)), as_pair(-1.0)))) < 1e-30
    True
    """
    first = a[0] / b[0]
    left = add(a, multiply(as_pair(-first), b))
    second = left[0] / b[0]
    left = add(left, multiply(as_pair(-second), b))
    high, low = _quick_two_sum(first, second)
    return _quick_two_sum(high, low + left[0] / b[0])


def negative(a: Pair) -> Pair:
    """Return −a.

    Examples
    --------
    >>> [float(part) for part in negative(as_pair(2.0))]
    [-2.0, -0.0]
    """
    return np.negative(a[0]), np.negative(a[1])


def total(a: Pair) -> FloatArray:
    """Return a pair as one float.

    Examples
    --------
    >>> float(total(as_pair(0.5)))
    0.5
    """
    return np.asarray(a[0] + a[1])


def _two_sum(a: FloatArray, b: FloatArray) -> Pair:
    high = np.asarray(a + b)
    part = high - a
    return high, np.asarray((a - (high - part)) + (b - part))


def _quick_two_sum(a: FloatArray, b: FloatArray) -> Pair:
    high = np.asarray(a + b)
    return high, np.asarray(b - (high - a))


def _two_product(a: FloatArray, b: FloatArray) -> Pair:
    high = np.asarray(a * b)
    a_high, a_low = _split(a)
    b_high, b_low = _split(b)
    return high, np.asarray(((a_high * b_high - high) + a_high * b_low + a_low * b_high) + a_low * b_low)


def _split(a: FloatArray) -> Pair:
    scaled = _SPLITTER * a
    high = np.asarray(scaled - (scaled - a))
    return high, np.asarray(a - high)
