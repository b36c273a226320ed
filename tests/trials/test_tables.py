"""The three tables: what a spreadsheet, pandas and a plain reader find in them."""

import csv
import json
import math
from dataclasses import asdict, replace

import pytest

from ropefric.errors import Problem
from ropefric.trials.result import Extraction, write_tables

# The hand-over to fitting and the JSON of the command: these names may not change.
TRIAL_COLUMNS = {
    "trial", "file", "wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N", "peak_N", "peak_raw_N",
    "peak_time_s", "probability", "kinetic_N", "status", "kept",
}  # fmt: skip
CONDITION_COLUMNS = {
    "wheel_radius_m", "wrap_angle_rad", "end_tension_N", "n", "n_kept", "rejected", "mean_all_N", "std_all_N",
    "mean_kept_N", "std_kept_N",
}  # fmt: skip


def read(path):
    with path.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


@pytest.fixture(scope="module")
def tables(small_extraction, tmp_path_factory):
    return small_extraction, write_tables(small_extraction, tmp_path_factory.mktemp("out") / "new" / "folder")


def test_names_headers_and_plain_text_that_every_program_reads(tables, tmp_path):
    extraction, paths = tables
    assert [path.name for path in paths] == ["trials.csv", "conditions.csv", "problems.csv"]
    trials, conditions, problems = map(read, paths)
    assert set(trials[0]) >= TRIAL_COLUMNS
    assert set(conditions[0]) >= CONDITION_COLUMNS
    assert list(problems[0]) == ["severity", "code", "path", "line", "key", "message", "fix"]
    for path in paths:
        data = path.read_bytes()
        assert b"\r" not in data
        assert data.endswith(b"\n")
        assert b"nan" not in data.lower().replace(b"nano", b"")
        data.decode("utf-8")
        (tmp_path / path.name).write_text("old " * 50_000)
    assert [p.read_bytes() for p in write_tables(extraction, tmp_path)] == [p.read_bytes() for p in paths]


def test_every_digit_that_means_something_survives(tables):
    extraction, (trials, conditions, _) = tables
    rows = read(trials)
    assert len(rows) == len(extraction.trials)
    for row, trial in zip(rows, extraction.trials, strict=True):
        assert (row["trial"], row["kept"]) == (trial.trial, "true" if trial.kept else "false")
        assert row["status"] == trial.breakaway.status.value
        for name in ("wrap_angle_rad", "end_tension_N", "wheel_radius_m"):
            assert float(row[name]) == getattr(trial, name), "what was set stays as it was given"
        for name in ("peak_N", "peak_std_N"):
            value = getattr(trial, name)
            assert row[name] == "" if math.isnan(value) else row[name] == repr(float(f"{value:.9g}"))
    rejected = ["; ".join(condition.rejected) for condition in extraction.conditions]
    assert [row["rejected"] for row in read(conditions)] == rejected
    assert any(rejected)


def test_what_goes_out_as_json_is_json(small_extraction):
    told = small_extraction.to_dict()
    assert json.loads(json.dumps(told, allow_nan=False)) == told
    assert set(told["trials"][0]) >= TRIAL_COLUMNS
    assert set(told["conditions"][0]) >= CONDITION_COLUMNS


def test_words_with_commas_quotes_and_line_ends_come_back(small_extraction, tmp_path):
    words = 'the rope "jumped",\nφ = 540°; see p. 3'
    told = Problem(code="RF101", message=words, path="a,b.csv", line=3, key="k", fix='say "no"')
    trial = replace(small_extraction.trials[0], excluded=words)
    trials, _, problems = write_tables(replace(small_extraction, trials=(trial,), problems=(told,)), tmp_path)
    assert read(trials)[0]["excluded"] == words
    (problem,) = read(problems)
    assert problem == {name: str(value) for name, value in asdict(told).items()}


def test_an_extraction_of_nothing_can_be_written(tmp_path):
    nothing = Extraction(name="none", trials=(), conditions=(), problems=())
    paths = write_tables(nothing, tmp_path)
    assert [len(read(path)) for path in paths] == [0, 0, 0]
    assert paths[2].read_text(encoding="utf-8") == "severity,code,path,line,key,message,fix\n"
