"""Step 1 in a real browser: a campaign is changed, files are dropped, thousands of recordings are listed."""

from itertools import product

import pytest
from browser import complaints, shown_as
from newcomer import PATTERN, write_daq

from ropefric.cli.app import main
from ropefric.page.desk import Desk

pytest.importorskip("selenium.webdriver")
from road import Road
from selenium.webdriver.common.keys import Keys

pytestmark = pytest.mark.slow


@pytest.fixture
def opened(chromium, serve):
    """A function that opens the first step of the page at a place."""
    return lambda place: Road(chromium, f"{serve(Desk(place, by='A. Meier'))}#recordings")


@pytest.fixture
def daq(tmp_path):
    """Four recordings of a newcomer."""
    write_daq(tmp_path / "daq")
    for path in sorted((tmp_path / "daq").iterdir())[4:]:
        path.unlink()
    return tmp_path / "daq"


def test_a_campaign_is_changed_after_its_changes_were_shown(opened, daq):
    home = daq.parent
    assert main(["init", str(home), "--from", str(daq), "--pattern", PATTERN, "--quiet"]) == 0
    path, lists = home / "campaign.toml", (home / "trials.csv").read_bytes()
    before = path.read_text(encoding="utf-8").replace("[rope]", "[rope]  # the blue one")
    path.write_text(before, encoding="utf-8")
    road = opened(home)
    driver = road.driver
    road.wait(lambda: road.one("r-there").is_displayed() and road.one("r-force-sensitivity").is_displayed())
    road.settled()
    driver.execute_script("document.getElementById('do-hide').click()")  # the campaign is not complete yet
    assert road.one("r-rope").get_property("value") == "9.8 mm"
    assert not road.one("r-folder").is_displayed()
    assert not road.can("r-write")
    fields = {"r-rope": "11 mm", "r-force-sensitivity": "25 N/mV", "r-end_tension-sensitivity": "40 N/mV"}
    road.write(fields | {"r-wheel-R30": "30 mm"})
    for answer in ("no", "yes"):
        road.wait(lambda: road.can("r-write"))
        driver.execute_script("arguments[0].click()", road.one("r-write"))
        road.wait(lambda: road.one("replace").is_displayed())
        said = road.text("replace-lines")
        assert '-diameter = "9.8 mm"' in said
        assert '+diameter = "11 mm"' in said
        assert path.read_text(encoding="utf-8") == before
        for width, scheme in product((1280, 390), ("light", "dark")):
            with shown_as(driver, width, scheme):
                assert complaints(driver, width) == []
        road.one(f"replace-{answer}").click()
    road.wait(lambda: driver.execute_script("return document.body.dataset.step") == "picks")
    after = path.read_text(encoding="utf-8")
    assert ("[rope]  # the blue one" in after, (home / "trials.csv").read_bytes()) == (True, lists)
    assert after.count("\n") == before.count("\n") + 3  # the wheel has a table
    # Back in the first step the fields show what is written now.
    road.go("recordings")
    road.wait(lambda: road.one("r-rope").get_property("value") == "11 mm")
    road.settled()
    assert (road.text("r-where"), road.text("error")) == ("No setting is changed.", "")
    # A new campaign beside it begins with empty fields.
    road.one("r-anew").click()
    road.wait(lambda: road.one("r-folder").is_displayed())
    assert road.one("r-rope").get_property("value") == ""


def test_a_campaign_that_is_edited_meanwhile_is_read_again_before_anything_is_written(opened, daq):
    home = daq.parent
    assert main(["init", str(home), "--from", str(daq), "--pattern", PATTERN, "--quiet"]) == 0
    road, path = opened(home), home / "campaign.toml"
    road.wait(lambda: road.one("r-force-sensitivity").is_displayed())
    road.settled()
    road.driver.execute_script(
        "document.getElementById('do-hide').click()"
    )  # the campaign is not complete yet
    text = path.read_text(encoding="utf-8").replace('"9.8 mm"', '"12 mm"')
    path.write_text(text, encoding="utf-8")
    road.one("r-name").send_keys(" of mine", Keys.TAB)
    road.wait(lambda: "RF153: somebody else has changed" in road.text("why"))
    assert path.read_text(encoding="utf-8") == text
    road.one("do-reload").click()
    road.wait(lambda: road.one("r-rope").get_property("value") == "12 mm")
    road.settled()
    assert not road.one("error").is_displayed()
    assert (road.text("r-where"), path.read_text(encoding="utf-8")) == ("No setting is changed.", text)


