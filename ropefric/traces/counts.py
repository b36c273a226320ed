"""Raw ADC counts as integers, with missing samples marked."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ropefric.errors import DataError, InputError


def as_counts(values: Any) -> NDArray[np.int64]:
    """Return raw counts as integers, with −1 where a float is NaN."""
    array = np.asarray(values)
    if array.ndim != 1 or (array.size and array.dtype.kind not in "iuf"):
        raise InputError(
            f"raw counts are a row of whole numbers, not {array.dtype} of shape {array.shape}", code="RF211"
        )
    if array.dtype == np.uint64:
        array = np.minimum(array, np.uint64(2**62))  # larger ones would turn negative, which means missing
    if array.dtype.kind != "f":
        return array.astype(np.int64, copy=False)
    missing = np.isnan(array)
    filled = np.where(missing, 0.0, array)
    wrong = (filled < 0) | (filled > 2.0**32) | (filled != np.floor(filled))
    if wrong.any():
        index = int(np.argmax(wrong))
        raise DataError(
            f"sample {index} (the first is 0) is {array[index]:g}; a raw count is a whole number from 0",
            code="RF211",
            key="counts",
            fix="name the column of raw counts, or import this one as force or voltage with its unit",
        )
    filled[missing] = -1.0
    return filled.astype(np.int64)
