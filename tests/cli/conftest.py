"""A small simulated campaign and a way to call the program in process."""

import json
from types import SimpleNamespace

import pytest

from ropefric.cli.app import main


def _strict(text):
    """One JSON document, without the NaN that Python's reader would let through."""

    def refuse(word):
        raise AssertionError(f"{word} is not JSON")

    return json.loads(text, parse_constant=refuse)


@pytest.fixture
def strict():
    return _strict


@pytest.fixture(autouse=True)
def _no_terminal(monkeypatch):
    """Let no runner's idea of a terminal fold what goes into a pipe."""
    monkeypatch.delenv("COLUMNS", raising=False)


@pytest.fixture
def call(capfd):
    """Call the program; return exit code, stdout, stderr, and what `json()` reads from stdout."""

    def call(*argv):
        capfd.readouterr()
        code = main([str(word) for word in argv])
        said = capfd.readouterr()
        return SimpleNamespace(code=code, out=said.out, err=said.err, json=lambda: _strict(said.out))

    return call


@pytest.fixture(scope="session")
def bench(tmp_path_factory):
    """Twelve recordings of two conditions on the virtual rig, with the usual faults; do not write to it."""
    folder = tmp_path_factory.mktemp("bench") / "campaign"
    assert main(["simulate", str(folder), "--conditions", "2", "--repeats", "6", "--quiet"]) == 0
    return folder
