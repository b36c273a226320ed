"""The series of one condition in numbers: mean and scatter with and without what a rule sets aside."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ropefric.errors import InputError, Problem
from ropefric.trials.outliers import RULES
from ropefric.trials.outliers.rule import OutlierRule, scaled


@dataclass(frozen=True, slots=True, kw_only=True)
class Trimming:
    """What a rule does to clean normal series of n values."""

    ratio: float
    bias: float
    share: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Repeatability:
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
    warning = rule.warning(n)
    return Repeatability(
        rule=rule.name,
        n=n,
        n_kept=n_kept,
        rejected=tuple(int(index) for index in np.flatnonzero(rejected)),
        mean_all=everything.mean(),
        std_all=everything.std(),
        mean_kept=kept.mean(),
        std_kept=kept.std(),
        warnings=(warning,) if warning else (),
        notes=(_trimming_note(n, rule),) if n_kept < n and rule.trimming else (),
    )


def trimming_bias(n: int, rule: OutlierRule | str = "two-sigma") -> Trimming:
    """Return what a rule does to clean normal series: how low s reads, and how often a good value is lost.

    Interpolated in 1/n from the rule's table of simulated values, which holds 3 to 100 values; above 100 the last
    entry stands.
    """
    if n < 2:
        raise InputError(f"a series of {n} has no scatter", code="RF313", fix="ask for two values or more")
    if isinstance(rule, str):
        rule = RULES[rule]
    # E[s]/σ of untrimmed normal series (c4 of control charts): s itself reads low for few values.
    untrimmed = math.sqrt(2.0 / (n - 1)) * math.exp(math.lgamma(n / 2.0) - math.lgamma((n - 1) / 2.0))
    if not rule.trimming or not rule.can_reject(n):
        return Trimming(ratio=untrimmed, bias=0.0, share=0.0)
    sizes, ratios, shares = (np.array(column) for column in zip(*reversed(rule.trimming), strict=True))
    ratio = float(np.interp(1.0 / n, 1.0 / sizes, ratios))
    return Trimming(
        ratio=ratio, bias=ratio / untrimmed - 1.0, share=float(np.interp(1.0 / n, 1.0 / sizes, shares))
    )


def _trimming_note(n: int, rule: OutlierRule) -> str:
    clean = trimming_bias(n, rule)
    return (
        f"{rule.label} takes a good value from {100 * clean.share:.0f} % of clean normal series of n = {n}, and s "
        f"of what it keeps reads {-100 * clean.bias:.0f} % low on average"
    )
