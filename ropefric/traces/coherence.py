"""Faults of a file that a comparison of its numbers proves: interleaved signals and repeated blocks.

No rope makes them. Other damage (a scale that changes, lost lines, joined files) shows as a sudden step, which a rope
might make too; the picker judges that.
"""

import math

import numpy as np

from ropefric.arrays import FloatArray, IntArray

SIGNALS, SMOOTHED, APART, CLEAR, MOST = (2, 3), 15, 0.1, 6.0, 0.5
"""Numbers of interleaved signals that are tested, rounds that are averaged, smallest difference between the signals as a
fraction of the force's range and in standard errors, and the fraction of the loaded samples that must show it."""
TOKENS, BLOCK, BY_CHANCE = 8, 32, 1e-9
"""Runs of equal samples that are compared at once; fewest samples of a repeated block, and the largest probability of a
repetition by chance."""

SHOWS, BESIDE, STEEPER = 0.08, 20, 4.0
"""A sudden step is larger than this fraction of the force's range and this many times any step of as many neighbours."""

_FACTORS = np.array([6_364_136_223_846_793_005, 1_442_695_040_888_963_407])
_WEIGHTS = _FACTORS[0] ** np.arange(TOKENS)
"""Weights of the hash of `TOKENS` integers, modulo 2^64."""


def sudden_steps(force_N: FloatArray) -> IntArray:
    """Return the samples at which the force changes far more than between any of their neighbours."""
    steps_N = np.abs(np.diff(force_N))
    found = []
    for step in np.flatnonzero(steps_N > SHOWS * float(np.ptp(force_N))).tolist():
        beside_N = np.concatenate(
            [steps_N[max(step - BESIDE, 0) : step], steps_N[step + 1 : step + 1 + BESIDE]]
        )
        if steps_N[step] > STEEPER * float(beside_N.max(initial=0.0)):
            found.append(step + 1)
    return np.array(found, dtype=np.int64)


def incoherence(time_s: FloatArray, force_N: FloatArray) -> str:
    """Return in words what proves that samples are not one signal; empty if nothing does."""
    return _interleaved(force_N) or _repeated_block(time_s, force_N)


def _interleaved(force_N: FloatArray) -> str:
    range_N = float(np.ptp(force_N))
    if np.count_nonzero(np.abs(np.diff(force_N)) > 0.5 * APART * range_N) < SMOOTHED:
        return ""
    for n in SIGNALS:
        rounds = force_N.size // n
        if rounds < 2 * SMOOTHED:
            continue
        turns_N = force_N[: rounds * n].reshape(rounds, n)
        # Freed of how the force changes from one round to the next, which is the same for all in a round.
        slopes_N = np.gradient(turns_N.mean(axis=1))[:, None] * (np.arange(n) - 0.5 * (n - 1)) / n
        away_N = turns_N - turns_N.mean(axis=1)[:, None] - slopes_N
        kernel = np.ones(SMOOTHED) / SMOOTHED
        steady_N = np.stack([np.convolve(column, kernel, "valid") for column in away_N.T], axis=1)
        level_N = np.convolve(np.abs(turns_N - force_N[0]).max(axis=1), kernel, "valid")
        apart_N = np.ptp(steady_N, axis=1)[level_N > 0.5 * level_N.max()]
        scatter_N = float(np.std(away_N[SMOOTHED // 2 : -(SMOOTHED // 2)] - steady_N)) / math.sqrt(SMOOTHED)
        if np.mean(apart_N > max(APART * range_N, CLEAR * scatter_N)) > MOST:
            return (
                f"every {'second' if n == 2 else 'third'} sample is {np.median(apart_N):.3g} N away from "
                "its neighbours: several signals are interleaved; export each into a column of its own"
            )
    return ""


def _repeated_block(time_s: FloatArray, force_N: FloatArray) -> str:
    """Return in words which block is repeated: the same runs of equal samples, too many and too rare for chance."""
    begins = np.flatnonzero(np.concatenate([[True], force_N[1:] != force_N[:-1]]))
    if begins.size < 2 * TOKENS:
        return ""
    several = np.correlate(
        _mixed(force_N[begins].view(np.int64), _lengths(begins, force_N)), _WEIGHTS, "valid"
    )
    if _all_differ(several):
        return ""
    sums, order = _surprises(begins, force_N), np.argsort(several, kind="stable")
    several = several[order]
    is_same = several[1:] == several[:-1]
    first, second = order[:-1][is_same], order[1:][is_same]
    is_rare = sums[first + TOKENS] - sums[first] > TOKENS
    shifts, first = (second - first)[is_rare], first[is_rare]
    for shift in np.unique(shifts).tolist():
        at = np.sort(first[shifts == shift])
        for run in np.split(at, np.flatnonzero(np.diff(at) != 1) + 1):
            start, stop = int(run[0]), min(int(run[-1]) + TOKENS, int(run[0]) + shift, begins.size - 1)
            samples = int(begins[stop] - begins[start])
            rare = float(sums[stop] - sums[start]) - 2.0 * math.log(begins.size)
            if samples >= BLOCK and rare > -math.log(BY_CHANCE):
                first_s, again_s = (float(time_s[begins[one]]) for one in (start, start + shift))
                where = f"{samples} samples from {first_s:.4g} s on stand again from {again_s:.4g} s on"
                return f"{where}, number by number: a block was written twice; export the file again"
    return ""


def _surprises(begins: IntArray, force_N: FloatArray) -> FloatArray:
    """Return how rare all runs before a run are together, −ln of their probability, shape (n + 1,).

    A step and the length of the run after it count: what a level is like hangs on the one before it.
    """
    parts = 0.5 * force_N[begins]  # the range of the largest floats is no float
    range_N = max(float(np.ptp(parts)), float(np.finfo(np.float64).tiny))
    parts -= parts[0]
    parts /= range_N
    steps = np.diff(parts, prepend=0.0)
    steps *= 1e9
    kinds = _mixed(np.rint(steps, out=steps).astype(np.int64), _lengths(begins, force_N))
    ordered = np.sort(kinds)
    counts = np.searchsorted(ordered, kinds, side="right")
    counts -= np.searchsorted(ordered, kinds, side="left")
    return np.concatenate([[0.0], np.cumsum(-np.log(counts / begins.size))])


def _lengths(begins: IntArray, force_N: FloatArray) -> IntArray:
    return np.diff(begins, append=force_N.size)


def _mixed(one: IntArray, other: IntArray) -> IntArray:
    """Return a hash of pairs of integers, in the place of the first ones; large recordings need no more copies."""
    one *= _FACTORS[0]
    other *= _FACTORS[1]
    one += other
    return one


def _all_differ(values: IntArray) -> bool:
    """Return whether no value is there twice: most recordings need no slower search for the places."""
    ordered = np.sort(values)
    return not (ordered[1:] == ordered[:-1]).any()
