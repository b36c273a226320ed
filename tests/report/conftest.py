"""A small simulated campaign with its report, and a real browser spoken to through a pipe."""

import itertools
import json
import os
import select
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from ropefric.cli.app import main
from ropefric.pipeline import gather_evidence, run_campaign
from ropefric.report import campaign as pages
from ropefric.report.campaign import write_report
from ropefric.report.page import Wish
from ropefric.trials.campaign import load_campaign

# fmt: off
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--hide-scrollbars",
    "--disable-sync", "--disable-background-networking", "--disable-component-update", "--disable-extensions",
    "--disable-dev-shm-usage", "--remote-debugging-pipe", "--force-color-profile=srgb",
)
# fmt: on
MOVE = """
import fcntl, os, sys
ends = [fcntl.fcntl(int(end), fcntl.F_DUPFD, 100) for end in sys.argv[1:3]]
for place, end in zip((3, 4), ends):
    os.dup2(end, place)
    os.close(end)
os.execv(sys.argv[3], [*sys.argv[3:], "about:blank"])
"""
PATIENCE_S = 60.0


class Browser:
    """A headless Chromium and one page of it, driven by the DevTools protocol over file descriptors 3 and 4."""

    def __init__(self, program, profile):
        to_it, self._out = os.pipe()
        self._in, from_it = os.pipe()
        words = [
            sys.executable,
            "-c",
            MOVE,
            str(to_it),
            str(from_it),
            program,
            *FLAGS,
            f"--user-data-dir={profile}",
        ]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self._process = subprocess.Popen(words, pass_fds=(to_it, from_it), **quiet)
        os.close(to_it)
        os.close(from_it)
        self._numbers = itertools.count(1)
        self._buffer = b""
        self._session = None
        self.events = []
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def call(self, method, **params):
        number = next(self._numbers)
        message = {"id": number, "method": method, "params": params}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._out, json.dumps(message).encode() + b"\0")
        while True:
            found = self._read()
            if found.get("id") == number:
                assert "error" not in found, f"{method}: {found['error']}"
                return found["result"]
            self.events.append(found)

    def _read(self):
        stop = time.monotonic() + PATIENCE_S
        while b"\0" not in self._buffer:
            ready = select.select([self._in], [], [], max(0.0, stop - time.monotonic()))[0]
            part = os.read(self._in, 1 << 20) if ready else b""
            if not part:
                raise RuntimeError("the browser does not answer")
            self._buffer += part
        text, self._buffer = self._buffer.split(b"\0", 1)
        return json.loads(text)

    def show(self, path, width, height=900):
        """Load a file in a window of this size and wait until it is there."""
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600}
        self.call("Emulation.setDeviceMetricsOverride", **size)
        self.events.clear()
        self.call("Page.navigate", url=Path(path).as_uri())
        while not any(event.get("method") == "Page.loadEventFired" for event in self.events):
            self.events.append(self._read())

    def ask(self, expression):
        """Return the value of a JavaScript expression on the page."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def press(self, key):
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=9)

    def close(self):
        os.close(self._out)
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        os.close(self._in)


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    """A browser; tests that need one skip where there is none."""
    program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if program is None:
        pytest.skip("no Chromium on this machine: apt-get install chromium")
    try:
        found = Browser(program, tmp_path_factory.mktemp("profile"))
    except (OSError, RuntimeError) as error:
        pytest.skip(f"Chromium does not start here: {error}")
    yield found
    found.close()


@pytest.fixture(scope="session")
def campaign(tmp_path_factory):
    """Fifty-four recordings of nine conditions, some of them spoilt, with a wheel to design; do not write to it."""
    folder = tmp_path_factory.mktemp("report") / "campaign"
    assert main(["simulate", str(folder), "--conditions", "9", "--repeats", "6", "--quiet"]) == 0
    return folder


@pytest.fixture(scope="session")
def results(tmp_path_factory):
    """The folder of its results; do not write to it."""
    return tmp_path_factory.mktemp("results") / "out"


@pytest.fixture(scope="session")
def run(campaign, results):
    """The result of the campaign, with its report written."""
    found = run_campaign(load_campaign(campaign / "campaign.toml"), results, cache_dir=results / ".cache")
    write_report(found, results)
    return found


@pytest.fixture(scope="session")
def page(run, results):
    """The text of the report."""
    return (results / "report.html").read_text(encoding="utf-8")


@pytest.fixture(scope="session")
def evidence(run):
    """What stands behind the answer, gathered once."""
    return gather_evidence(run)


@pytest.fixture
def without_figures(evidence, tmp_path, monkeypatch):
    """Return the text of the report of a changed result, with the evidence of the unchanged one."""
    monkeypatch.setattr(pages.pipeline, "gather_evidence", lambda _: evidence)

    def without_figures(run):
        write_report(run, tmp_path, Wish(figures=False))
        return (tmp_path / "report.html").read_text(encoding="utf-8")

    return without_figures
