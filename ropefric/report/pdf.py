"""A page as PDF, printed by a browser that is there: what is seen on the screen is what is on paper, formulas too."""

import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

from ropefric.errors import RopefricError

BROWSER = "ROPEFRIC_BROWSER"
"""The environment variable that names the browser, where it is not found by itself."""

_NAMES = (
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
    "msedge",
    "brave-browser",
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
_DATE = re.compile(rb"(?<=Date \(D:)\d{14}")
_UUID = re.compile(rb"(?<=uuid:)[0-9a-f-]{36}")


def find_browser() -> str:
    """Return the program of a Chromium, Chrome or Edge: the one that is named, else one that is found."""
    named = os.environ.get(BROWSER, "")
    candidates = [named] if named else [*_NAMES, *_PLACES]
    for found in map(shutil.which, candidates):
        if found is not None:
            return found
    what = (
        f"{BROWSER} names {named!r}, which is no program"
        if named
        else "no Chromium, Chrome or Edge was found"
    )
    raise RopefricError(
        f"a PDF is printed by a browser, and {what}",
        code="RF154",
        fix=f"install one (apt-get install chromium), or name its program in {BROWSER}; or open report.html in any "
        "browser and print it",
    )


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
    raise RopefricError(
        f"the browser {browser} printed no PDF: {said or 'it said nothing'}",
        code="RF154",
        fix=f"name another one in {BROWSER}, or open report.html in any browser and print it",
    )
