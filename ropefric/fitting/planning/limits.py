"""What a rig can do: wheels, wraps, end tensions and the largest force its cell takes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from itertools import product

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.friction.condition import Conditions

FACTORS = ("wheel_radius_m", "wrap_angle_rad", "end_tension_N")
"""What a plan may vary; the rope is the same throughout."""

_MOST_LEVELS, _MOST_CONDITIONS = 1000, 50_000
"""Of one factor, and of all combinations, each of which the search weighs against the others."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RigLimits:
    """Every setting a rig offers; each combination is a condition that might be tested."""

    wheel_radius_m: tuple[float, ...]
    wrap_angle_rad: tuple[float, ...]
    end_tension_N: tuple[float, ...]
    rope_radius_m: float
    largest_force_N: float = math.inf

    def __post_init__(self) -> None:
        for name in FACTORS:
            levels = sorted(float(level) for level in getattr(self, name))
            if not levels or not (levels[0] > 0.0 and math.isfinite(levels[-1])):
                raise InputError(
                    f"{name}: {levels} are no settings", key=name, fix="give one or more above zero"
                )
            if len(set(levels)) < len(levels):
                raise InputError(f"{name}: a setting is given twice", key=name, fix="give each once")
            object.__setattr__(self, name, tuple(levels))
        if math.prod(self.shape) > _MOST_CONDITIONS:
            sizes = " × ".join(str(size) for size in self.shape)
            raise InputError(
                f"{sizes} settings are {math.prod(self.shape)} conditions; the limit is {_MOST_CONDITIONS}",
                key="limits",
                fix="give fewer wheels, wraps or end tensions, or fewer levels",
            )
        for item in fields(self):
            if item.name not in FACTORS and not getattr(self, item.name) > 0.0:
                raise InputError(f"{item.name} = {getattr(self, item.name):g} is not positive", key=item.name)

    @property
    def shape(self) -> tuple[int, ...]:
        """Return the number of settings of each factor."""
        return tuple(len(getattr(self, name)) for name in FACTORS)

    def conditions(self) -> Conditions:
        """Return all combinations, wheel by wheel, wrap by wrap, end tension by end tension."""
        rows = np.array(list(product(*(getattr(self, name) for name in FACTORS))))
        return Conditions(
            wheel_radius_m=rows[:, 0],
            rope_radius_m=np.full(len(rows), self.rope_radius_m),
            wrap_angle_rad=rows[:, 1],
            end_tension_N=rows[:, 2],
        )

    def ranges(self) -> dict[str, tuple[float, float]]:
        """Return the smallest and largest setting of each factor, and the rope, as the validity of a fit has them."""
        spans = {name: (min(getattr(self, name)), max(getattr(self, name))) for name in FACTORS}
        return spans | {"rope_radius_m": (self.rope_radius_m, self.rope_radius_m)}


def linear_levels(low: float, high: float, n: int, *, step: float) -> tuple[float, ...]:
    """Return about n settings from low to high that are whole multiples of a step, ends included."""
    _check_range(low, high, n)
    return _unique([low, *(round(x / step) * step for x in np.linspace(low, high, n)[1:-1]), high], low, high)


def geometric_levels(low: float, high: float, n: int, *, digits: int = 2) -> tuple[float, ...]:
    """Return about n settings from low to high in even ratios, rounded to digits, ends included."""
    _check_range(low, high, n)
    if not low > 0.0:
        raise InputError(f"a range from {low:g} has no even ratios", key="range", fix="begin above zero")
    inner: FloatArray = np.geomspace(low, high, n)[1:-1]
    return _unique([low, *(float(f"{x:.{digits}g}") for x in inner.tolist()), high], low, high)


def _check_range(low: float, high: float, n: int) -> None:
    if not (low < high and 2 <= n <= _MOST_LEVELS):
        raise InputError(
            f"{n} settings from {low:g} to {high:g}",
            key="range",
            fix=f"give low before high, two to {_MOST_LEVELS} settings",
        )


def _unique(values: Sequence[float], low: float, high: float) -> tuple[float, ...]:
    return tuple(sorted({float(value) for value in values if low <= value <= high}))
