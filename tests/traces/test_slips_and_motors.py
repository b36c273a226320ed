"""What slips and what a motor does: waves of sliding, partial slips of a held rope, wearing in, smooth falls, stops."""

import numpy as np
import pytest

from ropefric.traces.breakaway import PickSettings, Status
from ropefric.traces.decision import pick_breakaway
from ropefric.traces.trace import ForceTrace

TIME_S = np.arange(0.0, 5.0, 1e-3)
RATE_N_S = 200.0 / 3.0
SLIDES = TIME_S >= 2.5


def climb(top_N=100.0):
    """A force that rests for a second and is loaded to 100 N within another and a half."""
    return np.clip(RATE_N_S * (TIME_S - 1.0), 0.0, top_N)


def picked(force_N, time_s=TIME_S, noise_N=0.1):
    noise = np.random.default_rng(0).normal(0.0, noise_N, time_s.size)
    (found,) = pick_breakaway(ForceTrace(time_s=time_s, force_N=force_N + noise), PickSettings())
    return found


@pytest.mark.parametrize(("fall_N", "n_waves"), [(3.0, 8), (4.0, 8), (5.6, 2), (5.6, 1)])
def test_the_first_of_some_rounded_waves_is_the_breakaway(fall_N, n_waves):
    since_s = TIME_S - 2.5
    wave = -0.5 * fall_N * (1.0 - np.cos(2.0 * np.pi * since_s / 0.3))
    lasts = since_s < 0.3 * n_waves
    force = np.where(SLIDES, 100.0 + np.where(lasts, wave, 0.0), climb())
    found = picked(np.maximum(force - 200.0 * np.maximum(since_s - 0.3 * n_waves - 0.1, 0.0), 0.0))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.005)


def slipped(at_N, drop_N):
    """What a slip takes off a climb that begins at one second [N]."""
    return drop_N * np.clip((TIME_S - 1.0 - at_N / RATE_N_S) / 0.003, 0.0, 1.0)


@pytest.mark.parametrize("drop_N", [4.0, 6.0])
def test_a_partial_slip_of_a_rope_that_is_held_later_on_is_no_breakaway(drop_N):
    found = picked(np.minimum(RATE_N_S * np.maximum(TIME_S - 1.0, 0.0) - slipped(50.0, drop_N), 60.0))
    assert found.status is Status.NO_BREAKAWAY, found.detail


def test_a_large_slip_of_a_rope_that_is_held_later_on_is_not_clear():
    found = picked(np.minimum(RATE_N_S * np.maximum(TIME_S - 1.0, 0.0) - slipped(50.0, 15.0), 90.0))
    assert found.status is not Status.OK, found.detail


@pytest.mark.parametrize("part", [0.4, 0.6])
def test_a_fall_beyond_which_the_force_grows_more_slowly_is_the_breakaway(part):
    """A partial slip is loaded on at the machine's rate; a rope that slides and wears in gives way."""
    again = np.maximum(RATE_N_S * (TIME_S - 1.0) - slipped(60.0, 6.0), 0.0)
    found = picked(np.where(again > 60.0, 60.0 + part * (again - 60.0), again))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(60.0, rel=0.01)


def test_a_fall_that_bends_to_a_level_has_shown_it_however_briefly():
    since_s = np.maximum(TIME_S - 2.5, 0.0)
    force = np.where(SLIDES, 85.0 + 15.0 * np.exp(-since_s / 0.12), climb())
    force = np.maximum(force - 150.0 * np.maximum(since_s - 0.6, 0.0), 0.0)
    found = picked(force)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.01)


@pytest.mark.parametrize(("rate_Hz", "swings_1_s", "damped_1_s"), [(410, 250, 60), (205, 400, 25)])
def test_a_motor_that_stops_lets_the_masses_swing(rate_Hz, swings_1_s, damped_1_s):
    """A spring that is loaded at a rate r and stopped swings by r/ω, no faster than it was loaded."""
    time_s = np.arange(0.0, 1.2, 1.0 / rate_Hz)
    since_s = np.maximum(time_s - 0.4, 0.0)
    force = np.clip(5000.0 * (time_s - 0.1), 0.0, 1500.0)
    swing = 5000.0 / swings_1_s * np.sin(swings_1_s * since_s) * np.exp(-damped_1_s * since_s)
    found = picked(force + swing, time_s, noise_N=1.0)
    assert found.status is not Status.OK, found.detail


