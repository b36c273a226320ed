"""Rules that set values of a series aside, by name; the arithmetic they share, and a series with and without them."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError, Problem
from ropefric.registry import Registry
from ropefric.shown import Shown

_LARGEST = 1e300
_TIED = 1e-12
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
    good_lost : callable
        `good_lost(n)` returns how many values of a clean normal series of n it rejects on average; NaN if not known.
    trimming : tuple of (n, ratio)
        For clean normal series of n values: expected s of the kept values over σ. From simulation, to 0.002.

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
    good_lost: Callable[[int], float] = lambda _n: math.nan
    trimming: tuple[tuple[int, float], ...] = field(default=(), repr=False)

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


class Scaled(NamedTuple):
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
        array = np.empty((0, 0))
    if array.ndim != 1:
        text = f"{values!r:.60} is not a series of numbers in one dimension"
        raise InputError(text, code="RF311", key="values", fix="give a list of numbers")
    wrong = ~(np.abs(array) <= _LARGEST)
    if wrong.any():
        index = int(np.argmax(wrong))
        which = f"value {index + 1} of {array.size} is {array[index]}"
        message = f"{which}, so no mean and no limit can be formed"
        fix = "leave trials without a break-away force out of the series"
        raise InputError(message, code="RF311", fix=fix)
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


def expected_beyond(n: int, z_limit: float) -> float:
    """Return how many of n normal values lie further than `z_limit` of their own s from their own mean, on average.

    (x − mean)²/s² · n/(n − 1)² follows the beta distribution of 1/2 and (n − 2)/2 (Thompson 1935).
    """
    if n < 3 or z_limit >= max_z(n):
        return 0.0
    from scipy.special import betainc  # noqa: PLC0415  (as below)

    return n * (1.0 - float(betainc(0.5, 0.5 * (n - 2), n * (z_limit / (n - 1)) ** 2)))


def grubbs_critical_value(n: int) -> float:
    """Return the two-sided 5 % critical value of Grubbs' statistic max |x − mean|/s; infinite for fewer than 3 values.

    G = (n − 1)/√n · √(t²/(n − 2 + t²)), with t the upper 0.05/(2n) quantile of Student's distribution with
    n − 2 degrees of freedom. Source: ASTM E178; Grubbs, Technometrics 11 (1969) 1.
    """
    if n < 3:
        return math.inf
    # Loaded here, because every command lists the rules when it starts, and few apply this one.
    from scipy.special import stdtrit  # noqa: PLC0415

    t = -float(stdtrit(n - 2, 0.05 / (2 * n)))
    return (n - 1) / math.sqrt(n) * math.sqrt(t * t / (n - 2 + t * t))


def _judge_by_grubbs(deviations: FloatArray) -> BoolArray:
    distance = np.abs(deviations - deviations.mean())
    # Values that are equally extreme share one fate: which comes first in the list must not matter.
    extreme = distance >= distance.max() * (1.0 - _TIED)
    flagged: BoolArray = extreme & beyond(deviations, grubbs_critical_value(deviations.size))
    return flagged


# n: s of the kept values over σ by two-sigma and by grubbs.
_TRIMMING = {
    3: (0.886, 0.843),
    4: (0.922, 0.883),
    5: (0.941, 0.905),
    6: (0.949, 0.920),
    7: (0.926, 0.931),
    8: (0.912, 0.939),
    9: (0.904, 0.947),
    10: (0.899, 0.951),
    11: (0.895, 0.955),
    12: (0.894, 0.959),
    15: (0.890, 0.967),
    20: (0.886, 0.975),
    30: (0.883, 0.983),
    50: (0.882, 0.989),
    100: (0.881, 0.994),
}


def _trimming(column: int) -> tuple[tuple[int, float], ...]:
    return tuple((n, row[column]) for n, row in _TRIMMING.items())


RULES: Registry[OutlierRule] = Registry(
    "outlier rule",
    [
        OutlierRule(
            name="two-sigma",
            label="the ±2s rule",
            source="PRTH paper, section 2",
            description="all values further than 2 sample standard deviations from the mean of all; one pass",
            judge=lambda deviations: beyond(deviations, 2.0),
            can_reject=lambda n: max_z(n) > 2.0,
            good_lost=lambda n: expected_beyond(n, 2.0),
            trimming=_trimming(0),
        ),
        OutlierRule(
            name="grubbs",
            label="Grubbs' test",
            source="ASTM E178; Grubbs, Technometrics 11 (1969) 1",
            description="the most extreme value, if a clean normal series had it once in 20 times or less; one pass, "
            "two-sided, alpha 0.05",
            judge=_judge_by_grubbs,
            can_reject=lambda n: n >= 3,
            good_lost=lambda n: 0.05 if n >= 3 else 0.0,
            trimming=_trimming(1),
        ),
        OutlierRule(
            name="none",
            label="no rule",
            source="",
            description="nothing",
            judge=lambda deviations: np.zeros(deviations.shape, dtype=np.bool_),
            can_reject=lambda _n: False,
            good_lost=lambda _n: 0.0,
        ),
    ],
)
"""Every rule: two-sigma (the paper's, the default), grubbs, none."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Repeatability(Shown):
    """The repeatability of one condition.

    Attributes
    ----------
    rule : str
        Name of the outlier rule.
    n, n_kept : int
        Number of values, and of those kept.
    rejected : tuple of int
        Indices of the rejected values, from 0.
    mean_all, std_all : float
        Mean and sample standard deviation (divisor n − 1) of all values, in their unit; NaN where there are too
        few for one, 1 and 2.
    mean_kept, std_kept : float
        The same of the kept values.
    warnings : tuple of str
        RF310: why the rule could not reject anything.
    notes : tuple of str
        What rejection does to the scatter, if something was rejected.
    """

    _said = ("rule", "n", "n_kept", "rejected", "mean_kept", "std_kept", "mean_all", "std_all", "warnings")

    rule: str
    n: int
    n_kept: int
    rejected: tuple[int, ...]
    mean_all: float
    std_all: float
    mean_kept: float
    std_kept: float
    warnings: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def problems(self) -> tuple[Problem, ...]:
        """Return the warnings as problems with code RF310."""
        return tuple(Problem(code="RF310", message=text, severity="warning") for text in self.warnings)


def summarise(values: npt.ArrayLike, rule: OutlierRule | str = "two-sigma") -> Repeatability:
    """Return mean and scatter of a series, with and without the values that a rule rejects in one pass."""
    if isinstance(rule, str):
        rule = RULES[rule]
    everything, rejected = scaled(values), rule.flag(values)
    kept = scaled(np.asarray(values, dtype=np.float64)[~rejected])
    n, n_kept = rejected.size, kept.deviations.size
    warning, note = rule.warning(n), ""
    if n_kept < n:
        low = f"s of what it keeps reads {-100 * trimming_bias(n, rule):.0f} % low on average"
        note = f"{rule.label} rejected {n - n_kept} of {n}: in clean normal series {low}"
    return Repeatability(
        rule=rule.name,
        n=n,
        n_kept=n_kept,
        rejected=tuple(np.flatnonzero(rejected).tolist()),
        mean_all=everything.mean(),
        std_all=everything.std(),
        mean_kept=kept.mean(),
        std_kept=kept.std(),
        warnings=(warning,) if warning else (),
        notes=(note,) if n_kept < n and rule.trimming else (),
    )


def trimming_bias(n: int, rule: OutlierRule | str = "two-sigma") -> float:
    """Return by what share s reads low, below zero, where a rule is applied to clean normal series of n values.

    Interpolated in 1/n from the rule's table of simulated values, which holds 3 to 100 values; above 100 the last
    entry is used.
    """
    if n < 2:
        raise InputError(f"a series of {n} has no scatter", code="RF313", fix="use two values or more")
    if isinstance(rule, str):
        rule = RULES[rule]
    if not rule.trimming or not rule.can_reject(n):
        return 0.0
    # E[s]/σ of untrimmed normal series (c4 of control charts): s itself reads low for few values.
    untrimmed = math.sqrt(2.0 / (n - 1)) * math.exp(math.lgamma(n / 2.0) - math.lgamma((n - 1) / 2.0))
    sizes, ratios = (np.array(column) for column in zip(*reversed(rule.trimming), strict=True))
    return float(np.interp(1.0 / n, 1.0 / sizes, ratios)) / untrimmed - 1.0
