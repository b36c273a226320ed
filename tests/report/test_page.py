"""The report as a file: alone in the world, complete, in order, true to the results it shows."""

import csv
import hashlib
import html
import json
import math
import re
from dataclasses import replace
from html.parser import HTMLParser
from itertools import pairwise

import pytest

from ropefric.errors import Problem
from ropefric.fitting.store import load_fit
from ropefric.plotting.campaign import typical_trial
from ropefric.section import plus_minus

LARGEST_BYTES = 3_000_000
VOID = {"meta", "br", "hr", "img", "input", "link"}
CHAPTERS = (*("result", "warnings", "trials", "recordings", "friction", "law"),
    *("uncertainty", "design", "next", "provenance"))  # fmt: skip
FIGURES = (*("typical_recording", "law", "recordings_1", "mu_facets", "capstan", "fit_over_wheel_radius"),
    *("ladder", "residuals", "budget_lift", "tornado", "design_chart"))  # fmt: skip


class Outline(HTMLParser):
    """Tags that are closed in the order they were opened, with their attributes and the text of each part."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.open, self.tags, self.words = [], [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))

    def handle_endtag(self, tag):
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


@pytest.fixture(scope="module")
def outline(page):
    return Outline(page)


@pytest.fixture(scope="module")
def words(outline):
    return " ".join(" ".join(outline.words).split())


def test_the_tags_are_closed_and_every_name_is_there_once(outline):
    assert outline.open == []
    names = [attributes["id"] for _, attributes in outline.tags if "id" in attributes]
    assert len(names) == len(set(names))


def test_nothing_is_fetched_and_every_link_leads_somewhere(outline, page):
    assert not {"script", "link", "img", "iframe", "object", "image"} & {tag for tag, _ in outline.tags}
    names = {attributes["id"] for _, attributes in outline.tags if "id" in attributes}
    for _, attributes in outline.tags:
        for key in ("href", "xlink:href", "src"):
            assert attributes.get(key, "#result")[:1] == "#"
            assert attributes.get(key, "#result")[1:] in names
        assert not any(key.startswith("on") for key in attributes)
    assert "@import" not in page
    assert set(re.findall(r"url\(([^)#]?)", page)) <= {""}
    assert len(page.encode()) < LARGEST_BYTES


def test_no_unset_mathematics_is_left(words):
    assert not re.search(r"\\math|\\times|\$", words)
    assert "{{" not in words
    assert "nan" not in words.lower().split()


def test_the_result_comes_first_then_what_to_know_then_the_evidence(outline):
    sections = [attributes["id"] for tag, attributes in outline.tags if tag == "section"]
    assert sections == [name for name in CHAPTERS if name in sections]
    assert {*CHAPTERS} == {*sections}
    linked = [attributes["href"][1:] for tag, attributes in outline.tags if tag == "a"]
    assert linked == ["result", *sections]
    # To a screen reader it is one page, whose headings go down by one.
    tags = [tag for tag, _ in outline.tags]
    levels = [int(tag[1]) for tag in tags if tag in {"h1", "h2", "h3"}]
    assert (levels[0], levels.count(1), tags.count("main"), tags.count("nav")) == (1, 1, 1, 1)
    assert all(after - before <= 1 for before, after in pairwise(levels))


def test_every_figure_has_words_and_its_numbers_beside_it(outline, page, results):
    pictures = [attributes for tag, attributes in outline.tags if tag == "svg"]
    figures = [attributes["id"] for tag, attributes in outline.tags if tag == "figure"]
    assert len(pictures) == len(figures) >= len(FIGURES)
    assert {f"fig-{name}" for name in FIGURES} <= {*figures}
    for picture in pictures:
        assert picture["role"] == "img"
        assert len(picture["aria-label"]) > 20
    named = re.findall(r"<code>(figures/[^<]+)</code>", page)
    assert len(named) >= len(figures)
    for name in named:
        with (results / name).open(encoding="utf-8", newline="") as stream:
            header, *rows = csv.reader(stream)
        assert rows, name
        assert all(len(row) == len(header) for row in rows)


def test_the_numbers_are_those_of_the_results(words, results):
    prediction = json.loads((results / "prediction.json").read_text(encoding="utf-8"))
    low, high = prediction["interval_N"]
    wide = prediction["prediction_interval_N"]
    lift_N, std_N = prediction["lift_force_N"], prediction["std_N"]
    # To the second digit of the standard error, all of them.
    places = 1 - math.floor(math.log10(float(f"{std_N:.1e}")))
    lift, std, *ends = (f"{value:.{places}f}" for value in (lift_N, std_N, low, high, *wide))
    assert f"{lift} ± {std} N" in words
    assert f"{ends[0]} … {ends[1]} N" in words
    assert f"{ends[2]} … {ends[3]} N" in words
    assert low < lift_N < high
    fit = load_fit(results / "fits" / f"{prediction['law']}.json")
    for item in fit.parameters:
        assert plus_minus(item.value, item.std).split(" ± ")[0] in words
    stated = json.loads((results / "uncertainty.json").read_text(encoding="utf-8"))
    assert f"U = {stated['expanded']:.3g} N" in words
    assert math.isclose(stated["estimate"], prediction["lift_force_N"], rel_tol=1e-9)
    first = stated["lines"][0]
    assert f"{100 * first['share']:.0f} % of its variance: {first['name']}" in words


def test_every_trial_that_does_not_count_is_named_with_its_reason(page, results):
    with (results / "trials.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    gone = [row for row in rows if row["kept"] != "true"]
    assert 0 < len(gone) < len(rows)
    table = page[page.index("<h3>Trials not kept") : page.index("<h3>Conditions")]
    assert table.count('<th scope="row"') == len(gone)
    for row in gone:
        verdict = row["status"] if row["status"] != "ok" else "rejected"
        assert f'>{row["trial"]}</th><td class="words">{verdict}</td>' in table
    kept = next(row["trial"] for row in rows if row["kept"] == "true")
    assert kept not in table


def test_a_remark_says_where_by_the_name_of_the_file_alone(run, without_figures):
    more = Problem(
        code="RF212", message="the zero drifts", path="/home/me/daq/r7.csv", line=3, severity="warning"
    )
    extraction = replace(run.extraction, problems=(*run.extraction.problems, more))
    assert "r7.csv:3: the zero drifts." in (page := without_figures(replace(run, extraction=extraction)))
    assert "/home/me" not in page


def test_recordings_with_a_remark_and_a_typical_one_a_condition_are_shown(run, evidence, page):
    shown = page[page.index('id="fig-recordings_1"') :].split("</figure>")[0]
    trials = run.extraction.trials
    wanted = {trial.trial for trial in trials if not trial.kept or trial.problems}
    typical = {typical_trial(run.extraction, i).trial for i in range(1, 7)}
    drawn = [trial for trial in trials if f">{trial.trial}</text>" in shown]
    assert {trial.trial for trial in drawn} == wanted | typical
    assert len(typical) == 6
    for trial in drawn:
        word = f"{trial.measured_N:.4g} N" if trial.outcome != "without a force" else trial.breakaway.status
        assert f">{word}</text>" in shown
    assert evidence.rejection[0] in html.unescape(page)


def test_the_inputs_stand_in_it_with_their_hashes(page, campaign, results):
    for path in (campaign / "campaign.toml", campaign / "trials.csv", *(campaign / "traces").iterdir()):
        assert hashlib.sha256(path.read_bytes()).hexdigest() in page
    for said in ("ropefric run campaign.toml --out out", "seeds: fit 0", "numpy", "rejection"):
        assert said in page
    manifest = json.loads((results / "manifest.json").read_text(encoding="utf-8"))
    assert (manifest["schema"], manifest["settings"]["rope"]["radius_m"]) == ("ropefric.run/1", 0.0049)
    assert (results / manifest["campaign"]).resolve() == (campaign / "campaign.toml").resolve()
    # But neither a place nor a time.
    for place in (campaign.parent, results.parent):
        assert str(place) not in page
    assert not re.search(r"\b20\d\d-\d\d-\d\d\b", page)
