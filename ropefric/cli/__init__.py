"""The command line: presentation only. Every number it prints comes from the library.

`app` assembles the commands, runs one and turns failures into words and exit codes; `output` is where words, JSON,
tables and progress go; `options` has the parts that commands share: their answer, and the options for files, folders,
quantities and processes.
`commands` has the commands by subject: options, one call of the library, output.
"""

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from importlib.util import LazyLoader
from types import ModuleType


class _Lazily(MetaPathFinder):
    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        spec = PathFinder.find_spec(name, path, target) if name.startswith("ropefric.") else None
        if spec is not None and spec.loader is not None:
            spec.loader = LazyLoader(spec.loader)
        return spec


@contextmanager
def on_first_use() -> Iterator[None]:
    """Put off what modules imported within do until they are used: NumPy and pandas take long, a help needs none.

    Only whole modules wait (`from package import module`), and only where nothing of them is used yet: annotations
    that name them are quoted. A package whose `__init__` does something is better imported by the function that uses it:
    its submodules cannot be named without running it.
    """
    finder = _Lazily()
    sys.meta_path.insert(0, finder)
    try:
        yield
    finally:
        sys.meta_path.remove(finder)
