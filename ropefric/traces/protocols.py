"""Ways of measuring: one load ramp a recording, slow stick-slip, load cycles that are held, raising and lowering.

A new one is a `pick` function and a line in `PROTOCOLS`; `pick_at` measures the peak that a person names.

Raised and lowered over one wheel: while a weight W is raised the sensor pulls T_raise = W e^(μφ); while it is lowered
it holds back T_lower = W e^(-μφ): the capstan equation, with friction against the motion both times. Their ratio
e^(2μφ) holds neither W nor the scale of the sensor, so μ = ln(T_raise/T_lower)/(2φ); their geometric mean is W. The
trial of the pair has F_A = T_raise and F_B = √(T_raise T_lower), for then ln(F_A/F_B) = μφ, and every law
fits it. With relative uncertainties r and l of the two forces, u(ln(F_A/F_B)) = ½ √(r² + l²): F_A carries all of it.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import DataError
from ropefric.registry import Registry
from ropefric.traces.breakaway import SURE, Breakaway, Phase, PickSettings, Status
from ropefric.traces.decision import (
    fallen_from,
    least_fall_N,
    measured,
    pick_breakaway,
    pick_prepared,
    rests_of,
    teeth_of,
    usable,
    without_force,
)
from ropefric.traces.picker import look
from ropefric.traces.segments import Prepared
from ropefric.traces.trace import ForceTrace
from ropefric.traces.zero import with_its_zero

FEWEST_TEETH = 3
"""Number of slips that are a train, wherever the recording begins."""

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

    A fall is a stick-slip event if it exceeds the noise and is not small against the typical one, or if it is as large
    as the user requires. A recording may begin in the middle of a train.
    """
    prepared = usable(trace, settings)
    if isinstance(prepared, Breakaway):
        return (prepared,)
    first = pick_prepared(trace, prepared, settings)
    blocks, least_N = prepared.blocks, least_fall_N(prepared, settings)
    tops = teeth_of(blocks.force_N, settings.min_step_N or least_N)
    is_ok = first.status is Status.OK
    is_none = first.status is Status.NO_BREAKAWAY and first.probability >= SURE
    if not is_ok and (tops.size < FEWEST_TEETH or is_none):
        return (first,)
    begins_s = first.peak_time_s if is_ok else -inf
    block_s = 2.0 * float(np.median(np.diff(blocks.time_s)))
    teeth = []
    for before, top in zip([0, *tops.tolist()], tops.tolist(), strict=False):
        if blocks.time_s[top] > begins_s + block_s:
            start = before + int(np.argmin(blocks.force_N[before : top + 1]))
            teeth.append(measured(prepared, settings, top, None, start))
    return (first, *teeth) if is_ok else tuple(teeth)


def pick_plateaus(trace: ForceTrace, settings: PickSettings) -> tuple[Breakaway, ...]:
    """Return the plateau of every load cycle of a recording: the rope is loaded, held and let go.

    With the sensor on the slack side and a known weight on the tight side, the plateau is the end tension F_B at which
    the weight F_A is just held (Euler, rope_wheel eq. 2).
    """
    prepared = usable(trace, settings)
    if isinstance(prepared, Breakaway):
        return (prepared,)
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


BANDS = (0.01, 0.02, 0.05, 0.1, 0.2)
"""A steady force stays within this part of the largest one; stick-slip needs a wide band, a small wrap a narrow one."""
LEAST = 0.1
"""A steady stretch lasts at least this part of the loaded part of a recording."""
WEIGHT = 0.01
"""Less than this part of the largest force is no weight that is lowered, but a cell whose zero is not quite one."""
BETTER = 1.05
"""A wider band counts where it finds a pair whose ratio is larger by this factor: the narrow one saw drift only."""
TRIM = 0.15
"""Part of a steady stretch, at either end, that may still belong to the change of direction."""
PIECES = 8
PARTS = 400
"""Number of parts of a recording whose means show whether it is steady."""
NOISE_SIGMAS = 6.0


