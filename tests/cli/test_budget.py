"""`ropefric budget`: of campaigns, of trial tables, of predicted lift forces."""

import json
import math
import shlex
import shutil
from pathlib import Path

import pytest

from ropefric.api import measured_budgets
from ropefric.cli.app import find_commands
from ropefric.errors import InputError
from ropefric.traces.calibration import Calibration, ForceCell, chain_quantities

ROOT = Path(__file__).parents[2]
TRIALS = ROOT / "fits" / "prth-trials.csv"
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
    law = next(line for line in found["lines"] if line["correlated"])
    assert len(law["correlated"]) == 5
    assert 20.0 < law["dof"] < 36.0  # of 36 conditions, five parameters and two levels of scatter


def test_of_an_exact_wheel_it_is_what_predict_says(call):
    budget = call("budget", "--fit", COUPLED, *WHEEL, "--json").json()
    std_N = call("predict", "--fit", COUPLED, *WHEEL, "--json").json()["std_N"]
    assert budget["combined"] == pytest.approx(std_N, rel=5e-4), "a standard error has four digits"
    assert "taken as exact: wheel radius, rope radius, wrap angle, end tension" in budget["notes"]


def test_every_condition_of_a_table_has_its_budget(call):
    done = call("budget", TRIALS, "--quantity", "mu", "--draws", "10000", "--json")
    budgets = done.json()["budgets"]
    assert (done.code, [each["condition"] for each in budgets]) == (0, list(range(1, 37)))
    for each in budgets:
        mu = math.log(each["lift_force_N"] / each["end_tension_N"]) / each["wrap_angle_rad"]
        assert each["estimate"] == pytest.approx(mu)
    savings = [item["saving"] for budget in budgets for item in budget["improvements"]]
    assert min(savings) >= 0.005, "what saves nothing is no advice"
    assert "36 " in call("budget", TRIALS, "--draws", "10000").out


def test_wrap_gravity_and_gain_are_counted_as_told(call):
    def stated(*words):
        words = ("--condition", "1", "--quantity", "mu", "--draws", "10000", *words, "--json")
        return call("budget", TRIALS, *words).json()["budgets"][0]

    def assumed(tree):
        return {line["name"]: line.get("assumed") for line in tree["lines"]}["acceleration of gravity"]

    plain, usual = stated("--gravity", "0 %")["combined"], stated()
    assert plain < usual["combined"] < stated("--u-wrap", "2 deg")["combined"]
    both = ("--end-tension-measured", "--u-end-tension", "0.3 N")
    measured = stated(*both)["combined"]
    assert stated(*both, "--gain", "1 %")["combined"] == pytest.approx(measured)
    assert stated("--gravity", "0 %", "--gain", "1 %")["combined"] > plain
    assert "--gravity" in assumed(usual)
    assert assumed(stated("--gravity", "0.0001")) is None


def test_a_campaign_is_taken_apart(call, bench):
    words = ("budget", bench, "--condition", "1", "--draws", "10000", "--quiet")
    done = call(*words, "--json")
    assert done.code == 0
    (found,) = done.json()["budgets"]
    names = {line["name"] for line in found["lines"]}
    assert names >= {"repeatability", "resolution", "transmitter", "linearity", "hysteresis"}
    assert "bias of the smoothing" in names
    assert any("tare" in note for note in found["notes"])
    assert "√12" in call(*words).out


def test_what_is_not_to_be_trusted_is_4(call, tmp_path):
    done = call("budget", "--fit", ROOT / "fits" / "prth-constant.json", *WHEEL, "--json")
    assert (done.code, done.json()["status"]) == (4, "fit-not-trusted")
    header = "wheel_radius_mm,rope_diameter_mm,wrap_angle_deg,end_tension_N,peak_N,peak_std_N"
    path = tmp_path / "t.csv"
    path.write_text(f"{header}\n40,10,180,20,40,0.4\n40,10,360,20,80,0.4\n", encoding="utf-8")
    done = call("budget", path, "--draws", "10000", "--json")
    assert (done.code, {each["status"] for each in done.json()["budgets"]}) == (4, {"no-repeats"})


