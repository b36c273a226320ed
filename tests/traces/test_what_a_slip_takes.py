"""What a slip takes off the spring tells a full one from a partial one, a swing of weights and a snag."""

import numpy as np
import pytest
from drawing import Drawing

from ropefric.traces.breakaway import PickSettings, Status

TIME_S = np.arange(0.0, 8.0, 0.001)
DRAWING = Drawing(TIME_S, seed=5)
drawn, picked, since = DRAWING.drawn, DRAWING.picked, DRAWING.since


# --- weights that are hung on one by one ---


def hung(n_weights, each_N, slid_N, swing_s=0.08, fall_s=0.05):
    """Return a force under weights that swing as they come on, the last of which the rope slips under, and its F_A."""
    force = np.zeros(TIME_S.size)
    for n in range(n_weights):
        at = since(1.0 + 0.5 * n)
        force += each_N * (1.0 - np.exp(-at / 0.1) * np.cos(2.0 * np.pi * at / (2.0 * swing_s)))
    top = int(np.argmax(force * (1.0 + 0.5 * n_weights > TIME_S)))
    at = since(TIME_S[top])
    force[top:] = slid_N + (force[top] - slid_N) * np.exp(-at[top:] / fall_s)
    return force, float(force[top])


@pytest.mark.parametrize("slid_N", [35.0, 45.0])
@pytest.mark.parametrize("n_weights", [8, 10])
def test_swings_of_weights_stop_far_above_where_the_rope_slides(n_weights, slid_N):
    """Each falls back by less than half of what the slip falls: what still sticks has stopped it."""
    force, peak_N = hung(n_weights, 10.0, slid_N)
    found = picked(force + drawn((0.0, 0.0), (8.0, 0.0)))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(peak_N, rel=0.01)


# --- a machine that loads faster at the end ---


@pytest.mark.parametrize("slid_N", [55.0, 65.0])
def test_a_break_after_slack_was_taken_up_is_no_bump(slid_N):
    """It rises faster than before and falls to the line of before, but is loaded again as fast, nothing is higher."""
    force = [(0.0, 0.0), (1.0, 0.0), (4.0, 50.0), (4.4, 100.0), (4.402, slid_N)]
    at_s = 4.402
    while at_s < 7.8:
        force += [(at_s + 0.08, slid_N + 10.0), (at_s + 0.082, slid_N)]
        at_s += 0.082
    found = picked(drawn(*force))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.005)


# --- what springs back by itself ---


def dips(*, taken_N, dip_N, at_s=(2.5, 3.0), decay_s=0.006, ring_Hz=0.0):
    """Return a straight climb with partial slips that spring back, up to a slip at 100 N that stays."""
    climb = np.clip((TIME_S - 1.0) * 40.0, 0.0, None)
    for one_s in at_s:
        at = since(one_s)
        swing = np.exp(-at / decay_s) * np.cos(2.0 * np.pi * ring_Hz * at)
        climb -= (one_s <= TIME_S) * (taken_N + (dip_N - taken_N) * swing)
    top = int(np.argmax(climb >= 100.0))
    climb[top:] = 45.0
    return climb


@pytest.mark.parametrize(
    ("taken_N", "dip_N", "ring_Hz"),
    [
        (2.0, 45.0, 0.0),
        (5.0, 30.0, 0.0),
        (6.0, 60.0, 0.0),
        (8.0, 50.0, 0.0),
        (2.0, 45.0, 40.0),
        (4.0, 60.0, 20.0),
    ],
)
def test_a_partial_slip_is_what_it_takes_however_deep_it_swings(taken_N, dip_N, ring_Hz):
    force = dips(taken_N=taken_N, dip_N=dip_N, ring_Hz=ring_Hz)
    found = picked(force + drawn((0.0, 0.0), (8.0, 0.0)))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.005)
    partial = [event for event in found.events if event.kind == "partial-slip"]
    assert len(partial) + sum(event.kind == "bump" for event in found.events) >= 2


