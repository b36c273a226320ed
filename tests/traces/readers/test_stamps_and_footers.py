"""Recordings whose time is text, and whose end is no data."""

import numpy as np
import pytest
from reading import read as read_all
from reading import refused

from ropefric.traces.assemble import assemble_trace
from ropefric.traces.readers import read_recordings
from ropefric.traces.readers.inspection import inspect_file
from ropefric.traces.readers.profile import Channel


def read(path, **keys):
    (trace,) = read_all(path, **keys)
    return trace


def test_a_german_logger_with_text_time_stamps(write):
    rows = "".join(f"05.03.2024 23:59:59,{i}00;{i},5\n" for i in range(5, 10))
    path = write(f"Prüfstand;3\nDatum/Uhrzeit;Kraft_N\n{rows}06.03.2024 00:00:00,000;7,5\n".encode("cp1252"))
    found = inspect_file(path)
    assert (found.separator, found.decimal, found.header_row) == (";", ",", 2)
    assert (found.sampling_rate_Hz, found.is_uniform) == (10, True)
    assert any("text time stamps (day, month, year) from 05.03.2024 23:59:59,500" in n for n in found.notes)
    trace = assemble_trace(read_recordings(path, found.profile)[0], found.profile)
    np.testing.assert_allclose(trace.time_s, np.arange(6) / 10, atol=1e-12)
    assert trace.force_N.tolist() == [5.5, 6.5, 7.5, 8.5, 9.5, 7.5]
    assert any("text time stamps" in note for note in trace.notes)


def test_the_only_column_of_stamps_is_the_time_whatever_it_is_called(write):
    path = write("when,force_N\n10:00:00.00,1\n10:00:00.01,2\n")
    assert read(path).time_s.tolist() == [0, 0.01]
    named = {"time": Channel(column="when", unit="ms"), "force": Channel(column=2, unit="kN", instead_of="N")}
    trace = read(path, channels=named)  # stamps are no milliseconds
    assert (trace.time_s.tolist(), trace.force_N.tolist()) == ([0, 0.01], [1000, 2000])


def test_a_time_stamp_that_is_none_is_told_by_its_line(write):
    error = refused(write("time,force_N\n10:00:00,1\nnoon,2\n"))
    assert (error.code, error.where) == ("RF104", "run:3 time")
    assert "'noon'" in str(error)


def test_the_order_of_american_dates_is_stated(write):
    path = write("time,force_N\n03/04/2024 11:59:59 PM,1\n03/05/2024 12:00:00 AM,2\n")
    assert "date_order" in refused(path).fix
    assert any("date_order" in doubt for doubt in inspect_file(path).doubts)
    assert read(path, date_order="mdy").time_s.tolist() == [0, 1]


# --- footers ---

ROWS = "".join(f"{i / 10},{i}\n" for i in range(30))
HEAD = "time_s,force_N\n"


@pytest.mark.parametrize(
    "footer", ["End of test\n", "\nMaximum:,29,N\nOperator: Smith\n", "# done", "***END***,,\n\n\n"]
)
def test_lines_of_words_at_the_end_are_a_footer_and_are_told(write, footer):
    path = write(HEAD + ROWS + footer)
    trace = read(path)
    assert trace.force_N.tolist() == [*range(30)]
    (note,) = [note for note in trace.notes if "left out at the end" in note]
    assert footer.strip().splitlines()[0].strip() in note
    assert inspect_file(path).notes == (note,)


def test_a_footer_that_looks_like_a_row_is_skipped_by_its_key(write):
    path = write(HEAD + ROWS + "Maximum,29\nMean,14.5\n")
    assert refused(path).code == "RF102"
    assert "skip_footer" in refused(path).fix
    trace = read(path, skip_footer=2)
    assert trace.force_N.size == 30
    assert any(
        "2 lines without data left out at the end: Maximum,29; Mean,14.5" in note for note in trace.notes
    )


@pytest.mark.parametrize("end", ["3.0\n", "3.0", "3.0,1,2\n", "3.0,1\nfoo\n3.1,2\n"])
def test_rows_that_are_damaged_are_no_footer(write, end):
    assert refused(write(HEAD + ROWS + end)).code in {"RF102", "RF103"}


@pytest.mark.parametrize(
    ("head", "row", "last"),
    [
        ("point,force_N,way_mm", "P{i},{i},{i}", "P30,3"),  # rows that begin with words
        ("time,force_N", "2024-03-05T10:00:{i:02d}Z,{i}", "2024-03-05T10:0"),
        ("time_s,force_N", "{i},{i}", "nan"),
    ],
)
def test_a_last_row_that_is_cut_is_no_footer(write, head, row, last):
    rows = "".join(row.format(i=i) + "\n" for i in range(30))
    rate = {"sampling_rate_Hz": 10.0, "channels": {"force": Channel(column=2, unit="N")}}
    assert refused(write(f"{head}\n{rows}{last}\n"), **rate).code == "RF103"
