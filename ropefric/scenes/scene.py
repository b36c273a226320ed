"""From a scene file to a problem that can be planned and solved, or to everything that is wrong with it."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ropefric.errors import DataError, Problem, RopefricError, data_error, raise_problems
from ropefric.files.toml import TomlDocument, is_campaign, read_toml
from ropefric.files.toml_model import validate_document
from ropefric.registry import did_you_mean
from ropefric.scenes.friction_source import FrictionSource, friction_source
from ropefric.scenes.kind import Kind
from ropefric.scenes.kinds import KINDS
from ropefric.scenes.schema import SceneTable


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Scene:
    """A scene, read and understood.

    Attributes
    ----------
    kind : Kind
        Which system it is of.
    document : TomlDocument
        What the file says.
    table : SceneTable
        The same, checked, in SI.
    source : FrictionSource or None
        Its friction, and how well that is known.
    problem : object
        What its system solves.
    folder : Path
        Where the file is.
    """

    kind: Kind
    document: TomlDocument
    folder: Path
    table: SceneTable
    source: FrictionSource | None
    problem: Any

    @property
    def accuracy(self) -> float:
        """Return the relative error wanted."""
        return self.table.accuracy

    @property
    def effects(self) -> str | tuple[str, ...]:
        """Return "auto", "all" or the effects asked for."""
        asked: str | tuple[str, ...] = self.table.effects
        return asked


def load_scene(path: str | os.PathLike[str]) -> Scene:
    r"""Return the scene of a TOML file.

    Parameters
    ----------
    path : path-like
        The file.

    Raises
    ------
    DataError
        With everything that is wrong in `.problems`, each with its line.

    Examples
    --------
    >>> import tempfile
    >>> text = '''system = "hoist"
    ... wheel = { radius = "40 mm", wrap = "540 deg" }
    ... rope = { diameter = "9.8 mm" }
    ... load = { end_tension = "80 N" }
    ... friction = { mu = 0.2 }'''
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(folder, "scene.toml").write_text(text)
    ...     scene = load_scene(Path(folder, "scene.toml"))
    >>> scene.kind.name, scene.accuracy, scene.effects
    ('hoist', 0.01, 'auto')
    """
    return read_scene(read_toml(path, "scene file"), Path(path).parent)


def check_scene(path: str | os.PathLike[str]) -> tuple[Problem, ...]:
    """Return everything that is wrong with a scene file, by line; empty where it can be solved."""
    try:
        load_scene(path)
    except DataError as error:
        return error.problems
    return ()


def read_scene(document: TomlDocument, folder: Path) -> Scene:
    """Return the scene of a TOML tree."""
    kind = _kind(document)
    table, problems = validate_document(kind.schema, document)
    raise_problems(sorted((*problems, *_unknown_effects(kind, document)), key=lambda one: one.line or 0))
    if table is None:  # pragma: no cover - no table without an error would be our own mistake
        raise DataError("the scene cannot be read", path=document.path)
    try:
        source = source_of(kind, table, folder)
        problem = kind.problem(table, None if source is None else source.friction)
    except RopefricError as error:
        raise placed(error, document) from error
    return Scene(kind=kind, document=document, folder=folder, table=table, source=source, problem=problem)


def placed(error: RopefricError, document: TomlDocument) -> DataError:
    """Return an error as one of the scene file, with the lines of the keys it names."""
    named = KINDS[document.data["system"]].scene_key
    problems = [
        document.problem(
            tuple(named(problem.key).split(".")) if problem.key else (),
            problem.code,
            problem.message if not problem.path else f"{problem.where}: {problem.message}",
            fix=problem.fix,
        )
        for problem in error.problems
    ]
    return data_error(problems)


def _kind(document: TomlDocument) -> Kind:
    name = document.data.get("system")
    if isinstance(name, str) and name in KINDS:
        return KINDS[name]
    if is_campaign(document.data):
        fix = f"use `ropefric run {document.path}`"
        raise_problems([document.problem((), "RF121", "this is a campaign, not a scene", fix=fix)])
    if name is None:
        message, fix = "'system' is missing", f'add system = "{next(iter(KINDS))}" ({", ".join(KINDS)})'
        code = "RF121"
    else:
        message, fix = f"unknown system {name!r:.60}", did_you_mean(str(name), KINDS)
        code = "RF120"
    raise_problems([document.problem(("system",), code, message, fix=fix)])
    raise AssertionError  # pragma: no cover - an error is always raised above


def _unknown_effects(kind: Kind, document: TomlDocument) -> tuple[Problem, ...]:
    asked = document.data.get("effects")
    known = kind.system.effects
    if not isinstance(asked, list):
        return ()
    return tuple(
        document.problem(
            ("effects", place), "RF120", f"unknown {known.kind} {name!r}", fix=did_you_mean(name, known)
        )
        for place, name in enumerate(asked)
        if isinstance(name, str) and name not in known
    )


def source_of(kind: Kind, table: SceneTable, folder: Path) -> FrictionSource | None:
    """Return the friction that a checked table names; None where it names none."""
    if table.friction is None:
        return None
    wheel_radius_m, rope_radius_m = kind.own_wheel(table)
    return friction_source(table.friction, folder, wheel_radius_m=wheel_radius_m, rope_radius_m=rope_radius_m)
