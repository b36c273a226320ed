"""Numbers that people give: finite, of the right sign, of a size that a machine has, and of one length."""

from collections.abc import Mapping
from typing import Literal

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError

Rule = Literal["positive", "zero or more", "any"]

_LOWEST = {"positive": np.nextafter(0.0, 1.0), "zero or more": 0.0, "any": -np.inf}
_LARGEST, _SMALLEST = 1e30, 1e-30


def checked(name: str, values: npt.ArrayLike, rule: Rule = "positive") -> FloatArray:
    """Return numbers that are finite and keep to a rule; refuse any others by name."""
    array = np.asarray(values, dtype=np.float64)
    wrong = ~((array >= _LOWEST[rule]) & np.isfinite(array))
    if wrong.any():
        wanted = "finite" if rule == "any" else f"finite and {rule}"
        raise InputError(
            f"{name} is {array[wrong].ravel()[0]:g}; it must be {wanted}", key=name, fix="correct this value"
        )
    return array


def out_of_scale(values: npt.ArrayLike, *, may_vanish: bool) -> BoolArray:
    """Return where a quantity is above 1e30 in amount, or below 1e-30 if it may not vanish.

    No machine has such numbers, and squares and quotients of them are no floats.
    """
    size = np.abs(np.asarray(values, dtype=np.float64))
    return np.asarray((size > _LARGEST) | ((size < _SMALLEST) & (not may_vanish)))


def refuse_out_of_scale(name: str, values: npt.ArrayLike, *, may_vanish: bool) -> None:
    """Refuse a quantity above 1e30 in amount, or below 1e-30 if it may not vanish."""
    array = np.atleast_1d(np.asarray(values, dtype=np.float64))
    beyond = out_of_scale(array, may_vanish=may_vanish)
    if beyond.any():
        raise InputError(
            f"{name} is {array[beyond][0]:g}, beyond anything from {_SMALLEST:g} to {_LARGEST:g} in SI units",
            key=name,
            fix="check the unit it was given in",
        )


def side_by_side(
    values: Mapping[str, npt.ArrayLike | None], rules: Mapping[str, Rule]
) -> dict[str, FloatArray]:
    """Return the values that are given, many cases side by side: checked, and spread to arrays of one length."""
    given = {
        name: np.atleast_1d(checked(name, value, rules[name]))
        for name, value in values.items()
        if value is not None
    }
    try:
        shape = np.broadcast_shapes(*(array.shape for array in given.values()))
    except ValueError:
        lengths = ", ".join(f"{name} has {array.size}" for name, array in given.items() if array.size > 1)
        raise InputError(
            f"the cases disagree in length: {lengths}", fix="give one value each, or one for all"
        ) from None
    return {name: np.broadcast_to(array, shape) for name, array in given.items()}
