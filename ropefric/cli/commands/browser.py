"""The page in the browser: the whole job from recordings to the report, or begun at the picks of a campaign."""

import getpass
import html
import os
import sys
import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from typer import Argument, Option

from ropefric.cli import on_first_use, options
from ropefric.cli.options import Answer, command, option
from ropefric.cli.output import Output, Progress
from ropefric.errors import DataError, InputError
from ropefric.glossary import counted

with on_first_use():
    from ropefric import section
    from ropefric.page import desk as desks
    from ropefric.page import server

if TYPE_CHECKING:
    from ropefric.page.desk import Desk

_BY = "Who decides, as decisions.csv will say; by default the login name."
_PORT: Any = Option(0, min=0, max=65535, help="Of the page; 0: any that is free.")
_OPEN: Any = Option(True, "--open/--no-open", help="Open the page in the browser.")


@command("ropefric app daq", order=5)
def app(
    out: Output,
    place: Path = Argument(
        Path(), metavar="FOLDER", help="Of recordings, of a campaign, or of results; or a campaign.toml."
    ),
    *,
    by: str = option("NAME", _BY, default=""),
    port: int = _PORT,
    open_page: bool = _OPEN,
    jobs: options.Jobs = "auto",
) -> Answer:
    """Do the whole job on a page in the browser: recordings, picks, the law, wheels and machines, the report.

    It writes the very files that the commands write: campaign.toml and trials.csv beside the folder of recordings (never
    over others without asking), decisions.csv, and a folder of results. The page is served on this machine
    alone, to whoever has the address that is printed. Ctrl-C ends it.
    """
    desk = _desk(place, by, jobs)
    _serve(out, desk, port, "Ctrl-C ends the page", open_page=open_page)
    n_decisions = 0 if desk.review is None else desk.review.n_written
    data = {"campaign": desk.campaign, "out": desk.out, "n_decisions": n_decisions}
    said = f"the campaign is in {desk.campaign}" if desk.campaign else "no campaign was written"
    return Answer(data, [section.Section(title="", lines=(said,), verbatim=True)])


@command("ropefric review out", order=65)
def review(
    out: Output,
    folder: Path = Argument(
        ...,
        metavar="OUT_DIR|CAMPAIGN.toml",
        help="A folder that `run` or `extract` wrote; or a campaign.",
    ),
    *,
    campaign: Path | None = option(
        "CAMPAIGN.toml", "The campaign; by default the one that `run` made the folder from."
    ),
    by: str = option("NAME", _BY, default=""),
    port: int = _PORT,
    open_page: bool = _OPEN,
    jobs: options.Jobs = "auto",
) -> Answer:
    """Look at the picks of a campaign in the browser, and decide: accept, move, exclude, comment, undo.

    This is the second step of the page that `ropefric app` opens. Decisions go into decisions.csv beside the campaign's
    list of trials, which itself is never written; what they change
    in the condition, the law and the lift force is shown. The folder of results is brought up to date by the page's last
    step, by `ropefric report OUT_DIR`, or by `extract`.
    """
    named = options.campaign_file(campaign or folder)
    desk = _desk(folder, by, jobs, campaign=None if campaign is None else named)
    if desk.campaign is None:
        why = "the folder does not say which campaign it is of: only `run` writes that down"
        raise DataError(why, path=folder, fix="name the campaign: --campaign CAMPAIGN.toml")
    with Progress(out, "extract") as progress:
        desk.open(progress.update)
    reviewed = desk.opened
    decisions = reviewed.campaign.decisions
    _serve(out, desk, port, f"decisions go into {decisions}; Ctrl-C ends the review", open_page=open_page)
    more = f"; `ropefric report {folder}` brings the results up to date" if reviewed.n_written else ""
    data = {"trial_list": reviewed.campaign.trial_list, "decisions": decisions, "by": reviewed.by}
    data |= {"n_decisions": reviewed.n_written}
    said = f"{counted(reviewed.n_written, 'decision')} written to {decisions}{more}"
    return Answer(data, [section.Section(title="", lines=(said,), verbatim=True)])


def _desk(place: Path, by: str, jobs: str, campaign: Path | None = None) -> "Desk":
    """Return the desk at a folder or a campaign."""
    if not place.exists():
        fix = "name a folder of recordings or of results, or a campaign"
        raise DataError("there is no such folder", path=place, fix=fix)
    n_jobs = options.parse_jobs(jobs, options.SERIAL_BELOW)
    return desks.Desk(place, by=by.strip() or _login_name(), campaign=campaign, jobs=n_jobs)


def _serve(out: Output, desk: "Desk", port: int, said: str, *, open_page: bool) -> None:
    """Serve the page until Ctrl-C."""
    options.lend_fonts_a_place(desk.out)
    with server.PageServer(desk, port) as serving:
        # Not a note: without it nobody finds the page.
        sys.stderr.write(f"{serving.address}\n")
        sys.stderr.flush()
        out.note(said)
        try:
            with _door_to(serving.address) as door:
                if open_page and _has_screen():
                    webbrowser.open(door)
                serving.serve_forever()
        except KeyboardInterrupt as interrupt:
            if interrupt.args:  # not Ctrl-C: the system wants an end
                raise
        finally:
            desk.close()


@contextmanager
def _door_to(address: str) -> Iterator[str]:
    """Yield a page, which only this user can read, that leads to an address: all can read a browser's command line."""
    with TemporaryDirectory(prefix="ropefric-") as folder:
        door, shown = Path(folder, "ropefric.html"), html.escape(address)
        door.write_text(
            f'<!doctype html><meta charset="utf-8"><meta name="referrer" content="no-referrer">'
            f'<meta http-equiv="refresh" content="0; url={shown}"><a href="{shown}">ropefric</a>\n',
            encoding="utf-8",
        )
        yield door.as_uri()


def _login_name() -> str:
    try:
        return getpass.getuser()
    except (OSError, KeyError, ImportError):  # a machine that knows no names
        raise InputError("who decides?", code="RF121", key="--by", fix="give your name with --by") from None


def _has_screen() -> bool:
    """Return whether a browser could show itself; one for terminals would take this one."""
    names = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")
    return sys.platform != "linux" or any(os.environ.get(name) for name in names)
