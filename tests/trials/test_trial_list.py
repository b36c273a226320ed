"""Every kind of mistake in trials.csv, and what is said of lists that are right but teach little."""

# ruff: noqa: E501  (a mistake a row reads better than a mistake a page)

import pytest

from ropefric.trials.campaign import load_campaign

# What is replaced, by what, code, line, key, part of the message, part of the fix.
MISTAKES = {
    "no unit": ("wrap_angle_deg", "wrap_angle", "RF130", 1, "wrap_angle", "no unit", "wrap_angle_deg"),
    "small n": ("end_tension_N", "end_tension_n", "RF121", 1, "end_tension_N", "there is no column end_tension_N", "or correct the name"),
    "unit of another dimension": ("end_tension_N", "end_tension_mm", "RF130", 1, "end_tension_mm", "'mm' is not a unit of force", "'N'"),
    "knots": ("end_tension_N", "end_tension (kn)", "RF130", 1, "end_tension (kn)", "knot", "'kN'"),
    "column twice": ("note", "wrap_turns", "RF122", 1, "wrap_turns", "same as 'wrap_angle_deg'", "remove one"),
    "no file column": ("file", "_file", "RF121", 1, "file", "no column file", "add the column file"),
    "no cell column": ("cell", "_cell", "RF121", 1, "cell", "force is in counts", "add the column cell"),
    "empty file": ("b.csv", "", "RF121", 3, "file", "file is empty", "fill"),
    "empty wrap": (",180,", ",,", "RF121", 2, "wrap_angle_deg", "wrap_angle_deg is empty; every trial needs a wrap angle", "fill"),
    "empty wheel": ("W40", "", "RF121", 2, "wheel_radius_mm", "every trial needs a wheel radius", "fill"),
    "unknown wheel": ("W40", "W4O", "RF120", 2, "wheel", "unknown wheel 'W4O'", "did you mean 'W40'?"),
    "two radii": ("W40,,", "W40,60,", "RF111", 2, "wheel_radius_mm", "60 mm, but wheel 'W40' has 40 mm", "leave one"),
    "text": ("60.5", "abc", "RF102", 4, "end_tension_N", "cannot read 'abc' as a number", "plain number"),
    "unit in the cell": ("60.5", "60.5 N", "RF102", 4, "end_tension_N", "cannot read '60.5 N'", "without a unit"),
    "thousands": ("60.5", "1 060.5", "RF102", 4, "end_tension_N", "1 060.5", "marks between thousands"),
    "quoted decimal comma": ("60.5", '"60,5"', "RF102", 4, "end_tension_N", "decimal comma", "write 60.5, or separate the columns by ';'"),
    "decimal comma": ("60.5", "60,5", "RF103", 4, "", "12 cells, but the header has 11", "decimal comma, separate the columns by ';'"),
    "nan": ("60.5", "nan", "RF102", 4, "end_tension_N", "cannot read 'nan'", "plain number"),
    "inf": ("60.5", "1e999", "RF130", 4, "end_tension_N", "not a finite number", ""),
    "zero tension": ("60.5", "0", "RF110", 4, "end_tension_N", "an end tension must be above zero", "correct"),
    "negative radius": (",35,", ",-35,", "RF110", 4, "wheel_radius_mm", "a wheel radius must be above zero", "correct"),
    "negative dwell": ("R1,0.5,,\n", "R1,-1,,\n", "RF110", 2, "dwell_min", "negative", "0 or more"),
    "too few cells": ("t2,b.csv,W60,,", "t2,b.csv,", "RF103", 3, "", "9 cells, but the header has 11 columns", "a cell for every column"),
    "open quote": ("see book", '"see book', "RF103", 3, "", "not closed", "close the quotes"),
    "column without a name": ("note", "", "RF120", 3, "", "column 11 has no name, but holds 'see book'", "name it"),
    "file twice": ("b.csv", "a.csv", "RF122", 3, "file", "a.csv is listed in line 2 already", "from_s and until_s"),
    "name twice": ("t2,", "t1,", "RF122", 3, "trial", "the name 't1' is given in line 2 already", "own name"),
    "missing recording": ("c.csv", "C.csv", "RF124", 4, "file", "the recording C.csv is not there", "recordings"),
    "endless name": ("c.csv", "c" * 300, "RF124", 4, "file", "is not there", "recordings"),
}  # fmt: skip


