"""A small simulated campaign with its report."""

import gzip
import pickle
from concurrent.futures import Executor, Future

import pytest

from ropefric.cli.app import main
from ropefric.fitting import compare
from ropefric.pipeline import gather_evidence, run_campaign
from ropefric.report import campaign as pages
from ropefric.report.campaign import write_report
from ropefric.report.page import Wish
from ropefric.trials.campaign import load_campaign


@pytest.fixture(scope="session")
def campaign(tmp_path_factory):
    """Thirty-six recordings of six conditions, one of them spoilt, with a wheel to design; do not write to it."""
    folder = tmp_path_factory.mktemp("report") / "campaign"
    words = ["simulate", str(folder), "--conditions", "6", "--repeats", "6", "--seed", "3", "--quiet"]
    assert main(words) == 0
    (spoilt,) = folder.glob("traces/c06-r03.csv*")
    lines = gzip.decompress(spoilt.read_bytes()).splitlines(keepends=True)
    spoilt.write_bytes(
        gzip.compress(b"".join(lines[: len(lines) // 4]), mtime=0)
    )  # it ends before it is loaded
    return folder


@pytest.fixture(scope="session")
def results(tmp_path_factory):
    """The folder of its results; do not write to it."""
    return tmp_path_factory.mktemp("results") / "out"


@pytest.fixture(scope="session")
def few_laws():
    """The laws that are compared here: to fit all of them takes longer than a report."""
    return {name: compare.LAWS[name] for name in (*compare.ALWAYS, "howell", "coupled")}


@pytest.fixture(scope="session")
def run(campaign, results, few_laws):
    """The result of the campaign."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compare, "LAWS", few_laws)
        return run_campaign(load_campaign(campaign / "campaign.toml"), results)


class _ElsewhereExecutor(Executor):
    """An executor whose work is sent as to another process."""

    def submit(self, work, /, *words, **named):
        done = Future()
        again, words, named = pickle.loads(pickle.dumps((work, words, named)))  # noqa: S301  (our own)
        done.set_result(again(*words, **named))
        return done


@pytest.fixture(scope="session")
def page(run, results):
    """The text of the report with all its figures, each drawn as in another process."""
    write_report(run, results, executor=_ElsewhereExecutor())
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
