"""The report in a real browser: drawn without complaint, on any screen, by keyboard alone, on paper."""

import base64
import io
import re
from itertools import pairwise

import numpy as np
import pytest
from matplotlib import image

pytestmark = [pytest.mark.usefixtures("run"), pytest.mark.slow]
WIDTHS = (1280, 390)
FINE = 4.5
LARGE = 3.0
A4_PX = 96 * (297 - 30) / 25.4

OVERFLOW = """(() => {
  const width = document.documentElement.clientWidth, out = [];
  for (const e of document.querySelectorAll('body *')) {
    if (e.closest('.scroll, .hidden, .skip') && !e.matches('.scroll')) continue;
    const box = e.getBoundingClientRect();
    if (box.width && (box.right > width + 1 || box.left < -1)) out.push(e.tagName + '.' + e.className);
  }
  return {page: document.documentElement.scrollWidth, width, out};
})()"""

FIGURES = """[...document.querySelectorAll('figure')].map(f => {
  const svg = f.querySelector('svg'), box = svg.getBoundingClientRect(), style = getComputedStyle(svg);
  return {name: f.id, width: box.width, height: box.height, whole: f.getBoundingClientRect().height,
          marks: svg.querySelectorAll('path, use, rect, line, polyline, circle').length,
          seen: style.visibility === 'visible' && style.display !== 'none' && +style.opacity > 0};
})"""

CONTRAST = """(() => {
  const channel = c => { c /= 255; return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4; };
  const light = c => 0.2126 * channel(c[0]) + 0.7152 * channel(c[1]) + 0.0722 * channel(c[2]);
  const read = text => (text.match(/[\\d.]+/g) || [0, 0, 0, 0]).map(Number);
  const over = (top, under) => { const a = top.length > 3 ? top[3] : 1;
    return [0, 1, 2].map(i => a * top[i] + (1 - a) * under[i]); };
  const behind = e => { const layers = [];
    for (; e; e = e.parentElement) layers.push(read(getComputedStyle(e).backgroundColor));
    return layers.reverse().reduce((under, top) => over(top, under), [255, 255, 255]); };
  const found = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node; (node = walker.nextNode());) {
    const e = node.parentElement;
    if (!node.data.trim() || e.closest('svg, .hidden, style')) continue;
    const style = getComputedStyle(e), under = behind(e), ink = over(read(style.color), under);
    const [a, b] = [light(ink), light(under)].sort((x, y) => y - x);
    const size = parseFloat(style.fontSize), bold = +style.fontWeight >= 700;
    found.push([(a + 0.05) / (b + 0.05), size >= 24 || (bold && size >= 18.66), node.data.trim().slice(0, 40)]);
  }
  return found;
})()"""

FOCUS = """(() => { const e = document.activeElement, style = getComputedStyle(e), box = e.getBoundingClientRect();
  return {body: e === document.body, key: e.tagName + ' ' + (e.getAttribute('href') || e.textContent.slice(0, 30)),
          outline: parseFloat(style.outlineWidth), line: style.outlineStyle, top: box.top, bottom: box.bottom,
          tall: innerHeight}; })()"""


@pytest.mark.parametrize("width", WIDTHS)
def test_it_is_drawn_without_complaint_and_nothing_runs_off_the_screen(browser, results, width):
    browser.show(results / "report.html", width)
    bad = [e for e in browser.events if e.get("method") in {"Log.entryAdded", "Runtime.exceptionThrown"}]
    assert bad == []
    fetched = [
        e["params"]["request"]["url"]
        for e in browser.events
        if e.get("method") == "Network.requestWillBeSent"
    ]
    assert len(fetched) == 1
    found = browser.ask(OVERFLOW)
    assert found["page"] == found["width"] == width
    assert found["out"] == []
    figures = browser.ask(FIGURES)
    assert len(figures) > 10
    for figure in figures:
        assert figure["seen"], figure["name"]
        assert figure["width"] >= 300, figure["name"]
        assert figure["height"] >= 100, figure["name"]
        assert figure["marks"] > 5, figure["name"]


def test_what_is_wider_than_the_screen_scrolls_and_can_be_reached_by_keyboard(browser, results):
    browser.show(results / "report.html", 390)
    wide = browser.ask(
        "[...document.querySelectorAll('main .scroll')].filter(e => e.scrollWidth > e.clientWidth)"
        ".map(e => [e.tabIndex, getComputedStyle(e).overflowX, e.getAttribute('aria-label')])"
    )
    assert len(wide) > 5
    for tab, overflow, name in wide:
        assert (tab, overflow) == (0, "auto")
        assert name


def test_ink_stands_out_from_paper(browser, results):
    browser.show(results / "report.html", 1280)
    browser.ask("document.querySelectorAll('details').forEach(e => { e.open = true; })")
    found = browser.ask(CONTRAST)
    assert len(found) > 500
    assert [row for row in found if row[0] < (LARGE if row[1] else FINE)] == []


def test_every_link_and_fold_is_reached_by_tab_and_seen(browser, results):
    browser.show(results / "report.html", 1280)
    wanted = browser.ask(
        "[...document.querySelectorAll('a[href], summary')]"
        ".map(e => e.tagName + ' ' + (e.getAttribute('href') || e.textContent.slice(0, 30)))"
    )
    most = browser.ask("document.querySelectorAll('a[href], summary, [tabindex=\"0\"]').length")
    reached = []
    for _ in range(most):
        browser.press("Tab")
        found = browser.ask(FOCUS)
        if found["body"]:  # round once
            break
        assert found["outline"] >= 2, found["key"]
        assert found["line"] != "none", found["key"]
        assert found["bottom"] > 0, found["key"]
        assert found["top"] < found["tall"], found["key"]
        reached.append(found["key"])
    assert [key for key in reached if key in wanted] == wanted
    assert wanted[0] == "A #result"


