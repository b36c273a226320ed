"""What a sliding rope does that a held one does not, what comes free of a snag, and impacts on the climb."""

import numpy as np
import pytest
from drawing import loaded

from ropefric.traces.breakaway import PickSettings, Status
from ropefric.traces.decision import pick_breakaway
from ropefric.traces.trace import ForceTrace

TIME_S = np.arange(0.0, 6.0, 0.001)
AT_REST = ((0.0, 0.0), (0.8, 0.0))
SLIP = ((4.6, 100.0), (4.604, 80.0), (6.0, 80.0))


def drawn(*corners, noise_N=0.1):
    """Return the force along a line through corners (time, force), with noise."""
    noise = np.random.default_rng(11).normal(0.0, noise_N, TIME_S.size)
    return np.interp(TIME_S, *zip(*corners, strict=True)) + noise


def picked(force_N, *, until_s=6.0):
    seen = until_s >= TIME_S
    return pick_breakaway(ForceTrace(time_s=TIME_S[seen], force_N=force_N[seen]), PickSettings())[0]


def knock(at_s, height_N, lasts_s):
    return height_N * np.sin(np.pi * np.clip((TIME_S - at_s) / lasts_s, 0.0, 1.0))


def ring(at_s, height_N, lasts_s=0.03, hz=30.0):
    since = np.maximum(TIME_S - at_s, 0.0)
    return height_N * np.exp(-since / lasts_s) * np.sin(2.0 * np.pi * hz * since)


def small_slip(noise_N=0.1):
    """Return a force that falls by 3 % at 3 s, as of a small slip or of a motor that stops."""
    return drawn(*AT_REST, (3.0, 100.0), (3.05, 97.0), (6.0, 97.0), noise_N=noise_N)


@pytest.mark.parametrize(("wave_N", "hz"), [(0.3, 1.0), (0.3, 1.3), (0.4, 0.7), (0.4, 1.6)])
@pytest.mark.parametrize("noise_N", [0.05, 0.1])
def test_what_goes_up_and_down_after_a_small_fall_is_not_said_to_be_held(wave_N, hz, noise_N):
    """So slowly that no moment of it is rough: it slides, or the zero wanders as it did not at rest."""
    waves = wave_N * np.sin(2.0 * np.pi * hz * np.maximum(TIME_S - 3.05, 0.0))
    found = picked(small_slip(noise_N) + waves)
    assert found.status in (Status.OK, Status.DOUBTFUL), found.detail
    told_N = found.peak_N if found.status is Status.OK else found.candidates[0].force_N
    assert told_N == pytest.approx(100.0, rel=0.01)


@pytest.mark.parametrize("what", ["nothing", "creep", "drift", "swing", "noise", "slow noise at rest, too"])
def test_what_is_held_after_a_small_fall_is_not_said_to_slide(what):
    since = np.maximum(TIME_S - 3.05, 0.0)
    slow = np.cumsum(np.random.default_rng(3).normal(0.0, 0.01, TIME_S.size))
    more = {
        "nothing": 0.0,
        "creep": -1.5 * (1.0 - np.exp(-since / 0.8)),
        "drift": 0.5 * since,
        "swing": ring(3.05, 2.0, lasts_s=0.2, hz=6.0),
        "noise": np.random.default_rng(4).normal(0.0, 0.5, TIME_S.size),
        "slow noise at rest, too": slow,
    }[what]
    found = picked(small_slip() + more)
    assert found.status is Status.NO_BREAKAWAY, found.detail


def test_a_hand_is_as_uneven_while_it_loads():
    steps = 2.0 * np.sin(2.0 * np.pi * 1.5 * np.clip(TIME_S - 0.8, 0.0, 2.2))
    held = 0.6 * np.sin(2.0 * np.pi * 1.3 * np.maximum(TIME_S - 3.05, 0.0))
    found = picked(small_slip() + steps + held)
    assert found.status is not Status.OK, found.peak_N


def test_what_levels_off_and_goes_up_and_down_slides_without_a_peak():
    waves = 0.3 * np.sin(2.0 * np.pi * 1.7 * np.maximum(TIME_S - 3.0, 0.0))
    found = picked(drawn(*AT_REST, (3.0, 100.0), (6.0, 100.0)) + waves)
    assert found.status is Status.NO_PEAK, found.detail


def waves_of_sliding(wave_N):
    since = np.maximum(TIME_S - 3.0, 0.0)
    return wave_N * (np.sin(2.0 * np.pi * 3.1 * since) + np.sin(2.0 * np.pi * 5.3 * since))


