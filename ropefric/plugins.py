"""Plugins: a lab's own law, reader, outlier rule, protocol or machine, in a Python file that is asked for by name.

The file declares the same objects as ours under the same names, `LAW = FrictionLaw(...)`, `READER = Reader(...)`; they
stand in the same registries from then on. Nothing is ever loaded that nobody named: on the command line, in the campaign
or scene, or in Python.
"""

import hashlib
import re
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from ropefric.errors import PATH, PLUGIN_MODULE, DataError, Problem, RopefricError
from ropefric.executors import CARRIED
from ropefric.files.disk import read_file
from ropefric.files.toml import TomlDocument
from ropefric.registry import Registry, count_added, forget_added
from ropefric.shown import Shown

SLOTS = {
    "LAW": ("ropefric.friction.laws", "ALL_LAWS"),
    "READER": ("ropefric.traces.readers", "READERS"),
    "RULE": ("ropefric.trials.outliers", "RULES"),
    "PROTOCOL": ("ropefric.traces.protocols", "PROTOCOLS"),
    "KIND": ("ropefric.scenes.kinds", "KINDS"),
    "STUDY": ("ropefric.accuracy.studies", "STUDIES"),
}
"""Objects that a file may declare, and their registries. Named, not imported: the registries stand above this
room, and each is loaded when a plugin declares something for it."""

