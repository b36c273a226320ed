"""What is handed over: the first pages, PDF, figures as files, a table's report."""

import datetime as dt
import math
import re
import shutil
from dataclasses import replace

import pandas as pd
import pytest

from ropefric.cli.app import main
from ropefric.plotting.campaign import typical_trial
from ropefric.report import page as pages
from ropefric.report.campaign import summary_sections, write_report
from ropefric.report.page import Wish
from ropefric.section import plus_minus
from ropefric.trials.campaign_model import ReportWords

WORDS = ('\n[report]\nlab = "Friction & rope laboratory"\ncustomer = "Hoists Ltd."\nnumber = "2026-014"\n'
    'date = 2026-01-20\nquestion = "Which load does the wheel lift?"\n'
    'assumptions = ["rope dry, at 20.5 °C"]\n')  # fmt: skip


@pytest.fixture(scope="module")
def five(tmp_path_factory):
    """Five pulls of one condition with words for the report; its results. Do not write to it."""
    folder = tmp_path_factory.mktemp("five")
    words = ["simulate", str(folder / "c"), "--conditions", "1", "--repeats", "5", "--no-faults", "--quiet"]
    assert main(words) == 0
    campaign = folder / "c" / "campaign.toml"
    campaign.write_text(campaign.read_text(encoding="utf-8") + WORDS, encoding="utf-8")
    assert main(["report", str(campaign), "--out", str(folder / "out"), "--no-figures", "--quiet"]) == 4
    return folder


@pytest.fixture(scope="module")
def handed(five):
    return (five / "out" / "report.html").read_text(encoding="utf-8")


def test_what_is_given_is_said_and_nothing_is_made_up(run, without_figures):
    given = ReportWords(customer="Hoists & Ropes", date=dt.date(2026, 1, 20))
    told = replace(run, campaign=run.campaign.model_copy(update={"report": given}))
    handed = without_figures(told)
    lift_N = run.answer.prediction.lift_force_N[0]
    for said in ("<dt>Customer</dt><dd>Hoists &amp; Ropes</dd>", "<dt>Date</dt><dd>2026-01-20</dd>",
        f'<dd class="value">{plus_minus(lift_N, run.answer.prediction.std_N[0])} N</dd>'):  # fmt: skip
        assert said in handed
    for label in ("Laboratory", "Operator", "Question"):
        assert f"<dt>{label}</dt>" not in handed
    assert "<dt>Customer</dt>" not in without_figures(run)


@pytest.mark.slow
def test_it_is_printed_short_with_page_numbers_alike_each_time(five, tmp_path):
    words = ["report", str(five / "c"), "--out", str(tmp_path), "--figure-files", "svg", "--quiet"]
    assert main(words) == 4
    handed = (tmp_path / "report.html").read_text(encoding="utf-8")
    written = {path.name for path in (tmp_path / "figures").iterdir()}
    assert {"law.svg", "typical_recording.svg", "residuals.svg"} <= written
    assert not {"law.png", "law.pdf"} & written
    assert "<code>figures/law.svg</code>" in handed
    try:
        pages.find_browser()
    except pages.RopefricError:
        pytest.skip("no browser on this machine: apt-get install chromium")
    printed = pages.pdf_of(handed)
    assert printed.startswith(b"%PDF")
    assert len(re.findall(rb"/Type /Page\b", printed)) <= 6
    assert pages.pdf_of(handed) == printed


def test_without_a_browser_it_is_said_what_to_do(run, results, monkeypatch, capfd):
    monkeypatch.setenv("PATH", "")
    monkeypatch.setattr(pages, "_PLACES", ())
    assert main(["report", str(results), "--pdf"]) == 3
    said = " ".join(capfd.readouterr().err.split())
    assert "no Chromium, Chrome or Edge was found" in said
    assert pages.BROWSER in said
    monkeypatch.setenv(pages.BROWSER, "/nowhere/chrome")
    assert main(["report", str(results), "--pdf"]) == 3
    assert "'/nowhere/chrome', which is no program" in capfd.readouterr().err


def test_a_browser_that_prints_nothing_is_said(monkeypatch):
    monkeypatch.setenv(pages.BROWSER, shutil.which("true"))
    with pytest.raises(pages.RopefricError, match=r"printed no PDF: it said nothing"):
        pages.pdf_of("<p>page</p>")


def test_a_short_report_is_the_first_pages_alone(run, results, page, tmp_path):
    write_report(run, tmp_path, Wish(short=True))
    short = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert re.findall(r'<section id="(\w+)"', short) == ["result"]
    assert re.findall(r'<figure id="fig-(\w+)"', short) == ["typical_recording", "law"]
    assert "<nav" not in short
    first, second = (re.sub(r" fig-\w+|Figure \d+", "", one) for one in (short, page))
    start = first.index('<section id="result"')
    assert first[start:].partition("</section>")[0] in second


