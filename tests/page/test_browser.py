"""The page in a real browser: what a person does with keys and mouse stands in the list, and nowhere else."""

import csv
import io
import shutil
from dataclasses import fields, replace
from itertools import product
from pathlib import Path

import pytest
from browser import complaints, shown_as

from ropefric.cli.app import main
from ropefric.page import review as session
from ropefric.page.desk import Desk
from ropefric.trials.campaign_model import TrialRow

webdriver = pytest.importorskip("selenium.webdriver")
from selenium.webdriver.common.by import By  # noqa: E402
from selenium.webdriver.common.keys import Keys  # noqa: E402
from selenium.webdriver.support.ui import Select, WebDriverWait  # noqa: E402

pytestmark = pytest.mark.slow
BENCH = Path(__file__).parents[2] / "data" / "prth-bench"


@pytest.fixture
def page(chromium, begin, campaign, serve):
    """The page of a new review, as a function that opens it."""

    def page(*, fits=False):
        page.review = begin(fits=fits)
        desk = Desk(campaign / "campaign.toml", by="A. Meier")
        desk.review = page.review
        chromium.get(serve(desk))
        wait(chromium, lambda: inside(chromium, "return S.curve !== null && S.info !== null"))
        return chromium

    return page


def inside(driver, script):
    """Run a script that knows the names of the step of picks."""
    modules = "Promise.all([import('/static/picks.js'), import('/static/canvas.js')])"
    names = "[{S, take, scales, show}, {EDGE}]"
    return driver.execute_script(f"return {modules}.then(({names}) => {{ {script} }})")


def wait(driver, done):
    WebDriverWait(driver, 60, poll_frequency=0.02).until(lambda _: done())


def text(driver, name):
    return driver.find_element(By.ID, name).text


def rows_of(driver):
    return driver.find_elements(By.CSS_SELECTOR, ".row")


def press(driver, *keys):
    driver.switch_to.active_element.send_keys(*keys)


def written(path):
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    return {row["trial"]: row for row in csv.DictReader(io.StringIO("\n".join(lines)))}


