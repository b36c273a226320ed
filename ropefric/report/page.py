"""A report as data, as one HTML page without other files, and the page printed as PDF."""

import math
import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, Literal, NamedTuple

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from ropefric import __version__
from ropefric.errors import RopefricError
from ropefric.files.plain_text import visible
from ropefric.glossary import counted
from ropefric.pipeline import CampaignAnswer, CampaignRun, Evidence
from ropefric.report import parts
from ropefric.section import Section, percent, plain, plus_minus
from ropefric.trials.campaign_model import ReportWords

_INDEXED = re.compile(r"\b([RFuUkνμδ]|mu)_(w|r|A|B|R|c|eff|tr|lin|hys|sm|q|inf|rope)\b")


class Alert(NamedTuple):
    """A remark on a result: a reason not to use it, a doubt, or a note."""

    grade: Literal["stop", "doubt", "note"]
    title: str
    text: str


class Fact(NamedTuple):
    """A key number: what it is, its value, and what belongs to it."""

    name: str
    value: str
    remark: str = ""


class Picture(NamedTuple):
    """A figure on the page, and the files of its numbers beside the page."""

    stem: str
    svg: str
    caption: str
    files: tuple[str, ...] = ()
    narrow: bool = False


class Fold(NamedTuple):
    """A section that is shown on demand, and not printed."""

    title: str
    section: Section


Block = Section | Picture | dict[str, str] | Fold | list[Fact] | list[Alert]
"""Of a chapter; a mapping holds particulars of what the report is about."""


class Chapter(NamedTuple):
    """A heading with blocks under it; `key` is its anchor."""

    key: str
    title: str
    blocks: tuple[Block, ...]


class Report(NamedTuple):
    """A whole report; its chapter `result` is what a reader may skip to."""

    title: str
    lead: str
    chapters: tuple[Chapter, ...]


def as_html(report: Report) -> str:
    """Return a report as an HTML page; the same report gives the same text.

    Everything but the figures is escaped. There is no script, and nothing is fetched.
    """
    blocks = [block for chapter in report.chapters for block in chapter.blocks]
    stems = [block.stem for block in blocks if isinstance(block, Picture)]
    numbers = {stem: place for place, stem in enumerate(stems, start=1)}
    template = _environment().get_template("report.html.j2")
    return visible(template.render(report=report, numbers=numbers, made_by=f"ropefric {__version__}")) + "\n"


@cache
def _environment() -> Environment:
    blanks: Any = {"trim_blocks": True, "lstrip_blocks": True}
    loader = PackageLoader("ropefric.report")
    environment = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, **blanks)
    environment.filters |= {"kind": _kind, "markup": Markup, "symbols": _symbols}
    return environment


def _kind(block: Block) -> str:
    """Return the kind of a block, by which the template chooses its form."""
    return type(block[0] if isinstance(block, list) else block).__name__.lower()


def _symbols(text: str) -> Markup:
    """Return text with the index of each symbol set low, all else escaped."""
    return Markup(_INDEXED.sub(r"\1<sub>\2</sub>", str(escape(text))))  # noqa: S704  (escaped just now)


_GIVEN = {
    "lab": "Laboratory",
    "customer": "Customer",
    "operator": "Operator",
    "number": "Report",
    "date": "Date",
}
_LIMITS = ("linearity", "hysteresis", "repeatability", "transmitter")


class Wish(NamedTuple):
    """How a report is wanted: as PDF too, with figures, these as which files, and its first pages alone."""

    pdf: bool = False
    figures: bool = True
    formats: tuple[str, ...] = ()
    short: bool = False


USUAL = Wish()


class Subject(NamedTuple):
    """The content of a report: an answer, its evidence, and the remarks beside it.

    `measured` are particulars of what was measured with what; `run` is None where there is a trial table alone.
    """

    title: str
    tally: str
    answer: CampaignAnswer
    evidence: Evidence
    provenance: Mapping[str, Any]
    words: ReportWords
    measured: Mapping[str, str]
    run: CampaignRun | None = None
    wish: Wish = USUAL


