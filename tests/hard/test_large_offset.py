"""Numbers with an offset of 1e9: averages, noise and peaks keep the digits that the numbers themselves have."""

import math

import numpy as np
import pytest
from hard_regime import EPS, Regime, once

from ropefric.traces.breakaway import PickSettings
from ropefric.traces.decision import pick_breakaway
from ropefric.traces.noise import noise_std
from ropefric.traces.smoothing import average_over_samples, average_over_time
from ropefric.traces.trace import ForceTrace

REGIME = Regime(
    name="offset of 1e9",
    statement="moving averages of a signal of 1 on an offset of 1e9, with gaps, relative to the offset; "
    "ordinary ones relative to the largest sample: the sum that runs along rounds at every step",
    accuracy=1e-12,
)
OFFSET = 1e9


def exact(values, n_window):
    """Every window summed exactly and rounded once."""
    n = len(values)
    means = []
    for i in range(n):
        half = min(n_window // 2, i, n - 1 - i)
        there = [x for x in values[i - half : i + half + 1] if not math.isnan(x)]
        means.append(math.fsum(there) / len(there) if there else math.nan)
    return np.array(means)


@once(REGIME)
def measured():
    rng = np.random.default_rng(3)
    worst = 0.0
    for offset in (OFFSET, -OFFSET, 0.0):
        values = offset + rng.normal(0.0, 1.0, 1200)
        with_gaps = values.copy()
        with_gaps[rng.random(values.size) < 0.2] = np.nan
        for signal in (values, with_gaps):
            scale = np.nanmax(np.abs(signal))
            for n_window in (3, 31, 301):
                truth = exact(signal, n_window)
                # A stamp at a distance of 0.4 of a step never lies on the edge of a window.
                by_time = average_over_time(np.arange(1200.0), signal, n_window - 0.2)
                for found in (average_over_samples(signal, n_window), by_time):
                    assert (np.isnan(found) == np.isnan(truth)).all()
                    worst = max(worst, float(np.nanmax(np.abs(found - truth))) / scale)
    return worst


def test_nothing_is_lost():
    assert measured() <= REGIME.accuracy


def test_a_straight_line_stays_one_up_to_its_ends():
    line = OFFSET + 0.5 * np.arange(1001.0)  # exact in floats
    for n_window in (3, 101, 1001, 99999):
        assert average_over_samples(line, n_window).tolist() == line.tolist()


def test_one_wild_sample_leaves_a_rounding_of_its_own_size_and_no_more():
    values = np.ones(4000)
    values[10] = 1e9
    found = average_over_samples(values, 31)
    assert np.abs(found[40:] - 1.0).max() <= 64 * EPS * 1e9
    assert np.isclose(
        found[10], (1e9 + 20) / 21, rtol=1e-15
    )  # the window that the start still leaves: 21 samples


def test_noise_and_peak_are_found_on_the_offset():
    rng = np.random.default_rng(4)
    t = np.arange(0.0, 4.0, 0.001)
    pull = np.where(t < 1, 0.0, np.where(t < 3, 100 * (t - 1), 160 + 4 * np.sin(60 * t)))
    pull = pull + rng.normal(0.0, 0.2, t.size)
    (plain,) = pick_breakaway(ForceTrace(time_s=t, force_N=pull), PickSettings())
    (lifted,) = pick_breakaway(ForceTrace(time_s=t, force_N=pull + OFFSET), PickSettings())
    assert plain.status == lifted.status == "ok"
    # The offset leaves steps of 1.2e-7 N to the samples.
    assert lifted.peak_N - OFFSET == pytest.approx(plain.peak_N, abs=1e-6)
    assert lifted.peak_std_N == pytest.approx(plain.peak_std_N, rel=1e-4)
    assert noise_std(pull + OFFSET) == pytest.approx(noise_std(pull), rel=1e-5)


def test_late_time_stamps_are_no_matter():
    t = 1e9 + np.arange(0.0, 4.0, 2.0**-10)  # a clock that counts from long ago; exact in floats
    pull = np.where(t - 1e9 < 3, 100 * (t - 1e9), 200 + 4 * np.sin(60 * t))
    (early,) = pick_breakaway(ForceTrace(time_s=t - 1e9, force_N=pull), PickSettings())
    (late,) = pick_breakaway(ForceTrace(time_s=t, force_N=pull), PickSettings())
    assert early.status == "ok"
    assert late.peak_N == early.peak_N
    assert late.peak_time_s - 1e9 == early.peak_time_s
