"""A person's decision about a trial stands in the list, is carried out, shown, and never overridden."""

import csv

import numpy as np
import pytest

import ropefric as rf
from ropefric.errors import DataError
from ropefric.traces.breakaway import Status
from ropefric.traces.trace import ForceTrace
from ropefric.trials.campaign import check_campaign
from ropefric.trials.result import write_tables
from ropefric.trials.table import read_trial_table

SAID = {"why": "slip seen on the video", "by": "A. Lovelace"}
OPEN = {"sample": "", "pick_s": "", "peak_N": "", "peak_std_N": "", "exclude": "", "why": "", "by": ""}
EARLY_N = 60.0


def two_peaks(*, seed=0, late_N=100.0):
    """A ramp to 60 N at 0.8 s, a fall to 40 N, and a ramp on to 100 N at 1.8 s, from where it slides at 80 N."""
    time_s = np.arange(3000) / 1000
    force_N = np.interp(time_s, [0.2, 0.8, 0.82, 1.8, 1.82], [0, EARLY_N, 40, late_N, 0.8 * late_N])
    return time_s, force_N + 0.05 * np.random.default_rng(seed).standard_normal(time_s.size)


@pytest.fixture
def decided(lab, pull_csv):
    """Return a campaign of two pulls; `cells` is what the list says of the second, which has two peaks."""

    def decided(settings="", **cells):
        (lab.folder / "one.csv").write_text(pull_csv(100.0), encoding="utf-8")
        lab.record("two.csv", **dict(zip(("time_s", "force_N"), two_peaks(), strict=True)))
        return lab.write([lab.row("one.csv", **OPEN), lab.row("two.csv", **OPEN | cells)], settings)

    return decided


def test_a_peak_at_a_stated_time_is_measured_with_its_uncertainty(decided):
    lab = decided(pick_s=0.805, **SAID)
    trial = lab.extract().trials[-1]
    assert trial.breakaway.status is Status.OK
    assert trial.kept
    assert trial.peak_N == pytest.approx(EARLY_N, abs=0.3)
    assert abs(trial.breakaway.peak_time_s - 0.8) < 0.01
    assert 0.0 < trial.peak_std_N < 0.3
    assert (trial.decision, trial.by, trial.why) == ("pick_s = 0.805 s", SAID["by"], SAID["why"])
    assert any(note.startswith("without the decision: ") for note in trial.breakaway.notes)


def test_the_peak_that_the_picker_takes_has_the_same_uncertainty_where_a_person_names_it():
    """A zero that is not quite known, one that drifts and one that reads 3 % count as much as without the decision."""
    for level_N, drift_N_s in ((0.3, 0.0), (0.0, 0.2), (0.4, 0.1)):
        time_s = np.arange(3000) / 1000
        force_N = np.interp(time_s, [0.5, 1.8, 1.82], [0, 100, 80]) + level_N + drift_N_s * time_s
        trace = ForceTrace(
            time_s=time_s, force_N=force_N + 0.05 * np.random.default_rng(1).standard_normal(3000)
        )
        own = rf.find_breakaway(trace)
        assert own.status is Status.OK
        for moved_s in (0.0, 0.011, -0.011):
            found = rf.find_breakaway(trace, pick_s=own.peak_time_s + moved_s)
            assert (found.peak_N, found.peak_std_N) == pytest.approx((own.peak_N, own.peak_std_N))
    trace = ForceTrace(
        time_s=time_s, force_N=np.interp(time_s, [0.5, 1.8, 1.82], [4, 104, 84])
    )  # zero, or load?
    assert rf.find_breakaway(trace).status is Status.DOUBTFUL
    found = rf.find_breakaway(trace, pick_s=1.8)
    assert found.peak_N == pytest.approx(104.0, abs=0.2)
    assert found.peak_std_N == pytest.approx(4.0 / 3**0.5, rel=0.1)
    assert any(note.startswith("taken as read: ") for note in found.notes)


