"""The whole road in a real browser, and the commands beside it: the same files, byte for byte, the same numbers."""

import json
import threading
from pathlib import Path

import pytest
from browser import complaints, driven, shown_as
from newcomer import write_daq

from ropefric.cli.app import main
from ropefric.page.desk import Desk
from ropefric.page.server import PageServer

pytest.importorskip("selenium.webdriver")
from road import Road

pytestmark = pytest.mark.slow

PATTERN = "R{wheel_radius_mm}_{wrap_angle_deg}Grad_{end_tension_N}N_{repeat}"


@pytest.fixture(scope="module")
def chromium():
    yield from driven()


@pytest.fixture
def road(chromium, tmp_path):
    write_daq(tmp_path / "daq")
    desk = Desk(tmp_path / "daq", by="A. Meier")
    with PageServer(desk) as server:
        thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        try:
            yield Road(chromium, server.address, look)
            assert [one for one in chromium.get_log("browser") if "409" not in one["message"]] == []
        finally:
            chromium.get("about:blank")
            server.shutdown()
            thread.join()
            desk.close()


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
    for width in (1280, 390):
        for scheme in ("light", "dark"):
            with shown_as(driver, width, scheme):
                assert (step, width, scheme, complaints(driver, width)) == (step, width, scheme, [])


def files_of(folder):
    """The bytes of the files of a folder by name, but for what the folder keeps for itself."""
    paths = (path for path in folder.rglob("*") if path.is_file())
    names = {path.relative_to(folder): path for path in paths}
    return {
        name: path.read_bytes()
        for name, path in names.items()
        if not any(part[0] == "." for part in name.parts)
    }


def test_from_a_folder_to_a_report_as_the_commands_do(road, tmp_path, call, monkeypatch):
    monkeypatch.chdir(tmp_path)
    road.recordings()
    toml = (tmp_path / "campaign.toml").read_text(encoding="utf-8")
    for said in (
        'name   = "Newcomer"',
        'sensitivity = "25 N/mV"',
        'sensitivity = "40 N/mV"',
        'wheel_radius = "40 mm"',
    ):
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
    assert {
        Path("report.html"),
        Path("trials.csv"),
        Path("prediction.json"),
        Path("next_tests.csv"),
    } <= made.keys()
    assert [name for name in made if made[name] != same[name]] == []

    wheel = ("--wheel-radius", "42 mm", "--wrap", "300 deg", "--end-tension", "35 N")
    found = call("predict", "--fit", f"out/fits/{law}.json", *wheel)[1]
    assert lift["lift_force_N"] == pytest.approx(found["lift_force_N"], rel=1e-6)
    assert lift["interval_N"] == pytest.approx(found["interval_N"], rel=1e-4)
