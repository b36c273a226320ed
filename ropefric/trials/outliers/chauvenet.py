"""Chauvenet's criterion: values of which less than half a one was to be expected."""

from statistics import NormalDist

from ropefric.arrays import BoolArray, FloatArray
from ropefric.trials.outliers.rule import OutlierRule, beyond, max_z


def limit(n: int) -> float:
    """Return the |z| that half a value of n normal ones is expected to exceed: n·P(|z| > limit) = 1/2.

    Source: Taylor, An Introduction to Error Analysis, 2nd ed. (1997) chapter 6.
    """
    return NormalDist().inv_cdf(1.0 - 1.0 / (4.0 * max(n, 1)))


def _judge(deviations: FloatArray) -> BoolArray:
    return beyond(deviations, limit(deviations.size))


RULE = OutlierRule(
    name="chauvenet",
    label="Chauvenet's criterion",
    source="Taylor, An Introduction to Error Analysis (1997) chapter 6",
    description="all values so far from the mean that less than half a value of n was expected there; one pass",
    judge=_judge,
    can_reject=lambda n: max_z(n) > limit(n),
    trimming=(
        (3, 0.887, 0.000),
        (4, 0.921, 0.000),
        (5, 0.855, 0.136),
        (6, 0.854, 0.196),
        (7, 0.862, 0.228),
        (8, 0.872, 0.250),
        (9, 0.881, 0.264),
        (10, 0.889, 0.276),
        (11, 0.896, 0.285),
        (12, 0.901, 0.293),
        (15, 0.915, 0.310),
        (20, 0.930, 0.327),
        (30, 0.947, 0.343),
        (50, 0.963, 0.359),
        (100, 0.978, 0.371),
    ),
)
"""Chauvenet's criterion with sample mean and s."""
