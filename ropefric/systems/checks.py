"""Numbers that people give: finite, of the right sign, of a size that a machine has, and of one length."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import lru_cache
from typing import Annotated, Any, Literal, get_args

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


def refuse(wrong: BoolArray, words: str, *, key: str, fix: str = "", code: str = "", **values: Any) -> None:
    """Refuse the first of many cases in which something is wrong.

    In the words and the fix `{name}` stands for its value there and `{place}` for which case it is, if there are many.
    """
    if wrong.any():
        first = int(np.argmax(wrong))
        here = {name: np.broadcast_to(value, wrong.shape)[first] for name, value in values.items()}
        here["place"] = f" at case {first}" if wrong.size > 1 else ""
        raise InputError(words.format(**here), code=code, key=key, fix=fix.format(**here))


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


Positive = Annotated[FloatArray, "positive"]
ZeroOrMore = Annotated[FloatArray, "zero or more"]
AnyNumber = Annotated[FloatArray, "any"]


@dataclass(frozen=True, kw_only=True, eq=False)  # no slots: those who have it as base need none
class Cases:
    """Quantities by name, n cases side by side: scalars are spread; each field's type says what it may be."""

    n: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        rules = _rules(type(self))  # type: ignore[arg-type]  # a class is hashable
        for name, array in side_by_side({name: getattr(self, name) for name in rules}, rules).items():
            if array.ndim != 1:
                raise InputError(f"{name} has {array.ndim} axes; it has one, of its cases", key=name)
            refuse_out_of_scale(name, array, may_vanish=rules[name] != "positive")
            object.__setattr__(self, name, array)
            object.__setattr__(self, "n", array.size)

    def product(self, *names: str) -> FloatArray:
        """Return the product of quantities, shape (n,); zero where one of them is not given."""
        factors = [getattr(self, name) for name in names]
        return np.zeros(self.n) if any(one is None for one in factors) else np.asarray(math.prod(factors))


@lru_cache(maxsize=32)
def _rules(kind: Any) -> dict[str, Rule]:
    """Return the rules of the fields that are `Positive` and the like, or None."""
    return {
        one.name: rule
        for one in fields(kind)
        for part in (one.type, *get_args(one.type))
        for rule in getattr(part, "__metadata__", ())
    }
