"""`cost`: errors and times of numerical choices, measured here and now."""

import csv

import pytest

from ropefric.accuracy import measure
from ropefric.accuracy.measure import error_table
from ropefric.cli.app import main


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    """One quick study through the program."""
    folder = tmp_path_factory.mktemp("cost") / "out"
    assert main(["cost", "integral", "--quick", "--out", str(folder), "--quiet"]) == 0
    return folder


def test_it_writes_figures_tables_and_a_page(measured):
    names = {path.name for path in measured.iterdir() if path.is_file()}
    assert names == {
        "integral.png",
        "integral.csv",
        "cost.md",
        "cost.html",
    }
    with (measured / "integral.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert {row["case"] for row in rows} == {"regular", "many", "from-zero", "near-minus-one", "short-wrap"}
    assert all(float(row["seconds"]) > 0.0 for row in rows)
    assert all(float(row["error"]) >= 0.0 for row in rows)
    assert "the closed form" in (measured / "cost.md").read_text(encoding="utf-8")


def test_the_result_is_json_and_progress_goes_elsewhere(call, tmp_path):
    done = call("cost", "end-tension", "end-tension", "--quick", "--out", tmp_path / "out", "--json")
    assert done.code == 0
    facts = done.json()
    assert facts["quick"] is True
    assert facts["machine"]["cores"] >= 1
    (study,) = facts["studies"]
    assert study["name"] == "end-tension"
    assert [row["accuracy"] for row in study["cheapest"]["power"]] == [10.0**-n for n in range(2, 13)]
    assert {point["case"] for point in study["points"]} == set(study["cheapest"])
    known = {(row.method, row.setting): row.error for row in error_table("end-tension", "power")}
    for point in study["points"]:
        if point["case"] == "power":
            assert point["error"] == known[point["method"], point["setting"]], "errors know no clock"
    assert any(path.endswith("cost.html") for path in facts["written"])
    assert "measuring on" in done.err
    assert "100 %" in done.err


def test_what_an_interrupted_run_measured_is_kept_until_the_whole_is(call, tmp_path, monkeypatch):
    done, whole = [], measure.time_call

    def timed(setting, effort):
        done.append(setting)
        if len(done) == 3:
            raise KeyboardInterrupt
        return whole(setting, effort)

    monkeypatch.setattr(measure, "time_call", timed)
    said = call("cost", "end-tension", "--quick", "--out", tmp_path / "out")
    kept = tmp_path / "out" / ".cache" / "cost.jsonl"
    assert said.code == 130
    assert f"finished settings are kept in {kept}" in said.err
    assert len(kept.read_text(encoding="utf-8").splitlines()) == 1 + 2
    again = call("--json", "cost", "end-tension", "--quick", "--out", tmp_path / "out")
    assert again.code == 0
    (study,) = again.json()["studies"]
    assert len(done) == 3 + len(study["points"]) - 2
    assert not kept.exists()


def test_an_unknown_study_is_answered_with_the_nearest_before_anything_is_measured(call, tmp_path):
    done = call("cost", "integrl", "--out", tmp_path / "out")
    assert done.code == 3
    assert "did you mean 'integral'?" in done.err
    assert "measuring" not in done.err
    assert not (tmp_path / "out").exists()
