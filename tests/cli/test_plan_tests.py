"""`ropefric plan-tests`: from a fit or a guess to conditions for the lab."""

import csv
import math
import shlex
from pathlib import Path

import pytest

from ropefric.cli.app import find_commands
from ropefric.cli.commands.laws import read_levels

ROOT = Path(__file__).parents[2]
COUPLED = ROOT / "fits" / "prth-coupled.json"
RIG = ("--wheels", "15 mm, 30 mm, 60 mm", "--wraps", "90 deg .. 1080 deg", "--end-tensions", "5 N .. 200 N")
CELL = ("--max-force", "800 N")
WHEEL = ("--wheel-radius", "35 mm", "--wrap", "400 deg", "--end-tension", "60 N")
GUESS = ("--law", "wrap-power", "--guess", "a=0.2", "--guess", "b=-0.5", "--guess", "c=0.1")
GUESSED = (*GUESS, "--rope-diameter", "9.8 mm", "--scatter-within", "1.7 %")
KEYS = {"schema", "law", "conditions", "wanted", "before", "after", "improvement", "notes", "scatter",
    "parameters", "expected_std", "level"}  # fmt: skip


@pytest.fixture(autouse=True)
def at_home(monkeypatch):
    monkeypatch.chdir(ROOT)


def test_the_example_in_the_help_works(call):
    done = call(*shlex.split(find_commands()["plan-tests"].example)[1:], "--quiet")
    assert (done.code, done.err) == (0, "")
    words = "12 conditions to test, 144 pulls", "with this plan", "whatever is planned"
    assert all(one in done.out for one in words)


def test_a_plan_from_a_guess_is_written_for_the_lab(call, tmp_path):
    file = tmp_path / "plan.csv"
    done = call("plan-tests", *GUESSED, *RIG, *CELL, *WHEEL, "--conditions", "8", "--out", file, "--json")
    found = done.json()
    assert done.code == 0
    assert found.keys() >= KEYS
    assert found["before"] == [{"std_log": None, "std_N": None, "interval_N": [None, None], "dof": 0}]
    low, high = found["after"][0]["interval_N"]
    assert low < found["wanted"][0]["lift_force_N"] < high
    assert max(row["cell_use"] for row in found["conditions"]) <= 1.0
    with file.open(encoding="utf-8") as stream:
        loads_N = [float(row["end_tension_N"]) for row in csv.DictReader(stream)]
    assert loads_N == [row["end_tension_N"] for row in found["conditions"]]
    assert f"wrote {file}" in done.err


def test_a_plan_from_a_fit_adds_to_it(call):
    more = ("--conditions", "6", "--json")
    words = ("plan-tests", "--fit", COUPLED, *RIG, *CELL, *WHEEL, *more)
    found = call(*words).json()
    assert 31.0 < found["before"][0]["dof"] < 45.0  # errors that are stated are known for sure
    assert found["after"][0]["std_N"] < found["before"][0]["std_N"]
    assert found["scatter"]["within"] == pytest.approx(0.016, abs=2e-4)
    assert call(*words).json() == found


def test_a_fit_that_is_not_to_be_trusted_plans_with_4(call):
    fit = ROOT / "fits" / "prth-constant.json"
    done = call("plan-tests", "--fit", fit, *RIG, *CELL, *WHEEL)
    assert done.code == 4
    assert "the law is undecided" in done.err
    assert "conditions to test" in done.out


def test_a_range_becomes_settings_one_can_set():
    wraps_rad = read_levels("90 deg .. 1080 deg", "rad", "--wraps")
    degrees = [round(math.degrees(x), 9) for x in wraps_rad]
    assert (degrees[0], degrees[-1], len(degrees)) == (90, 1080, 12)
    assert all(x % 45 == 0 for x in degrees)
    assert read_levels("5 N..200 N", "N", "--end-tensions")[:3] == (5.0, 7.0, 9.8)
    assert read_levels("20 mm; 1 in", "m", "--wheels") == (0.02, 0.0254)


BAD = {(*RIG, *CELL, *WHEEL): (2, "give a fit, or a law with --guess"),
    (*GUESSED, *CELL, *WHEEL): (2, "--wheels"), (*GUESS, *RIG, *CELL, *WHEEL): (2, 'Write it like "1.7 %"'),
    (*GUESS, "--scatter-within", "1.7 %", *RIG, *CELL, *WHEEL): (2, "does not know its rope"),
    (*GUESSED[2:], "--law", "wrap-pwoer", *RIG, *CELL, *WHEEL): (3, "did you mean 'wrap-power'?"),
    (*GUESSED, *RIG, *CELL, *WHEEL, "--conditions", "2"): (3, "cannot determine the 3 parameters"),
    (*GUESSED, *RIG, "--max-force", "1 N", *WHEEL): (3, "leave 0 conditions"),
    (*GUESSED, *RIG[:2], "--wraps", "90 .. 1080", *RIG[4:], *CELL, *WHEEL): (2, 'for example "90 deg"'),
    (*GUESSED, "--guess", "q=1", *RIG, *CELL, *WHEEL): (3, "no parameter 'q'")}  # fmt: skip


def test_what_it_cannot_follow_is_told(call):
    for words, (code, told) in BAD.items():
        done = call("plan-tests", *words)
        assert (done.code, done.out) == (code, ""), words
        assert told in done.err


def test_a_plan_that_must_be_singular_says_what_would_help(call):
    law = ("--law", "size-exponential", "--guess", "mu_inf=0.3", "--guess", "a=-0.2", "--guess", "b=-0.2")
    words = (*law, *GUESSED[8:], "--wheels", "30 mm", *RIG[2:], *CELL, *WHEEL)
    done = call("plan-tests", *words)
    assert done.code == 3
    assert all(one in done.err for one in ("singular", "give more wheels"))
