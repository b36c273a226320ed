"""Print what a user is told, hashed, command by command: `python tests/mutation/probe.py PROJECT`."""

import contextlib
import hashlib
import io
import sys
import tempfile
from pathlib import Path


def answers(project):
    """Print one line a command; imports come after the path, so that this project is asked and no other."""
    sys.path.insert(0, str(project))

    from ropefric.cli.app import main

    trials, fit = project / "fits" / "prth-trials.csv", project / "fits" / "prth-coupled.json"
    wheel = ["--wheel-radius", "40 mm", "--end-tension", "20 N"]
    from ropefric.friction.laws import LAWS

    scenes = sorted((project / "data" / "scenes").glob("*.toml"))
    commands = [
        ["extract", project / "data" / "prth-bench" / "campaign.toml", "--json"],
        ["compare", trials, "--json"],
        ["diagnose", trials, "--json"],
        ["predict", "--fit", fit, *wheel, "--wrap", "540 deg", "--json"],
        ["predict", "--fit", fit, *wheel, "--wrap", "540 deg", "--hand"],
        ["design", "--fit", fit, "--lift", "500 N", *wheel, "--json"],
        ["budget", "--fit", fit, *wheel, "--wrap", "540 deg", "--json"],
        *(["fit", trials, "--law", law, "--json"] for law in LAWS),
        *([word, scene, "--json"] for scene in scenes for word in ("solve", "explain")),
    ]
    with tempfile.TemporaryDirectory() as name:
        for words in commands:
            out = io.StringIO()
            with (
                contextlib.redirect_stdout(out),
                contextlib.redirect_stderr(io.StringIO()),
                contextlib.chdir(name),
            ):
                try:
                    code = main([str(word) for word in words])
                except SystemExit as stop:
                    code = stop.code
                except BaseException as error:  # noqa: BLE001  a crash is an answer too
                    code = type(error).__name__
            text = out.getvalue().replace(str(project), "")
            print(words[0], Path(str(words[1])).name, code, hashlib.sha256(text.encode()).hexdigest()[:16])


if __name__ == "__main__":
    answers(Path(sys.argv[1]))