def test_each_figure_is_a_named_picture_to_a_screen_reader(browser, results):
    browser.show(results / "report.html", 1280)
    browser.call("Accessibility.enable")
    nodes = browser.call("Accessibility.getFullAXTree")["nodes"]
    roles = [node.get("role", {}).get("value") for node in nodes]
    images = [
        node["name"]["value"] for node in nodes if node.get("role", {}).get("value") in {"image", "img"}
    ]
    assert len([name for name in images if len(name) > 20]) == browser.ask(
        "document.querySelectorAll('figure').length"
    )
    assert roles.count("main") == roles.count("navigation") == 1
    levels = browser.ask("[...document.querySelectorAll('h1, h2, h3')].map(e => +e.tagName[1])")
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(after - before <= 1 for before, after in pairwise(levels))


def test_no_figure_is_cut_on_paper(browser, results, tmp_path):
    browser.show(results / "report.html", 688)  # 182 mm, what the margins leave of A4
    browser.call("Emulation.setEmulatedMedia", media="print")
    try:
        for figure in browser.ask(FIGURES):
            assert 60 < figure["whole"] < A4_PX, figure["name"]
        kept = browser.ask(
            "[...document.querySelectorAll('figure')].map(e => getComputedStyle(e).breakInside)"
        )
        assert {*kept} == {"avoid"}
        assert browser.ask("document.documentElement.scrollWidth") <= 688
        shown = browser.ask("getComputedStyle(document.querySelector('nav')).display")
        assert shown == "none"
    finally:
        browser.call("Emulation.setEmulatedMedia", media="")
    printed = base64.b64decode(browser.call("Page.printToPDF", preferCSSPageSize=True)["data"])
    boxes = {tuple(map(float, box.split())) for box in re.findall(rb"/MediaBox \[([^\]]+)\]", printed)}
    assert len(boxes) == 1
    *_, wide_pt, tall_pt = boxes.pop()
    assert (wide_pt, tall_pt) == (pytest.approx(595.3, abs=1), pytest.approx(841.9, abs=1))
    assert 5 < len(re.findall(rb"/Type /Page\b", printed)) < 30


def test_dumping_the_page_needs_no_script(browser, results):
    """The page without any script switched on is the same page."""
    browser.call("Emulation.setScriptExecutionDisabled", value=True)
    try:
        browser.show(results / "report.html", 1280)
        assert browser.ask("document.querySelectorAll('figure svg').length") > 10
    finally:
        browser.call("Emulation.setScriptExecutionDisabled", value=False)


@pytest.fixture
def dark(browser):
    """The browser, asked for dark pages."""
    wish = [{"name": "prefers-color-scheme", "value": "dark"}]
    browser.call("Emulation.setEmulatedMedia", media="", features=wish)
    yield browser
    browser.call("Emulation.setEmulatedMedia", media="", features=[])


def test_ink_stands_out_in_the_dark_too(dark, results):
    dark.show(results / "report.html", 1280)
    dark.ask("document.querySelectorAll('details').forEach(e => { e.open = true; })")
    paper = dark.ask("getComputedStyle(document.body).backgroundColor")
    assert max(map(int, re.findall(r"\d+", paper)[:3])) < 60
    # What has no colour of its own behind it lies on the page, which is dark.
    found = dark.ask(CONTRAST.replace("[255, 255, 255]", f"[{paper[4:-1]}]"))
    assert len(found) > 500
    assert [row for row in found if row[0] < (LARGE if row[1] else FINE)] == []


def test_figures_are_light_on_dark_where_the_page_is_dark(dark, results):
    dark.show(results / "report.html", 1280)
    box = dark.ask(
        "(() => { const b = document.querySelector('#fig-law svg').getBoundingClientRect();"
        "return [b.x + scrollX, b.y + scrollY, b.width, b.height]; })()"
    )
    clip = dict(zip(("x", "y", "width", "height"), box, strict=True), scale=1)
    shot = dark.call("Page.captureScreenshot", format="png", captureBeyondViewport=True, clip=clip)["data"]
    light = image.imread(io.BytesIO(base64.b64decode(shot)))[..., :3].mean(axis=2)
    assert np.median(light) < 0.25
    assert np.quantile(light, 0.999) > 0.8


def test_on_a_telephone_the_first_pictures_fit_and_can_be_read(browser, results):
    browser.show(results / "report.html", 390)
    for stem in ("typical_recording", "law"):
        width, letters = browser.ask(
            f"(() => {{ const svg = document.querySelector('#fig-{stem} svg'), b = svg.getBoundingClientRect();"
            "const sizes = [...svg.querySelectorAll('text')].map(t => t.getBoundingClientRect().height);"
            "return [b.width, Math.min(...sizes)]; })()"
        )
        assert width <= 390
        assert letters >= 8


def test_formulas_are_typeset_and_stay_on_the_page(browser, results):
    browser.show(results / "report.html", 390)
    boxes = browser.ask(
        "[...document.querySelectorAll('math')].map(e => { const b = e.getBoundingClientRect();"
        "return [b.width, b.height]; })"
    )
    assert boxes
    assert all(wide > 20 and 10 < high < 200 for wide, high in boxes)
