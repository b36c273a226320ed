"""A scene solved over a grid of its own numbers: in one call where the system allows, point by point elsewhere.

An axis is a key of the scene and the values it is to take; the answers are a table, written as CSV fast because it
may have a million rows.
"""

import math
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import product
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray, IntArray
from ropefric.errors import InputError, RopefricError, UnknownNameError
from ropefric.files.folder import Folder
from ropefric.files.plain_text import csv_cell, csv_text
from ropefric.files.toml import TomlDocument
from ropefric.registry import did_you_mean
from ropefric.scenes.kind import Failure, Quantity
from ropefric.scenes.plan import Plan, make_plan
from ropefric.scenes.scene import Scene, read_scene, source_of

MOST_POINTS = 10_000_000
"""Of an axis, and of a whole grid: some 2.5 GB."""
_NUMBER = re.compile(r"\s*+([+-]?[\d.]++(?:[eE][+-]?\d++)?)")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Axis:
    """A key of a scene and its values."""

    key: str
    values: FloatArray
    unit: str
    factor: float


def parse_axis(scene: Scene, text: str) -> Axis:
    """Return the axis that "KEY=START:STOP:COUNT" or "KEY=A,B,C" asks for."""
    key, equals, asked = (part.strip() for part in text.partition("="))
    if not equals or not key or not asked:
        raise InputError(
            f"--sweep {text!r} is not KEY=START:STOP:COUNT or KEY=A,B,C",
            key="--sweep",
            fix='write it like  --sweep "wheel.wrap=90deg:1440deg:50"',
        )
    known = scalar_keys(scene)
    if key not in known:
        raise UnknownNameError(
            f"the scene gives no number {key!r} that could be swept",
            key="--sweep",
            fix=f"{did_you_mean(key, known)}; a key that the scene leaves out must be written into it first",
        )
    texts, between = [part.strip() for part in asked.split(":" if ":" in asked else ",")], None
    if ":" in asked:
        texts, between = texts[:2], _between(asked, texts[2:])
    values = np.array([_si(scene, key, part) for part in texts])
    # The unit is that of the last value.
    found, si_value = _NUMBER.match(texts[-1]), float(values[-1])
    unit = texts[-1][found.end() :].strip() if found else texts[-1]
    written = float(found[1]) if found else 1.0
    factor = si_value / written if unit and written else 1.0
    if between is not None:
        spaced, count = between
        if spaced == "log" and not (values > 0.0).all():
            raise InputError(f"{asked!r} has no equal ratios: both ends must be positive", key="--sweep")
        values = (np.geomspace if spaced == "log" else np.linspace)(values[0], values[1], count)
    return Axis(key=key, values=values, unit=unit, factor=factor)


def _between(asked: str, parts: list[str]) -> tuple[str, int]:
    """Return how the values of a range are spaced, and how many there are."""
    count, spaced = parts if len(parts) == 2 else ("".join(parts[:1]), "linear")
    counted = int(count) if len(parts) <= 2 and count.isdecimal() and len(count) < 20 else 0
    if not 2 <= counted <= MOST_POINTS or spaced not in {"linear", "log"}:
        raise InputError(
            f"{asked!r} is not START:STOP:COUNT with a count from 2 to {MOST_POINTS}",
            key="--sweep",
            fix="write it like  90deg:1440deg:50  or, in equal ratios,  90deg:1440deg:50:log",
        )
    return spaced, counted


def _si(scene: Scene, key: str, text: str) -> float:
    """Return a value in SI, read and checked by the scene itself."""
    now = _at(scene.document.data, key)
    try:
        written = text if isinstance(now, str) else float(text)
    except ValueError:
        raise InputError(
            f"{key}: {text!r} is no number", key="--sweep", fix="write it without unit"
        ) from None
    data = _replaced(scene.document.data, key, written)
    changed = read_scene(TomlDocument(path=scene.document.path, data=data, lines={}), scene.folder)
    return float(_at(changed.table, key))


def scalar_keys(scene: Scene) -> tuple[str, ...]:
    """Return the keys of a scene that hold a number, with or without unit."""
    return tuple(
        key
        for key, _ in _leaves(scene.document.data)
        if isinstance(_at(scene.table, key), int | float) and key != "accuracy"
    )


def _leaves(tree: Any, prefix: str = "") -> list[tuple[str, Any]]:
    found = []
    for name, value in tree.items():
        key = f"{prefix}.{name}" if prefix else str(name)
        found += _leaves(value, key) if isinstance(value, dict) else [(key, value)]
    return found


