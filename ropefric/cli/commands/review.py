"""A person's look at the picks of a campaign, in the browser."""

import getpass
import os
import sys
import webbrowser
from pathlib import Path

from typer import Argument, Option

from ropefric.cli import on_first_use, options
from ropefric.cli.options import Answer, command
from ropefric.cli.output import Output, Progress
from ropefric.errors import DataError, InputError
from ropefric.glossary import counted

with on_first_use():
    from ropefric.files import folder as folders
    from ropefric.pipeline import evidence
    from ropefric.report import section
    from ropefric.review import server, session
    from ropefric.trials import campaign as campaigns


@command("ropefric review out", order=65)
def review(
    out: Output,
    folder: Path = Argument(..., metavar="OUT_DIR", help="A folder that `run` or `extract` wrote."),
    *,
    campaign: Path | None = Option(
        None,
        metavar="CAMPAIGN.toml",
        help="The campaign; by default the one that `run` made the folder from.",
    ),
    by: str = Option(
        "", metavar="NAME", help="Who decides, as the list will say; by default the login name."
    ),
    port: int = Option(0, min=0, max=65535, help="Of the page; 0: any that is free."),
    open_page: bool = Option(True, "--open/--no-open", help="Open the page in the browser."),
    jobs: options.Jobs = "auto",
) -> Answer:
    """Look at the picks of a campaign in the browser, and decide: accept, move, exclude, comment, undo.

    Decisions go into the campaign's own list of trials (columns pick_s, exclude, why, by, when), of which nothing else
    changes; what they change in the condition, the law and the lift force is shown. The page is served on this machine
    alone, to whoever has the address that is printed. Ctrl-C ends it. The folder of results is brought up to date by
    `ropefric report OUT_DIR`, or `extract`.
    """
    if not folder.is_dir():
        raise DataError("there is no such folder", path=folder, fix="give a folder that `ropefric run` wrote")
    if campaign is None and not (folder / evidence.MANIFEST).is_file():
        why = "the folder does not say which campaign it is of: only `run` writes that down"
        raise DataError(why, path=folder, fix="name the campaign: --campaign CAMPAIGN.toml")
    path, law = (campaign, "") if campaign is not None else evidence.recorded_run(folder)
    path = options.campaign_file(path)
    n_jobs = options.parse_jobs(jobs, len(campaigns.load_campaign(path, missing_recordings="flag").trials))
    with Progress(out, "extract") as progress:
        reviewed = session.Review(
            path,
            by=by.strip() or _login_name(),
            law=law,
            cache_dir=folder / folders.CACHE,
            jobs=n_jobs,
            progress=progress.update,
        )
    with server.ReviewServer(reviewed, port) as serving:
        # Not a note: without it nobody finds the page.
        sys.stderr.write(f"{serving.address}\n")
        sys.stderr.flush()
        out.note(f"decisions go into {reviewed.trial_list}; Ctrl-C ends the review")
        if open_page and _has_screen():
            webbrowser.open(serving.address)
        try:
            serving.serve_forever()
        except KeyboardInterrupt as interrupt:
            reviewed.close()
            if interrupt.args:  # not Ctrl-C: the system wants an end
                raise
    written = counted(reviewed.n_written, "decision")
    more = f"; `ropefric report {folder}` brings the results up to date" if reviewed.n_written else ""
    data = {"trial_list": reviewed.trial_list, "n_decisions": reviewed.n_written, "by": reviewed.by}
    said = f"{written} written to {reviewed.trial_list}{more}"
    return Answer(data, [section.Section(title="", lines=(said,), verbatim=True)])


def _login_name() -> str:
    try:
        return getpass.getuser()
    except (OSError, KeyError, ImportError):  # a machine that knows no names
        raise InputError("who decides?", code="RF121", key="--by", fix="give your name with --by") from None


def _has_screen() -> bool:
    """Return whether a browser could show itself; one for terminals would take this one."""
    names = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")
    return sys.platform != "linux" or any(os.environ.get(name) for name in names)
