"""`ropefric paper`: a paper in words, as JSON, and with its figures as files."""

import csv
import json
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PNG, TRIALS = b"\x89PNG", ROOT / "fits" / "prth-trials.csv"


@pytest.mark.parametrize("name", ["prth", "press", "saw"])
def test_a_paper_in_words_and_as_json(call, name):
    said = call("paper", name)
    assert said.code == 0
    assert said.err == ""
    tree = call("paper", name, "--json").json()
    assert tree["paper"] == name
    assert tree["title"] in said.out
    for item in tree["items"]:
        assert f"{item['number']}  {item['says']}" in said.out
    assert f"{tree['agree']} of {tree['printed']} printed numbers" in said.out


def test_figures_and_numbers_are_written(call, tmp_path):
    done = call("paper", "saw", "--out", tmp_path, "--json")
    names = sorted(path.name for path in tmp_path.iterdir() if path.is_file())
    assert "paper.json" in names
    assert {"running_forward.png", "running_backward.png", "running_mode.csv", "rest_mode.csv"} <= set(names)
    assert (tmp_path / "running_mode.png").read_bytes().startswith(PNG)
    with (tmp_path / "running_mode.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert list(rows[0]) == ["line", "place_m", "deflection"]
    assert {row["line"] for row in rows} == {"t = 0 T", "t = 0.125 T", "t = 0.25 T", "t = 0.375 T"}
    assert json.loads((tmp_path / "paper.json").read_text())["items"] == done.json()["items"]


def test_trials_a_fit_and_a_scene_of_ones_own(call):
    trials, fit = TRIALS, ROOT / "fits" / "prth-wrap-power.json"
    scene = ROOT / "data" / "scenes" / "hoist.toml"
    done = call("paper", "prth", "--trials", trials, "--fit", fit, "--scene", scene, "--json", "-q").json()
    assert done["printed"] == 0
    assert [part for part in (str(scene), str(fit)) if part not in done["of"]] == []
    values = {row["of"]: row["value"] for item in done["items"] for row in item["rows"]}
    assert "ln F_A by wrap-power for F_0 = 1 N, the rope at rest" in values
    other = call("paper", "prth", "--fit", fit, "--reference-tension", "2 N", "--json").json()
    found = {row["of"] for item in other["items"] for row in item["rows"]}
    assert "ln F_A by wrap-power for F_0 = 2 N, the rope at rest" in found


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("sew",), "unknown paper 'sew'"),
        (("press", "--trials", TRIALS), "only prth reduces trials"),
        (("saw", "--reference-tension", "1 N"), "only prth has a reference tension"),
        (("prth", "--reference-tension", "0 N"), "must be finite and positive"),
    ],
)
def test_what_is_refused(call, words, said):
    done = call("paper", *words)
    assert done.code in {2, 3}
    assert said in done.err
