"""Weights that are hung on one by one, ropes that wear in, slips before a larger one, blows, and what hides in a gap."""

import numpy as np
import pytest
from drawing import Drawing, loaded

from ropefric.traces.breakaway import Status

TIME_S = np.arange(0.0, 6.0, 0.001)
DRAWING = Drawing(TIME_S, seed=7)
drawn, picked = DRAWING.drawn, DRAWING.picked


def hung(levels_N, swing_Hz, damping, *, every_s=0.5, time_s=TIME_S):
    """Return the force of weights hung on one by one, each of which swings around its level."""
    force_N, below_N = np.zeros(time_s.size), 0.0
    for n, level_N in enumerate(levels_N):
        since = np.maximum(time_s - 0.3 - n * every_s, 0.0)
        omega = 2.0 * np.pi * swing_Hz
        force_N += (level_N - below_N) * (1.0 - np.exp(-damping * omega * since) * np.cos(omega * since))
        below_N = level_N
    return force_N


WEIGHTS = [(12.0, 24.0), (8.0, 16.0, 24.0), (15.0, 30.0, 45.0), (10.0, 20.0, 30.0, 40.0), (20.0, 50.0)]


@pytest.mark.parametrize("levels_N", WEIGHTS)
@pytest.mark.parametrize(("swing_Hz", "damping"), [(8.0, 0.06), (15.0, 0.03), (25.0, 0.1)])
def test_weights_hung_on_one_by_one_are_no_breakaway(levels_N, swing_Hz, damping):
    """However they swing; what breaks away is the pull of the motor after the last of them."""
    ramp = drawn(
        (0.0, 0.0),
        (2.8, 0.0),
        (4.8, 100.0 - levels_N[-1]),
        (4.804, 80.0 - levels_N[-1]),
        (6.0, 80.0 - levels_N[-1]),
    )
    found = picked(hung(levels_N, swing_Hz, damping) + ramp)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.005)
    if swing_Hz * damping > 1.0:  # the others still swing when the next is hung on
        assert {event.kind for event in found.events} == {"bump"}


@pytest.mark.parametrize("levels_N", WEIGHTS)
@pytest.mark.parametrize(("swing_Hz", "damping"), [(8.0, 0.06), (15.0, 0.03), (25.0, 0.1)])
def test_weights_before_a_climb_that_never_ends_are_no_breakaway_either(levels_N, swing_Hz, damping):
    ramp = drawn((0.0, 0.0), (2.8, 0.0), (6.0, 150.0 - levels_N[-1]))
    found = picked(hung(levels_N, swing_Hz, damping) + ramp)
    assert np.isnan(found.peak_N), found.peak_N
    assert found.status in (Status.NO_BREAKAWAY, Status.DOUBTFUL), found.detail


def test_weights_are_told_where_few_samples_show_them():
    time_s = np.arange(0.0, 6.0, 0.02)
    ramp = drawn((0.0, 0.0), (2.8, 0.0), (4.8, 76.0), (4.9, 56.0), (6.0, 56.0), time_s=time_s)
    found = picked(hung((8.0, 16.0, 24.0), 8.0, 0.2, time_s=time_s) + ramp, time_s=time_s)
    assert found.peak_N == pytest.approx(100.0, rel=0.03)


def test_waves_of_sliding_are_no_weights():
    """They stand for a moment where they turn, and rise fast; but the force has been as high before."""
    slides = np.clip(TIME_S - 2.38, 0.0, 0.1) / 0.1
    waves = 2.0 * slides * (np.sin(31.0 * TIME_S) + np.sin(53.0 * TIME_S))
    bends = ((0.0, 0.0), (0.3, 0.0), (1.6, 13.0), (1.9, 14.5), (2.3, 15.0))
    found = picked(drawn(*bends, (2.38, 11.5), (6.0, 11.5)) + waves)
    assert found.status is Status.NO_PEAK, found.detail


@pytest.mark.parametrize("weight_N", [12.0, 20.0])
@pytest.mark.parametrize("slides_N", [80.0, 90.0])
def test_a_rope_that_slides_where_a_motor_brought_it_is_no_second_weight(weight_N, slides_N):
    """It stands at a round top for a moment and slides on; an obstacle comes later."""
    again_s = 3.5 + (134.0 - slides_N) / 48.0
    climb = ((0.0, 0.0), (0.3, 0.0), (0.31, weight_N), (1.2, weight_N), (3.0, 99.0), (3.1, 100.0))
    slides = (
        (3.11, slides_N),
        (3.5, slides_N),
        (again_s, 134.0),
        (again_s + 0.02, slides_N),
        (6.0, slides_N),
    )
    found = picked(drawn(*climb, *slides))
    assert found.status is not Status.OK or found.peak_N == pytest.approx(100.0, rel=0.01), found.peak_N


