"""From a scene file to a problem that can be planned and solved, or to everything that is wrong with it."""

import math
import os
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import (
    BY_NAME,
    PATH,
    DataError,
    InputError,
    Problem,
    RopefricError,
    data_error,
    raise_problems,
)
from ropefric.files.disk import kind_of_file
from ropefric.files.toml import TomlDocument, is_campaign, read_toml
from ropefric.files.toml_model import got, validate_document
from ropefric.fitting.predict import outside_range
from ropefric.fitting.result import FitResult
from ropefric.fitting.store import load_fit
from ropefric.friction.condition import SETTINGS, Conditions, one_condition
from ropefric.friction.laws import ALL_LAWS
from ropefric.plugins import load_named
from ropefric.quantities import parse_fraction, parse_quantity, si_unit_of
from ropefric.registry import did_you_mean
from ropefric.scenes.kind import Kind, SceneTable, Table, given, value_at
from ropefric.scenes.kinds import KINDS
from ropefric.shown import Shown
from ropefric.systems.friction import ScaleTo, WrapFriction

_HALF_A_TURN = math.pi
_USUAL_TENSION_N = 100.0


class FrictionSource(NamedTuple):
    """A friction law as a scene uses it, and how well it is known."""

    friction: WrapFriction
    origin: str
    tested: Mapping[str, tuple[float, float]] | None = None
    warnings: tuple[str, ...] = ()
    fit: FitResult | None = None


def cases_outside(
    tested: Mapping[str, tuple[float, float]], contacts: Mapping[str, FloatArray], n: int
) -> BoolArray:
    """Return which regressors leave the tested range at any contact of n cases, shape (n, 4).

    Contacts are those of the first case, then of the next, and so on; or those of one case, which all have.
    """
    outside = outside_range(tested, Conditions(**contacts))
    own = outside.reshape(n if len(outside) % n == 0 else 1, -1, outside.shape[1]).any(axis=1)
    return np.broadcast_to(own, (n, own.shape[1]))


def source_of(kind: Kind, scene: SceneTable, folder: Path) -> FrictionSource | None:
    """Return the friction that the `[friction]` of a checked scene names; None where there is none."""
    table = scene.friction
    if table is None:
        return None
    known: dict[str, Any] = {}
    if table.fit is not None:
        fit = load_fit(_find(table.fit, folder))
        law, theta, reference = ALL_LAWS[fit.law], np.asarray(fit.theta), _amid(fit)
        origin = f"{fit.law} fitted to {fit.statistics.n} trials ({Path(table.fit).name})"
        sound = fit.status.value == "ok"
        known = {
            "tested": {name: (float(low), float(high)) for name, (low, high) in fit.validity.items()},
            "fit": fit,
            "warnings": () if sound else (f"the fit's status is {fit.status.value}", *fit.advice),
        }
    else:
        reference = one_condition(*kind.own_wheel(scene), _HALF_A_TURN, _USUAL_TENSION_N)
        law = ALL_LAWS["constant" if table.law is None else table.law]
        theta = law.theta_from(table.parameters or {}) if table.mu is None else np.array([table.mu])
        values = ", ".join(f"{name} = {value:g}" for name, value in law.as_mapping(theta).items())
        origin = f"{law.name} with {values}" if table.mu is None else f"mu = {table.mu:g}"
    scale_to = None if table.scale_to is None else ScaleTo(**given(table.scale_to))
    if scale_to is not None:
        origin += f", scaled to mu = {scale_to.mu:g} over {math.degrees(scale_to.wrap_angle_rad):g} deg"
    own = {name: np.array([value]) for name, value in given(table.reference).items()}
    friction = WrapFriction(law=law, theta=theta, reference=replace(reference, **own), scale_to=scale_to)
    _ = friction.scale  # a law without an answer at the reference is refused here, not while solving
    return FrictionSource(friction=friction, origin=origin, **known)


def _find(name: str, folder: Path) -> Path:
    for place in (folder / name, Path(name)):
        if kind_of_file(place):
            return place
    raise DataError(
        f"there is no fit {name!r}, neither beside the scene nor in the folder of the command",
        key="friction.fit",
        fix="give the path of a file from fits/, relative to the scene",
    )


