"""Figures inside a page: text that can be read, ids that do not collide, the same bytes."""

import math
import re
from itertools import combinations
from xml.etree import ElementTree as ET

import matplotlib as mpl
import pytest

from ropefric.plotting.campaign import draw_condition
from ropefric.plotting.figure import DataTable, FigureWithData, new_figure, svg_text
from ropefric.plotting.style import house_style


@pytest.fixture(scope="module")
def extracted(extraction_of, trials):
    return extraction_of(trials)


@pytest.fixture(scope="module")
def drawn(extracted):
    return draw_condition(extracted.conditions[0], extracted.trials)


def test_it_is_one_picture_with_its_words(drawn):
    page = svg_text(drawn)
    root = ET.fromstring(page)  # noqa: S314  (our own text)
    assert (root.tag, root.attrib["role"], root.attrib["aria-label"]) == ("svg", "img", drawn.alt)
    words = ["".join(text.itertext()) for text in root.iter("text")]
    assert "Time t [s]" in words
    assert "Break-away force FA [N]" in words  # one run of words, the index in a tspan of its own
    assert any("7 of 11 trials kept" in text for text in words)
    index = next(span for span in root.iter("tspan") if span.text == "A")
    assert index.attrib["font-size"] == "70%"
    for word in ("<style", "<metadata", "<script", "http", "<?xml", "<!", "@font-face", "date"):
        assert word not in page


def test_every_reference_has_its_id_and_no_two_figures_share_one(drawn):
    found = {}
    for stem, figure in (('one "&', drawn), ("two", drawn), ("", drawn), ("r#1", drawn), ("r-1", drawn)):
        text = svg_text(figure, stem=stem)
        ids = re.findall(r' id="([^"]+)"', text)
        assert len(ids) == len(set(ids))
        assert set(re.findall(r"url\(#(\w+)\)|href=\"#(\w+)", text)) == {
            (name, "") if f"url(#{name})" in text else ("", name) for name in ids
        }
        found[stem] = set(ids)
    for one, other in combinations(found.values(), 2):
        assert one
        assert not one & other


def test_a_colour_is_no_reference():
    with house_style():
        figure = new_figure(3.0, 2.0, margins={})
        axes = figure.subplots()
        axes.axvspan(0.0, 0.5, facecolor="#ABCDEF", edgecolor="#123456", hatch="//", linewidth=2.0)
        axes.axhline(0.5, color="#123456")
    text = svg_text(FigureWithData(figure=figure, tables=()), stem="x")
    assert text.count("stroke: #123456") == 3  # the frame of the span, its hatch, the line
    assert re.search(r"fill: url\(#\w+\)", text)


def test_the_same_figure_gives_the_same_text_whatever_was_drawn_before(drawn):
    first = svg_text(drawn)
    with mpl.rc_context({"font.size": 30.0, "svg.fonttype": "path", "svg.hashsalt": "x"}):
        again = svg_text(drawn)
    assert again == first


def test_no_figure_is_without_words():
    with house_style():
        figure = new_figure()
        figure.subplots().set(xlabel="Time t [s]", ylabel="Break-away force $F_{\\mathrm{A}}$ [N]")
    table = DataTable.of_rows(("n",), ((1,), (2,)))
    assert (FigureWithData(figure=figure,
        tables=(table,)).alt == "Break-away force F_A [N] over Time t [s] (2 rows of data).")  # fmt: skip
    assert FigureWithData(figure=new_figure(), tables=(), alt=" ").alt == "Figure (0 rows of data)."


def test_what_no_eye_sees_in_a_place_is_not_in_the_text():
    """The last bits of a layout differ from processor to processor."""
    texts = set()
    for left in (0.2, math.nextafter(0.2, 1.0), 0.2 + 1e-12):
        with house_style():
            figure = new_figure(3.0, 2.0, margins={})
            axes = figure.add_axes((left, 0.2, 0.7, 0.7))
            axes.plot([0.0, 1.0], [0.0, 2.0], marker="o")
        texts.add(svg_text(FigureWithData(figure=figure, tables=()), stem="x"))
    assert len(texts) == 1
