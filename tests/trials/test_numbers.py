"""A number of a trial is declared in one place: what is added there stands in every table, the JSON and the labels."""

import csv
import json

import pytest

from ropefric.cli.app import main
from ropefric.page.review import facts_of
from ropefric.plotting.campaign import draw_recording
from ropefric.report import campaign as report
from ropefric.trials import numbers
from ropefric.trials.numbers import COLUMNS, TrialColumn
from ropefric.trials.result import write_tables


def test_a_number_that_is_added_to_the_declaration_is_everywhere(lab, monkeypatch, tmp_path, capfd):
    half = TrialColumn(name="half_N", taken=lambda trial: trial.breakaway.peak_N / 2,
        words="half the force", brief="mean half", symbol="F_h", drawn="halved",
        on_page="half")  # fmt: skip
    monkeypatch.setattr(numbers, "COLUMNS", (*COLUMNS, half))
    lab.pulls(a=100.0, b=102.0)
    extraction = lab.extract()
    halves_N = [trial.peak_N / 2 for trial in extraction.trials]
    told = extraction.to_dict()
    assert [trial["half_N"] for trial in told["trials"]] == halves_N
    mean_N = sum(halves_N) / 2
    mean, n = (told["conditions"][0][name] for name in ("mean_half_N", "n_half"))
    assert ((mean, n), extraction.to_frame()["half_N"].tolist()) == ((pytest.approx(mean_N), 2), halves_N)
    trials, conditions, _ = write_tables(extraction, tmp_path / "out")
    for path, name, value in ((trials, "half_N", halves_N[0]), (conditions, "mean_half_N", mean_N)):
        with path.open(encoding="utf-8", newline="") as stream:
            assert float(next(csv.DictReader(stream))[name]) == pytest.approx(value, rel=1e-8)
    (fold,) = report._sliding_section(extraction)
    assert "half the force [N]" in fold.section.headings
    assert facts_of(extraction.trials[0])["numbers"][-1] == ["half", pytest.approx(halves_N[0]), "N"]
    assert f"halved at {halves_N[0]:.4g} N" in draw_recording(extraction.trials[0]).alt
    with monkeypatch.context() as patch:
        patch.chdir(lab.folder)
        assert main(["extract", ".", "--out", str(tmp_path / "command"), "--no-figures"]) == 0
        assert "mean half [N]" in capfd.readouterr().out
        assert main(["extract", ".", "--out", str(tmp_path / "command"), "--no-figures", "--json"]) == 0
    assert json.loads(capfd.readouterr().out)["trials"][1]["half_N"] == pytest.approx(halves_N[1])


def test_every_column_has_a_name_of_its_own_and_stands_in_the_row_in_order(lab):
    (trial,) = lab.pulls(a=100.0).extract().trials
    names = [column.name for column in COLUMNS]
    assert len({*names}) == len(names)
    assert [*trial.to_dict()] == [*names, "sha256"]
