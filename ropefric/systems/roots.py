"""Roots of many cases side by side."""

from collections.abc import Callable

import numpy as np
from scipy.optimize.elementwise import find_root

from ropefric.arrays import FloatArray, IntArray


def roots_of_cases(
    function: Callable[[FloatArray], FloatArray], low: FloatArray, high: FloatArray
) -> FloatArray:
    """Return the root of each of n cases to its last digits, shape (n,); NaN where the ends have the same sign.

    `function` takes the places of all cases, shape (n,), and returns their values.
    """
    places = np.array(low, dtype=np.float64)

    def some(x: FloatArray, cases: IntArray) -> FloatArray:
        places[cases] = x
        return function(places)[cases]

    found = find_root(some, (low, high), args=(np.arange(places.size),), tolerances={"xatol": 0.0})
    return np.where(found.success, found.x, np.nan)
