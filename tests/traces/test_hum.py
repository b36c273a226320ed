"""Mains hum in a recording: found where it is, taken out as what it is, and nothing else with it."""

from itertools import product

import numpy as np
import pytest
from drawn import drawn

from ropefric.traces.breakaway import PickSettings, Status
from ropefric.traces.decision import pick_breakaway
from ropefric.traces.noise import without_hum
from ropefric.traces.trace import ForceTrace

PEAK_N = 100.0


def pull(rate_Hz, *, seed=0):
    """A ramp to 100 N in two seconds, a slip of 20 N, sliding; with noise."""
    time_s = np.arange(0.0, 4.0, 1.0 / rate_Hz)
    return time_s, drawn((0.5, 0.0), (2.5, PEAK_N), (2.503, 80.0), seed=seed, time_s=time_s)


def wave(time_s, amplitude_N, frequency_Hz, phase=0.0):
    return amplitude_N * np.sin(2.0 * np.pi * frequency_Hz * time_s + phase)


@pytest.mark.parametrize("mains_Hz", [49.93, 50.0, 60.04])
def test_hum_is_found_and_taken_out(mains_Hz):
    for rate_Hz, amplitude_N in product((500.0, 3000.0), (0.3, 1.0, 3.0)):
        time_s, force_N = pull(rate_Hz)
        third = wave(time_s, 0.3 * amplitude_N, 3 * mains_Hz, 2.0)
        found = without_hum(time_s, force_N + wave(time_s, amplitude_N, mains_Hz, 0.7) + third)
        assert found.frequency_Hz == pytest.approx(mains_Hz, abs=0.03)
        assert found.amplitude_N == pytest.approx(amplitude_N, rel=0.05)
        assert np.sqrt(np.mean((found.force_N - force_N) ** 2)) < 0.12 * amplitude_N


@pytest.mark.parametrize("amplitude_N", [0.3, 3.0])
def test_the_force_is_right_whatever_the_phase_of_the_hum(amplitude_N):
    """The crest of the hum was picked: three newtons too much of a hundred, with an uncertainty of a tenth."""
    errors = []
    for number, phase in enumerate(np.linspace(0.0, 6.0, 8)):
        time_s, force_N = pull(1000.0, seed=number)
        trace = ForceTrace(time_s=time_s, force_N=force_N + wave(time_s, amplitude_N, 50.02, phase))
        (picked,) = pick_breakaway(trace, PickSettings())
        assert picked.status is Status.OK, picked.detail
        assert any("hum of" in note for note in picked.notes)
        errors.append(picked.peak_N - PEAK_N)
    assert abs(np.mean(errors)) < 0.15
    assert np.abs(errors).max() < 0.35


def test_without_hum_the_force_is_the_same_to_the_last_bit_and_teeth_of_stick_slip_are_none():
    """They begin with sliding; mains are there from the first sample on."""
    for rate_Hz, seed in product((50.0, 97.0, 500.0, 3000.0), range(3)):
        time_s, force_N = pull(rate_Hz, seed=seed)
        found = without_hum(time_s, force_N)
        assert found.amplitude_N == 0.0
        assert found.force_N is force_N
    time_s, force_N = pull(2000.0)
    for tooth_Hz in (47.0, 50.0, 61.0):
        teeth = np.where(time_s > 2.51, 4.0 * ((time_s * tooth_Hz) % 1.0 - 0.5), 0.0)
        assert without_hum(time_s, force_N + teeth).amplitude_N == 0.0
