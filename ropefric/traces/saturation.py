"""Where the converter sat at its limits, or stuck at a value in between."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

# As many as a dropout that is mended, `noise.MAX_DROPOUT_SAMPLES`.
_FEWEST = 40
_LEAST = 8
# Shorter runs say nothing of what is usual.
_SHORT = 16
# Of very many, as of a coarse converter, the longest are looked at.
_MOST = 100
_AROUND = 400
_LEAST_AROUND = 100
_REST = 50
_WIDE = 0.3
# White noise turns back at two of three samples, also when it is rounded; a smooth curve hardly ever does.
_TURNS = 0.4
# From this share of changing samples on, the noise is too large to hide within one step of the converter.
_LIVELY = 0.3
_LEAST_CHANGES = 0.01
_CHANCE = 1e-6
_LONGER = 3.0
_JUMP_SIGMAS = 4.0
_JUMP_STEPS = 2.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Saturation:
    """Where a recording sat at the converter's ceiling and floor.

    At the ceiling the force is at least that high and unknown. At the floor it need not be a fault: an
    unloaded cell with 0 V at zero reads count 0.
    """

    high_runs: NDArray[np.int64]
    low_runs: NDArray[np.int64]

    @property
    def high(self) -> bool:
        """Return whether any sample is at the ceiling."""
        return len(self.high_runs) > 0

    @property
    def low(self) -> bool:
        """Return whether any sample is at the floor."""
        return len(self.low_runs) > 0

    @property
    def n_high(self) -> int:
        """Return the number of samples at the ceiling."""
        return int((self.high_runs[:, 1] - self.high_runs[:, 0]).sum())

    @property
    def n_low(self) -> int:
        """Return the number of samples at the floor."""
        return int((self.low_runs[:, 1] - self.low_runs[:, 0]).sum())

    @property
    def first_high(self) -> int | None:
        """Return the index of the first sample at the ceiling; None if there is none."""
        return int(self.high_runs[0, 0]) if self.high else None

    @property
    def longest_high(self) -> int:
        """Return the number of samples in the longest run at the ceiling."""
        return int((self.high_runs[:, 1] - self.high_runs[:, 0]).max(initial=0))

    def longest_high_s(self, time_s: NDArray[np.float64]) -> float:
        """Return how long the longest run at the ceiling lasted [s]: first to last sample and one step more."""
        if not self.high:
            return 0.0
        step_s = float(np.median(np.diff(time_s))) if len(time_s) > 1 else 0.0
        lasted_s = time_s[self.high_runs[:, 1] - 1] - time_s[self.high_runs[:, 0]]
        return float(lasted_s.max()) + step_s

    def describe(self, time_s: NDArray[np.float64], *, ceiling_N: float) -> str:
        """Return what sat at the ceiling, for how long and what it means; empty if nothing did."""
        if not self.high:
            return ""
        return (
            f"at the ADC ceiling for {self.n_high} samples, longest run {self.longest_high} "
            f"({1e3 * self.longest_high_s(time_s):.3g} ms): the force is {ceiling_N:.4g} N or more, unknown"
        )


def find_saturation(counts: NDArray[np.int64], max_count: int) -> Saturation:
    """Return the runs of samples at count 0 and at `max_count`."""
    return Saturation(high_runs=_runs(counts == max_count), low_runs=_runs(counts == 0))


def find_stuck(values: NDArray[np.float64], step: float, noise: float) -> NDArray[np.int64]:
    """Return the stretches in which a live signal reads exactly the same: start and stop of each, shape (k, 2).

    The recording itself says what is live. Where around the stretch a share p of the samples differs from the one
    before and the changes go to and fro, at rest if not on a ramp, the noise spans the converter's steps, and n equal
    samples have a probability below (1 − p²)ⁿ: p² and not p, for between two steps the noise changes less than on an
    edge.
    A converter coarser than its noise may well repeat itself, q/r seconds long on a ramp of rate r. There a
    stretch is stuck if it is three times as long as any other around it and the signal then jumps: it went on
    unseen. A signal without noise is never called stuck: it may have been computed, or held.
    """
    same = _runs(values[1:] == values[:-1])
    runs = np.asarray(same + np.array([0, 1]), dtype=np.int64)
    runs = runs[runs[:, 1] - runs[:, 0] >= _LEAST]
    if not len(runs):
        return runs
    changed = np.diff(values, prepend=values[0])
    longest = np.sort(np.argsort(runs[:, 0] - runs[:, 1], kind="stable")[:_MOST])
    candidates = runs[longest][_may_be_stuck(runs[longest], changed)]
    stuck = [run for run in candidates if _is_stuck(values, changed, runs, run, (step, noise))]
    return np.asarray(np.array(stuck, dtype=np.int64).reshape(-1, 2))


def _may_be_stuck(runs: NDArray[np.int64], changed: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which runs are long, or too long for the liveliest of their two sides: a quick look at all of them."""
    so_far = np.concatenate([[0], np.cumsum(changed != 0.0)])
    start, stop = runs.T
    reach = np.maximum(_AROUND, stop - start)
    before, after = np.maximum(0, start - reach), np.minimum(changed.size, stop + reach)
    shares = (
        (so_far[start] - so_far[before]) / np.maximum(1, start - before),
        (so_far[after] - so_far[np.minimum(stop + 1, after)]) / np.maximum(1, after - stop - 1),
    )
    share = np.clip(np.maximum(*shares), 0.0, 0.95)
    chance = changed.size * (1.0 - share**2) ** (stop - start)
    return np.asarray((stop - start >= _FEWEST) | ((share >= _LIVELY) & (chance < _CHANCE)))


