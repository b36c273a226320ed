"""Averages over 10⁸ samples: no drift of the running sum, and little more memory than input and output."""

import resource

import numpy as np
import pytest
from hard_regime import Regime, once

from ropefric.traces import smoothing
from ropefric.traces.smoothing import average_over_samples

REGIME = Regime(
    name="averages over 1e8 samples",
    statement="5e6 samples by default, 1e8 in the long run, on an offset of 1e9, relative to the signal of 500: the "
    "offset leaves it steps of 2.4e-10",
    accuracy=1e-9,
)
PERIOD = 1000
# Whole numbers, so that the truth is exact: a window of 1001 holds one period and its first sample once more.
PATTERN = (np.arange(PERIOD) * 7919 % PERIOD).astype(np.float64)


def _error(n):
    signal = np.tile(PATTERN + 1e9, n // PERIOD)
    found = average_over_samples(signal, PERIOD + 1)
    inside = found[PERIOD : n - PERIOD].reshape(-1, PERIOD)
    # Window i runs from i − 500 to i + 500, both of the same phase.
    truth = 1e9 + (PATTERN.sum() + np.roll(PATTERN, PERIOD // 2)) / (PERIOD + 1)
    return max(float(np.abs(rows - truth).max()) for rows in np.array_split(inside, 50)) / 500.0


@once(REGIME)
def measured():
    return _error(5_000_000)


def test_nothing_drifts():
    assert measured() <= REGIME.accuracy


def test_pieces_join_without_a_seam(monkeypatch):
    # Halves of whole numbers, whose sums are exact: pieces must then agree to the last bit of the quotient.
    values = np.random.default_rng(6).integers(-2000, 2000, 5000) / 2.0
    values[::37] = np.nan
    whole = [average_over_samples(values, n) for n in (3, 31, 999, 4999, 9999)]
    monkeypatch.setattr(smoothing, "_PIECE", 7)
    pieces = [average_over_samples(values, n) for n in (3, 31, 999, 4999, 9999)]
    for one, other in zip(whole, pieces, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-15, atol=1e-13)


@pytest.mark.slow
def test_a_hundred_million_samples():
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert _error(100_000_000) <= REGIME.accuracy
    grown_GB = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1e6
    # Two arrays of 0.8 GB, two masks of 0.1 GB, and a little.
    assert grown_GB < 2.2
