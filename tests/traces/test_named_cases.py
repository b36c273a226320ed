"""What a person sees at a glance, case by case: the force within its uncertainty, or the reason why there is none."""

import numpy as np
import pytest
from drawn import PULL, REST, TIME_S, drawn, hung, knock, loaded, picked, ring, settles, since

from ropefric.traces.breakaway import PickSettings, Status

SLIDES = TIME_S > 3.0


def finds(force_N, peak_N=100.0, *, within=0.01, settings=PickSettings(), **times):  # noqa: B008  (it is frozen)
    """Assert that a force is found, and return what is."""
    found = picked(force_N, settings, **times)
    assert found.status is Status.OK, found.detail
    assert found.peak_N == pytest.approx(peak_N, rel=within)
    return found


def refuses(force_N, *statuses, words="", **times):
    """Assert that none is given, for one of some reasons."""
    found = picked(force_N, **times)
    assert found.status in statuses, (found.status, found.detail)
    assert np.isnan(found.peak_N)
    assert words in found.detail
    return found


NONE, DOUBT, NO_PEAK, CUT = Status.NO_BREAKAWAY, Status.DOUBTFUL, Status.NO_PEAK, Status.SATURATED


# --- before the pull ---


def test_weights_are_hung_on_one_by_one_before_the_pull():
    climb = drawn((0.0, 0.0), (2.8, 0.0), (4.8, 76.0), (4.804, 56.0), (6.0, 56.0))
    found = picked(hung((8.0, 16.0, 24.0)) + climb)
    assert found.status in {Status.OK, DOUBT}
    best_N = found.candidates[0].force_N if found.candidates else found.peak_N
    assert best_N == pytest.approx(100.0, rel=0.01)


def test_a_bump_at_rest():
    found = finds(drawn(*PULL) + knock(0.5, 60.0, 0.03))
    assert found.dwell_s == pytest.approx(1.0, abs=0.6)


def test_a_snag_lets_the_rope_go_before_the_pull():
    """A first pull to three quarters that ends in nothing: the second is the likelier, and a person may decide."""
    found = picked(drawn((0.0, 0.0), (0.5, 0.0), (1.5, 75.0), (1.504, 0.0), (2.5, 0.0), (4.5, 100.0), (4.504, 70.0),
        (6.0, 70.0)))  # fmt: skip
    best_N = found.peak_N if found.status is Status.OK else found.candidates[0].force_N
    assert best_N == pytest.approx(100.0, rel=0.01)


def test_a_partial_slip_is_listed_and_the_full_one_picked():
    found = finds(drawn(*PULL) - 6.0 * np.clip((TIME_S - 2.7) / 0.003, 0.0, 1.0), 94.0)
    (event,) = found.events
    assert (event.kind, event.time_s) == ("partial-slip", pytest.approx(2.7, abs=0.01))
    assert event.drop_N == pytest.approx(6.0, abs=1.0)


def test_an_impact_on_the_climb_is_no_breakaway():
    finds(drawn(*PULL, noise_N=0.2) + knock(1.8, 150.0, 0.02) + ring(1.82, 22.0))


def test_a_blow_and_no_pull():
    refuses(drawn((0.0, 0.0), (6.0, 0.0)) + knock(1.0, 500.0, 0.01) + ring(1.01, 60.0, hz=60.0), NONE)


# --- the slip ---


def test_a_stick_slip_train_breaks_away_at_its_first_tooth():
    teeth = [(top_N, 75.0) for top_N in (100.0, 103.0, 101.0, 102.0, 99.0, 103.0)]
    found = picked(drawn(*loaded(*teeth, rate_N_s=70.0), (6.0, 75.0)))
    top_s = found.peak_time_s if found.status is Status.OK else found.candidates[0].time_s
    assert found.status in {Status.OK, DOUBT}
    assert top_s == pytest.approx(0.3 + 100.0 / 70.0, abs=0.01)


def test_a_rope_wears_in_beyond_its_first_peak():
    finds(drawn((0.0, 0.0), (0.3, 0.0), (2.3, 100.0), (2.36, 86.0), (6.0, 125.0)))


