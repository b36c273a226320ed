"""The moving average: exact on lines, honest at edges and gaps, never in integers."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ropefric.errors import InputError
from ropefric.traces.smoothing import (
    average_over_samples,
    average_over_time,
    is_uniform,
    smooth,
)
from ropefric.traces.trace import ForceTrace


def naive(values, n_window):
    """The definition: mean of what is present within a window that shrinks on both sides alike at the ends."""
    n, half = len(values), n_window // 2
    out = np.full(n, np.nan)
    for i in range(n):
        h = min(half, i, n - 1 - i)
        near = values[i - h : i + h + 1]
        near = near[~np.isnan(near)]
        if near.size:
            out[i] = near.mean()
    return out


samples = arrays(
    np.float64, st.integers(1, 60), elements=st.one_of(st.floats(-1e6, 1e6), st.just(float("nan")))
)


@given(samples, st.integers(0, 50))
def test_it_is_the_mean_of_what_is_in_the_window_by_samples_and_by_time(values, half):
    wanted = naive(values, 2 * half + 1)
    by_samples = average_over_samples(values, 2 * half + 1)
    by_time = average_over_time(0.25 * np.arange(values.size), values, 2 * half * 0.25)
    scale = np.nanmax(np.abs(values), initial=1.0) if not np.isnan(values).all() else 1.0
    for found, digits in ((by_samples, 1e-11), (by_time, 1e-9)):
        np.testing.assert_allclose(found, wanted, rtol=0, atol=digits * scale)


def test_a_ramp_stays_a_ramp_up_to_its_last_sample_and_nothing_is_truncated():
    ramp = np.linspace(-3.0, 40.0, 500)
    for n_window in (1, 3, 31, 999, 1001):
        np.testing.assert_allclose(average_over_samples(ramp, n_window), ramp, rtol=0, atol=1e-11)
    counts = np.array([707, 708, 707, 706, 708, 707], dtype=np.int16)
    assert average_over_samples(counts, 3)[1] == pytest.approx(707 + 1 / 3)
    assert counts.tolist() == [707, 708, 707, 706, 708, 707]


def test_a_large_common_offset_costs_no_digits():
    rng = np.random.default_rng(3)
    wiggle = rng.normal(0, 1, 20_000)
    for values in (wiggle, np.where(rng.random(20_000) < 0.1, np.nan, wiggle)):
        got = average_over_samples(values + 1e9, 301) - 1e9
        # A double near 1e9 holds 1e-7; the running sum must not make that worse.
        np.testing.assert_allclose(got, average_over_samples(values, 301), atol=4e-7)


def test_samples_across_a_gap_in_time_never_mix():
    time_s = np.concatenate((np.arange(50) * 0.01, 10 + np.arange(50) * 0.01))
    force_N = np.where(time_s < 5, 100.0, 0.0)
    assert not is_uniform(time_s)
    smoothed = smooth(ForceTrace(time_s=time_s, force_N=force_N), 0.1)
    np.testing.assert_allclose(smoothed.force_N, force_N, atol=1e-9)


def test_missing_samples_are_counted_and_left_out():
    force_N = np.full(100, 7.0)
    force_N[40:60] = np.nan
    smoothed = smooth(ForceTrace(time_s=np.arange(100.0), force_N=force_N), 5.0)
    assert smoothed.n_missing == 20
    assert np.isnan(smoothed.force_N[45:55]).all()
    assert np.nanmax(np.abs(smoothed.force_N - 7.0)) < 1e-12


def test_the_conventions_bias_of_a_ramp_and_drop():
    # 200 N/s at 3 kHz: 301 samples lower the peak by 2 % of it at 500 N, 31 samples by 0.2 %.
    time_s = np.arange(9000) / 3000
    force_N = np.where(time_s <= 2.5, 200 * time_s, 300.0)
    for n_window, wanted in ((301, -0.02), (31, -0.002)):
        top = average_over_samples(force_N, n_window).max()
        assert top / 500 - 1 == pytest.approx(wanted, rel=0.02)


def test_senseless_windows_are_refused():
    trace = ForceTrace(time_s=[0.0, 0.1, 0.2], force_N=[0.0, 1.0, 2.0])
    for window_s in (float("nan"), -1.0, float("inf")):
        with pytest.raises(InputError, match="makes no sense"):
            smooth(trace, window_s)
