"""Break lines of physics, fitting, trials and picking at random: does the suite notice?

`python tests/mutation/mutants.py [--count 60] [--seed 2026]` copies the project and breaks one line at a time in the
copy. The tests run in one process until one fails: those of the broken module's room first, then all others. A break
that no test notices is a gap of the suite, or it changes nothing: `EQUIVALENT` names those, with the reason.
"""

import argparse
import ast
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
ROOMS = ("friction", "systems", "traces", "trials", "uncertainty", "fitting")
LONGEST_S = 1200.0
"""A run of tests that takes longer hangs: the break is noticed."""

EQUIVALENT = {
    "ropefric/traces/picker.py: 20.0  ->  22.0": "no channel comes to the limit: it would be a ratio of 2e8",
    "ropefric/uncertainty/budget.py: 1.0  ->  1.1": "it is divided into a row of zeros",
    "ropefric/systems/press/transient/exact.py: 3.0  ->  3.3000000000000003": "a longer step of a search whose answer "
    "keeps its tolerance",
    "ropefric/fitting/standing.py: 1  ->  2": "a spare start less, in rounds that begin at the minimum",
    "ropefric/fitting/assembled.py: 1e-14  ->  1.1e-14": "a limit of rounding",
    "ropefric/fitting/fit.py: 6  ->  7": "a rounding that decides between parameters that are equally well known",
}
"""Breaks that change no result, as `str(mutant)` without its line number, and why."""

_LEFT_OUT = {"mutation", "benchmarks", "test_architecture.py", "test_gate.py"}
"""Tests of speed, of the size of the code (a broken module is written without comments) and of this study."""

_OTHER = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Pow: ast.Mult, ast.MatMult: ast.Add,
    ast.Lt: ast.GtE, ast.GtE: ast.Lt, ast.Gt: ast.LtE, ast.LtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.And: ast.Or, ast.Or: ast.And,
    ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd,
}  # fmt: skip
_NAMES = {
    "min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum", "any": "all", "all": "any",
    "sin": "cos", "cos": "sin", "exp": "expm1", "log": "log1p", "argmin": "argmax", "argmax": "argmin",
}  # fmt: skip


@dataclass(frozen=True)
class Mutant:
    path: Path
    line: int
    before: str
    after: str
    text: str
    """The whole broken module."""

    @property
    def key(self) -> str:
        return f"{self.path.as_posix()}: {self.before}  ->  {self.after}"

    def __str__(self) -> str:
        return f"{self.path.as_posix()}:{self.line}: {self.before}  ->  {self.after}"


def _break_of(node: ast.AST) -> Callable[[], None] | None:
    """Return what makes a node wrong, None where nothing is done to its kind."""
    match node:
        case ast.BinOp(op=op) if type(op) in _OTHER and not isinstance(
            node.left, ast.Constant | ast.JoinedStr
        ):
            return lambda: setattr(node, "op", _OTHER[type(op)]())
        case ast.BoolOp(op=op):
            return lambda: setattr(node, "op", _OTHER[type(op)]())
        case ast.Compare(ops=[op]) if type(op) in _OTHER:
            return lambda: setattr(node, "ops", [_OTHER[type(op)]()])
        case ast.Constant(value=value) if type(value) is float and value not in (0.0, float("inf")):
            return lambda: setattr(node, "value", 1.1 * value)
        case ast.Constant(value=value) if type(value) is int:
            return lambda: setattr(node, "value", value + 1)
        case ast.UnaryOp(op=ast.USub(), operand=operand) if not isinstance(operand, ast.Constant):
            return lambda: setattr(node, "op", ast.UAdd())
        case ast.If() | ast.IfExp():
            return lambda: setattr(node, "test", ast.UnaryOp(ast.Not(), node.test))
        case ast.Attribute(attr=name) | ast.Name(id=name) if name in _NAMES:
            return lambda: setattr(node, "attr" if isinstance(node, ast.Attribute) else "id", _NAMES[name])
    return None


def _places(tree: ast.Module) -> dict[int, list[ast.AST]]:
    """Return the nodes that can be broken, by line; messages, imports, annotations and words are not results."""
    found: dict[int, list[ast.AST]] = {}

    def visit(node: ast.AST) -> None:
        if isinstance(node, ast.Raise | ast.Import | ast.ImportFrom | ast.JoinedStr | ast.Assert):
            return
        if _break_of(node) is not None:
            found.setdefault(node.lineno, []).append(node)  # type: ignore[attr-defined]
        for name, child in ast.iter_fields(node):
            if name in {"annotation", "returns", "decorator_list"}:
                continue
            for one in child if isinstance(child, list) else [child]:
                if isinstance(one, ast.AST):
                    visit(one)

    visit(tree)
    return found


