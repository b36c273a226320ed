"""The gate asks for the long studies of what changed, and for all of them where it does not know."""

import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "ropefric"

pytestmark = pytest.mark.skipif(not (ROOT / ".ci").is_dir(), reason="a source archive has no gate")


@pytest.fixture
def gate():
    return runpy.run_path(str(ROOT / ".ci" / "studies.py"))


def test_a_room_asks_for_its_studies_and_what_nobody_knows_for_all(gate):
    studies = gate["studies"]
    assert studies([]) == studies(["CHANGELOG.md"]) == ()
    assert studies(["ropefric/fitting/fit.py", "LICENSE"]) == ("tests/fitting", "tests/fuzz", "tests/hard")
    assert studies(["tests/cli/test_run.py", "tests/test_readme.py"]) == ("tests/cli", "tests/test_readme.py")
    for unknown in ("pyproject.toml", "ropefric/quantities.py", "tests/conftest.py", "?", "new/file.py"):
        assert studies(["LICENSE", unknown]) == gate["EVERYTHING"]


def test_the_table_names_what_is_there(gate):
    for path, asked in gate["STUDIES"].items():
        assert all((ROOT / one).exists() for one in (path, *asked)), path
