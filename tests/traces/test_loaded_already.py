"""Recordings that begin under load, falls that a motor makes, and partial slips as large as full ones."""

import numpy as np
import pytest
from drawing import loaded

from ropefric.traces.breakaway import PickSettings, Status
from ropefric.traces.decision import pick_breakaway
from ropefric.traces.segments import upright
from ropefric.traces.trace import ForceTrace

TIME_S = np.arange(0.0, 6.0, 0.001)


def drawn(*corners, noise_N=0.1):
    """Return the force along a line through corners (time, force), with noise."""
    noise = np.random.default_rng(7).normal(0.0, noise_N, TIME_S.size)
    return np.interp(TIME_S, *zip(*corners, strict=True)) + noise


def train(*teeth, climb=60.0, noise_N=0.1):
    """Return the force of teeth (top, drop) that are all loaded at one rate [N/s], and the level they end at."""
    falls = ((top_N, top_N - drop_N) for top_N, drop_N in teeth)
    return drawn(*loaded(*falls, rate_N_s=climb), noise_N=noise_N)


def picked(force_N, *, since_s=0.0, **settings):
    seen = since_s <= TIME_S
    trace = ForceTrace(time_s=TIME_S[seen], force_N=force_N[seen])
    return pick_breakaway(trace, PickSettings(**settings))[0]


@pytest.mark.parametrize("end_N", [35.0, 0.0])
@pytest.mark.parametrize("since_s", [0.0, 1.0, 1.4])
def test_a_recording_may_begin_within_the_climb_and_fall_below_where_it_began(since_s, end_N):
    """No motor that stopped: what the rope was loaded from lies before the recording."""
    slip = ((2.3, 100.0), (2.304, 35.0), (4.5, 35.0), (5.5, end_N))
    found = picked(drawn((0.0, 0.0), (0.3, 0.0), *slip, (6.0, end_N)), since_s=since_s)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.01)


@pytest.mark.parametrize("since_s", [0.0, 1.0, 1.8])
def test_a_reversed_recording_may_begin_within_the_climb_too(since_s):
    force = drawn((0.0, 0.0), (0.3, 0.0), (2.3, 100.0), (2.304, 35.0), (4.5, 35.0), (5.5, 0.0), (6.0, 0.0))
    seen = since_s <= TIME_S
    turned, said = upright(ForceTrace(time_s=TIME_S[seen], force_N=-force[seen]))
    assert "sign is taken as reversed" in said
    assert np.array_equal(turned.force_N, force[seen])
    # The other way round, and with a zero that is off, nothing is turned.
    for way in (force, force - 150.0):
        assert upright(ForceTrace(time_s=TIME_S[seen], force_N=way[seen]))[1] == ""


def test_a_climb_no_longer_than_those_of_later_teeth_may_be_one_of_them():
    force = train(*[(100.0, 40.0)] * 6)
    assert picked(force).peak_N == pytest.approx(100.0, rel=0.01)
    found = picked(force, since_s=2.1)  # after the first slip
    assert found.status is Status.DOUBTFUL, found.detail
    assert found.candidates[0].force_N == pytest.approx(100.0, rel=0.01)
    # Half as long again, it is the first one.
    assert picked(force, since_s=0.95).status is Status.OK


def test_a_climb_from_the_first_sample_on_is_no_rest_before_a_bump():
    since = np.maximum(TIME_S - 1.9, 0.0)
    waves = 0.4 * np.sin(2.0 * np.pi * 3.0 * since)
    corners = ((0.0, 37.0), (1.3, 37.0), (1.65, 60.0), (1.75, 52.0), (1.9, 39.5), (6.0, 39.5))
    found = picked(drawn(*corners, noise_N=0.02) + waves, since_s=1.3)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(60.0, rel=0.01)


@pytest.mark.parametrize(
    ("lsb_N", "end_N", "fall_s"), [(0.1, 22.0, 2.0), (0.18, 24.0, 0.9), (0.25, 19.5, 2.0)]
)
def test_a_slow_fall_that_halts_on_a_step_of_the_converter_goes_on(lsb_N, end_N, fall_s):
    """Nothing is held there."""
    force = drawn((0.0, 0.0), (0.5, 0.0), (2.0, 30.0), (2.0 + fall_s, end_N), (6.0, end_N), noise_N=0.01)
    found = picked(np.rint(force / lsb_N) * lsb_N)
    assert found.status is Status.DOUBTFUL, found.detail
    assert found.candidates[0].force_N == pytest.approx(30.0, rel=0.01)
    assert found.candidates[0].drop_N == pytest.approx(30.0 - end_N, rel=0.05)


@pytest.mark.parametrize("seen_s", [0.03, 0.05, 0.1, 0.3])
def test_what_falls_far_faster_than_it_was_loaded_is_no_held_load_for_certain(seen_s):
    """After a moment at its top, to a level that is seen for so long."""
    force = drawn((0.0, 0.0), (0.3, 0.0), (2.3, 100.0), (2.38, 100.0), (2.41, 80.0), (6.0, 80.0), noise_N=0.2)
    found = picked(np.where(2.41 + seen_s >= TIME_S, force, np.nan))
    assert found.status is Status.DOUBTFUL, found.detail
    assert found.candidates[0].force_N == pytest.approx(100.0, rel=0.01)


JOG = ((0.0, 0.0), (0.3, 0.0), (0.32, 30.0), (0.6, 30.0))