def test_a_second_higher_pull():
    first = ((0.5, 0.0), (1.5, 100.0), (1.504, 70.0), (2.5, 70.0), (2.7, 0.0), (3.5, 0.0))
    found = picked(drawn((0.0, 0.0), *first, (4.6, 112.0), (4.604, 78.0), (6.0, 78.0)))
    assert found.status in {Status.OK, DOUBT}
    best_N = found.candidates[0].force_N if found.candidates else found.peak_N
    assert best_N == pytest.approx(100.0, rel=0.01)


def test_a_peak_falls_slowly_on_a_soft_machine():
    finds(drawn(*REST, (3.0, 100.0), (3.1, 80.0), (6.0, 80.0)))


def test_a_slip_rings_on():
    finds(np.where(SLIDES, 45.0 + 25.0 * np.cos(60.0 * since(3.0)) * np.exp(-since(3.0)), drawn(*PULL)))


def test_a_separation_gives_its_highest_force_only_if_asked_for():
    force = drawn((0.0, 0.0), (0.2, 0.0), (0.3, 70.0), (0.33, 55.0), (0.36, 72.0), (0.5, 0.0), (2.0, 0.0))
    found = finds(force, 72.0, within=0.02, settings=PickSettings(ending="separation"))
    assert np.isnan(found.kinetic_N)
    assert "no sliding phase" in found.detail


# --- no slip ---


def test_the_trace_is_cut_in_the_climb():
    seen = TIME_S < 2.5
    refuses(drawn(*PULL)[seen], NONE, time_s=TIME_S[seen], words="no break-away")


def test_the_motor_stops_and_the_rope_is_held():
    refuses(drawn(*REST, (3.0, 100.0), (6.0, 99.5)), NONE, words="no break-away")


@pytest.mark.parametrize(("part", "tau_s"), [(0.03, 2.0), (0.08, 4.0), (0.12, 2.0)])
def test_a_held_rope_relaxes(part, tau_s):
    """A loss of 5 % within a second still passes for a slip."""
    refuses(
        drawn(*REST, (2.5, 100.0), (6.0, 100.0)) - settles(2.5, 100.0 * part, tau_s), NONE, DOUBT, NO_PEAK
    )


def test_the_load_is_let_down():
    refuses(drawn(*REST, (3.0, 100.0), (3.5, 100.0), (3.9, 0.0), (6.0, 0.0)), NONE)


def test_the_motor_stops_and_the_masses_swing():
    refuses(drawn(*REST, (3.0, 100.0), (6.0, 100.0)) + ring(3.0, 2.0, lasts_s=0.2, hz=4.0), NONE, DOUBT)


def test_a_force_that_bends_into_sliding_has_no_static_peak():
    waves = 0.7 * since(3.5).clip(max=1.0) * (np.sin(20.0 * TIME_S) + np.sin(33.0 * TIME_S))
    refuses(drawn((0.0, 0.0), (6.0, 0.0)) + settles(1.0, 100.0, 0.7) + waves, NO_PEAK)


def test_a_pull_that_reads_negative_is_told_so():
    refuses(-drawn(*PULL), NONE, words="only goes down")


# --- the sensor ---


def test_the_converter_saturates():
    refuses(np.minimum(drawn(*PULL, noise_N=1.0), 80.0), CUT, words="exactly 80 N")


def test_spikes_of_up_to_five_samples_move_nothing():
    clean_N = picked(drawn(*PULL, noise_N=0.2)).peak_N
    for length in range(1, 6):
        force = drawn(*PULL, noise_N=0.2)
        for start in (500, 1900, 2600, 4000):
            force[start : start + length] += 80.0
        finds(force, clean_N, within=2e-3)


def test_a_gap_hides_the_peak():
    seen = (TIME_S < 2.997) | (TIME_S > 3.3)
    found = refuses(drawn(*PULL)[seen], DOUBT, time_s=TIME_S[seen])
    assert "gap of" in " ".join(found.notes)
    refuses(drawn(*PULL)[far := (TIME_S < 1.6) | (TIME_S > 2.999)], DOUBT, time_s=TIME_S[far],
        words="most of the climb")  # fmt: skip
