"""The break that ends the loading: where the rope breaks away."""

from math import inf

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.traces.blocks import Glance
from ropefric.traces.sliding import sliding_after
from ropefric.traces.slips import breaks, is_slip

GROWTH = 1.15
SLIP_GROWTH = 1.3
"""A slip, or any other break, after which the force still grows by more than this was a jolt of the loading."""
TALL = 0.3


def first_static_break(view: Glance, drop_N: float) -> int | None:
    """Return the block of the first break that ends the loading; None if the force never breaks.

    That is the first slip after which the force does not go on climbing by more than 30 %: later teeth may be higher
    and the sliding force may drift above it. Where nothing drops as suddenly as a slip, it is the first break that
    stays within 15 % of the largest force and is not followed by a higher level; an earlier jolt, as when the
    weights bounce, is followed by a climb well above it. A recording that goes back and forth is judged by its first
    cycle. Wiggles below 30 % of the largest force do not count.
    """
    force_N = view.force_N
    idle_N = float(force_N[: int(np.argmax(force_N)) + 1].min())
    tall_N = idle_N + TALL * (float(force_N.max()) - idle_N)
    first, cycle_end = None, force_N.size
    for record, drop in breaks(force_N, drop_N):
        if force_N[record] < tall_N:
            continue
        if record >= cycle_end:
            break
        base_N = float(force_N[: record + 1].min())
        stop = _end_of_load(force_N, record, base_N)
        climbed_N = max(float(force_N[record]) - base_N, drop_N)
        # Numbers so coarse that they show neither noise nor a climb: whatever comes later has outgrown it.
        growth = (float(force_N[record:stop].max()) - base_N) / climbed_N if climbed_N > 0.0 else inf
        # Noise may put the record well before the slip; the peak is where the slip begins.
        begin = max(record, drop - 2)
        edge = begin + int(np.argmax(force_N[begin : drop + 1]))
        if growth <= SLIP_GROWTH and is_slip(view, edge):
            return edge
        if first is None and growth <= GROWTH:
            sliding = sliding_after(view, record)
            if sliding is None or sliding.level_N <= force_N[record]:
                first, cycle_end = record, stop
    return first


def _end_of_load(force_N: FloatArray, block: int, base_N: float) -> int:
    """Return the block at which the force has fallen back for good: unloaded, or the direction reversed."""
    low = force_N[block:] < base_N + 0.25 * (float(force_N[block]) - base_N)
    gone = np.flatnonzero(low[:-1] & low[1:])
    return block + int(gone[0]) if gone.size else force_N.size
