"""The search for the tests to make: what a rig can set, and which of it to choose.

The best plan is found by exchange of conditions against candidates until no exchange helps (Fedorov 1972); the plan to
compare with varies one factor at a time about a centre, as such campaigns are usually made.
"""

import math
from dataclasses import dataclass
from itertools import product
from typing import Literal

import numpy as np

from ropefric.arrays import BoolArray, FloatArray, IntArray
from ropefric.errors import InputError
from ropefric.friction.condition import Conditions

Criterion = Literal["v", "d"]
"""Make the variance of the wanted predictions small, or the volume of the parameters' ellipsoid."""

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
        for name in ("rope_radius_m", "largest_force_N"):
            if not getattr(self, name) > 0.0:
                raise InputError(f"{name} = {getattr(self, name):g} is not positive", key=name)

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
    inner = [round(x / step) * step for x in np.linspace(low, high, n)[1:-1].tolist()]
    return tuple(sorted({low, high, *(x for x in inner if low <= x <= high)}))


def geometric_levels(low: float, high: float, n: int, *, digits: int = 2) -> tuple[float, ...]:
    """Return about n settings from low to high in even ratios, rounded to digits, ends included."""
    _check_range(low, high, n)
    if not low > 0.0:
        raise InputError(f"a range from {low:g} has no even ratios", key="range", fix="begin above zero")
    inner = [float(f"{x:.{digits}g}") for x in np.geomspace(low, high, n)[1:-1].tolist()]
    return tuple(sorted({low, high, *(x for x in inner if low <= x <= high)}))


def _check_range(low: float, high: float, n: int) -> None:
    if not (low < high and 2 <= n <= _MOST_LEVELS):
        raise InputError(
            f"{n} settings from {low:g} to {high:g}",
            key="range",
            fix=f"give low before high, two to {_MOST_LEVELS} settings",
        )


BALANCE = 0.3
"""Weight of the parameters' ellipsoid in a plan for a prediction [-]; it costs that prediction a few per cent."""

# Keeps the inverse finite while a plan of few conditions has one taken out; a whitened plan has eigenvalues near 1.
_RIDGE = 1e-13
_TINY = float(np.finfo(np.float64).tiny)
_WORTHWHILE = 1e-9
_MAX_PASSES = 100
# Half a per cent of a standard error.
_AS_GOOD = 0.01


class Exchange:
    """A criterion on a choice of rows: values of plans, and of all exchanges of one condition."""

    def __init__(
        self,
        rows: FloatArray,
        known: FloatArray,
        targets: FloatArray,
        *,
        criterion: Criterion,
        balance: float = BALANCE,
    ) -> None:
        """Turn to coordinates in which all candidates and what is known are of even size.

        Both criteria keep their order in them.
        """
        length = np.linalg.norm(np.vstack([rows, known]), axis=0)
        triangle = np.linalg.qr(np.vstack([rows, known]) / length, mode="r") / np.sqrt(len(rows))
        turn = np.linalg.inv(triangle) / length[:, None]
        old = known @ turn
        self.rows, self.known, self.targets = rows @ turn, old.T @ old, targets @ turn
        self.criterion, self.balance = criterion, balance

    def information(self, plan: IntArray) -> FloatArray:
        """Return the information matrix of a plan with what is known, shape (q, q)."""
        rows = self.rows[plan]
        return np.asarray(rows.T @ rows + self.known + _RIDGE * np.eye(rows.shape[1]))

    def value(self, plan: IntArray) -> float:
        """Return the criterion of a plan."""
        information = self.information(plan)
        log_det = float(np.linalg.slogdet(information)[1])
        if self.criterion == "d":
            return -log_det
        targets = self.targets
        variance = np.einsum("ti,it->", targets, np.linalg.solve(information, targets.T)) / len(targets)
        return float(np.log(max(variance, _TINY))) - self.balance * log_det / len(information)

    def with_each(self, rest: IntArray) -> FloatArray:
        """Return the criterion of a plan with each candidate added in turn, shape (N,)."""
        information = self.information(rest)
        inverse, rows = np.linalg.inv(information), self.rows
        leverage = np.maximum(np.einsum("ni,ij,nj->n", rows, inverse, rows), 0.0)
        log_det = float(np.linalg.slogdet(information)[1]) + np.log1p(leverage)
        if self.criterion == "d":
            return np.asarray(-log_det)
        targets = self.targets
        gained = ((rows @ inverse @ targets.T) ** 2).sum(axis=1) / (1.0 + leverage)
        left = np.einsum("ti,ij,tj->", targets, inverse, targets) - gained
        variance = np.log(np.maximum(left, _TINY) / len(targets))
        return np.asarray(variance - self.balance * log_det / len(information))

    def improved(self, plan: IntArray) -> IntArray:
        """Return a plan that no exchange of a single condition improves, sorted."""
        current = self.value(plan)
        for _ in range(_MAX_PASSES):
            before = current
            for place in range(plan.size):
                rest = np.delete(plan, place)
                values = self.with_each(rest)
                values[rest] = np.inf  # a condition set up twice is one condition with more repeats
                best = int(np.argmin(values))
                # The values of exchanges carry the rounding of an inverse; only the plan's own value decides.
                changed = np.append(rest, best)
                value = self.value(changed)
                if value < current - _WORTHWHILE:
                    plan, current = changed, value
            if before - current < _WORTHWHILE:
                break
        return np.sort(plan)

    def greedy(self, n: int) -> IntArray:
        """Return n candidates taken one by one, each the best of its turn."""
        plan = np.zeros(0, dtype=np.int64)
        for _ in range(n):
            values = self.with_each(plan)
            values[plan] = np.inf
            plan = np.append(plan, int(np.argmin(values)))
        return plan