@pytest.mark.parametrize("left_N", [28.0, 34.0])
def test_a_jog_from_a_pretension_and_back_is_no_breakaway_for_certain(left_N):
    """Far down, and as fast as a motor goes; then the pull."""
    jog = ((1.3, 75.0), (1.9, left_N), (2.4, left_N))
    found = picked(drawn(*JOG, *jog, (4.2, 100.0), (4.204, 80.0), (6.0, 80.0)))
    if found.status is Status.OK:
        assert found.peak_N == pytest.approx(100.0, rel=0.01)
    else:
        assert found.status is Status.DOUBTFUL, found.detail


def test_a_load_that_is_held_and_creeps_before_a_far_higher_pull_has_not_slipped():
    held = ((1.0, 75.0), (1.02, 74.0), (2.0, 73.5), (2.1, 0.0), (2.6, 0.0))
    ripple = 0.5 * np.sin(2.0 * np.pi * 7.0 * TIME_S) * ((TIME_S > 1.0) & (TIME_S < 2.0))
    found = picked(drawn((0.0, 0.0), (0.3, 0.0), *held, (3.6, 100.0), (3.604, 70.0), (6.0, 70.0)) + ripple)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.01)


@pytest.mark.parametrize(("left_N", "rest", "peak_N"), [
    (-1.0, "", 100.0), (-6.0, "", None), (-6.0, "zero", 106.0), (-6.0, "pretension", 100.0)
])  # fmt: skip
def test_what_a_jog_leaves_below_nothing_is_no_zero_for_certain(left_N, rest, peak_N):
    """Tared with the weights hung on, a rope that is let back may pull less than at first."""
    jog = ((1.1, 60.0), (1.6, left_N), (2.6, left_N))
    force = drawn((0.0, 0.0), (0.6, 0.0), *jog, (4.2, 100.0), (4.204, 80.0), (6.0, 80.0))
    found = picked(force, **({"rest": rest} if rest else {}))
    if peak_N is None:
        assert found.status is Status.DOUBTFUL
        assert [event.force_N for event in found.candidates] == pytest.approx([100.0, 106.0], rel=0.01)
    else:
        assert found.status is Status.OK, found.detail
        assert found.peak_N == pytest.approx(peak_N, rel=0.005)


def test_an_impact_higher_than_the_climb_it_falls_into_is_no_breakaway():
    since = TIME_S - 2.2
    knock = 150.0 * np.sin(np.pi * np.clip(since / 0.024, 0.0, 1.0))
    swing = (
        40.0 * np.exp(-np.maximum(since, 0.0) / 0.03) * np.sin(2.0 * np.pi * 30.0 * since) * (since > 0.024)
    )
    found = picked(drawn((0.0, 0.0), (1.0, 0.0), (3.0, 100.0), (3.004, 70.0), (6.0, 70.0)) + knock - swing)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.01)


@pytest.mark.parametrize("lasts_s", [0.05, 0.12])
def test_what_rises_far_faster_than_a_later_pull_and_is_soon_over_is_a_bump(lasts_s):
    top = ((0.05, 0.0), (0.09, 70.0), (0.1, 64.0), (0.1 + lasts_s, 64.0), (0.14 + lasts_s, 0.0), (1.2, 0.0))
    found = picked(drawn((0.0, 0.0), *top, (3.2, 100.0), (3.204, 70.0), (6.0, 70.0)))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.01)


def test_a_large_slip_after_which_the_force_grows_by_nearly_as_much_again_was_partial():
    """Loaded on along the machine's line: what has slipped in full is no stronger by so much."""
    found = picked(train((50.0, 12.0), (97.0, 25.0), (82.0, 12.0), (80.0, 10.0), (79.0, 9.0)))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(97.0, rel=0.01)


def test_a_slip_as_large_as_those_of_an_even_train_far_above_it_is_partial_below_one_that_grows_it_is_full():
    even = picked(train((75.0, 13.0), *[(100.0, 15.0)] * 6))
    assert even.status is Status.OK, even.detail
    assert even.peak_N == pytest.approx(100.0, rel=0.01)
    assert even.events[0].kind == "partial-slip"
    growing = picked(train((75.0, 13.0), *[(100.0 - 25.0 * 0.7**k, 15.0) for k in range(1, 8)]))
    assert growing.peak_N == pytest.approx(75.0, rel=0.01)


def test_two_small_slips_close_together_are_partial_below_a_train():
    """The second from hardly less than the first: that has not weakened the rope."""
    found = picked(train((58.0, 3.4), (57.0, 2.5), (62.0, 2.0), (64.0, 5.0), *[(100.0, 14.0)] * 6))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.01)


@pytest.mark.parametrize("top_N", [92.0, 94.0])
@pytest.mark.parametrize(("part", "half_s"), [(0.3, 0.012), (0.45, 0.012), (0.45, 0.016)])
def test_a_swing_half_as_large_right_after_a_partial_slip_is_no_slip_again(top_N, part, half_s):
    """However slowly it swings."""
    low_s, low_N = 0.068 + top_N / 50.0, top_N - 2.0
    back_N, again_N = low_N + 1.8 * part, low_N - 0.2 * part
    ring = ((low_s - 0.008, top_N), (low_s, low_N), (low_s + half_s, back_N), (low_s + 2.0 * half_s, again_N))
    top_s = low_s + 2.0 * half_s + (100.0 - again_N) / 50.0
    corners = ((0.0, 0.0), (0.06, 0.0), *ring, (top_s, 100.0), (top_s + 0.05, 82.0), (6.0, 82.0))
    found = picked(drawn(*corners, noise_N=0.02))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.01)
    assert found.events[0].kind == "partial-slip"
