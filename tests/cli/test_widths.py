"""What every command prints on terminals of 40 to 200 columns: no line is longer, no word is broken, nothing is lost."""

import math
import re
import shlex
from pathlib import Path

import pytest
from thinned import thinned

from ropefric.cli import app
from ropefric.cli.app import find_commands, main
from ropefric.section import Section, as_text, fold, folded, shorthand, to_error

ROOT = Path(__file__).parents[2]
FIT = f"--fit {ROOT}/fits/prth-coupled.json --wheel-radius '35 mm' --wrap '400 deg' --end-tension '60 N'"
RIG = "--wheels '15 mm, 60 mm' --wraps '90 deg .. 720 deg' --end-tensions '5 N .. 200 N' --max-force '800 N'"
TABLE = f"{ROOT}/fits/prth-trials.csv"
SCENES = sorted((ROOT / "data" / "scenes").glob("*.toml"))
WIDTHS = (40, 60, 80, 120)
WIDE = 200

COMMANDS = (
    *("init {new} --force", "init {new} --scenes", "check {bench}", "check {new}/campaign.toml"),
    *("inspect {bench}/traces/c01-r01.csv.gz", "simulate {new}/s --conditions 1 --repeats 1"),
    *("extract {bench} --out {out} --no-figures", "run {bench} --out {out} --no-figures"),
    *("report {bench} --out {out} --no-figures", f"fit {TABLE} --law size-exponential"),
    *(f"show {ROOT}/fits/prth-coupled.json", f"compare {TABLE} --laws coupled", f"diagnose {TABLE}"),
    *(f"predict {FIT} --hand", f"budget {FIT} --draws 10000"),
    "design " + FIT.replace("--wrap '400 deg'", "--lift '900 N'"),
    f"plan-tests {FIT} {RIG} --conditions 4 --starts 2",
    f"export {ROOT}/fits/prth-coupled.json",
    f"verify {ROOT}/fits", "cost --help", f"explain {SCENES[0]}",
    *(f"solve {scene}" for scene in SCENES if scene.stem != "press-start-up"),
)  # fmt: skip


def assert_folded(text, wide, width):
    """No line of several words is too long, each word is one of the whole text, and none is missing."""
    long = [line for line in text.splitlines() if len(line) > width and len(line.split()) > 1]
    assert long == []
    # Without a shell's own mark of a line that goes on, and the head of a column that is empty.
    whole, words = ({word.rstrip(":") for word in one.split()} - {"\\", "rejected"} for one in (wide, text))
    assert words == whole


def test_every_command_is_here():
    """Two write what a person is to see elsewhere: a server's page, and what plugins are told by tests of their own."""
    named = {words.split()[0] for words in COMMANDS}
    assert named <= {*find_commands()}
    assert {*find_commands()} - named <= {"check-plugin", "review"}


@pytest.fixture(scope="module")
def places(tmp_path_factory, bench):
    folder = tmp_path_factory.mktemp("widths")
    return {"bench": bench, "new": folder / "new", "out": folder / "out"}


@pytest.mark.parametrize("command", thinned(COMMANDS), ids=lambda words: " ".join(words.split()[:2])[-40:])
def test_an_answer_is_folded_to_any_terminal(command, places, monkeypatch, capfd):
    """The work is done once, and shown at each width as the program shows it."""
    answers, show, width = [], app._shown, [WIDE]
    monkeypatch.setattr(app, "_shown", lambda answer: (answers.append(answer), "")[1])
    monkeypatch.setattr(app, "width_of", lambda _: width[0])
    assert main(shlex.split(command.format(**places))) in {0, 3, 4}
    for answer in answers:
        wide = show(answer)
        for narrow in WIDTHS:
            width[0] = narrow
            assert_folded(show(answer), wide, narrow)


@pytest.mark.parametrize("name", ["", *find_commands()])
def test_a_help_is_folded(name, monkeypatch, call):
    words = [*name.split(), "--help"]
    monkeypatch.setenv("COLUMNS", str(WIDE))
    wide = call(*words).out
    for narrow in (40, 60):
        monkeypatch.setenv("COLUMNS", str(narrow))
        assert_folded(call(*words).out, wide, narrow)