def front_blocks(
    subject: Subject, alerts: Sequence[Alert], remarks: Sequence[Alert], pictures: Sequence[Picture]
) -> Iterator[Block]:
    """Yield the blocks of the first two pages: grave doubts, question, answer, pictures, law, remarks, limits.

    `alerts` are of the answer, `remarks` of the measurements, which the annex holds in full.
    """
    answer, words = subject.answer, subject.words
    of_grade = {grade: [one for one in alerts if one.grade == grade] for grade in ("stop", "doubt")}
    yield from filter(None, (of_grade["stop"], _particulars(words)))
    yield [*_facts(answer, subject.evidence)]
    yield from pictures
    yield parts.fit_section(answer.fit, f"The law: {answer.fit.law}, {answer.winner.how}")
    doubtful = "; ".join(one.title for one in remarks if one.grade == "doubt")
    of_trials = [Alert("doubt", "The measurements", f"{doubtful}. The annex says what to do.")]
    noted = [*of_grade["doubt"], *of_trials[: bool(doubtful)]]
    if noted or not of_grade["stop"]:
        yield Section("Remarks")
        yield noted or [Alert("note", "All checks passed", "")]
    tested = f"Tested: {', '.join(parts.tested_ranges(answer.fit))}. The law is extrapolated beyond."
    yield Section("Limits and assumptions", notes=(tested, *words.assumptions, *_decided(subject.run)))
    yield {name: value for name, value in subject.measured.items() if value}


def _particulars(words: ReportWords) -> dict[str, str]:
    """Return question, laboratory, customer and the like, as far as they are given."""
    given = {"Question": words.question} | {label: getattr(words, name) for name, label in _GIVEN.items()}
    return {label: str(value) for label, value in given.items() if value}


def _decided(run: CampaignRun | None) -> Iterator[str]:
    """Yield the number of trials that people decided about, with names and dates."""
    trials = run.extraction.trials if run else ()
    if decided := [one for one in trials if one.decision or (one.excluded and one.by)]:
        who = ", ".join(sorted({one.by for one in decided if one.by})) or "a person who is not named"
        days = sorted({one.when.partition("T")[0] for one in decided if one.when})
        dates = f" on {days[0]}" if len(days) == 1 else f" from {days[0]} to {days[-1]}" if days else ""
        yield f"{counted(len(decided), 'trial')} decided by {who}{dates}."


def measured_rows(run: CampaignRun) -> dict[str, str]:
    """Return rope, wheels, force cells with their calibration, and the method, as far as they are given."""
    campaign, rope = run.campaign, run.campaign.rope
    density = rope.linear_density_kg_m
    weight = "" if density is None else f"{plain(1e3 * density)} g/m"
    used = {(trial.wheel_radius_m, trial.cell) for trial in run.extraction.trials}
    radii_m, own_cells = (set(one) for one in zip(*used, strict=True)) if used else (set(), set())
    wheels = [
        f"{name} R_w = {plain(1e3 * wheel.radius_m)} mm" + (f" ({wheel.material})" if wheel.material else "")
        for name, wheel in campaign.wheels.items()
        if wheel.radius_m in radii_m
    ]
    cells = [_cell_words(name, cell) for name, cell in campaign.cells.items() if name in own_cells]
    window_s = campaign.smoothing.window_s
    smoothing = campaign.smoothing.mode + (f", {plain(1e3 * window_s)} ms" if window_s else "")
    method = f"protocol {campaign.protocol.name}; smoothing {smoothing}; outliers by {campaign.rejection}"
    size = f"{plain(2e3 * rope.radius_m)} mm in diameter"
    of_rope = ", ".join(filter(None, (size, weight, rope.material)))
    on = {"Wheels": "; ".join(wheels), "Force cells": "; ".join(cells)}
    return {"Rope": of_rope, **on, "Method": method}


def _cell_words(name: str, cell: Any) -> str:
    """Return a cell's range, its number and calibration, and its limits of error, those that are assumed as such."""
    known = ", ".join(f"{limit} {100 * getattr(cell, limit):.2g} %" for limit in _LIMITS)
    assumed = f" ({', '.join(cell.assumed)} assumed, not stated)" if cell.assumed else ""
    said = (
        f"{name} to {plain(cell.full_scale_N)} N",
        cell.serial and f"serial {cell.serial}",
        cell.calibrated and f"calibrated {cell.calibrated}",
        f"of full scale: {known}{assumed}",
    )
    return ", ".join(filter(None, said))