def _number(*words: object) -> int:
    """Return a number drawn by the words alone."""
    return int.from_bytes(hashlib.sha256("\0".join(map(str, words)).encode()).digest()[:8], "big")


def draw(count: int, seed: int, root: Path = ROOT) -> list[Mutant]:
    """Return mutants of `count` lines, each line as likely as every other.

    A line is drawn by its own text: a change elsewhere leaves the draw as it is.
    """
    lines = []
    for path in (path for room in ROOMS for path in sorted((root / "ropefric" / room).rglob("*.py"))):
        text = path.read_text(encoding="utf-8")
        written, name = text.splitlines(), path.relative_to(root).as_posix()
        lines += [
            (_number(seed, name, written[line - 1].strip()), path, line) for line in _places(ast.parse(text))
        ]
    return [_mutant(path, line, number, root) for number, path, line in sorted(lines)[:count]]


def _mutant(path: Path, line: int, number: int, root: Path) -> Mutant:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    nodes = _places(tree)[line]
    node = nodes[number % len(nodes)]
    before = ast.unparse(getattr(node, "test", node))
    wrong = _break_of(node)
    assert wrong is not None
    wrong()
    return Mutant(
        path.relative_to(root), line, before, ast.unparse(getattr(node, "test", node)), ast.unparse(tree)
    )


def _copy(place: Path) -> Path:
    """Return a copy of the project as it is now, with the real recordings beside it where there are any."""
    folder = place / "project"
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True)
    for name in listed.stdout.splitlines():
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, folder / name)
    (place / "shared").symlink_to(ROOT.parent / "shared")
    return folder


def _failed(folder: Path, tests: list[Path]) -> str:
    """Return the first of these tests that fails; "" if none does."""
    words = ("-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "-p", "no:randomly", "--tb=no")
    environment = {**os.environ, "PYTHONPATH": str(folder), "OMP_NUM_THREADS": "1"}
    try:
        done = subprocess.run(
            [sys.executable, *words, *map(str, tests)],
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
            timeout=LONGEST_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return "a test that hangs"
    if done.returncode in {0, 5}:  # 5: all of these tests are long ones
        return ""
    failed = [line.split()[1] for line in done.stdout.splitlines() if line.startswith(("FAILED ", "ERROR "))]
    return failed[0] if failed else (done.stdout + done.stderr).strip()[-80:]


def noticed_by(mutant: Mutant, folder: Path, *, near: bool) -> str:
    """Return the first test that notices a mutant, of its room (near) or of all others; "" if none does."""
    module, tests = folder / mutant.path, folder / "tests"
    own = tests / mutant.path.parts[1]
    others = [path for path in sorted(tests.glob("[a-z]*")) if path.name not in _LEFT_OUT and path != own]
    whole = module.read_text(encoding="utf-8")
    try:
        _write(module, mutant.text)
        return _failed(
            folder, [module, own] if near else [*filter(_holds_tests, others), folder / "ropefric"]
        )
    finally:
        _write(module, whole)


def _holds_tests(path: Path) -> bool:
    return path.is_dir() or path.name.startswith("test_")


def _write(module: Path, text: str) -> None:
    """Write a module and remove what was compiled of it, which its time and size may not tell apart."""
    module.write_text(text, encoding="utf-8")
    for compiled in (module.parent / "__pycache__").glob(f"{module.stem}.*.pyc"):
        compiled.unlink()


def study(count: int, seed: int, say: Callable[[str], object] = print) -> tuple[int, int]:
    """Return how many of the mutants that change a result were noticed, and how many there were.

    The tests of their rooms see all mutants before the whole suite sees those that are left.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = _copy(Path(name))
        if failed := _failed(folder, [folder / "tests" / room for room in ROOMS]):
            raise RuntimeError(f"{failed} fails on the unbroken project")
        drawn = draw(count, seed, folder)
        left = [mutant for mutant in drawn if mutant.key not in EQUIVALENT]
        for mutant in drawn:
            if mutant not in left:
                say(f"{mutant}\n    changes no result: {EQUIVALENT[mutant.key]}")
        counted = len(left)
        for near in (True, False):
            missed = []
            for mutant in left:
                test = noticed_by(mutant, folder, near=near)
                say(
                    f"{mutant}\n    {f'noticed by {test}' if test else 'left to the others' if near else 'MISSED'}"
                )
                missed += [] if test else [mutant]
            left = missed
    say(
        f"{counted - len(left)} of {counted} that change a result were noticed; {count - counted} change none"
    )
    return counted - len(left), counted


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--seed", type=int, default=2026)
    given = parser.parse_args()
    study(given.count, given.seed, lambda line: print(line, flush=True))
