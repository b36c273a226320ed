"""How the force climbed to a block."""

from dataclasses import dataclass

import numpy as np

from ropefric.traces.arrays import FloatArray

__all__ = ["Climb", "climb_to", "flattened"]

STILL_CLIMBING = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class Climb:
    """The way up to a block.

    Attributes
    ----------
    base_N : float
        Lowest force before it [N]: the idle level.
    start : int
        First block of the last climb through half the height.
    top : int
        The block itself.
    """

    base_N: float
    start: int
    top: int


def climb_to(force_N: FloatArray, block: int) -> Climb:
    """Return how the force climbed to a block.

    Parameters
    ----------
    force_N : ndarray, shape (m,)
        Block means [N].
    block : int
        The block reached.

    Examples
    --------
    >>> climb_to(np.array([0.0, 1.0, 0.0, 4.0, 8.0, 9.0]), 5)
    Climb(base_N=0.0, start=4, top=5)
    """
    before = force_N[: block + 1]
    base_N = float(before.min())
    below = np.flatnonzero(before < 0.5 * (base_N + float(force_N[block])))
    start = min(int(below[-1]) + 1, block) if below.size else 0
    return Climb(base_N=base_N, start=start, top=block)


def flattened(force_N: FloatArray, climb: Climb) -> bool:
    """Return whether the force had stopped climbing well before the block was reached.

    True if the slope over the last quarter of the climb is below a tenth of its average.

    Examples
    --------
    >>> F = np.array([0, 2, 4, 6, 8, 10] + [10] * 20, dtype=float)
    >>> flattened(F, climb_to(F, 25)), flattened(F, climb_to(F, 5))
    (True, False)
    """
    late = climb.start + 3 * (climb.top - climb.start) // 4
    if climb.top - late < 3:
        return False
    average = 0.5 * (float(force_N[climb.top]) - climb.base_N) / (climb.top - climb.start)
    return float(force_N[climb.top] - force_N[late]) / (climb.top - late) < STILL_CLIMBING * average
