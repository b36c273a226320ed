"""Ropes that give way little by little, slip to nothing or go on to harden, and what only looks like it."""

import numpy as np
import pytest
from drawing import Drawing

from ropefric.traces.breakaway import Status

TIME_S = np.arange(0.0, 16.0, 0.002)
DRAWING = Drawing(TIME_S, seed=5)
drawn, picked, since = DRAWING.drawn, DRAWING.picked, DRAWING.since


def let_down(force_N, at_s, lasts_s=0.3, time_s=TIME_S):
    """Return a force that is let down to nothing from a moment on."""
    return force_N * np.clip((at_s + lasts_s - time_s) / lasts_s, 0.0, 1.0)


# --- what gives way until it is let down ---


@pytest.mark.parametrize("part", [0.25, 0.35])
@pytest.mark.parametrize("tau_s", [2.5, 4.0])
def test_a_rope_that_gives_way_until_it_is_let_down_has_slid(part, tau_s):
    """It falls more and more slowly, by more than a held rope creeps, and comes to no level before it is let down."""
    force = drawn((0.0, 0.0), (1.0, 0.0), (4.0, 100.0), (16.0, 100.0), noise_N=0.0)
    weaker = 100.0 * part * (1.0 - np.exp(-since(4.0) / tau_s)) / (1.0 - np.exp(-8.0 / tau_s))
    found = picked(let_down(force - weaker, 12.0) + drawn((0.0, 0.0), (16.0, 0.0)))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.005)


@pytest.mark.parametrize("shape", ["creeps", "is let back"])
def test_what_creeps_by_a_tenth_or_is_let_back_evenly_gives_no_force(shape):
    """A held rope creeps by less; a motor that goes back slowly, and then fast, does not slow down in between."""
    force = drawn((0.0, 0.0), (1.0, 0.0), (4.0, 100.0), (16.0, 100.0), noise_N=0.0)
    down = 10.0 * (1.0 - np.exp(-since(4.0) / 3.0)) if shape == "creeps" else 30.0 * since(4.0) / 8.0
    found = picked(let_down(force - down, 12.0) + drawn((0.0, 0.0), (16.0, 0.0)))
    assert found.status is not Status.OK
    assert np.isnan(found.peak_N)


def test_a_held_rope_that_creeps_to_the_end_of_the_recording_gives_no_force():
    """It comes to its level as sliding does, but more slowly than it was loaded, and by little."""
    force = drawn((0.0, 0.0), (1.0, 0.0), (4.0, 100.0), (16.0, 100.0)) - 6.0 * (
        1.0 - np.exp(-since(4.0) / 1.2)
    )
    found = picked(force[: int(8.0 / 0.002)], time_s=TIME_S[: int(8.0 / 0.002)])
    assert found.status is not Status.OK
    assert np.isnan(found.peak_N)


@pytest.mark.parametrize("seed", range(4))
def test_ripples_on_a_slow_way_down_do_not_hide_the_peak(seed):
    """They part the fall, so that its first piece hardly stands out."""
    ripple = 0.6 * np.sin(2.0 * np.pi * 1.9 * TIME_S + seed) * (TIME_S > 4.3)
    force = drawn((0.0, 0.0), (1.0, 0.0), (4.0, 100.0), (16.0, 100.0), noise_N=0.05, seed=seed)
    found = picked(force - 20.0 * (1.0 - np.exp(-since(4.0) / 2.0)) + ripple)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.01)


@pytest.mark.parametrize("seed", range(12))
def test_what_wanders_without_a_peak_has_none_however_wide_one_looks(seed):
    """Its highest waves are small falls for the whole, and the motor lets it down by half from the last of them."""
    rng = np.random.default_rng(seed)
    at = since(3.6)
    waves = sum(
        rng.uniform(0.2, 1.0) * np.sin(2.0 * np.pi * f * at + rng.uniform(0.0, 6.28)) for f in (0.9, 1.7, 2.9)
    )
    climb = 100.0 * -np.expm1(-(np.clip(TIME_S - 1.0, 0.0, None) ** 3) / 6.0)
    force = (climb + waves * np.clip(at, 0.0, 1.0)) * (1.0 - 0.45 * np.clip((TIME_S - 9.0) / 0.2, 0.0, 1.0))
    found = picked(force + drawn((0.0, 0.0), (16.0, 0.0), seed=seed))
    assert np.isnan(found.peak_N), (found.peak_N, found.detail)


