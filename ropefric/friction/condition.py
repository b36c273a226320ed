"""The conditions under which a rope is pulled over a wheel: who is large, how far it wraps, what hangs on it."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Self

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray, IntArray
from ropefric.errors import InputError

# Nobody sets a wheel, a wrap or a weight to a millionth, and every conversion of units and every rounding of what is
# written to nine digits stays a hundred times below it.
_SAME_SETTING = 1e-6

SETTINGS = ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N")
"""The four settings that make a condition."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Conditions:
    """Conditions of n pulls as read-only arrays of one length."""

    wheel_radius_m: FloatArray
    rope_radius_m: FloatArray
    wrap_angle_rad: FloatArray
    end_tension_N: FloatArray

    def __post_init__(self) -> None:
        arrays = {name: as_floats(name, getattr(self, name)) for name in SETTINGS}
        for name, spread in same_length("conditions", arrays).items():
            _check_range(name, arrays[name])
            own = spread.copy()
            own.flags.writeable = False
            object.__setattr__(self, name, own)
        _check_sizes(self.wheel_radius_m, self.rope_radius_m)

    def __len__(self) -> int:
        return self.wheel_radius_m.size

    @property
    def size_ratio(self) -> FloatArray:
        """Return the size ratio r = R_w/R_r [-], shape (n,)."""
        return self.wheel_radius_m / self.rope_radius_m

    @property
    def centreline_radius_m(self) -> FloatArray:
        """Return the radius of the rope's centreline R_w + R_r [m], shape (n,)."""
        return self.wheel_radius_m + self.rope_radius_m

    @property
    def log_end_tension(self) -> FloatArray:
        """Return ln(F_B / 1 N) [-], shape (n,)."""
        return np.log(self.end_tension_N)

    def select(self, index: npt.ArrayLike) -> Self:
        """Return the conditions at an index array or boolean mask, in that order."""
        chosen = np.asarray(index)
        return type(self)(**{item.name: getattr(self, item.name)[chosen] for item in fields(self)})

    def joined(self, other: "Conditions") -> "Conditions":
        """Return these and then others."""
        both = {name: np.append(getattr(self, name), getattr(other, name)) for name in SETTINGS}
        return Conditions(**both)

    def row(self, index: int) -> dict[str, float]:
        """Return the settings of one condition by name."""
        return {name: float(getattr(self, name)[index]) for name in SETTINGS}

    def describe(self, index: int) -> str:
        """Return one condition in words, for messages."""
        return (
            f"condition {index} (R_w = {self.wheel_radius_m[index]:.6g} m, "
            f"R_r = {self.rope_radius_m[index]:.6g} m, wrap = {self.wrap_angle_rad[index]:.6g} rad, "
            f"F_B = {self.end_tension_N[index]:.6g} N)"
        )


def _check_sizes(wheel_m: FloatArray, rope_m: FloatArray) -> None:
    """Refuse sizes so far apart, or so large, that their ratio or their sum is no float."""
    with np.errstate(over="ignore", under="ignore"):
        ratio = wheel_m / rope_m
        wrong = ~((ratio > 0.0) & np.isfinite(ratio) & np.isfinite(wheel_m + rope_m))
    if wrong.any():
        first = int(np.argmax(wrong))
        sizes = (
            f"wheel_radius_m[{first}] is {wheel_m[first]:g} m and rope_radius_m[{first}] {rope_m[first]:g} m"
        )
        why = f"{sizes}: no number holds R_w/R_r or R_w + R_r"
        raise InputError(why, key="wheel_radius_m", fix="give both in metres")


def one_condition(
    wheel_radius_m: float, rope_radius_m: float, wrap_angle_rad: float, end_tension_N: float
) -> Conditions:
    """Return one condition: R_w [m], R_r [m], φ [rad], F_B [N]."""
    values = (wheel_radius_m, rope_radius_m, wrap_angle_rad, end_tension_N)
    return Conditions(**{name: np.array([value]) for name, value in zip(SETTINGS, values, strict=True)})


