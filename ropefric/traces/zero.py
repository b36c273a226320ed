"""The zero of a recording stays, drifts or jumps; and a level at rest is an error of it or a pretension.

Lines through the rope at rest, before the climb and after the load was let down, are compared by BIC: with a slope or
without, each rest at a level of its own (weights were hung) or at that of another. Noise is coloured, so that only as
many blocks count as are independent. A jump is one step between two samples with the same line on either side, more
likely than any ramp.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from typing import NamedTuple

import numpy as np

from ropefric.arrays import BoolArray, FloatArray, median
from ropefric.traces.breakaway import Breakaway, ForceEvent, PickSettings, Status
from ropefric.traces.clock import GAP_STEPS
from ropefric.traces.noise import runs_of
from ropefric.traces.segments import AT_REST, Blocks, Prepared
from ropefric.traces.trace import ForceTrace

MATTERS, LARGE, LARGEST_JUMP = 0.02, 0.12, 0.4
"""Parts of F_A: what matters, a level at rest that can only be a pretension, and more than any zero jumps by."""
LEAST = 8
"""A rest has so many blocks, and so many samples lie on either side of a jump."""
STILL, STILL_SIGMAS = 0.3, 7.0
"""A rope at rest is loaded at less than this part of the machine's rate, which is so many times its uncertainty."""
CERTAIN = 0.95
USUAL, ODDS, MAY_MATTER = 0.05, 0.1, 0.1
GOES_ON = 0.5 / math.sqrt(3.0)
"""Standard uncertainty of a drift after the last rest, where it may be half or one and a half times as fast."""
WIDTHS, CAME_BACK = (LEAST, 4 * LEAST, 16 * LEAST), 0.25
"""Samples on either side of a jump; what comes back to within this part of one was a load."""
ASK = 'say whether {} (a [tare] interval, or [protocol] rest = "zero") or {} (rest = "pretension")'


class Rest(NamedTuple):
    """A stretch in which the rope is at rest, in blocks; its mean force, and the standard uncertainty of that."""

    start: int
    stop: int
    level_N: float
    std_N: float


class Drift(NamedTuple):
    """How far the zero moves from the middle of the first rest until the peak, how surely, and for how long."""

    force_N: float
    std_N: float
    probability: float
    is_confirmed: bool
    lasting_s: float
    may_matter: float


def with_its_zero(
    trace: ForceTrace, prepared: Prepared, result: Breakaway, settings: PickSettings
) -> Breakaway:
    """Return a result with what the rope at rest says of the zero: its level, its drift, and a jump."""
    if result.status is not Status.OK or (result.peak_N <= 0.0 and settings.rest != "zero"):
        return result
    is_tared = trace.calibration is not None or settings.rest == "pretension"
    blocks, n = prepared.blocks, prepared.blocks.n_rest // prepared.blocks.size
    if not n and settings.rest == "zero" and not is_tared and blocks.force_N[0] > AT_REST * result.peak_N:
        return _either(result, "the recording begins under load, so that it shows no zero to take off")
    top = min(int(np.searchsorted(blocks.time_s, result.peak_time_s)), blocks.force_N.size - 1)
    rests = _rests(blocks.force_N[: top + 1], blocks.noise_N) if n else []
    if n and (not rests or rests[0].start >= n):
        rests = [_rest(blocks.force_N, 0, n), *rests]
    later = _later_rest(blocks, top, result)
    level_N = rests[0].level_N if rests else 0.0
    if not is_tared and level_N < -2.0 * LARGE * max(result.peak_N, result.peak_N - level_N):
        if settings.rest != "zero":
            asked = ASK.format("that is an error of the zero", "the machine pushes")
            why = f"before the climb it reads {level_N:.3g} N: {asked}"
            return _either(result, why, ("from the level at rest", level_N), as_read_last=True)
        said = f"{level_N:.4g} N at rest were taken off as the error of the zero"
        result, is_tared = _without(result, level_N, rests[0].std_N, said), True
    if result.peak_N <= 0.0:
        return result
    if rests:
        result, level_N = _with_drift(blocks, rests, later, result, level_N)
    jump_N, is_at_rest = _jump_N(prepared, rests, later, result)
    if result.status is Status.OK and rests and not is_tared:
        level_N += jump_N if settings.rest == "zero" and is_at_rest else 0.0
        result = _with_level(rests, level_N, result, settings)
    if result.status is not Status.OK or not jump_N or (is_at_rest and settings.rest != "unknown"):
        return result
    why = f"the force jumps by {jump_N:.3g} N at once within the climb: the zero did, or a load came on"
    if is_at_rest:
        why = f"the rope at rest jumps by {jump_N:.3g} N at once: {ASK.format('the zero did', 'a load came on')}"
    return _either(result, why, ("without the jump", jump_N))


