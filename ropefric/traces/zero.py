"""The zero of a recording is constant, drifts or jumps; a level at rest is a zero error or a pretension.

Lines through the rope at rest, before the climb and after the load was let down, are compared by their likelihood
(BIC, with priors of levels and slopes in place of one penalty for each): with a slope or without, each rest at a
level of its own (weights were hung) or at that of another. Noise is coloured: only as many blocks count as are
independent. A jump is one step between two samples with one line on either side, more likely than any ramp.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ropefric.arrays import FloatArray, median
from ropefric.traces.breakaway import SURE, Breakaway, ForceEvent, PickSettings, Status
from ropefric.traces.clock import GAP_STEPS
from ropefric.traces.noise import runs_of
from ropefric.traces.segments import AT_REST, TINY, Blocks, Prepared
from ropefric.traces.trace import ForceTrace

MATTERS, LARGE, LARGEST_JUMP = 0.02, 0.12, 0.4
"""Fractions of F_A: the smallest error that matters, the largest zero error, the largest jump of a zero."""
CERTAIN, SELDOM, USUAL = 0.95, 0.06, 0.05
"""Probability that counts as certain; prior probability of a drift, its typical size until the peak as a part of F_A."""
GOES_ON = 0.5 / math.sqrt(3.0)
"""Standard uncertainty of a drift after the last rest, where it may be half or one and a half times as fast."""
LEAST, WIDTHS, CAME_BACK = 8, (8, 32, 128), 0.25
"""Fewest blocks of a rest; samples on either side of a jump; a level that returns within this fraction of a jump was
a load."""
STILL, STILL_SIGMAS, ENDS = 0.3, 7.0, 4.0
"""At rest the force changes at less than this fraction of the loading rate, tested at this many standard errors; a rest
ends where it leaves the line through its middle by this many noise standard deviations."""
ASK = 'say whether {} (a [tare] interval, or [protocol] rest = "zero") or {} (rest = "pretension")'


class Rest(NamedTuple):
    """A stretch of blocks at rest: level, slope, noise, and the number of blocks that are correlated."""

    start: int
    stop: int
    level_N: float
    std_N: float
    slope_N: float
    slope_std_N: float
    noise_N: float
    alike: float


def with_its_zero(
    trace: ForceTrace, prepared: Prepared, result: Breakaway, settings: PickSettings
) -> Breakaway:
    """Return a result corrected for the zero that the rope at rest shows: drift, jump and, without a tare, level."""
    if result.status is not Status.OK or (result.peak_N <= TINY and settings.rest != "zero"):
        return result
    blocks, is_tared = prepared.blocks, trace.tare_N != 0.0 or settings.rest == "pretension"
    if settings.rest == "zero" and not is_tared and _begins_loaded(blocks, result):
        return _either(result, "the recording begins under load: it shows no zero to subtract")
    rests, later = _before_and_after(blocks, result)
    level_N, std_N = (rests[0].level_N, rests[0].std_N) if rests else (0.0, 0.0)
    if not is_tared and level_N < -2.0 * LARGE * max(result.peak_N, result.peak_N - level_N):
        if settings.rest != "zero":
            return _far_below_nothing(result, level_N)
        result, is_tared = _with_level(level_N, std_N, result, settings), True
    if result.peak_N <= TINY:
        return result
    jump_N, is_at_rest = _jump_N(prepared, rests, later, result)
    if rests:
        result, level_N = _with_drift(blocks, rests, later, result)
    if rests and not is_tared:
        level_N += jump_N if settings.rest == "zero" and is_at_rest else 0.0
        result = _with_level(level_N, std_N, _below_nothing(rests, result, settings), settings)
    is_said = is_at_rest and settings.rest != "unknown"
    return _with_jump(result, 0.0 if is_said else jump_N, is_at_rest=is_at_rest)


def _begins_loaded(blocks: Blocks, result: Breakaway) -> bool:
    return not blocks.n_rest and bool(blocks.force_N[0] > AT_REST * result.peak_N)


def _far_below_nothing(result: Breakaway, level_N: float) -> Breakaway:
    """Return a doubtful result: no zero is wrong by so much, unless the machine pushes; the zero is the likelier."""
    asked = ASK.format("that is an error of the zero", "the machine pushes")
    found = _either(result, f"before the climb it reads {level_N:.3g} N: {asked}", "at rest", level_N)
    return replace(found, candidates=found.candidates[::-1])


def _below_nothing(rests: list[Rest], result: Breakaway, settings: PickSettings) -> Breakaway:
    """Return a doubtful result if a later rest reads below zero: the zero shifted, or a load was left."""
    lowest_N = min(
        (rest.level_N + 3.0 * rest.std_N for rest in rests if rest.stop - rest.start > 2 * LEAST), default=0.0
    )
    if (
        result.status is not Status.OK
        or settings.rest != "unknown"
        or lowest_N > min(rests[0].level_N, 0.0) - MATTERS * result.peak_N
    ):
        return result
    asked = ASK.format("the zero shifted", "the load left that")
    why = f"the rope at rest reads {lowest_N:.3g} N after a load: {asked}"
    return _either(result, why, "after a load", lowest_N)


def _with_level(level_N: float, std_N: float, result: Breakaway, settings: PickSettings) -> Breakaway:
    """Return a result in which a level at rest is subtracted, is a load, or is a doubt."""
    if result.status is not Status.OK:
        return result
    result = replace(result, rest_N=level_N)
    if settings.rest == "zero":
        said = f"{level_N:.4g} N at rest were taken off as the error of the zero"
        return _without(result, level_N, std_N, said)
    said = f"the rope at rest reads {level_N:.3g} N"
    if level_N < -3.0 * std_N:
        why = f"{said}, less than nothing: taken off as the error of the zero"
        return _without(result, level_N, std_N, why)
    if level_N > LARGE * result.peak_N:
        why = f'{said}, which counts as a pretension: if that is an error of the zero, set [protocol] rest = "zero"'
        return replace(result, notes=(*result.notes, why))
    if level_N > MATTERS * result.peak_N:
        why = f"{said}: {ASK.format('that is an error of the zero', 'a pretension')}"
        return _either(result, why, "at rest", level_N)
    return replace(result, peak_std_N=math.hypot(result.peak_std_N, level_N / math.sqrt(3.0)))


# --- drift -----------------------------------------------------------------------------------------------------------


def _with_drift(
    blocks: Blocks, rests: list[Rest], later: Rest | None, result: Breakaway
) -> tuple[Breakaway, float]:
    """Return a result corrected for the drift of the zero, and the level at which the drift begins."""
    middle, level_N = (rests[0].start + rests[0].stop - 1) // 2, rests[0].level_N
    rested_s = float(blocks.time_s[middle] - blocks.time_s[0])
    lasting_s, small_N = result.peak_time_s - float(blocks.time_s[middle]), MATTERS * result.peak_N
    whole = [*rests, later] if later else rests
    if sum(rest.stop - rest.start for rest in whole) < len(whole) + LEAST:
        return result, level_N
    drifts_N, stds_N, weights, is_tied = _drifts(blocks, whole, lasting_s, result.peak_N)
    has = stds_N > 0.0
    if weights[has].sum() < CERTAIN:
        within = [_within(small_N, *drift) for drift in zip(drifts_N.tolist(), stds_N.tolist(), strict=True)]
        std_N = math.sqrt(float(weights @ (stds_N**2 + drifts_N**2)))
        right = float(weights @ within)
        likely, share = _as_likely(result, right)
        if share < SURE and right > CERTAIN:
            return _either(
                likely, f"the place and its zero together have a probability of {share:.2f}"
            ), level_N
        if share < SURE:
            why = f"the rope rests too briefly to exclude a drift of the zero of {2.0 * std_N:.2g} N"
            return _either(likely, why), level_N
        return replace(likely, peak_std_N=math.hypot(result.peak_std_N, std_N)), level_N
    weights = weights * has / weights[has].sum()
    drift_N = float(weights @ drifts_N)
    std_N = math.sqrt(float(weights @ (stds_N**2 + (drifts_N - drift_N) ** 2)))
    # Counted from when the zero was right, if it was so within the first rest, as after a tare.
    since_N = float(np.clip(level_N * lasting_s / drift_N, 0.0, rested_s)) * drift_N / lasting_s
    drift_N += since_N
    # Between two rests it may bend, after the last one end; and what slopes in coloured noise may be a part of that.
    goes_on = GOES_ON * (0.5 if later and weights[is_tied].sum() > CERTAIN else 1.0)
    alike = max(whole, key=lambda rest: rest.stop - rest.start).alike
    std_N = math.hypot(std_N, goes_on * drift_N * min(max(0.5 * alike, 1.0), 2.0))
    likely, share = _as_likely(result, _within(small_N, 0.0, std_N))
    if share < SURE:
        why = f"the zero drifts by about {abs(drift_N):.2g} N between the rope at rest and the peak"
        return _either(likely, why, "before the drift", drift_N), level_N
    said = f"the zero drifts by {drift_N:.2g} N until the peak, which was taken off"
    return _without(likely, drift_N, std_N, said), level_N - since_N


def _within(small_N: float, mean_N: float, std_N: float) -> float:
    """Return the probability that a normal error of this mean and standard deviation is within ± `small_N`."""
    parts = [(small_N + way * mean_N) / max(std_N, 1e-9 * small_N) / math.sqrt(2.0) for way in (-1, 1)]
    return 0.5 * sum(map(math.erf, parts))


def _as_likely(result: Breakaway, share: float) -> tuple[Breakaway, float]:
    """Return a result with its probability times `share`, and that product; a result without probability stays so."""
    if not math.isfinite(result.probability):
        return result, share
    share = round(result.probability * share, 2)
    return replace(result, probability=share), share


def _drifts(
    blocks: Blocks, rests: list[Rest], lasting_s: float, peak_N: float
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return for each hypothesis: drift, standard error, probability, and if the last level equals an earlier one."""
    n, sizes = len(rests), [rest.stop - rest.start for rest in rests]
    index = np.concatenate([np.arange(rest.start, rest.stop) for rest in rests])
    own, longest = np.repeat(np.arange(n), sizes), rests[int(np.argmax(sizes))]
    noises_N = np.array([max(rest.noise_N, longest.noise_N) for rest in rests])
    # In units of F_A, of which no noise is smaller than a billionth.
    scale = np.maximum(noises_N / peak_N * math.sqrt(longest.alike), 1e-9)[own]
    # Each at a level of its own, or the last one at that of the first one or of the one before it.
    level_sets = {
        tuple(range(n)),
        (0,) * n,
        (*range(n - 1), 0),
        (*range(n - 1), max(n - 2, 0)),
        (*(0,) * (n - 1), 1),
    }
    found = []
    for levels in sorted(level_sets):
        columns = (np.array(levels)[own][:, None] == np.unique(levels)) / scale[:, None]
        slope = (blocks.time_s[index] - blocks.time_s[index[0]]) / lasting_s / scale
        # A level may be anything up to F_A: one more is paid for by what is known of it.
        paid = float(np.log((columns**2).sum(axis=0) / math.tau).sum())
        y, slope = (
            some - columns @ np.linalg.lstsq(columns, some, rcond=None)[0]
            for some in (blocks.force_N[index] / peak_N / scale, slope)
        )
        is_tied = levels[-1] in levels[:-1]
        found.append((0.0, 0.0, float(y @ y) + paid, is_tied))
        seen2, usual2 = 1.0 / max(float(slope @ slope), TINY), USUAL**2
        seen, known = float(slope @ y) * seen2, usual2 / (usual2 + seen2)
        if abs(seen * known) < LARGE:
            paid += math.log((usual2 + seen2) / seen2) - 2.0 * math.log(SELDOM)
            left = float(y @ y) - seen**2 / seen2 * known
            found.append((seen * known, math.sqrt(seen2 * known), left + paid, is_tied))
    drifts, stds, unlikely, is_tied = np.array(found).T
    weights = np.exp(0.5 * (unlikely.min() - unlikely))
    return drifts * peak_N, stds * peak_N, weights / weights.sum(), is_tied > 0.0