BAD = {(): (2, "give a campaign or trial table, or --fit"), (TRIALS, "--fit", COUPLED): (2, "not both"),
    (TRIALS, "--quantity", "nu"): (2, "neither force nor mu"),
    (TRIALS, "--condition", "99"): (3, "numbered 1 to 36"),
    (TRIALS, "--condition", "1", "--u-wrap", "2"): (2, 'for example "2 deg"'),
    (TRIALS, "--condition", "1", "--level", "2"): (3, "the level is 2"),
    (TRIALS, "--condition", "1", "--draws", "5"): (3, "draw 10000 or more"),
    ("--fit", COUPLED): (2, "--wheel-radius and --wrap and --end-tension missing"),
    ("--fit", COUPLED, *WHEEL[:4]): (2, "--end-tension missing"),
    ("nowhere.csv",): (3, "nowhere.csv")}  # fmt: skip


def test_what_it_cannot_follow_is_told(call):
    for words, (code, told) in BAD.items():
        done = call("budget", *words)
        assert (done.code, done.out) == (code, ""), words
        assert told in done.err


def test_the_check_is_told_with_its_numbers(call):
    done = call("budget", "--fit", LARGER, *WHEEL, "--quiet")
    found = call("budget", "--fit", LARGER, *WHEEL, "--json").json()
    flat = " ".join(done.out.split())
    gap = 100 * max(found["monte_carlo"]["gaps"]) / found["expanded"]
    assert "draws (seed 0) do not agree with y ± U" in flat
    assert f"{float(f'{gap:.2g}'):g} % of U; 10 % are allowed" in flat
    assert "The test of JCGM 101 §8.1 is not passed." in flat


def test_the_command_and_python_state_the_same(call):
    words = ("--quantity", "mu", "--condition", "3", "--u-wrap", "0.02 rad", "--gain", "0.1 %")
    (told,) = call("budget", TRIALS, *words, "--draws", "10000", "--json").json()["budgets"]
    how = {"u_wrap_angle_rad": 0.02, "gain_limit": 0.001, "draws": 10_000}
    stated = measured_budgets(TRIALS, "mu", **how)[2].to_dict()
    assert {key: told[key] for key in stated} == json.loads(json.dumps(stated))
    with pytest.raises(InputError, match="neither 'force' nor 'mu'"):
        measured_budgets(TRIALS, "nu")


# --- what nobody stated is not listed as if somebody had -----------------------------------------------------------

FIRST = ("--condition", "1", "--draws", "10000")
LIMITS = ("linearity", "hysteresis", "repeatability", "transmitter")


@pytest.fixture
def unstated(bench, tmp_path):
    """The small campaign, whose cells state their linearity alone."""
    folder = tmp_path / "campaign"
    shutil.copytree(bench, folder)
    lines = (folder / "campaign.toml").read_text(encoding="utf-8").splitlines()
    kept = [line for line in lines if not line.startswith(LIMITS[1:])]
    assert len(kept) < len(lines)
    (folder / "campaign.toml").write_text("\n".join([*kept, ""]), encoding="utf-8")
    return folder


@pytest.mark.slow
def test_limits_that_nobody_stated_are_assumed_wherever_they_stand(call, bench, unstated, tmp_path):
    checked = call("check", unstated)
    said = " ".join((checked.err + checked.out).split())
    assert "RF142" in said
    words = 'hysteresis = "0.02 %FS", repeatability = "0.02 %FS", transmitter = "0.1 %FS"'
    assert f"not stated, so assumed: {words}" in said
    stated, assumed = (call("budget", folder, *FIRST, "--json").json() for folder in (bench, unstated))
    by_name = [{line["name"]: line.get("assumed") for line in tree["budgets"][0]["lines"]}
        for tree in (stated, assumed)]  # fmt: skip
    assert by_name[0]["transmitter"] is None
    cell = by_name[1]["transmitter"].split(".")[1]
    assert by_name[1]["transmitter"] == f"cells.{cell}.transmitter"
    assert (by_name[1]["linearity"], by_name[1]["hysteresis"]) == (None, f"cells.{cell}.hysteresis")
    note = f"transmitter is assumed, nobody stated it: state cells.{cell}.transmitter"
    assert note in assumed["budgets"][0]["notes"]
    assert note not in stated["budgets"][0]["notes"]
    text = " ".join(call("budget", unstated, *FIRST).out.split())
    assert "transmitter (assumed)" in text
    assert note in text
    # The numbers are the same: only what is said of them changes.
    assert assumed["budgets"][0]["combined"] == stated["budgets"][0]["combined"]
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
