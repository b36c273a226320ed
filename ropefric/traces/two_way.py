"""Raised and lowered over one wheel: the two steady forces of a dead weight, and the coefficient their ratio gives.

While a weight W is raised the sensor pulls T_raise = W e^(μφ); while it is lowered it holds back T_lower = W e^(-μφ):
the capstan equation, with friction against the motion both times. Their ratio e^(2μφ) holds neither W nor the scale
of the sensor, so μ = ln(T_raise/T_lower)/(2φ); their geometric mean is W. The trial that stands for the pair has
F_A = T_raise and F_B = √(T_raise T_lower), for then ln(F_A/F_B) = ½ ln(T_raise/T_lower) = μφ, and every law fits it.
With relative uncertainties r and l of the two forces, u(ln(F_A/F_B)) = ½ √(r² + l²): F_A carries all of it.
"""

import math

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.traces.breakaway import Breakaway, Phase, PickSettings, Status
from ropefric.traces.decision import too_short, without_force
from ropefric.traces.segments import Prepared, prepare
from ropefric.traces.trace import ForceTrace

BANDS = (0.01, 0.02, 0.05, 0.1, 0.2)
"""A steady force stays within this part of the largest one; stick-slip needs a wide band, a small wrap a narrow one."""
LEAST = 0.1
"""A steady stretch lasts at least this part of the loaded part of a recording."""
LOADED = 0.01
"""Less than this part of the largest force is no weight that is lowered, but a cell whose zero is not quite one."""
BETTER = 1.05
"""A wider band counts where it finds a pair whose ratio is larger by this factor: the narrow one saw drift only."""
TRIM = 0.15
"""Part of a steady stretch, at either end, that may still belong to the change of direction."""
PIECES = 8
PARTS = 400
"""Means over so many parts of a recording tell what is steady."""
NOISE_SIGMAS = 6.0


def pick_two_way(trace: ForceTrace, settings: PickSettings) -> tuple[Breakaway, ...]:
    """Return the highest steady force and the steady one after it, as one trial."""
    prepared = prepare(trace, settings)
    if prepared is None:
        return (too_short(trace, settings),)
    edges = np.linspace(0, prepared.force_N.size, min(PARTS, prepared.force_N.size) + 1).astype(np.intp)
    force_N = np.add.reduceat(prepared.force_N, edges[:-1]) / np.diff(edges)
    top_N, noise_N = float(force_N.max()), prepared.noise_N / math.sqrt(float(np.diff(edges).min()))
    best, pair = 1.0, None
    for band in BANDS:
        band_N = max(band * top_N, NOISE_SIGMAS * noise_N)
        levels = _levels(force_N, band_N, LOADED * top_N)
        means = [float(_inner(force_N, level).mean()) for level in levels]
        high = int(np.argmax(means)) if means else 0
        if high + 1 < len(levels):
            ratio, fall_N = means[high] / means[high + 1], means[high] - means[high + 1]
            if fall_N > 0.5 * band_N and ratio > best * (BETTER if pair else 1.0):
                best, pair = ratio, (levels[high], levels[high + 1])
    if pair is None:
        detail = "no steady force of raising with a lower steady force of lowering after it was found"
        return (without_force(Status.NO_BREAKAWAY, detail, prepared),)
    raising, lowering = ((int(edges[first]), int(edges[stop])) for first, stop in pair)
    fewest = min(_inner(prepared.force_N, samples).size for samples in (raising, lowering))
    if fewest < 2 * PIECES:
        detail = (
            f"the steady forces of raising and lowering last {fewest} samples: too few to tell their scatter"
        )
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
