"""The stretch in which the rope slides, and how rough it is, told from block means."""

from dataclasses import dataclass

import numpy as np

from ropefric.traces.blocks import Glance
from ropefric.traces.loading import climb_to
from ropefric.traces.slips import slips
from ropefric.traces.trace import FloatArray

__all__ = ["PIECE_BLOCKS", "Sliding", "roughness_N", "sliding_after"]

SHORTEST_BLOCKS = 4
MAX_FALLS = 20
FEW_PIECES = 4
PIECE_BLOCKS = 25
"""A tenth of a second at three kilohertz: drift is slow against it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sliding:
    """The stretch after a break in which the rope slides.

    Attributes
    ----------
    first, stop : int
        Its blocks.
    level_N : float
        Median force [N].
    onset_N : float
        Median force of its first part [N], before it drifts.
    spread_N : float
        Robust standard deviation around a straight line [N].
    roughness_N : float
        The same within a tenth of a second [N]: slow drift and a release at the end do not count.
    falls_N : tuple of float
        Heights of the sudden falls in it [N], largest first.
    """

    first: int
    stop: int
    level_N: float
    onset_N: float
    spread_N: float
    roughness_N: float
    falls_N: tuple[float, ...]


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
    level_N = float(np.median(force_N[first : first + n_first]))
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
        onset_N=float(np.median(stretch[:n_first])),
        spread_N=spread_N,
        roughness_N=roughness_N(stretch),
        falls_N=tuple(height_N for _, height_N in slips(stretch, view.noise_N, most=MAX_FALLS)),
    )


def roughness_N(stretch: FloatArray) -> float:
    """Return the standard deviation around a straight line within pieces of 25 blocks [N].

    The median of the pieces counts, of four or fewer the quietest.

    Examples
    --------
    >>> roughness_N(np.linspace(0.0, 9.0, 100)) < 1e-12
    True
    """
    pieces = np.array_split(stretch, max(1, stretch.size // PIECE_BLOCKS))
    stds = []
    for piece in pieces:
        x = np.arange(piece.size) - (piece.size - 1) / 2
        slope = float(x @ (piece - piece.mean())) / float(x @ x) if piece.size > 1 else 0.0
        stds.append(float(np.sqrt(np.mean((piece - piece.mean() - slope * x) ** 2))))
    # Half of a short stretch may be the release at its end.
    return sorted(stds)[(len(stds) - 1) // 2 if len(stds) > FEW_PIECES else 0]


def _level_and_spread(stretch: FloatArray) -> tuple[float, float]:
    """Median, and robust standard deviation around the line through the medians of both halves."""
    half = stretch.size // 2
    x = np.arange(stretch.size) - (stretch.size - 1) / 2
    slope = 0.0
    if half >= SHORTEST_BLOCKS:
        slope = float(np.median(stretch[-half:]) - np.median(stretch[:half])) / (stretch.size - half)
    flat = stretch - slope * x
    middle_N = float(np.median(flat))
    return float(np.median(stretch)), 1.4826 * float(np.median(np.abs(flat - middle_N)))
