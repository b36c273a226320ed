"""The README keeps its word: two commands, each one line, and the file names it mentions exist."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def commands():
    return re.findall(r"<!-- command: (\w+) -->\n```sh\n(.*?)\n```\n<!-- end -->", README, re.DOTALL)


def test_there_are_two_commands_of_one_line_that_make_their_own_environment():
    found = dict(commands())
    assert list(found) == ["main", "test"]
    for line in found.values():
        assert "\n" not in line
        assert line.startswith("python3 -m venv .venv && .venv/bin/python -m pip install ")
    assert "data/prth-bench" in found["main"]
    assert found["test"].endswith("-m pytest -q -n 2 --dist loadfile")


def test_the_gate_runs_the_readmes_test_command():
    gate = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert "command: test" in gate
    assert "README.md" in gate