def _at(tree: Any, key: str) -> Any:
    """Return what stands at a key of a TOML tree or of the table made from it; None where nothing does."""
    for name in key.split("."):
        tree = tree.get(name) if isinstance(tree, dict) else getattr(tree, name, None)
    return tree


def _replaced(tree: Any, key: str, value: Any) -> Any:
    """Return a TOML tree, or the table made from it, with another value at a key; it is not checked again."""
    name, _, rest = key.partition(".")
    inner = {name: _replaced(_at(tree, name), rest, value) if rest else value}
    return {**tree, **inner} if isinstance(tree, dict) else tree.model_copy(update=inner)


_BLOCK = 50_000
_PLANNED_POINTS = 1000
"""Up to here a grid gets a plan of its own; beyond, bounding the effects would cost more than simulating them."""

Progress = Callable[[int, int, str], None]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sweep:
    """The answers over a grid.

    Attributes
    ----------
    axes : tuple of Axis
        The grid; the last axis runs fastest.
    columns : mapping of str to ndarray, shape (points,)
        The numbers of the answer, NaN where a point has none.
    failed : int
        How many points have no answer.
    first_failure : str
        What the first of them says.
    simulated : tuple of str
        Effects in the model, wherever on the grid.
    error_bound : float
        The largest of all points.
    accuracy : float
        What was wanted.
    failures : mapping of str to int
        At how many points the machine does not do what it is for, by what it does not do.
    """

    axes: tuple[Axis, ...]
    columns: dict[str, FloatArray]
    failed: int
    first_failure: str
    simulated: tuple[str, ...]
    error_bound: float
    accuracy: float = math.inf
    failures: dict[str, int] = field(default_factory=dict)

    @property
    def keeps_accuracy(self) -> bool:
        """Return whether the error bound is within the accuracy wanted at every point."""
        return self.error_bound <= self.accuracy

    @property
    def warnings(self) -> tuple[str, ...]:
        """Return what speaks against using the answers, and where the machine does not do what it is for."""
        total = prod(self.shape)
        found = [f"at {n} of {total} points {words}" for words, n in self.failures.items()]
        if not self.keeps_accuracy:
            bound = "not known" if math.isinf(self.error_bound) else f"up to {self.error_bound:.2g}"
            found.append(f"the error is {bound} at some points, more than the accuracy of {self.accuracy:g}")
        return tuple(found)

    @property
    def shape(self) -> tuple[int, ...]:
        """Return the lengths of the axes."""
        return tuple(axis.values.size for axis in self.axes)


def sweep_scene(scene: Scene, axes: tuple[Axis, ...], *, progress: Progress | None = None) -> Sweep:
    """Return the numbers of a scene's answer over the grid of all axes."""
    keys = [axis.key for axis in axes]
    if not keys or len(set(keys)) < len(keys):
        raise InputError("a sweep takes at least one key, and each key once", key="--sweep")
    shape = tuple(axis.values.size for axis in axes)
    total = prod(shape)
    if total > MOST_POINTS:
        raise InputError(
            f"a grid of {' × '.join(map(str, shape))} is {total} points; the limit is {MOST_POINTS}",
            key="--sweep",
            fix="ask for fewer values of each key",
        )
    columns: dict[str, FloatArray] = {}
    failed, first_failure, error_bound = 0, "", 0.0
    simulated: set[str] = set()
    failures: Counter[str] = Counter()
    for places, found in _outcomes(scene, axes, total, progress):
        if isinstance(found, RopefricError):
            failed += places.size
            first_failure = first_failure or found.problem.message
            continue
        plan, quantities, ways = found
        for quantity in quantities:
            columns.setdefault(quantity.name, np.full(total, np.nan))[places] = quantity.value
        simulated.update(plan.simulated)
        error_bound = max(error_bound, plan.error_bound)
        for way in ways:
            failures[way.words] += int(way.fails.sum())
    if failed == total:
        raise InputError(
            f"no point of the sweep has an answer; the first says: {first_failure}",
            code="RF503",
            key="--sweep",
            fix="sweep over values that this scene can take",
        )
    return Sweep(
        axes=axes,
        columns=columns,
        failed=failed,
        first_failure=first_failure,
        simulated=tuple(name for name in scene.kind.system.effects if name in simulated),
        error_bound=error_bound,
        accuracy=scene.accuracy,
        failures=dict(+failures),
    )


Outcome = tuple[Plan, tuple[Quantity, ...], tuple[Failure, ...]] | RopefricError
Build = Callable[[list[FloatArray]], Any]
"""Returns the problem of some points from the values of all axes there."""