@pytest.mark.parametrize(
    ("drop_N", "wave_N", "fall_s"), [(4.0, 2.0, 0.05), (4.0, 1.5, 0.3), (6.0, 2.0, 0.05), (9.0, 3.0, 0.15)]
)
def test_a_climb_that_is_straight_until_it_falls_ends_in_a_static_peak(drop_N, wave_N, fall_s):
    """However the rope slides on: one that only comes to slide bends before."""
    slides = 1.0 - np.exp(-np.maximum(TIME_S - 3.0, 0.0) / fall_s)
    force = drawn(*AT_REST, (3.0, 100.0), (6.0, 100.0)) - drop_N * slides + slides * waves_of_sliding(wave_N)
    found = picked(force)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.015)


@pytest.mark.parametrize("bends_s", [0.3, 0.6])
@pytest.mark.parametrize("wave_N", [1.0, 2.0])
def test_what_bends_into_waves_of_sliding_has_no_peak(wave_N, bends_s):
    comes = np.maximum(TIME_S - 0.8, 0.0)
    straight_s = 2.0
    bent = np.where(
        comes < straight_s - bends_s,
        comes,
        straight_s - bends_s * np.exp(-(comes - straight_s + bends_s) / bends_s),
    )
    begin_s = 0.8 + straight_s + 2.0 * bends_s
    slides = np.clip((TIME_S - begin_s + 1.0) / 0.3, 0.0, 1.0)
    found = picked(drawn((0.0, 0.0), (6.0, 0.0)) + 50.0 * bent + slides * waves_of_sliding(wave_N))
    assert found.status is not Status.OK, found.peak_N


@pytest.mark.parametrize("creeps_N", [3.0, 6.0])
def test_a_held_rope_that_creeps_after_a_straight_climb_is_held(creeps_N):
    since = np.maximum(TIME_S - 2.0, 0.0)
    rough = np.random.default_rng(5).normal(0.0, 0.5, TIME_S.size)
    found = picked(
        drawn(*AT_REST, (2.0, 100.0), (6.0, 100.0)) - creeps_N * np.log1p(since / 0.3) / 2.7 + rough
    )
    assert found.status in (Status.NO_BREAKAWAY, Status.DOUBTFUL), found.detail


@pytest.mark.parametrize(("wave_N", "hz"), [(0.7, 2.0), (1.5, 2.0), (3.0, 2.0), (0.7, 8.0), (1.5, 8.0)])
def test_what_hardly_stands_out_below_a_far_higher_force_is_not_judged(wave_N, hz):
    waves = wave_N * np.sin(2.0 * np.pi * hz * TIME_S) * ((TIME_S > 2.0) & (TIME_S < 3.0))
    pull = ((2.0, 80.0), (3.0, 80.0), (4.05, 150.0), (4.15, 82.0), (6.0, 82.0))
    found = picked(drawn(*AT_REST, *pull) + waves)
    assert found.status is Status.DOUBTFUL, found.detail
    assert found.candidates[-1].force_N == pytest.approx(150.0, rel=0.01)


@pytest.mark.parametrize("hung_N", [20.0, 60.0, 75.0])
def test_a_train_above_weights_that_are_most_of_the_load_is_one(hung_N):
    """Its teeth are loaded by the motor, the weights were not."""
    hung = ((0.0, 0.0), (0.4, 0.0), (0.42, hung_N), (1.4, hung_N))
    corners = loaded(*[(100.0, 76.0)] * 4, rate_N_s=80.0, begins=hung, fall_s=0.02)
    found = picked(drawn(*corners, (corners[-1][0] + 0.1, 40.0), (6.0, 40.0)))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.01)


@pytest.mark.parametrize("left_N", [30.0, 50.0, 70.0])
def test_a_recording_that_ends_in_a_slip_does_not_say_that_the_motor_stopped(left_N):
    found = picked(drawn(*AT_REST, (4.0, 100.0), (4.015, left_N), (6.0, left_N)), until_s=4.02)
    assert found.status is Status.DOUBTFUL, found.detail
    assert found.candidates[0].force_N == pytest.approx(100.0, rel=0.01)