def test_a_person_decides_and_the_list_and_the_next_extraction_follow(page, campaign):
    path, lists = campaign / "decisions.csv", (campaign / "trials.csv").read_bytes()
    driver = page(fits=True)

    def until(name, words):
        wait(driver, lambda: words in text(driver, name))

    def computed():
        wait(driver, lambda: not text(driver, "computing").startswith("computing"))

    computed()
    # Doubtful ones come first, and the first is shown; its candidate is chosen, seen, accepted.
    first, second = (row.get_attribute("data-trial") for row in rows_of(driver)[:2])
    assert (first, second) == ("c28-r03", "c35-r02")
    assert (text(driver, "trial"), text(driver, "status")) == ("c28-r03", "doubtful: to decide")
    press(driver, "1")
    until("said", "it would be F_A = 79.1")
    press(driver, "a")
    until("status", "counts")
    assert "1 to decide" in text(driver, "counts")
    computed()
    change = {cells[0].text: [cell.text for cell in cells[1:]] for cells in (
        row.find_elements(By.TAG_NAME, "td") for row in driver.find_elements(By.CSS_SELECTOR, "#change tbody tr")
    )}  # fmt: skip
    assert change["F_A of c28-r03"][0] == "–"
    assert change["F_A of c28-r03"][1].startswith("79.1")
    assert change["counting"] == ["3 of 4", "4 of 4"]
    was, now = inside(driver, "return [S.answer.before.lift.lift_force_N, S.answer.now.lift.lift_force_N]")
    assert was != now
    for name in ("Its condition: mean", "s", "Lift force, 95 % interval"):
        was, now = change[name]
        assert was != now or name.startswith("Lift")  # which may change by less than is shown
        assert was[0].isdigit()
        assert now[0].isdigit()

    # The pick of the next is moved by the mouse, then by keys, and accepted there.
    press(driver, "j")
    wait(driver, lambda: text(driver, "trial") == second and inside(driver, "return S.curve !== null"))
    driver.execute_script("document.getElementById('plot').scrollIntoView({block: 'center'})")
    plot = driver.find_element(By.ID, "plot")
    x = inside(driver, "return scales().x(S.info.candidates[0].time_s)") - plot.size["width"] / 2
    webdriver.ActionChains(driver).move_to_element_with_offset(plot, int(x) + 1, 0).click().perform()
    until("said", "it would be")
    clicked = inside(driver, "return S.draft")
    press(driver, Keys.ARROW_LEFT, Keys.ARROW_LEFT)
    moved, candidate = inside(driver, "return [S.draft, S.info.candidates[0].time_s]")
    assert moved < clicked
    assert moved == pytest.approx(candidate, abs=0.05)
    wait(driver, lambda: inside(driver, "return S.preview !== null"))
    press(driver, "a")
    until("status", "counts")

    # Another one is excluded with its reason; a comment on it is undone.
    Select(driver.find_element(By.ID, "by-condition")).select_by_index(1)
    driver.find_element(By.ID, "by-text").send_keys("r02")
    assert text(driver, "n-shown") == "1 of 12 shown"
    rows_of(driver)[0].click()
    until("trial", "c11-r02")
    wait(driver, lambda: inside(driver, "return S.info.trial") == "c11-r02")
    driver.find_element(By.ID, "list").send_keys("x")
    press(driver, "torn, by hand", Keys.ENTER)
    until("status", "excluded")
    driver.find_element(By.ID, "do-comment").click()
    press(driver, "loud", Keys.ENTER)
    until("detail", "loud")
    assert written(path)["c11-r02"]["why"] == "loud"
    driver.find_element(By.ID, "list").send_keys("u")
    wait(driver, lambda: "undone" in text(driver, "said") and "loud" not in text(driver, "detail"))

    after = written(path)
    assert (campaign / "trials.csv").read_bytes() == lists
    decided = ("pick_s", "exclude", "why", "by", "when")
    assert [after["c28-r03"][name] for name in ("pick_s", "exclude", "by")] == ["2.19833", "", "A. Meier"]
    assert after["c28-r03"]["why"].startswith("review: candidate 1 of ")
    assert float(after["c35-r02"]["pick_s"]) == pytest.approx(moved, abs=1e-4)
    assert after["c35-r02"]["why"] == "review: set by hand"
    assert [after["c11-r02"][name] for name in decided[1:4]] == ["torn, by hand", "", "A. Meier"]
    assert set(after) == {"c28-r03", "c35-r02", "c11-r02"}

    out = campaign / "fresh"
    words = ["extract", str(campaign / "campaign.toml"), "--out", str(out), "--no-figures", "--quiet"]
    assert main(words) == 0
    found = written(out / "trials.csv")
    shown = inside(driver, "return [...S.rows].map(([name, row]) => [name, row.outcome, row.force_N])")
    for name, outcome, force_N in shown:
        assert (found[name]["kept"] == "true") == (outcome == "kept")
        assert (float(found[name]["peak_N"] or 0)) == pytest.approx(force_N or 0, rel=1e-7)
    assert found["c11-r02"]["excluded"] == "torn, by hand"


@pytest.fixture
def many(campaign, monkeypatch):
    """Five thousand rows in place of those of the list, of 400 conditions; their recordings are read as one."""
    path, toml, extract = campaign / "trials.csv", campaign / "campaign.toml", session.extract_rows
    head, *rows = [row for row in path.read_text().splitlines() if not row.startswith("#")]
    assert head.startswith("trial,file,wheel,wrap_angle_deg,")
    _, recording, wheel, _, *cells = next(row for row in rows if row.startswith("c35-r01")).split(",")
    toml.write_text(toml.read_text().replace(f'data = "{BENCH.as_posix()}"', 'data = "."'))
    shutil.copy(BENCH / recording, campaign / "one.csv.gz")
    lines = []
    for i in range(5000):
        (campaign / f"f{i}.csv.gz").hardlink_to(campaign / "one.csv.gz")
        lines.append(",".join([f"t{i:04d}", f"f{i}.csv.gz", wheel, f"{90 + 2 * (i % 400)}", *cells]))
    path.write_text("\n".join([head, *lines, ""]))
    of_row = [field.name for field in fields(TrialRow)]

    def extract_rows(campaign, **options):
        if len(campaign.trials) < 100:
            return extract(campaign, **options)
        ((one,),) = extract(
            campaign.model_copy(update={"trials": campaign.trials[:1]}), trusted=True
        ).values()
        return {
            row.trial: (replace(one, **{name: getattr(row, name) for name in of_row}),)
            for row in campaign.trials
        }

    monkeypatch.setattr(session, "extract_rows", extract_rows)


