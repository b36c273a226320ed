"""LabVIEW measurement files, written by NI's published description: what is told of them must come out."""

import numpy as np
import pytest
from reading import read, refused

from ropefric.errors import DataError
from ropefric.traces.readers import find_reader, read_recordings
from ropefric.traces.readers.inspection import inspect_file
from ropefric.traces.readers.profile import Channel, ImportProfile

FORCE = [0.5, 1.25, 2.0, 1.5]


def general(*, columns="No", separator="Tab", mark="\t", decimal="."):
    tags = [
        ("LabVIEW Measurement", ""), ("Writer_Version", "2"), ("Reader_Version", "2"), ("Separator", separator),
        ("Decimal_Separator", decimal), ("Multi_Headings", "Yes"), ("X_Columns", columns), ("Time_Pref", "Absolute"),
        ("Operator", "JS"), ("Date", "2024/02/19"), ("Time", "09:51:39.1970510124996275989"),
    ]  # fmt: skip
    return (
        "".join(f"{tag}{mark}{value}\r\n" for tag, value in tags) + f"***End_of_Header***{mark}\r\n{mark}\r\n"
    )


def block(names, rows, *, units=("Newtons",), time="09:51:40.5", step="0.01", mark="\t", gap="", x0="0.0E+0"):
    n = len(units)
    tags = [
        ("Channels", [str(n)]), ("Samples", [str(len(rows))] * n), ("Date", ["2024/02/19"] * n), ("Time", [time] * n),
        ("Y_Unit_Label", units), ("X_Dimension", ["Time"] * n), ("X0", [x0] * n),
        ("Delta_X", step.split() if " " in step else [step] * n),
    ]  # fmt: skip
    head = "".join(mark.join([tag, *_gapped(cells, gap)]) + f"{mark}\r\n" for tag, cells in tags)
    table = "".join(mark.join(row) + "\r\n" for row in [names, *rows])
    return head + f"***End_of_Header***{mark * 3}\r\n{table}\r\n"


def _gapped(cells, gap):
    return [cell for one in cells for cell in ((one, "") if gap else (one,))]


def test_without_x_columns_the_time_is_start_and_steps(write):
    rows = [["", f"{f}", f"{10 * f}"] for f in FORCE]
    text = general() + block(["X_Value", "Force", "Way", "Comment"], rows, units=("Newtons", "mm"), x0="0.25")
    path = write(text, "run.lvm")
    (trace,) = read(path)
    assert trace.force_N.tolist() == FORCE
    np.testing.assert_allclose(trace.time_s, [0.25, 0.26, 0.27, 0.28], rtol=1e-12)
    assert "LabVIEW measurement of 1 header block, X columns: no" in trace.notes
    found = inspect_file(path)
    assert (found.format, found.n_rows, found.sampling_rate_Hz) == ("labview", 4, 100)
    assert [(c.name, c.unit) for c in found.columns[1:3]] == [("Force", "N"), ("Way", "mm")]
    assert found.doubts == ()


def test_it_is_known_by_its_first_line_whatever_it_is_called(write):
    text = general() + block(["X_Value", "Force", "Comment"], [["", "1"], ["", "2"]])
    assert read(write(text, "run.txt"))[0].force_N.tolist() == [1, 2]
    assert (
        find_reader("run.lvm", ImportProfile()).name == "delimited"
    )  # an .lvm without headers is a plain table
    assert read_recordings(write("time_s\tforce_N\n0\t1\n1\t2\n", "bare.lvm"), ImportProfile())[0].columns


def test_one_x_column_and_comments_on_some_rows(write):
    rows = [[f"{i / 100}", f"{f}", *(["rope jumped"] if i in (0, 2) else [])] for i, f in enumerate(FORCE)]
    text = general(columns="One") + block(["X_Value", "Force", "Comment"], rows)
    (trace,) = read(write(text, "run.lvm"))
    assert trace.force_N.tolist() == FORCE
    np.testing.assert_array_equal(trace.time_s, [0, 0.01, 0.02, 0.03])


@pytest.mark.parametrize(("separator", "mark", "decimal"),
    [("Tab", "\t", ","), ("Comma", ",", "."), ("Semicolon", ";", ","), ("Tab", "\t", ".")])  # fmt: skip
def test_separators_and_decimal_marks_are_those_of_the_header(write, separator, mark, decimal):
    rows = [[f"{i / 100}".replace(".", decimal), f"{f}".replace(".", decimal)] for i, f in enumerate(FORCE)]
    text = general(columns="One", separator=separator, mark=mark, decimal=decimal)
    text += block(["X_Value", "Force", "Comment"], rows, mark=mark, step=f"0{decimal}01")
    (trace,) = read(write(text, "run.lvm"))
    assert (trace.force_N.tolist(), trace.time_s[3]) == (FORCE, 0.03)


def test_every_channel_may_have_its_own_x(write):
    rows = [[f"{i / 100}", f"{f}", f"{i / 50}", f"{i}"] for i, f in enumerate(FORCE)]
    names = ["X_Value", "Force", "X_Value", "Way", "Comment"]
    text = general(columns="Multi") + block(names, rows, units=("Newtons", "mm"), gap=" ", step="0.01 0.02")
    path = write(text, "run.lvm")
    (trace,) = read(path)
    np.testing.assert_array_equal(trace.time_s, [0, 0.01, 0.02, 0.03])
    way = {"way": Channel(column="Way"), "force": Channel(column="Force")}
    (both,) = read(path, channels=way | {"end_tension": Channel(column="Way", unit="N", instead_of="mm")})
    np.testing.assert_array_equal(both.time_s, [0, 0.01, 0.02, 0.03])
    np.testing.assert_array_equal(both.end_tension_N, [0, np.nan, 1, np.nan])
    newtons = Channel(column="Way", unit="N", instead_of="mm")
    named = {"time": Channel(column=3, unit="s"), "force": newtons}
    assert read(path, channels=named)[0].time_s.tolist() == [0, 0.02, 0.04, 0.06]


