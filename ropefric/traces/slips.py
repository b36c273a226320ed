"""Drops of the force: records that break, and the sudden ones by which a rope slips.

Everything here looks at block means (`ropefric.traces.blocks`). A *record* is a force never reached before; a *break*
is a record followed by a drop of more than the noise.
"""

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.traces.blocks import Glance

DROP_SIGMAS = 6.0
"""A drop of fewer noise standard deviations is noise."""
SLIP_SIGMAS = 8.0
"""The same for a fall that is to be timed as well."""
SUDDEN = 0.65
"""Part of a slip that happens within two blocks; a release with a time constant of 20 ms does half of it."""
FAST_BLOCKS = 6


def breaks(force_N: FloatArray, drop_N: float) -> list[tuple[int, int]]:
    """Return each record that is followed by a drop of more than `drop_N` before the next one, with that drop."""
    highest = np.maximum.accumulate(force_N)
    dropped = highest - force_N > drop_N
    drops = np.flatnonzero(dropped & ~np.concatenate(([False], dropped[:-1])))
    records = np.maximum.accumulate(np.where(force_N >= highest, np.arange(force_N.size), 0))[drops]
    _, first = np.unique(records, return_index=True)
    return [(int(records[i]), int(drops[i])) for i in first]


def fast_drop_N(force_N: FloatArray, block: int) -> float:
    """Return how far the force falls within a few blocks after `block` [N]."""
    return float(force_N[block] - force_N[block : block + FAST_BLOCKS + 1].min())


def is_slip(view: Glance, block: int) -> bool:
    """Return whether the force drops after `block` as when a rope slips: far beyond the noise, within two blocks.

    A bounce of the weights or a motor that is switched off takes longer.
    """
    ahead = view.force_N[block : block + 3 * FAST_BLOCKS]
    if ahead.size < 3:
        return False
    fall = ahead[:-2] - np.minimum(ahead[1:-1], ahead[2:])
    steepest = int(np.argmax(fall[:FAST_BLOCKS]))
    fall_N = float(fall[steepest])
    whole_N = float(ahead[: steepest + 1].max() - ahead[steepest : steepest + 2 * FAST_BLOCKS].min())
    return fall_N > SLIP_SIGMAS * view.noise_N and fall_N > SUDDEN * whole_N


def slips(stretch: FloatArray, noise_N: float, *, most: int) -> list[tuple[int, float]]:
    """Return the sudden falls of a sliding force, largest first: block before the fall, and its height [N]."""
    if stretch.size <= FAST_BLOCKS:
        return []
    lowest = np.lib.stride_tricks.sliding_window_view(stretch, FAST_BLOCKS + 1).min(axis=1)
    fall = stretch[: lowest.size] - lowest
    steepest = stretch[: lowest.size] - np.minimum(stretch[1 : lowest.size + 1], stretch[2 : lowest.size + 2])
    highest = np.maximum.reduce([np.roll(stretch, shift) for shift in range(FAST_BLOCKS + 1)])
    highest[:FAST_BLOCKS] = np.maximum.accumulate(stretch[:FAST_BLOCKS])
    whole = highest[: lowest.size] - lowest
    fall[(fall < DROP_SIGMAS * noise_N) | (steepest < 0.5 * whole)] = 0.0
    found: list[tuple[int, float]] = []
    order = np.argsort(-fall, kind="stable")
    # Neighbouring blocks see the same fall; take the largest of each run.
    for block in order[: np.count_nonzero(fall)]:
        if len(found) >= most:
            break
        if fall[block] > 0:
            found.append((int(block), float(fall[block])))
            fall[max(0, block - FAST_BLOCKS) : block + FAST_BLOCKS + 1] = 0.0
    return found
