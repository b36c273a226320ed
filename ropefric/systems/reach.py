"""Numbers so large or small that no machine has them, and that squares and quotients of them are no floats."""

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray
from ropefric.errors import InputError

_LARGEST, _SMALLEST = 1e30, 1e-30


def beyond_reach(values: npt.ArrayLike, *, may_vanish: bool) -> BoolArray:
    """Return where a quantity is above 1e30 in amount, or below 1e-30 if it may not vanish.

    Arguments as in `refuse_beyond_reach`.
    """
    size = np.abs(np.asarray(values, dtype=np.float64))
    return np.asarray((size > _LARGEST) | ((size < _SMALLEST) & (not may_vanish)))


def refuse_beyond_reach(name: str, values: npt.ArrayLike, *, may_vanish: bool) -> None:
    """Refuse a quantity above 1e30 in amount, or below 1e-30 if it may not vanish."""
    array = np.atleast_1d(np.asarray(values, dtype=np.float64))
    beyond = beyond_reach(array, may_vanish=may_vanish)
    if beyond.any():
        raise InputError(
            f"{name} is {array[beyond][0]:g}, beyond anything from {_SMALLEST:g} to {_LARGEST:g} in SI units",
            key=name,
            fix="check the unit it was given in",
        )