def test_of_five_thousand_recordings_only_what_is_seen_is_drawn_and_sent(many, page, monkeypatch):
    loads, load = [], session.load_campaign
    monkeypatch.setattr(
        session, "load_campaign", lambda *given, **how: loads.append(1) or load(*given, **how)
    )
    driver = page()

    def sent(name):
        """The bytes of every answer of an address since the last question."""
        return driver.execute_script(
            """const found = performance.getEntriesByType('resource').filter((one) => one.name.includes(arguments[0]));
            performance.clearResourceTimings(); return found.map((one) => one.encodedBodySize)""",
            f"/api/{name}",
        )

    assert text(driver, "n-shown") == "5000 of 5000 shown"
    (whole,) = sent("overview")
    assert whole < 5000 * 320
    assert len(rows_of(driver)) < 40
    # Scrolling asks for nothing, and a recording for no more than its picture holds.
    driver.execute_script("document.getElementById('list').scrollTop = 2500 * 46")
    wait(driver, lambda: rows_of(driver)[8].get_attribute("data-trial") > "t2000")
    assert len(rows_of(driver)) < 40
    assert sent("") == []
    rows_of(driver)[8].click()
    wait(driver, lambda: text(driver, "trial") > "t2000" and inside(driver, "return S.curve !== null"))
    assert sum(sent("")) < 120_000
    # A decision sends what it changes, and reads the campaign once.
    loads.clear()
    press(driver, Keys.ARROW_RIGHT)
    wait(driver, lambda: inside(driver, "return S.preview !== null"))
    sent("")
    press(driver, "a")
    wait(driver, lambda: "accepted" in text(driver, "said") and inside(driver, "return S.curve !== null"))
    assert sum(sent("decide")) < 10_000
    assert len(loads) == 1
    assert driver.execute_script("return document.getElementsByTagName('*').length") < 1200


def test_a_decision_of_another_window_is_seen_with_the_next_of_this_one(page):
    driver = page()
    page.review.decide("c11-r02", "exclude", text="by the other window")
    assert inside(driver, "return S.rows.get('c11-r02').excluded") == ""
    press(driver, "1")
    wait(driver, lambda: inside(driver, "return S.preview !== null"))
    press(driver, "a")
    wait(driver, lambda: "accepted" in text(driver, "said"))
    assert inside(driver, "return S.rows.get('c11-r02').excluded") == "by the other window"
    assert text(driver, "counts").startswith("12 trials: 1 to decide")


def test_where_the_break_away_may_be_is_drawn_and_said(page, undecided):
    driver = page()
    said = "Where the break-away may be: 2.1 to 2.2 s (0.61), 1.5 s (0.30); no break-away (0.09)."
    wait(driver, lambda: text(driver, "places") == said)
    assert driver.find_element(By.ID, "plot").get_attribute("aria-describedby") == "places"
    heights, widths, frame = inside(driver, STRIP)
    assert heights == pytest.approx([0.61 * 30, 0.30 * 30], abs=1)
    assert widths[0] == pytest.approx(0.1 * frame, abs=2)
    assert widths[1] >= 2
    # Zoomed to where it is not there is no bar; the words stay.
    inside(driver, "show(0, 0.5)")
    wait(driver, lambda: inside(driver, "return S.curve.stop_s") < 0.6)
    assert inside(driver, STRIP)[0] == [0, 0]
    assert text(driver, "places") == said