def test_the_only_x_column_is_not_lent_to_channels_with_other_steps(write):
    rows = [[f"{i / 100}", f"{i}", f"{f}"] for i, f in enumerate(FORCE)]
    text = general(columns="One")
    text += block(["X_Value", "Way", "Force", "Comment"], rows, units=("mm", "Newtons"), step="0.01 0.02")
    assert "no time channel" in str(refused(write(text, "run.lvm")))


def test_blocks_with_one_x_column_go_on_by_their_dates(write):
    rows = [["0", "1"], ["0.01", "1.5"]]
    parts = (block(["X_Value", "Force", "Comment"], rows, time=f"10:00:{start}") for start in ("00", "00.02"))
    (trace,) = read(write(general(columns="One") + "".join(parts), "run.lvm"))
    np.testing.assert_allclose(trace.time_s, [0.0, 0.01, 0.02, 0.03], atol=1e-12)
    assert trace.force_N.tolist() == [1, 1.5, 1, 1.5]


def blocks(*starts):
    parts = (block(["X_Value", "Force", "Comment"], [["", f"{k}"], ["", f"{k}.5"]], time=f"10:00:{start}")
        for k, start in enumerate(starts, start=1))  # fmt: skip
    return general() + "".join(parts)


def test_blocks_that_go_on_are_one_recording(write):
    (trace,) = read(write(blocks("00.00", "00.02", "00.04"), "run.lvm"))
    assert trace.force_N.tolist() == [1, 1.5, 2, 2.5, 3, 3.5]
    np.testing.assert_allclose(trace.time_s, np.arange(6) / 100, atol=1e-12)
    assert "by their times the blocks make 1 recording" in trace.notes


def test_blocks_with_a_pause_between_them_are_recordings_of_their_own(write):
    path = write(blocks("00.00", "00.02", "30.00"), "run.lvm")
    first, second = read(path)
    assert (first.name, second.name) == ("run#1", "run#2")
    assert (first.force_N.size, second.force_N.tolist()) == (4, [3, 3.5])
    assert "by their times the blocks make 2 recordings" in second.notes
    assert inspect_file(path).samples == ("1", "2")


def test_units_that_are_not_told_are_not_made_up(write):
    text = general(columns="One") + block(["X_Value", "Force", "Comment"], [["0", "1"], ["0.01", "2"]])
    path = write(text.replace("Y_Unit_Label\tNewtons\t\r\n", ""), "run.lvm")
    units = {column.name: column.unit for column in inspect_file(path).columns}
    assert units == {"X_Value": "s", "Force": "", "Comment": ""}


def test_special_blocks_are_passed_over(write):
    special = "***Start_Special***\r\n1\t2\r\n***End_Special***\r\n"
    text = general() + special + block(["X_Value", "Force", "Comment"], [["", "1"], ["", "2"]])
    assert read(write(text, "run.lvm"))[0].force_N.tolist() == [1, 2]


GOOD = general() + block(["X_Value", "Force", "Comment"], [["", "1"], ["", "2"], ["", "3"]])


def test_what_is_broken_is_told(write):
    for text, code, line, words, fix in (
        (general(), "RF103", None, "no second ***End_of_Header***", "delimited"),
        (GOOD.replace("\t2\r\n", "\toops\r\n"), "RF102", 25, "'oops'", "missing"),
        (GOOD.replace("\t2\r\n", "\t2\t3\t4\r\n"), "RF103", 25, "4 values", "mend"),
        (
            GOOD.replace("X_Dimension\tTime", "X_Dimension\tFrequency"),
            "RF103",
            23,
            "'Frequency'",
            "time as X",
        ),
        (GOOD.replace("Separator\tTab", "Separator\tWord"), "RF103", 1, "'Word'", "delimited"),
        (GOOD[: GOOD.index("\t1\r\n")], "RF101", None, "no block has data rows", "again"),
    ):
        error = refused(write(text, "run.lvm"))
        assert (error.code, error.problem.line) == (code, line)
        assert words in str(error)
        assert fix in error.fix


def test_any_cut_of_the_file_is_read_or_refused(write):
    for size in range(0, len(GOOD), 7):
        try:
            read(write(GOOD[:size], "run.lvm"))
        except DataError as error:
            assert error.code.startswith(("RF1", "RF2"))  # noqa: PT017


def test_a_last_number_that_is_cut_is_left_out_and_a_footer_told(write):
    rows = [["", "10.5"], ["", "11.5"], ["", "12.5"]]
    text = general() + block(["X_Value", "Force", "Comment"], rows)
    cut = text[: text.rindex(".5")]
    assert read(write(cut, "run.lvm"))[0].force_N.tolist() == [10.5, 11.5]
    (trace,) = read(write(text.rstrip() + "\r\nEnd of test\r\n", "run.lvm"))
    assert trace.force_N.tolist() == [10.5, 11.5, 12.5]
    assert any("End of test" in note for note in trace.notes)