@pytest.mark.parametrize(("height_N", "swing_Hz"), [(240.0, 60.0), (150.0, 45.0), (300.0, 80.0)])
def test_an_impact_higher_than_the_pull_that_swings_about_nothing_is_passed_over(height_N, swing_Hz):
    since = np.maximum(TIME_S - 0.8, 0.0)
    struck = height_N * np.exp(-since / 0.15) * np.sin(2.0 * np.pi * swing_Hz * since)
    found = picked(drawn((0.0, 0.0), (1.6, 0.0), (4.0, 100.0), (4.004, 80.0), (6.0, 80.0)) + struck)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.005)


@pytest.mark.parametrize("rings_N", [0.0, 6.0])
@pytest.mark.parametrize(("stays_s", "end_N"), [(0.0, 104.0), (0.0, 125.0), (1.4, 102.0), (0.5, 118.0)])
def test_a_rope_that_slides_and_wears_in_broke_away_at_first(stays_s, end_N, rings_N):
    """The force grows beyond the first peak again, but far more slowly than the machine loads a rope that sticks."""
    force = drawn((0.0, 0.0), (0.3, 0.0), (2.3, 100.0), (2.36, 86.0), (2.36 + stays_s, 86.0), (6.0, end_N))
    since = np.maximum(TIME_S - 2.36, 0.0)
    found = picked(force - rings_N * np.exp(-since / 0.05) * np.sin(2.0 * np.pi * 12.0 * since))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.005)


@pytest.mark.parametrize("end_N", [104.0, 125.0])
def test_a_load_that_comes_on_at_once_does_not_wear_in(end_N):
    """It overshoots, falls back, and the motor loads it on; nothing has slid."""
    since = np.maximum(TIME_S - 0.6, 0.0)
    step = 86.0 * (1.0 - np.exp(-since / 0.05) * np.cos(2.0 * np.pi * 8.0 * since))
    found = picked(step + drawn((0.0, 0.0), (1.5, 0.0), (6.0, end_N - 86.0)))
    assert found.status is not Status.OK, found.peak_N


@pytest.mark.parametrize("snag_N", [80.0, 90.0])
def test_a_snag_before_a_slower_climb_to_a_higher_force_does_not_wear_in(snag_N):
    """Nothing of it stays but the weights, and what slides keeps its friction."""
    snag = ((0.0, 0.0), (0.35, 0.0), (0.5, 0.6 * snag_N), (0.74, snag_N), (0.78, 19.0), (0.95, 19.0))
    found = picked(drawn(*snag, (2.03, 100.0), (2.034, 75.0), (6.0, 75.0)))
    assert found.status is not Status.OK or found.peak_N == pytest.approx(100.0, rel=0.005), found.peak_N


@pytest.mark.parametrize(("first_N", "drop_N"), [(92.0, 17.0), (84.0, 15.0), (95.0, 8.0)])
def test_a_slip_before_a_larger_one_from_a_higher_force_is_not_said_to_be_the_first_full_one(first_N, drop_N):
    """All that the motor turns goes into the spring until then: it may be partial, or an obstacle came later."""
    rate = 50.0
    again_s = (100.0 - first_N + drop_N) / rate
    at_s = 0.3 + first_N / rate
    top_s = at_s + 0.004 + again_s
    force = drawn(
        (0.0, 0.0), (0.3, 0.0), (at_s, first_N), (at_s + 0.004, first_N - drop_N), (top_s, 100.0),
        (top_s + 0.004, 70.0), (6.0, 70.0),
    )  # fmt: skip
    found = picked(force)
    if found.status is Status.OK:
        assert found.peak_N == pytest.approx(100.0, rel=0.005)
    else:
        assert found.status is Status.DOUBTFUL, found.detail
        assert any(one.force_N == pytest.approx(100.0, rel=0.01) for one in found.candidates)


@pytest.mark.parametrize(
    ("part", "ring"),
    [(0.08, 0.0), (0.08, 0.8), (0.08, 1.5), (0.12, 0.0), (0.12, 0.8), (0.15, 0.0), (0.18, 0.0)],
)
@pytest.mark.parametrize("firsts_N", [(62.0,), (45.0, 70.0), (40.0, 60.0, 80.0), (50.0, 57.0, 73.0, 90.0)])
def test_small_slips_along_the_line_of_the_machine_are_partial(firsts_N, part, ring):
    """All that the motor turned went into the spring until the far larger slip, though each of them rings on."""
    teeth = (*((top_N, (1.0 - part) * top_N) for top_N in firsts_N), (100.0, 45.0))
    corners = loaded(*teeth, rate_N_s=50.0)
    force = drawn(*corners, (corners[-1][0] + 1.0, 45.0))
    for (top_N, bottom_N), (slipped_s, _) in zip(teeth, corners[3::2], strict=True):
        since_s = np.maximum(TIME_S - slipped_s, 0.0)
        ring_N = ring * (top_N - bottom_N)
        force -= ring_N * np.exp(-since_s / 0.02) * np.sin(2.0 * np.pi * 40.0 * since_s)
    found = picked(force)
    assert found.status in (Status.OK, Status.DOUBTFUL), found.detail
    if found.status is Status.OK:
        assert found.peak_N == pytest.approx(100.0, rel=0.01)