# --- jump ------------------------------------------------------------------------------------------------------------


def _with_jump(result: Breakaway, jump_N: float, *, is_at_rest: bool) -> Breakaway:
    """Return a doubtful result: a jump of the zero and a load that came on look alike."""
    if result.status is not Status.OK or not jump_N:
        return result
    why = f"the force jumps by {jump_N:.3g} N at once within the climb: the zero did, or a load came on"
    if is_at_rest:
        why = f"the rope at rest jumps by {jump_N:.3g} N at once: {ASK.format('the zero did', 'a load came on')}"
    return _either(result, why, "before the jump", jump_N)


def _jump_N(
    prepared: Prepared, rests: list[Rest], later: Rest | None, result: Breakaway
) -> tuple[float, bool]:
    """Return by how much the zero may jump before the peak, 0 if not, and whether that is at rest."""
    top, first_N = (
        int(np.searchsorted(prepared.time_s, result.peak_time_s)),
        rests[0].level_N if rests else 0.0,
    )
    found = [step for n in WIDTHS for step in _steps(prepared, top, n, MATTERS * result.peak_N)]
    for jump_N, at in sorted(found, key=lambda step: -abs(step[0])):
        before_N = float(prepared.force_N[max(0, at - LEAST) : at].mean())
        after = [rest for rest in rests if rest.stop > at // prepared.blocks.size + 1]
        # Where it comes back to the first level it was a load.
        levels_N = [rest.level_N for rest in (*after[-1:], later) if rest] + [before_N + jump_N]
        came_back = rests and min(abs(level_N - first_N) for level_N in levels_N) < CAME_BACK * abs(jump_N)
        is_at_rest = abs(before_N - first_N) < LARGE * result.peak_N
        is_too_large = is_at_rest and abs(jump_N) > LARGEST_JUMP * result.peak_N
        if not (came_back or is_too_large or (jump_N < 0.0 and not after)):
            return jump_N, is_at_rest
    return 0.0, False


def _steps(prepared: Prepared, top: int, n: int, least_N: float) -> Iterator[tuple[float, int]]:
    """Yield the steps between two samples, with the same line through `n` samples on either side; size and place."""
    y = prepared.force_N[:top] - prepared.force_N[0]
    if y.size <= 2 * n:
        return
    i = np.arange(y.size) - 0.5 * y.size
    s0, s1, s2 = (np.concatenate([[0.0], np.cumsum(some)]) for some in (y, i * y, y * y))
    whole, right = s0[2 * n :] - s0[: -2 * n], s0[2 * n :] - s0[n:-n]
    tilt = s1[2 * n :] - s1[: -2 * n] - (i[: whole.size] + n - 0.5) * whole
    # The step x_h of the second half, freed of level and line, whose squares are these.
    line, h = n * (4.0 * n * n - 1.0) / 6.0, 0.5 * n * n
    hh, hy = 0.5 * n - h * h / line, right - 0.5 * whole - h / line * tilt
    left_N2 = np.maximum(s2[2 * n :] - s2[: -2 * n] - whole**2 / (2 * n) - tilt**2 / line, 0.0)
    sizes_N, noise_N2 = (
        hy / hh,
        max(prepared.noise_N**2, float(np.quantile(left_N2, 0.1)) / (2 * n - 2), TINY),
    )
    likely = (hy * sizes_N > 4.0 * math.log(y.size) * noise_N2) & (np.abs(sizes_N) > least_N)
    likely &= left_N2 - hy * sizes_N < (1.0 + 3.0 / math.sqrt(n)) * 2 * n * noise_N2
    for start, stop in runs_of(likely).tolist():
        at = start + int(np.argmax(np.abs(sizes_N[start:stop])))
        if _at_once(prepared, at + n, n, 4.0 * noise_N2):
            yield float(sizes_N[at]), at + n


def _at_once(prepared: Prepared, at: int, n: int, worse_N2: float) -> bool:
    """Return whether a step is likelier than a ramp, in no gap, and the converter neither stuck nor holds its value."""
    y, steps_s = prepared.force_N[at - n : at + n], np.diff(prepared.time_s)
    if (
        steps_s[at - 1] > GAP_STEPS * median(steps_s)
        or min(map(np.ptp, (y[n - LEAST : n], y[n : n + LEAST]))) == 0.0
    ):
        return False
    if any(first < at + 2 and last > at for first, last in prepared.stuck.tolist()):
        return False
    x, left_N2 = np.arange(2.0 * n), {}
    line = np.column_stack([np.ones(2 * n), x - x.mean()]) / np.sqrt([2 * n, float(x.var()) * 2 * n])
    y = y - line @ (line.T @ y)
    for width in (2**k for k in range(int(math.log2(n)) + 1)):
        begins = (
            np.arange(n - width - n // 2, n + n // 2, max(1, width // 4)) if width > 1 else np.array([n - 1])
        )
        ramps = np.clip((x - begins[:, None]) / width, 0.0, 1.0)
        ramps -= (ramps @ line) @ line.T
        left_N2[width] = float(y @ y - ((ramps @ y) ** 2 / (ramps**2).sum(axis=1)).max())
    longest_N2 = min(left for width, left in left_N2.items() if width >= min(n, 32))
    return bool(left_N2[1] <= min(left_N2.values()) + worse_N2 and left_N2[1] + worse_N2 < longest_N2)


# --- rest ------------------------------------------------------------------------------------------------------------


def _before_and_after(blocks: Blocks, result: Breakaway) -> tuple[list[Rest], Rest | None]:
    """Return the rests before the climb, beginning with the start of the recording, and the rest after it."""
    top = min(int(np.searchsorted(blocks.time_s, result.peak_time_s)), blocks.force_N.size - 1)
    # A slope steeper than any drift of a zero is of a load that comes on or is let down.
    lasting_s = result.peak_time_s - float(blocks.time_s[0])
    most_N = LARGE * abs(result.peak_N) / lasting_s * float(blocks.time_s[1] - blocks.time_s[0])
    rests, later = (
        [
            rest
            for rest in (_rest(blocks, *one) for one in some)
            if abs(rest.slope_N) - 3.0 * rest.slope_std_N < most_N
        ]
        for some in (_flat_before(blocks, top), _flat_after(blocks, result, top))
    )
    return rests, max(later, key=lambda rest: rest.stop - rest.start, default=None)


def _flat_before(blocks: Blocks, top: int) -> list[tuple[int, int]]:
    """Return the stretches at rest before a climb to a top; the first one begins with the recording, if it rests."""
    n = blocks.n_rest // blocks.size
    if not n:
        return []
    flat = _flat(blocks.force_N[: top + 1], blocks.noise_N)
    if not flat or flat[0][0] >= n:
        return [(0, n), *flat]
    if n < flat[0][1]:
        return [(a, b) for a, b in ((flat[0][0], n), (n, flat[0][1])) if b - a >= LEAST] + flat[1:]
    return flat


def _flat_after(blocks: Blocks, result: Breakaway, top: int) -> list[tuple[int, int]]:
    """Return the first stretches at rest after a top, where the load was let down."""
    is_low = blocks.force_N < 0.5 * min(
        result.kinetic_N if result.kinetic_N > 0.0 else result.peak_N, result.peak_N
    )
    is_low[: top + 1] = False
    for start, stop in runs_of(is_low).tolist():
        back = _flat(blocks.force_N[start - 1 : stop][::-1], blocks.noise_N)
        if again := [(stop - b, stop - a) for a, b in back if b - a > LEAST + 1]:
            return again
    return []


def _rest(blocks: Blocks, start: int, stop: int) -> Rest:
    """Return level, slope and noise of a stretch without its ends, which may belong to a step or a soft start."""
    cut = (stop - start) // 8
    start, stop = start + cut * (start > 0), stop - cut
    y, quarter = blocks.force_N[start:stop], (stop - start) // 4
    x, middle = np.arange(y.size) - 0.5 * (y.size - 1), slice(quarter, y.size - quarter)
    slope_N = float(x[middle] @ y[middle]) / max(float(x[middle] @ x[middle]), TINY)
    left_N = np.abs(y - y[middle].mean() - slope_N * x)
    away = np.flatnonzero(left_N > ENDS * max(float(np.sqrt(np.mean(left_N[middle] ** 2))), blocks.noise_N))
    stop = start + min(away[away >= y.size - quarter].tolist(), default=y.size)
    start += max(away[away < quarter].tolist(), default=-1) + 1
    y, x = blocks.force_N[start:stop], np.arange(start, stop) - 0.5 * (start + stop - 1)
    level_N, xx = float(y.mean()), max(float(x @ x), TINY)
    slope_N = float(x @ y) / xx
    left_N = y - level_N - slope_N * x
    noise_N, alike = (
        max(math.sqrt(float(left_N @ left_N) / max(y.size - 2, 1)), blocks.noise_N, TINY),
        _alike(left_N),
    )
    of_mean_N, of_slope_N = (noise_N * math.sqrt(alike / count) for count in (y.size, xx))
    return Rest(start, stop, level_N, of_mean_N, slope_N, of_slope_N, noise_N, alike)


def _alike(left_N: FloatArray) -> float:
    """Return the number of correlated neighbours: the variance of their means relative to that of white noise."""
    size, variances = 2, [max(float(left_N @ left_N) / left_N.size, TINY)]
    while left_N.size // size >= LEAST:
        means = left_N[: left_N.size // size * size].reshape(-1, size).mean(axis=1)
        variances.append(size * float(means @ means) / means.size)
        size *= 2
    # What is slower is not seen any more: it goes on as over the last two doublings, twice as far.
    grows = variances[-1] / max(variances[max(len(variances) - 3, 0)], TINY)
    return float(np.clip(max(variances) / variances[0] * max(1.0, grows**2), 1.0, left_N.size / 3.0))


def _flat(force_N: FloatArray, noise_N: float) -> list[tuple[int, int]]:
    """Return the stretches at rest before a climb to the last block; weights that are hung separate them."""
    low_N, top_N, top = float(force_N.min()), float(force_N[-1]), force_N.size - 1
    below = np.flatnonzero(force_N < 0.5 * (low_N + top_N))
    half = min(int(below[-1]) + 1, top) if below.size else 0
    rate_N = (top_N - float(force_N[half])) / max(1, top - half)
    # Means over w blocks that follow each other differ by noise of √(2/w), that is √2 w^-1.5 in slope.
    w = max(
        1, math.ceil((STILL_SIGMAS * math.sqrt(2.0) * noise_N / (STILL * max(rate_N, TINY))) ** (2.0 / 3.0))
    )
    if half < max(2 * LEAST, 2 * w + 3) or rate_N <= 0.0:
        return []
    sums, still = np.concatenate([[0.0], np.cumsum(force_N[:half] - force_N[0])]), np.zeros(half, dtype=bool)
    still[w : half - w + 1] = (
        np.abs(sums[2 * w :] - 2.0 * sums[w:-w] + sums[: -2 * w]) < STILL * rate_N * w**2
    )
    still[:w] = still[w]
    still &= force_N[:half] < low_N + AT_REST * (top_N - low_N)
    return [part for start, stop in runs_of(still).tolist() for part in _parted(force_N, start, stop)]


def _parted(force_N: FloatArray, start: int, stop: int) -> list[tuple[int, int]]:
    """Return the parts of a stretch between steps, if steps fit better than one line (BIC)."""
    n = stop - start
    if n < 2 * LEAST:
        return [(start, stop)] if n >= LEAST else []
    x, y = np.arange(n) - 0.5 * (n - 1), force_N[start:stop] - force_N[start:stop].mean()
    xx, k = float(x @ x), np.arange(LEAST, n - LEAST + 1)
    y = y - x * float(x @ y) / xx
    gains = np.cumsum(y)[k - 1] ** 2 / (k * (n - k) / n - np.cumsum(x)[k - 1] ** 2 / xx)
    split, line_N2 = int(k[np.argmax(gains)]), float(y @ y) + TINY
    count = n / _alike(np.concatenate([side - side.mean() for side in (y[:split], y[split:])]))
    if count * math.log(line_N2 / max(line_N2 - float(gains.max()), TINY)) < 3.0 * math.log(count):
        return [(start, stop)]
    return [*_parted(force_N, start, start + split), *_parted(force_N, start + split, stop)]


# --- what is told ----------------------------------------------------------------------------------------------------


def _without(result: Breakaway, zero_N: float, std_N: float, said: str) -> Breakaway:
    """Return a result with `zero_N` subtracted from its forces, and a note of it."""
    forces = {key: getattr(result, key) - zero_N for key in ("peak_N", "peak_raw_N", "kinetic_N")}
    return replace(
        result, **forces, peak_std_N=math.hypot(result.peak_std_N, std_N), notes=(*result.notes, said)
    )


def either(result: Breakaway, why: str, forces_N: Mapping[str, float]) -> Breakaway:
    """Return a doubtful result with several possible forces at one place, each with the assumption behind it."""
    events = tuple(
        ForceEvent(
            kind="break-away", time_s=result.peak_time_s, force_N=force_N, drop_N=result.drop_N, evidence=evidence
        )
        for evidence, force_N in forces_N.items()
    )  # fmt: skip
    return Breakaway(
        status=Status.DOUBTFUL,
        detail=f"{' or '.join(f'{event.force_N:.4g} N' for event in events)}: {why}",
        noise_std_N=result.noise_std_N, probability=result.probability, rest_N=result.rest_N,
        candidates=events, events=result.events, notes=result.notes, phases=result.phases,
    )  # fmt: skip


def _either(result: Breakaway, why: str, origin: str = "", zero_N: float = 0.0) -> Breakaway:
    """Return a doubtful result: F_A is the force as read, or counted from another zero."""
    other = {f"from the level {origin}": result.peak_N - zero_N} if origin else {}
    return either(result, why, {"as read": result.peak_N} | other)