def _amid(fit: FitResult) -> Conditions:
    """Return the geometric middle of what was tested; a law changes by factors, not by differences."""
    middle = {name: np.sqrt([math.prod(fit.validity[name])]) for name in SETTINGS if name in fit.validity}
    try:
        return Conditions(**middle)
    except (TypeError, RopefricError):
        raise DataError(
            "the fit does not say at which conditions it was tested",
            key="friction.fit",
            fix="fit again: `ropefric fit TRIALS.csv --law NAME --out FIT.json`, or save_fit in Python",
        ) from None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Scene(Shown):
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
    tolerances : mapping of str to float
        By how much the value of a key may be off at most, in SI.
    """

    _said = ("system=kind.name", "accuracy", "effects", "folder")

    kind: Kind
    document: TomlDocument
    folder: Path
    table: SceneTable
    source: FrictionSource | None
    problem: Any
    tolerances: Mapping[str, float] = field(default_factory=dict)

    @property
    def accuracy(self) -> float:
        """Return the relative error wanted."""
        return self.table.accuracy

    @property
    def effects(self) -> str | tuple[str, ...]:
        """Return "auto", "all" or the effects asked for."""
        return self.table.effects


def load_scene(path: str | os.PathLike[str], changes: Mapping[str, Any] | None = None) -> Scene:
    r"""Return the scene of a TOML file, or of what it becomes with some of its keys changed.

    Parameters
    ----------
    path : path-like
        The file.
    changes : mapping of str to value, optional
        What keys shall say, as TOML has it: `{"wheel.wrap": "720 deg"}`; None takes a key out. The parts of a list count
        from 0: "element.1.angle".

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
    ...     longer = load_scene(Path(folder, "scene.toml"), {"wheel.wrap": "2 turn", "friction.mu": 0.3})
    >>> scene.kind.name, scene.accuracy, scene.effects, round(float(longer.problem.wrap_angle_rad[0]), 3)
    ('hoist', 0.01, 'auto', 12.566)
    """
    PATH.check(path=path)
    BY_NAME.check_given(changes=changes)
    document = read_toml(path, "scene file")
    if changes:
        data: Any = document.data
        for key, value in changes.items():
            data = replaced(data, key, value)
        document = replace(document, data=data)
    return read_scene(document, Path(path).parent)


def check_scene(path: str | os.PathLike[str]) -> tuple[Problem, ...]:
    """Return everything that is wrong with a scene file, by line; empty where it can be solved."""
    try:
        load_scene(path)
    except DataError as error:
        return error.problems
    return ()


def read_scene(document: TomlDocument, folder: Path) -> Scene:
    """Return the scene of a TOML tree."""
    raise_problems(load_named(document))
    kind = _kind(document)
    table, problems = validate_document(kind.schema, document)
    raise_problems(sorted((*problems, *_unknown_effects(kind, document)), key=lambda one: one.line or 0))
    if table is None:  # pragma: no cover - no table without an error would be our own mistake
        raise DataError("the scene cannot be read", path=document.path)
    tolerances = _tolerances(document, table)
    with placed(document):
        source = source_of(kind, table, folder)
        problem = kind.problem(table, None if source is None else source.friction)
    read: dict[str, Any] = {"document": document, "folder": folder, "table": table, "tolerances": tolerances}
    return Scene(kind=kind, source=source, problem=problem, **read)


@contextmanager
def placed(document: TomlDocument) -> Iterator[None]:
    """Turn the errors of a block into those of the scene file, with the lines of the keys they name."""
    try:
        yield
    except RopefricError as error:
        named = KINDS[document.data["system"]].scene_key
        problems = [
            document.problem(
                _path(document.data, named(problem.key)) if problem.key else (),
                problem.code,
                problem.message if not problem.path else f"{problem.where}: {problem.message}",
                fix=problem.fix,
            )
            for problem in error.problems
        ]
        raise data_error(problems) from error


def _path(tree: Any, key: str) -> tuple[str | int, ...]:
    """Return the parts of a key, those of lists as numbers."""
    path: list[str | int] = []
    for name in key.split("."):
        in_list = isinstance(tree, list) and name.isdecimal() and int(name) < len(tree)
        path.append(int(name) if in_list else name)
        tree = tree[path[-1]] if in_list else tree.get(name) if isinstance(tree, dict) else None
    return tuple(path)


def _kind(document: TomlDocument) -> Kind:
    name = document.data.get("system")
    if isinstance(name, str) and name in KINDS:
        return KINDS[name]
    if is_campaign(document.data):
        fix = f"use `ropefric run {document.path}`"
        raise data_error([document.problem((), "RF121", "this is a campaign, not a scene", fix=fix)])
    code, message, fix = "RF120", f"unknown system {name!r:.60}", did_you_mean(str(name), KINDS)
    if name is None:
        code, message, fix = "RF121", "'system' is missing", f'add system = "NAME", one of {", ".join(KINDS)}'
    raise data_error([document.problem(("system",), code, message, fix=fix)])


def _unknown_effects(kind: Kind, document: TomlDocument) -> tuple[Problem, ...]:
    asked, known = document.data.get("effects"), kind.system.effects
    names = enumerate(asked if isinstance(asked, list) else ())
    return tuple(
        document.problem(
            ("effects", place), "RF120", f"unknown {known.kind} {name!r}", fix=did_you_mean(name, known)
        )
        for place, name in names
        if isinstance(name, str) and name not in known
    )


def _tolerances(document: TomlDocument, table: SceneTable) -> dict[str, float]:
    """Return by how much the value of each key in `[tolerances]` may be off at most, in SI."""
    found, problems = {}, []
    numbers = number_keys(document, table)
    for key, written in leaves(table.tolerances):
        at = ("tolerances", *key.split("."))
        if key not in numbers:
            fix = did_you_mean(key, numbers)
            problems.append(document.problem(at, "RF120", f"the scene gives no number {key!r}", fix=fix))
            continue
        try:
            found[key] = _half_width(written, value_at(document.data, key), float(value_at(table, key)))
        except InputError as error:
            problems.append(document.problem(at, "RF110", error.problem.message, fix=error.problem.fix))
    raise_problems(problems)
    return found


def _half_width(written: Any, value: Any, value_si: float) -> float:
    """Return a tolerance in SI: in the unit of the value or in per cent of it."""
    unit = unit_of(value)[0] if isinstance(value, str) else ""
    if isinstance(written, str) and written.rstrip().endswith("%"):
        half = abs(value_si) * parse_fraction(written)
    elif unit and isinstance(written, str):
        half = parse_quantity(written, si_unit_of(unit), name="the tolerance")
    elif not isinstance(value, str) and isinstance(written, int | float) and not isinstance(written, bool):
        half = float(written)
    else:
        raise InputError(
            f"expected a tolerance written like its value, {value!r}, got {got(written)}",
            fix=f'write it like "1 {unit}" or "2 %"' if unit else "write it without unit",
        )
    if not 0.0 < half < math.inf:
        raise InputError(f"the tolerance is {got(written)}; it must be more than 0", fix="leave it out")
    return half


_NUMBER = re.compile(r"\s*+([+-]?[\d.]++(?:[eE][+-]?\d++)?)")


def unit_of(text: str) -> tuple[str, float]:
    """Return the unit of a quantity as written, and its number; 1 where there is none."""
    found = _NUMBER.match(text)
    return (text[found.end() :].strip(), float(found[1])) if found else (text, 1.0)


def leaves(tree: Any, prefix: str = "") -> list[tuple[str, Any]]:
    """Return the keys of a TOML tree that hold a value, with it."""
    found = []
    for name, value in enumerate(tree) if isinstance(tree, list) else tree.items():
        key = f"{prefix}.{name}" if prefix else str(name)
        inner = isinstance(value, dict) or (
            isinstance(value, list) and all(isinstance(one, dict) for one in value)
        )
        found += leaves(value, key) if inner else [(key, value)]
    return found


def replaced(tree: Any, key: str, value: Any) -> Any:
    """Return a TOML tree, or the table made from it, with another value at a key; it is not checked again.

    In a tree None takes the key out, and tables on the way to it are made where they are missing.
    """
    name, _, rest = key.partition(".")
    if isinstance(tree, list) and name.isdecimal() and int(name) < len(tree):
        place = int(name)
        return [*tree[:place], replaced(tree[place], rest, value) if rest else value, *tree[place + 1 :]]
    if not isinstance(tree, dict | Table):
        raise InputError(f"{key!r} is no key of the scene", key="changes", fix='write it like "wheel.wrap"')
    inner = value_at(tree, name)
    inner = replaced({} if inner is None else inner, rest, value) if rest else value
    if not isinstance(tree, dict):
        return tree.model_copy(update={name: inner})
    return {one: what for one, what in {**tree, name: inner}.items() if what is not None}


def number_keys(document: TomlDocument, table: SceneTable) -> tuple[str, ...]:
    """Return the keys of a scene that hold a number, with or without unit."""
    return tuple(
        key
        for key, _ in leaves(document.data)
        if isinstance(value_at(table, key), int | float)
        and key != "accuracy"
        and not key.startswith("tolerances.")
    )
