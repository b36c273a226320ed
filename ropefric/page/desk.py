"""The job of one person: folder, campaign, review and one long task at a time; the answer to each address."""

import os
import threading
from collections.abc import Callable, Mapping
from pathlib import Path, PureWindowsPath
from typing import Any

from ropefric import pipeline
from ropefric.errors import DataError, InputError
from ropefric.files.disk import read_file, write_file
from ropefric.page import answers
from ropefric.page.recordings import Draft, wish_of
from ropefric.page.review import Review
from ropefric.page.work import Step, Work
from ropefric.report import campaign as reports
from ropefric.report.page import Wish, find_browser
from ropefric.trials.campaign import load_campaign

DROPPED = "recordings"
"""The folder beside the campaign that receives the files dropped on the page."""
MOST_OF_A_FILE = 256 * 2**20
"""Bytes of one of them."""
MOST_FILES, MOST_BYTES = 10_000, 8 * 2**30
"""Limits of all files dropped on the page together."""
_SETTINGS = ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N")
_SHOWN = ("report.html", "report.pdf", "summary.txt")


class Desk:
    """The work of one person.

    Parameters
    ----------
    place : Path
        A campaign file; or a folder: of a campaign, of results, or of recordings.
    by : str
        Who decides.
    campaign : Path, optional
        The campaign whose results are in the folder, which does not say so itself.
    jobs : int
        Processes that read the recordings.
    """

    def __init__(self, place: Path, *, by: str, campaign: Path | None = None, jobs: int = 1) -> None:
        self.by, self.jobs = by, jobs
        self.review: Review | None = None
        self.campaign, self._law = (campaign, "") if campaign else _campaign_at(place)
        is_result = campaign is not None or (place / pipeline.MANIFEST).is_file()
        self._out = place if place.is_dir() and is_result else None
        self._recordings, home = "", place if self.campaign is None else self.campaign.parent
        if self.campaign is None and any(one.is_file() for one in place.iterdir()):
            # A campaign is beside its recordings.
            self._recordings, home = str(place), place.absolute().parent
        self.draft = Draft(home)
        self.work, self._lock = Work(), threading.Lock()
        self._n_files = self._n_bytes = 0
        self.reads: dict[str, Callable[[Mapping[str, str]], Any]] = {
            "state": lambda _: self.state(),
            "work": lambda _: self.work.state(),
            "names": lambda q: self.draft.names(q["recordings"], q["pattern"]),
            "trace": lambda q: self.draft.trace(int(q["number"]), int(q["columns"])),
            "overview": lambda _: self.opened.overview(),
            "answer": lambda _: self.opened.answer(),
            "trial": lambda q: self.opened.trial(q["trial"]),
            "preview": lambda q: self.opened.preview(q["trial"], float(q["pick_s"])),
            "curve": lambda q: self.opened.curve(
                q["trial"], float(q["start_s"]), float(q["stop_s"]), int(q["columns"])
            ),
            "law": lambda _: self._of_run(lambda run: answers.law_of(self.opened, run)),
            "lift": lambda q: self._of_run(lambda run: answers.lift_of(run, _settings(q))),
            "inverse": lambda q: self._of_run(lambda run: answers.inverse_of(run, q, _settings(q))),
            "machines": lambda _: answers.machine_names(),
            "machine": lambda q: answers.machine_form(q["name"]),
        }
        self.writes: dict[str, Callable[[dict[str, Any]], Any]] = {
            "begin": self._begin_draft,
            "propose": self._propose,
            "write": self._write,
            "open": lambda _: self.work.begin("reading the recordings", self.open),
            "stop": lambda _: self.work.stop(),
            "decide": lambda asked: self.opened.decide(**asked),
            "undo": lambda _: self.opened.undo(),
            "switch": lambda asked: self.opened.switch(asked["trial"], str(asked["text"]).strip()),
            "use-law": lambda asked: self.opened.use_law(str(asked["law"])),
            "plan": lambda _: self.work.begin("planning tests", lambda _: self._of_run(answers.plan_of)),
            "solve": self._solve,
            "report": self._report,
        }

    @property
    def out(self) -> Path:
        """Return the folder of results."""
        return self._out or self.draft.home / "out"

    @property
    def opened(self) -> Review:
        """Return the review of the campaign that is open."""
        if self.review is None:
            raise InputError("no campaign is open", fix="begin with the recordings")
        return self.review

    def close(self) -> None:
        """End the work and the review."""
        self.work.close()
        if self.review is not None:
            self.review.close()

    def state(self) -> dict[str, Any]:
        """Return the state of the job: folders, campaign, whether it is open, and the reports that exist."""
        return {
            "home": str(self.draft.home),
            "recordings": self._recordings,
            "campaign": "" if self.campaign is None else str(self.campaign),
            "name": "" if self.review is None else self.review.campaign.name,
            "ready": self.review is not None,
            "out": str(self.out),
            "reports": [name for name in _SHOWN if (self.out / name).is_file()],
            "largest_file": MOST_OF_A_FILE,
        }

    # --- the recordings ---

    def upload(self, name: str, content: bytes) -> dict[str, Any]:
        """Write a file that was dropped on the page; an existing file is never replaced."""
        if not name or name.startswith(".") or PureWindowsPath(name).name != name or not name.isprintable():
            raise InputError(f"{name!r} is no name of a recording", key="name", fix="rename the file")
        path = self.draft.home / DROPPED / name
        with self._lock:
            self._n_files, self._n_bytes = self._n_files + 1, self._n_bytes + len(content)
            if self._n_files > MOST_FILES or self._n_bytes > MOST_BYTES:
                raise InputError("too much was dropped", fix="name the folder of the recordings instead")
            if os.path.lexists(path):
                raise InputError("the file exists already", code="RF150", path=path, fix="rename it")
            write_file(path, content)
        self._recordings = str(path.parent)
        return {"recordings": self._recordings}

    def _begin_draft(self, asked: dict[str, Any]) -> dict[str, Any]:
        """Begin with the settings of the existing campaign; or, if anew, with none."""
        self.draft = Draft(self.draft.home, None if asked.get("anew") else self.campaign)
        return self.draft.form()

    def _propose(self, asked: dict[str, Any]) -> dict[str, Any]:
        wish = wish_of(asked)
        if self.draft.campaign is None:
            self.draft.home, self._recordings = Path(asked.get("home") or self.draft.home), wish.recordings
        return self.work.begin("looking at the recordings", lambda step: self.draft.propose(wish, step))

    def _write(self, asked: dict[str, Any]) -> dict[str, Any]:
        self.campaign = self.draft.write(asked["shown"], overwrite=bool(asked.get("overwrite")))
        if self.draft.campaign is None:  # a new one
            if self.review is not None:
                self.review.close()
            self.review, self._law, self._out = None, "", None
        self.draft = Draft(self.campaign.parent, self.campaign)
        return self.state()

    def open(self, step: Step) -> dict[str, Any]:
        """Open the campaign; one that is open already is read again, as far as its files have changed."""
        if self.campaign is None:
            raise InputError("there is no campaign here yet", fix="begin with the recordings")
        if self.review is not None:
            self.review.reload(step)
        else:
            how: dict[str, Any] = {"law": self._law, "jobs": self.jobs, "progress": step}
            self.review = Review(self.campaign, by=self.by, **how)
        return self.state()

    # --- the law, wheels and machines ---

    def _of_run(self, make: Callable[[pipeline.CampaignRun], dict[str, Any]]) -> dict[str, Any]:
        """Return a result of the answer to all trials, or that it is being computed; raise its error, if any."""
        run = self.opened.run()
        return {"computing": self.opened.answer()["computing"] or "fit"} if run is None else make(run)

    def _solve(self, asked: dict[str, Any]) -> dict[str, Any]:
        name, values = asked["name"], {key: str(text) for key, text in dict(asked["values"]).items()}
        if not asked.get("own"):
            return answers.solve_machine(name, values, None)
        return self._of_run(lambda run: answers.solve_machine(name, values, run.answer.fit))

    # --- the report ---

    def _report(self, asked: dict[str, Any]) -> dict[str, Any]:
        """Begin what `ropefric report CAMPAIGN.toml --out FOLDER [--short] [--pdf]` does."""
        campaign = self.opened.campaign_file
        wish = Wish(pdf=bool(asked.get("pdf")), short=bool(asked.get("short")))
        if wish.pdf:
            find_browser()  # before the work

        def report(step: Step) -> dict[str, Any]:
            loaded = load_campaign(campaign)
            with pipeline.campaign_folder(loaded, self.out) as target:
                how: dict[str, Any] = {
                    "extract_progress": step,
                    "fit_progress": lambda law, done, total: step(done, total, law),
                }
                done = pipeline.run_campaign(loaded, target, law=self.opened.law, jobs=self.jobs, **how)
                reports.write_report(done, target, wish, progress=step)
                target.publish("answer")
            return self.state()

        return self.work.begin("making the report", report)

    def result(self, name: str) -> bytes:
        """Return a file of the folder of results that the page shows."""
        if name not in _SHOWN:
            raise DataError("the page does not show this file", path=name)
        return read_file(self.out / name)


def _campaign_at(place: Path) -> tuple[Path | None, str]:
    """Return the campaign file that a place is, contains, or was made from, None if there is none; the chosen law."""
    if not place.is_dir():
        return place, ""
    if (place / "campaign.toml").is_file():
        return place / "campaign.toml", ""
    return pipeline.recorded_run(place) if (place / pipeline.MANIFEST).is_file() else (None, "")


def _settings(query: Mapping[str, str]) -> dict[str, float]:
    return {name: float(query[name]) for name in _SETTINGS}