def test_files_that_are_dropped_with_the_mouse_are_listed(opened, daq, tmp_path):
    (tmp_path / "lab").mkdir()
    road = opened(tmp_path / "lab")
    area = road.one("r-drop")
    road.wait(area.is_displayed)
    road.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", area)
    place = road.driver.execute_script(
        "const at = arguments[0].getBoundingClientRect(); return {x: at.x + 40, y: at.y + 10}", area
    )
    paths = [str(path) for path in sorted(daq.iterdir())]
    for kind in ("dragEnter", "dragOver", "drop"):
        data = {"items": [], "files": paths, "dragOperationsMask": 1}
        road.driver.execute_cdp_cmd("Input.dispatchDragEvent", {"type": kind, "data": data, **place})
    road.wait(lambda: road.one("r-more").is_displayed())
    dropped = tmp_path / "lab" / "recordings"
    assert road.text("r-dropped") == f"{len(paths)} files are in {dropped}"
    assert {one.name: one.read_bytes() for one in dropped.iterdir()} == {
        path.name: path.read_bytes() for path in daq.iterdir()
    }
    assert len(road.driver.find_elements("css selector", "#r-rows tbody tr")) == len(paths)


def answered(road, **answers):
    """Let the page get these answers, whatever its server would say."""
    road.driver.execute_script(
        """
      const [answers, ask] = [arguments[0], window.fetch];
      window.fetch = (url, how) => { const name = /api\\/([\\w-]+)/.exec(url)[1];
        return name in answers ? Promise.resolve(new Response(JSON.stringify(answers[name]))) : ask(url, how); };
    """,
        answers,
    )


def test_five_thousand_recordings_are_listed_in_part_and_each_can_be_chosen(opened, tmp_path):
    (tmp_path / "lab").mkdir()
    road = opened(tmp_path / "lab")
    road.wait(lambda: road.one("r-look").is_displayed())
    problem = {
        "severity": "error",
        "code": "RF121",
        "key": "",
        "message": "no force",
        "fix": "",
        "times": 5000,
    }
    told = {"found": None, "channels": {}, "said": ["not read"], "problems": [problem], "shown": ""}
    told["header"] = ["file", "wheel", "wrap_angle_deg", "end_tension_N"]
    told["rows"] = [[f"daq/f{i}.csv", f"W{i % 4}", str(90 * (1 + i % 5)), "20"] for i in range(5000)]
    done = {"name": "looking", "running": False, "result": told | {"there": [], "difference": ""}}
    answered(road, propose={"work": done})
    road.one("r-look").click()
    road.wait(lambda: road.text("r-told") == "5000 trials, the first 200 are shown")
    assert road.text("r-problems") == "error: no force (5000 times)"
    assert road.driver.execute_script("return document.getElementById('r-which').options.length") == 5000
    assert len(road.driver.find_elements("css selector", "#r-wheels input")) == 4
    drawn = road.driver.execute_script("return document.querySelectorAll('#step-recordings *').length")
    assert drawn < 5000 + 200 * 6 + 300  # a choice for each recording, a row for two hundred


def test_a_law_of_five_thousand_trials_has_a_row_for_each_condition(opened, tmp_path):
    (tmp_path / "lab").mkdir()
    road = opened(tmp_path / "lab")
    road.wait(lambda: road.one("r-look").is_displayed())
    counts = {"off": "", "n": 12, "n_kept": 12, "mean_N": 50.0, "std_N": 1.0}
    conditions = [{"words": f"R {i} mm", "trial": f"t{i}"} | counts for i in range(420)]
    curve = {"line": [[90, 20], [180, 40]], "band": [[90, 19, 21], [180, 38, 42]]}
    curve |= {"points": [[90, 20, 19, 21]], "residuals": [[90, 1, 0, 2]]}
    law = {"law": "constant", "asked": "", "how": "", "equation": "mu", "verdict": {"word": "", "reason": ""}}
    law |= {"fit": {"parameters": {}}, "ranking": [], "verdicts": {}, "doubts": [], "prediction": None}
    law |= {"computing": "", "diagnosis": {"summary": "", "causes": []}, "conditions": conditions}
    law["series"] = [{"name": f"R {i} mm"} | curve for i in range(40)]
    answered(road, law=law)
    road.driver.execute_script("""
      for (const link of document.querySelectorAll('nav a')) link.setAttribute('aria-disabled', 'false');
      return import('/static/frame.js').then((page) => page.go('law'));
    """)
    road.wait(lambda: len(road.driver.find_elements("css selector", "#l-conditions tbody tr")) == 420)
    assert (
        road.driver.execute_script("return document.querySelectorAll('#step-law *').length") < 420 * 8 + 400
    )
