"""What an extraction promises of every campaign, whatever it runs on."""

import gc
import hashlib
import json
import math
import tracemalloc

import numpy as np
import pytest
from drawn import drawn, loaded

from ropefric.cli.app import main
from ropefric.errors import InputError
from ropefric.files import disk
from ropefric.traces.breakaway import Status
from ropefric.trials import extract
from ropefric.trials.campaign import load_campaign
from ropefric.trials.extract import extract_campaign
from ropefric.trials.result import write_tables
from ropefric.trials.workers import guarded
from tests.trials.conftest import pull


def test_a_missing_recording_is_an_error_of_a_check_and_a_status_of_a_run(lab, capfd):
    lab.pulls(here=100.0, gone=100.0)
    (lab.folder / "gone.csv").unlink()
    with pytest.raises(ValueError, match=r"gone\.csv is not there") as caught:
        lab.load()
    assert caught.value.code == "RF124"
    campaign = lab.load(missing_recordings="flag")
    told = [(p.code, p.severity, p.line) for p in campaign.warnings if p.code == "RF124"]
    assert told == [("RF124", "warning", 3)]
    here, gone = extract_campaign(campaign).trials
    assert (here.breakaway.status, gone.breakaway.status, gone.sha256) == ("ok", "unreadable", "")
    assert "no such file" in gone.breakaway.detail
    assert math.isnan(gone.peak_N)
    words = [str(lab.path), "--out", str(lab.folder / "out"), "--no-figures", "--json"]
    assert main(["extract", *words]) == 0
    told = json.loads(capfd.readouterr().out)
    assert [trial["status"] for trial in told["trials"]] == ["ok", "unreadable"]
    assert main(["check", str(lab.path), "--quiet"]) == 3


def test_flagging_lets_no_other_mistake_through(lab):
    lab.pulls(here=100.0).write([lab.row("gone.csv", wrap_angle_deg="much")])
    with pytest.raises(ValueError, match="much"):
        lab.load(missing_recordings="flag")
    lab.pulls(here=100.0).write([lab.row("here.csv")], data="nowhere")
    with pytest.raises(ValueError, match="no folder"):
        lab.load(missing_recordings="flag")
    with pytest.raises(LookupError, match="flga") as caught:
        lab.load(missing_recordings="flga")
    assert "flag" in caught.value.fix


def rows_of(extraction, folder):
    """Everything that leaves an extraction: its dictionary, the bytes of its tables, what figures are drawn from."""
    outlines = [trial.outline and [getattr(trial.outline, name).tobytes()
        for name in trial.outline.__slots__] for trial in extraction.trials]  # fmt: skip
    return extraction.to_dict(), [path.read_bytes() for path in write_tables(extraction, folder)], outlines


@pytest.mark.slow
def test_results_do_not_depend_on_who_does_the_work(small_campaign, small_extraction, tmp_path, monkeypatch):
    campaign = load_campaign(small_campaign / "campaign.toml")
    serial, calls = rows_of(small_extraction, tmp_path), []
    monkeypatch.setattr(extract, "guarded", guarded)
    extraction = extract_campaign(campaign, jobs=2, progress=lambda *call: calls.append(call))
    assert rows_of(extraction, tmp_path) == serial
    backwards = lambda work, n, **_: ((place, work(place)) for place in reversed(range(n)))  # noqa: E731
    monkeypatch.setattr(extract, "guarded", backwards)
    assert rows_of(extract_campaign(campaign), tmp_path) == serial
    assert [(done, total) for done, total, _ in calls] == [(i + 1, 16) for i in range(16)]
    assert {text for *_, text in calls} == {f"{t.trial} {t.breakaway.status}" for t in extraction.trials}


def test_no_processes_cannot_work(lab):
    with pytest.raises(InputError, match="cannot work"):
        lab.pulls(a=100.0).extract(jobs=0)


def test_nothing_that_was_read_is_changed(lab):
    lab.pulls(a=100.0, b=90.0)
    campaign = lab.load()
    before, files = repr(dict(campaign)), {path: path.read_bytes() for path in lab.folder.iterdir()}
    extraction = extract_campaign(campaign)
    assert repr(dict(campaign)) == before
    assert {path: path.read_bytes() for path in lab.folder.iterdir()} == files
    told = extraction.to_dict()
    told["trials"][0]["peak_N"] = 0
    assert extraction.to_dict()["trials"][0]["peak_N"] != 0


def test_results_stand_in_the_order_of_the_list_even_when_files_are_shared(lab):
    """Rows of one file are read together; that must not show."""
    lab.pulls(a=100.0, b=90.0)
    rows = [lab.row("b.csv", trial="late b", from_s=1.4, until_s=2.4),
        lab.row("a.csv", trial="a#1", from_s="", until_s=""),
        lab.row("b.csv", trial="b", from_s=0, until_s=1.4),
        lab.row("b.csv", trial="b#2", from_s=2.4, until_s=2.5)]  # fmt: skip
    extraction = lab.write(rows).extract()
    assert [trial.trial for trial in extraction.trials] == ["late b", "a#1", "b", "b#2"]
    assert extraction.trials[1].peak_N == pytest.approx(100.0, rel=2e-3)
    assert Status.OK not in {extraction.trials[place].breakaway.status for place in (0, 3)}