def test_decisions_of_people_stand_on_the_first_page_and_in_the_annex(run, without_figures):
    trials = list(run.extraction.trials)
    taken = {"decision": "peak_N = 90 N", "by": "A. Smith", "why": "the cell slipped"}
    trials[3] = replace(trials[3], **taken, when="2026-11-22T14:30:00+00:00")
    trials[4] = replace(trials[4], excluded="torn", by="B. Jones", when="2026-11-25T09:00:00+00:00")
    changed = without_figures(replace(run, extraction=replace(run.extraction, trials=tuple(trials))))
    said = "<li>2 trials decided by A. Smith, B. Jones from 2026-11-22 to 2026-11-25.</li>"
    assert said in changed
    table = changed[changed.index("<h3>Decisions of people") : changed.index("<h3>Conditions")]
    for word in (trials[3].trial, *taken.values(), "2026-11-22", "B. Jones", "2026-11-25"):
        assert f">{word}</t" in table


def test_a_sheet_of_forces_has_a_law_and_a_first_page(tmp_path):
    """Without a wheel to predict; what is said beside it is looked for in the file that is named."""
    header = ["wheel_radius_mm", "rope_diameter_mm", "wrap_angle_deg", "end_tension_N", "peak_N"]
    rows = [(30, 10, wrap, 20, 20 * math.exp(0.15 * math.radians(wrap)) * (1 + off))
        for wrap in (180, 360, 540, 720) for off in (-0.01, 0.0, 0.01)]  # fmt: skip
    table, about = tmp_path / "t.xlsx", tmp_path / "about.toml"
    pd.DataFrame(rows, columns=header).to_excel(table, index=False)
    about.write_text('[report]\noperator = "A. Smith"\n', encoding="utf-8")
    words = ["report", str(table), "--out", str(tmp_path / "o"), "--quiet", "--no-figures"]
    assert main([*words, "--about", str(about)]) in {0, 4}
    page = (tmp_path / "o" / "report.html").read_text(encoding="utf-8")
    assert "Lift force of the design" not in page
    assert "12 trials of 4 conditions" in page
    assert "<dt>Operator</dt><dd>A. Smith</dd>" in page
    assert not {"trials", "recordings"} & {*re.findall(r'<section id="(\w+)"', page)}
    about.write_text('[report]\noperater = "A. Smith"\n', encoding="utf-8")
    assert main([*words, "--about", str(about)]) == 3
    assert main(["report", str(tmp_path / "missing.csv"), "--out", str(tmp_path / "p")]) == 3


def test_a_typical_recording_is_the_kept_one_closest_to_the_mean(run):
    item = run.extraction.conditions[2]
    by_name = {trial.trial: trial for trial in run.extraction.trials}
    kept = [by_name[name] for name in item.trials if by_name[name].kept]
    typical = typical_trial(run.extraction, 3)
    assert typical in kept
    off = abs(typical.measured_N - item.mean_kept_N)
    plain = [trial for trial in kept if not (trial.breakaway.events or trial.breakaway.notes)] or kept
    assert off == min(abs(trial.measured_N - item.mean_kept_N) for trial in plain)
    bare = tuple(replace(trial, outline=None) for trial in run.extraction.trials)
    assert typical_trial(replace(run.extraction, trials=bare), 3) is None


def test_a_reason_is_given_once_and_only_remarks_have_a_heading(handed):
    """Five pulls of one condition support no law: the first alert says why, and no other place on the first page."""
    first = handed.partition('id="provenance"')[0].partition("<h3>The law")[0]
    (reason,) = re.findall("Do not use</span>.*?</strong>(.*?)</li>", first)
    assert first.count(reason.strip()) == 1
    assert "See the first line" not in handed
    assert "<h3>Trials not kept" not in handed  # all five are


def test_notes_on_recordings_are_counted_by_kind(run):
    trials = list(run.extraction.trials)
    for i, force in enumerate((20.6, 7.125, 20.4)):
        note = f"the rope at rest reads {force} N, which counts as a pretension"
        trials[i] = replace(trials[i], breakaway=replace(trials[i].breakaway, notes=(note,)))
    noted = replace(run, extraction=replace(run.extraction, trials=tuple(trials)))
    (found,) = (one for one in summary_sections(noted) if one.title == "Notes on the recordings")
    kept = "the rope at rest reads 20.6 N, which counts as a pretension"
    assert found.rows[0] == ("3", trials[0].trial, kept)
