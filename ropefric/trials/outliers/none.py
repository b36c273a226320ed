"""No rejection."""

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.trials.outliers.rule import OutlierRule


def _judge(deviations: FloatArray) -> BoolArray:
    return np.zeros(deviations.shape, dtype=np.bool_)


RULE = OutlierRule(
    name="none",
    label="no rule",
    source="",
    description="nothing",
    judge=_judge,
    can_reject=lambda _n: False,
)
"""Keep everything."""
