"""The whole road in a real browser, and the commands beside it: the same files, byte for byte, the same numbers."""

import json
from itertools import product
from pathlib import Path

import pytest
from browser import complaints, shown_as, unnamed
from newcomer import write_daq

from ropefric.cli.app import main
from ropefric.page.desk import Desk

pytest.importorskip("selenium.webdriver")
from road import DESIGN, FIELDS, Road
from selenium.webdriver import ActionChains
from selenium.webdriver.common.keys import Keys

pytestmark = pytest.mark.slow

PATTERN = "R{wheel_radius_mm}_{wrap_angle_deg}Grad_{end_tension_N}N_{repeat}"


@pytest.fixture
def road(chromium, serve, tmp_path):
    write_daq(tmp_path / "daq")
    return Road(chromium, serve(Desk(tmp_path / "daq", by="A. Meier")), look)


@pytest.fixture
def call(capfd):
    """Run a command, and return its exit code and what it says as JSON."""

    def call(*argv):
        capfd.readouterr()
        code = main([*map(str, argv), "--json"])
        return code, json.loads(capfd.readouterr().out)

    return call


def look(driver, step):
    """A step can be read and used in the light and in the dark, on a wide screen and on a narrow one."""
    for width, scheme in product((1280, 390), ("light", "dark")):
        with shown_as(driver, width, scheme):
            assert (step, width, scheme, complaints(driver, width)) == (step, width, scheme, [])


def files_of(folder):
    """The bytes of the files of a folder by name, but for what the folder keeps for itself."""
    paths = (path for path in folder.rglob("*") if path.is_file())
    names = {path.relative_to(folder): path for path in paths}
    seen = {name: path for name, path in names.items() if not any(part[0] == "." for part in name.parts)}
    return {name: path.read_bytes() for name, path in seen.items()}


def test_from_a_folder_to_a_report_as_the_commands_do(road, tmp_path, call, monkeypatch):
    monkeypatch.chdir(tmp_path)
    road.recordings()
    toml = (tmp_path / "campaign.toml").read_text(encoding="utf-8")
    for said in ('name   = "Newcomer"', 'sensitivity = "25 N/mV"', 'sensitivity = "40 N/mV"',
        'wheel_radius = "40 mm"'):  # fmt: skip
        assert said in toml
    assert call("init", "mine", "--from", "daq", "--pattern", PATTERN)[0] == 0
    listed = Path("mine/trials.csv").read_bytes().replace(b"../daq/", b"daq/")
    assert Path("trials.csv").read_bytes() == listed
    assert call("check", "campaign.toml")[0] == 0

    road.picks()
    assert len(Path("decisions.csv").read_text(encoding="utf-8").splitlines()) == 2
    road.law()
    law, verdict = road.text("l-law"), road.text("l-verdict")
    lift = road.wheel()
    assert "Newcomer" in road.report()

    told = call("report", tmp_path / "campaign.toml", "--out", "again")[1]
    assert (law, verdict) == (told["law"], told["verdict"]["word"])
    made, same = (files_of(Path(folder)) for folder in ("out", "again"))
    assert made.keys() == same.keys()
    wanted = ("report.html", "trials.csv", "prediction.json", "next_tests.csv")
    assert {*map(Path, wanted)} <= made.keys()
    assert [name for name in made if made[name] != same[name]] == []

    wheel = ("--wheel-radius", "42 mm", "--wrap", "300 deg", "--end-tension", "35 N")
    found = call("predict", "--fit", f"out/fits/{law}.json", *wheel)[1]
    assert lift["lift_force_N"] == pytest.approx(found["lift_force_N"], rel=1e-6)
    assert lift["interval_N"] == pytest.approx(found["interval_N"], rel=1e-4)


@pytest.mark.release
def test_the_road_by_keys_alone_and_the_focus_is_never_lost(road, tmp_path):
    driver, keys = road.driver, Keys

    def on():
        return driver.execute_script("return document.activeElement.id || document.activeElement.tagName")

    def press(*given, held=None):
        chain = ActionChains(driver)
        chain = (
            chain.send_keys(*given) if held is None else chain.key_down(held).send_keys(*given).key_up(held)
        )
        chain.perform()
        assert on() != "BODY", given

    def tab_to(name):
        for _ in range(150):
            if on() == name:
                return
            press(keys.TAB)
        raise AssertionError(f"no way to {name} by keys")

    road.wait(lambda: road.one("r-more").is_displayed())
    road.settled()
    road.one("r-folder").click()
    # In the order of the page: behind its last control a browser leaves it.
    fields = {"r-pattern": PATTERN, "r-from": "0 s", "r-until": "0.3 s"} | FIELDS | DESIGN
    placed = driver.execute_script("return [...document.querySelectorAll('input')].map((one) => one.id)")
    for name, words in sorted(fields.items(), key=lambda item: placed.index(item[0])):
        tab_to(name)
        press("a", held=keys.CONTROL)
        press(words, keys.TAB)
        road.settled()
        assert on() != "BODY", name
    tab_to("r-write")
    press(keys.ENTER)
    road.wait(lambda: driver.execute_script("return document.body.dataset.step") == "picks")
    road.wait(lambda: on() == "list")
    road.picks()
    tab_to("do-clear")
    press(keys.ENTER)
    road.wait(lambda: "left to the picker again" in road.text("said"))
    assert (on(), road.can("do-clear")) == ("do-clear", False)
    press(keys.ENTER)  # it can do nothing now, and says so
    press("3", held=keys.ALT)
    road.wait(lambda: road.one("l-all").is_displayed() and road.text("l-law"))

    def label():
        return driver.execute_script("return document.activeElement.textContent")

    tab_to("l-series")
    press(keys.TAB)
    while label() != "constant-offset":
        press(keys.TAB)
    press(keys.ENTER)
    road.wait(lambda: road.text("l-law") == "constant-offset")
    assert label() == "constant-offset"
    while not label().startswith("Switch off"):
        press(keys.TAB)
    press(keys.ENTER)
    press("wet rope", keys.ENTER)
    road.wait(lambda: label() == "Switch on")
    press(keys.ENTER)
    road.wait(lambda: label().startswith("Switch off"))
    press("5", held=keys.ALT)
    tab_to("p-make")
    press(keys.ENTER)
    road.wait(lambda: road.one("p-frame").is_displayed())
    assert on() == "p-make"
    assert (tmp_path / "out" / "report.html").exists()
    # What finds controls without a name does find one.
    driver.execute_script("document.getElementById('p-make').textContent = ''")
    assert len(unnamed(driver)) == 1
