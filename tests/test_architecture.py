"""The house: imports go downward, libraries stay in their rooms, importing stays light."""

import ast
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(Path(__file__).parent))
import house  # noqa: E402

PACKAGE = ROOT / "ropefric"
MODULES = sorted(PACKAGE.rglob("*.py"))

LEVELS = {
    "arrays": 0, "errors": 0, "executors": 0, "glossary": 0, "quantities": 0, "registry": 0, "section": 0,
    "shown": 0,
    "files": 1, "friction": 1, "uncertainty": 1,
    "traces": 2, "systems": 2, "plugins": 2,
    "trials": 3, "rig": 3,
    "fitting": 4, "given": 4,
    "scenes": 5,
    "pipeline": 6, "accuracy": 6, "contracts": 6, "papers": 6,
    "plotting": 7,
    "report": 8,
    "review": 9,
    "cli": 10, "api": 10,
}  # fmt: skip
# The package's own face and its `python -m` door stand outside the house: they may look at everything.
DOORS = {"__init__", "__main__"}

ONLY_IN = {"lmfit": "fitting", "matplotlib": "plotting", "pint": "quantities", "typer": "cli", "rich": "cli"}


def room_of(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


@cache
def imported_names(path: Path) -> tuple[str, ...]:
    """Every imported module, function-level imports included; `from a import b` gives both a and a.b."""
    names: list[str] = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            names += [str(node.module), *(f"{node.module}.{alias.name}" for alias in node.names)]
    return tuple(names)


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(ROOT)))
def test_every_module_has_a_level_and_imports_only_downward(path):
    room = room_of(path)
    if room in DOORS:
        return
    assert room in LEVELS, f"{room} has no level"
    for name in imported_names(path):
        parts = name.split(".")
        if parts[0] != "ropefric" or len(parts) == 1 or parts[1] == "__version__":
            continue
        other = parts[1]
        assert other in LEVELS, f"{path.name} imports {name}, which has no level"
        same_room = other == room or LEVELS[other] == LEVELS[room] == 0  # the ground floor is one room
        assert same_room or LEVELS[other] < LEVELS[room], f"{path.name} imports upward: {name}"


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(ROOT)))
def test_libraries_stay_in_their_rooms(path):
    for name in imported_names(path):
        library = name.split(".")[0]
        if library in ONLY_IN:
            assert room_of(path) == ONLY_IN[library], f"{path.name} imports {library}"
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
        "CHANGELOG.md",
    }
    tracked = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False
    ).stdout.splitlines()
    tops = {line.split("/")[0] for line in tracked}
    assert not {top for top in tops - allowed if not top.startswith(".")}


def test_import_stays_light():
    code = (
        "import sys, ropefric\n"
        "heavy = {'pandas', 'matplotlib', 'lmfit', 'scipy', 'pint', 'pydantic', 'typer'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT)


def test_no_room_grows_past_what_the_changelog_states(capsys):
    sizes, stated = house.rooms(), house.stated()
    with capsys.disabled():
        print(f"\n{house.total(sizes)}")  # noqa: T201
    assert sizes.keys() == stated.keys()
    for name, size in sizes.items():
        modules, code = stated[name]
        assert size.modules <= modules, f"{name}: {size.modules} modules, {modules} stated in CHANGELOG.md"
        assert size.code <= code, f"{name}: {size.code} lines of code, {code} stated in CHANGELOG.md"
        assert size.largest <= 500, f"{name}: a module of {size.largest} lines of code"


def test_each_room_has_a_map():
    """What comes in, what goes out and which file does what stands where a newcomer looks first."""
    for folder in sorted(path.parent for path in PACKAGE.glob("*/__init__.py")):
        words = ast.get_docstring(ast.parse((folder / "__init__.py").read_text(encoding="utf-8"))) or ""
        missing = [
            path.stem
            for path in sorted(folder.glob("*.py"))
            if not path.stem.startswith("_") and path.stem not in words
        ]
        assert not missing, f"{folder.name}/__init__.py says nothing of {missing}"