@pytest.mark.parametrize("low_N", [30.0, 45.0])
@pytest.mark.parametrize("again_s", [0.1, 0.4])
def test_what_comes_free_of_all_load_before_a_pull_that_slides_at_more_had_not_slipped(low_N, again_s):
    """It hung on a snag: what falls to nothing at once is let go, not let down."""
    snag = ((1.6, 66.0), (1.604, low_N), (1.604 + again_s, 68.0), (1.61 + again_s, 0.0), (2.6, 0.0))
    found = picked(drawn((0.0, 0.0), (0.5, 0.0), *snag, (4.4, 100.0), (4.404, 80.0), (6.0, 80.0)))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.01)


def test_a_pull_that_slid_and_was_let_go_counts_before_one_that_slides_at_less_than_its_top():
    first = ((2.0, 100.0), (2.004, 80.0), (3.0, 80.0), (3.004, 0.0), (3.8, 0.0))
    found = picked(drawn((0.0, 0.0), (0.5, 0.0), *first, (5.3, 110.0), (5.304, 85.0), (6.0, 85.0)))
    assert found.status is Status.OK, found.detail
    assert found.peak_time_s == pytest.approx(2.0, abs=0.02)


@pytest.mark.parametrize("rate_N_s", [60.0, 114.0])
@pytest.mark.parametrize("drop_N", [9.0, 11.0])
@pytest.mark.parametrize("fall_s", [0.05, 0.2])
def test_small_slips_below_the_force_at_which_the_rope_slides_later_are_partial(rate_N_s, drop_N, fall_s):
    teeth = ((84.0, 84.0 - 6.2), (87.6, 87.6 - drop_N))
    corners = loaded(*teeth, rate_N_s=rate_N_s, begins=AT_REST, fall_s=0.012)
    now_s = corners[-1][0] + (100.0 - corners[-1][1]) / rate_N_s
    slides = ((now_s, 100.0), (now_s + fall_s, 90.0), (now_s + fall_s + 0.15, 91.2), (6.0, 91.2))
    found = picked(drawn(*corners, *slides, noise_N=0.06))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.01)


@pytest.mark.parametrize("hz", [40.0, 60.0])
@pytest.mark.parametrize("ring_N", [2.0, 3.0, 4.0])
def test_the_swing_of_a_partial_slip_is_no_slip_of_its_own(ring_N, hz):
    """It begins at a lower force, and the rope is loaded on."""
    force = drawn(
        *AT_REST, (4.0, 86.0), (4.004, 80.0), (4.75, 100.0), (4.85, 93.0), (6.0, 93.0), noise_N=0.02
    )
    found = picked(force - ring(4.004, ring_N, lasts_s=0.04, hz=hz))
    assert found.status in (Status.OK, Status.DOUBTFUL), found.detail
    told_N = found.peak_N if found.status is Status.OK else found.candidates[-1].force_N
    assert told_N == pytest.approx(100.0, rel=0.01)


def test_of_two_pulls_that_slip_at_one_force_the_first_counts_after_weights_that_are_most_of_it():
    """The jump of the weights is no snag."""

    def teeth(since_s, n):
        starts = since_s + 0.1 * np.arange(n)
        return [(at_s + dt_s, force_N) for at_s in starts for dt_s, force_N in ((0.008, 86.0), (0.1, 91.0))]

    first = [(2.4, 95.5), *teeth(2.4, 20), (4.6, 52.0), (5.4, 52.0)]
    force = drawn(
        (0.0, 0.0), (0.6, 0.0), (0.62, 65.0), (1.5, 65.0), *first, (5.8, 95.6), *teeth(5.8, 1), (6.0, 91.0)
    )
    found = picked(force, until_s=5.95)
    assert found.status is Status.OK, found.detail
    assert found.peak_time_s == pytest.approx(2.4, abs=0.02)


@pytest.mark.parametrize("rings", [0.0, 0.1, 0.2])
@pytest.mark.parametrize("knocks", [
    ((3.0, 60.0, 0.02),), ((2.0, 80.0, 0.012), (2.4, 80.0, 0.03), (2.8, 80.0, 0.03)), ((1.1, 90.0, 0.012),),
    ((1.05, 60.0, 0.02), (1.12, 120.0, 0.02)), ((3.0, 55.0, 0.05), (3.3, 60.0, 0.05), (3.6, 70.0, 0.05)),
])  # fmt: skip
def test_impacts_on_the_climb_are_no_breakaway(knocks, rings):
    """However many, round or early, and however they swing on."""
    force = drawn(*AT_REST, *SLIP)
    for at_s, height_N, lasts_s in knocks:
        force = force + knock(at_s, height_N, lasts_s) - ring(at_s + lasts_s, rings * height_N)
    found = picked(force)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.01)
