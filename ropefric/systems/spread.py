"""Numbers of many cases side by side: checked one by one, and spread to one length."""

from collections.abc import Mapping
from typing import Literal

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.errors import InputError

Rule = Literal["positive", "zero or more", "any"]

_LOWEST = {"positive": np.nextafter(0.0, 1.0), "zero or more": 0.0, "any": -np.inf}


def spread(values: Mapping[str, npt.ArrayLike | None], rules: Mapping[str, Rule]) -> dict[str, FloatArray]:
    """Return the values that are given as arrays of one length."""
    given = {
        name: np.atleast_1d(np.asarray(value, dtype=np.float64))
        for name, value in values.items()
        if value is not None
    }
    try:
        shape = np.broadcast_shapes(*(array.shape for array in given.values()))
    except ValueError:
        lengths = ", ".join(f"{name} has {array.size}" for name, array in given.items())
        raise InputError(
            f"the cases disagree in length: {lengths}", fix="give one value each, or one for all"
        ) from None
    for name, array in given.items():
        rule = rules[name]
        wrong = ~((array >= _LOWEST[rule]) & np.isfinite(array))
        if wrong.any():
            wanted = "finite" if rule == "any" else f"finite and {rule}"
            raise InputError(
                f"{name} is {array[wrong][0]:g}; it must be {wanted}", key=name, fix="correct this value"
            )
    return {name: np.broadcast_to(array, shape) for name, array in given.items()}
