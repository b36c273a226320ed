"""What labs measure beside F_A goes per trial and per condition; a doubtful trial waits for a person."""

import csv
import json
import math

import numpy as np
import pytest

from ropefric.cli.app import main
from ropefric.traces.breakaway import Breakaway, ForceEvent, Status
from ropefric.traces.protocols import PROTOCOLS
from ropefric.trials.result import TrialResult, summarise_conditions, write_tables
from ropefric.trials.table import read_trial_table

PHI, END_N = math.pi, 20.0
CANDIDATES = (ForceEvent(kind="break-away", time_s=1.3, force_N=97.3, drop_N=12.0, fall_s=0.01, probability=0.61),
    ForceEvent(kind="bump", time_s=0.7, force_N=51.25, drop_N=30.0, fall_s=0.2))  # fmt: skip


def trial(name, *, peak_N=60.0, kinetic_N=45.0, kept=True, **found):
    breakaway = Breakaway(status=Status.OK, peak_N=peak_N, kinetic_N=kinetic_N, **found)
    return TrialResult(
        trial=name, file=f"{name}.csv", wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=PHI,
        end_tension_N=END_N, end_tension_std_N=0.01, peak_N=peak_N, peak_std_N=0.6, breakaway=breakaway, kept=kept,
    )  # fmt: skip


def test_a_condition_has_mean_scatter_and_number_of_what_was_measured():
    trials = [trial("a", kinetic_N=44.0, n_slips=3, recurrence_s=0.5, drop_N=15.0, dwell_s=2.0),
        trial("b", peak_N=62.0, kinetic_N=46.0, n_slips=5, recurrence_s=0.7, drop_N=16.0),
        trial("c", peak_N=61.0, kinetic_N=math.nan)]  # fmt: skip
    _, (condition,), _ = summarise_conditions(trials, "none")
    row = condition.to_dict()
    kinetic = [row[name] for name in ("mean_kinetic_N", "std_kinetic_N", "n_kinetic")]
    assert kinetic == [45.0, pytest.approx(math.sqrt(2.0)), 2]
    assert (row["mean_n_slips"], row["n_slips"]) == (pytest.approx(8 / 3), 3)
    assert (row["mean_recurrence_s"], row["n_recurrence"]) == (pytest.approx(0.6), 2)
    dwell = [row[name] for name in ("mean_measured_dwell_s", "std_measured_dwell_s", "n_measured_dwell")]
    assert dwell == [2.0, None, 1]
    assert row["mean_mu_kinetic"] == pytest.approx((math.log(44 / 20) + math.log(46 / 20)) / 2 / PHI)
    assert (row["mean_trough_N"], row["n_trough"]) == (None, 0)


def test_rejected_trials_take_no_part_in_the_means():
    pulls = [trial(f"t{i}", peak_N=60 + 0.01 * i, kinetic_N=45.0) for i in range(9)]
    _, (condition,), _ = summarise_conditions([*pulls, trial("x", peak_N=90, kinetic_N=80.0)], "two-sigma")
    assert (condition.rejected, condition.to_dict()["mean_kinetic_N"]) == (("x",), pytest.approx(45.0))


def test_apparent_coefficients_are_those_of_the_capstan_equation():
    one = trial("a", peak_N=END_N * math.exp(0.3 * PHI), kinetic_N=END_N * math.exp(0.2 * PHI))
    assert (one.mu, one.mu_kinetic) == (pytest.approx(0.3), pytest.approx(0.2))
    assert one.mu_std == pytest.approx(math.hypot(0.6 / one.peak_N, 0.01 / END_N) / PHI)


def test_the_kinetic_force_has_an_uncertainty_and_reaches_the_trial_table(lab, tmp_path):
    extraction = lab.pulls(a=100, b=101).extract()
    one = extraction.trials[0]
    assert one.breakaway.kinetic_N == pytest.approx(80.0, abs=0.2)
    assert 0.0 <= one.kinetic_mean_std_N < 0.2
    write_tables(extraction, tmp_path / "out")
    kinetic = read_trial_table(tmp_path / "out" / "trials.csv").of("kinetic")
    assert kinetic.peak_N == pytest.approx([80.0, 80.8], abs=0.2)
    row = next(csv.DictReader((tmp_path / "out" / "conditions.csv").read_text(encoding="utf-8").splitlines()))
    assert float(row["mean_kinetic_N"]) == pytest.approx(80.4, abs=0.2)
    assert np.isfinite(float(row["mean_loading_rate_N_s"]))


@pytest.fixture
def doubtful_last(lab, monkeypatch):
    """Return a campaign whose last recording leaves the picker in doubt."""
    protocol = PROTOCOLS["breakaway"]

    def pick(trace, settings):
        if "d.csv" in trace.source:
            return (Breakaway(status=Status.DOUBTFUL, detail="two falls may be it", candidates=CANDIDATES),)
        return protocol.pick(trace, settings)

    class Doubting:
        """The protocol, in doubt."""

        def __getitem__(self, _name):
            return type("Protocol", (), {"pick": staticmethod(pick)})

    monkeypatch.setattr("ropefric.trials.extract.PROTOCOLS", Doubting())
    return lab.pulls(a=100, b=101, c=100.5, d=99)


def test_a_doubtful_trial_is_never_kept_and_comes_with_its_candidates(doubtful_last):
    extraction = doubtful_last.extract()
    found = extraction.trials[-1]
    assert (found.kept, found.outcome) == (False, "without a force")
    assert found.to_dict()["candidates"] == "97.3 N at 1.3 s (0.61); 51.25 N at 0.7 s"
    assert math.isnan(found.peak_N)
    (problem,) = (problem for problem in extraction.problems if problem.code == "RF234")
    assert "d: doubtful: two falls may be it" in problem.message
    assert "give the trial a pick_s or a peak_N" in problem.fix
    row = extraction.to_dict()["trials"][-1]
    assert (row["status"], row["candidates"][0]["force_N"]) == ("doubtful", 97.3)
    assert extraction.to_dict()["counts"]["status"] == {"ok": 3, "doubtful": 1}


def test_the_command_lists_what_is_doubtful_first(doubtful_last, capsys, monkeypatch):
    lab = doubtful_last
    (lab.folder / "a.csv").write_text("time_s,force_N\n0,1\n", encoding="utf-8")
    monkeypatch.chdir(lab.folder)
    assert main(["extract", ".", "--out", "out", "--no-figures"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert said.index("d doubtful") < said.index("a too-short")
    assert "97.3 N at 1.3 s" in said
    assert "doubtful: More than one thing in this recording" in said
    assert main(["extract", ".", "--out", "out", "--no-figures", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["counts"]["n_kept"] == 2
