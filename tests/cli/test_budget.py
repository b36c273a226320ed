"""`ropefric budget`: of a predicted lift force; what a campaign does not state of its cells is said to be assumed."""

import math
import shlex
from pathlib import Path

import pytest

from ropefric.cli.app import find_commands
from ropefric.traces.calibration import Calibration, ForceCell, chain_quantities

ROOT = Path(__file__).parents[2]
COUPLED = ROOT / "fits" / "prth-coupled.json"
LARGER = ROOT / "tests" / "fitting" / "coupled-0.1.0.json"
"""Its parameters are less certain, so that the law is not linear within their errors."""
WHEEL = ("--wheel-radius", "35 mm", "--wrap", "400 deg", "--end-tension", "60 N")
LINE_KEYS = {*("name", "symbol", "unit", "estimate", "standard_uncertainty", "type", "distribution",
    "divisor"), *("sensitivity", "contribution", "share", "dof")}  # fmt: skip
KEYS = {*("schema", "quantity", "unit", "estimate", "lines", "combined", "effective_dof", "coverage_factor"),
    *("level", "expanded", "interval", "monte_carlo", "improvements", "notes", "status",
    "trustworthy")}  # fmt: skip


@pytest.fixture(autouse=True)
def at_home(monkeypatch):
    monkeypatch.chdir(ROOT)


def test_the_example_in_the_help_works(call):
    done = call(*shlex.split(find_commands()["budget"].example)[1:], "--quiet")
    assert (done.code, done.err) == (0, "")
    for words in ("wrap angle", "end tension", "parameters of coupled", "u_c =", "200000 draws", "smaller"):
        assert words in done.out
    assert "draws (seed 0) agree with y ± U" in " ".join(done.out.split())


def test_a_budget_of_a_lift_force_adds_up(call):
    words = ("--u-wrap", "2 deg", "--u-end-tension", "0.5 N", "--u-wheel-radius", "0.1 mm", "--one-pull")
    found = call("budget", "--fit", COUPLED, *WHEEL, *words, "--json").json()
    assert found.keys() >= KEYS
    assert all(line.keys() >= LINE_KEYS for line in found["lines"])
    assert math.hypot(*(line["contribution"] for line in found["lines"])) == pytest.approx(found["combined"])
    assert sum(line["share"] for line in found["lines"]) == pytest.approx(1.0)
    assert found["expanded"] == pytest.approx(found["coverage_factor"] * found["combined"])
    wrap = next(line for line in found["lines"] if line["symbol"] == "φ")
    assert wrap["standard_uncertainty"] == pytest.approx(math.radians(2))
    law = next(line for line in found["lines"] if line["name"] == "parameters of coupled")
    assert 20.0 < law["dof"] < 36.0  # of 36 conditions, five parameters and two levels of scatter


def test_what_is_not_to_be_trusted_is_4(call):
    done = call("budget", "--fit", ROOT / "fits" / "prth-constant.json", *WHEEL, "--json")
    assert (done.code, done.json()["status"]) == (4, "fit-not-trusted")
    assert "taken as exact: wheel radius, rope radius, wrap angle, end tension" in done.json()["notes"]


BAD = {(): (2, "--fit"), ("--fit", COUPLED, *WHEEL[:4]): (2, "--end-tension"),
    ("--fit", COUPLED, *WHEEL, "--u-wrap", "2"): (2, 'for example "2 deg"'),
    ("--fit", COUPLED, *WHEEL, "--level", "2"): (3, "the level is 2"),
    ("--fit", COUPLED, *WHEEL, "--draws", "5"): (3, "draw 10000 or more"),
    ("--fit", "nowhere.json", *WHEEL): (3, "nowhere.json")}  # fmt: skip


def test_what_it_cannot_follow_is_told(call):
    for words, (code, told) in BAD.items():
        done = call("budget", *words)
        assert (done.code, done.out) == (code, ""), words
        assert told in done.err


def test_the_check_is_told_with_its_numbers(call):
    words = ("--fit", LARGER, *WHEEL, "--u-wrap", "200 deg")
    done, found = call("budget", *words, "--quiet"), call("budget", *words, "--json").json()
    flat = " ".join(done.out.split())
    gap = 100 * max(found["monte_carlo"]["gaps"]) / found["expanded"]
    assert "draws (seed 0) do not agree with y ± U" in flat
    assert f"{float(f'{gap:.2g}'):g} % of U; 10 % are allowed" in flat


# --- what nobody stated is not listed as if somebody had -----------------------------------------------------------

LIMITS = ("linearity", "hysteresis", "repeatability", "transmitter")


@pytest.fixture
def unstated(campaign):
    """The small campaign, whose cells state their linearity alone."""
    lines = (campaign / "campaign.toml").read_text(encoding="utf-8").splitlines()
    kept = [line for line in lines if not line.startswith(LIMITS[1:])]
    assert len(kept) < len(lines)
    (campaign / "campaign.toml").write_text("\n".join([*kept, ""]), encoding="utf-8")
    return campaign


@pytest.mark.slow
def test_limits_that_nobody_stated_are_assumed_wherever_they_stand(call, unstated, tmp_path):
    checked = call("check", unstated)
    said = " ".join((checked.err + checked.out).split())
    assert "RF142" in said
    words = 'hysteresis = "0.02 %FS", repeatability = "0.02 %FS", transmitter = "0.1 %FS"'
    assert f"not stated, so assumed: {words}" in said
    done = call("run", unstated, "--out", tmp_path / "out", "--no-figures", "--law", "constant")
    assert "hysteresis, repeatability, transmitter assumed, not stated" in " ".join(done.out.split())
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "transmitter (assumed)" in page
    assert "hysteresis, repeatability, transmitter assumed, not stated" in page
    assert "RF142" in (tmp_path / "out" / "problems.csv").read_text(encoding="utf-8")


def test_a_cell_knows_what_was_assumed_of_it():
    cell = ForceCell(name="K1", full_scale_N=1000.0, linearity=0.0002)
    assert cell.assumed == LIMITS[1:]
    calibration = Calibration(cell=cell)
    assert calibration.to_dict()["cell"]["assumed"] == list(LIMITS[1:])
    components = {one.name: one.assumed for one in chain_quantities(300.0, calibration)}
    assert (components["linearity"], components["transmitter"]) == ("", "cells.K1.transmitter")