def _with_level(rests: list[Rest], level_N: float, result: Breakaway, settings: PickSettings) -> Breakaway:
    """Return a result of which a level at rest is taken off, is a load, or may be either."""
    std_N, part = rests[0].std_N, level_N / result.peak_N
    if settings.rest == "zero":
        said = f"{level_N:.4g} N at rest were taken off as the error of the zero"
        return _without(result, level_N, std_N, said)
    lowest = min(rests, key=lambda rest: rest.level_N)
    if lowest.level_N < min(level_N, 0.0) - MATTERS * result.peak_N - 3.0 * lowest.std_N:
        why = f"the rope at rest reads {lowest.level_N:.3g} N after a load: "
        asked = ASK.format("the zero shifted", "the load left that")
        return _either(result, why + asked, ("from the level after a load", lowest.level_N))
    if level_N < -3.0 * std_N:
        said = (
            f"the rope at rest reads {level_N:.3g} N, less than nothing: taken off as the error of the zero"
        )
        return _without(result, level_N, std_N, said)
    if part > LARGE:
        said = f"the rope at rest reads {level_N:.3g} N, which counts as a pretension: if that is an error of the zero, "
        return replace(result, notes=(*result.notes, said + 'set [protocol] rest = "zero"'))
    if part > MATTERS:
        asked = ASK.format("that is an error of the zero", "a pretension")
        why = f"the rope at rest reads {level_N:.3g} N: {asked}"
        return _either(result, why, ("from the level at rest", level_N))
    return replace(result, peak_std_N=math.hypot(result.peak_std_N, level_N / math.sqrt(3.0)))


# --- drift -----------------------------------------------------------------------------------------------------------


def _with_drift(
    blocks: Blocks, rests: list[Rest], later: Rest | None, result: Breakaway, level_N: float
) -> tuple[Breakaway, float]:
    """Return a result without the drift of its zero, and the level from which that drifts."""
    found = _drift(blocks, rests, later, result)
    if found is None:
        return result, level_N
    small_N = MATTERS * result.peak_N
    if found.probability < CERTAIN:
        if found.may_matter > MAY_MATTER:
            why = f"the rope rests too briefly to exclude a drift of the zero of {2.0 * found.std_N:.2g} N"
            return _either(result, why), level_N
        return replace(result, peak_std_N=math.hypot(result.peak_std_N, found.std_N)), level_N
    rate_N_s = found.force_N / found.lasting_s
    # Counted from when the zero was right, if it was so within the first rest, as after a tare.
    rested_s = result.peak_time_s - found.lasting_s - float(blocks.time_s[0])
    since_N = float(np.clip(level_N / rate_N_s, 0.0, rested_s)) * rate_N_s
    drift_N = found.force_N + since_N
    std_N = math.hypot(found.std_N, 0.0 if found.is_confirmed else GOES_ON * drift_N)
    if 2.0 * std_N > small_N:
        why = f"the zero drifts by about {abs(drift_N):.2g} N between the rope at rest and the peak"
        return _either(result, why, ("without the drift", drift_N)), level_N
    said = f"the zero drifts by {drift_N:.2g} N until the peak, which was taken off"
    return _without(result, drift_N, std_N, said), level_N - since_N