def _facts(answer: CampaignAnswer, evidence: Evidence) -> Iterator[Fact]:
    """Yield the main numbers of the answer."""
    fit, found = answer.fit, answer.prediction
    if found is not None:
        at, std_N = found.conditions, float(found.std_N[0])
        cells = parts.setting_cells(at.wheel_radius_m[0], at.wrap_angle_rad[0], at.end_tension_N[0])
        (wheel, wrap, tension), rope = cells, plain(2e3 * at.rope_radius_m[0])
        where = f"mean ± standard error for R_w = {wheel} mm, φ = {wrap} deg, F_B = {tension} N, rope of {rope} mm"
        yield Fact("Lift force of the design", f"{plus_minus(found.lift_force_N[0], std_N)} N", where)
        level = f"{100 * found.level:g} %"
        mean = "of the mean law: the average of many new ropes"
        yield Fact(f"{level} confidence interval", f"{parts.ends(found.interval_N[0], std_N)} N", mean)
        if not math.isnan(float(found.prediction_interval_N[0][0])):
            one = parts.ends(found.prediction_interval_N[0], std_N)
            largest = evidence.lift and evidence.lift.budget.lines[0]
            most = f"; {percent(largest.share, '.0f')} of its variance: {largest.label}" if largest else ""
            yield Fact(f"{level} prediction interval", f"{one} N", f"of one pull with a new rope{most}")
    verdict = answer.verdict  # the first alert gives the reasons of any other word
    yield Fact("Law and verdict", f"{fit.law}, {verdict.word}", verdict.reason if verdict.supported else "")
    unseen, scatter = answer.winner.entry.loco_error, fit.statistics.scatter_within
    if math.isfinite(unseen):
        remark = "root mean square, each condition left out once"
        yield Fact("Error at unseen conditions", percent(unseen), remark)
    if math.isfinite(scatter):
        yield Fact("Repeatability", percent(scatter), "standard deviation of one pull")


BROWSER = "ROPEFRIC_BROWSER"
"""The environment variable that names the browser, where it is not found by itself."""

_NAMES = (
    *("chromium", "chromium-browser", "google-chrome", "google-chrome-stable"),
    *("chrome", "msedge", "brave-browser"),
)
_PLACES = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
    "C:/Program Files/Google/Chrome/Application/chrome.exe",
    "C:/Program Files (x86)/Microsoft/Edge/Application/msedge.exe",
)
_FLAGS = (
    *("--headless", "--disable-gpu", "--disable-dev-shm-usage", "--disable-extensions", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--no-pdf-header-footer"),
)
_PATIENCE_S = 300.0
_BY_HAND = "or open report.html in any browser and print it"
_DATE = re.compile(rb"(?<=Date \(D:)\d{14}")
_UUID = re.compile(rb"(?<=uuid:)[0-9a-f-]{36}")


def find_browser() -> str:
    """Return the program of a Chromium, Chrome or Edge: the one that is named, else one that is found."""
    named = os.environ.get(BROWSER, "")
    candidates = [named] if named else [*_NAMES, *_PLACES]
    for found in map(shutil.which, candidates):
        if found is not None:
            return found
    none = "no Chromium, Chrome or Edge was found"
    what = f"{BROWSER} names {named!r}, which is no program" if named else none
    fix = f"install one (apt-get install chromium), or name its program in {BROWSER}; {_BY_HAND}"
    raise RopefricError(f"a PDF is printed by a browser, and {what}", code="RF154", fix=fix)


def pdf_of(page: str) -> bytes:
    """Return an HTML page as PDF; the same page and browser give the same bytes.

    The page is ours, has no script and fetches nothing; so a browser that has no sandbox here, as in a container, is
    asked again to do without.
    """
    browser = find_browser()
    with tempfile.TemporaryDirectory(prefix="ropefric-", ignore_cleanup_errors=True) as folder:
        source, target = Path(folder, "report.html"), Path(folder, "report.pdf")
        source.write_text(page, encoding="utf-8")
        own = (f"--user-data-dir={folder}/profile", f"--print-to-pdf={target}", source.as_uri())
        said = ""
        for sandbox in ((), ("--no-sandbox",)):
            try:
                done = subprocess.run(  # noqa: S603  (the browser that was found, or that the user names)
                    [browser, *_FLAGS, *sandbox, *own], capture_output=True, timeout=_PATIENCE_S, check=False
                )
                said = done.stderr.decode(errors="replace").strip().rpartition("\n")[2]
            except (OSError, subprocess.TimeoutExpired) as error:
                said = str(error)
            if target.is_file():
                content = _DATE.sub(b"20000101000000", target.read_bytes())
                return _UUID.sub(b"00000000-0000-0000-0000-000000000000", content)
    why = f"the browser {browser} printed no PDF: {said or 'it said nothing'}"
    raise RopefricError(why, code="RF154", fix=f"name another one in {BROWSER}, {_BY_HAND}")