def test_every_mistake_is_told_with_its_place_and_remedy(bench):
    good = bench.table.read_bytes()
    for name, (old, new, code, line, key, message, fix) in MISTAKES.items():
        bench.write(trials=good)
        bench.spoil_table(old, new)
        problem = bench.only()
        assert (problem.code, problem.line, problem.key) == (code, line, key), name
        assert message in problem.message, name
        assert fix in problem.fix, name
        assert problem.path.endswith("/trials.csv"), name


ODD = [
    (b"", None, "empty"), (b"\n \n# only a comment\n", None, "empty"), (b"\x00\x01\x02", 1, "not a text file"),
    (b"file,wheel_radius_mm,wrap_angle_deg,end_tension_N,cell\n", 1, "no trials"), (b'"file\n', 1, "not closed"),
    (b"\x1f\x8b\x08\x00garbage", None, "gzip"), (b"a\n\x81\xff\n", 2, "cp1252"),
]  # fmt: skip


def test_odd_tables(bench):
    for content, line, message in ODD:
        bench.write(trials=content)
        problem = bench.errors()[0]
        assert problem.code in {"RF101", "RF103"}, content
        assert problem.line == line, content
        assert message in problem.message, content
        assert "[import]" not in str(problem), content


def test_a_decimal_comma_before_an_empty_cell_shifts_nothing_unseen(bench):
    head = "file,wheel_radius_mm,wrap_angle_deg,end_tension_N,cell,note\n"
    bench.write(trials=head + "a.csv,40,5,180,K1,,\n")
    assert (bench.only().code, bench.only().line) == ("RF103", 2)


def test_a_point_among_decimal_commas_is_refused(bench):
    head = "file;wheel_radius_mm;wrap_angle_deg;end_tension_N;cell\n"
    bench.write(trials=f"{head}a.csv;40;180;80,5;K1\nb.csv;40;180;1.250;K1\n")
    problem = bench.only()
    assert (problem.code, problem.line, problem.key) == ("RF102", 3, "end_tension_N")
    assert "write 1,250 if the point is a decimal mark" in problem.fix


def test_each_missing_recording_is_a_problem_of_its_row(bench):
    head = "file,wheel_radius_mm,wrap_angle_deg,end_tension_N,cell,exclude\n"
    bench.write(trials=head + "".join(f"no{i}.csv,40,180,80,K1,\n" for i in range(33)))
    errors = bench.errors()
    assert [one.line for one in errors] == [*range(2, 35)]
    assert errors[-1].message == "the recording no32.csv is not there"
    assert len({one.fix for one in errors}) == 1


def test_an_excluded_trial_may_lack_its_recording_but_not_its_numbers(bench):
    bench.spoil_table("b.csv", "lost.csv")
    assert (bench.errors(), [p.code for p in bench.warnings() if p.line == 3]) == ([], ["RF124"])
    bench.spoil_table("360", "abc")
    assert bench.only().code == "RF102"


def test_parts_of_one_recording_are_different_trials(bench):
    head = "file,wheel_radius_mm,wrap_angle_deg,end_tension_N,cell,from_s,until_s\n"
    bench.write(trials=head + "a.csv,40,180,80,K1,2,4\na.csv,40,180,80,K1,0,2\na.csv,40,180,80,K1,4,\n")
    assert (bench.errors(), [t.start_s for t in load_campaign(bench.path).trials]) == ([], [2.0, 0.0, 4.0])
    bench.write(trials=head + "a.csv,40,180,80,K1,2,4\na.csv,40,180,80,K1,0,2.5\n")
    assert (bench.only().code, bench.only().line) == ("RF122", 3)


