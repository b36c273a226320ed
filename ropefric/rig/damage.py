"""Damage to a file that an expert sees at once: from some sample on, the numbers do not go on with what was before.

Each kind takes the forces of a recording at equal steps of time and a sample, and returns the damaged forces and from
which sample each of them comes. `damaged` draws a sample at which the damage shows, or returns nothing where it hides.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ropefric.arrays import FloatArray, IntArray
from ropefric.traces.coherence import BESIDE, sudden_steps

Rng = np.random.Generator
Spoilt = tuple[FloatArray, IntArray]


class Damaged(NamedTuple):
    """Damaged forces, from which sample each one comes, and from which one on they do not go on."""

    force_N: FloatArray
    source: IntArray
    at: int


def _from_on(force_N: FloatArray, at: int, factor: float, offset_N: float = 0.0) -> Spoilt:
    spoilt = force_N.copy()
    spoilt[at:] = factor * spoilt[at:] + offset_N
    return spoilt, np.arange(force_N.size)


def _scale_changes(rng: Rng, force_N: FloatArray, at: int) -> Spoilt:
    return _from_on(force_N, at, float(np.exp(rng.choice((-1.0, 1.0)) * rng.uniform(0.15, 1.2))))


def _decimal_lost(rng: Rng, force_N: FloatArray, at: int) -> Spoilt:
    return _from_on(force_N, at, 10.0 ** int(rng.integers(1, 5)))


def _tared_again(_: Rng, force_N: FloatArray, at: int) -> Spoilt:
    return _from_on(force_N, at, 1.0, -float(force_N[at]))


def _offset_steps(rng: Rng, force_N: FloatArray, at: int) -> Spoilt:
    size_N = float(np.ptp(force_N)) * rng.choice((-1.0, 1.0)) * rng.uniform(0.1, 0.8)
    return _from_on(force_N, at, 1.0, size_N)


def _sign_flips(_: Rng, force_N: FloatArray, at: int) -> Spoilt:
    return _from_on(force_N, at, -1.0)


def _lines_lost(rng: Rng, force_N: FloatArray, at: int) -> Spoilt:
    stop = min(at + int(rng.integers(2, max(3, force_N.size // 4))), force_N.size - 1)
    source = np.concatenate([np.arange(at), np.arange(stop, force_N.size)])
    return force_N[source], source


def _joined(rng: Rng, force_N: FloatArray, at: int) -> Spoilt:
    source = np.concatenate([np.arange(at), np.arange(int(rng.integers(force_N.size - 1)), force_N.size)])
    spoilt = force_N[source]
    spoilt[at:] *= rng.choice((1.0, rng.uniform(0.5, 2.0)))
    return spoilt, source


DAMAGES: dict[str, Callable[[Rng, FloatArray, int], Spoilt]] = {
    "scale-changes": _scale_changes, "decimal-lost": _decimal_lost, "tared-again": _tared_again,
    "offset-steps": _offset_steps, "sign-flips": _sign_flips, "lines-lost": _lines_lost, "joined": _joined,
}  # fmt: skip
"""What each kind of damage to the lines of a file does at a sample, by name."""


def damaged(
    rng: Rng, force_N: FloatArray, state: IntArray, between: tuple[int, int], name: str | None = None
) -> Damaged | None:
    """Return a recording damaged at a sample between two, by a kind or by any; None where it hides.

    `state` is what the rope does at each sample: what falls as another state begins may be a slip or a let-down.
    """
    kind = name or str(rng.choice(list(DAMAGES)))
    for _ in range(20):
        low, high = max(between[0], BESIDE), min(between[1], force_N.size - BESIDE)
        if low >= high:
            return None
        at = int(rng.integers(low, high))
        spoilt_N, source = DAMAGES[kind](rng, force_N, at)
        step_N = float(spoilt_N[at] - spoilt_N[at - 1])
        may_be_a_slip = -spoilt_N[at - 1] < step_N < 0.0 and state[source[at]] != state[source[at - 1]]
        if not may_be_a_slip and at in sudden_steps(spoilt_N):
            return Damaged(spoilt_N, source, at)
    return None