def test_what_goes_to_stderr_is_folded_too(places, monkeypatch, call):
    for words in (
        ("fit", TABLE, "--law", "cupled"),
        ("check", places["bench"]),
        ("solve", "data/scenes/nothing.toml"),
        ("predict", "--fit", f"{ROOT}/fits/prth-constant.json", "--wrap", "9 deg"),
    ):
        monkeypatch.setenv("COLUMNS", str(WIDE))
        wide = call(*words).err
        assert wide
        for narrow in (40, 60):
            monkeypatch.setenv("COLUMNS", str(narrow))
            assert_folded(call(*words).err, wide, narrow)


def test_a_wide_sweep_shows_what_changes_and_says_where_the_rest_is(monkeypatch, call):
    words = (
        "solve",
        f"{ROOT}/data/scenes/belt-press.toml",
        "--sweep",
        "press.preload=1000N:3000N:4",
        "--quiet",
    )
    for columns, fewest in ((40, 2), (100, 5)):
        monkeypatch.setenv("COLUMNS", str(columns))
        out = call(*words).out
        assert max(map(len, out.splitlines())) <= columns
        assert "the same at every point: Power [W] 1673.8" in " ".join(out.split())
        left = int(re.search(r"(\d+) columns more with what changes", " ".join(out.split()))[1])
        row = next(line for line in out.splitlines() if line.split()[:1] == ["1000"])
        assert len(row.split()) >= fewest
        # The preload, and the numbers of the answer, nine of them the same at every point but for the last bits.
        assert len(row.split()) + left == 1 + len(call(*words, "--json").json()["columns"]) - 9
    shown = call("solve", f"{ROOT}/data/scenes/hoist.toml", "--sweep", "rope.diameter=5mm:10mm:3", "--quiet")
    assert "  rope.diameter [mm]  Lift force [N]" in shown.out


def test_angles_are_in_degrees_for_people_and_in_radians_for_programs(call):
    words = ("solve", f"{ROOT}/data/scenes/traction.toml", "--quiet")
    wrap_rad = call(*words, "--json").json()["needed_wrap_rad"]
    shown = next(line for line in call(*words).out.splitlines() if "Least wrap" in line)
    assert "[deg]" in shown
    assert float(shown.split()[-1]) == pytest.approx(math.degrees(wrap_rad), rel=1e-4)


@pytest.mark.parametrize(
    ("value", "std", "told", "short"),
    [
        (319.30908, 0.6392, "319.31", "319.31(64)"),
        (0.1468611, 0.000212, "0.14686", "0.14686(21)"),
        (12345.6, 99.96, "12350", "12350(100)"),
        (12345.6, 12.3, "12346", "12346(12)"),
        (3.1415926, 0.0, "3.14159", "3.1416"),
        (3.1415926, float("nan"), "3.14159", "3.1416"),
        (2.0, 0.0999, "2.00", "2.00(10)"),
    ],
)
def test_digits_end_with_the_error(value, std, told, short):
    assert to_error(value, std) == told
    assert shorthand(value, std) == short


def test_a_table_that_has_no_room_becomes_lines():
    section = Section(
        "T", headings=("law", "error", "status "), rows=(("size-exponential", "1.25", "residual-structure"),)
    )
    assert as_text([section], 60).splitlines()[1].split() == ["law", "error", "status"]
    assert as_text([section], 30).splitlines() == [
        "T", "  law: size-exponential", "    error: 1.25", "    status: residual-structure",
    ]  # fmt: skip


def test_a_word_longer_than_the_terminal_stays_whole():
    path = "/a/very/long/path/without/any/blank/in/it/report.html"
    assert path in folded(f"written to {path}", 40).split()
    assert fold("ropefric a b", 10, more=" \\") == ["ropefric \\", "  a b"]