def _outcomes(
    scene: Scene, axes: tuple[Axis, ...], total: int, progress: Progress | None
) -> Iterator[tuple[IntArray, Outcome]]:
    """Yield what the points give, block by block; point by point where a key does not go in one call."""
    kind = scene.kind
    shape = tuple(axis.values.size for axis in axes)
    fields = [kind.sweep_fields.get(axis.key) for axis in axes]
    by_array = None not in fields and kind.in_one_call(scene.problem)
    effects = "all" if by_array and scene.effects == "auto" and total > _PLANNED_POINTS else scene.effects

    def build(values: list[FloatArray]) -> Any:
        if by_array:
            swept = {one.field: one.factor * value for one, value in zip(fields, values, strict=True) if one}
            return replace(scene.problem, **swept)
        table = scene.table
        for axis, value in zip(axes, values, strict=True):
            table = _replaced(table, axis.key, float(value[0]))
        source = source_of(kind, table, scene.folder)
        return kind.problem(table, None if source is None else source.friction)

    size = _BLOCK if by_array else 1
    for start in range(0, total, size):
        places = np.arange(start, min(start + size, total))
        grid = np.unravel_index(places, shape)
        values = [axis.values[place] for axis, place in zip(axes, grid, strict=True)]
        possible = kind.answerable(build(values)) if by_array else np.ones(1, dtype=np.bool_)
        # Of the points that cannot have an answer one is solved, to hear why not.
        hopeless = np.flatnonzero(~possible)
        for some in (hopeless[:1], np.flatnonzero(possible)):
            if some.size:
                yield from _solved(scene, build, places[some], [value[some] for value in values], effects)
        if hopeless.size > 1:
            yield places[hopeless[1:]], InputError("there is no answer")
        if progress is not None:
            progress(int(places[-1]) + 1, total, "points")


def _solved(
    scene: Scene, build: Build, places: IntArray, values: list[FloatArray], effects: str | tuple[str, ...]
) -> Iterator[tuple[IntArray, Outcome]]:
    """Yield what points give, solved in one call; where one has no answer, the block is halved until it stands alone."""
    kind = scene.kind
    try:
        problem = build(values)
        plan, model = make_plan(kind.system, problem, accuracy=scene.accuracy, effects=effects)
        answer = kind.system.solve(model, plan.method)
        yield places, (plan, kind.quantities(answer, problem), kind.failures(answer, problem))
    except RopefricError as error:
        if places.size == 1:
            yield places, error
            return
        for half in np.array_split(np.arange(places.size), 2):
            yield from _solved(scene, build, places[half], [value[half] for value in values], effects)


def header_of(sweep: Sweep) -> tuple[str, ...]:
    """Return the columns of a sweep's table: the swept keys with their units, then the numbers of the answer."""
    keys = (f"{axis.key} [{axis.unit}]" if axis.unit else axis.key for axis in sweep.axes)
    return (*keys, *sweep.columns)


def write_sweep(sweep: Sweep, folder: Folder, name: str) -> Path:
    """Write a sweep as CSV, one row a point, the last axis fastest; return the path.

    Swept values stand in the unit in which they were asked for; a point without an answer has empty cells.
    """
    # An axis has few values, so each is put into words once.
    words = [[f"{value / axis.factor:.10g}," for value in axis.values] for axis in sweep.axes]
    cells = ",".join(["%.9g"] * len(sweep.columns)) + "\n"
    lines = [word + cells for word in words[-1]]
    values = np.stack(list(sweep.columns.values()), axis=-1)
    with folder.stream(name) as stream:
        stream.write(csv_text([map(csv_cell, header_of(sweep))]).encode())
        for place, outer in enumerate(product(*words[:-1])):
            for start in range(0, len(lines), _BLOCK):
                rows = lines[start : start + _BLOCK]
                first = place * len(lines) + start
                stream.write(_rows("".join(outer), rows, values[first : first + len(rows)]).encode())
    return folder.path / name


def columns_text(columns: Mapping[str, FloatArray]) -> str:
    """Return columns of one length as CSV."""
    values = np.stack(list(columns.values()), axis=-1)
    row = ",".join(["%.9g"] * len(columns)) + "\n"
    return csv_text([map(csv_cell, columns)]) + _rows("", [row] * len(values), values)


def _rows(outer: str, rows: list[str], values: FloatArray) -> str:
    """Return the rows of one block: what stands before all of them, and after it each row's template filled in."""
    text: str = outer.join(["", *rows]) % tuple(values.ravel().tolist())
    return text.replace("nan", "") if np.isnan(values).any() else text
