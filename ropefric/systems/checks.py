"""Numbers that people give: finite, of the right sign, of a size that a machine has, and of one length."""

import math
from dataclasses import dataclass, field, fields, replace
from functools import lru_cache
from typing import Annotated, Any, Literal, Self, get_args

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError

Rule = Literal["positive", "zero or more", "any", "from 0 to 1"]

_RANGES = {
    "positive": (1e-30, 1e30, "finite and positive, from 1e-30 to 1e30 in SI units"),
    "zero or more": (0.0, 1e30, "finite and zero or more, up to 1e30 in SI units"),
    "any": (-1e30, 1e30, "finite, up to 1e30 in SI units"),
    "from 0 to 1": (0.0, 1.0, "from 0 to 1"),
}
"""No machine has other numbers, and their squares and quotients are no floats."""


def checked(name: str, values: npt.ArrayLike, rule: Rule = "positive") -> FloatArray:
    """Return numbers that keep to a rule; refuse others by name."""
    array, (low, high, wanted) = np.asarray(values, dtype=np.float64), _RANGES[rule]
    wrong = ~((array >= low) & (array <= high))
    if wrong.any():
        raise InputError(
            f"{name} is {array[wrong].ravel()[0]:g}; it must be {wanted}",
            key=name,
            fix="correct this value, or the unit it was given in",
        )
    return array


def refuse(wrong: BoolArray, words: str, *, key: str, fix: str = "", code: str = "", **values: Any) -> None:
    """Refuse the first of many cases in which something is wrong.

    In the words and the fix `{name}` is its value there and `{place}` the number of the case, if there are many.
    """
    if wrong.any():
        first = int(np.argmax(wrong))
        here = {name: np.broadcast_to(value, wrong.shape)[first] for name, value in values.items()}
        here["place"] = f" at case {first}" if wrong.size > 1 else ""
        raise InputError(words.format(**here), code=code, key=key, fix=fix.format(**here), cases=wrong)


Positive = Annotated[FloatArray, "positive"]
ZeroOrMore = Annotated[FloatArray, "zero or more"]
AnyNumber = Annotated[FloatArray, "any"]
Share = Annotated[FloatArray, "from 0 to 1"]


@dataclass(frozen=True, kw_only=True, eq=False)  # no slots: those who have it as base need none
class Cases:
    """Quantities by name, n cases side by side: scalars are spread; each field's type says what it may be."""

    n: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        rules = rules_of(type(self))  # type: ignore[arg-type]  # a class is hashable
        values = {name: getattr(self, name) for name in rules if getattr(self, name) is not None}
        given = {name: np.atleast_1d(checked(name, one, rules[name])) for name, one in values.items()}
        try:
            shape = np.broadcast_shapes(*(array.shape for array in given.values()))
        except ValueError:
            lengths = ", ".join(f"{name} has {array.size}" for name, array in given.items() if array.size > 1)
            raise InputError(
                f"the cases disagree in length: {lengths}", fix="give one value each, or one for all"
            ) from None
        for name, array in given.items():
            if array.ndim != 1:
                raise InputError(f"{name} has {array.ndim} axes; it has one, of its cases", key=name)
            object.__setattr__(self, name, np.broadcast_to(array, shape))
        object.__setattr__(self, "n", shape[0])

    def select(self, index: npt.ArrayLike) -> Self:
        """Return the cases at an index array or boolean mask, in that order."""
        values = {name: getattr(self, name) for name in rules_of(type(self))}  # type: ignore[arg-type]  # a class is hashable
        return replace(
            self, **{name: one[np.asarray(index)] for name, one in values.items() if one is not None}
        )

    def product(self, *names: str) -> FloatArray:
        """Return the product of quantities, shape (n,); zero where one of them is not given."""
        factors = [getattr(self, name) for name in names]
        if any(one is None for one in factors):
            return np.zeros(self.n)
        return np.broadcast_to(math.prod(map(lean, factors)), (self.n,))


def lean(values: FloatArray) -> FloatArray:
    """Return one value where an array has been spread from one, so that equal cases are computed once."""
    return values[:1] if values.strides == (0,) else values


@lru_cache(maxsize=32)
def rules_of(kind: Any) -> dict[str, Rule]:
    """Return the rules of the fields that are `Positive` and the like, or None."""
    return {
        one.name: rule
        for one in fields(kind)
        for part in (one.type, *get_args(one.type))
        for rule in getattr(part, "__metadata__", ())
    }