def test_teeth_that_spring_back_are_teeth():
    """A train whose force grows: every slip swings far down, and back; the first is the break-away."""
    force, at_s, top_N = np.clip((TIME_S - 0.5) * 60.0, 0.0, None), 0.5 + 100.0 / 60.0, 100.0
    while at_s < 8.0:
        at = since(at_s)
        force = np.where(at_s <= TIME_S, top_N - 12.0 + 60.0 * at - 25.0 * np.exp(-at / 0.004), force)
        top_N += 2.0
        at_s += 14.0 / 60.0
    found = picked(force + drawn((0.0, 0.0), (8.0, 0.0)))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.005)


# --- a snag that swings ---


@pytest.mark.parametrize("ring_Hz", [25.0, 35.0])
def test_a_snag_after_which_the_climb_goes_on_along_its_line_took_nothing(ring_Hz):
    """It rises twice as fast as the machine loads, lets go and swings about the line; the line itself is not left."""
    line = np.clip((TIME_S - 1.0) * 50.0, 0.0, 100.0)
    top = int(np.argmax(line >= 100.0))
    line[top:] = 62.0
    gone = since(2.0)
    snag = np.where(TIME_S < 2.0, np.clip((TIME_S - 1.6) * 60.0, 0.0, None), 0.0)
    snag += (TIME_S >= 2.0) * 24.0 * np.exp(-gone / 0.03) * np.cos(2.0 * np.pi * ring_Hz * gone)
    found = picked(line + snag + drawn((0.0, 0.0), (8.0, 0.0)))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.005)


# --- falls ---


@pytest.mark.parametrize("times", [7.0, 10.0])
@pytest.mark.parametrize("share", [0.3, 0.45])
def test_a_fall_that_dies_away_far_faster_than_it_was_loaded_has_slid(share, times):
    """No motor lets down so fast and little by little; along a line it might, and that stays in doubt."""
    drop_N = 100.0 * (1.0 - share)
    fall_s = drop_N / (times * 50.0)
    at, top = since(3.0), (TIME_S < 3.0)
    climb = np.clip((TIME_S - 1.0) * 50.0, 0.0, 100.0)
    slips = np.where(top, climb, 100.0 - drop_N * (1.0 - np.exp(-3.0 * at / fall_s)))
    found = picked(slips + drawn((0.0, 0.0), (8.0, 0.0)))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.015)
    let_down = drawn(
        (0.0, 0.0), (1.0, 0.0), (3.0, 100.0), (3.0 + fall_s, 100.0 - drop_N), (8.0, 100.0 - drop_N)
    )
    assert picked(let_down).status is not Status.OK


def test_a_moment_at_the_top_before_a_fast_fall_is_a_slip_that_begins_slowly():
    """Of a fall by a third within a twentieth of the time of loading, the machine would have loaded on by a tenth."""
    found = picked(drawn((0.0, 0.0), (1.0, 0.0), (3.0, 100.0), (3.06, 100.0), (3.12, 65.0), (8.0, 65.0)))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.005)
    held = drawn((0.0, 0.0), (1.0, 0.0), (3.0, 100.0), (3.4, 100.0), (3.46, 65.0), (8.0, 65.0))
    assert picked(held).status is not Status.OK


@pytest.mark.parametrize(("drop_N", "status"), [(5.0, Status.DOUBTFUL), (15.0, Status.OK)])
def test_a_held_rope_creeps_by_some_per_cent_however_slowly_the_motor_stopped(drop_N, status):
    """The force bends to its largest and dies away within seconds: a motor that stops, or sliding that weakens."""
    at, stopped = since(1.0), since(2.2)
    climb = 100.0 * np.minimum(at / 0.8, 1.0 - 0.25 * np.exp(-since(1.6) / 0.2)) * (TIME_S < 2.2)
    after = (TIME_S >= 2.2) * (100.0 - drop_N * (1.0 - np.exp(-stopped / 1.0)))
    found = picked(climb + after + drawn((0.0, 0.0), (8.0, 0.0)))
    assert found.status is status, found.detail


def test_an_impact_higher_than_the_pull_that_comes_back_to_nothing_was_struck():
    """However fast the machine loads: nothing slips down to nothing and swings there."""
    blow = since(1.5)
    force = np.interp(TIME_S, (1.3, 2.1, 2.101), (0.0, 100.0, 78.0))
    force += (TIME_S >= 1.5) * 110.0 * np.exp(-blow / 0.04) * np.sin(2.0 * np.pi * 75.0 * blow)
    found = picked(force + drawn((0.0, 0.0), (8.0, 0.0)))
    assert found.status is not Status.OK or found.peak_N == pytest.approx(100.0, rel=0.01), found.peak_N