def test_the_highest_force_near_the_time_counts_and_a_time_without_a_peak_is_refused():
    time_s, force_N = two_peaks()
    trace = ForceTrace(time_s=time_s, force_N=force_N)
    for at_s in (0.79, 0.8, 0.81, 1.79, 1.81):
        expected_N = EARLY_N if at_s < 1 else 100.0
        assert rf.find_breakaway(trace, pick_s=at_s).peak_N == pytest.approx(expected_N, abs=0.3), at_s
    refused = ((5.0, "is not in the recording"), (0.4, "only rises"), (1.0, "only rises"), (-1.0, "not in"))
    for at_s, why in refused:
        with pytest.raises(DataError, match=why) as caught:
            rf.find_breakaway(trace, pick_s=at_s)
        assert (caught.value.code, caught.value.problem.key) == ("RF244", "pick_s")


def test_a_decision_that_cannot_be_carried_out_is_an_error_of_that_trial(decided):
    extraction = decided(pick_s=50, **SAID).extract()
    *others, trial = extraction.trials
    assert all(other.kept for other in others)
    assert trial.breakaway.status is Status.UNREADABLE
    assert "50 s is not in the recording, which runs from 0 s to 2.999 s" in trial.breakaway.detail
    (problem,) = (problem for problem in extraction.problems if problem.severity == "error")
    assert (problem.code, problem.path, problem.key) == ("RF244", "two.csv", "pick_s")


def test_a_stated_force_comes_with_a_stated_uncertainty_or_a_hundredth_of_it(decided):
    for given, std_N in (("", 0.77), (0.25, 0.25)):
        trial = decided(peak_N=77, peak_std_N=given, **SAID).extract().trials[-1]
        assert (trial.peak_N, trial.kept, trial.decision) == (77.0, True, "peak_N = 77 N")
        assert trial.peak_std_N == pytest.approx(std_N)
        assert any("taken as 1%" in note for note in trial.breakaway.notes) == (given == "")


def test_a_stated_force_holds_where_the_recording_cannot_be_read(decided):
    lab = decided(peak_N=77, **SAID)
    (lab.folder / "two.csv").write_bytes(b"\x00\x01 nothing a reader takes")
    extraction = lab.extract()
    assert (extraction.trials[-1].peak_N, extraction.trials[-1].kept) == (77.0, True)
    assert {problem.severity for problem in extraction.problems if problem.path == "two.csv"} == {"warning"}


HALF = [
    ({"pick_s": 0.8, "why": "w"}, "by", "RF121"), ({"pick_s": 0.8, "by": "b"}, "why", "RF121"),
    ({"peak_N": 80, "by": "b"}, "why", "RF121"), ({"pick_s": 0.8, "peak_N": 80, **SAID}, "peak_N", "RF111"),
    ({"peak_std_N": 1, **SAID}, "peak_std_N", "RF121"), ({"peak_N": 0, **SAID}, "peak_N", "RF110"),
    ({"peak_N": 50, "peak_std_N": -1, **SAID}, "peak_std_N", "RF110"),
    ({"pick_s": 0.8, "sample": "*", **SAID}, "pick_s", "RF111"),
]  # fmt: skip


def test_half_a_decision_is_refused_by_the_list_and_so_is_one_about_many_trials(decided):
    for cells, key, code in HALF:
        found = check_campaign(decided(**cells).path)
        told = [(one.code, one.key, one.line) for one in found if one.severity == "error"]
        assert told == [(code, key, 3)], cells
    lab = decided('[protocol]\nname = "stick-slip"', pick_s=0.8, **SAID)
    assert [problem.key for problem in check_campaign(lab.path) if problem.severity == "error"] == ["pick_s"]


def test_a_table_of_results_still_serves_as_a_list(decided, tmp_path):
    lab = decided(pick_s=0.8, **SAID)
    first = lab.extract()
    write_tables(first, tmp_path / "out")
    rows = list(csv.DictReader((tmp_path / "out" / "trials.csv").read_text(encoding="utf-8").splitlines()))
    told = [(row["decision"], row["decided_by"], row["decided_why"]) for row in rows[-2:]]
    assert told == [("", "", ""), ("pick_s = 0.8 s", SAID["by"], SAID["why"])]
    assert read_trial_table(tmp_path / "out" / "trials.csv").used.all()
    (lab.folder / "trials.csv").write_bytes((tmp_path / "out" / "trials.csv").read_bytes())
    again = lab.extract()
    assert again.trials[0].peak_N == first.trials[0].peak_N
    assert {trial.decision for trial in again.trials} == {""}
    assert any(one.key == "peak_N" and "not used" in one.message for one in check_campaign(lab.path))
