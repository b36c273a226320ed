"""Print the tests whose long studies a change of the last days asks for: `python .ci/studies.py [all]`.

A path that no row of the table knows asks for all of them.
"""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
EVERYTHING = ("tests", "ropefric")
LAWS = ("tests/friction", "tests/hard", "tests/fitting", "tests/uncertainty")
MACHINES = ("tests/systems", "tests/scenes", "tests/hard", "tests/accuracy")
RECORDINGS = ("tests/traces", "tests/trials", "tests/rig", "tests/fuzz", "tests/accuracy")
PAGES = ("tests/plotting", "tests/report", "tests/page")

STUDIES: dict[str, tuple[str, ...]] = {
    "ropefric/friction": (*LAWS, *MACHINES),
    "ropefric/uncertainty": (*LAWS, "tests/traces", "tests/trials"),
    "ropefric/files": ("tests/files", "tests/trials", "tests/fuzz", "tests/scenes"),
    "ropefric/traces": RECORDINGS,
    "ropefric/trials": RECORDINGS,
    "ropefric/rig": RECORDINGS,
    "ropefric/training.py": ("tests/traces", "tests/test_training.py"),
    "ropefric/fitting": ("tests/fitting", "tests/hard", "tests/fuzz"),
    "ropefric/systems": MACHINES,
    "ropefric/scenes": ("tests/scenes", "tests/fuzz", "tests/accuracy"),
    "ropefric/accuracy": ("tests/accuracy",),
    "ropefric/plotting": PAGES,
    "ropefric/report": PAGES,
    "ropefric/page": PAGES,
    "ropefric/cli": ("tests/cli", "tests/docs"),
    "data": ("tests/trials", "tests/pipeline", "tests/scenes"),
    "fits": ("tests/fitting", "tests/pipeline"),
    "docs": ("tests/docs",),
    "notebooks": ("tests/test_notebooks.py",),
    "README.md": ("tests/docs",),
    "CHANGELOG.md": (),
    "CITATION.cff": (),
    "CODE_OF_CONDUCT.md": (),
    "CONTRIBUTING.md": (),
    "LICENSE": (),
    ".gitignore": (),
    ".ci": (),
}
"""What to study where something changed; tests ask for their own folder's."""


def studies(changed: list[str], root: Path = ROOT) -> tuple[str, ...]:
    """Return the folders and files of tests to study, in their order; EVERYTHING where a path is unknown."""
    asked: set[str] = set()
    for path in changed:
        parts = path.split("/")
        own = "/".join(parts[:2])
        if parts[0] == "tests" and len(parts) > 1:
            if len(parts) == 2 and not parts[1].startswith("test_"):
                return EVERYTHING  # what all tests share
            asked.add(own)
        elif (row := STUDIES.get(own, STUDIES.get(parts[0]))) is not None:
            asked.update(row)
        else:
            return EVERYTHING
    return tuple(sorted(one for one in asked if (root / one).exists()))


def changed_of_late(since: str = "2 days ago") -> list[str]:
    """Return the paths that commits of the last days or the working tree changed; one unknown where git says nothing."""
    commands = (
        ["git", "log", f"--since={since}", "--name-only", "--format="],
        ["git", "status", "--porcelain", "--no-renames"],
    )
    found: set[str] = set()
    for command in commands:
        said = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
        if said.returncode:
            return ["?"]
        found.update(line[3:] if command[1] == "status" else line for line in said.stdout.splitlines())
    return sorted(found - {""})


if __name__ == "__main__":
    print(*(EVERYTHING if "all" in sys.argv[1:] else studies(changed_of_late())))
