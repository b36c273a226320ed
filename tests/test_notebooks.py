"""Every notebook runs from top to bottom, asserts its own numbers, and is stored without outputs.

Here its code runs in this process; kernels run it where the site is built.
"""

import ast
import json
from pathlib import Path

import pytest

import ropefric as rf

NOTEBOOKS = sorted((Path(__file__).parents[1] / "notebooks").glob("*.ipynb"))
QUICK = ("02_belt_press",)
"""What runs by default; the long run and the site run all."""


def code_cells(path):
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    return [cell for cell in cells if cell["cell_type"] == "code"]


def code_of(path):
    return "\n".join("".join(cell["source"]) for cell in code_cells(path)).replace("%matplotlib inline", "")


def test_notebooks_are_stored_without_outputs_end_in_assertions_and_use_the_interface_alone():
    """`import ropefric as rf`, and of its modules none: what a notebook needs, everybody can have."""
    assert len(NOTEBOOKS) >= 5
    for path in NOTEBOOKS:
        code = code_cells(path)
        assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in code), path.stem
        assert "assert " in "".join(code[-1]["source"]), path.stem
        nodes = [*ast.walk(ast.parse(code_of(path)))]
        named = [
            (one.name, one.asname) for node in nodes if isinstance(node, ast.Import) for one in node.names
        ]
        named += [(node.module or "", None) for node in nodes if isinstance(node, ast.ImportFrom)]
        assert [one for one in named if one[0].partition(".")[0] == "ropefric"] == [("ropefric", "rf")], (
            path.stem
        )
        of_rf = (
            node for node in nodes if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name)
        )
        assert {node.attr for node in of_rf if node.value.id == "rf"} <= set(rf.__all__), path.stem


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(one, marks=() if one.stem in QUICK else pytest.mark.slow, id=one.stem)
        for one in NOTEBOOKS
    ],
)
def test_a_notebook_runs(path, monkeypatch):
    plt = pytest.importorskip("matplotlib.pyplot")
    monkeypatch.chdir(path.parent)
    monkeypatch.setattr(plt, "show", lambda: None)  # a notebook's, and the canvas of tests shows nothing
    pd = pytest.importorskip("pandas")
    try:
        with pd.option_context("display.max_rows", 60, "display.max_colwidth", 50), plt.rc_context():
            plt.switch_backend("agg")
            exec(compile(code_of(path), path.name, "exec"), {"__name__": "notebook"})  # noqa: S102  (our own)
    finally:
        plt.close("all")
