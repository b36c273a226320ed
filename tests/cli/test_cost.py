"""`cost`: errors and times of numerical choices, measured here and now."""

import csv
from dataclasses import replace

import pytest

from ropefric.accuracy import measure
from ropefric.accuracy import studies as all_studies
from ropefric.registry import Registry


@pytest.fixture
def one_case(monkeypatch):
    """The cheapest study, of its first case only."""
    study = all_studies.STUDIES["interval"]
    small = Registry("study", [replace(study, cases=study.cases[:1])])
    monkeypatch.setattr(all_studies, "STUDIES", small)


@pytest.mark.usefixtures("one_case")
def test_it_writes_figures_tables_and_a_page(call, tmp_path):
    out = tmp_path / "out"
    done = call("cost", "interval", "interval", "--quick", "--out", out, "--json")
    assert done.code == 0
    assert all(one in done.err for one in ("measuring on", "100 %"))
    facts = done.json()
    (study,) = facts["studies"]
    assert (facts["quick"], facts["machine"]["cores"] >= 1, study["name"]) == (True, True, "interval")
    assert [row["accuracy"] for row in study["cheapest"]["linear"]] == [10.0**-n for n in range(2, 13)]
    known = {(row.method, row.setting): row.error for row in measure.error_table("interval", "linear")}
    for point in study["points"]:
        assert point["error"] == known[point["method"], point["setting"]], "errors know no clock"
        assert point["seconds"] > 0.0
    names = {path.name for path in out.iterdir() if path.is_file()}
    assert names == {"interval.png", "interval.csv", "cost.html"}
    assert any(path.endswith("cost.html") for path in facts["written"])
    with (out / "interval.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert {row["case"] for row in rows} == {"linear"}
    assert all(float(row["seconds"]) > 0.0 <= float(row["error"]) for row in rows)
    assert "six pulls" in (out / "cost.html").read_text(encoding="utf-8")


def test_an_unknown_study_is_answered_with_the_nearest_before_anything_is_measured(call, tmp_path):
    done = call("cost", "integrl", "--out", tmp_path / "out")
    assert done.code == 3
    assert "did you mean 'integral'?" in done.err
    assert "measuring" not in done.err
    assert not (tmp_path / "out").exists()
