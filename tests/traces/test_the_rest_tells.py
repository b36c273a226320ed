"""What the rest of a recording tells of a pull: rests and pulls after it, jumps of the zero before it, gaps in it."""

import numpy as np
import pytest
from drawing import Drawing

from ropefric.traces.breakaway import Status

TIME_S = np.arange(0.0, 12.0, 0.002)
DRAWING = Drawing(TIME_S, seed=7)
drawn, picked, since = DRAWING.drawn, DRAWING.picked, DRAWING.since


def strokes(*begins_s, load_s=2.0, slid_s=1.0, top_N=100.0, kinetic_N=70.0):
    """Return the corners of pulls that break away, slide and are let down."""
    corners = [(0.0, 0.0)]
    for at_s in begins_s:
        slips_s = at_s + load_s
        corners += [(at_s, 0.0), (slips_s, top_N), (slips_s + 0.004, kinetic_N)]
        corners += [(slips_s + slid_s, kinetic_N), (slips_s + slid_s + 0.2, 0.0)]
    return corners


# --- a fall by what swings after it ---


@pytest.mark.parametrize("part", [0.3, 0.4, 0.5])
@pytest.mark.parametrize("period_s", [0.06, 0.1, 0.2])
def test_a_slip_that_rings_on_stands_out_however_far_it_rings(period_s, part):
    """None of its swings comes near the top again, though the scatter of what slides is a quarter of the fall."""
    slides = 45.0 + 55.0 * part * np.cos(2.0 * np.pi * since(4.0) / period_s)
    force = np.where(TIME_S < 4.0, drawn((1.0, 0.0), (4.0, 100.0), noise_N=0.0), slides) + drawn((0.0, 0.0))
    found = picked(force[TIME_S < 4.5], time_s=TIME_S[TIME_S < 4.5])
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.01)


@pytest.mark.parametrize("again_N", [12.0, 25.0, 60.0])
def test_a_slip_to_nothing_after_which_the_machine_loads_on_is_one(again_N):
    """The motor had not stopped, whatever was told; it was let down before the rope slipped again."""
    lasts_s = again_N / 20.0
    ends = (
        (6.01 + lasts_s, again_N + 2.0),
        (6.6 + lasts_s, again_N + 2.0),
        (7.0 + lasts_s, 0.0),
        (12.0, 0.0),
    )
    found = picked(drawn((0.0, 0.0), (1.0, 0.0), (6.0, 100.0), (6.01, 2.0), *ends, noise_N=0.2))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.01)


@pytest.mark.parametrize("ends", [((6.01, 2.0), (12.0, 2.0)), ((8.0, 2.0), (9.0, 22.0), (12.0, 22.0))])
def test_what_nobody_loads_on_or_was_let_down_slowly_is_none(ends):
    """The rope is off, or the motor went back and forth."""
    found = picked(drawn((0.0, 0.0), (1.0, 0.0), (6.0, 100.0), *ends, noise_N=0.2))
    assert found.status is not Status.OK
    assert np.isnan(found.peak_N)


# --- the zero ---


@pytest.mark.parametrize("phase", np.arange(8) * np.pi / 4)
def test_what_a_brief_rest_shows_is_no_drift_where_the_rope_rests_as_at_first_between_pulls(phase):
    """A slow wave of half a percent reads like a drift; the end of the recording lies within the last pull."""
    wave = 0.6 * np.sin(2.0 * np.pi * 1.5 * TIME_S + phase)
    found = picked(drawn(*strokes(0.2, 6.0)[:-2], noise_N=0.1) + wave)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, abs=1.0)


def test_what_slips_to_nothing_for_a_moment_is_no_rest():
    """Its level would say that the zero is back, while it drifts on."""
    force = drawn((0.0, 0.0), (5.0, 0.0), (7.0, 96.0), (7.01, -4.0), (7.03, -4.0), (7.6, 66.0), (12.0, 66.0))
    found = picked(force + 0.6 * TIME_S)
    assert found.status is Status.DOUBTFUL or found.peak_N == pytest.approx(96.0, rel=0.02)


