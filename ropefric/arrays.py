"""The arrays that recordings are made of."""

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]


def frozen_array(values: npt.ArrayLike) -> FloatArray:
    """Return values as a read-only float64 array that nobody else can write to.

    Integers become floats here, once: `scipy.ndimage.uniform_filter1d` answers integer input with truncated
    integers.
    """
    if (
        isinstance(values, np.ndarray)
        and values.dtype == np.float64
        and values.flags.owndata
        and not values.flags.writeable
    ):
        return values
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array


def median(values: FloatArray) -> float:
    """Return the middle value of finite numbers, the upper one of two.

    A tenth of the time of `numpy.median`, which looks for NaN and averages the middle pair; on noise, half a step
    between neighbours does not matter.
    """
    middle = values.size // 2
    return float(np.partition(values, middle)[middle])
