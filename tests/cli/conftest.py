"""A small simulated campaign and a way to call the program in process."""

import json
import os
import shutil
import sys
import traceback
import warnings
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


@pytest.fixture
def forked(capfd):
    """Run the program as a process, forked from this one, that first calls `prepare`; return code, stdout, stderr."""
    if not hasattr(os, "fork"):
        pytest.skip("no fork")

    def forked(prepare, *argv):
        capfd.readouterr()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # of threads: those of the runner only wait
            number = os.fork()
        if not number:
            code = 70
            try:
                sys.argv[1:] = [str(word) for word in argv]
                sys.stdout, sys.stderr = (os.fdopen(to, "w", encoding="utf-8", closefd=False)
                    for to in (1, 2))  # fmt: skip
                prepare()
                sys.modules.pop("ropefric.__main__", None)  # which remembers the process it was loaded in
                from ropefric.__main__ import main as door

                code = door()
                sys.stdout.flush()
                sys.stderr.flush()
            except BaseException:  # noqa: BLE001  (the fork must not go on with the tests)
                os.write(2, traceback.format_exc().encode())
            finally:
                os._exit(code)
        code = os.waitstatus_to_exitcode(os.waitpid(number, 0)[1])
        return code, *capfd.readouterr()

    return forked


@pytest.fixture(scope="session")
def bench(tmp_path_factory):
    """Twelve recordings of two conditions on the virtual rig, with the usual faults; do not write to it."""
    folder = tmp_path_factory.mktemp("bench") / "campaign"
    assert main(["simulate", str(folder), "--conditions", "2", "--repeats", "6", "--quiet"]) == 0
    return folder


@pytest.fixture
def campaign(bench, tmp_path):
    """A copy that may be spoilt."""
    return shutil.copytree(bench, tmp_path / "campaign")
