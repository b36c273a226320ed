"""Trial tables and lists of trials as sheets mean what the same cells mean as CSV."""

import csv
import datetime as dt

import pytest

from ropefric.errors import DataError
from ropefric.trials.cells import read_cells
from ropefric.trials.table import read_trial_table

HEADER = ["trial", "wheel_radius_mm", "rope_diameter_mm", "wrap_angle_deg", "end_tension_N", "peak_N", "note"]
ROWS = [[f"w{i}", 40 if i % 2 else 35.5, 9.8, 180 + i, 60.25, 150.5 + i, "a; b"] for i in range(6)]


def save(path, rows, *, sheets=("Sheet",)):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.title = sheets[0]
    for row in rows:
        book.active.append(row)
    for name in sheets[1:]:
        book.create_sheet(name)
    book.save(path)
    return path


def test_a_trial_table_is_the_same_from_a_sheet(tmp_path):
    sheet = read_trial_table(save(tmp_path / "trials.xlsx", [["# of March"], [], HEADER, *ROWS]))
    with (tmp_path / "trials.csv").open("w", newline="", encoding="utf-8") as stream:
        csv.writer(stream).writerows([HEADER, *ROWS])
    text = read_trial_table(tmp_path / "trials.csv")
    assert sheet.peak_N.tolist() == text.peak_N.tolist()
    assert sheet.wheel_radius_m.tolist() == text.wheel_radius_m.tolist()
    assert sheet.wrap_angle_rad.tolist() == text.wrap_angle_rad.tolist()


def test_a_list_of_trials_is_read_from_a_sheet(lab):
    lab.pulls(a=100.0, b=110.0)
    head = ["file", "wheel_radius_mm", "wrap_angle_deg", "end_tension_N", "rope_id"]
    rows = [["a.csv", 40, "180,5", 20, 1], ["b.csv", 40, 180.5, 20, dt.date(2026, 1, 2)]]
    path = save(lab.folder / "trials.xlsx", [head, *rows])
    text = lab.path.read_text(encoding="utf-8")
    lab.path.write_text(
        text.replace(next(p.name for p in lab.folder.glob("*.csv") if p.stem == "trials"), path.name)
    )
    first, second = lab.extract().trials
    assert (first.wrap_angle_rad, first.rope_id, second.rope_id) == (second.wrap_angle_rad, "1", "2026-01-02")
    assert first.breakaway.status == "ok"


def test_rows_are_numbered_as_the_sheet_shows_them(tmp_path):
    rows = [HEADER, *ROWS[:2], [*ROWS[2][:5], "oops", ""]]
    with pytest.raises(DataError) as caught:
        read_trial_table(save(tmp_path / "trials.xlsx", rows))
    assert caught.value.where.endswith("trials.xlsx:4 peak_N")


def test_the_sheet_that_was_read_is_told_where_there_are_others(tmp_path):
    _, problems = read_cells(save(tmp_path / "trials.xlsx", [HEADER, *ROWS], sheets=("Trials", "Old")))
    assert [(p.severity, p.message) for p in problems] == [
        ("warning", "read from the sheet 'Trials', one of 2")
    ]


def test_what_is_no_sheet_is_told(tmp_path):
    path = tmp_path / "trials.xlsx"
    path.write_bytes(b"PK\x03\x04" + bytes(50))
    with pytest.raises(DataError, match="not a readable sheet"):
        read_cells(path)
