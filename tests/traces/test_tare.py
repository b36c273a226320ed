import numpy as np
import pytest

from ropefric.errors import DataError, InputError
from ropefric.traces.calibration import Calibration, ForceCell, tare_from_interval

# One count is exactly one newton.
UNIT = Calibration(cell=ForceCell(name="unit", full_scale_N=1023.0))
RATE_HZ = 3000.0


def recording(idle_N, seed, *, noise_N=1.5, ramp_N_s=200.0):
    """Half a second of idling at `idle_N`, then a ramp."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(3000) / RATE_HZ
    force_N = idle_N + ramp_N_s * np.clip(time_s - 0.5, 0, None) + rng.normal(0, noise_N, time_s.size)
    return time_s, np.clip(np.rint(force_N), 0, 1023).astype(np.int64)


def test_the_tare_makes_idle_zero():
    time_s, counts = recording(40.3, 1)
    tared, problems = tare_from_interval(time_s, counts, UNIT, 0.0, 0.45)
    assert (problems, tared.tare_N) == ((), pytest.approx(40.3, abs=0.15))
    assert np.mean(tared.apply(counts)[0][time_s <= 0.45]) == pytest.approx(0.0, abs=1e-9)
    assert UNIT.tare_N == 0.0


def test_an_earlier_tare_is_replaced_not_added():
    time_s, counts = recording(40.3, 1)
    once, _ = tare_from_interval(time_s, counts, UNIT, 0.0, 0.45)
    twice, _ = tare_from_interval(time_s, counts, once, 0.0, 0.45)
    assert (twice, UNIT.with_tare(counts[time_s <= 0.45])[0]) == (once, once)


def test_the_stated_uncertainty_is_that_of_many_tares():
    pulls = []
    for seed in range(200):
        idle_N = 40.0 + seed / 200.0
        time_s, counts = recording(idle_N, seed)
        tared, _ = tare_from_interval(time_s, counts, UNIT, 0.0, 0.1)
        pulls.append((tared.tare_N - idle_N) / tared.tare_std_N)
    # Taking the larger of two estimates overstates a little; it must not understate.
    assert abs(np.mean(pulls)) < 0.2
    assert 0.7 < np.std(pulls) < 1.1


def test_a_reading_without_noise_is_known_to_a_count_at_best():
    tared, problems = tare_from_interval(np.arange(100.0), np.full(100, 7), UNIT, 0.0, 99.0)
    assert (tared.tare_std_N, problems) == (pytest.approx(1 / np.sqrt(12)), ())


def test_slow_noise_is_not_averaged_away_on_paper():
    rng = np.random.default_rng(3)
    time_s = np.arange(1600) / RATE_HZ
    slow_N = np.repeat(rng.normal(0, 0.8, 8), 200)
    counts = np.rint(100 + slow_N + rng.normal(0, 1.0, 1600)).astype(int)
    tared, _ = tare_from_interval(time_s, counts, UNIT, 0.0, time_s[-1])
    assert tared.tare_std_N > 5 * 1.0 / np.sqrt(1600)


def test_an_interval_that_reaches_into_the_ramp_is_doubtful():
    for seed in range(5):
        _, (problem,) = tare_from_interval(*recording(40.0, seed), UNIT, 0.0, 0.7)
        assert (problem.code, problem.severity) == ("RF212", "warning")
        assert "not constant" in problem.message


def test_white_noise_seldom_looks_restless():
    doubtful = 0
    for seed in range(150):
        time_s, counts = recording(300.0, seed, noise_N=8.0)
        doubtful += bool(tare_from_interval(time_s, counts, UNIT, 0.0, 0.45)[1])
    assert doubtful <= 1


def test_idling_on_the_floor_is_a_warning_not_a_fault():
    time_s, counts = recording(0.0, 4)
    tared, (problem,) = tare_from_interval(time_s, counts, UNIT, 0.0, 0.45)
    assert "at the ADC floor" in problem.message
    assert problem.severity == "warning"
    assert tared.tare_N < 1.5


def test_an_unusable_interval_is_refused():
    time_s, counts = recording(40.0, 5)
    for start_s, end_s, message in (
        (-0.5, 0.2, "not in the recording, 0 s to 0.99"), (0.9, 1.5, "not in the recording"),
        (5.0, 6.0, "not in the recording"), (0.1, 0.102, "7 usable of 7 samples; at least 10"),
    ):  # fmt: skip
        with pytest.raises(DataError, match=message) as error:
            tare_from_interval(time_s, counts, UNIT, start_s, end_s)
        assert error.value.code == "RF212"
    for start_s, end_s in ((0.3, 0.3), (0.3, 0.1), (float("nan"), 1.0)):
        with pytest.raises(InputError, match="is empty"):
            tare_from_interval(time_s, counts, UNIT, start_s, end_s)
    counts[30:40] = 1023
    with pytest.raises(DataError, match="10 samples of the tare interval are at the ADC ceiling"):
        tare_from_interval(time_s, counts, UNIT, 0.0, 0.4)


def test_a_first_stamp_a_little_late_is_no_reason_to_refuse():
    time_s, counts = recording(40.0, 5)
    tared, _ = tare_from_interval(time_s + 0.01, counts, UNIT, 0.0, 0.4)
    assert tared.tare_N == pytest.approx(40.0, abs=0.2)


def test_missing_samples_are_left_out_and_too_many_refused():
    time_s, counts = recording(40.0, 6)
    counts[::3] = -1
    tared, _ = tare_from_interval(time_s, counts, UNIT, 0.0, 0.4)
    assert tared.tare_N == pytest.approx(40.0, abs=0.2)
    counts[1::3] = -1
    with pytest.raises(DataError, match="400 usable of 1201"):
        tare_from_interval(time_s, counts, UNIT, 0.0, 0.4)
