"""The two waves of a running blade: each keeps its shape and pace, both together solve the moving string."""

import math

import numpy as np
import pytest

from ropefric.systems.bandsaw.saw import Side, span_of
from ropefric.systems.bandsaw.span import string_frequencies_Hz, travelling_waves


@pytest.fixture(params=[1, 3])
def mode(request):
    return request.param


@pytest.fixture(params=[Side.REST, Side.TIGHT], ids=str)
def span(request, saw):
    return span_of(saw, request.param)


def test_each_wave_runs_at_its_own_pace(span, mode):
    c, v = float(span.wave_speed_m_s[0]), float(span.travel_speed_m_s[0])
    place, later = np.linspace(0.1, 0.7, 7), 0.004
    now = travelling_waves(span, mode, place, [0.011])
    ahead = travelling_waves(span, mode, place + (c + v) * later, [0.011 + later])
    behind = travelling_waves(span, mode, place - (c - v) * later, [0.011 + later])
    np.testing.assert_allclose(ahead.forward, now.forward, atol=1e-12)
    np.testing.assert_allclose(behind.backward, now.backward, atol=1e-12)


def test_both_ends_stay_where_they_are_and_a_round_trip_is_a_period(span, mode):
    frequency_Hz = string_frequencies_Hz(span, mode)[0]
    waves = travelling_waves(span, mode, [0.0, 1.6], np.linspace(0.0, 0.1, 50))
    assert np.abs(waves.mode).max() < 1e-12
    assert waves.forward_s + waves.backward_s == pytest.approx(1.0 / frequency_Hz[0], rel=1e-14)


def test_together_they_are_the_mode_and_solve_the_moving_string(span, mode):
    c, v = float(span.wave_speed_m_s[0]), float(span.travel_speed_m_s[0])
    turns, step = 2.0 * math.pi * float(string_frequencies_Hz(span, mode)[0, -1]), 1e-3
    x, t = 0.57, 0.0123

    def w(dx, dt):
        return float(travelling_waves(span, mode, [x + dx], [t + dt / c]).mode[0, 0])

    shape = math.sin(mode * math.pi * x / 1.6) * math.cos(turns * t + mode * math.pi * v * x / (1.6 * c))
    assert w(0.0, 0.0) == pytest.approx(shape, abs=1e-12)
    here, h = w(0.0, 0.0), step
    w_tt = (w(0.0, h) - 2.0 * here + w(0.0, -h)) * (c / h) ** 2
    w_xx = (w(h, 0.0) - 2.0 * here + w(-h, 0.0)) / h**2
    w_xt = (w(h, h) - w(h, -h) - w(-h, h) + w(-h, -h)) * c / (4.0 * h**2)
    assert w_tt + 2.0 * v * w_xt + (v**2 - c**2) * w_xx == pytest.approx(0.0, abs=1e-4 * turns**2)