def test_teeth_and_plateaus_are_numbered_trials(lab):
    tops_N, held_N = (100.0, 104.0, 97.0, 101.0), (60.0, 58.8)
    cycles = [(0.0, 0.0), *((at, force) for n, held in enumerate(held_N) for at, force in zip(
        np.array([1, 2, 5, 5.5]) + 5 * n, (0.0, held, held, 0.0), strict=True))]  # fmt: skip
    teeth = loaded(*((top_N, 70.0) for top_N in tops_N), rate_N_s=60.0)
    for protocol, corners, expected_N in (("stick-slip", teeth, tops_N), ("held", cycles, held_N)):
        time_s = np.arange(0.0, corners[-1][0] + 0.5, 0.001)
        lab.record("a.csv", time_s=time_s, force_N=drawn(*corners, time_s=time_s))
        lab.write([lab.row("a.csv")], f'[protocol]\nname = "{protocol}"\nside = "tight"\n')
        extraction = lab.extract()
        names = [f"a#{number}" for number in range(1, len(expected_N) + 1)]
        assert [trial.trial for trial in extraction.trials] == list(extraction.conditions[0].trials) == names
        assert [trial.peak_N for trial in extraction.trials] == pytest.approx(expected_N, rel=3e-3)


# --- doubts that are told ------------------------------------------------------------------------------------------


def codes(extraction):
    return {problem.code for problem in extraction.problems}


def test_an_excluded_trial_is_read_but_does_not_count(lab):
    lab.pulls(a=100.0, b=150.0)
    extraction = lab.write([lab.row("a.csv", exclude=""), lab.row("b.csv", exclude="rope jumped")]).extract()
    a, b = extraction.trials
    assert (a.kept, b.kept, b.excluded, b.rejected_by) == (True, False, "rope jumped", "")
    assert b.peak_N == pytest.approx(150, rel=2e-3)
    (condition,) = extraction.conditions
    assert (condition.n_recorded, condition.n, condition.n_kept) == (2, 1, 1)
    assert condition.mean_kept_N == a.peak_N


def test_a_clock_against_the_stated_rate_is_told(lab):
    lab.pulls(a=100.0)
    rows = [lab.row("a.csv")]
    assert "RF203" not in codes(lab.write(rows, '[sampling]\nrate = "1 kHz"').extract())
    extraction = lab.write(rows, '[sampling]\nrate = "2 kHz"').extract()
    (problem,) = (p for p in extraction.problems if p.code == "RF203")
    assert (problem.severity, problem.path) == ("error", "a.csv")
    assert "1000 Hz" in problem.message
    assert "2000 Hz" in problem.message


@pytest.mark.slow
def test_memory_does_not_grow_with_the_number_of_recordings(lab, pull_csv):
    """What stays of a recording is its result; the samples of at most one are there at a time."""
    names = [f"r{i:02d}.csv" for i in range(40)]
    for seed, name in enumerate(names):
        (lab.folder / name).write_text(pull_csv(100.0, seed=seed, rate_Hz=8000.0))
    samples_bytes = 2 * 8 * 20_000

    def peak_and_result(n):
        campaign = lab.write([lab.row(name) for name in names[:n]]).load()
        gc.collect()
        tracemalloc.start()
        extraction = extract_campaign(campaign)
        gc.collect()
        held, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert len(extraction.trials) == n
        return peak, held

    peak_and_result(2)  # what is loaded once
    few, many = peak_and_result(10), peak_and_result(40)
    assert many[0] - few[0] < (many[1] - few[1]) + samples_bytes
    assert (many[1] - few[1]) / 30 < 0.1 * samples_bytes


@pytest.mark.parametrize(("large", "in_place"), [(False, True), (True, False)])
def test_hash_and_numbers_come_from_the_same_bytes(lab, pull_csv, monkeypatch, *, large, in_place):
    """A file that is replaced between being hashed and being parsed."""
    if large:
        monkeypatch.setattr(disk, "KEPT_BYTES", 100)
    lab.pulls(a=100.0)
    target, other, real = lab.folder / "a.csv", pull_csv(150.0, seed=3).encode(), extract.read_recordings
    first = target.read_bytes()
    todo = [other]

    def replace_it(*args, **options):
        while todo:
            if in_place:
                target.write_bytes(todo.pop())
            else:
                (lab.folder / "new").write_bytes(todo.pop())
                (lab.folder / "new").replace(target)
        return real(*args, **options)

    monkeypatch.setattr(extract, "read_recordings", replace_it)
    (trial,) = lab.extract().trials
    assert not todo
    read_bytes = first if round(trial.peak_N) == 100 else other
    assert trial.peak_N == pytest.approx(100 if read_bytes is first else 150, rel=0.01)
    assert trial.sha256 == hashlib.sha256(read_bytes).hexdigest()
    (again,) = lab.extract().trials
    assert (again.sha256, again.peak_N) == (hashlib.sha256(other).hexdigest(), pytest.approx(150, rel=0.01))


@pytest.mark.parametrize(
    ("share", "zero_N", "setting"), [(0.15, 0.0, "pretension"), (0.0, 4.0, "zero"), (0.1, 2.0, "")]
)
def test_a_campaign_says_what_its_forces_at_rest_are(lab, share, zero_N, setting):
    """In step with F_B they are pretensions, alike errors of the zero; between the two nobody can say."""
    rows = []
    for seed, tension_N in enumerate((10, 20, 40, 10, 20, 40)):
        time_s, force_N = pull(2.0 * tension_N, seed=seed)
        rest_N = share * tension_N * (1.0 + 0.02 * (seed > 2)) + zero_N
        lab.record(
            f"{seed}.csv", time_s=time_s, force_N=np.maximum(force_N, rest_N) if share else force_N + zero_N
        )
        rows.append(lab.row(f"{seed}.csv", end_tension_N=tension_N))
    said = [one for one in lab.write(rows).extract().problems if one.code == "RF245"]
    assert [one.fix for one in said] == [f'set [protocol] rest = "{setting}" in campaign.toml'] * bool(
        setting
    )
    if setting == "zero":
        answered = lab.write(rows, '[protocol]\nrest = "zero"').extract()
        assert "RF245" not in codes(answered)
