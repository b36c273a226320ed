"""The zero of a recording stays, drifts or jumps: forces drawn by hand whose truth is known, in white and slow noise."""

from dataclasses import replace

import numpy as np
import pytest
from drawn import PULL, TIME_S, drawn, hung, line, picked
from scipy.signal import lfilter

from ropefric.traces.breakaway import PickSettings, Status
from ropefric.traces.calibration import Calibration, ForceCell
from ropefric.traces.decision import pick_breakaway
from ropefric.traces.trace import ForceTrace
from ropefric.traces.zero import _alike, _parted

LONG, BRIEF = 1.0, 0.3
"""How long a rope rests before the climb [s]."""
ZERO, PRETENSION = PickSettings(rest="zero"), PickSettings(rest="pretension")


def pulled(rest_s=LONG, *, rests_again=False, left_N=0.0):
    """Return a pull to 100 N without noise, after which the rope may rest again."""
    down = ((3.0, 70.0), (3.4, left_N), (6.0, left_N)) if rests_again else ((6.0, 70.0),)
    return line((0.0, 0.0), (rest_s, 0.0), (rest_s + 1.6, 100.0), (rest_s + 1.604, 70.0), *down)


def noise(seed, std_N=0.2, *, lasts_s=0.0):
    """Return white noise, or noise that keeps its sign for about so long."""
    keeps = np.exp(-0.001 / lasts_s) if lasts_s else 0.0
    steps = np.random.default_rng(seed).normal(0.0, std_N * np.sqrt(1.0 - keeps**2), TIME_S.size + 3000)
    return lfilter([1.0], [1.0, -keeps], steps)[3000:]


def is_right(found, peak_N=100.0):
    """Return whether a force is found that is off by no more than what matters; a doubt must name the true one."""
    if found.status is Status.OK:
        assert found.peak_N == pytest.approx(peak_N, rel=0.02), found.notes
    else:
        assert found.status is Status.DOUBTFUL
    return found.status is Status.OK


def names(found, *forces_N, words=""):
    """Assert that a result is in doubt between some forces."""
    assert found.status is Status.DOUBTFUL, found.notes
    assert words in found.detail
    assert [one.force_N for one in found.candidates] == pytest.approx(forces_N, abs=0.6)


@pytest.mark.parametrize("rest_s", [LONG, BRIEF])
def test_a_zero_that_stays_leaves_the_force_as_it_is(rest_s):
    for seed in range(8):
        found = picked(pulled(rest_s) + noise(seed))
        assert found.status is Status.OK, found.detail
        assert abs(found.peak_N - 100.0) < 3.0 * found.peak_std_N
        assert found.peak_std_N < 0.8
        assert not any("taken off" in note for note in found.notes if "drift" in note)


@pytest.mark.parametrize("rate_N_s", [-0.6, -0.3, 0.3, 0.6])
def test_a_drift_is_taken_off_and_what_it_may_leave_is_in_the_uncertainty(rate_N_s):
    for seed in range(4):
        found = picked(pulled() + rate_N_s * TIME_S + noise(seed))
        assert is_right(found), found.detail
        assert abs(found.peak_N - 100.0) < 2.0 * found.peak_std_N
        assert found.peak_std_N > 0.2 * abs(rate_N_s) * 2.6
        assert found.status is Status.DOUBTFUL or "taken off" in " ".join(found.notes)


def test_a_large_drift_is_in_doubt_until_a_later_rest_confirms_it():
    drift = 2.6 * TIME_S
    found = picked(pulled() + drift + noise(1))
    assert "drifts by" in found.detail
    names(found, 100.0 + 2.6 * 2.6, 100.0)
    found = picked(pulled(rests_again=True) + drift + noise(1))
    assert found.status is Status.OK, found.detail
    assert abs(found.peak_N - 100.0) < 2.0 * found.peak_std_N
    # Whatever tension is left: the slope of both rests is the same.
    assert is_right(picked(pulled(rests_again=True, left_N=9.0) + 0.5 * TIME_S + noise(1)))


def test_what_a_drift_may_leave_is_a_part_of_the_probability():
    """Off by less than a fiftieth: nearly certain without a drift, less so the larger one is that was taken off."""
    stated = [picked(pulled() + rate_N_s * TIME_S + noise(1)).probability for rate_N_s in (0.0, 1.4, 1.8)]
    assert stated[0] >= 0.9
    assert stated[0] > stated[1] > stated[2] >= 0.8


def test_slow_noise_makes_no_drift_that_is_wrong():
    """Noise of one part in a hundred that keeps its sign for a tenth of a second: what it hides is doubtful or in u."""
    found = [picked(pulled(LONG) + noise(seed, 0.5, lasts_s=0.1)) for seed in range(8)]
    assert sum(map(is_right, found)) >= 6
    again = [picked(pulled(BRIEF, rests_again=True) + noise(seed, 0.5, lasts_s=0.1)) for seed in range(8)]
    assert sum(map(is_right, again)) >= 6


