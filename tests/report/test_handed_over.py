"""What is handed over: the first pages, numbers as a language writes them, PDF, figures as files, a table's report."""

import csv
import html
import json
import re
import shutil
from dataclasses import replace

import pytest

from ropefric.cli.app import main
from ropefric.files.plain_text import localized
from ropefric.report import pdf
from ropefric.report.pictures import typical_trial

WORDS = """
[report]
lab = "Friction & rope laboratory"
customer = "Hoists Ltd."
number = "2026-014"
date = 2026-01-20
question = "Which load does the wheel lift?"
assumptions = ["rope dry, at 20.5 °C"]
language = "de"
"""
GERMAN_TICK = re.compile(r">−?\d+,\d+</text>")


@pytest.fixture(scope="module")
def five(tmp_path_factory):
    """Five pulls of one condition with words for the report; its results. Do not write to it."""
    folder = tmp_path_factory.mktemp("five")
    words = ["simulate", str(folder / "c"), "--conditions", "1", "--repeats", "5", "--no-faults", "--quiet"]
    assert main(words) == 0
    campaign = folder / "c" / "campaign.toml"
    campaign.write_text(campaign.read_text(encoding="utf-8") + WORDS, encoding="utf-8")
    words = ["report", str(campaign), "--out", str(folder / "out"), "--figure-files", "svg,pdf", "--quiet"]
    assert main(words) == 4
    return folder


@pytest.fixture(scope="module")
def handed(five):
    return (five / "out" / "report.html").read_text(encoding="utf-8")


def seen(page):
    """The words of a page outside its figures, styles and formulas."""
    page = re.sub(r"<(style|svg|math|pre)\b.*?</\1>", " ", page, flags=re.DOTALL)
    return " ".join(html.unescape(re.sub(r"<[^>]+>", " ", page)).split())


def test_the_first_page_says_what_is_given_and_nothing_else(handed, page):
    first = handed[: handed.index('<section id="warnings"')]
    for said in (
        *("Friction &amp; rope laboratory", "Hoists Ltd.", "2026-014", "20.01.2026"),
        *("Which load does the wheel lift?", "rope dry, at 20,5 °C", "9,8 mm in diameter", "K1 to 1000 N"),
        *("Lift force of the design", "95 % confidence interval", "constant, not judged", "Do not use"),
        *('id="fig-typical_recording"', 'id="fig-law"', "<math", "Limits and assumptions"),
    ):
        assert said in first, said
    assert "Operator" not in handed
    for label in ("Laboratory", "Customer", "Operator", "Date", "Question"):
        assert f"<dt>{label}</dt>" not in page


def test_numbers_and_dates_are_german_where_that_is_asked_for(five, handed):
    words = seen(handed[: handed.index('<section id="provenance"')])
    assert re.findall(r"(?<![§\w.])\d+\.\d+(?!\.?\w)", words) == []
    assert len(GERMAN_TICK.findall(handed)) > 20
    assert not re.search(r">−?\d+\.\d+</text>", handed)
    assert "ropefric 0.1.0" in handed  # a version is no number
    told = json.loads((five / "out" / "prediction.json").read_text(encoding="utf-8"))
    assert localized(f"{told['lift_force_N']:.5g} N", "de") in handed
    with (five / "out" / "figures" / "law.csv").open(encoding="utf-8", newline="") as stream:
        float(next(csv.DictReader(stream))["lift_force_N"])  # programs go on reading points


def test_english_asked_for_by_option_wins(five, tmp_path):
    shutil.copytree(five / "out", tmp_path / "out")
    shutil.copytree(five / "c", tmp_path / "c")
    assert main(["report", str(tmp_path / "out"), "--locale", "en", "--no-figures", "--quiet"]) == 4
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "2026-01-20" in page
    assert "9.8 mm in diameter" in page
    assert not (tmp_path / "out" / "figures" / "law.svg").exists()  # of the run before, and no longer fits
    assert main(["report", str(tmp_path / "out"), "--locale", "fr"]) == 2


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("-0.26 % to 0.64 %", "-0,26 % to 0,64 %"),
        ("μ = 0.139 ± 0.00086, 1.5e-05 N", "μ = 0,139 ± 0,00086, 1,5e-05 N"),
        ("(0.5, 0.6); 0.1192(12).", "(0,5, 0,6); 0,1192(12)."),
        (
            "numpy 2.4.6, run_1.5.csv, v1.5, §8.1, 12:30:01.5",
            "numpy 2.4.6, run_1.5.csv, v1.5, §8.1, 12:30:01.5",
        ),
        ("2026-01-20 and 2026-01-20.csv", "20.01.2026 and 2026-01-20.csv"),
    ],
)
def test_only_numbers_and_dates_change(text, expected):
    assert localized(text, "de") == expected
    assert localized(text, "en") == text


def test_figures_stand_beside_it_as_files_alike_each_time(five, tmp_path):
    written = {path.name: path.read_bytes() for path in (five / "out" / "figures").iterdir()}
    assert {"law.svg", "law.pdf", "typical_recording.svg", "residuals.pdf"} <= written.keys()
    assert "law.png" not in written
    words = ["report", str(five / "c"), "--out", str(tmp_path), "--figure-files", "svg,pdf", "--quiet"]
    assert main(words) == 4
    again = {path.name: path.read_bytes() for path in (tmp_path / "figures").iterdir()}
    assert again == written
    assert written["law.svg"].startswith(b"<?xml")
    assert written["law.pdf"].startswith(b"%PDF")
    assert b"Date" not in written["law.pdf"] + written["law.svg"]


