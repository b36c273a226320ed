"""Where a recording shows the break-away, as probabilities: a small trained network over equal bins of its time.

The network (a U-net: Ronneberger et al. 2015; for onsets of waves in noise Zhu and Beroza's PhaseNet, 2019) has seen
recordings drawn piece by piece (`rig.stories`) and some of the first rig, no real one; `python -m ropefric.training`
makes its weights again. It gives one softmax over *the break-away is in bin i* and the reasons why there is none, and
the state of every bin. All numbers inside are multiples of a power of two within what floats hold, so that every sum is
exact and the same on every processor.
"""

from collections.abc import Callable, Mapping
from enum import IntEnum
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from ropefric.arrays import FloatArray, IntArray, median
from ropefric.traces.breakaway import Status
from ropefric.traces.noise import noise_std

BINS = 1024
CHANNELS = 8
WIDTHS = (16, 24, 32, 48, 64, 64)
STEM, HEAD, POOLED = 12, 16, 64
WIDE, NARROW = 7, 5
"""Kernel width of a convolution in bins, at full resolution and below it."""
REASONS = (Status.NO_BREAKAWAY, Status.NO_PEAK, Status.SATURATED, Status.DOUBTFUL)
"""Reasons for no break-away; the last one means a damaged recording."""
INPUT_GRID, ACTIVATION_GRID, WEIGHT_GRID, LARGEST = 2.0**12, 2.0**7, 2.0**9, 16.0
"""Inputs, activations and weights are multiples of one over these, activations at most 16. A sum of products below 256
then needs at most the 24 bits of single precision and is exact; that of the first layer needs at most 53 bits."""
MOST_PRODUCTS = 2**18
"""Matrices are multiplied in pieces of this many products, too small for BLAS to start threads for."""

Weights = Mapping[str, Any]
STORED = Path(__file__).with_name("picker.npz")

ON_TOP = 1e-3
"""Changes smaller than this fraction of the level are looked at without the level."""

T = TypeVar("T")


class State(IntEnum):
    """State of the rope; DAMAGED from the sample on at which the recording is no longer continuous."""

    REST = 0
    HUNG = 1
    LOADING = 2
    PARTIAL_SLIP = 3
    SLIP = 4
    SLIDING = 5
    HELD = 6
    LET_DOWN = 7
    DISTURBED = 8
    DAMAGED = 9


CLIMBING = (State.LOADING, State.PARTIAL_SLIP, State.HELD, State.SLIP)
"""States before a break-away without a rest."""


class Look(NamedTuple):
    """Output of the network for a stretch of time: shape (BINS,), states (BINS, len(State)).

    `edges_s` are the BINS + 1 edges of the bins; all probabilities of `place` and `reasons` add up to one.
    """

    edges_s: FloatArray
    place: FloatArray
    reasons: dict[Status, float]
    states: FloatArray


