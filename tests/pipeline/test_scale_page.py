"""What the page about many recordings says can be done is done: its Python, its commands, its numbers."""

import json
import re
import runpy
import shlex
import textwrap
from pathlib import Path

import pytest

import ropefric as rf
from ropefric.cli.app import main

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "scale.md").read_text(encoding="utf-8")
MEASURING = runpy.run_path(str(DOCS / "scale" / "measure.py"), run_name="measuring")


def blocks(language):
    found = re.findall(rf"^( *)```{language}\n(.*?)^ *```$", PAGE, re.MULTILINE | re.DOTALL)
    return [textwrap.dedent(text) for _, text in found]


@pytest.fixture(scope="module")
def shared(tmp_path_factory):
    """Two parts of a campaign."""
    folder = tmp_path_factory.mktemp("shared")
    for name in ("part-1", "part-2"):
        MEASURING["campaign"](folder / name, 20)
    return folder


@pytest.mark.slow
def test_parts_are_extracted_put_together_and_fitted(shared, monkeypatch, capfd):
    monkeypatch.chdir(shared)
    lines = "\n".join(blocks("bash")).replace("\\\n", "").split("\n")
    (extract,) = [line for line in lines if "--parquet" in line]
    words = shlex.split(extract.split("||")[0])
    options = words[words.index("--no-figures") : words.index("--cluster")]
    for part in ("part-1", "part-2"):
        assert main([words[1], part, "--out", f"results/{part}", *options]) == 0
    _, merge = blocks("python")
    exec(compile(merge, "scale.md", "exec"), {})  # noqa: S102
    whole, one = rf.trial_table("all.parquet"), rf.trial_table("results/part-2/trials.csv")
    assert (len(whole), whole.trial[20:]) == (40, tuple(f"part-2/{name}" for name in one.trial))
    assert whole.peak_N[20:].tolist() == one.peak_N.tolist()
    told = [shlex.split(line)[1:] for line in lines if "all.parquet" in line]
    assert [words[0] for words in told] == ["compare", "fit"]
    told[1][told[1].index("coupled")] = "constant"  # two conditions tell no more than that
    assert main(told[1]) in (0, 4)
    assert json.loads(Path("coupled.json").read_text(encoding="utf-8"))["law"] == "constant"
    capfd.readouterr()


def test_the_python_of_the_page_runs_in_processes(shared, monkeypatch):
    monkeypatch.chdir(shared)
    found = {"__name__": "__main__"}
    exec(compile(blocks("python")[0], "scale.md", "exec"), found)  # noqa: S102
    assert len(found["extraction"].trials) == 20


def test_the_table_of_the_page_is_what_was_measured():
    told = json.loads((DOCS / "scale" / "scale.json").read_text(encoding="utf-8"))
    assert MEASURING["page"](PAGE, told) == PAGE
    for points in told["points"].values():
        power, _ = MEASURING["grown"](points, "processor_s", 1e6)
        assert power < 1.3


def test_what_is_computed_goes_on_as_the_last_decade_grew_and_no_slower_than_the_number():
    grown = MEASURING["grown"]
    square = [{"size": n, "s": 1e-6 * n**2} for n in (100, 1000)]
    assert grown(square, "s", 1e4) == (pytest.approx(2.0), pytest.approx(100.0))
    slow = [{"size": n, "s": 1e-3 * n**0.5} for n in (100, 10_000)]
    assert grown(slow, "s", 1e6) == (pytest.approx(0.5), pytest.approx(10.0))