def pick_two_way(trace: ForceTrace, settings: PickSettings) -> tuple[Breakaway, ...]:
    """Return the highest steady force and the lowest steady one after it, as one trial."""
    prepared = usable(trace, settings)
    if isinstance(prepared, Breakaway):
        return (prepared,)
    edges = np.linspace(0, prepared.force_N.size, min(PARTS, prepared.force_N.size) + 1).astype(np.intp)
    force_N = np.add.reduceat(prepared.force_N, edges[:-1]) / np.diff(edges)
    top_N, noise_N = float(force_N.max()), prepared.noise_N / math.sqrt(float(np.diff(edges).min()))
    best, pair = 1.0, None
    for band in BANDS:
        band_N = max(band * top_N, NOISE_SIGMAS * noise_N)
        levels = _levels(force_N, band_N, WEIGHT * top_N)
        means = [float(_inner(force_N, level).mean()) for level in levels]
        high = int(np.argmax(means)) if means else 0
        if high + 1 < len(levels):
            low = high + 1 + int(np.argmin(means[high + 1 :]))  # a rope that stops in between holds more
            ratio, fall_N = means[high] / means[low], means[high] - means[low]
            if fall_N > 0.5 * band_N and ratio > best * (BETTER if pair else 1.0):
                best, pair = ratio, (levels[high], levels[low])
    if pair is None:
        detail = "no steady force of raising with a lower steady force of lowering after it was found"
        return (without_force(Status.NO_BREAKAWAY, detail, prepared),)
    raising, lowering = ((int(edges[first]), int(edges[stop])) for first, stop in pair)
    fewest = min(_inner(prepared.force_N, samples).size for samples in (raising, lowering))
    if fewest < 2 * PIECES:
        detail = f"the steady forces of raising and lowering last {fewest} samples: too few to determine their scatter"
        return (without_force(Status.TOO_SHORT, detail, prepared),)
    return (_result(prepared, raising, lowering),)


def _levels(force_N: FloatArray, band_N: float, loaded_N: float) -> list[tuple[int, int]]:
    """Return the steady loaded stretches from left to right, as first part and stop."""
    values, least = force_N.tolist(), max(3, round(LEAST * np.count_nonzero(force_N > loaded_N)))
    found, start = [], 0
    for stop in range(1, len(values) + 1):
        part = values[start:stop]
        if stop < len(values) and max(*part, values[stop]) - min(*part, values[stop]) <= band_N:
            continue
        if stop - start >= least and min(part) > loaded_N:
            found.append((start, stop))
            start = stop
        while start < stop and max(values[start : stop + 1]) - min(values[start : stop + 1]) > band_N:
            start += 1
    return found


def _inner(values: FloatArray, stretch: tuple[int, int]) -> FloatArray:
    cut = int(TRIM * (stretch[1] - stretch[0]))
    return values[stretch[0] + cut : stretch[1] - cut]


def _result(prepared: Prepared, *pair: tuple[int, int]) -> Breakaway:
    forces_N, shares, phases = [], [], []
    for name, samples in zip(("raising", "lowering"), pair, strict=True):
        inner_N = _inner(prepared.force_N, samples)
        means_N = np.array([piece.mean() for piece in np.array_split(inner_N, PIECES)])
        forces_N.append(inner_N)
        shares.append(float(means_N.std(ddof=1)) / math.sqrt(PIECES) / float(inner_N.mean()))
        times_s = prepared.time_s[[samples[0], samples[1] - 1]].tolist()
        phases.append(Phase(name=name, start_s=times_s[0], end_s=times_s[1]))
    raise_N, lower_N = (float(inner_N.mean()) for inner_N in forces_N)
    raising = phases[0]
    return Breakaway(
        status=Status.OK,
        detail=f"raised at {raise_N:.6g} N, lowered at {lower_N:.6g} N",
        peak_N=raise_N,
        peak_raw_N=raise_N,
        peak_time_s=0.5 * (raising.start_s + raising.end_s),
        peak_std_N=0.5 * raise_N * math.hypot(*shares),
        bias_N=0.0,
        kinetic_N=raise_N,
        kinetic_std_N=float(forces_N[0].std(ddof=1)),
        kinetic_s=(1.0 - 2.0 * TRIM) * (raising.end_s - raising.start_s),
        drop_N=raise_N - lower_N,
        trough_N=lower_N,
        end_tension_N=math.sqrt(raise_N * lower_N),
        end_tension_std_N=0.0,
        noise_std_N=prepared.noise_N,
        phases=tuple(phases),
        notes=prepared.notes,
    )


