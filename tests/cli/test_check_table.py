"""A table of trials, or a list of conditions without forces, is checked for what it can tell, as a campaign is."""

import numpy as np
import pytest

from ropefric.fitting.resolution import TYPICAL_BETWEEN, TYPICAL_WITHIN, law_outlook
from ropefric.friction.condition import Conditions
from ropefric.friction.laws import LAWS

HEAD = ["wheel_radius_mm", "rope_diameter_mm", "wrap_angle_deg", "end_tension_N"]
WRAPS, LOADS = (90, 180, 360, 720), (10, 40, 120)


def rows(*more):
    return [[30, 8, wrap, load, *more] for wrap in WRAPS for load in LOADS]


def write(path, head, lines):
    path.write_text("".join(",".join(map(str, line)) + "\n" for line in [head, *lines]), encoding="utf-8")
    return path


def by_hand(law, std):
    """What the twelve conditions can tell, from arrays of their own."""
    phi, force = (a.ravel() for a in np.meshgrid(np.radians(WRAPS), LOADS, indexing="ij"))
    at = Conditions(wheel_radius_m=0.03, rope_radius_m=0.004, wrap_angle_rad=phi, end_tension_N=force)
    return law_outlook(LAWS[law], at, np.full(phi.size, std**2))


def test_a_list_without_forces_is_judged_by_the_usual_scatter(call, tmp_path):
    done = call("--json", "check", write(tmp_path / "list.csv", [*HEAD, "repeats"], rows(5)))
    found = done.json()["table"]
    assert (done.code, found["n_trials"], found["n_conditions"], found["n_forces"]) == (0, 60, 12, 0)
    assert found["repeats"] == {"fewest": 5, "most": 5}
    expected = by_hand("wrap-power", np.hypot(TYPICAL_BETWEEN, TYPICAL_WITHIN / np.sqrt(5.0)))
    told = next(item for item in found["tells"] if item["law"] == "wrap-power")
    assert told["power"]["constant"] == pytest.approx(expected.power["constant"], rel=1e-6)
    assert told["expected_std"]["a"] == pytest.approx(expected.expected_std["a"], rel=1e-6)


def test_a_table_with_forces_is_judged_by_the_scatter_of_its_repeats(call, tmp_path):
    """Two pulls of each condition, 4 % apart: their standard deviation is 4 %/√2 to second order."""
    lines = [[*row, f"{row[3] * 2.0 * np.exp(sign * 0.02):.9g}"] for row in rows() for sign in (-1.0, 1.0)]
    found = call("--json", "check", write(tmp_path / "t.csv", [*HEAD, "peak_N"], lines)).json()["table"]
    assert found["scatter_within"] == pytest.approx(0.04 / np.sqrt(2.0), rel=1e-6)
    expected = by_hand("constant-offset", np.hypot(TYPICAL_BETWEEN, 0.04 / np.sqrt(2.0) / np.sqrt(2.0)))
    told = next(item for item in found["tells"] if item["law"] == "constant-offset")
    assert told["power"]["constant"] == pytest.approx(expected.power["constant"], rel=1e-6)


def test_a_workbook_tells_the_same_as_text(call, tmp_path):
    book = pytest.importorskip("openpyxl").Workbook()
    for line in [HEAD, *rows()]:
        book.active.append(line)
    book.save(tmp_path / "list.xlsx")
    texts = [call("check", path).out.partition("\n")[2]
        for path in (tmp_path / "list.xlsx", write(tmp_path / "list.csv", HEAD, rows()))]  # fmt: skip
    assert texts[0] == texts[1]
    assert "constant-offset: distinguishable from constant (in " in texts[0]
    assert "probably distinguishable: in 50 % of campaigns or more" in texts[0]


def test_a_plan_can_be_checked_as_it_was_written(call, tmp_path):
    head = ["condition", *HEAD, "repeats", "expected_lift_force_N"]
    lines = [[i, *row, 12, 50.0] for i, row in enumerate(rows(), start=1)]
    found = call("--json", "check", write(tmp_path / "plan.csv", head, lines)).json()["table"]
    assert (found["n_conditions"], found["n_trials"]) == (12, 144)


def test_what_is_wrong_with_a_list_is_told_all_at_once(call, tmp_path):
    lines = [*rows(3), [30, 8, "", 40, 3], [30, 8, 90, 40, "many"]]
    done = call("check", write(tmp_path / "list.csv", [*HEAD, "repeats"], lines))
    assert done.code == 3
    assert "list.csv:14 wrap_angle_deg  the cell is empty" in done.err
    assert "list.csv:15 repeats  'many' is no number of pulls" in done.err


def test_the_list_of_a_campaign_leads_to_the_campaign(call, bench):
    done = call("check", bench / "trials.csv")
    assert done.code == 3
    assert "there is no column for the wheel radius" in done.err
    assert f"{bench.as_posix()}/campaign.toml" in done.err


def test_a_table_of_other_things_says_what_it_lacks(call, tmp_path):
    done = call("check", write(tmp_path / "run.csv", ["time_s", "force_N"], [[0, 1], [1, 2]]))
    assert (done.code, done.err.count("there is no column for the")) == (3, 4)