def _drift(blocks: Blocks, rests: list[Rest], later: Rest | None, result: Breakaway) -> Drift | None:
    """Return the drift until the peak, all hypotheses weighed by their likelihood; None where the rests are too brief."""
    whole = [*rests, *([later] if later else [])]
    sizes, n = [rest.stop - rest.start for rest in whole], len(whole)
    time_s, force_N = (
        np.concatenate([some[rest.start : rest.stop] for rest in whole])
        for some in (blocks.time_s, blocks.force_N)
    )
    lasting_s = result.peak_time_s - float(time_s[: sizes[0]].mean())
    if force_N.size < n + LEAST:
        return None
    own = np.repeat(np.arange(n), sizes)
    # Each rest at its own level first; the last one may be that of the first one or of the one before it.
    shared = {
        tuple(range(n)),
        (0,) * n,
        (*range(n - 1), 0),
        (*range(n - 1), max(n - 2, 0)),
        (*(0,) * (n - 1), 1),
    }
    hypotheses = list(product(sorted(shared, key=lambda levels: (-len(set(levels)), levels)), (True, False)))
    fits, count, usual_N2 = [], 0.0, (USUAL * result.peak_N) ** 2
    for levels, has_slope in hypotheses:
        columns = (np.array(levels)[own][:, None] == np.unique(levels)).astype(float)
        if has_slope:
            columns = np.column_stack([columns, (time_s - time_s[0]) / lasting_s])
        terms, *_ = np.linalg.lstsq(columns, force_N, rcond=None)
        left_N = force_N - columns @ terms
        count = count or _independent(left_N)
        squares = float(left_N @ left_N) + 1e-300
        bic = count * math.log(squares) + columns.shape[1] * math.log(count)
        drift_N = drift_N2 = 0.0
        if has_slope:
            variance = squares / (force_N.size - columns.shape[1]) * force_N.size / count
            drift_N2 = variance * float(np.linalg.pinv(columns.T @ columns)[-1, -1])
            known = usual_N2 / (usual_N2 + drift_N2)
            bic -= (
                2.0 * math.log(math.inf if abs(terms[-1]) * known > LARGE * result.peak_N else ODDS)
                if abs(terms[-1]) * known <= LARGE * result.peak_N
                else -math.inf
            )
            drift_N, drift_N2 = float(terms[-1]) * known, drift_N2 * known
        fits.append((drift_N, drift_N2, bic))
    drifts_N, drifts_N2, bic = np.array(fits).T
    weights = np.exp(0.5 * (bic.min() - bic))
    weights /= weights.sum()
    has = np.array([has_slope for _, has_slope in hypotheses])
    probability = float(weights[has].sum())
    small_N = MATTERS * result.peak_N
    stds_N = np.sqrt(drifts_N2 + 1e-300)
    within = [
        0.5 * (math.erf((small_N - d) / s / math.sqrt(2.0)) - math.erf((-small_N - d) / s / math.sqrt(2.0)))
        for d, s in zip(drifts_N, stds_N, strict=True)
    ]
    may_matter = float(weights @ (1.0 - np.array(within)))
    if probability >= CERTAIN:
        weights *= has
        weights /= weights.sum()
    mean_N = float(weights @ drifts_N) if probability >= CERTAIN else 0.0
    std_N = math.sqrt(float(weights @ (drifts_N2 + (drifts_N - mean_N) ** 2)))
    levels = hypotheses[int(np.argmax(weights))][0]
    return Drift(mean_N, std_N, probability, bool(later) and levels[-1] in levels[:-1], lasting_s, may_matter)


