"""Damaged and misleading text files: refused with place and remedy, never read in silence."""

import gzip
import os
from itertools import product

import numpy as np
import pytest

from ropefric.errors import DataError, InputError, UnknownNameError
from ropefric.traces.readers import read_recordings
from ropefric.traces.readers.profile import Channel, ImportProfile

HEAD = "time_s,force_N\n"
GOOD = HEAD + "".join(f"{i * 0.1:.1f},{i * 1.5}\n" for i in range(30))
BY_NUMBER = {"time": Channel(column=1, unit="s"), "force": Channel(column=2, unit="N")}


def refused(path, profile=None):
    with pytest.raises(DataError) as caught:
        read_recordings(path, profile or ImportProfile(), shown_as="run.csv")
    error = caught.value
    assert "run.csv" in str(error)
    return error


def columns(path, profile=None):
    (recording,) = read_recordings(path, profile or ImportProfile())
    return recording.columns


# content, code, line, words of the message, words of the fix
CORPUS = {
    "empty": ("", "RF101", None, "0 bytes", ""),
    "blank": (" \n\n \t\n", "RF101", None, "nothing but blanks", ""),
    "header only": (HEAD, "RF101", None, "no data rows", "record it again"),
    "words only": ("a\nb\nc\n", "RF101", None, "no data rows", ""),
    "binary": (GOOD.encode() + b"\x00\x01", "RF101", 32, "not a text file", "utf-16"),
    "gzip cut off": (gzip.compress(GOOD.encode(), mtime=0)[:60], "RF101", None, "damaged or cut off", "copy"),
    "gzip of nothing": (gzip.compress(b"", mtime=0), "RF101", None, "empty", ""),
    "undefined in cp1252": (HEAD.encode() + b"0,1\n\x81,2\n", "RF108", 3, "cannot be read as cp1252", ""),
    "text cell": (HEAD + "0,1\n0.1,oops\n0.2,2\n", "RF102", 3, "'oops'", "missing"),
    "text in first row": (HEAD + "0,oops\n0.1,1\n0.2,2\n", "RF102", 2, "'oops'", ""),
    "infinite": (HEAD + "0,1\n0.1,inf\n", "RF102", 3, "infinite", ""),
    "too large": (HEAD + "0,1\n0.1,1e999\n", "RF102", 3, "too large", ""),
    "mark for missing": (HEAD + "0,1\n0.1,NA\n", "RF102", 3, "missing value", 'missing = ["NA"]'),
    "pandas' own word for missing": (HEAD + "0,1\n0.1,null\n", "RF102", 3, "'null'", ""),
    "underscore": (HEAD + "0,1\n0.1,1_000\n", "RF102", 3, "1_000", ""),
    "clock": (HEAD + "0,1\n12:00:01,2\n", "RF102", 3, "date or a clock", "sampling_rate"),
    "short row": (HEAD + "0,1\n0.1\n0.2,3\n", "RF103", 3, "1 values", "mend"),
    "cut last row": (HEAD + "0,1\n0.1,2\n0.2", "RF103", 4, "1 values", "cut off"),
    "long row": (HEAD + "0,1\n0.1,2,3\n0.2,3\n", "RF103", 3, "3 values", ""),
    "short and long row": (HEAD + "0,1\n0.1\n0.2,3,4\n", "RF103", 3, "1 values", ""),
    "all rows long": (HEAD + "0,1,2\n1,2,3\n", "RF103", 2, "3 values, but the header (line 1) names 2", ""),
    "all rows short": ("t_s,a,force_N\n0,1\n1,2\n", "RF103", 2, "2 values", ""),
    "open quote": (HEAD + '0,1\n0.1,"2\n0.2,3\n', "RF103", 3, "quotation mark", ""),
    "decimal comma in commas": (HEAD + "0,1,12,47\n0,2,12,48\n", "RF103", 2, "4 values", "decimal comma"),
    "grouped or decimal": ("time_s;force_N\n0;1,234\n1;2,345\n", "RF104", 2, "1.234 or 1234", 'decimal = ","'),
    "grouped and decimal": ("time_s;force_N\n0;1,234.5\n1;2,5\n", "RF104", 3, "mixes marks", 'thousands = ","'),
    "grouped both ways": ("time_s;force_N\n0;1.234,5\n1;2,345.5\n", "RF104", 3, "mixes marks", "decimal"),
    "grouped oddly": ("time_s;force_N\n0;1,23.5\n", "RF104", 2, "mixes marks", "thousands"),
    "one or two columns": ("12,47\n13,01\n", "RF104", None, "two whole numbers", "separator"),
    "unknown columns": ("zeit_s,weg_mm\n0,1\n", "RF105", None, "zeit_s, weg_mm", "ropefric inspect"),
    "two forces": ("time_s,force_N,Force (V)\n0,1,2\n", "RF105", None, "meaning of the columns", ""),
    "two columns in newtons": ("t/s,left/N,right/N\n0,1,2\n1,2,3\n", "RF105", None, "left/N, right/N", ""),
    "no header": ("0,1.5\n1,2.5\n", "RF105", None, "without names", "column = 1"),
}  # fmt: skip