@pytest.mark.parametrize("drift_N", [1.5, 2.5])
def test_a_drift_at_rest_that_is_gone_later_is_not_taken_off(drift_N):
    """A tension that settles while the rope rests reads like a zero that drifts."""
    settles = drift_N * np.exp(-TIME_S / 0.3) * (TIME_S < 1.0)
    found = picked(drawn(*strokes(1.0, slid_s=4.0), (12.0, 0.0), noise_N=0.02) + settles)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.005)
    assert "taken off" not in " ".join(found.notes)


@pytest.mark.parametrize("slope_N_s", [-3.0, 2.0, 4.0])
@pytest.mark.parametrize("rest_s", [0.16, 0.19])
def test_what_slopes_within_a_fifth_of_a_second_is_no_drift(slope_N_s, rest_s):
    """It would come to several percent at the peak; a recording that begins within the climb shows no rest at all.

    Sliding, here one that gets easier, does not tell.
    """
    settles = slope_N_s * np.minimum(TIME_S - rest_s, 0.0)
    slides = ((rest_s + 2.0, 100.0), (rest_s + 2.004, 75.0), (7.0, 62.0), (12.0, 55.0))
    found = picked(drawn((0.0, 0.0), (rest_s, 0.0), *slides, noise_N=0.05) + settles)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.01)


@pytest.mark.parametrize("jump_N", [3.0, 6.0])
@pytest.mark.parametrize("load_s", [0.4, 2.0])
def test_a_jump_at_rest_is_told_however_fast_the_rope_is_loaded(jump_N, load_s):
    """A climb that begins rises by more within as many blocks, and is not it."""
    rest = drawn(*strokes(1.0, load_s=load_s), noise_N=0.3)
    found = picked(rest + jump_N * (TIME_S > 0.5))
    assert found.status is Status.DOUBTFUL, found.peak_N
    assert "jumps" in found.detail
    assert len(found.candidates) == 2
    assert found.candidates[1].force_N == pytest.approx(100.0, rel=0.01)


@pytest.mark.parametrize("seed", range(8))
def test_a_slow_start_is_no_jump(seed):
    """Of the noise the largest step between two samples lies somewhere, and a line is no step."""
    soft = ((0.0, 0.0), (0.6, 0.0), (1.2, 8.0), (3.0, 100.0), (3.004, 70.0), (12.0, 70.0))
    found = picked(drawn(*soft, noise_N=0.5, seed=seed))
    assert found.status is Status.OK, found.detail


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("jump_N", [3.0, 5.0])
def test_a_jump_smaller_than_the_noise_is_told_by_its_levels(jump_N, seed):
    """No single step of the samples is as large, but where the level changes is known to one or two of them."""
    force = drawn(*strokes(2.0, slid_s=8.0), noise_N=1.0, seed=seed)
    found = picked(force + jump_N * (TIME_S > 1.0))
    assert found.status is Status.DOUBTFUL, found.peak_N
    assert "jumps" in found.detail
    assert found.candidates[1].force_N == pytest.approx(100.0, rel=0.02)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("lasts_s", [0.16, 0.4])
def test_a_load_that_comes_on_within_the_noise_is_no_jump(lasts_s, seed):
    """It takes a time that the noise does not hide."""
    force = drawn(*strokes(2.0, slid_s=8.0), noise_N=1.0, seed=seed)
    found = picked(force + 5.0 * np.clip((TIME_S - 1.0) / lasts_s, 0.0, 1.0))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(105.0, rel=0.01)


@pytest.mark.parametrize("seed", range(8))
def test_a_zero_that_wanders_is_not_the_lowest_that_it_reads(seed):
    """Within a percent below nothing it stands for a while at one, for a while at another level."""
    wanders = np.interp(TIME_S, [0.8, 0.9, 1.1, 1.2], [-0.3, -1.7, -1.7, -0.3])
    found = picked(drawn(*strokes(3.0, slid_s=6.0), noise_N=0.3, seed=seed) + wanders)
    assert found.status is Status.OK, found.detail
    assert abs(found.peak_N - 100.0) < 2.0 * found.peak_std_N
    assert found.peak_N == pytest.approx(100.0, rel=0.01)