def _is_stuck(
    values: NDArray[np.float64],
    changed: NDArray[np.float64],
    runs: NDArray[np.int64],
    run: NDArray[np.int64],
    grain: tuple[float, float],
) -> bool:
    start, stop = int(run[0]), int(run[1])
    length, reach = stop - start, max(_AROUND, stop - start)
    shares, is_noisy = [], False
    # On one side the force may run up and down so fast that no noise is seen on it.
    for found in (changed[max(0, start - reach) : start], changed[stop + 1 : stop + reach]):
        steps = found[found != 0.0]
        if found.size < _LEAST_AROUND:
            continue
        is_quiet = steps.size < max(3.0, _LEAST_CHANGES * found.size)
        turns = not is_quiet and (_turns(steps) >= _TURNS or _rests_noisily(found, grain[0]))
        is_noisy |= turns
        if is_quiet or turns:
            shares.append(steps.size / found.size)
    if not is_noisy:
        return False
    share = min([*shares, 0.95])
    if share >= _LIVELY and values.size * (1.0 - share**2) ** length < _CHANCE:
        return True
    if length < _FEWEST:
        return False
    step, noise = grain
    jump = np.abs(np.append(changed, 0.0)[runs[:, 1]]) > _JUMP_SIGMAS * noise + _JUMP_STEPS * step
    near = (runs[:, 1] > start - reach) & (runs[:, 0] < stop + reach) & ~jump
    longest = int((runs[near, 1] - runs[near, 0]).max(initial=_SHORT))
    return length > _LONGER * longest and bool(jump[runs[:, 0] == start][0])


def _turns(steps: NDArray[np.float64]) -> float:
    """Return the share of the steps that go the other way than the one before."""
    return float(np.mean(np.sign(steps[1:]) != np.sign(steps[:-1])))


def _rests_noisily(changes: NDArray[np.float64], step: float) -> bool:
    """Return whether somewhere, as before the load comes on, the noise alone moves the signal by several steps.

    A ramp outruns the noise, so that it only rises; and where it moves by one step only, the converter is coarser
    than its noise and may well stay where it is.
    """
    for start in range(0, changes.size - _REST + 1, _REST):
        part = changes[start : start + _REST]
        steps = part[part != 0.0]
        is_wide = np.count_nonzero(np.abs(part) > 1.5 * step) >= _WIDE * part.size
        if is_wide and _turns(steps) >= _TURNS:
            return True
    return False


def _runs(mask: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return the start and stop of every run of True, shape (k, 2)."""
    if not mask.any():
        runs = np.empty((0, 2), dtype=np.int64)
    else:
        edges = np.flatnonzero(mask[1:] != mask[:-1]) + 1
        first = [0] if mask[0] else []
        last = [mask.size] if mask[-1] else []
        runs = np.concatenate([first, edges, last]).astype(np.int64).reshape(-1, 2)
    runs.flags.writeable = False
    return runs