def test_a_force_that_wears_in_slowly_after_a_rounded_top_does_not_swing():
    """It comes back to the level of sliding in seconds, and fell to it within a tenth of one."""
    at = since(3.0)
    climb = np.minimum((TIME_S - 1.0) * 50.0, 100.0 - 16.0 * (1.0 - np.exp(-((at / 0.04) ** 2))) + 0.9 * at)
    found = picked(np.clip(climb, 0.0, None) + drawn((0.0, 0.0), (8.0, 0.0), noise_N=0.4))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.01)


def test_a_slip_that_swings_to_nothing_and_stays_loaded_was_not_off():
    """The second of two pulls is lower: what slid after the first for as long as it was loaded was no snag."""
    force = np.interp(TIME_S, (0.5, 1.0, 1.001, 2.2, 2.3), (0.0, 100.0, 35.0, 35.0, 0.0))
    at = since(1.001)
    force -= (TIME_S > 1.0) * 60.0 * np.exp(-at / 0.008) * np.cos(2.0 * np.pi * 30.0 * at)
    force += np.interp(TIME_S, (6.0, 6.4, 6.401, 7.2, 7.3), (0.0, 80.0, 40.0, 40.0, 0.0))
    found = picked(force + drawn((0.0, 0.0), (8.0, 0.0)))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.01)


# --- the zero ---


def test_a_zero_that_falls_far_below_nothing_in_two_jumps_is_in_doubt():
    """Each jump is small enough to be one of the zero, both together are what a machine that pushes may leave."""
    zero = -25.0 * (TIME_S > 0.4) - 25.0 * (TIME_S > 0.8)
    found = picked(zero + drawn((0.0, 0.0), (1.2, 0.0), (3.0, 190.0), (3.004, 130.0), (8.0, 130.0)))
    assert found.status is Status.DOUBTFUL, found.peak_N
    assert [one.force_N for one in found.candidates] == pytest.approx([190.0, 140.0], rel=0.005)


def test_a_large_level_at_rest_is_said_to_count_as_a_pretension():
    """No recording in newtons tells one from an error of the zero; a person does."""
    force = drawn((0.0, 20.0), (1.0, 20.0), (3.0, 100.0), (3.004, 70.0), (8.0, 70.0))
    found = picked(force)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.005)
    assert any("counts as a pretension" in note and 'rest = "zero"' in note for note in found.notes)
    told = picked(force, PickSettings(rest="zero"))
    assert told.peak_N == pytest.approx(80.0, rel=0.005)
    assert not any("pretension" in note for note in picked(force, PickSettings(rest="pretension")).notes)


@pytest.mark.parametrize("rest_s", [0.15, 0.3])
def test_a_short_rest_and_the_same_level_at_the_end_exclude_a_drift(rest_s):
    """The force of sliding may be less than half of the peak."""
    time_s = np.arange(0.0, 24.0, 0.002)
    corners = [(0.0, 0.0), (rest_s, 0.0), (8.0, 100.0), (8.004, 40.0), (16.0, 40.0), (17.0, 0.0)]
    found = picked(drawn(*corners, (24.0, 0.0), time_s=time_s), time_s=time_s)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.005)
    # Where the level differs, it may have drifted.
    drifts_N = np.interp(time_s, (0.0, 17.0), (0.0, 6.0))
    again = picked(drawn(*corners, (24.0, 0.0), time_s=time_s) + drifts_N, time_s=time_s)
    assert again.status is not Status.OK or abs(again.peak_N - 100.0) < 2.0 * again.peak_std_N


def test_a_pretension_that_creeps_at_rest_is_no_drift_where_the_level_comes_back():
    time_s = np.arange(0.0, 14.0, 0.002)
    corners = [
        (0.0, 0.0),
        (1.0, 0.0),
        (1.1, 18.0),
        (4.0, 16.5),
        (6.0, 100.0),
        (6.01, 70.0),
        (9.0, 70.0),
        (10.0, 0.0),
    ]
    found = picked(drawn(*corners, (14.0, 0.0), time_s=time_s), time_s=time_s)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.005)
