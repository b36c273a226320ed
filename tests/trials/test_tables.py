"""The three tables: what a spreadsheet, pandas and a plain reader find in them."""

import csv
import json
import math
from dataclasses import replace

import pandas as pd
import pytest

from ropefric.errors import Problem
from ropefric.trials.result import Extraction, write_tables

# The hand-over to fitting and the JSON of the command: these names may not change.
TRIAL_COLUMNS = {
    "trial", "file", "wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N", "peak_N", "peak_raw_N",
    "peak_time_s", "kinetic_N", "status", "kept",
}  # fmt: skip
CONDITION_COLUMNS = {
    "wheel_radius_m", "wrap_angle_rad", "end_tension_N", "n", "n_kept", "rejected", "mean_all_N", "std_all_N",
    "mean_kept_N", "std_kept_N",
}  # fmt: skip


def read(path):
    with path.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


@pytest.fixture(scope="module")
def bench_tables(bench_extraction, tmp_path_factory):
    return bench_extraction, write_tables(bench_extraction, tmp_path_factory.mktemp("out") / "new" / "folder")


def test_names_and_headers(bench_tables):
    _, (trials, conditions, problems) = bench_tables
    assert [path.name for path in (trials, conditions, problems)] == [
        "trials.csv",
        "conditions.csv",
        "problems.csv",
    ]
    assert set(read(trials)[0]) >= TRIAL_COLUMNS
    assert set(read(conditions)[0]) >= CONDITION_COLUMNS
    assert list(read(problems)[0]) == ["severity", "code", "path", "line", "key", "message", "fix"]


def test_plain_text_that_every_program_reads(bench_tables):
    for path in bench_tables[1]:
        data = path.read_bytes()
        assert b"\r" not in data
        assert data.endswith(b"\n")
        assert b"nan" not in data.lower().replace(b"nano", b"")
        data.decode("utf-8")


def test_every_digit_that_means_something_survives(bench_tables):
    extraction, (trials, *_) = bench_tables
    rows = read(trials)
    assert len(rows) == len(extraction.trials)
    for row, trial in zip(rows, extraction.trials, strict=True):
        assert row["trial"] == trial.trial
        assert row["kept"] == ("true" if trial.kept else "false")
        assert row["status"] == trial.breakaway.status.value
        for name in ("wrap_angle_rad", "end_tension_N", "wheel_radius_m"):
            assert float(row[name]) == getattr(trial, name), "what was set stays as it was given"
        for name in ("peak_N", "peak_std_N"):
            value = getattr(trial, name)
            assert row[name] == "" if math.isnan(value) else row[name] == repr(float(f"{value:.9g}"))


def test_pandas_reads_numbers_as_numbers(bench_tables):
    extraction, (trials, conditions, _) = bench_tables
    table = pd.read_csv(trials)
    assert table["kept"].dtype == bool
    assert table["peak_N"].isna().sum() == sum(math.isnan(trial.peak_N) for trial in extraction.trials)
    means = (
        table[table["kept"]].groupby(["wheel_radius_m", "wrap_angle_rad", "end_tension_N"])["peak_N"].mean()
    )
    told = pd.read_csv(conditions)
    assert len(means) == len(told)
    assert sorted(means) == pytest.approx(sorted(told["mean_kept_N"]), rel=1e-8), "both of nine digits"
    assert told["n_kept"].sum() == table["kept"].sum()


def test_rejected_names_stand_in_one_cell(bench_tables):
    extraction, (_, conditions, _) = bench_tables
    for row, condition in zip(read(conditions), extraction.conditions, strict=True):
        assert row["rejected"] == "; ".join(condition.rejected)


def test_what_goes_out_as_json_is_json(bench_extraction):
    told = bench_extraction.to_dict()
    text = json.dumps(told, allow_nan=False)
    assert json.loads(text) == told
    assert set(told["trials"][0]) >= TRIAL_COLUMNS
    assert set(told["conditions"][0]) >= CONDITION_COLUMNS


def test_the_same_extraction_gives_the_same_bytes_and_replaces_older_ones(bench_extraction, tmp_path):
    one = [path.read_bytes() for path in write_tables(bench_extraction, tmp_path)]
    (tmp_path / "trials.csv").write_text("old " * 500_000)
    assert [path.read_bytes() for path in write_tables(bench_extraction, tmp_path)] == one


def test_words_with_commas_quotes_and_line_ends_come_back(bench_extraction, tmp_path):
    words = 'the rope "jumped",\nφ = 540°; see p. 3'
    trial = replace(bench_extraction.trials[0], excluded=words)
    extraction = replace(
        bench_extraction,
        trials=(trial,),
        problems=(Problem(code="RF101", message=words, path="a,b.csv", line=3, key="k", fix='say "no"'),),
    )
    trials, _, problems = write_tables(extraction, tmp_path)
    assert read(trials)[0]["excluded"] == words
    (problem,) = read(problems)
    assert problem == {
        "severity": "error",
        "code": "RF101",
        "path": "a,b.csv",
        "line": "3",
        "key": "k",
        "message": words,
        "fix": 'say "no"',
    }


def test_no_problem_is_a_table_with_a_header(bench_extraction, tmp_path):
    *_, problems = write_tables(replace(bench_extraction, problems=()), tmp_path)
    assert problems.read_text(encoding="utf-8") == "severity,code,path,line,key,message,fix\n"


def test_an_extraction_of_nothing_can_be_written(tmp_path):
    nothing = Extraction(name="none", trials=(), conditions=(), problems=())
    assert [len(read(path)) for path in write_tables(nothing, tmp_path)] == [0, 0, 0]
