"""The chosen window and the three estimates of a peak, against signals whose peak is known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ropefric.traces.peak import Neighbourhood, choose_window, measure_peak, window_bias_N

STEP_S = 1 / 3000


def uncertainty_N(rate, noise, window_s, step_s):
    """Noise that is left, and the window's bias."""
    return np.hypot(noise / np.sqrt(max(window_s / step_s, 1.0)), window_bias_N(rate, window_s, step_s))


@given(st.floats(1, 5000), st.floats(0.01, 20), st.sampled_from([1e-4, STEP_S, 1e-2]))
def test_no_other_window_is_better(rate, noise, step_s):
    best_s = choose_window(rate, noise, step_s, longest_s=10.0)
    here = uncertainty_N(rate, noise, best_s, step_s)
    # The formula neglects one step in the bias, so compare with windows beyond the neighbours.
    for factor in (0.2, 0.3, 3.0, 5.0):
        other_s = max(1, round(best_s * factor / step_s)) * step_s
        if abs(other_s - best_s) > 2.5 * step_s:
            assert here <= uncertainty_N(rate, noise, other_s, step_s) * 1.001


def test_limits_of_the_window():
    assert choose_window(200.0, 0.0, STEP_S, longest_s=0.02) == STEP_S
    assert choose_window(0.0, 1.0, STEP_S, longest_s=0.02) == pytest.approx(0.02, rel=0.05)
    assert window_bias_N(-5.0, 0.1, STEP_S) == 0.0


def signal(rng, *, noise, rate=200.0, top_N=320.0, drop_N=50.0, drop_s=0.003):
    time_s = np.arange(6000) * STEP_S
    corner_s = 1.2 + rng.uniform(0, STEP_S)
    ramp = top_N + rate * (time_s - corner_s)
    slip = top_N - drop_N * np.clip((time_s - corner_s) / drop_s, 0, 1)
    force_N = np.where(time_s <= corner_s, ramp, slip) + rng.normal(0, noise, time_s.size)
    corner = int(corner_s / STEP_S)
    where = Neighbourhood(loading=corner - 1500, first=corner - 30, stop=corner + 12)
    return time_s, force_N, where


def errors(n=150, **settings):
    window_s = settings.pop("window_s", None)
    noise = settings["noise"]
    rows = []
    for seed in range(n):
        time_s, force_N, where = signal(np.random.default_rng(seed), **settings)
        peak = measure_peak(time_s, force_N, where, noise_std_N=noise, window_s=window_s)
        rows.append((peak.peak_N - 320, peak.bias_N, peak.peak_std_N, peak.peak_raw_N - 320))
    return np.array(rows)


def test_the_bias_estimate_is_the_bias_of_a_wide_window():
    rows = errors(noise=0.05, window_s=31 * STEP_S)
    assert rows[:, 0].mean() == pytest.approx(rows[:, 1].mean(), rel=0.06)
    assert rows[:, 1].mean() == pytest.approx(-1.0, rel=0.02)


@pytest.mark.parametrize("noise", [0.2, 0.6, 2.0])
def test_the_chosen_window_keeps_the_error_within_its_uncertainty(noise):
    rows = errors(noise=noise)
    rms = np.sqrt((rows[:, 0] ** 2).mean())
    assert 0.3 < rms / rows[:, 2].mean() < 1.6
    assert abs(rows[:, 0].mean()) < 0.003 * 320


def test_without_smoothing_the_peak_is_the_largest_sample():
    rng = np.random.default_rng(0)
    time_s, force_N, where = signal(rng, noise=0.5)
    peak = measure_peak(time_s, force_N, where, noise_std_N=0.5, window_s=0.0)
    assert peak.peak_N == peak.peak_raw_N == force_N[where.first : where.stop].max()
    assert peak.window_s == peak.bias_N == 0.0


def test_a_peak_narrower_than_the_window_is_not_smoothed_away():
    time_s = np.arange(200) / 100
    force_N = np.full(200, 9.0)
    force_N[:90] = 2.0
    force_N[90:94] = [5.0, 11.0, 17.0, 23.4]
    where = Neighbourhood(loading=89, first=91, stop=95)
    peak = measure_peak(time_s, force_N, where, noise_std_N=0.2)
    assert peak.peak_N == 23.4
