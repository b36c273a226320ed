"""Clocks that repeat, jitter, run backwards or stop; any clock is in tests/fuzz."""

from itertools import product

import numpy as np
import pytest

from ropefric.errors import DataError
from ropefric.traces.clock import mend_clock


def test_a_clean_clock_is_passed_on_untouched_and_so_is_jitter():
    clean_s = 5.0 + np.arange(1000) / 3000
    for time_s in (clean_s, clean_s + np.random.default_rng(1).uniform(-1e-4, 1e-4, 1000)):
        keep, mended_s, notes = mend_clock(time_s)
        assert keep == slice(None)
        assert mended_s is time_s  # the offset stays as well
        assert notes == ()


@pytest.mark.parametrize(("rate_Hz", "digit_s"), [(3000, 1e-3), (1000, 1e-2), (1200, 1e-3), (900, 0.002),
    (997, 0.01), (2000, 6e-4)])  # fmt: skip
def test_rounded_stamps_come_back_within_their_rounding(rate_Hz, digit_s):
    truth_s = 3.0 + np.arange(2000) / rate_Hz
    printed_s = np.round(np.floor(truth_s / digit_s) * digit_s, 6)
    force = np.sin(40 * truth_s)
    keep, mended_s, notes = mend_clock(printed_s, [force])
    assert np.asarray(keep).all() if not isinstance(keep, slice) else True
    assert (np.diff(mended_s) > 0).all()
    assert np.abs(mended_s - truth_s).max() <= digit_s * 1.001
    assert "rounded" in notes[0]


def test_a_gap_is_not_filled_by_rounded_stamps():
    time_s = np.repeat([0.0, 0.01, 0.02, 3.0, 3.01, 4.0, 4.01], 10)
    _, mended_s, notes = mend_clock(time_s, [np.arange(70.0)])
    assert mended_s[29] < 0.031
    assert any("2 gaps in time; the longest is 2.97" in note and "after 0.029" in note for note in notes)


def test_a_few_repeated_stamps_keep_the_first():
    time_s = np.arange(1000) * 1e-3
    time_s[[300, 301, 700]] = time_s[[299, 299, 699]]
    keep, mended_s, notes = mend_clock(time_s, [np.arange(1000.0)])
    assert (np.flatnonzero(~keep).tolist(), mended_s.size) == ([300, 301, 700], 997)
    assert notes == ("3 samples with a repeated time stamp; only the first of each was kept",)


def test_rows_written_twice_are_told_from_rounding_by_their_values():
    time_s = np.repeat(np.arange(100) * 0.1, 2)
    force = np.repeat(np.arange(100.0), 2)
    keep, mended_s, notes = mend_clock(time_s, [force])
    assert (mended_s.tolist(), force[keep].tolist()) == ((np.arange(100) * 0.1).tolist(), list(range(100)))
    assert "written twice" in notes[0]


def test_a_stuck_clock_is_refused():
    time_s = np.arange(1000) * 1e-3
    time_s[400:500] = time_s[400]
    with pytest.raises(DataError, match=r"sample 401 shares its time stamp 0\.4 s with 99") as caught:
        mend_clock(time_s, [np.arange(1000.0)], source="run.csv", first_line=2)
    assert (caught.value.code, caught.value.where) == ("RF202", "run.csv:402 time")
    assert "sampling_rate" in caught.value.fix


def test_repeats_that_are_no_rounding_are_refused():
    rng = np.random.default_rng(2)
    stamps = np.cumsum(rng.uniform(0.5, 1.5, 400))
    with pytest.raises(DataError, match="not as rounding would"):
        mend_clock(np.repeat(stamps, rng.integers(1, 3, 400)), [])


def test_a_reset_and_unsorted_rows_are_told_apart():
    up = np.arange(50) * 0.1
    with pytest.raises(DataError, match=r"sample 51 has time 0 s after 4\.9 s") as caught:
        mend_clock(np.concatenate([up, up]), [], source="run.csv", first_line=3)
    assert caught.value.where == "run.csv:53 time"
    assert "two recordings" in caught.value.fix
    with pytest.raises(DataError, match="backwards") as caught:
        mend_clock(np.random.default_rng(3).permutation(up), [])
    assert "sort the rows" in caught.value.fix


def test_empty_rows_go_and_unstamped_values_are_refused():
    time_s, force = np.arange(10.0), np.arange(10.0)
    time_s[[4, 9]] = np.nan
    with pytest.raises(DataError, match="sample 5 has values but no time stamp"):
        mend_clock(time_s, [force])
    force[[4, 9]] = np.nan
    keep, mended_s, notes = mend_clock(time_s, [force])
    assert mended_s.tolist() == time_s[keep].tolist() == [0, 1, 2, 3, 5, 6, 7, 8]
    assert notes[0] == "2 empty rows dropped"
    with pytest.raises(DataError) as caught:
        mend_clock(np.full(3, np.nan), [np.full(3, np.nan)])
    assert caught.value.code == "RF201"


def test_infinite_stamps_are_refused():
    for bad, at in product((np.inf, -np.inf), (0, 5, 9)):
        time_s = np.arange(10.0)
        time_s[at] = bad
        with pytest.raises(DataError):
            mend_clock(time_s, [np.full(10, np.nan)])