# --- what falls to nothing ---


def to_nothing(tops_N, rate_N_s=30.0, rests_s=0.2):
    """Return a force that is loaded again and again at one rate, and falls to nothing at once from every top."""
    corners, at_s = [(0.0, 0.0), (1.0, 0.0)], 1.0
    for top_N in tops_N:
        at_s += top_N / rate_N_s
        corners += [(at_s, top_N), (at_s + 0.004, 0.0), (at_s + rests_s, 0.0)]
        at_s += rests_s
    return drawn(*corners, (max(at_s + 1.0, 16.0), 0.0))


def test_a_slip_to_nothing_is_one_where_the_machine_loads_on_at_its_rate_to_the_next():
    found = picked(to_nothing([100.0, 75.0, 74.0, 76.0]))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.005)


@pytest.mark.parametrize("tops_N", [[100.0], [80.0, 100.0, 99.0]])
def test_what_comes_off_for_good_or_is_followed_by_a_higher_pull_is_no_slip(tops_N):
    """A rope that came off leaves nothing; one that hung on a snag is loaded to more after it."""
    found = picked(to_nothing(tops_N))
    assert found.status is not Status.OK or found.peak_N == pytest.approx(100.0, rel=0.005)
    assert len(tops_N) > 1 or np.isnan(found.peak_N)


@pytest.mark.parametrize("teeth", [True, False])
def test_what_falls_far_faster_than_it_was_loaded_and_slips_on_soon_has_slipped(teeth):
    """Fifty times faster, and it stays loaded; the level after it lasts for a moment only."""
    after = (
        [(x, y) for n in range(6) for x, y in ((4.45 + n * 0.4, 78.0), (4.455 + n * 0.4, 66.0))]
        if teeth
        else [(4.2, 85.0), (4.35, 75.0), (12.0, 75.0)]
    )
    corners = [(0.0, 0.0), (1.0, 0.0), (4.0, 100.0), (4.03, 86.0), (4.1, 86.0), *after]
    found = picked(drawn(*corners, (16.0, after[-1][1])))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.005)


def test_the_later_of_two_slips_alike_is_in_doubt_where_the_motor_stops_after_it():
    """The first may be the break-away, of a rope that hardens, or partial: no train that would tell follows."""
    corners = [
        (0.0, 0.0),
        (2.0, 0.0),
        (7.8, 75.8),
        (7.86, 67.6),
        (9.3, 84.3),
        (9.36, 73.1),
        (9.7, 77.5),
        (10.7, 77.5),
    ]
    found = picked(drawn(*corners, (12.2, 51.0), (16.0, 51.0)))
    assert found.status is Status.DOUBTFUL, found.peak_N


# --- tops ---


@pytest.mark.parametrize("wide_s", [0.4, 0.8])
def test_a_round_top_is_not_held(wide_s):
    """It bends all the way, from the slope of the climb to that of the fall; so does no motor that stops."""
    slope, down = 25.0, -60.0
    bend = np.clip((TIME_S - 5.0) / wide_s, 0.0, 1.0)
    rate = np.where(TIME_S < 1.0, 0.0, slope + (down - slope) * bend)
    force = np.cumsum(rate) * 0.002
    fallen = int(np.argmax((TIME_S > 5.0) & (force < 0.72 * force.max())))
    force[fallen:] = force[fallen] - 2.0 * (1.0 - np.exp(-since(TIME_S[fallen])[fallen:] / 0.05))
    found = picked(let_down(force, 12.0) + drawn((0.0, 0.0), (16.0, 0.0)))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(force.max(), rel=0.005)