def test_all_blocks_and_one_of_them(bench):
    head = "file,sample,wheel_radius_mm,wrap_angle_deg,end_tension_N,cell\n"
    bench.write(trials=head + "a.csv,S1,40,180,80,K1\na.csv,S2,40,180,80,K1\n")
    assert bench.errors() == []
    bench.write(trials=head + "a.csv,S1,40,180,80,K1\na.csv,*,40,180,80,K1\n")
    assert "'*' takes every block" in bench.only().fix


def test_an_interval_the_wrong_way(bench):
    head = "file,wheel_radius_mm,wrap_angle_deg,end_tension_N,cell,from_s,until_s\n"
    bench.write(trials=head + "a.csv,40,180,80,K1,5,4\nb.csv,40,180,80,K1,7,\n")
    first, second = bench.errors()
    assert (first.code, first.line, first.key) == ("RF111", 2, "until_s")
    # The second row's end is the campaign's 6 s.
    assert (second.line, second.message) == (3, "the part from 7 s until 6 s is empty")


def test_a_list_without_wheels_table(bench):
    bench.spoil(r"^\[wheels.*\n(.+\n)+?(?=\n|\[)", "", pattern=True)
    fixes = {p.fix for p in bench.errors()}
    assert "describe it under [wheels.W40] in the campaign file" in fixes
    head = "file,wheel,wrap_angle_deg,end_tension_N,cell\n"
    bench.write(trials=head + "a.csv,Rad A,180,80,K1\n")
    assert bench.only().fix == 'describe it under [wheels."Rad A"] in the campaign file'


DOUBTS = {
    "radius in metres": ("wheel_radius_mm", "wheel_radius_m", "wheel_radius", "35 m is outside 1 mm to 10 m"),
    "wrap in radians": ("wrap_angle_deg", "wrap_angle_rad", "wrap_angle", "turns is probably in another unit"),
    "no as a reason": ("rope jumped", "no", "exclude", "'no' is taken as a reason, so the trial is excluded"),
    "thick rope": (",35,", ",4,", "rope_diameter", "4.9 mm, is not below the wheel radius, 4 mm"),
}  # fmt: skip


def test_doubtful_values_are_warnings(bench):
    good = bench.table.read_bytes()
    for name, (old, new, key, message) in DOUBTS.items():
        bench.write(trials=good)
        bench.spoil_table(old, new)
        assert bench.errors() == [], name
        doubts = [p for p in bench.warnings() if p.code == "RF140"]
        assert {p.key for p in doubts} == ({key} if key else set()), name
        assert all(message in p.message for p in doubts), name


@pytest.fixture
def listed(bench):
    """Write a list of `n` recordings each of some conditions."""

    def listed(conditions, n, change=lambda lines: lines):
        names = [(f"{r}-{w}-{f}-{i}.csv", r, w, f) for r, w, f in conditions for i in range(n)]
        for name, *_ in names:
            bench.record(name)
        rows = [",".join(map(str, (*row, "K1"))) for row in names]
        head = "file,wheel_radius_mm,wrap_angle_deg,end_tension_N,cell"
        bench.write(trials="\n".join(change([head, *rows])))
        return bench

    return listed


def test_repeats_that_cannot_be_rejected(bench, listed):
    two = [(40, 180, 80), (50, 360, 120)]
    assert "RF310" not in {p.code for p in listed(two, 5).warnings()}  # by the rule of Grubbs they can
    bench.spoil('"grubbs"', '"two-sigma"')
    assert "RF310" not in {p.code for p in listed(two, 6).warnings()}
    (found,) = [p for p in listed(two, 5).warnings() if p.code == "RF310"]
    assert "2 of 2 conditions" in found.message
    assert "n <= 5" in found.message


def test_excluded_trials_do_not_count_as_repeats(bench, listed):
    bench.spoil('"grubbs"', '"two-sigma"')

    def excluded(lines):
        return [f"{lines[0]},exclude", f"{lines[1]},bad", *(f"{line}," for line in lines[2:])]

    told = listed([(40, 180, 80), (50, 360, 120)], 6, excluded).warnings()
    (found,) = [p for p in told if p.code == "RF310"]
    assert "1 of 2 conditions" in found.message
    assert "(fewest: 5)" in found.message
