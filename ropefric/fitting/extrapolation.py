"""Whether a condition lies inside what was tested, and in words where it does not."""

import math
from collections.abc import Mapping

import numpy as np

from ropefric.arrays import BoolArray
from ropefric.friction.condition import Conditions

REGRESSORS = {
    "wheel_radius_m": ("wheel radius", "mm", 1e3),
    "rope_radius_m": ("rope radius", "mm", 1e3),
    "wrap_angle_rad": ("wrap", "deg", math.degrees(1.0)),
    "end_tension_N": ("end tension", "N", 1.0),
}
"""Each regressor's name in words, the unit people read it in, and the factor to that unit."""

# Settings are written in round degrees and millimetres; the last digits of the conversion are no extrapolation.
_SLACK = 1e-6

Validity = Mapping[str, tuple[float, float]]


def outside_range(validity: Validity, conditions: Conditions) -> BoolArray:
    """Return which regressors lie outside the tested range, shape (n, 4), columns in the order of `REGRESSORS`."""
    outside = np.zeros((len(conditions), len(REGRESSORS)), dtype=np.bool_)
    for column, name in enumerate(REGRESSORS):
        if name in validity:
            low, high = validity[name]
            values = getattr(conditions, name)
            outside[:, column] = (values < low * (1.0 - _SLACK)) | (values > high * (1.0 + _SLACK))
    return outside


def outside_words(validity: Validity, conditions: Conditions, index: int = 0) -> tuple[str, ...]:
    """Return one sentence for each regressor of a condition that lies outside the tested range."""
    flags = outside_range(validity, conditions.select([index]))[0]
    words = []
    for flag, (name, (title, unit, factor)) in zip(flags, REGRESSORS.items(), strict=True):
        if flag:
            low, high = (value * factor for value in validity[name])
            value = float(getattr(conditions, name)[index]) * factor
            tested = f"{low:.4g}" if math.isclose(low, high, rel_tol=_SLACK) else f"{low:.4g}–{high:.4g}"
            words.append(f"{title} {value:.4g} {unit} is outside the tested {tested} {unit}")
    return tuple(words)