def test_damage_is_told_with_place_and_remedy(write):
    for case, (content, code, line, words, fix) in CORPUS.items():
        error = refused(write(content))
        assert (error.code, error.problem.line) == (code, line), case
        assert words in str(error), case
        assert fix in error.fix, case


def test_a_decimal_comma_after_the_first_64_kilobytes_is_told(write):
    rows = [f"{i};{i}" for i in range(20000)]
    rows[15000] = "15000;12,47"
    error = refused(write("time_s;force_1\n" + "\n".join(rows)), ImportProfile(channels=BY_NUMBER))
    assert (error.code, error.where) == ("RF102", "run.csv:15002 force_1")
    assert "decimal comma" in str(error)
    assert error.fix == '[import] decimal = ","'


def test_grouped_thousands_are_read_where_they_are_plain(write):
    for cells, decimal in (("1,234.5", "."), ("1.234,5", ","), ("1,234,567", "."), ('"1,234.5"', ".")):
        separator = "," if '"' in cells else ";"
        path = write(f"time_s{separator}force_N\n0{separator}{cells}\n1{separator}12{decimal}5\n")
        (trace,) = read_recordings(path, ImportProfile())
        whole = 1234567 if cells.count(",") > 1 else 1234.5
        assert trace.columns["force"].tolist() == [whole, 12.5]
        assert any("groups thousands" in note for note in trace.notes)
    swiss = ImportProfile(thousands="'", decimal=".")
    assert columns(write("time_s;force_N\n0;1'234.5\n1;2345\n"), swiss)["force"].tolist() == [1234.5, 2345]
    assert refused(write("time_s;force_N\n0;1'234.5\n1;23'45\n"), swiss).problem.line == 3


def test_an_ambiguous_comma_is_settled_by_the_profile_or_by_another_cell(write):
    path = write("time_s;force_N\n0;1,234\n1;2,345\n")
    assert columns(path, ImportProfile(decimal=","))["force"].tolist() == [1.234, 2.345]
    assert refused(path, ImportProfile(decimal=".")).code == "RF102"  # never 1234
    assert columns(write("time_s;force_N\n0;1,234\n1;0,345\n"))["force"].tolist() == [1.234, 0.345]
    assert columns(write("time_s;force_N\n0;1,234\n1;2,3\n"))["force"].tolist() == [1.234, 2.3]


def test_quoted_decimal_commas_between_commas(write):
    path = write('time_s,force_N\n"0,1","12,47"\n"0,2","12,5"\n')
    for decimal in ("", ","):
        found = columns(path, ImportProfile(decimal=decimal))
        assert (found["time"].tolist(), found["force"].tolist()) == ([0.1, 0.2], [12.47, 12.5])


