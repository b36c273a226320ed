"""The report in a real browser: drawn without complaint, on any screen, by keyboard alone, on paper, in the dark."""

import base64
import io
import re

import numpy as np
import pytest
from browser import complaints, driven
from matplotlib import image

webdriver = pytest.importorskip("selenium.webdriver")
from selenium.webdriver.common.keys import Keys  # noqa: E402

pytestmark = [pytest.mark.usefixtures("page"), pytest.mark.slow]
A4_PX = 96 * (297 - 30) / 25.4

OVERFLOW = """return (() => {
  const width = document.documentElement.clientWidth, out = [];
  for (const e of document.querySelectorAll('body *')) {
    if (e.closest('.scroll, .hidden, .skip') && !e.matches('.scroll')) continue;
    const box = e.getBoundingClientRect();
    if (box.width && (box.right > width + 1 || box.left < -1)) out.push(e.tagName + '.' + e.className);
  }
  return {page: document.documentElement.scrollWidth, width, out};
})()"""

FIGURES = """return [...document.querySelectorAll('figure')].map(f => {
  const svg = f.querySelector('svg'), box = svg.getBoundingClientRect(), style = getComputedStyle(svg);
  return {name: f.id, width: box.width, height: box.height, whole: f.getBoundingClientRect().height,
          marks: svg.querySelectorAll('path, use, rect, line, polyline, circle').length,
          seen: style.visibility === 'visible' && style.display !== 'none' && +style.opacity > 0};
})"""

FOCUS = """
return (() => { const e = document.activeElement, style = getComputedStyle(e), box = e.getBoundingClientRect();
  return {body: e === document.body, key: e.tagName + ' ' + (e.getAttribute('href') || e.textContent.slice(0, 30)),
          outline: parseFloat(style.outlineWidth), line: style.outlineStyle, top: box.top, bottom: box.bottom,
          tall: innerHeight}; })()"""


@pytest.fixture(scope="module")
def driver():
    yield from driven("--hide-scrollbars")


@pytest.fixture
def show(driver, results):
    """Load the report in a window of some width, as a kind of medium, in a scheme of colours."""

    def show(width, *, media="", scheme="light"):
        size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 600}
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        features = [{"name": "prefers-color-scheme", "value": scheme}]
        driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": media, "features": features})
        driver.get((results / "report.html").as_uri())
        return driver.execute_script

    return show


@pytest.mark.parametrize("width", [1280, 390])
def test_it_is_drawn_without_complaint_and_nothing_runs_off_the_screen(driver, show, width):
    ask = show(width)
    assert driver.get_log("browser") == []
    assert ask("return performance.getEntriesByType('resource').length") == 0
    found = ask(OVERFLOW)
    assert found["page"] == found["width"] == width
    assert found["out"] == []
    figures = ask(FIGURES)
    assert len(figures) > 9
    for figure in figures:
        assert figure["seen"], figure["name"]
        assert (figure["width"] >= 300, figure["height"] >= 100, figure["marks"] > 5) == (True,) * 3, figure[
            "name"
        ]


def test_on_a_telephone_what_is_wide_scrolls_and_the_first_pictures_can_be_read(show):
    ask = show(390)
    wide = ask("return [...document.querySelectorAll('main .scroll')].filter(e => e.scrollWidth > e.clientWidth)"
        ".map(e => [e.tabIndex, getComputedStyle(e).overflowX, e.getAttribute('aria-label')])")  # fmt: skip
    assert len(wide) > 5
    assert all((tab, overflow) == (0, "auto") and name for tab, overflow, name in wide)
    for stem in ("typical_recording", "law"):
        width, letters = ask(
            f"const svg = document.querySelector('#fig-{stem} svg'), b = svg.getBoundingClientRect();"
            "const sizes = [...svg.querySelectorAll('text')].map(t => t.getBoundingClientRect().height);"
            "return [b.width, Math.min(...sizes)];"
        )
        assert width <= 390
        assert letters >= 8


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_ink_stands_out_from_paper(driver, show, scheme):
    ask = show(1280, scheme=scheme)
    ask("document.querySelectorAll('details').forEach(e => { e.open = true; })")
    paper = ask("return getComputedStyle(document.body).backgroundColor")
    assert (max(map(int, re.findall(r"\d+", paper)[:3])) < 60) == (scheme == "dark")
    assert complaints(driver, 1280) == []
    box = ask("const b = document.querySelector('#fig-law svg').getBoundingClientRect();"
        "return [b.x + scrollX, b.y + scrollY, b.width, b.height];")  # fmt: skip
    clip = dict(zip(("x", "y", "width", "height"), box, strict=True), scale=1)
    how = {"format": "png", "captureBeyondViewport": True, "clip": clip}
    shot = driver.execute_cdp_cmd("Page.captureScreenshot", how)["data"]
    light = image.imread(io.BytesIO(base64.b64decode(shot)))[..., :3].mean(axis=2)
    assert (np.median(light) < 0.25) == (scheme == "dark")
    assert np.ptp(np.quantile(light, [0.001, 0.999])) > 0.5


def test_every_link_and_fold_is_reached_by_tab_and_seen(driver, show):
    ask = show(1280)
    wanted = ask("return [...document.querySelectorAll('a[href], summary')]"
        ".map(e => e.tagName + ' ' + (e.getAttribute('href') || e.textContent.slice(0, 30)))")  # fmt: skip
    most = ask("return document.querySelectorAll('a[href], summary, [tabindex=\"0\"]').length")
    reached = []
    for _ in range(most):
        driver.switch_to.active_element.send_keys(Keys.TAB)
        found = ask(FOCUS)
        if found["body"]:  # round once
            break
        assert found["outline"] >= 2, found["key"]
        assert found["line"] != "none", found["key"]
        assert found["bottom"] > 0, found["key"]
        assert found["top"] < found["tall"], found["key"]
        reached.append(found["key"])
    assert ([key for key in reached if key in wanted], wanted[0]) == (wanted, "A #result")


def test_no_figure_is_cut_on_paper(driver, show):
    ask = show(688, media="print")  # 182 mm, what the margins leave of A4
    for figure in ask(FIGURES):
        assert 60 < figure["whole"] < A4_PX, figure["name"]
    kept = ask("return [...document.querySelectorAll('figure')].map(e => getComputedStyle(e).breakInside)")
    assert {*kept} == {"avoid"}
    assert ask("return document.documentElement.scrollWidth") <= 688
    assert ask("return getComputedStyle(document.querySelector('nav')).display") == "none"
    show(688)
    printed = base64.b64decode(driver.execute_cdp_cmd("Page.printToPDF", {"preferCSSPageSize": True})["data"])
    boxes = {tuple(map(float, box.split())) for box in re.findall(rb"/MediaBox \[([^\]]+)\]", printed)}
    assert len(boxes) == 1
    *_, wide_pt, tall_pt = boxes.pop()
    assert (wide_pt, tall_pt) == (pytest.approx(595.3, abs=1), pytest.approx(841.9, abs=1))
    assert 3 < len(re.findall(rb"/Type /Page\b", printed)) < 11
