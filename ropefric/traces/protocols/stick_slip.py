"""One recording, many trials: every tooth of slow stick-slip is a break-away of its own."""

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.traces.breakaway import Breakaway, Phase, Status
from ropefric.traces.outcome import peak_between, peak_result
from ropefric.traces.prepare import prepare, too_short
from ropefric.traces.protocols.breakaway import pick_prepared, smallest_drop_N
from ropefric.traces.protocols.protocol import Protocol
from ropefric.traces.settings import PickSettings
from ropefric.traces.sliding import sliding_after
from ropefric.traces.slips import FAST_BLOCKS, fast_drop_N, slips
from ropefric.traces.static_break import first_static_break
from ropefric.traces.trace import ForceTrace

SAME_KIND = 0.3
"""A fall smaller than this part of the first slip is no tooth but the creep of one."""


def pick_teeth(trace: ForceTrace, settings: PickSettings) -> tuple[Breakaway, ...]:
    """Return every tooth of a recording, the first break-away first."""
    prepared = prepare(trace, settings)
    if prepared is None:
        return (too_short(trace, settings),)
    first = pick_prepared(trace, prepared, settings)
    if first.status is not Status.OK:
        return (first,)
    view = prepared.view
    block = first_static_break(view, smallest_drop_N(prepared, settings))
    sliding = None if block is None else sliding_after(view, block)
    if block is None or sliding is None:
        return (first,)
    smallest_N = max(SAME_KIND * fast_drop_N(view.force_N, block), settings.min_step_N or 0.0)
    stretch = view.force_N[sliding.first : sliding.stop + FAST_BLOCKS]
    found = sorted(
        sliding.first + tooth
        for tooth, fall_N in slips(stretch, view.noise_N, most=stretch.size)
        if fall_N >= smallest_N
    )
    teeth = [first]
    bottom = sliding.first
    for tooth in found:
        edge = _edge(view.force_N, bottom, tooth)
        fallen = edge + 1 + int(np.argmin(view.force_N[edge + 1 : edge + FAST_BLOCKS + 1]))
        if edge > bottom:
            peak = peak_between(prepared, settings, climb=bottom, block=edge, fallen=fallen)
            loading = Phase(
                name="loading", start_s=float(view.time_s[bottom]), end_s=float(view.time_s[edge])
            )
            teeth.append(peak_result(prepared, peak, settings, sliding=sliding, phases=(loading,)))
        bottom = fallen
    return tuple(teeth)


def _edge(force_N: FloatArray, bottom: int, tooth: int) -> int:
    """Return the highest block just before a fall that was located to a few blocks."""
    first = max(bottom, tooth - 2)
    return first + int(np.argmax(force_N[first : tooth + 3]))


PROTOCOL = Protocol(
    name="stick-slip",
    description="slow stick-slip; every tooth of a recording is a trial",
    pick=pick_teeth,
)