def seen(time_s: FloatArray, force_N: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the input of the network for finite samples, shape (BINS, CHANNELS), and the edges of the bins [s].

    Of each bin: mean, highest and lowest force, the step from the bin before it in units of the usual one and of the
    noise, whether it holds samples; and for all alike how loud and how long the recording is.
    """
    edges_s = np.linspace(time_s[0], time_s[-1], BINS + 1)
    low_N, high_N = float(force_N.min()), float(force_N.max())
    if high_N - low_N < ON_TOP * max(abs(low_N), abs(high_N)):
        force_N = force_N - low_N
    size_N = float(np.partition(np.abs(force_N), (at := (199 * (force_N.size - 1)) // 200))[at])
    force = force_N / size_N if size_N > 0.0 else force_N
    starts = np.searchsorted(time_s, edges_s[:-1])
    counts = np.diff(starts, append=force.size)
    full = np.flatnonzero(counts)
    begins = starts[full]
    middle_s = 0.5 * (edges_s[1:] + edges_s[:-1])
    mean = np.interp(middle_s, time_s, force)  # what an empty bin has
    mean[full] = np.add.reduceat(force, begins) / counts[full]
    high, low = mean.copy(), mean.copy()
    high[full], low[full] = np.maximum.reduceat(force, begins), np.minimum.reduceat(force, begins)
    noise = max(noise_std(force, 0.0), 1e-6)
    steps = np.diff(mean, prepend=mean[0])
    usual = 1.4826 * median(np.abs(steps)) + 1e-6
    averaged = noise / np.sqrt(np.maximum(counts, 1))
    channels = (
        mean, np.arcsinh(100.0 * (high - mean)) / 3.0, np.arcsinh(100.0 * (mean - low)) / 3.0,
        np.arcsinh(steps / usual), np.arcsinh(steps / averaged) / 3.0, counts > 0,
        np.log10(noise) / 3.0 + 1.0, np.log10(force.size) - 3.5,
    )  # fmt: skip
    columns = np.stack(np.broadcast_arrays(*channels), axis=1)
    return np.clip(columns, -20.0, 20.0), edges_s


def forward(
    channels: T, layer: Callable[..., T], twice: Callable[[T], T], beside: Callable[[T, T], T]
) -> tuple[T, T]:
    """Return the logits of the network for every bin, and its deepest level.

    `layer(name, input, width, reach, every, is_last)` convolves; with NumPy or with what trains it.
    """
    stem = layer("stem", channels, STEM, WIDE)
    found, levels = stem, []
    for depth, width in enumerate(WIDTHS):
        found = layer(f"down{depth}", found, width, NARROW, every=2)
        found = _block(f"left{depth}", found, width, layer)
        levels.append(found)
    deepest = found
    for depth in reversed(range(len(WIDTHS) - 1)):
        found = layer(f"up{depth}", beside(twice(found), levels[depth]), WIDTHS[depth], NARROW)
        found = _block(f"right{depth}", found, WIDTHS[depth], layer)
    found = layer("top", beside(twice(found), stem), HEAD, WIDE)
    found = layer("head", found, HEAD, NARROW)
    return layer("out", found, 1 + len(State), 1, is_last=True), deepest


def _block(name: str, found: Any, width: int, layer: Callable[..., Any]) -> Any:
    return found + layer(f"{name}b", layer(f"{name}a", found, width, NARROW), width, NARROW)


def look(time_s: FloatArray, force_N: FloatArray, weights: Weights | None = None) -> Look:
    """Return the output of the network for at least two finite samples at increasing times."""
    channels, edges_s = seen(time_s, force_N)
    weights = stored_weights() if weights is None else weights
    bins, deepest = forward(_rounded(channels, INPUT_GRID), _convolved(weights), _twice, _beside)
    deepest = deepest.astype(np.float64)
    pooled = np.concatenate([deepest.mean(axis=0), deepest.max(axis=0)])
    hidden = np.maximum(_rounded(pooled @ weights["pool.w"][0] + weights["pool.b"], ACTIVATION_GRID), 0.0)
    reasons = hidden @ weights["reason.w"][0] + weights["reason.b"]
    logits = np.concatenate([bins[:, 0], reasons]) / float(weights["temperature"])
    logits[BINS:] += weights["rarer"]
    share = np.exp(logits - logits.max())
    share /= share.sum()
    states = np.exp(bins[:, 1:] - bins[:, 1:].max(axis=1, keepdims=True)).astype(np.float64)
    states /= states.sum(axis=1, keepdims=True)
    return Look(edges_s, share[:BINS], dict(zip(REASONS, share[BINS:].tolist(), strict=True)), states)


def _rounded(values: FloatArray, grid: float) -> FloatArray:
    return np.asarray(np.rint(values * grid) / grid)


def _convolved(weights: Weights) -> Callable[..., Any]:
    def layer(
        name: str, values: Any, width: int, reach: int, every: int = 1, *, is_last: bool = False
    ) -> Any:
        kernel, (bins, channels) = weights[f"{name}.w"], values.shape
        padded = np.zeros((bins + reach - 1, channels), dtype=kernel.dtype)
        np.minimum(values, LARGEST, out=padded[reach // 2 : reach // 2 + bins])
        # Neighbouring bins lie one after the other: a window of them is one row.
        rows, columns, apart = -(-bins // every), reach * channels, padded.strides[1]
        steps = (every * channels * apart, apart)
        windows = np.lib.stride_tricks.as_strided(padded, (rows, columns), steps, writeable=False)
        piece = 1
        while 2 * piece <= rows and 2 * piece * columns * width <= MOST_PRODUCTS:
            piece *= 2
        found = (np.ascontiguousarray(windows).reshape(-1, piece, columns) @ kernel).reshape(rows, width)
        found += weights[f"{name}.b"]
        if is_last:
            return found
        found *= ACTIVATION_GRID
        np.rint(found, out=found)
        found *= 1.0 / ACTIVATION_GRID
        return np.clip(found, 0.0, LARGEST, out=found).astype(np.float32, copy=False)

    return layer


def _twice(values: Any) -> Any:
    return np.repeat(values, 2, axis=0)


def _beside(left: Any, right: Any) -> Any:
    return np.concatenate([left, right], axis=1)


def multiplied(weights: Weights) -> Weights:
    """Return the weights in the precision of their layer: double in the first and the last, else single."""
    precise = ("stem", "pool", "reason", "temperature", "rarer")
    return {
        name: np.asarray(values, dtype=np.float64 if name.startswith(precise) else np.float32)
        for name, values in weights.items()
    }


@cache
def stored_weights() -> Weights:
    """Return the weights that come with the package."""
    with np.load(STORED) as stored:
        return multiplied(dict(stored))


def closer(around: int, states: IntArray, edges_s: FloatArray) -> tuple[float, float]:
    """Return the stretch of time of the second look at a bin: a few climb durations before and after it.

    `states` are those of the bins; a climb is what leads to the bin without a rest.
    """
    before = np.flatnonzero(~np.isin(states[: around + 1], CLIMBING))
    climb = max(around - (int(before[-1]) if before.size else 0), 1)
    width_s = float(edges_s[1] - edges_s[0])
    middle_s = float(edges_s[around]) + 0.5 * width_s
    climb_s = (climb + 1) * width_s
    first_s, last_s = float(edges_s[0]), float(edges_s[-1])
    return max(middle_s - 2.5 * climb_s, first_s), min(middle_s + 1.8 * climb_s, last_s)
