"""The arrays that recordings are made of."""

from typing import Any

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]


def frozen_array(values: npt.ArrayLike) -> FloatArray:
    """Return values as a read-only float64 array that nobody else can write to; a copy, unless they are that already.

    Integers become floats here, once: `scipy.ndimage.uniform_filter1d` answers integer input with truncated
    integers.
    """
    if isinstance(values, np.ndarray) and values.dtype == np.float64:
        owner: Any = values if values.base is None else values.base
        if isinstance(owner, np.ndarray) and owner.flags.owndata and not owner.flags.writeable:
            return values
    return sealed(np.array(values, dtype=np.float64))


def sealed(values: FloatArray) -> FloatArray:
    """Return an array, read-only from now on; for its maker only, who has given it to nobody that writes to it."""
    values.flags.writeable = False
    return values


def median(values: FloatArray) -> float:
    """Return the middle value of finite numbers, the upper one of two; on noise, half a step does not matter.

    Two places are asked for, as by `numpy.median`: with one, partition takes twenty times as long on equal steps.
    """
    middle = values.size // 2
    return float(np.partition(values, (max(middle - 1, 0), middle))[middle])