def best_plan(exchange: Exchange, n: int, *, starts: int = 10, seed: int = 0) -> tuple[IntArray, int]:
    """Return the best plan of n different candidates from several starts, and how many starts found it.

    The first start takes the best candidate one by one; the others are drawn at random. The same arguments give the
    same plan.
    """
    rng = np.random.default_rng(seed)
    first = [exchange.greedy(n)]
    first += [rng.choice(len(exchange.rows), size=n, replace=False) for _ in range(max(starts - 1, 0))]
    found = [exchange.improved(plan) for plan in first]
    values = np.array([exchange.value(plan) for plan in found])
    best = int(np.argmin(values))
    return found[best], int(np.count_nonzero(values <= values[best] + _AS_GOOD))


def middle_of(allowed: BoolArray) -> tuple[int, ...]:
    """Return the allowed combination nearest to the middle setting of every factor."""
    return nearest_to(allowed, tuple((size - 1) / 2.0 for size in allowed.shape))


def nearest_to(allowed: BoolArray, place: tuple[float, ...]) -> tuple[int, ...]:
    """Return the allowed combination nearest to a place counted in settings, the first of equals."""
    spots = np.argwhere(allowed)
    size = np.maximum(np.array(allowed.shape) - 1.0, 1.0)
    gap = (((spots - np.array(place)) / size) ** 2).sum(axis=1)
    return tuple(int(i) for i in spots[int(np.argmin(np.round(gap, 12)))])


def one_factor_plan(allowed: BoolArray, centre: tuple[int, ...], n: int) -> IntArray:
    """Return the combinations of a one-factor-at-a-time plan: the centre, then each factor varied alone.

    The n − 1 conditions beside the centre are dealt evenly to the factors that can vary, and spread evenly over the
    settings of each, its ends first.
    """
    lines = [np.moveaxis(allowed, axis, 0)[:, *np.delete(centre, axis)] for axis in range(allowed.ndim)]
    others = [
        [int(spot) for spot in np.flatnonzero(line) if spot != centre[axis]]
        for axis, line in enumerate(lines)
    ]
    shares = [0] * len(others)
    for _ in range(n - 1):
        open_factors = [axis for axis, spots in enumerate(others) if shares[axis] < len(spots)]
        if not open_factors:
            break
        shares[min(open_factors, key=lambda axis: shares[axis])] += 1
    found = [centre]
    for axis, (spots, share) in enumerate(zip(others, shares, strict=True)):
        found += [(*centre[:axis], spot, *centre[axis + 1 :]) for spot in _spread(spots, share)]
    return np.sort(np.array([np.ravel_multi_index(spot, allowed.shape) for spot in found], dtype=np.int64))


def _spread(spots: list[int], share: int) -> list[int]:
    """Return some of a list, its last (the strongest setting) first, then its first, then evenly between."""
    if share == 1:
        return spots[-1:]
    return [spots[round(place)] for place in np.linspace(0, len(spots) - 1, share)] if share else []
