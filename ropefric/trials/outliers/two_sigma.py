"""The ±2s rule of the paper: mean and s of all values, once."""

from ropefric.arrays import BoolArray, FloatArray
from ropefric.trials.outliers.rule import OutlierRule, beyond, max_z

_LIMIT = 2.0


def _judge(deviations: FloatArray) -> BoolArray:
    return beyond(deviations, _LIMIT)


RULE = OutlierRule(
    name="two-sigma",
    label="the ±2s rule",
    source="PRTH paper, section 2",
    description="all values further than 2 sample standard deviations from the mean of all; one pass",
    judge=_judge,
    can_reject=lambda n: max_z(n) > _LIMIT,
    trimming=(
        (3, 0.886, 0.000),
        (4, 0.922, 0.000),
        (5, 0.941, 0.000),
        (6, 0.949, 0.004),
        (7, 0.926, 0.061),
        (8, 0.912, 0.122),
        (9, 0.904, 0.180),
        (10, 0.899, 0.234),
        (11, 0.895, 0.285),
        (12, 0.894, 0.334),
        (15, 0.890, 0.462),
        (20, 0.886, 0.626),
        (30, 0.883, 0.821),
        (50, 0.882, 0.960),
        (100, 0.881, 0.999),
    ),
)
"""The default rule."""
