"""What a page shows is what a command prints: sessions in the pages, run and compared, or written anew.

A ```console block is a session: a line that begins with `$ ` is run, what follows is its output, and a line `…` stands
for any number of lines left out. `ropefric` (with or without `2>&1`), `cat FILE` and `echo $?` can be run; a command
that ends with another code than 0 has `echo $?` behind it. A ```pycon block is a doctest. All blocks of a page run in
their order in one folder that holds the checkout's `data`, `fits` and `docs`, and every file that a block of the page
begins with the name of: `# file: NAME`.
"""

import contextlib
import difflib
import doctest
import io
import os
import re
import shlex
from dataclasses import dataclass, field
from pathlib import Path

from ropefric import plugins
from ropefric.cli.app import main

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *(page for page in sorted(ROOT.glob("docs/**/*.md"))
    if page.parent.name != "generated")]  # fmt: skip
LEFT_OUT = "…"
WAITS = ("ropefric app ", "ropefric review ")
"""Commands that serve until somebody ends them are not run, and what a page says of them stays."""
_FILE = re.compile(r"^```\w+\n# file: (\S+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_BLOCK = re.compile(r"^```(console|pycon)\n(.*?)^```$", re.DOTALL | re.MULTILINE)


@dataclass
class Step:
    """One command of a session, as the page has it."""

    command: str
    shown: list[str] = field(default_factory=list)


def steps_of(block):
    """Return the commands of a console block with what it says they print."""
    steps = []
    for line in block.splitlines():
        if line.startswith("$ "):
            steps.append(Step(line[2:]))
        else:
            assert steps, f"a session begins with a command, not with: {line}"
            steps[-1].shown.append(line)
    return steps


def sessions(page):
    """Return the kind and the text of every block of a page that is run."""
    return _BLOCK.findall(page.read_text(encoding="utf-8"))


def prepare(folder):
    """Put what a checkout holds within reach of the commands."""
    for name in ("data", "fits", "docs"):
        (folder / name).symlink_to(ROOT / name, target_is_directory=True)


class Shell:
    """Runs the commands of one page in the working folder and remembers how the last one ended."""

    def __init__(self):
        self.code = 0

    def run(self, line):
        """Return the lines that a command prints."""
        words = shlex.split(line)
        if words == ["echo", "$?"]:
            code, self.code = self.code, 0
            return [str(code)]
        assert self.code == 0, f"ended with {self.code}, and the page does not say so; before: {line}"
        if words[0] == "cat":
            return "".join(Path(name).read_text(encoding="utf-8") for name in words[1:]).splitlines()
        assert words[0] == "ropefric", f"not a command a page may show: {line}"
        out, err = io.StringIO(), io.StringIO()
        both = words[-1] == "2>&1"
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out if both else err):
            self.code = main(words[1 : len(words) - both])
        assert self.code != 1, err.getvalue()
        return [line.rstrip() for line in out.getvalue().strip("\n").splitlines()]


def agrees(shown, printed):
    """Say whether lines on a page are what was printed, `…` standing for what was left out."""
    at = 0
    for place, part in enumerate(_parts(shown)):
        starts = [at] if place == 0 else range(at, len(printed) - len(part) + 1)
        found = next((start for start in starts if printed[start : start + len(part)] == part), None)
        if found is None:
            return False
        at = found + len(part)
    return at == len(printed) or bool(shown and shown[-1].strip() == LEFT_OUT)


def written_anew(shown, printed):
    """Return what was printed with the same parts left out as on the page: a part is found by its first line."""
    if not any(line.strip() == LEFT_OUT for line in shown):
        return printed
    kept, at = [], 0
    for place, part in enumerate(_parts(shown)):
        if place:
            kept.append(LEFT_OUT)
        if not part:
            continue
        start = 0 if place == 0 else _begins(part[0], printed, at)
        kept += printed[start : start + len(part)]
        at = start + len(part)
    return kept


def _parts(shown):
    parts = [[]]
    for line in shown:
        if line.strip() == LEFT_OUT:
            parts.append([])
        else:
            parts[-1].append(line)
    return parts


def _begins(line, printed, at):
    """Return where a part begins that began with this line: there, or where the same words or most alike ones are."""
    for like in (str, _words):
        for place in range(at, len(printed)):
            if like(printed[place]) == like(line):
                return place
    alike = difflib.get_close_matches(line, printed[at:], n=1, cutoff=0.7)
    assert alike, f"nothing printed begins like: {line}"
    return printed.index(alike[0], at)


def _words(line):
    """Return what a line begins with before its numbers."""
    first = re.split(r"\s{2,}|[:=]", line.strip())[0]
    words = re.split(r"\d", first)[0]
    return words if len(words) > 3 else first


def run_page(page, *, anew=False):
    """Run a page's blocks in the working folder; return its text, with what is printed now where `anew`.

    What does not agree is an AssertionError that shows both.
    """
    shell, names = Shell(), {}
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)

    def done(found):
        kind, block = found.groups()
        if kind == "pycon":
            test = doctest.DocTestParser().get_doctest(block, names, page.name, str(page), 0)
            said = io.StringIO()
            runner.run(test, out=said.write, clear_globs=False)
            names.update(test.globs)
            assert not said.getvalue(), said.getvalue()
            return found[0]
        lines = []
        for step in steps_of(block):
            printed = step.shown if step.command.startswith(WAITS) else shell.run(step.command)
            if not anew and not agrees(step.shown, printed):
                raise AssertionError(f"{page.name}: $ {step.command}\nprints\n" + "\n".join(printed) +
                    "\nand not\n" + "\n".join(step.shown) +
                    "\nrun python tests/regenerate_readme.py sessions")  # fmt: skip
            lines += [f"$ {step.command}", *(written_anew(step.shown, printed) if anew else step.shown)]
        return "```console\n" + "".join(f"{line}\n" for line in lines) + "```"

    text = page.read_text(encoding="utf-8")
    for name, content in _FILE.findall(text):
        Path(name).write_text(content, encoding="utf-8")
    text = _BLOCK.sub(done, text)
    assert shell.code == 0, (
        f"{page.name}: the last command ended with {shell.code}, and the page does not say so"
    )
    return text


@contextlib.contextmanager
def quiet_terminal():
    """Take away what a terminal or a user's settings would change in what is printed, and plugins when it is over."""
    kept = {name: os.environ.pop(name, None) for name in ("COLUMNS", "LINES", "FORCE_COLOR")}
    try:
        with plugins.unloaded_after():
            yield
    finally:
        os.environ.update({name: value for name, value in kept.items() if value is not None})
