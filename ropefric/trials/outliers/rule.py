"""What an outlier rule is, and the arithmetic all rules share."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError

_LARGEST = 1e300
_ROUNDING = 1e-12  # a value on the limit, but for rounding, counts as inside


@dataclass(frozen=True, slots=True, kw_only=True)
class OutlierRule:
    """One way to set values aside; each is applied once.

    Attributes
    ----------
    name : str
        The name users give.
    label : str
        What it is called in a sentence: "the ±2s rule".
    source : str
        Where it comes from.
    description : str
        One line: what it flags.
    judge : callable
        Says of three or more deviations (see `Scaled`), shape (n,), which are rejected.
    can_reject : callable
        `can_reject(n)` returns whether the rule can flag anything at all among n values.
    trimming : tuple of (n, ratio, share)
        For clean normal series of n values: expected s of the kept values over σ, and the share of series that
        lose a value. From simulation, to 0.002.

    Examples
    --------
    >>> from ropefric.trials.outliers import RULES
    >>> RULES["two-sigma"].flag([7.18, 7.64, 8.00, 7.40, 9.14, 7.82, 7.67, 7.73, 8.27, 7.30]).nonzero()[0]
    array([4])
    """

    name: str
    label: str
    source: str
    description: str
    judge: Callable[[FloatArray], BoolArray]
    can_reject: Callable[[int], bool]
    trimming: tuple[tuple[int, float, float], ...] = field(default=(), repr=False)

    def flag(self, values: npt.ArrayLike) -> BoolArray:
        """Return which values are rejected, True for a rejected one; the values are not changed.

        Parameters
        ----------
        values : array_like, shape (n,)
            Finite numbers. Of fewer than three, or of equal ones, none is rejected.

        Raises
        ------
        InputError
            RF311 if a value is missing or not finite, or the shape is another one.
        """
        deviations = scaled(values).deviations
        return self.judge(deviations) if deviations.size > 2 else np.zeros(deviations.shape, dtype=np.bool_)

    def warning(self, n: int) -> str:
        """Return why nothing can be rejected among n values; empty if something can, or is not meant to be.

        Examples
        --------
        >>> from ropefric.trials.outliers import RULES
        >>> RULES["two-sigma"].warning(5)
        'n = 5, the ±2s rule cannot reject anything (max |z| = 1.79)'
        """
        never = not self.can_reject(10**6)
        if never or self.can_reject(n):
            return ""
        reach = f" (max |z| = {max_z(n):.2f})" if n > 0 else ""
        return f"n = {n}, {self.label} cannot reject anything{reach}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Scaled:
    """Values as `shift` + `scale`·`deviations`, with deviations of order 1."""

    shift: float
    scale: float
    deviations: FloatArray

    def mean(self) -> float:
        """Return the mean of the values; NaN for none."""
        if not self.deviations.size:
            return math.nan
        return self.shift + self.scale * (math.fsum(self.deviations) / self.deviations.size)

    def std(self) -> float:
        """Return the sample standard deviation of the values, divisor n − 1; NaN for fewer than two."""
        return self.scale * float(self.deviations.std(ddof=1)) if self.deviations.size > 1 else math.nan


def scaled(values: npt.ArrayLike) -> Scaled:
    """Return values relative to their middle one, so that a large common offset costs no digits.

    The difference of nearby floats is exact; squares are formed only afterwards (two-pass).
    """
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{values!r} is not a series of numbers", code="RF311") from None
    if array.ndim != 1:
        raise InputError(f"a series has one dimension, not shape {array.shape}", code="RF311")
    wrong = ~(np.abs(array) <= _LARGEST)
    if wrong.any():
        index = int(np.argmax(wrong))
        raise InputError(
            f"value {index + 1} of {array.size} is {array[index]}, so no mean and no limit can be formed",
            code="RF311",
            fix="leave trials without a break-away force out of the series",
        )
    if array.size == 0:
        return Scaled(shift=math.nan, scale=1.0, deviations=array)
    shift = float(np.partition(array, array.size // 2)[array.size // 2])
    array -= shift
    exponent = math.frexp(float(np.abs(array).max()))[1]
    # Two steps, because 2^-exponent alone overflows for the smallest floats.
    half = exponent // 2
    array = np.ldexp(np.ldexp(array, -half), half - exponent)
    return Scaled(shift=shift, scale=math.ldexp(1.0, exponent), deviations=array)


def beyond(deviations: FloatArray, z_limit: float) -> BoolArray:
    """Return which values lie more than `z_limit` sample standard deviations from the mean."""
    distance = np.abs(deviations - deviations.mean())
    flagged: BoolArray = distance > z_limit * (1.0 + _ROUNDING) * float(deviations.std(ddof=1))
    return flagged


def max_z(n: int) -> float:
    """Return the largest |z| that one of n values can reach, (n − 1)/√n; 0 for no value.

    Source: Shiffler, The American Statistician 42 (1988) 79.
    """
    return (n - 1) / math.sqrt(n) if n > 0 else 0.0
