"""Ways of measuring: one load ramp a recording, slow stick-slip, load cycles that are held, raising and lowering.

A new one is a `pick` function and a line in `PROTOCOLS`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.registry import Registry
from ropefric.traces.breakaway import Breakaway, Phase, PickSettings, Status
from ropefric.traces.decision import (
    measured,
    pick_breakaway,
    pick_prepared,
    too_short,
    without_force,
)
from ropefric.traces.events import SAME_KIND
from ropefric.traces.segments import Prepared, prepare
from ropefric.traces.slips import FEWEST_TEETH, slips_of, typical_drop_N
from ropefric.traces.trace import ForceTrace
from ropefric.traces.two_way import pick_two_way

CREEP = 0.15
"""A fall smaller than this part of the typical slip is no tooth but the creep of one."""

LOADED = 0.5
UNLOADED = 0.25
"""A load cycle begins above and ends below these parts of the largest force."""
BAND = 0.01
"""A plateau stays within this part of its force, either way, and the noise."""
SHORTEST = 0.1
"""A plateau lasts at least this part of its cycle; less is a rest on the way up."""
STEPS = 1000


@dataclass(frozen=True, slots=True, kw_only=True)
class Protocol:
    """A way of measuring, and how its recordings are read.

    Attributes
    ----------
    name : str
        As in `[protocol] name`.
    description : str
        One line for people.
    pick : callable
        `(trace, settings) -> tuple of Breakaway`, one per trial, at least one.
    measures : {"peak_N", "plateau", "pair"}
        Which side of the rope the result belongs to: a break-away force is the lift force F_A itself, a held
        plateau may be either side, a pair gives both.
    """

    name: str
    description: str
    pick: Callable[[ForceTrace, PickSettings], tuple[Breakaway, ...]]
    measures: str = "peak_N"


def pick_teeth(trace: ForceTrace, settings: PickSettings) -> tuple[Breakaway, ...]:
    """Return every tooth of a recording of slow stick-slip, each a break-away of its own, the first one first.

    A fall is a tooth if it stands out of the noise, is not small against the typical one and the rope is loaded again
    after it, or if it is as large as the user asks for. A recording may begin in the middle of a train.
    """
    prepared = prepare(trace, settings)
    if prepared is None:
        return (too_short(trace, settings),)
    first = pick_prepared(trace, prepared, settings)
    found = slips_of(prepared, settings)
    if first.status is not Status.OK and len(found) < FEWEST_TEETH:
        return (first,)
    typical_N = typical_drop_N([tooth.fall for tooth in found])
    least_N = CREEP * typical_N if settings.min_step_N is None else settings.min_step_N
    begins_s = first.peak_time_s if first.status is Status.OK else -inf
    block_s = 2 * float(np.median(np.diff(prepared.blocks.time_s)))
    teeth = [first] if first.status is Status.OK else []
    for tooth in found:
        fall = tooth.fall
        after_s = float(prepared.blocks.time_s[fall.top]) - begins_s
        # Before what looks like the break-away only a full slip is a tooth: weights that come on swing, too.
        if (after_s > block_s and fall.drop_N >= least_N) or (
            after_s < -block_s and fall.drop_N >= max(least_N, SAME_KIND * typical_N)
        ):
            teeth.append(measured(prepared, settings, tooth, None))
    teeth.sort(key=lambda tooth: tooth.peak_time_s)
    return tuple(teeth)


def pick_plateaus(trace: ForceTrace, settings: PickSettings) -> tuple[Breakaway, ...]:
    """Return the plateau of every load cycle of a recording: the rope is loaded, held and let go.

    With the sensor on the slack side and a known weight on the tight side, the plateau is the end tension F_B at which
    the weight F_A is just held (Euler, rope_wheel eq. 2).
    """
    prepared = prepare(trace, settings)
    if prepared is None:
        return (too_short(trace, settings),)
    # Means over about a thousandth of the recording: a plateau is long, and its search goes step by step.
    size = max(1, prepared.force_N.size // STEPS)
    n = prepared.force_N.size // size
    force_N = prepared.force_N[: n * size].reshape(n, size).mean(axis=1)
    base_N, top_N = float(force_N.min()), float(np.quantile(force_N, 0.98))
    if top_N - base_N <= 10 * prepared.noise_N:
        detail = f"the force changes by {top_N - base_N:.3g} N only: the rope was never loaded"
        return (without_force(Status.NO_BREAKAWAY, detail, prepared),)
    cycles = _cycles(force_N, base_N + LOADED * (top_N - base_N), base_N + UNLOADED * (top_N - base_N))
    band_N = 2 * BAND * (top_N - base_N) + 4 * prepared.noise_N / np.sqrt(size)
    return tuple(
        _plateau(
            prepared, slice(start * size, stop * size), _longest_level(force_N[start:stop], band_N), size
        )
        for start, stop in cycles
    )


def _cycles(force_N: FloatArray, loaded_N: float, unloaded_N: float) -> list[tuple[int, int]]:
    """Stretches that rise above `loaded_N` and last until the force is below `unloaded_N`."""
    cycles: list[tuple[int, int]] = []
    start = -1
    for i, force in enumerate(force_N.tolist()):
        if start < 0 and force > loaded_N:
            start = i
        elif start >= 0 and force < unloaded_N:
            cycles.append((start, i))
            start = -1
    if start >= 0:
        cycles.append((start, force_N.size))
    return cycles


def _longest_level(force_N: FloatArray, band_N: float) -> tuple[int, int]:
    """Return the longest stretch whose largest and smallest force differ by no more than `band_N`."""
    values = force_N.tolist()
    best, start, low, high = (0, 0), 0, inf, -inf
    for stop, value in enumerate(values, start=1):
        low, high = min(low, value), max(high, value)
        while high - low > band_N:
            start += 1
            if values[start - 1] in (low, high):
                low, high = min(values[start:stop]), max(values[start:stop])
        if stop - start > best[1] - best[0]:
            best = (start, stop)
    return best


def _plateau(prepared: Prepared, cycle: slice, level: tuple[int, int], size: int) -> Breakaway:
    first, stop = cycle.start + level[0] * size, cycle.start + level[1] * size
    held = prepared.force_N[first:stop]
    begin_s, end_s = float(prepared.time_s[first]), float(prepared.time_s[max(first, stop - 1)])
    if held.size < max(3, SHORTEST * (cycle.stop - cycle.start)):  # its second half must have a scatter
        detail = f"the load from {prepared.time_s[cycle.start]:.4g} s on was never held: no plateau"
        return without_force(Status.NO_BREAKAWAY, detail, prepared)
    # A rope creeps after it was pulled; in the second half of the plateau it has settled.
    settled = held[held.size // 2 :]
    mean_N = float(settled.mean())
    return Breakaway(
        status=Status.OK,
        detail=f"held from {begin_s:.4g} s until {end_s:.4g} s",
        peak_N=mean_N,
        peak_raw_N=mean_N,
        peak_time_s=0.5 * (begin_s + end_s),
        peak_std_N=float(settled.std(ddof=1)),
        bias_N=0.0,
        window_s=end_s - begin_s,
        noise_std_N=prepared.noise_N,
        phases=(Phase(name="held", start_s=begin_s, end_s=end_s),),
        notes=prepared.notes,
    )


PROTOCOLS: Registry[Protocol] = Registry(
    "protocol",
    [
        Protocol(
            name="breakaway",
            description="one load ramp a recording; F_A is the static peak before sliding",
            pick=pick_breakaway,
        ),
        Protocol(
            name="stick-slip",
            description="slow stick-slip; every tooth of a recording is a trial",
            pick=pick_teeth,
        ),
        Protocol(
            name="held",
            description="load cycles held by hand or weight; every plateau of a recording is a trial",
            pick=pick_plateaus,
            measures="plateau",
        ),
        Protocol(
            name="two-way",
            description="a weight raised and then lowered over the wheel; the pair of steady forces is a trial",
            pick=pick_two_way,
            measures="pair",
        ),
    ],
)
"""Every protocol by name."""