def test_the_least_sure_come_first_where_that_is_asked(page):
    driver = page()
    inside(
        driver,
        """
      const row = (status, outcome, probability) => ({file: "f.csv", condition: "R 7 mm", status, outcome, force_N: 1,
        std_N: 1, excluded: "", decision: "", why: "", by: "", probability});
      const none = "without a force", order = [..."abcdef"];
      const rows = {a: row("ok", "kept", 0.99), b: row("ok", "excluded", 0.8), c: row("no-peak", none, 0.85),
        d: row("doubtful", none, 0.7), e: row("ok", "kept", null), f: row("doubtful", none, 0.4)};
      const counts = {n_trials: 6, n_kept: 2, n_rejected: 0, n_excluded: 1, n_without_force: 3, status: {ok: 3}};
      take({campaign: "some", list: "trials.csv", by: "me", slack: false, order, undo: 0, counts, rows});
    """,
    )
    shown = "return S.shown.join('')"
    assert inside(driver, shown) == "dfcaeb"
    Select(driver.find_element(By.ID, "by-order")).select_by_value("sure")
    assert inside(driver, shown) == "fdcaeb"
    assert [row.text.splitlines()[-1] for row in rows_of(driver)][:3] == ["P 0.40", "P 0.70", "P 0.85"]
    Select(driver.find_element(By.ID, "by-order")).select_by_value("list")
    assert inside(driver, shown) == "dfcaeb"
    Select(driver.find_element(By.ID, "by-status")).select_by_value("ask")
    assert (inside(driver, shown), text(driver, "n-shown")) == ("df", "2 of 6 shown")


def test_a_list_changed_by_somebody_else_is_told_and_read_again(page, campaign):
    path, driver = campaign / "trials.csv", page()
    path.write_bytes(path.read_bytes().replace(b"# taken in spring", b"# taken in autumn"))
    press(driver, "a")  # shows the force: nothing is written before
    wait(driver, lambda: "it would be" in text(driver, "said"))
    assert not driver.find_element(By.ID, "error").is_displayed()
    press(driver, "a")
    wait(driver, lambda: driver.find_element(By.ID, "error").is_displayed())
    assert "RF153: somebody else has changed" in text(driver, "why")
    assert not (campaign / "decisions.csv").exists()
    driver.find_element(By.ID, "do-reload").click()
    wait(driver, lambda: "read again" in text(driver, "said"))
    press(driver, "a")
    wait(driver, lambda: "it would be" in text(driver, "said"))
    press(driver, "a")
    wait(driver, lambda: text(driver, "status") == "counts")
    assert path.read_bytes().count(b"# taken in autumn") == 1
    assert "2.19833" in (campaign / "decisions.csv").read_text()


def test_nothing_is_cut_off_and_everything_can_be_read(page):
    driver = page()
    for width, scheme in product((1280, 390), ("light", "dark")):
        with shown_as(driver, width, scheme):
            assert complaints(driver, width) == []
            # By keys alone: to the list, down, and the trial changes.
            driver.execute_script("document.getElementById('list').focus()")
            was = text(driver, "trial")
            press(driver, Keys.ARROW_DOWN)
            wait(driver, lambda was=was: text(driver, "trial") != was)


# Height of the bar in the middle of each place, its width at the foot, and pixels of a second.
STRIP = """
  const plot = document.getElementById('plot'), ratio = devicePixelRatio || 1, s = scales();
  const pen = new OffscreenCanvas(plot.width, plot.height).getContext('2d', {willReadFrequently: true});
  pen.drawImage(plot, 0, 0);
  const image = pen.getImageData(0, 0, plot.width, plot.height), foot = EDGE.top + s.height + s.strip;
  const wanted = getComputedStyle(document.documentElement).getPropertyValue('--candidate').trim();
  const is = (x, y) => { const at = 4 * (Math.round(y * ratio) * image.width + Math.round(x * ratio));
    const far = [0, 1, 2].map((i) => Math.abs(parseInt(wanted.slice(1 + 2 * i, 3 + 2 * i), 16) - image.data[at + i]));
    return Math.max(...far) < 40; };
  const highest = [...Array(40).keys()], inside = (x) => x > EDGE.left && x < EDGE.left + s.width;
  const bars = S.curve.places.map(([a, b]) => {
    const middle = s.x((a + b) / 2), near = s.x(b) - s.x(a) + 4;
    const across = [...Array(Math.ceil(2 * near)).keys()].map((i) => middle - near + i).filter(inside);
    return [highest.filter((up) => inside(middle) && is(middle - 0.5, foot - 2 - up)).length,
      across.filter((x) => is(x, foot - 3)).length];
  });
  return [bars.map((bar) => bar[0]), bars.map((bar) => bar[1]), s.width / (S.view[1] - S.view[0])];
"""