def test_one_column_is_told_from_two_by_header_or_profile(write):
    one = write("force_N\n12,47\n13,01\n")
    assert refused(one, ImportProfile(sampling_rate_Hz=100.0)).code == "RF104"
    with_rate = ImportProfile(sampling_rate_Hz=100.0, decimal=",")
    assert columns(one, with_rate)["force"].tolist() == [12.47, 13.01]
    plain = write("force_N\n12.47\n13.01\n")
    assert columns(plain, ImportProfile(sampling_rate_Hz=100.0))["force"].tolist() == [12.47, 13.01]
    two = columns(write("time_s,force_N\n12,47\n13,01\n"))
    assert two["force"].tolist() == [47, 1]
    two = columns(write("12,47\n13,01\n"), ImportProfile(header_row=0, channels=BY_NUMBER))
    assert two["force"].tolist() == [47, 1]


def test_a_blank_line_in_a_single_column_may_be_a_sample(write):
    error = refused(write("force_N\n1.5\n\n2.5\n"), ImportProfile(sampling_rate_Hz=100.0))
    assert error.code == "RF103"


def test_missing_values_become_nan_and_a_number_can_mean_missing(write):
    path = write("time_s,force_N\n0,\n0.1,nan\n0.2,NaN\n0.3,-9999\n0.4, \n0.5,OVL\n0.6,7\n")
    force = columns(path, ImportProfile(missing=("-9999", "OVL")))["force"]
    assert np.isnan(force).tolist() == [True] * 6 + [False]
    for cell, end in product(("-999", " -999", "-999.0"), ("", '0.3,"7"\n')):  # quotes are read the slow way
        force = columns(write(HEAD + f"0,1\n0.1,{cell}\n0.2,2\n" + end), ImportProfile(missing=("-999",)))[
            "force"
        ]
        np.testing.assert_array_equal(force[:3], [1.0, np.nan, 2.0])


HARMLESS = [GOOD.replace("\n", "\n\n"), GOOD + "\n \n\n", GOOD.replace("\n", ",\n"),
    GOOD.replace("0.1,", " 0.1 , "), GOOD.replace(HEAD, HEAD.replace("\n", ",\n")),
    GOOD.replace(HEAD, "# rig 2\n# " + HEAD), GOOD.replace(HEAD,
    "Test of March\n\nOperator,Jo\nSamples,30\n" + HEAD), GOOD.replace(HEAD, "time,force\ns,N\n"),
    GOOD.replace(HEAD, "time,force\n[s],[N]\n\n"), GOOD.replace(HEAD, '"time_s","force_N"\n'),
    GOOD.replace(HEAD, "time_s,force_N,Comment\n"), ("\ufeff" + GOOD).encode("utf-16-be")]  # fmt: skip
"""Beside the dialects of `test_dialects.py`."""


def test_harmless_habits_change_nothing(write):
    for content in HARMLESS:
        (found,) = read_recordings(write(content), ImportProfile())
        np.testing.assert_array_equal(found.columns["time"], [round(i * 0.1, 1) for i in range(30)])
        np.testing.assert_array_equal(found.columns["force"], [i * 1.5 for i in range(30)])
        assert found.units == {"time": "s", "force": "N"}


def test_line_of_the_first_sample_is_known_unless_blank_lines_move_it(write):
    assert read_recordings(write(GOOD), ImportProfile())[0].first_line == 2
    assert read_recordings(write("x\n" + GOOD + "\n\n"), ImportProfile())[0].first_line == 3
    assert read_recordings(write(GOOD.replace("\n", "\n\n")), ImportProfile())[0].first_line == 0


def test_a_text_column_that_nobody_asked_for_does_no_harm(write):
    found = columns(write("time_s,event,force_N\n0,start,1\n1,,2\n2,stop,3\n"))
    assert found["force"].tolist() == [1, 2, 3]


def test_duplicate_headers_are_an_error_only_when_asked_for(write):
    path = write("Time.(s),force_N,Time.(s)\n0,1,5\n1,2,6\n")
    force = {"force": Channel(column="force_N")}
    assert columns(path, ImportProfile(channels=force))["force"].tolist() == [1, 2]
    error = refused(path, ImportProfile(channels={**force, "time": Channel(column="Time.(s)")}))
    assert error.code == "RF105"
    assert "numbers 1, 3" in str(error)