def _independent(left_N: FloatArray) -> float:
    """Return how many independent values leave means that vary as those of some coloured ones do."""
    n, size = left_N.size, 2
    variances = [max(float(left_N @ left_N) / n, 1e-300)]
    while n // size >= LEAST:
        means = left_N[: n // size * size].reshape(-1, size).mean(axis=1)
        variances.append(size * float(means @ means) / means.size)
        size *= 2
    # Of what is slower than the longest of them no more is seen: it goes on as over the last two doublings.
    most = max(variances) / variances[0]
    grows = variances[-1] / max(variances[max(len(variances) - 3, 0)], 1e-300)
    return max(n / max(most, most * grows), 3.0)


# --- jump ------------------------------------------------------------------------------------------------------------


def _jump_N(
    prepared: Prepared, rests: list[Rest], later: Rest | None, result: Breakaway
) -> tuple[float, bool]:
    """Return by how much the zero may jump before the peak, 0 if not, and whether that is at rest."""
    top = int(np.searchsorted(prepared.time_s, result.peak_time_s))
    found = [(size_N, at) for n in WIDTHS for size_N, at in _steps(prepared, top, n, result.peak_N)]
    for jump_N, at in sorted(found, key=lambda one: -abs(one[0])):
        block = at // prepared.blocks.size
        before = [rest for rest in rests if rest.start <= block]
        after = [rest for rest in rests if rest.stop - 1 > block and rest not in before[:-1]]
        low_N = prepared.force_N[max(0, at - LEAST) : at].mean()
        first_N = rests[0].level_N if rests else 0.0
        is_at_rest = bool(abs(low_N - first_N) < LARGE * result.peak_N)
        if (jump_N < 0.0 and not after) or (is_at_rest and abs(jump_N) > LARGEST_JUMP * result.peak_N):
            continue
        close_N = CAME_BACK * abs(jump_N)
        if rests and (
            (later and abs(later.level_N - first_N) < close_N)
            or (after and abs(after[-1].level_N - first_N) < close_N)
            or abs(low_N + jump_N - first_N) < close_N
        ):
            continue
        return jump_N, is_at_rest
    return 0.0, False


def _steps(prepared: Prepared, top: int, n: int, peak_N: float) -> Iterator[tuple[float, int]]:
    """Yield the steps between two samples, with the same line through `n` samples on either side; size and place."""
    y = prepared.force_N[:top] - prepared.force_N[0]
    if y.size < 2 * n + 1:
        return
    x = np.arange(2 * n) - (n - 0.5)
    i = np.arange(y.size) - 0.5 * y.size
    s0, s1, s2 = (np.concatenate([[0.0], np.cumsum(some)]) for some in (y, i * y, y * y))
    both, right = s0[2 * n :] - s0[: -2 * n], s0[2 * n :] - s0[n:-n]
    middle = i[: both.size] + n - 0.5
    tilt = (s1[2 * n :] - s1[: -2 * n]) - middle * both
    xx, xh = float(x @ x), 0.5 * n * n
    hh = 0.5 * n - xh * xh / xx
    hy = right - 0.5 * both - xh / xx * tilt
    line_N2 = np.maximum((s2[2 * n :] - s2[: -2 * n]) - both**2 / (2 * n) - tilt**2 / xx, 0.0)
    sizes_N = hy / hh
    noise_N2 = max(prepared.noise_N**2, float(np.quantile(line_N2, 0.1)) / (2 * n - 2))
    enough = 2.0 * math.log(y.size) * 2.0
    fits = line_N2 - hy * sizes_N < (1.0 + 3.0 / math.sqrt(n)) * 2 * n * noise_N2
    good = fits & (hy * sizes_N > enough * noise_N2) & (np.abs(sizes_N) > MATTERS * peak_N)
    for start, stop in runs_of(good).tolist():
        at = start + int(np.argmax(np.abs(sizes_N[start:stop])))
        if _at_once(prepared, at, n, noise_N2):
            yield float(sizes_N[at]), at + n


def _at_once(prepared: Prepared, start: int, n: int, noise_N2: float) -> bool:
    """Return whether a step in the middle of 2n samples is more likely than any ramp, and not one of the chain."""
    force_N, at = prepared.force_N[start : start + 2 * n], start + n
    x, widths = np.arange(2.0 * n), [w for w in (1, 2, 4, 8, 16, 32, 64, 128) if w <= n]
    begins = {
        w: np.arange(n - 1 if w == 1 else n - w - n // 2, n + (n // 2 if w > 1 else 0), max(1, w // 4))
        for w in widths
    }
    line = np.column_stack([np.ones(2 * n), x - x.mean()])
    line /= np.sqrt((line**2).sum(axis=0))
    y = force_N - line @ (line.T @ force_N)
    left_N2 = []
    for w in widths:
        ramps = np.clip((x - begins[w][:, None]) / w, 0.0, 1.0)
        ramps -= (ramps @ line) @ line.T
        left_N2.append(float(y @ y) - float(((ramps @ y) ** 2 / (ramps**2).sum(axis=1)).max()))
    steps_s = np.diff(prepared.time_s)
    is_gap = steps_s[at - 1] > GAP_STEPS * median(steps_s)
    is_stuck = min(np.ptp(force_N[n - LEAST : n]), np.ptp(force_N[n : n + LEAST])) == 0.0 or any(
        first < at + 2 and last > at for first, last in prepared.stuck.tolist()
    )
    long_N2 = min(left for w, left in zip(widths, left_N2, strict=True) if w >= min(n, 32))
    return bool(
        left_N2[0] <= min(left_N2) + 4.0 * noise_N2 and left_N2[0] + 4.0 * noise_N2 < long_N2
    ) and not (is_gap or is_stuck)


# --- rest ------------------------------------------------------------------------------------------------------------


def _rests(force_N: FloatArray, noise_N: float) -> list[Rest]:
    """Return where the rope is at rest before a climb to the last block; what was hung on parts the stretches."""
    low_N, top_N, top = float(force_N.min()), float(force_N[-1]), force_N.size - 1
    below = np.flatnonzero(force_N < 0.5 * (low_N + top_N))
    half = min(int(below[-1]) + 1, top) if below.size else 0
    rate_N = (top_N - float(force_N[half])) / max(1, top - half)
    if half < 2 * LEAST or rate_N <= 0.0:
        return []
    # Means over w blocks that follow each other differ by noise of √(2/w), that is √2 w^-1.5 in slope.
    w = max(1, math.ceil((STILL_SIGMAS * math.sqrt(2.0) * noise_N / (STILL * rate_N)) ** (2.0 / 3.0)))
    if half <= 2 * w + 2:
        return []
    sums = np.concatenate([[0.0], np.cumsum(force_N[:half] - force_N[0])])
    still = np.zeros(half, dtype=bool)
    still[w : half - w + 1] = (
        np.abs(sums[2 * w :] - 2.0 * sums[w:-w] + sums[: -2 * w]) < STILL * rate_N * w**2
    )
    still[:w] = still[w]
    still &= force_N[:half] < low_N + AT_REST * (top_N - low_N)
    return [rest for start, stop in runs_of(still).tolist() for rest in _parted(force_N, start, stop)]


def _parted(force_N: FloatArray, start: int, stop: int) -> list[Rest]:
    """Return the parts of a stretch between steps, which are more likely than a line through all of it."""
    n = stop - start
    if n < 2 * LEAST:
        return [_rest(force_N, start, stop)] if n >= LEAST else []
    x, y = np.arange(n) - 0.5 * (n - 1), force_N[start:stop] - force_N[start:stop].mean()
    xx = float(x @ x)
    left_N, k = y - x * float(x @ y) / xx, np.arange(LEAST, n - LEAST + 1)
    hy, hx = -np.cumsum(left_N)[k - 1], -np.cumsum(x)[k - 1]
    gains = hy**2 / (k * (n - k) / n - hx**2 / xx)
    at, line_N2 = int(np.argmax(gains)), float(left_N @ left_N)
    split = start + int(k[at])
    sides = [force_N[start:split], force_N[split:stop]]
    count = _independent(np.concatenate([side - side.mean() for side in sides]))
    if count * math.log(line_N2 / max(line_N2 - gains[at], 1e-300) + 1e-300) < 2.0 * math.log(count):
        return [_rest(force_N, start, stop)]
    return [*_parted(force_N, start, split), *_parted(force_N, split, stop)]


def _rest(force_N: FloatArray, start: int, stop: int) -> Rest:
    level_N = float(force_N[start:stop].mean())
    left_N = force_N[start:stop] - level_N
    return Rest(start, stop, level_N, float(left_N.std()) / math.sqrt(_independent(left_N)))


def _later_rest(blocks: Blocks, top: int, result: Breakaway) -> Rest | None:
    """Return where the rope rests again after it was let down, before it is loaded again."""
    slid_N = result.kinetic_N if result.kinetic_N > 0.0 else result.peak_N
    is_low = blocks.force_N < 0.5 * min(slid_N, result.peak_N)
    is_low[: top + 1] = False
    for start, stop in runs_of(is_low).tolist():
        back = _rests(blocks.force_N[start - 1 : stop][::-1], blocks.noise_N)
        longest = max(back, key=lambda rest: rest.stop - rest.start, default=None)
        if longest and longest.stop - longest.start > LEAST + 1:
            return longest._replace(start=stop - longest.stop, stop=stop - longest.start)
    return None


# --- what is told ----------------------------------------------------------------------------------------------------


def _without(result: Breakaway, zero_N: float, std_N: float, said: str) -> Breakaway:
    """Return a result whose forces are counted from another zero, and say so."""
    forces = {key: getattr(result, key) - zero_N for key in ("peak_N", "peak_raw_N", "kinetic_N")}
    u_N = math.hypot(result.peak_std_N, std_N)
    return replace(result, **forces, peak_std_N=u_N, notes=(*result.notes, said))


def _either(
    result: Breakaway, why: str, other: tuple[str, float] | None = None, *, as_read_last: bool = False
) -> Breakaway:
    """Return a result that leaves open whether a force as read is F_A, or one without some zero."""
    told = [("as read", 0.0), *([other] if other else [])]
    events = [
        ForceEvent(
            kind="break-away",
            time_s=result.peak_time_s,
            force_N=result.peak_N - zero_N,
            drop_N=result.drop_N,
            fall_s=0.0,
            evidence=evidence,
        )  # fmt: skip
        for evidence, zero_N in (reversed(told) if as_read_last else told)
    ]
    return Breakaway(
        status=Status.DOUBTFUL,
        detail=f"{' or '.join(f'{event.force_N:.4g} N' for event in events)}: {why}",
        noise_std_N=result.noise_std_N,
        candidates=tuple(events),
        events=result.events,
        notes=result.notes,
        phases=result.phases,
    )
