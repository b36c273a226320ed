"""A small campaign with two doubtful recordings, to decide about."""

import shutil
import threading
import time
from contextlib import ExitStack, contextmanager
from datetime import UTC, datetime
from pathlib import Path

import pytest
from browser import driven

from ropefric.errors import DataError
from ropefric.page import review as session
from ropefric.page.desk import Desk
from ropefric.page.review import Review
from ropefric.page.server import PageServer
from ropefric.traces.breakaway import Status
from ropefric.traces.decision import Candidate, Judgement

BENCH = Path(__file__).parents[2] / "data" / "prth-bench"


@pytest.fixture(scope="session")
def extracted(tmp_path_factory):
    """The folder of the campaign; do not write to it."""
    folder = tmp_path_factory.mktemp("review")
    toml = (BENCH / "campaign.toml").read_text().replace(
        'trials = "trials.csv"', f'trials = "trials.csv"\ndata = "{BENCH.as_posix()}"'
    )  # fmt: skip
    (folder / "campaign.toml").write_text(toml)
    head, *rows = (BENCH / "trials.csv").read_text().splitlines()
    some = [row for row in rows if row[:3] in {"c11", "c28", "c35"} and row[5:7] < "05"]
    (folder / "trials.csv").write_text("\n".join(["# taken in spring", head, *some, ""]))
    (folder / "out").mkdir()
    return folder


@pytest.fixture
def campaign(extracted, tmp_path):
    """A copy of it."""
    shutil.copytree(extracted, tmp_path / "campaign")
    return tmp_path / "campaign"


def not_fitted(*_):
    """Say nothing of all trials: to compare laws takes longer than all else."""
    raise DataError("not fitted")


@pytest.fixture(scope="session")
def picked(extracted):
    """What a review has picked of the campaign; a review that begins with it picks only what differs."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(session, "_answered", not_fitted)
        review = Review(extracted / "campaign.toml", by="A. Meier")
    review.close()
    return review._state


@pytest.fixture
def begin(campaign, picked, monkeypatch):
    """Begin a review of the campaign, which ends with the test; laws are fitted only where that is asked for."""
    begun, load = [], Review._load
    monkeypatch.setattr(Review, "_load", lambda self, before, *given: load(self, before or picked, *given))

    def begin(*, fits=False):
        if not fits:
            monkeypatch.setattr(session, "_answered", not_fitted)
        now = datetime(2026, 11, 22, 14, 30, tzinfo=UTC)
        begun.append(Review(campaign / "campaign.toml", by="A. Meier", now=lambda: now))
        return begun[-1]

    yield begin
    for review in begun:
        review.close()


@pytest.fixture
def undecided(monkeypatch):
    """What the picker says to the review of every recording; the times at which it was asked."""
    asked = []

    def judge(prepared):
        asked.append(float(prepared.time_s[0]))
        candidates = [Candidate(0, 80.0, 0.61, 2.1, 2.2), Candidate(0, 70.0, 0.3, 1.5, 1.5)]
        return Judgement(candidates, {Status.NO_BREAKAWAY: 0.09, Status.NO_PEAK: 0.0}, None)

    monkeypatch.setattr(session, "judge", judge)
    return asked


@contextmanager
def serving(desk):
    """Serve the page of a desk, and end both."""
    with PageServer(desk) as server:
        thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        try:
            yield server
        finally:
            server.shutdown()
            thread.join()
            desk.close()


@pytest.fixture(scope="session")
def chromium():
    """The one browser of all tests of this folder."""
    yield from driven()


@pytest.fixture
def serve(chromium):
    """A function that serves a desk and returns the address of its page; what the browser complains of is a failure."""
    with ExitStack() as stack:
        yield lambda desk: stack.enter_context(serving(desk)).address
        assert [one for one in chromium.get_log("browser") if "409" not in one["message"]] == []
        chromium.get("about:blank")


@pytest.fixture(scope="module")
def served(extracted, tmp_path_factory):
    """A review without fits and the server of its page; tests leave its list as it was."""
    folder = tmp_path_factory.mktemp("served") / "campaign"
    shutil.copytree(extracted, folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(session, "_answered", not_fitted)
        review = Review(folder / "campaign.toml", by="A. Meier")
        desk = Desk(folder / "campaign.toml", by="A. Meier")
        desk.review = review
        with serving(desk) as server:
            yield server


@pytest.fixture(scope="session")
def settled():
    """Return what all trials of a review say, once that is computed."""

    def settled(review):
        while review.answer()["computing"]:
            time.sleep(0.01)
        return review.answer()

    return settled
