"""How the force climbed to a block."""

from dataclasses import dataclass

import numpy as np

from ropefric.arrays import FloatArray

STILL_CLIMBING = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class Climb:
    """The way up to a block."""

    base_N: float
    start: int
    top: int


def climb_to(force_N: FloatArray, block: int) -> Climb:
    """Return how the force climbed to a block."""
    before = force_N[: block + 1]
    base_N = float(before.min())
    below = np.flatnonzero(before < 0.5 * (base_N + float(force_N[block])))
    start = min(int(below[-1]) + 1, block) if below.size else 0
    return Climb(base_N=base_N, start=start, top=block)


def flattened(force_N: FloatArray, climb: Climb) -> bool:
    """Return whether the force had stopped climbing well before the block was reached.

    True if the slope over the last quarter of the climb is below a tenth of its average.
    """
    late = climb.start + 3 * (climb.top - climb.start) // 4
    if climb.top - late < 3:
        return False
    average = 0.5 * (float(force_N[climb.top]) - climb.base_N) / (climb.top - climb.start)
    return float(force_N[climb.top] - force_N[late]) / (climb.top - late) < STILL_CLIMBING * average
