"""Noise and spikes: what is removed is a fault, what is kept is the measurement."""

from itertools import product

import numpy as np
import pytest

from ropefric.traces.noise import noise_std, remove_spikes, resolution


def ramp_and_teeth(rng, noise):
    """A loading ramp, a slip of 40 N and saw teeth of 15 N, at 3 kHz."""
    time_s = np.arange(9000) / 3000
    teeth = 240 + 150 * np.mod(time_s - 1.5, 0.1)
    return np.where(time_s < 1.5, 280 * time_s / 1.5, teeth) + rng.normal(0, noise, time_s.size)


@pytest.mark.parametrize("noise", [0.05, 0.5, 5.0])
def test_noise_is_found_under_ramp_slips_and_spikes(noise):
    rng = np.random.default_rng(1)
    force_N = ramp_and_teeth(rng, noise)
    force_N[rng.integers(0, 9000, 20)] += 500
    assert noise_std(force_N) == pytest.approx(noise, rel=0.08)


@pytest.mark.parametrize("size", [60, 1000, 4096, 4097, 50_000])
def test_noise_is_found_in_recordings_of_every_length(size):
    """Short ones are looked at whole, long ones in stretches; a median of n differences scatters by 1.8/√n."""
    rng = np.random.default_rng(6)
    ramp = np.linspace(0.0, 300.0, size)
    found = [noise_std(ramp + rng.normal(0.0, 2.0, size)) for _ in range(30)]
    assert np.mean(found) == pytest.approx(2.0, rel=0.05)


def test_noise_below_a_count_is_never_called_zero():
    rng = np.random.default_rng(2)
    counts = np.round(rng.normal(0, 0.05, 5000) + 100.3)
    counts[::700] += 1
    assert (noise_std(counts), resolution(counts)) == (pytest.approx(1 / np.sqrt(12)), 1.0)
    assert noise_std(np.full(100, 3.0)) == 0.0


def test_rounding_of_large_numbers_is_no_count():
    assert resolution(np.array([0.0, 100.0, 100.0 + 1e-8, 50.0])) == pytest.approx(50.0)


def test_spikes_of_one_or_two_samples_are_replaced():
    force_N = ramp_and_teeth(np.random.default_rng(4), 0.5)
    for height, length in product((-250.0, 40.0, 700.0), (1, 2)):
        wanted = np.sort([place + k for place in (100, 3000, 4400, 6100, 8990) for k in range(length)])
        spiked = force_N.copy()
        spiked[wanted] += height
        before = spiked.copy()
        cleaned = remove_spikes(spiked, noise_std(spiked))
        np.testing.assert_array_equal(cleaned.bad, wanted)
        np.testing.assert_allclose(cleaned.values, force_N, atol=4.0)
        np.testing.assert_array_equal(spiked, before)


def test_spikes_side_by_side_in_the_moment_of_the_slip_and_frozen_stretches_are_found():
    rest_N = 66 + np.random.default_rng(5).normal(0, 0.5, 400)
    rest_N[[200, 205]] = -8.7
    assert remove_spikes(rest_N, noise_std(rest_N)).bad.tolist() == [200, 205]
    force_N = ramp_and_teeth(np.random.default_rng(9), 0.5)
    force_N[4499:4501] += 216.0  # the ramp ends after sample 4499, 40 N above what follows
    force_N[2000:2025] = 0.0
    assert remove_spikes(force_N, noise_std(force_N)).bad.tolist() == [*range(2000, 2025), 4499, 4500]


def test_slips_and_narrow_peaks_are_kept():
    rng = np.random.default_rng(7)
    assert remove_spikes(ramp_and_teeth(rng, 0.5), 0.5).bad.size == 0
    # A static peak two samples wide, as a 100 Hz logger sees it.
    peak = [2.0, 2, 2, 2.1, 2.3, 3.8, 7.2, 11.8, 15.2, 15.1, 11.9, 4.4, 4.5, 4.4, 4.6, 4.4, 4.5, 4.4]
    assert remove_spikes(np.array(peak), 0.1).bad.size == 0
    # What jumps everywhere is left alone.
    assert remove_spikes(rng.choice([0.0, 100.0], 2000), 0.1).bad.size == 0


def test_spikes_are_found_in_a_steep_climb_without_noise():
    """There every step is large against the noise, and all are alike."""
    clean = np.concatenate([np.zeros(100), np.linspace(0.0, 100.0, 200), np.full(150, 80.0)])
    clean += np.random.default_rng(5).normal(0.0, 0.002, clean.size)
    bad = [50, 51, 180, 181, 182, 260]
    values = clean.copy()
    values[bad] += 40.0
    assert remove_spikes(values, 0.002).bad.tolist() == bad