def test_column_errors_say_what_there_is(write):
    path = write(GOOD)
    error = refused(path, ImportProfile(channels={"force": Channel(column="froce_N")}))
    assert (error.code, error.fix) == ("RF105", "did you mean 'force_N'?")
    for number in (0, 3, -1):
        error = refused(path, ImportProfile(channels={"force": Channel(column=number)}))
        assert error.code == "RF105"
        assert "from 1 to 2" in error.fix
    error = refused(write("0,1.5\n1,2.5\n"), ImportProfile(channels={"force": Channel(column="F")}))
    assert "by name" in str(error)


def test_files_that_are_not_there_or_not_theirs(tmp_path, write):
    assert "no such file" in str(refused(tmp_path / "none.csv"))
    assert "folder" in str(refused(tmp_path, ImportProfile(format="delimited")))
    assert "not gzip" in str(refused(write(GOOD, "run.csv.gz")))
    assert "no reader is known" in str(refused(write("MZ\0\1\2", "run.xyz")))
    assert columns(write(GOOD, "run.xyz"), ImportProfile(format="delimited"))
    error = refused("a\x00b.csv")
    assert error.code == "RF101"


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_a_file_without_permission(write):
    path = write(GOOD)
    path.chmod(0)
    assert "permission" in str(refused(path)).lower()


PROFILES = (
    ("RF108", "no text encoding", {"encoding": ("utf-9", "hex")}),
    ("RF108", "cannot be read as ascii", {"encoding": ("ascii",)}),
    ("RF101", "no data|last line", {"data_row": (500, 100000), "header_row": (500,), "units_row": (400,)}),
    (
        "",
        "cannot be used",
        {"separator": ("::", "5", "§"), "decimal": (";",), "header_row": (-2,), "data_row": (-1,)},
    ),
    ("", "did you mean 'delimited'", {"format": ("delimeted",)}),
)


def test_a_profile_that_fits_no_file_or_contradicts_itself_is_told(write):
    path = write("Prüfung\n" + GOOD)
    for code, words, changes in PROFILES:
        for key, value in ((key, value) for key, values in changes.items() for value in values):
            kind = DataError if code else (InputError, UnknownNameError)
            with pytest.raises(kind, match=words) as caught:
                read_recordings(path, ImportProfile(**{key: value}))
            assert not code or caught.value.code == code, (key, value)
    with pytest.raises(InputError, match="cannot be used"):
        read_recordings(path, ImportProfile(header_row=3, data_row=2))


def test_data_far_down_a_file_are_found_by_the_profile(write):
    junk = "".join(f"remark {i}\n" for i in range(9000))  # more than the first 64 kB
    path = write(junk + GOOD)
    assert columns(path, ImportProfile(header_row=9001))["force"].size == 30


WIDE = "F,t,,\nN,s,,\nA,,B,\n0,0,5,0\n1,1,6,1\n2,2,,\n"


@pytest.mark.parametrize("content", [WIDE, WIDE.replace("2,2,,", "2,2"), WIDE.replace("\n", ",\n")])
def test_wide_blocks_may_end_early(write, content):
    profile = ImportProfile(
        header_row=1, units_row=2, block_names_row=3, data_row=4, block_columns=2,
        channels={"time": Channel(column="t"), "force": Channel(column="F")},
    )  # fmt: skip
    first, second = read_recordings(write(content), profile)
    assert (first.name, second.name) == ("run.csv#A", "run.csv#B")
    assert (first.columns["force"].tolist(), second.columns["force"].tolist()) == ([0, 1, 2], [5, 6])
    assert second.units == {"time": "s", "force": "N"}


def test_wide_files_that_do_not_divide_are_refused(write):
    profile = ImportProfile(header_row=0, block_columns=3, channels=BY_NUMBER)
    assert refused(write("0,1,2,3\n1,1,6,1\n"), profile).code == "RF103"
    assert refused(write("0,1,2,3,4,5\n1,1,6,1\n"), profile).code == "RF103"
    named = ImportProfile(block_names_row=1, block_columns=2, data_row=2, channels=BY_NUMBER, header_row=0)
    error = refused(write("A,,A,\n0,1,2,3\n"), named)
    assert "two recordings are called 'A'" in str(error)
    assert "block_columns" in refused(write(GOOD), ImportProfile(format="wide")).fix