@pytest.mark.parametrize("hold_s", [0.8, 1.5])
def test_a_top_with_two_corners_is_held(hold_s):
    corners = [(0.0, 0.0), (1.0, 0.0), (5.0, 100.0), (5.0 + hold_s, 100.0), (5.6 + hold_s, 72.0)]
    found = picked(drawn(*corners, (12.0, 72.0), (12.3, 0.0), (16.0, 0.0)))
    assert np.isnan(found.peak_N), found.peak_N


@pytest.mark.parametrize("rate_Hz", [200.0, 500.0, 1000.0])
def test_what_a_weight_adds_at_once_is_measured_at_its_own_rate(rate_Hz):
    """The weights before it stood for seconds: a window for their mean rate would smooth the last rise away."""
    time_s = np.arange(0.0, 14.0, 1.0 / rate_Hz)
    force = 18.0 * sum(np.clip((time_s - 1.5 * n) / 0.03, 0.0, 1.0) for n in range(1, 7))
    slips = time_s > 9.024
    force[slips] = 70.0 + (float(force[~slips].max()) - 70.0) * np.exp(-since(9.024, time_s)[slips] / 0.05)
    noise = np.random.default_rng(3).normal(0.0, 0.3, time_s.size)
    found = picked(force + noise, time_s=time_s)
    assert found.status is Status.OK, found.detail
    assert abs(found.peak_N - force.max()) < 2.5 * found.peak_std_N
    assert found.peak_N == pytest.approx(force.max(), rel=0.02)


# --- a first slip, a later one ---


@pytest.mark.parametrize("slid_N", [72.0, 60.0])
def test_a_small_slip_before_one_that_is_four_times_larger_is_partial(slid_N):
    """Loaded on along the line of the machine to a force a fifth higher, from which the rope slides."""
    corners = [(0.0, 0.0), (1.0, 0.0), (5.0, 80.0), (5.005, 75.0), (6.25, 100.0), (6.26, slid_N)]
    found = picked(drawn(*corners, (14.0, slid_N), (14.3, 0.0), (16.0, 0.0)))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.005)


@pytest.mark.parametrize("growth", [0.35, 0.6])
def test_a_rope_that_hardens_by_more_than_a_third_had_slid_at_its_first_force(growth):
    """After a slip by a tenth the force grows far more slowly than it was loaded; small slips up there say nothing."""
    at = since(4.02)
    force = drawn((0.0, 0.0), (1.0, 0.0), (4.0, 100.0), (4.02, 90.0), (16.0, 90.0))
    force += (100.0 * growth + 10.0) * (1.0 - np.exp(-at / 3.5))
    for n in range(8):
        force -= 5.0 * np.exp(-since(11.0 + 0.5 * n) / 0.2) * (since(11.0 + 0.5 * n) > 0.0)
    found = picked(force)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.005)


def test_a_first_slip_by_most_of_the_force_is_that_of_a_train_that_grows():
    tops_N, corners, at_s, low_N = [100.0, 118.0, 137.0, 149.0], [(0.0, 0.0), (0.5, 0.0)], 0.5, 0.0
    for top_N, next_N in zip(tops_N, [29.0, 33.0, 32.0, 25.0], strict=True):
        at_s += (top_N - low_N) / 40.0
        corners += [(at_s, top_N), (at_s + 0.01, next_N)]
        low_N = next_N
    found = picked(drawn(*corners, (16.0, low_N)))
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(100.0, rel=0.005)


# --- the zero ---


@pytest.mark.parametrize(("left_N", "status"), [(0.0, Status.OK), (5.0, Status.DOUBTFUL)])
def test_a_level_that_jumps_was_loaded_where_the_rope_rests_as_at_first_in_the_end(left_N, status):
    """From one sample to the next the zero may have jumped, and then it reads so to the end."""
    corners = [(0.0, 0.0), (1.0, 0.0), (1.002, 5.0), (2.5, 5.0), (5.5, 100.0), (5.505, 70.0), (12.0, 70.0)]
    found = picked(drawn(*corners, (12.3, left_N), (16.0, left_N)))
    assert found.status is status, found.detail
    if status is Status.OK:
        assert found.peak_N == pytest.approx(100.0, rel=0.005)
