"""Modified z: distance from the median in units of the median absolute deviation."""

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.trials.outliers.rule import OutlierRule

_LIMIT = 3.5
_CONSISTENT = 0.6745  # MAD/σ of a normal distribution, as printed in the source
_MEAN_CONSISTENT = 0.797885  # mean absolute deviation/σ, √(2/π)


def _judge(deviations: FloatArray) -> BoolArray:
    distance = np.abs(deviations - np.median(deviations))
    spread = float(np.median(distance)) / _CONSISTENT
    if spread == 0.0:
        # More than half of the values are equal: the mean absolute deviation still tells a spread.
        spread = float(distance.mean()) / _MEAN_CONSISTENT
    flagged: BoolArray = distance > _LIMIT * spread
    return flagged


RULE = OutlierRule(
    name="mad",
    label="the modified z-score",
    source="Iglewicz and Hoaglin, How to Detect and Handle Outliers, ASQC (1993)",
    description="all values with 0.6745 |x − median|/MAD above 3.5; mean absolute deviation where MAD is 0",
    judge=_judge,
    can_reject=lambda n: n >= 3,
    trimming=(
        (3, 0.658, 0.288),
        (4, 0.802, 0.170),
        (5, 0.810, 0.207),
        (6, 0.866, 0.152),
        (7, 0.873, 0.170),
        (8, 0.902, 0.137),
        (9, 0.907, 0.148),
        (10, 0.923, 0.125),
        (11, 0.927, 0.133),
        (12, 0.938, 0.117),
        (15, 0.949, 0.115),
        (20, 0.964, 0.098),
        (30, 0.976, 0.089),
        (50, 0.985, 0.087),
        (100, 0.992, 0.096),
    ),
)
"""The median rule: several outliers cannot hide one another."""