@pytest.mark.parametrize("again_N", [58.0, 60.0, 61.0])
def test_what_slips_again_from_no_higher_a_force_has_slid(again_N):
    """An obstacle, or wear, came later."""
    teeth = ((60.0, 50.0), *[(again_N, 50.0)] * 3, (75.0, 45.0))
    found = picked(drawn(*loaded(*teeth, rate_N_s=50.0), (6.0, 45.0)))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(60.0, rel=0.005)


@pytest.mark.parametrize("lobes_N", [(36.0, 54.0, 36.0), (20.0, 50.0), (45.0, 60.0, 20.0)])
def test_a_snag_that_lets_go_little_by_little_is_no_breakaway(lobes_N):
    """It is pulled up again and again; then the force rests at nothing, and the pull goes higher."""
    force = drawn((0.0, 0.0), (2.8, 0.0), (4.0, 100.0), (4.004, 80.0), (6.0, 80.0))
    for n, lobe_N in enumerate(lobes_N):
        part = np.clip((TIME_S - 1.0 - 0.15 * n) / 0.2, 0.0, 1.0)
        force = np.maximum(force, lobe_N * np.sin(np.pi * part))
    found = picked(force)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.005)


@pytest.mark.parametrize(("at_s", "height_N", "lasts_s"), [
    (2.0, 25.0, 0.2), (2.4, 30.0, 0.3), (3.0, 25.0, 0.4), (1.6, 40.0, 0.3), (3.2, -20.0, 0.2),
])  # fmt: skip
def test_a_blow_that_the_climb_goes_on_after_is_no_slip(at_s, height_N, lasts_s):
    """What a slip takes off the spring is missing for good; after a blow the line goes on where it led to."""
    since = np.clip((TIME_S - at_s) / lasts_s, 0.0, 1.0)
    blow = height_N * np.sin(2.0 * np.pi * since) * (1.0 - since)
    found = picked(drawn((0.0, 0.0), (0.5, 0.0), (4.5, 100.0), (4.504, 80.0), (6.0, 80.0)) + blow)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.005)


@pytest.mark.parametrize("swing_Hz", [3.0, 6.0])
def test_a_rope_that_comes_off_and_swings_never_slid(swing_Hz):
    """It is loaded from a rest; then it hangs free and swings about nothing."""
    since = np.maximum(TIME_S - 2.5, 0.0)
    climb = np.where(TIME_S < 2.5, np.interp(TIME_S, (0.5, 2.5), (0.0, 100.0)), 0.0)
    swings = np.where(
        TIME_S < 2.5, 0.0, 100.0 * np.exp(-since / 0.4) * np.cos(2.0 * np.pi * swing_Hz * since)
    )
    found = picked(climb + swings + np.random.default_rng(7).normal(0.0, 0.1, TIME_S.size))
    assert found.status is not Status.OK, found.peak_N


def test_a_slip_unseen_in_a_gap_leaves_no_first_peak():
    """The force is lower behind the gap than before it: it slipped in it, from a force that nobody knows."""
    force = drawn(
        (0.0, 0.0), (0.3, 0.0), (1.5, 60.0), (1.504, 45.0), (2.9, 100.0), (2.904, 80.0), (6.0, 80.0)
    )
    seen = (TIME_S < 1.45) | (TIME_S > 1.6)
    found = picked(force[seen], time_s=TIME_S[seen])
    assert found.status is not Status.OK, found.peak_N


def test_the_load_that_comes_on_in_a_gap_is_no_jump_of_the_zero():
    force = drawn((0.0, 0.0), (1.0, 0.0), (3.0, 100.0), (3.004, 80.0), (6.0, 80.0))
    seen = (TIME_S < 0.99) | (TIME_S > 1.1)
    found = picked(force[seen], time_s=TIME_S[seen])
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.005)


@pytest.mark.parametrize("settles_s", [0.15, 0.3])
def test_a_climb_that_goes_straight_up_to_its_top_is_no_swing_of_a_machine_that_stops(settles_s):
    """A mass that is stopped bends over within a quarter of its period; a slip may settle as slowly as that swings."""
    since = np.maximum(TIME_S - 2.3, 0.0)
    settled = (
        86.0 + 8.0 * np.exp(-since / settles_s) - 2.5 * np.sin(np.pi * np.clip((since - 0.3) / 0.9, 0.0, 1.0))
    )
    fast = 6.0 * np.exp(-since / 0.02)
    force = np.where(TIME_S < 2.3, np.interp(TIME_S, (0.3, 2.3), (0.0, 100.0)), settled + fast)
    found = picked(force + np.random.default_rng(7).normal(0.0, 0.05, TIME_S.size))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.005)
