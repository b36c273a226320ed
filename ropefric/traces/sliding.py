"""The stretch in which the rope slides, and how rough it is, told from block means."""

from dataclasses import dataclass

import numpy as np

from ropefric.arrays import FloatArray, median
from ropefric.traces.blocks import Glance
from ropefric.traces.loading import climb_to

SHORTEST_BLOCKS = 4
FEW_PIECES = 4
PIECE_BLOCKS = 25
"""A tenth of a second at three kilohertz: drift is slow against it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sliding:
    """The stretch after a break in which the rope slides."""

    first: int
    stop: int
    level_N: float
    onset_N: float
    spread_N: float


def sliding_after(view: Glance, block: int) -> Sliding | None:
    """Return the stretch of sliding after a break; None if the force falls away without one.

    It ends where the force leaves its level for good: motor off, direction reversed, rope gone.
    """
    force_N = view.force_N
    climb = climb_to(force_N, block)
    base_N = climb.base_N
    first = block + 1
    while first + 1 < force_N.size and force_N[first + 1] < force_N[first]:
        first += 1
    if force_N.size - first < SHORTEST_BLOCKS:
        return None
    n_first = int(np.clip((block - climb.start) // 4, PIECE_BLOCKS, 4 * PIECE_BLOCKS))
    level_N = median(force_N[first : first + n_first])
    low = force_N[first:] < base_N + 0.4 * (level_N - base_N)
    gone = np.flatnonzero(low[:-1] & low[1:]) if level_N > base_N else np.zeros(1, dtype=np.int64)
    stop = first + (int(gone[0]) if gone.size else force_N.size - first)
    if stop - first < SHORTEST_BLOCKS:
        return None
    stretch = force_N[first:stop]
    level_N, spread_N = _level_and_spread(stretch[:n_first])
    # Sliding passes its level again and again; a released rope never does.
    stays = np.flatnonzero(stretch >= level_N - max(spread_N, 0.03 * abs(level_N - base_N)))
    stop = first + int(stays[-1]) + 1
    if stop - first < SHORTEST_BLOCKS:
        return None
    stretch = force_N[first:stop]
    level_N, spread_N = _level_and_spread(stretch)
    return Sliding(
        first=first,
        stop=stop,
        level_N=level_N,
        onset_N=median(stretch[:n_first]),
        spread_N=spread_N,
    )


def roughness_N(stretch: FloatArray) -> float:
    """Return the standard deviation around a straight line within pieces of 25 blocks [N].

    The median of the pieces counts, of four or fewer the quietest.
    """
    length = min(PIECE_BLOCKS, stretch.size)
    n_pieces = stretch.size // length
    pieces = stretch[: n_pieces * length].reshape(n_pieces, length)
    x = np.arange(length) - (length - 1) / 2
    flat = pieces - pieces.mean(axis=1, keepdims=True)
    if length > 1:
        flat -= np.outer(flat @ x / float(x @ x), x)
    stds = np.sort(np.sqrt(np.mean(flat**2, axis=1)))
    # Half of a short stretch may be the release at its end.
    return float(stds[(n_pieces - 1) // 2 if n_pieces > FEW_PIECES else 0])


def _level_and_spread(stretch: FloatArray) -> tuple[float, float]:
    """Median, and robust standard deviation around the line through the medians of both halves."""
    half = stretch.size // 2
    x = np.arange(stretch.size) - (stretch.size - 1) / 2
    slope = 0.0
    if half >= SHORTEST_BLOCKS:
        slope = (median(stretch[-half:]) - median(stretch[:half])) / (stretch.size - half)
    flat = stretch - slope * x
    middle_N = median(flat)
    return median(stretch), 1.4826 * median(np.abs(flat - middle_N))
