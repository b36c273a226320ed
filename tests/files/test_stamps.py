"""Text time stamps: what each way of writing means in seconds, and what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ropefric.errors import DataError, RopefricError
from ropefric.files.text_table import is_stamp, read_stamps


def refuse(line, why, fix):
    return DataError(why, line=line, fix=fix)


def seconds(*texts, order=""):
    found, notes = read_stamps(enumerate(texts, start=2), order=order, no_value=("", "--"), refuse=refuse)  # fmt: skip
    return found.tolist(), notes[0] if notes else ""


def test_ways_of_writing():
    ymd, dmy, mdy = "year, month, day", "day, month, year", "month, day, year"
    for first, second, step_s, said in (
        ("2024-03-05 14:33:21.123", "2024-03-05 14:33:21.124", 0.001, ymd),
        ("2024-03-05T14:33:21Z", "2024-03-05T14:33:21.000001Z", 1e-6, ymd),
        ("2024/03/05 23:59:59.9", "2024/03/06 00:00:00", 0.1, ymd),
        ("05.03.2024 14:33:21,5", "05.03.2024 14:33:22,25", 0.75, dmy),
        ("5.3.24 14:33:21", "6.3.24 14:33:21", 86400, dmy),
        ("28.02.2024 23:59:59", "01.03.2024 00:00:00", 86401, dmy),  # a leap year
        ("3/25/2024 2:33:21 PM", "3/25/2024 2:33:22 PM", 1, mdy),
        ("25/3/2024 14:33", "25/3/2024 14:34", 60, dmy),
        ("3/25/2024 11:59:59.5 AM", "3/25/2024 12:00:00 PM", 0.5, mdy),
        ("3/25/2024 12:00:00 AM", "3/25/2024 1:00:00 AM", 3600, mdy),
        ("03/04/2024 10:00:00", "03/04/2024 10:00:01.5", 1.5, "all of one day"),
        ("14:33:21.25", "14:33:21.5", 0.25, "without a date"),
        ("09:51:39.1970510124996275989", "09:51:39.1970510154", 3.0e-9, "without a date"),
        ("2024-03-31T01:59:59+01:00", "2024-03-31T03:00:00+02:00", 1, ymd),
        ("2024-03-05 10:00:00 -0330", "2024-03-05 10:00:01 -0330", 1, ymd),
    ):
        assert is_stamp(first)
        found, note = seconds(first, second)
        assert found == [0, pytest.approx(step_s, rel=1e-6)], first
        assert f"({said}" in note
        assert note.endswith(f"from {first} on")
    for text in ("", "12", "1.5", "12:30", "1:2:3", "2024-03-05", "a 10:00:00", "10:61:00", "-1:00:00"):
        assert not is_stamp(text), text


def test_empty_cells_are_missing_and_a_column_of_them_is_no_time():
    found, _ = seconds("", "10:00:00", "--", "10:00:02")
    np.testing.assert_array_equal(found, [np.nan, 0, np.nan, 2])
    assert np.isnan(seconds("", "--")[0]).all()


def test_midnight_is_passed_as_often_as_the_clock_falls():
    found, note = seconds("23:59:59.5", "00:00:00.5", "12:00:00", "23:59:59", "00:00:01")
    assert found == [0, 1, 43200.5, 86399.5, 86401.5]
    assert "past midnight 2 times" in note


def test_the_hour_that_the_end_of_summer_time_repeats():
    with pytest.raises(DataError, match="summer time ended") as caught:
        seconds("27.10.2024 02:59:59", "27.10.2024 02:00:00", "27.10.2024 02:59:59")
    assert caught.value.problem.line == 3
    assert "UTC" in caught.value.fix


def test_what_is_refused():
    for texts, words, fix in ((("03/04/2024 10:00:00", "03/05/2024 10:00:00"), "day, month, year or month, day, year",
            'date_order = "mdy" or "dmy"'), (("31.02.2024 10:00:00",), "no date '31.02.2024'", "date_order"),
            (("2024-03-05 25:00:00",), "no such hour", "mend"), (("13:00:00 PM",), "no such hour", "mend"),
            (("10:00:00", "oops"), "'oops' as a time stamp like '10:00:00'", "mend"),
            (("2024-03-05 10:00:00", "10:00:01"), "time stamp like", "mend"),
            (("2024-03-05 10:00:00", "2024-03-05 10:00:01Z"), "time stamp like", "mend")):  # fmt: skip
        with pytest.raises(DataError, match=words) as caught:
            seconds(*texts)
        assert fix in caught.value.fix
        assert caught.value.problem.line == 2 + (len(texts) > 1 and "03/04" not in texts[0])


def test_a_stated_order_is_kept_to():
    texts = ("03/04/2024 10:00:00", "04/04/2024 10:00:00")
    assert (seconds(*texts, order="dmy")[0], seconds(*texts, order="mdy")[0]) == ([0, 86400], [0, 31 * 86400])


@given(st.text(alphabet="0123456789-/.: TZ+APMapm,", max_size=30))
def test_any_text_is_read_or_refused(text):
    is_stamp(text)
    try:
        found, _ = seconds(text, order="dmy")
    except RopefricError:
        return
    assert found in ([0.0], [pytest.approx(np.nan, nan_ok=True)])