_SAFE = re.compile(r"[a-z0-9][a-z0-9_.-]{0,60}")
_LARGEST = 10_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Plugin(Shown):
    """A loaded plugin: what it was called by, its file and hash, and what it declares, as `"LAW two-term"`."""

    _said = ("source", "sha256", "declares")

    source: str
    path: Path
    sha256: str
    declares: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return what a result says of the plugins it was made with."""
        return {"file": self.source, "sha256": self.sha256, "declares": list(self.declares)}

    def __reduce__(self) -> tuple[Any, ...]:
        # Whoever unpickles it, such as a worker that was spawned, has it loaded.
        return load_plugin, (str(self.path), self.source)


_LOADED: list[Plugin] = []

TOLD: list[Callable[[str], None]] = []
"""Functions that are called before the code of a plugin runs that a file names."""


def loaded() -> tuple[Plugin, ...]:
    """Return the plugins that are loaded, in the order of loading."""
    return tuple(_LOADED)


CARRIED.append(loaded)


def provenance(*slots: str) -> list[dict[str, Any]]:
    """Return what results say of the loaded plugins; of those that declare something of these slots."""
    wanted = [one for one in _LOADED if not slots or any(said.split()[0] in slots for said in one.declares)]
    return [one.to_dict() for one in wanted]


def registry_of(slot: str) -> Registry[Any]:
    """Return the registry that takes in what a plugin declares under a name."""
    package, name = SLOTS[slot]
    registry: Registry[Any] = getattr(import_module(package), name)
    return registry


@contextmanager
def unloaded_after() -> Iterator[None]:
    """Forget at the end the plugins that are loaded within: those of one command are not those of the next."""
    plugins, members = list(_LOADED), count_added()
    try:
        yield
    finally:
        forget_added(members)
        _LOADED[:] = plugins


def load_plugin(source: str | Path, called: str = "") -> Plugin:
    r"""Load a plugin, a Python file.

    Parameters
    ----------
    source : str or path-like
        The file.
    called : str
        What provenance calls it; by default as it is named here.

    Returns
    -------
    Plugin
        Its file, hash, and what it declares. A file that is loaded already is not loaded again, unless it has changed.

    Raises
    ------
    DataError
        RF160 if it cannot be read or run, with its line; RF161 if it declares no such object; RF162 if a name is taken.

    Examples
    --------
    >>> import tempfile
    >>> text = "from dataclasses import replace\nfrom ropefric.friction.laws import LAWS\n"
    >>> text += "LAW = replace(LAWS['constant'], name='our-own')\n"
    >>> with unloaded_after(), tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(folder, "our_law.py").write_text(text)
    ...     load_plugin(Path(folder, "our_law.py")).declares
    ('LAW our-own',)
    """
    PATH.check(source=source)
    text = str(source)
    path, shown = Path(text).absolute(), called or Path(text).as_posix()
    content = read_file(path, shown=shown, limit=_LARGEST)
    sha256 = hashlib.sha256(content).hexdigest()
    for old in _LOADED:
        if old.path == path and old.sha256 == sha256:
            return old
    if any(old.path == path for old in _LOADED):  # it was edited: the others stay
        others = [old for old in _LOADED if old.path != path]
        forget_added()
        _LOADED.clear()
        for old in others:
            load_plugin(str(old.path), old.source)
    before = count_added()
    try:
        declares = tuple(_declared(_run(path, content, shown), content.decode("utf-8"), shown))
    except RopefricError:
        forget_added(before)
        raise
    plugin = Plugin(source=shown, path=path, sha256=sha256, declares=declares)
    _LOADED.append(plugin)
    return plugin


def load_named(document: TomlDocument) -> tuple[Problem, ...]:
    """Load the plugins that a campaign or scene names, relative to its file; return the problems."""
    given = document.data.get("plugins", [])
    problems: list[Problem] = []
    for name in given if isinstance(given, list) else []:
        if isinstance(name, str):  # all else is refused with the other keys
            place = Path(document.path).parent / name
            if all(one.source != name for one in _LOADED):
                for tell in TOLD:
                    tell(f"{document.path} names the plugin {name}, whose code runs now")
            try:
                load_plugin(place, name)
            except RopefricError as error:
                problems += error.problems
    return tuple(problems)


def _run(path: Path, content: bytes, shown: str) -> dict[str, Any]:
    """Run a plugin and return what it defines."""
    fix = "correct the file; `ropefric check-plugin` tries it by itself"
    try:
        module = ModuleType(f"{PLUGIN_MODULE}{path.stem}")
        module.__file__ = str(path)
        sys.modules[module.__name__] = module  # dataclasses look their module up
        exec(compile(content, str(path), "exec"), module.__dict__)  # noqa: S102  (what a plugin is for)
    except SyntaxError as error:
        text = f"the plugin is no Python: {error.msg}"
        raise DataError(text, code="RF160", path=shown, line=error.lineno, fix=fix) from None
    except (Exception, SystemExit) as error:
        frames = [
            one.lineno for one in traceback.extract_tb(error.__traceback__) if one.filename == str(path)
        ]
        text = f"the plugin cannot be loaded: {type(error).__name__}: {error}"
        line = frames[-1] if frames else None
        raise DataError(text, code="RF160", path=shown, line=line, fix=fix) from error
    return vars(module)


def _declared(names: dict[str, Any], text: str, shown: str) -> Iterator[str]:
    """Put what a plugin declares into the registries, and yield what that was."""
    found = [slot for slot in SLOTS if slot in names]
    if not found:
        fix = f"declare one of {', '.join(SLOTS)}: LAW = FrictionLaw(...)"
        raise DataError("the plugin declares nothing", code="RF161", path=shown, fix=fix)
    for slot in found:
        lines = enumerate(text.split("\n"), start=1)
        line = next((n for n, one in lines if one.split("=")[0].split(":")[0].rstrip() == slot), None)
        where: dict[str, Any] = {"path": shown, "line": line, "key": slot}
        registry = registry_of(slot)
        wanted = type(registry[next(iter(registry))])
        value = names[slot]
        for member in value if isinstance(value, tuple | list) else (value,):
            if not isinstance(member, wanted):
                why = f"{slot} is of type {type(member).__name__}, not {wanted.__name__}"
                fix = f"write {slot} = {wanted.__name__}(...), imported from {wanted.__module__}"
                raise DataError(why, code="RF161", **where, fix=fix)
            if not isinstance(member.name, str) or not _SAFE.fullmatch(member.name):
                why = f"the name {member.name!r:.60} cannot be used: it is part of file names and of command lines"
                raise DataError(
                    why, code="RF161", **where, fix="use small letters, digits and hyphens: two-term"
                )
            try:
                registry.add(member)
            except RopefricError as error:
                raise DataError(error.problem.message, code=error.code, fix=error.fix, **where) from None
            yield f"{slot} {member.name}"
