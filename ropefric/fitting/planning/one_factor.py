"""The plan to compare with: one factor at a time about a centre, as such campaigns are usually made."""

import numpy as np

from ropefric.arrays import BoolArray, IntArray


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
    others = [_others(allowed, centre, axis) for axis in range(allowed.ndim)]
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


def _others(allowed: BoolArray, centre: tuple[int, ...], axis: int) -> list[int]:
    fixed: tuple[int | slice, ...] = (*centre[:axis], slice(None), *centre[axis + 1 :])
    line: BoolArray = allowed[fixed]
    return [int(spot) for spot in np.flatnonzero(line) if spot != centre[axis]]


def _spread(spots: list[int], share: int) -> list[int]:
    """Return some of a list, its last (the strongest setting) first, then its first, then evenly between."""
    if share == 1:
        return spots[-1:]
    return [spots[round(place)] for place in np.linspace(0, len(spots) - 1, share)] if share else []