@pytest.mark.parametrize("jump_N", [3.0, 8.0])
def test_what_jumps_up_from_less_than_nothing_is_no_load_either(jump_N):
    """The lowest level was taken off, and the jump counted as force."""
    low = np.where(TIME_S > 1.5, jump_N - 12.0, -12.0)
    found = picked(drawn(*strokes(3.0, slid_s=6.0), noise_N=0.3) + low)
    assert found.status is Status.DOUBTFUL, found.peak_N
    assert found.candidates[1].force_N == pytest.approx(100.0, rel=0.01)


@pytest.mark.parametrize("slope_N_s", [-0.4, 0.4, 0.6])
@pytest.mark.parametrize("rest_s", [4.0, 6.0])
def test_a_drift_counts_from_the_first_sample_where_that_is_at_zero(slope_N_s, rest_s):
    """What it came to by the middle of the rest stayed in F_A: half of what it came to until the climb."""
    found = picked(drawn(*strokes(rest_s), noise_N=0.1) + slope_N_s * TIME_S)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, abs=0.5)


# --- a pull by those after it ---


@pytest.mark.parametrize("top_N", [90.0, 97.0])
def test_a_snag_that_drags_before_it_lets_go_is_none_where_the_rope_slides_later(top_N):
    """It slides, as far as one sees, at half of what the rope slides at."""
    drags = ((0.5, 0.0), (1.5, top_N), (1.51, 0.4 * top_N), (2.2, 0.45 * top_N), (2.3, 0.0), (3.0, 0.0))
    train = [(5.0 + 0.3 * k + dt, force) for k in range(20) for dt, force in ((0.0, 100.0), (0.01, 70.0))]
    found = picked(drawn((0.0, 0.0), *drags, *train, noise_N=0.2))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.01)
    assert found.peak_time_s == pytest.approx(5.0, abs=0.05)


def test_a_pull_that_slides_as_later_ones_do_stays_the_first():
    """The rope that is pulled again slides at much the same force, also from a somewhat higher peak."""
    found = picked(
        drawn(*strokes(0.5), *strokes(5.5, top_N=112.0, kinetic_N=78.0)[1:], (12.0, 0.0), noise_N=0.2)
    )
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.01)


@pytest.mark.parametrize("times", [3.0, 8.0])
def test_a_slip_to_nothing_that_is_loaded_again_to_a_train_broke_away(times):
    """A motor lets a load down so fast as well; but the rope slides later at less than it had held."""
    down_s = 2.0 / times
    waves = [(3.9 + down_s + 0.25 * k, 60.0 if k % 2 else 40.0) for k in range(1, 24)]
    corners = ((0.0, 0.0), (0.8, 0.0), (2.8, 100.0), (2.8 + down_s, 0.0), (3.0 + down_s, 0.0))
    found = picked(drawn(*corners, (3.9 + down_s, 45.0), *waves, noise_N=0.2))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.01)


def test_a_load_that_is_let_down_and_raised_higher_had_not_slipped():
    """What the rope holds later, it had held before."""
    first = ((0.8, 0.0), (2.8, 100.0), (3.4, 0.0), (3.6, 0.0))
    found = picked(drawn((0.0, 0.0), *first, (6.0, 120.0), (6.01, 90.0), (12.0, 90.0), noise_N=0.2))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(120.0, rel=0.01)


# --- what follows at once ---


def swinging(times, damping=0.6):
    """Return a force that slips at so many times the rate of its loading, and swings around where it slides."""
    t, loading_N_s = since(2.5), 100.0 / 1.7
    omega = np.pi * times * loading_N_s / 70.0
    climb = drawn((0.0, 0.0), (0.8, 0.0), (2.5, 100.0), (12.0, 100.0), noise_N=0.1)
    return climb - (38.0 - 38.0 * np.cos(omega * t) * np.exp(-damping * t))


@pytest.mark.parametrize("times", [3.0, 4.5])
def test_a_slip_that_swings_on_around_its_sliding_is_seen_by_its_mean(times):
    """At the bottom of its first swing hardly a third of the load is left."""
    found = picked(swinging(times))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.01)


