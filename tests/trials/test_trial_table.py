"""Trial tables: what reads, and what every kind of bad table says."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from ropefric.errors import DataError, InputError
from ropefric.trials.table import TrialTable, read_trial_table, table_from_frame

HEADER = "trial,wheel_radius_mm,rope_diameter_mm,wrap_angle_deg,end_tension_N,peak_N"
ROWS = ["a,40,9.8,540,80,300", "b,40,9.8,540,80,310", "c,20,9.8,720,80,400"]


@pytest.fixture
def read(tmp_path):
    def reader(*lines, encoding="utf-8"):
        path = tmp_path / "pulls.csv"
        path.write_bytes("\n".join(lines).encode(encoding) + b"\n")
        return read_trial_table(path)

    return reader


def problems(read, *lines):
    with pytest.raises(DataError) as caught:
        read(*lines)
    return caught.value.problems


def test_units_stand_in_the_header_and_end_as_si(read):
    table = read(
        "Wheel radius (cm),rope_radius_um,wrap_turns,end_mass_kg,Lift force [kN],kept,wrap_angle_std_deg,peak_std_N",
        "4,4900,1.5,2,0.3,true,1,",
        "4,4900,1.5,2,0.4,no,1,2",
        "4,4900,1.5,2,0.5,1,1,2",
    )
    assert (table.wheel_radius_m.tolist(), table.rope_radius_m.tolist()) == ([0.04] * 3, [0.0049] * 3)
    assert table.wrap_angle_rad == pytest.approx(3 * np.pi)
    assert (table.end_tension_N, table.peak_N.tolist()) == (pytest.approx(2 * 9.80665), [300, 400, 500])
    assert table.wrap_std_rad == pytest.approx(np.pi / 180)
    assert np.isnan(table.peak_std_N[0])
    assert (table.peak_std_N[1], table.kept.tolist()) == (2, [True, False, True])
    assert table.end_tension_std_N.tolist() == [0, 0, 0]


def test_dialects_read_alike(read):
    for lines in ([HEADER, *ROWS], [HEADER.replace(",", ";"),
        *(row.replace(",", ";").replace(".", ",") for row in ROWS)],
        [HEADER.replace(",", "\t"), *(row.replace(",", "\t") for row in ROWS)],
        ["# measured in May", HEADER, "", *ROWS, ",,,,,"], ["\ufeff" + HEADER, *ROWS],
        [HEADER + ",kinetic_N,operator", *(row + ",200,Anna" for row in ROWS)]):  # fmt: skip
        table = read(*lines)
        assert table.trial == ("a", "b", "c"), lines
        assert table.rope_radius_m == pytest.approx(0.0049, rel=1e-15), lines
        assert table.peak_N.tolist() == [300, 310, 400], lines
        assert table.group().tolist() == [0, 0, 1], lines


def test_rows_whose_coefficient_no_rope_has_are_told(read):
    assert read(HEADER, *ROWS).warnings == ()
    (low,) = read(HEADER.replace("angle_deg", "angle_rad"), *ROWS).warnings
    assert (low.code, low.line, low.message.partition(" ")[0]) == ("RF140", 2, "3")
    (odd,) = read(HEADER, *ROWS, "d,40,9.8,9.42,80,300").warnings
    assert (odd.code, odd.line, odd.message[-3:]) == ("RF140", 5, ": 8")


def test_missing_column_names_it_and_one_to_add(read):
    found = problems(
        read, "wheel_radius_mm,wrap_angle_deg,end_tension_N,peak_N", "40,540,80,300", "40,540,80,310"
    )
    assert [problem.code for problem in found] == ["RF121"]
    assert "no column for the rope radius" in found[0].message
    assert "rope_diameter_mm" in found[0].fix
    assert found[0].where.endswith("pulls.csv:1")


HEADERS = [
    ("wrap_angle", "RF130", "wrap_angle_deg"),
    ("wrap_angle_mm", "RF130", "'mm' is not a unit of angle"), ("wrap_angle (furlongs per)", "RF130", "unit"),
]  # fmt: skip
CELLS = [
    ("d,40,9.8,540,80,80", "peak_N", "80 N is not above the end tension 80 N", "exchanged"),
    ("d,40,9.8,-540,80,300", "wrap_angle_deg", "-540 deg is no possible value", "correct"),
    ("d,40,9.8,,80,300", "wrap_angle_deg", "empty or NaN", "kept = false"),
    ("d,40,9.8,540,80,about 300", "peak_N", "cannot read 'about 300' as a number", "plain number"),
    ("d,40,9.8,540,80 N,300", "end_tension_N", "cannot read '80 N'", "without a unit"),
    ("d,40,9.8,540,80,1'300", "peak_N", "cannot read", "marks between thousands"),
    ('d,40,"9,8",540,80,300', "rope_diameter_mm", "decimal comma", "write 9.8"),
    ("d,0,9.8,540,80,300", "wheel_radius_mm", "must be above zero", "correct"),
    ("d,40,9.8,540,80,-300", "peak_N", "no possible value", "correct"),
    ("d,40,9.8,540,80,inf", "peak_N", "cannot read", ""),
    ("d,40,9.8,540,80,1e999", "peak_N", "finite", ""),
    ("a,40,9.8,540,80,305", "trial", "'a' is in line 2 already", "name of its own"),
]  # fmt: skip


def test_wrong_names_and_units_of_columns_and_bad_cells_say_what_where_and_how_to_fix(read):
    found = problems(read, HEADER.replace("wrap_angle_deg", "warp_angle_deg"), *ROWS)
    assert {problem.code: problem.severity for problem in found} == {"RF121": "error"}
    for header, code, said in HEADERS:
        found = problems(read, HEADER.replace("wrap_angle_deg", header), *ROWS)
        assert [problem.code for problem in found] == [code], "and not that the column is missing as well"
        assert said in str(found[0])
        assert (found[0].line, found[0].key) == (1, header)
    for row, key, said, fix in CELLS:
        (found,) = problems(read, HEADER, *ROWS, row)
        assert said in found.message, row
        assert fix in found.fix, row
        assert (found.line, found.key) == (5, key), row


def test_an_empty_force_costs_its_trial_and_not_the_table(read):
    table = read(HEADER, *ROWS, "d,40,9.8,540,80,nan")
    assert (len(table), int(table.used.sum()), bool(table.used[3])) == (4, 3, False)
    (found,) = table.warnings
    assert (found.line, found.key, found.severity) == (5, "peak_N", "warning")
    assert "left out" in found.message


def test_all_problems_come_at_once(read):
    found = problems(read, HEADER, "a,40,9.8,-1,80,300", "b,40,9.8,540,80,20", "c,x,9.8,540,80,300")
    assert [problem.line for problem in found] == [2, 3, 4]


def test_too_few_rows_are_no_table(read):
    (found,) = problems(read, HEADER, ROWS[0])
    assert found.code == "RF410"
    assert "1 of 1 trials can be used; a fit needs at least two" in found.message
    found = problems(read, HEADER + ",kept", *(row + ",false" for row in ROWS))
    assert "0 of 3" in found[0].message


def test_ragged_row_and_quotes(read):
    found = problems(read, HEADER, *ROWS, "d,40,9.8,540,80", 'e,"40,9.8,540,80,300')
    assert {problem.code for problem in found} == {"RF103"}
    assert sorted(problem.line for problem in found) == [5, 6]


def test_file_that_is_not_there_or_no_text(tmp_path):
    with pytest.raises(DataError, match="no such file"):
        read_trial_table(tmp_path / "gone.csv")
    (tmp_path / "binary.csv").write_bytes(bytes(range(256)) * 10)
    with pytest.raises(DataError):
        read_trial_table(tmp_path / "binary.csv")


def test_a_row_set_aside_may_lack_everything(read):
    table = read(HEADER + ",kept,status", *(row + ",true,ok" for row in ROWS), "d,40,9.8,540,80,,false,ok",
                 "e,40,9.8,540,80,,true,no-breakaway", "f,40,9.8,540,80,70,0,ok")  # fmt: skip
    assert table.used.tolist() == [True, True, True, False, False, False]
    assert len(table.conditions()) == len(table.log_lift()) == 3


def test_kept_must_be_yes_or_no(read):
    found = problems(read, HEADER + ",kept", ROWS[0] + ",perhaps", *(row + ",yes" for row in ROWS[1:]))
    assert "'perhaps' does not say" in found[0].message


def test_rows_alike_in_every_number_are_a_warning(read):
    table = read(HEADER, *ROWS, *(f"{name},40,9.8,540,80,300" for name in "def"))
    (told,) = table.warnings
    assert (told.severity, told.line) == ("warning", 5)
    assert "3 rows with all numbers of an earlier one" in told.message


def test_frame_round_trip_and_frame_errors():
    frame = pd.DataFrame({"trial": ["a", "b", "c"], "wheel_radius_mm": [40.0, 40.0, 20.0], "rope_diameter_mm": 9.8,
                          "wrap_turns": [1.5, 1.5, 2], "end_tension_N": [80, 80, 60], "peak_N": [300.1, 310, None],
                          "kept": [True, True, False], "peak_std_N": [1.0, np.nan, 2.0]})  # fmt: skip
    before = frame.copy()
    table = table_from_frame(frame)
    pd.testing.assert_frame_equal(frame, before)
    again = table_from_frame(table.to_frame())
    for name in ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N", "peak_N",
        "peak_std_N"):  # fmt: skip
        assert np.array_equal(getattr(table, name), getattr(again, name), equal_nan=True), name
    assert again.kept.tolist() == [True, True, False]
    with pytest.raises(DataError, match="DataFrame:2 peak_N"):
        table_from_frame(frame.assign(peak_N=[300, 20, 310]))
    with pytest.raises(DataError, match="no column for"):
        table_from_frame(frame[["trial"]])
    with pytest.raises(DataError):
        table_from_frame(pd.DataFrame())


def test_slack_side_measured_against_a_known_weight_is_one_condition():
    """Where F_B is what the cell reads, repeats share F_A."""
    table = TrialTable(trial=tuple("abcd"), wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=3.0,
                       end_tension_N=[20.1, 19.8, 40.3, 40.1], peak_N=[40, 40, 80, 80])  # fmt: skip
    assert table.group().tolist() == [0, 0, 1, 1]


def test_arrays_are_read_only_and_lengths_must_agree():
    table = TrialTable(trial=("a", "b"), wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=3.0,
                       end_tension_N=20, peak_N=[40, 41])  # fmt: skip
    with pytest.raises(ValueError, match="read-only"):
        table.peak_N[0] = 1
    with pytest.raises(InputError, match=r"peak_N has shape \(3,\) for 2 trials"):
        TrialTable(trial=("a", "b"), wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=3.0,
                   end_tension_N=20, peak_N=[40, 41, 42])  # fmt: skip


def test_of_many_rows_those_with_something_wrong_are_named(tmp_path):
    lines = ["trial,wheel_radius_mm,rope_diameter_mm,wrap_angle_deg,end_tension_N,peak_kN"]
    lines += [
        f"t{i},{30 + 10 * (i % 2)},9.8,{180 * (1 + i % 3)},20,{0.06 + 1e-6 * i:.7g}" for i in range(3000)
    ]
    lines[1500] = lines[1500].replace(",20,", ",2O,")
    lines[2000] = lines[2000].replace("t1999,", "t3,")
    lines[2500] = ",".join([*lines[2500].split(",")[:-1], "0.001"])
    path = tmp_path / "many.csv"
    path.write_text("\n".join(lines))
    with pytest.raises(DataError) as caught:
        read_trial_table(path)
    told = [(p.code, p.line) for p in caught.value.problems]
    assert told == [("RF102", 1501), ("RF411", 2501), ("RF122", 2001)]


def test_a_table_that_is_cut_off_within_its_last_cell_is_refused(tmp_path):
    """What `extract` writes ends each row with the recording's hash; half a copy of it is no table."""
    text = (Path(__file__).parents[2] / "fits" / "prth-trials.csv").read_text(encoding="utf-8")
    assert text.splitlines()[0].endswith(",sha256")
    path = tmp_path / "trials.csv"
    path.write_text(text, encoding="utf-8")
    assert len(read_trial_table(path)) > 400
    for start in (len(text) // 3, len(text) // 2, len(text) - 100):
        cut = text[: text.index("\n", start) - 20]  # into the hash
        path.write_text(cut, encoding="utf-8")
        with pytest.raises(DataError, match="44 of 64 digits: the table is cut off") as caught:
            read_trial_table(path)
        assert caught.value.problem.line == cut.count("\n") + 1
