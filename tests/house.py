"""The size of the package, room by room: `python tests/house.py` prints it; the architecture test holds it.

Code is a line that is not blank, a comment or part of a docstring.
"""

import ast
import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "ropefric"


@dataclass
class Size:
    modules: int = 0
    code: int = 0
    docstrings: int = 0
    imports: int = 0
    dataclasses: int = 0
    largest: int = 0


def _is_list_of_names(node):
    return isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "__all__"


def measure_file(path):
    text = path.read_text(encoding="utf-8")
    size, docstrings, imports = Size(modules=1), set(), set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import | ast.ImportFrom) or _is_list_of_names(node):
            imports.update(range(node.lineno, node.end_lineno + 1))
        documented = isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef)
        if documented and ast.get_docstring(node, clean=False) is not None:
            docstrings.update(range(node.body[0].lineno, node.body[0].end_lineno + 1))
        if isinstance(node, ast.ClassDef):
            size.dataclasses += any("dataclass" in ast.unparse(one) for one in node.decorator_list)
    code = [
        number
        for number, line in enumerate(text.splitlines(), 1)
        if number not in docstrings and line.strip() and not line.strip().startswith("#")
    ]
    size.code = size.largest = len(code)
    size.docstrings, size.imports = len(docstrings), len(imports & set(code))
    return size


def rooms(package=PACKAGE):
    """Return the sizes of the rooms by name, largest first."""
    found = {}
    for path in sorted(package.rglob("*.py")):
        room = found.setdefault(path.relative_to(package).parts[0], Size())
        size = measure_file(path)
        for name in ("modules", "code", "docstrings", "imports", "dataclasses"):
            setattr(room, name, getattr(room, name) + getattr(size, name))
        room.largest = max(room.largest, size.largest)
    return dict(sorted(found.items(), key=lambda item: -item[1].code))


def stated(changelog=ROOT / "CHANGELOG.md"):
    """Return the (modules, code lines) of each room that the changelog states."""
    lines = re.findall(
        r"^\| `([\w./]+)` \| (\d+) \| (\d+) \|$", changelog.read_text(encoding="utf-8"), re.MULTILINE
    )
    return {room: (int(modules), int(code)) for room, modules, code in lines}


def table(sizes):
    """Return the rooms as the table of the changelog."""
    rows = [f"| `{name}` | {size.modules} | {size.code} |" for name, size in sizes.items()]
    return "\n".join(["| room | modules | code lines |", "|---|---|---|", *rows])


def total(sizes):
    """Return the figures of the whole in one line."""
    sums = {
        name: sum(getattr(size, name) for size in sizes.values())
        for name in ("modules", "code", "docstrings", "imports", "dataclasses")
    }
    return (
        f"modules {sums['modules']}, code {sums['code']}, docstrings {sums['docstrings']}, "
        f"imports {sums['imports'] / sums['code']:.1%} of the code, dataclasses {sums['dataclasses']}, "
        f"largest module {max(size.largest for size in sizes.values())}"
    )


if __name__ == "__main__":
    measured = rooms()
    print(table(measured))
    print(total(measured))