@pytest.mark.parametrize("period_s", [2.4, 3.6])
def test_waves_as_long_as_the_climb_are_no_swing_of_a_machine_that_stops(period_s):
    """It would have swung while it was loaded; a rope that slides may fall and rise as slowly."""
    t = since(2.5)
    waves = 12.0 * (1.0 - np.exp(-2.0 * t / period_s) * np.cos(2.0 * np.pi * t / period_s))
    climb = drawn((0.0, 0.0), (0.8, 0.0), (2.4, 99.0), (2.5, 100.0), (12.0, 100.0), noise_N=0.1)
    found = picked(climb - waves)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.01)


def test_what_is_let_back_and_pulled_again_later_is_not():
    """No faster than it was loaded, to a level at which it rests before it is loaded on: a snag, or the motor."""
    found = picked(
        drawn(
            *((0.0, 0.0), (0.8, 0.0), (1.1, 100.0), (1.38, 48.0), (3.0, 48.0), (4.0, 80.0)),
            *[(4.0 + 0.2 * k + dt, force) for k in range(1, 30) for dt, force in ((0.0, 80.0), (0.01, 72.0))],
            noise_N=0.1,
        )
    )
    assert found.status is not Status.OK or found.peak_N == pytest.approx(80.0, rel=0.02)


def test_a_long_rest_before_it_is_no_part_of_the_climb():
    """What slides for twice as long as it was loaded slides for long, whenever the recording began."""
    time_s = np.arange(0.0, 40.0, 0.002)
    force = drawn(
        (0.0, 0.0),
        (30.0, 0.0),
        (31.0, 100.0),
        (31.04, 46.0),
        (33.0, 52.0),
        (33.2, 0.0),
        (40.0, 0.0),
        time_s=time_s,
    )
    ring = 8.0 * np.sin(40.0 * since(31.04, time_s)) * np.exp(-4.0 * since(31.04, time_s)) * (time_s < 33.0)
    found = picked(force + ring, time_s=time_s)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.01)


@pytest.mark.parametrize("left", [3, 5])
def test_samples_between_a_gap_and_a_slip_are_no_spike(left):
    """What was left out while it was loaded ended just before it slipped."""
    time_s = np.arange(0.0, 12.0, 0.007)
    teeth = [(4.0 + k + dt, force) for k in range(8) for dt, force in ((0.0, 80.0), (0.01, 40.0))]
    force = drawn((0.0, 0.0), (0.5, 0.0), (3.0, 100.0), (3.007, 30.0), *teeth, time_s=time_s)
    last = int(np.searchsorted(time_s, 3.0))
    keep = (time_s < 1.9) | (np.arange(time_s.size) > last - left)
    found = picked(force[keep], time_s=time_s[keep])
    assert found.status is not Status.OK or found.peak_N == pytest.approx(100.0, rel=0.02)
    assert not any("spike" in note for note in found.notes)


@pytest.mark.parametrize("seed", range(8))
def test_a_gap_soon_after_the_highest_of_noisy_samples_may_hide_the_top(seed):
    """Within it the force climbs by 4 % and slips."""
    force = drawn((0.0, 0.0), (1.0, 0.0), (6.0, 100.0), (6.01, 70.0), (12.0, 70.0), noise_N=0.5, seed=seed)
    keep = (TIME_S < 5.8) | (TIME_S > 6.1)
    found = picked(force[keep], time_s=TIME_S[keep])
    assert found.status is Status.DOUBTFUL, found.peak_N
    assert "gap" in found.detail
    assert found.candidates[-1].force_N == pytest.approx(100.0, rel=0.04)


def test_a_load_that_goes_at_once_while_the_rope_rests_is_no_jump_of_the_zero():
    """It reads as at first again."""
    hooked = np.interp(TIME_S, [0.4, 0.6, 0.9, 0.9005], [0.0, 9.0, 9.0, 0.0])
    found = picked(drawn(*strokes(2.0), noise_N=0.1) + hooked)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.01)