def test_it_is_printed_short_with_page_numbers_alike_each_time(five, handed):
    try:
        pdf.find_browser()
    except pdf.RopefricError:
        pytest.skip("no browser on this machine: apt-get install chromium")
    printed = pdf.pdf_of(handed)
    assert printed.startswith(b"%PDF")
    assert len(re.findall(rb"/Type /Page\b", printed)) <= 2 + 6
    assert pdf.pdf_of(handed) == printed


def test_without_a_browser_it_is_said_what_to_do(five, monkeypatch, capfd):
    monkeypatch.setenv("PATH", "")
    monkeypatch.setattr(pdf, "_PLACES", ())
    assert main(["report", str(five / "out"), "--pdf"]) == 3
    said = capfd.readouterr().err
    assert "no Chromium, Chrome or Edge was found" in said
    assert pdf.BROWSER in said
    monkeypatch.setenv(pdf.BROWSER, "/nowhere/chrome")
    assert main(["report", str(five / "out"), "--pdf"]) == 3
    assert "'/nowhere/chrome', which is no program" in capfd.readouterr().err


def test_a_browser_that_prints_nothing_is_said(monkeypatch):
    monkeypatch.setenv(pdf.BROWSER, shutil.which("true"))
    with pytest.raises(pdf.RopefricError, match=r"printed no PDF: it said nothing"):
        pdf.pdf_of("<p>page</p>")


@pytest.mark.parametrize("suffix", [".csv", ".xlsx"])
def test_a_table_of_forces_has_a_report_without_recordings(run, tmp_path, suffix):
    kept = run.answer.table.to_frame()
    kept = kept[kept.kept][[*kept.columns[:6]]]
    table = tmp_path / f"forces{suffix}"
    kept.to_excel(table, index=False) if suffix == ".xlsx" else kept.to_csv(table, index=False)
    about = tmp_path / "about.toml"
    design = '[design]\nwheel_radius = "40 mm"\nwrap_angle = "400 deg"\nend_tension = "60 N"\n'
    about.write_text(design + WORDS, encoding="utf-8")
    out = tmp_path / "out"
    words = ["report", str(table), "--about", str(about), "--out", str(out), "--quiet", "--law", "constant"]
    assert main([*words, *(["--no-figures"] if suffix == ".xlsx" else [])]) in {0, 4}
    page = (out / "report.html").read_text(encoding="utf-8")
    sections = re.findall(r'<section id="(\w+)"', page)
    assert sections[0] == "result"
    assert not {"trials", "recordings"} & {*sections}
    told = json.loads((out / "prediction.json").read_text(encoding="utf-8"))
    assert localized(f"{told['lift_force_N']:.5g} N", "de") in page
    assert "Hoists Ltd." in page
    assert f"forces{suffix}" in page
    assert f"ropefric report forces{suffix} --out out --about about.toml --law constant" in page
    assert (out / "fits" / "constant.json").is_file()
    assert ("<svg" in page) == (suffix == ".csv")


def test_a_table_without_a_file_beside_it_has_a_law_alone(tmp_path):
    rows = [
        f"0.03,0.005,{wrap},20,{20 * 2.718281828 ** (0.15 * wrap) * (1 + off):.6g}"
        for wrap in (2.0, 4.0, 6.0, 8.0, 10.0)
        for off in (-0.01, 0.0, 0.01)
    ]
    header = "wheel_radius_m,rope_radius_m,wrap_angle_rad,end_tension_N,peak_N"
    (tmp_path / "t.csv").write_text("\n".join([header, *rows]), encoding="utf-8")
    words = ["report", str(tmp_path / "t.csv"), "--out", str(tmp_path / "o"), "--quiet", "--no-figures"]
    assert main(words) in {0, 4}
    page = (tmp_path / "o" / "report.html").read_text(encoding="utf-8")
    assert "Lift force of the design" not in page
    assert "15 trials of 5 conditions" in page
    assert main(["report", str(tmp_path / "missing.csv"), "--out", str(tmp_path / "p")]) == 3


def test_every_recording_is_shown_once_with_its_pick(run, page):
    for trial in run.extraction.trials:
        assert page.count(f">{trial.trial}</text>") >= 1, trial.trial
    shown = page[page.index('id="fig-recordings_1"') :].split("</figure>")[0]
    for trial in run.extraction.trials:
        word = f"{trial.measured_N:.4g} N" if trial.outcome != "without a force" else trial.breakaway.status
        assert f">{word}</text>" in shown


def test_a_typical_recording_is_the_kept_one_closest_to_the_mean(run):
    item = run.extraction.conditions[2]
    by_name = {trial.trial: trial for trial in run.extraction.trials}
    kept = [by_name[name] for name in item.trials if by_name[name].kept]
    typical = typical_trial(run.extraction, 3)
    assert typical in kept
    off = abs(typical.measured_N - item.mean_kept_N)
    assert off == min(abs(trial.measured_N - item.mean_kept_N) for trial in kept)
    bare = tuple(replace(trial, outline=None) for trial in run.extraction.trials)
    assert typical_trial(replace(run.extraction, trials=bare), 3) is None
