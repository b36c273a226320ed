"""Grubbs' test of the most extreme value of a series."""

import math

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.trials.outliers.rule import OutlierRule, beyond

_ALPHA = 0.05
_TIED = 1e-12


def critical_value(n: int, alpha: float = _ALPHA, *, sides: int = 2) -> float:
    """Return the critical value of Grubbs' statistic max |x − mean|/s; infinite for fewer than 3 values.

    G = (n − 1)/√n · √(t²/(n − 2 + t²)), with t the upper α/(sides·n) quantile of Student's distribution with
    n − 2 degrees of freedom. Source: ASTM E178; Grubbs, Technometrics 11 (1969) 1.
    """
    if not 0.0 < alpha < 1.0 or sides not in {1, 2}:
        raise InputError(
            f"no critical value for alpha = {alpha:g} and {sides} sides",
            code="RF312",
            fix="choose alpha between 0 and 1, for example 0.05, and 1 or 2 sides",
        )
    if n < 3:
        return math.inf
    # Loaded here, because every command lists the rules when it starts, and few apply this one.
    from scipy.special import stdtrit  # noqa: PLC0415

    t = -float(stdtrit(n - 2, alpha / (sides * n)))
    return (n - 1) / math.sqrt(n) * math.sqrt(t * t / (n - 2 + t * t))


def _judge(deviations: FloatArray) -> BoolArray:
    distance = np.abs(deviations - deviations.mean())
    # Values that are equally extreme share one fate: which comes first in the list must not matter.
    extreme = distance >= distance.max() * (1.0 - _TIED)
    flagged: BoolArray = extreme & beyond(deviations, critical_value(deviations.size))
    return flagged


RULE = OutlierRule(
    name="grubbs",
    label="Grubbs' test",
    source="ASTM E178; Grubbs, Technometrics 11 (1969) 1",
    description="the most extreme value, if a clean normal series had it once in 20 times or less; one pass, "
    "two-sided, alpha 0.05",
    judge=_judge,
    can_reject=lambda n: n >= 3,
    trimming=(
        (3, 0.843, 0.050),
        (4, 0.883, 0.050),
        (5, 0.905, 0.049),
        (6, 0.920, 0.050),
        (7, 0.931, 0.050),
        (8, 0.939, 0.050),
        (9, 0.947, 0.050),
        (10, 0.951, 0.050),
        (11, 0.955, 0.050),
        (12, 0.959, 0.050),
        (15, 0.967, 0.050),
        (20, 0.975, 0.050),
        (30, 0.983, 0.050),
        (50, 0.989, 0.050),
        (100, 0.994, 0.050),
    ),
)
"""Grubbs' two-sided test at 5 %."""