def test_so_many_neighbours_of_slow_noise_count_as_one():
    for lasts_s, least, most in ((0.0, 1.0, 3.0), (0.02, 10.0, 120.0)):
        alike = np.median([_alike(noise(seed, lasts_s=lasts_s)) for seed in range(9)])
        assert least <= alike <= most  # of a first-order filter: twice its time constant in samples


@pytest.mark.parametrize("at", [60, 137, 331])
def test_a_jump_is_found_to_the_sample(at):
    force_N = 5.0 * (np.arange(400) >= at) + 0.02 * np.random.default_rng(at).standard_normal(400)
    assert _parted(force_N, 0, 400) == [(0, at), (at, 400)]


@pytest.mark.parametrize("jump_N", [5.0, -5.0])
def test_a_jump_at_rest_is_a_load_or_the_zero(jump_N):
    for rest_N in (0.0, 8.0):  # so that it reads more than nothing
        found = picked(pulled() + rest_N + jump_N * (TIME_S > 0.5) + noise(3), PickSettings())
        assert found.status is Status.DOUBTFUL
    names(picked(pulled() + 15.0 + jump_N * (TIME_S > 0.5) + noise(3)), 115.0 + jump_N, 115.0, words="jumps")
    jumped = pulled() + 5.0 * (TIME_S > 0.5) + noise(3)
    assert picked(jumped, ZERO).peak_N == pytest.approx(100.0, abs=0.6)
    assert picked(jumped, PRETENSION).peak_N == pytest.approx(105.0, abs=0.6)


def test_what_jumps_and_comes_back_or_comes_on_slowly_was_a_load():
    came_off = 5.0 * ((TIME_S > 0.5) & (TIME_S < 3.2))
    assert is_right(picked(pulled(rests_again=True) + came_off + noise(4)), 105.0)
    assert is_right(picked(hung((5.0,), swing_Hz=6.0) + pulled() + noise(4)), 105.0)


def test_a_jump_in_the_climb_is_a_load_or_the_zero():
    for at_s in (1.3, 2.2):
        found = picked(pulled() + 6.0 * (at_s < TIME_S) + noise(5, 0.1))
        # From the step alone it may be the zero, a load that came on, a partial slip or a file that was joined.
        assert found.status is Status.DOUBTFUL
    slips = pulled() - 6.0 * np.clip((TIME_S - 2.2) / 0.003, 0.0, 1.0)
    assert is_right(picked(slips + noise(5, 0.1)), 94.0)


@pytest.mark.parametrize("level_N", [-12.0, -3.0, 0.5, 6.0, 20.0])
def test_a_level_is_an_error_of_the_zero_or_a_pretension(level_N):
    force_N = pulled() + level_N + noise(6)
    found = picked(force_N)
    if 2.0 < level_N < 12.0:
        names(found, 100.0 + level_N, 100.0, words='rest = "zero"')
    else:
        assert is_right(found, 100.0 + (level_N if level_N > 12.0 else 0.0))
        assert abs(found.peak_N - 100.0) < 2.0 * found.peak_std_N or level_N > 12.0
        said = {
            -3.0: "less than nothing: taken off",
            20.0: "as a pretension: if that is an error of the zero, set",
        }
        assert said.get(level_N, "") in " ".join(found.notes)
    for rest, true_N in ((ZERO, 100.0), (PRETENSION, 100.0 + level_N)):
        assert picked(force_N, rest).peak_N == pytest.approx(true_N, abs=0.6)
    begins = picked(drawn(*PULL)[1800:], ZERO, TIME_S[1800:])
    assert "begins under load" in begins.detail


def test_a_calibrated_force_is_asked_of_its_zero_like_any_other_unless_it_was_tared():
    made = ForceTrace(time_s=TIME_S, force_N=pulled() + 6.0 + noise(6))
    cell = Calibration(cell=ForceCell(name="K1", full_scale_N=1000.0, rated_output=0.002))
    for calibration in (None, cell):
        trace = replace(made, calibration=calibration)
        names(pick_breakaway(trace, PickSettings())[0], 106.0, 100.0)
        assert pick_breakaway(trace, ZERO)[0].peak_N == pytest.approx(100.0, abs=0.6)
        assert pick_breakaway(replace(trace, tare_N=2.0), PickSettings())[0].status is Status.OK


def test_a_rest_that_reads_less_than_nothing_after_a_load_is_in_doubt():
    load = line((0.3, 0.0), (0.5, 30.0), (0.7, -8.0), (6.0, -8.0))
    found = picked(pulled(1.5) + load + noise(7))
    assert "after a load" in found.detail
    names(found, 92.0, 100.0)
