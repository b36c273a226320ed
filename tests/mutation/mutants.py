"""Break lines of the physics, the fitting and the trials at random: does the suite notice?

`python tests/mutation/mutants.py [--count 40] [--seed 0] [--jobs 2]` copies the project, breaks one line in the copy,
and runs the tests of that room until one fails. Where none does, `probe.py` asks the commands for their numbers: a break
that changes none of them has changed no result and is not counted. All others have the rest of the suite to notice them.
"""

import argparse
import ast
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
ROOMS = ("friction", "systems", "trials", "uncertainty", "fitting")
SOONEST = ("hard", "literature", "pipeline", "friction", "systems", "fitting", "scenes", "trials", "cli")
LONGEST_S = 1500.0
"""A suite that takes longer hangs: that is noticed too."""

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


def draw(count: int, seed: int, root: Path = ROOT) -> list[Mutant]:
    """Return mutants of so many lines, each line as likely as every other."""
    lines = []
    for room in ROOMS:
        place = root / "ropefric" / room
        for path in sorted(place.rglob("*.py")) or [place]:
            found = _places(ast.parse(path.read_text(encoding="utf-8")))
            lines += [(path, line) for line in sorted(found)]
    chosen = random.Random(seed)
    return [_mutant(path, line, chosen, root) for path, line in chosen.sample(lines, count)]


def _mutant(path: Path, line: int, chosen: random.Random, root: Path) -> Mutant:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    node = chosen.choice(_places(tree)[line])
    before = ast.unparse(getattr(node, "test", node))
    wrong = _break_of(node)
    assert wrong is not None
    wrong()
    return Mutant(
        path.relative_to(root), line, before, ast.unparse(getattr(node, "test", node)), ast.unparse(tree)
    )


def _run(folder: Path, *words: str) -> tuple[int, str]:
    environment = {
        **os.environ,
        "PYTHONPATH": str(folder),
        "PYTHONDONTWRITEBYTECODE": "1",
        "OMP_NUM_THREADS": "1",
    }
    try:
        done = subprocess.run(
            [sys.executable, *words],
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
            timeout=LONGEST_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return 1, "hangs"
    return done.returncode, done.stdout


def _copy(place: Path) -> Path:
    """Return a copy of the project as it stands now, with the real recordings beside it where there are any."""
    folder = place / "project"
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True)
    for name in listed.stdout.splitlines():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, folder / name)
    (place / "shared").symlink_to(ROOT.parent / "shared")
    return folder


def _noticed(folder: Path, room: str, *, its_own: bool) -> str:
    """Return the first test that fails, of a room or of all others; "" if none does.

    The tests of the code's size and of this study are left out, and those of speed.
    """
    out = {"mutation", "benchmarks", "__pycache__", "test_architecture.py"}
    tests = [
        path
        for path in (folder / "tests").iterdir()
        if (path.is_dir() or path.name.startswith("test_")) and path.name not in out
    ]
    # What shows most of what may be wrong comes first.
    tests.sort(key=lambda path: (SOONEST.index(path.name) if path.name in SOONEST else len(SOONEST), path))
    chosen = [path.as_posix() for path in tests if (path.name == room) == its_own]
    whole = ("-n", "2", "--dist", "loadfile") if not room else ("-p", "no:xdist")
    quiet = ("-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *whole, "--tb=no")
    code, said = _run(folder, *quiet, *chosen, str(folder / "ropefric" / room))
    failed = [line.split()[1] for line in said.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return "" if not code else failed[0] if failed else said.strip()[-80:]


def _probed(folder: Path) -> tuple[int, str]:
    return _run(folder, str(Path(__file__).with_name("probe.py")), str(folder))


def fate(mutant: Mutant, expected: str) -> str:
    """Return what became of a mutant: the test that noticed it, "no result changed", or "MISSED"."""
    with tempfile.TemporaryDirectory() as name:
        folder = _copy(Path(name))
        (folder / mutant.path).write_text(mutant.text, encoding="utf-8")
        room = mutant.path.parts[1]
        noticed = _noticed(folder, room, its_own=True)
        if not noticed and _probed(folder)[1] == expected:
            return "no result changed"
        noticed = noticed or _noticed(folder, room, its_own=False)
        return f"noticed by {noticed}" if noticed else "MISSED"


def study(count: int, seed: int, jobs: int = 2, tell: Callable[[str], object] = print) -> tuple[int, int]:
    """Return how many of the mutants that change a result were noticed, and how many there were."""
    mutants = draw(count, seed)
    with tempfile.TemporaryDirectory() as name:
        folder = _copy(Path(name))
        code, expected = _probed(folder)
        failed = "the probe" if code else _noticed(folder, "", its_own=False)
        if failed:
            raise RuntimeError(f"{failed} fails on the unbroken project")
    noticed = counted = 0
    with ThreadPoolExecutor(jobs) as pool:
        for mutant, found in zip(mutants, pool.map(lambda one: fate(one, expected), mutants), strict=True):
            tell(f"{mutant}\n    {found}")
            counted += found != "no result changed"
            noticed += found.startswith("noticed")
    tell(f"{noticed} of {counted} that change a result were noticed; {count - counted} change none")
    return noticed, counted


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args()
    study(given.count, given.seed, given.jobs, lambda line: print(line, flush=True))