REACH_BLOCKS = 5
REACH = 0.01
"""A time read from a figure is good to some 20 ms, or to a hundredth of the recording."""


def pick_at(trace: ForceTrace, settings: PickSettings) -> Breakaway:
    """Return the highest force at `settings.pick_s`, whatever the picker would say of it.

    Raises
    ------
    DataError
        RF244 if that time is not in the recording, or the force passes it without a peak.
    """
    if (pick_s := settings.pick_s) is None:
        return pick_breakaway(trace, settings)[0]
    prepared = usable(trace, settings)
    if isinstance(prepared, Breakaway):
        return prepared
    blocks, start_s, end_s = prepared.blocks, float(prepared.time_s[0]), float(prepared.time_s[-1])
    if not start_s <= pick_s <= end_s:
        what = f"{pick_s:g} s is not in the recording, which runs from {start_s:.6g} s to {end_s:.6g} s"
        raise _not_possible(trace, what)
    force_N, here = blocks.force_N, int(np.searchsorted(blocks.time_s, pick_s, side="right")) - 1
    reach = max(REACH_BLOCKS, round(REACH * force_N.size))
    first, last = max(0, here - reach), min(force_N.size - 1, here + reach)
    block = first + int(np.argmax(force_N[first : last + 1]))
    least_N = least_fall_N(prepared, replace(settings, min_step_N=None))
    rises = fallen_from(force_N, block, least_N) == block
    if rises or fallen_from(force_N[block::-1], 0, least_N) == 0:
        way = "rises" if rises else "falls"
        raise _not_possible(trace, f"the force only {way} at {pick_s:g} s: there is no peak to measure")
    whole = look(prepared.time_s, prepared.force_N)
    found = measured(prepared, settings, block, rests_of(prepared, whole))
    if settings.ending == "sliding":
        found = _with_its_zero_as_read(trace, prepared, found, settings)
    if trace.saturation is not None and trace.saturation.n_high:
        begin_s, stop_s = trace.time_s[trace.saturation.high_runs - [0, 1]].T
        near_s = reach * float(blocks.time_s[1] - blocks.time_s[0])
        if ((begin_s <= found.peak_time_s + near_s) & (stop_s >= found.peak_time_s - near_s)).any():
            note = "the converter sat at its limit beside the peak: the force may have been higher"
            found = replace(found, notes=(*found.notes, note))
    return found


def _with_its_zero_as_read(
    trace: ForceTrace, prepared: Prepared, found: Breakaway, settings: PickSettings
) -> Breakaway:
    """Return a peak that a person named with what its zero adds to its uncertainty, as the picker's own has it.

    Where the zero allows two forces, the one that was read is used, and the distance to the other is its uncertainty.
    """
    zeroed = with_its_zero(trace, prepared, found, settings)
    if zeroed.status is Status.OK:
        return zeroed
    apart_N = max((abs(one.force_N - found.peak_N) for one in zeroed.candidates), default=0.0)
    std_N = math.hypot(found.peak_std_N, apart_N / math.sqrt(3.0))
    return replace(found, peak_std_N=std_N, notes=(*found.notes, f"taken as read: {zeroed.detail}"))


def _not_possible(trace: ForceTrace, why: str) -> DataError:
    fix = "correct pick_s, or give the force itself as peak_N, or exclude the trial"
    return DataError(why, code="RF244", path=trace.source, key="pick_s", fix=fix)


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
