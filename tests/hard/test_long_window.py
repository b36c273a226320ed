"""Windows longer than the trace: they shrink to what there is, and never invent a sample."""

import math

import numpy as np
import pytest
from hard_regime import Regime, once

from ropefric.traces.breakaway import PickSettings
from ropefric.traces.protocols import PROTOCOLS
from ropefric.traces.smoothing import average_over_samples, average_over_time, smooth, window_samples
from ropefric.traces.trace import ForceTrace

REGIME = Regime(
    name="window longer than the trace",
    statement="windows of up to 1e12 traces: the middle sample is the mean of all, the ends stay what they are",
    accuracy=1e-14,
)
WINDOWS = (1001, 99_999, 10**15 + 1)


def _signal(n=999):
    return np.random.default_rng(5).normal(3.0, 1.0, n)


@once(REGIME)
def measured():
    values = _signal()
    middle = math.fsum(values) / values.size
    trace = ForceTrace(time_s=0.001 * np.arange(values.size), force_N=values)
    found = [average_over_samples(values, n)[499] for n in WINDOWS]
    found += [average_over_time(np.arange(999.0), values, window)[499] for window in (2e3, 1e12, 1e300)]
    found += [smooth(trace, window).force_N[499] for window in (1.5, 1e9)]
    return max(abs(mean / middle - 1.0) for mean in found)


def test_the_middle_is_the_mean_of_all():
    assert measured() <= REGIME.accuracy


@pytest.mark.parametrize("n", [1, 2, 3, 4, 50, 51])
def test_the_ends_stay_and_nothing_leaves_the_range(n):
    values = _signal(n)
    for found in (
        average_over_samples(values, WINDOWS[-1]),
        average_over_time(np.arange(float(n)), values, 1e300),
    ):
        assert found.shape == values.shape
        assert found[0] == pytest.approx(values[0], rel=1e-15)
        assert found[-1] == pytest.approx(values[-1], rel=1e-15)
        assert values.min() - 1e-15 <= found.min() <= found.max() <= values.max() + 1e-15


def test_an_empty_trace_has_no_average():
    assert average_over_samples([], 3).size == average_over_time([], [], 1.0).size == 0


@pytest.mark.parametrize("name", PROTOCOLS)
@pytest.mark.parametrize("window_s", [100.0, 1e9])
def test_picking_survives_it(name, window_s):
    t = np.arange(0.0, 4.0, 0.001)
    pull = np.where(t < 1, 0.0, np.where(t < 3, 100 * (t - 1), 160 + 4 * np.sin(60 * t)))
    for result in PROTOCOLS[name].pick(ForceTrace(time_s=t, force_N=pull), PickSettings(window_s=window_s)):
        if result.status == "ok":
            assert np.isfinite(result.peak_N)
            # What such a window costs stands in the uncertainty.
            assert name in {"held", "two-way"} or result.peak_std_N > 1000.0
        assert result.detail or result.status == "ok"


@pytest.mark.parametrize(("window", "step"), [(1.0, 1e-300), (1e300, 1e-9), (1e20, 1.0)])
def test_a_window_that_cannot_be_counted_is_refused(window, step, refused):
    refused(lambda: window_samples(window, step), "too many steps")