def test_waves_that_go_on_are_no_swing_that_dies_away():
    since_s = np.maximum(TIME_S - 2.5, 0.0)
    first = np.maximum(1.0 - since_s / 0.4, 0.0)
    force = np.where(SLIDES, 94.0 + (3.0 + 3.0 * first) * np.cos(2.0 * np.pi * since_s / 0.5), climb())
    found = picked(force)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.01)


@pytest.mark.parametrize(("later_N", "tau_s"), [(2.5, 1.0), (4.5, 1.0), (4.5, 2.0)])
def test_a_fall_that_settles_little_by_little_is_not_the_creep_of_a_held_rope(later_N, tau_s):
    time_s = np.arange(0.0, 40.0, 0.05)
    since_s = np.maximum(time_s - 20.0, 0.0)
    fall = 3.4 * np.minimum(since_s / 0.1, 1.0) + later_N * (1.0 - np.exp(-since_s / tau_s))
    force = np.where(time_s < 20.0, np.clip((time_s - 8.0) / 0.12, 0.0, 100.0), 100.0 - fall)
    found = picked(force, time_s, noise_N=0.6)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.015)


def test_an_obstacle_with_a_small_fall_before_its_end_is_no_breakaway():
    """It is loaded six times as fast as the motor loads then, to a force that the rope holds by far."""
    time_s = np.arange(0.0, 3.3, 1e-3)
    at_s = [0.0, 0.3, 0.45, 0.548, 0.555, 0.612, 0.636, 0.95, 2.24, 2.246, 3.0, 3.3]
    force = np.interp(
        time_s, at_s, [0.0, 0.0, 45.0, 170.0, 166.0, 169.0, 54.0, 54.0, 283.0, 215.0, 215.0, 215.0]
    )
    found = picked(force, time_s, noise_N=0.3)
    assert found.status is not Status.OK or found.peak_N == pytest.approx(283.0, rel=0.01), found.detail


def test_a_slip_and_a_load_let_down_at_the_end_are_not_clear():
    """What slipped suddenly once does not slip little by little later: that may be the motor."""
    slip = np.maximum(RATE_N_S * (TIME_S - 1.0) - slipped(80.0, 7.0), 0.0)
    slow = np.where(slip > 80.0, 80.0 + 0.9 * (slip - 80.0), slip)
    until_s = 2.45
    top_N = float(np.interp(until_s, TIME_S, slow))
    let_down = 0.78 * top_N + 0.22 * top_N * np.exp(-(TIME_S - until_s) / 0.04)
    force = np.where(until_s <= TIME_S, let_down, slow)[until_s + 0.2 > TIME_S]
    found = picked(force, TIME_S[: force.size])
    assert found.status is not Status.OK or found.peak_N == pytest.approx(80.0, rel=0.01), found.detail


@pytest.mark.parametrize(("wander_N", "status"), [(0.2, Status.OK), (5.0, Status.NO_PEAK)])
def test_a_fall_on_a_high_level_is_a_breakaway_if_it_is_no_wander_of_sliding(wander_N, status):
    """A sensor may stand at an offset; a rope that slides from the beginning on falls as far again later."""
    wander = wander_N * np.sin(2.0 * np.pi * TIME_S / 0.9)
    climb_N = np.interp(TIME_S, (0.0, 0.3, 0.31), (150.0, 165.0, 157.0))
    found = picked(climb_N + np.where(TIME_S > 0.31, wander, 0.0), noise_N=0.02)
    assert found.status is status, found.detail


@pytest.mark.parametrize(("rise_s", "height_N"), [(0.1, 20.0), (0.2, 20.0), (0.3, 20.0), (0.3, 30.0)])
def test_a_snag_after_which_the_climb_goes_on_along_its_line_is_no_slip(rise_s, height_N):
    """A slip takes its length off the spring for good; what only pushed leaves the line as it was."""
    snag = np.interp(TIME_S, (1.4, 1.4 + rise_s, 1.45 + rise_s), (0.0, height_N, 0.0))
    found = picked(np.where(SLIDES, 85.0, climb()) + snag)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.005)
