"""A break-away decided by a person: the static peak at a time that was given, measured like any other."""

from dataclasses import replace

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import DataError
from ropefric.traces.breakaway import Breakaway, PickSettings
from ropefric.traces.decision import too_short
from ropefric.traces.events import Fall, half_climb
from ropefric.traces.peak import peak_result
from ropefric.traces.segments import phases_of, prepare, sliding_after
from ropefric.traces.slips import smallest_drop_N
from ropefric.traces.trace import ForceTrace

REACH_BLOCKS = 5
REACH = 0.01
"""A time read from a figure is good to some 20 ms, or to a hundredth of the recording."""
TURN = 0.3
"""A peak ends, on either side, where the force comes back by more than this part of what it had fallen."""


def pick_at(trace: ForceTrace, settings: PickSettings) -> Breakaway:
    """Return the highest force at `settings.pick_s`, whatever the picker would say of it.

    Raises
    ------
    DataError
        RF244 if that time is not in the recording, or the force passes it without a peak.
    """
    prepared, pick_s = prepare(trace, settings), settings.pick_s
    if prepared is None or pick_s is None:
        return too_short(trace, settings)
    blocks, start_s, end_s = prepared.blocks, float(prepared.time_s[0]), float(prepared.time_s[-1])
    if not start_s <= pick_s <= end_s:
        what = f"{pick_s:g} s is not in the recording, which runs from {start_s:.6g} s to {end_s:.6g} s"
        raise _not_possible(trace, what)
    force_N, here = blocks.force_N, int(np.searchsorted(blocks.time_s, pick_s, side="right")) - 1
    reach = max(REACH_BLOCKS, round(REACH * force_N.size))
    first, last = max(0, here - reach), min(force_N.size - 1, here + reach)
    block = first + int(np.argmax(force_N[first : last + 1]))
    least_N = smallest_drop_N(prepared, replace(settings, min_step_N=None))
    bottom, fallen = block - _lowest(force_N[block::-1], least_N), block + _lowest(force_N[block:], least_N)
    if block in {bottom, fallen}:
        way = "rises" if fallen == block else "falls"
        raise _not_possible(trace, f"the force only {way} at {pick_s:g} s: there is no peak to measure")
    top_N, level_N = float(force_N[block]), float(force_N[fallen])
    fall = Fall(bottom, block, fallen, fallen, top_N, level_N, level_N, has_settled=True, reloads=True)
    sliding = sliding_after(blocks, fall, float(force_N[bottom]))
    found = peak_result(
        prepared,
        settings,
        climb=half_climb(force_N, bottom, block),
        block=block,
        fallen=fallen,
        sliding=sliding,
        phases=phases_of(prepared, block, sliding),
    )
    if trace.saturation is not None and trace.saturation.high:
        begin_s, stop_s = trace.time_s[trace.saturation.high_runs - [0, 1]].T
        near_s = reach * float(blocks.time_s[1] - blocks.time_s[0])
        if ((begin_s <= found.peak_time_s + near_s) & (stop_s >= found.peak_time_s - near_s)).any():
            note = "the converter sat at its limit beside the peak: the force may have been higher"
            found = replace(found, notes=(*found.notes, note))
    return found


def _lowest(force_N: FloatArray, least_N: float) -> int:
    """Return where the force is lowest on its way from a peak, its first value, until it turns; 0 if nowhere."""
    lowest = 0
    for index, value_N in enumerate(force_N.tolist()):
        fallen_N = force_N[0] - force_N[lowest]
        if value_N - force_N[lowest] > max(least_N, TURN * fallen_N):
            break
        lowest = index if value_N < force_N[lowest] else lowest
    return lowest if force_N[0] - force_N[lowest] > least_N else 0


def _not_possible(trace: ForceTrace, why: str) -> DataError:
    fix = "correct pick_s, or give the force itself as peak_N, or exclude the trial"
    return DataError(why, code="RF244", path=trace.source, key="pick_s", fix=fix)
