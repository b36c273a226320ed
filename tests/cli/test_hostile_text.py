"""Names and headers that mean something to terminals, TeX, XML, spreadsheets or file systems: shown, never obeyed."""

import csv
import json
import os
import shutil
import sys
from pathlib import Path

import pytest

from ropefric.cli.app import main
from ropefric.files.plain_text import from_spreadsheet, to_spreadsheet, visible
from ropefric.fitting.store import load_fit
from ropefric.plotting.figure import DataTable, FigureWithData, new_figure, svg_text
from ropefric.trials.table import read_trial_table

ROOT = Path(__file__).parents[2]
NAMES = (r"$\frac{$", "$x$ and $", "a\x1b[31mred\x07", "\u202egnp.exe", "=cmd|' /C calc'!A0", "+1",
    "@SUM(A1)", "-3", "'=x", "''", "<script>alert(1)</script>", "]]>&amp;--", "Trial", "trial", "../../x",
    "CON", "x" * 300, 'a,b;c"d')  # fmt: skip


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """A campaign whose trials have all these names; some are excluded, which a page without figures lists too."""
    folder = tmp_path_factory.mktemp("names") / "campaign"
    size = ["--conditions", "1", "--repeats", str(len(NAMES))]
    argv = ["simulate", str(folder), *size, "--no-faults", "--quiet"]
    assert main(argv) == 0
    with (folder / "trials.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.reader(stream))
    column, excluded = rows[0].index("trial"), rows[0].index("exclude")
    for row, name in zip(rows[1:], NAMES, strict=True):
        row[column] = to_spreadsheet(name)
        row[excluded] = "slipped off" if name in NAMES[:4] or name.startswith("<") else ""
    with (folder / "trials.csv").open("w", encoding="utf-8", newline="") as stream:
        csv.writer(stream).writerows(rows)
    return folder


@pytest.mark.parametrize("figures", ["--no-figures", pytest.param("--figures", marks=pytest.mark.slow)])
def test_a_run_ends_well_and_shows_every_name(done, call, tmp_path, figures):
    # A backslash, a control character and TeX ended it at the report.
    out = tmp_path / "out"
    ended = call("run", done / "campaign.toml", "--out", out, figures)
    assert ended.code in (0, 4), ended.err
    assert "\x1b" not in ended.out + ended.err
    page = (out / "report.html").read_text(encoding="utf-8")
    assert visible(page) == page
    assert "<script>alert" not in page
    assert r"\x1b[31mred\x07" in page
    files = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert all(path.is_relative_to(out) and len(path.name) < 200 for path in files)
    assert read_trial_table(out / "trials.csv").trial == NAMES
    for path in files:
        if path.suffix == ".csv":
            with path.open(encoding="utf-8", newline="") as stream:
                cells = [cell for row in csv.reader(stream) for cell in row]
            assert not [cell for cell in cells if cell[:1] in tuple("=+@\t\r")
                or (cell in NAMES and cell == "-3")], path  # fmt: skip


def test_spreadsheet_text_comes_back():
    for name in (*NAMES, "'", "", "'+", "''+1", "\tx", "\rx", "-", "'twas"):
        cell = to_spreadsheet(name)
        assert from_spreadsheet(cell) == name
        assert not cell.startswith(("=", "+", "-", "@", "\t", "\r"))


def test_headers_steer_no_terminal(call, tmp_path):
    path = tmp_path / "head.csv"
    path.write_bytes(b"time (s);\x1b[31mforce\x07 (N)\n" + b"".join(b"%d;%d\n" % (i, i * i)
        for i in range(9)))  # fmt: skip
    for argv in (("inspect", path), ("inspect", tmp_path / "no\x1b[31mfile")):
        ended = call(*argv)
        assert not any(one in ended.out + ended.err for one in ("\x1b", "\x07"))
        assert r"\x1b[31m" in ended.out + ended.err


@pytest.mark.skipif(sys.platform != "linux", reason="file names of any bytes")
def test_a_file_name_that_is_no_utf8(call, tmp_path, strict):
    odd = Path(os.fsdecode(os.fsencode(tmp_path) + b"/\xff\xfe"))
    odd.mkdir()
    table = shutil.copy(ROOT / "fits" / "prth-trials.csv", odd / "t.csv")
    ended = call("fit", table, "--law", "constant", "--out", odd / "fit.json")
    assert ended.code in (0, 4), ended.err
    assert json.loads((odd / "fit.json").read_text(encoding="utf-8"))
    assert load_fit(odd / "fit.json").law == "constant"
    assert strict(call("fit", table, "--law", "constant", "--json").out)["law"] == "constant"
    ended = call("check", odd / "none.toml")
    assert ended.code == 3
    assert r"\udcff\udcfe/none.toml" in ended.err


def test_any_name_can_stand_in_a_figure():
    figure, some = new_figure(), NAMES[:9:2]
    axes = figure.subplots()
    for name in NAMES:
        axes.plot([0, 1], [0, 1], label=name)
    axes.legend(fontsize=4)
    axes.set_xticks(range(len(some)), some)
    axes.set_title(NAMES[0])
    figure.suptitle(f"{NAMES[0]}: $F_{{\\mathrm{{A}}}}$ and {NAMES[1]}")
    made = FigureWithData(figure=figure, tables=(DataTable.of_rows(("n",), ()),), alt=" ".join(NAMES))
    picture = svg_text(made)
    assert visible(picture) == picture
    assert "A" in picture