def levels(values: npt.ArrayLike) -> IntArray:
    """Return the number 0 … m − 1 of the level each setting belongs to, by rising value, shape (n,).

    A level is what lies within a millionth above its smallest value. Nothing is rounded, so there is no edge that a
    conversion of units could put two equal settings on either side of; and since a level ends a millionth above its
    beginning, many measured values do not join hands to make one.
    """
    array = np.asarray(values, dtype=np.float64)
    order = np.argsort(array, kind="stable")
    rising = array[order]
    ends = np.searchsorted(rising, rising + _SAME_SETTING * np.abs(rising), side="right").tolist()
    begins = np.zeros(array.size, dtype=np.int64)
    at = 0
    while at < array.size:
        begins[at] = 1
        at = ends[at]
    numbers = np.empty(array.size, dtype=np.int64)
    numbers[order] = np.cumsum(begins) - 1
    return numbers


def distinct(values: npt.ArrayLike) -> FloatArray:
    """Return the smallest setting of each of the `levels`, rising, shape (m,)."""
    array = np.sort(np.asarray(values, dtype=np.float64))
    return np.asarray(array[np.unique(levels(array), return_index=True)[1]])


def condition_groups(*settings: npt.ArrayLike) -> IntArray:
    """Return the number 0 … k − 1 of the condition of each pull, in order of appearance, shape (n,).

    The one rule by which pulls are put together everywhere: all their settings have the same `levels`.
    """
    found = levels(settings[0])
    for values in settings[1:]:
        number = levels(values)
        # Numbered anew each time, so that the product of all levels need not fit into an integer.
        found = np.unique(found * (number.max(initial=0) + 1) + number, return_inverse=True)[1]
    _, first, group = np.unique(found, return_index=True, return_inverse=True)
    rank = np.empty(first.size, dtype=np.int64)
    rank[np.argsort(first, kind="stable")] = np.arange(first.size)
    return np.asarray(rank[group])


def along_one(conditions: Conditions, over: str) -> tuple[IntArray, IntArray]:
    """Return where most conditions stand that differ in one setting alone, and the level of each in that."""
    others = condition_groups(*(getattr(conditions, name) for name in SETTINGS if name != over))
    along = levels(getattr(conditions, over))
    counts = [np.unique(along[others == group]).size for group in range(int(others.max()) + 1)]
    return np.flatnonzero(others == int(np.argmax(counts))), along  # the first of equals


def as_floats(name: str, values: npt.ArrayLike) -> FloatArray:
    """Return numbers given for pulls as one list."""
    try:
        array = np.atleast_1d(np.asarray(values, dtype=np.float64))
    except (TypeError, ValueError):
        why = f"{name} is not a number or a list of numbers: {values!r:.60}"
        raise InputError(why, key=name, fix="give SI numbers") from None
    if array.ndim > 1:
        why = f"{name} has {array.ndim} axes {array.shape}; conditions are one list"
        raise InputError(why, key=name, fix="ravel the array")
    return array


def same_length(what: str, arrays: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """Return lists as arrays of one length; a single value counts for all."""
    try:
        return dict(zip(arrays, np.broadcast_arrays(*arrays.values()), strict=True))
    except ValueError:
        lengths = ", ".join(f"{name} has {array.size}" for name, array in arrays.items())
        fix = "give one value each, or one for all"
        raise InputError(f"the {what} disagree in length: {lengths}", fix=fix) from None


def _check_range(name: str, array: FloatArray) -> None:
    rule, unit = ("zero or more" if name == "wrap_angle_rad" else "positive"), name.rpartition("_")[2]
    high_enough = array >= 0.0 if rule == "zero or more" else array > 0.0
    wrong = ~(high_enough & np.isfinite(array))
    if wrong.any():
        first = int(np.argmax(wrong))
        why = f"{name}[{first}] is {array[first]:g} {unit}; it must be finite and {rule}"
        fix = f"correct or leave out this condition ({int(wrong.sum())} of {array.size} are wrong)"
        raise InputError(why, key=name, fix=fix)
