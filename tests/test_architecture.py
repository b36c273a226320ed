"""The house: imports go downward, libraries stay in their rooms, importing stays light, nothing grows crooked."""

import ast
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "ropefric"
MODULES = sorted(PACKAGE.rglob("*.py"))

MOST_LINES, MOST_OF_A_MODULE = 37_100, 500
"""Lines of code, in all and of a module: those that are not blank, comment or part of a docstring."""
MOST_COMPLEX = 20
"""Branches of a function."""

LEVELS = {
    "arrays": 0, "errors": 0, "executors": 0, "glossary": 0, "quantities": 0, "registry": 0, "section": 0,
    "shown": 0,
    "files": 1, "friction": 1, "uncertainty": 1,
    "traces": 2, "systems": 2, "plugins": 2,
    "trials": 3, "rig": 3,
    "fitting": 4, "given": 4,
    "scenes": 5,
    "pipeline": 6, "accuracy": 6, "testing": 6, "training": 6,
    "plotting": 7,
    "report": 8,
    "page": 9,
    "cli": 10, "api": 10,
}  # fmt: skip
# The package's own face and its `python -m` door stand outside the house: they may look at everything.
DOORS = {"__init__", "__main__"}

TO_BE_REBUILT: set[str] = set()
"""Functions of rooms that are rebuilt next, more complex than any other may be."""

ONLY_IN = {
    "lmfit": "fitting", "matplotlib": "plotting", "pint": "quantities", "typer": "cli", "rich": "cli",
    "torch": "training",
}  # fmt: skip


def room_of(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


@cache
def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


STATEMENTS = (ast.Import, ast.ImportFrom, ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


@cache
def all_nodes(path: Path) -> dict[type[ast.AST], list[ast.AST]]:
    """All statements that are looked at, by their kind; expressions hold none."""
    found: dict[type[ast.AST], list[ast.AST]] = {}
    todo: list[ast.AST] = [tree_of(path)]
    while todo:
        node = todo.pop()
        if isinstance(node, STATEMENTS):
            found.setdefault(type(node), []).append(node)
        todo += (one for one in ast.iter_child_nodes(node) if not isinstance(one, ast.expr))
    return found


def nodes_of(path: Path, *kinds: type[ast.AST]) -> list[ast.AST]:
    return [node for kind in kinds for node in all_nodes(path).get(kind, [])]


@cache
def imported_names(path: Path) -> tuple[str, ...]:
    """Every imported module, function-level imports included; `from a import b` gives both a and a.b."""
    names: list[str] = []
    for node in nodes_of(path, ast.Import, ast.ImportFrom):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        else:
            assert node.level == 0, f"{path}: relative import"
            names += [str(node.module), *(f"{node.module}.{alias.name}" for alias in node.names)]
    return tuple(names)


def test_every_module_has_a_level_and_imports_only_downward():
    for path in MODULES:
        room = room_of(path)
        if room in DOORS:
            continue
        assert room in LEVELS, f"{room} has no level"
        for name in imported_names(path):
            parts = name.split(".")
            if parts[0] != "ropefric" or len(parts) == 1 or parts[1] == "__version__":
                continue
            other = parts[1]
            assert other in LEVELS, f"{path} imports {name}, which has no level"
            same_room = other == room or LEVELS[other] == LEVELS[room] == 0  # the ground floor is one room
            assert same_room or LEVELS[other] < LEVELS[room], f"{path} imports upward: {name}"


def test_libraries_stay_in_their_rooms():
    for path in MODULES:
        for name in imported_names(path):
            library = name.split(".")[0]
            if library in ONLY_IN:
                assert room_of(path) == ONLY_IN[library], f"{path} imports {library}"
        assert path.name != "utils.py"


def graph() -> dict[str, set[str]]:
    names = {".".join(p.relative_to(ROOT).with_suffix("").parts): p for p in MODULES}
    edges = {}
    for module, path in names.items():
        targets = set()
        for name in imported_names(path):
            targets |= {name, f"{name}.__init__"} & names.keys()
        edges[module] = targets - {module}
    return edges


def test_there_is_no_import_cycle():
    edges = graph()
    done, path = set(), []

    def visit(module):
        assert module not in path, f"cycle: {' -> '.join([*path, module])}"
        if module in done:
            return
        path.append(module)
        for target in edges[module]:
            visit(target)
        path.pop()
        done.add(module)

    for module in edges:
        visit(module)


def test_top_level_is_fixed():
    allowed = {
        "pyproject.toml",
        "ropefric",
        "data",
        "docs",
        "fits",
        "tests",
        "notebooks",
        "README.md",
        "CITATION.cff",
        "CODE_OF_CONDUCT.md",
        "CONTRIBUTING.md",
        "LICENSE",
        "SECURITY.md",
        "CHANGELOG.md",
    }
    git = shutil.which("git")
    if git is None:
        pytest.skip("git says which files belong to the project")
    tracked = subprocess.run([git, "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False).stdout
    if not tracked:
        pytest.skip("this is no checkout")
    tops = {line.split("/")[0] for line in tracked.splitlines()}
    assert not {top for top in tops - allowed if not top.startswith(".")}


def test_import_stays_light():
    code = (
        "import sys, ropefric\n"
        "heavy = {'pandas', 'matplotlib', 'lmfit', 'scipy', 'pint', 'pydantic', 'typer'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT)


def code_lines(path: Path) -> int:
    docstrings: set[int] = set()
    for node in nodes_of(path, ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef):
        if ast.get_docstring(node, clean=False) is not None:
            docstrings.update(range(node.body[0].lineno, node.body[0].end_lineno + 1))
    lines = enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
    return sum(1 for n, line in lines if n not in docstrings and line.strip() and line.strip()[0] != "#")


BRANCHING = (
    ast.If, ast.For, ast.AsyncFor, ast.While, ast.ExceptHandler, ast.IfExp, ast.Assert, ast.match_case,
)  # fmt: skip


def branches(function: ast.AST) -> int:
    """Branches of a function, those of functions in it apart."""
    count, todo = 1, list(ast.iter_child_nodes(function))
    while todo:
        node = todo.pop()
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            continue
        if isinstance(node, BRANCHING):
            count += 1
        elif isinstance(node, ast.BoolOp):
            count += len(node.values) - 1
        elif isinstance(node, ast.comprehension):
            count += 1 + len(node.ifs)
        todo.extend(ast.iter_child_nodes(node))
    return count


def test_the_house_stays_small():
    sizes = {path: code_lines(path) for path in MODULES}
    assert sum(sizes.values()) <= MOST_LINES
    assert not {path: lines for path, lines in sizes.items() if lines > MOST_OF_A_MODULE}


def test_no_function_grows_crooked():
    crooked = {
        f"{path.relative_to(PACKAGE).as_posix()} {node.name}"
        for path in MODULES
        for node in nodes_of(path, ast.FunctionDef, ast.AsyncFunctionDef)
        if branches(node) > MOST_COMPLEX
    }
    assert crooked <= TO_BE_REBUILT


def test_each_room_has_a_map():
    """What comes in, what goes out and which file does what stands where a newcomer looks first."""
    for folder in sorted(path.parent for path in PACKAGE.glob("*/__init__.py")):
        words = ast.get_docstring(tree_of(folder / "__init__.py")) or ""
        missing = [
            path.stem
            for path in sorted(folder.glob("*.py"))
            if not path.stem.startswith("_") and path.stem not in words
        ]
        assert not missing, f"{folder.name}/__init__.py says nothing of {missing}"
