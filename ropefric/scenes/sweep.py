"""A scene solved over a grid of its own numbers: in one call where the system allows, point by point elsewhere.

An axis is a key of the scene and the values it is to take; the answers are a table, written block by block because it
may have millions of rows.
"""

import math
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from importlib import import_module
from math import prod
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np

from ropefric.arrays import BoolArray, FloatArray, IntArray
from ropefric.errors import InputError, RopefricError, UnknownNameError
from ropefric.files.folder import Folder
from ropefric.files.plain_text import csv_cell, csv_text
from ropefric.files.toml import TomlDocument
from ropefric.registry import did_you_mean
from ropefric.scenes.kind import Failure, Quantity
from ropefric.scenes.plan import make_plan, room_for_effects, worth_asking
from ropefric.scenes.scene import Scene, read_scene, source_of
from ropefric.systems.effect import Effect, assemble

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
_LEVELS = {1: 9, 2: 5, 3: 4, 4: 3}
"""Values of each axis at which the box of a sweep is looked at, by how many axes there are; more have two."""
_BETWEEN = 2.0
"""What an effect may change between the levels, over what it changes at them."""

_LEAST_SAVED_S = 5e-2
"""An effect that takes less than this over the whole grid is not worth solving the box without it."""

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
    left_out : mapping of str to int
        At how many points an effect was left out.
    steps : tuple of int
        `columns` has every so many-th value of each axis; all where it is empty.
    ranges : mapping of str to tuple of float
        The least and the largest of each number over all points.
    """

    axes: tuple[Axis, ...]
    columns: dict[str, FloatArray]
    failed: int
    first_failure: str
    simulated: tuple[str, ...]
    error_bound: float
    accuracy: float = math.inf
    failures: dict[str, int] = field(default_factory=dict)
    left_out: dict[str, int] = field(default_factory=dict)
    steps: tuple[int, ...] = ()
    ranges: dict[str, tuple[float, float]] = field(default_factory=dict)

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

    @property
    def kept(self) -> tuple[Axis, ...]:
        """Return the grid of `columns`."""
        steps = self.steps or (1,) * len(self.axes)
        return tuple(
            replace(axis, values=axis.values[::step]) for axis, step in zip(self.axes, steps, strict=True)
        )


def sweep_scene(
    scene: Scene,
    axes: tuple[Axis, ...],
    *,
    progress: Progress | None = None,
    table: "SweepTable | None" = None,
    keep: int = MOST_POINTS,
) -> Sweep:
    """Return the numbers of a scene's answer over the grid of all axes.

    They are solved block by block, so that memory stays flat: each goes to the `table` that is being written, and in
    the result are at most some `keep` points, spread evenly.
    """
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
    kept = _Kept(shape, keep)
    failed, first_failure, error_bound = 0, "", 0.0
    simulated: set[str] = set()
    failures, left_out = Counter[str](), Counter[str]()
    run = _Run(scene, axes, total)
    for start in range(0, total, _BLOCK):
        stop = min(start + _BLOCK, total)
        block: dict[str, FloatArray] = {}
        for places, found in run.outcomes(start, stop, progress):
            if isinstance(found, RopefricError):
                failed += places.size
                first_failure = first_failure or found.problem.message
                continue
            for quantity in found.quantities:
                block.setdefault(quantity.name, np.full(stop - start, np.nan))[places - start] = (
                    quantity.value
                )
            simulated |= found.simulated
            error_bound = max(error_bound, found.error_bound)
            left_out.update(dict.fromkeys(found.left_out, places.size))
            for way in found.failures:
                failures[way.words] += int(way.fails.sum())
        kept.add(block, start, stop)
        if table is not None:
            table.add(block, stop - start)
    if failed == total:
        raise InputError(
            f"no point of the sweep has an answer; the first says: {first_failure}",
            code="RF503",
            key="--sweep",
            fix="sweep over values that this scene can take",
        )
    every = scene.kind.system.effects
    return Sweep(
        axes=axes,
        columns=kept.columns,
        failed=failed,
        first_failure=first_failure,
        simulated=tuple(name for name in every if name in simulated),
        error_bound=error_bound,
        accuracy=scene.accuracy,
        failures=dict(+failures),
        left_out={name: left_out[name] for name in every if left_out[name]},
        steps=kept.steps,
        ranges=kept.ranges,
    )


class _Kept:
    """What stays of a grid's numbers: those of points spread evenly, and the range of all."""

    def __init__(self, shape: tuple[int, ...], most: int) -> None:
        steps = np.ones(len(shape), dtype=np.int64)
        while prod(-(-np.array(shape) // steps)) > most:
            steps[np.argmax(shape // steps)] *= 2
        self.steps: tuple[int, ...] = () if (steps == 1).all() else tuple(steps.tolist())
        self.columns: dict[str, FloatArray] = {}
        self.ranges: dict[str, tuple[float, float]] = {}
        self._shape, self._thinned = shape, tuple((-(-np.array(shape) // steps)).tolist())

    def add(self, block: Mapping[str, FloatArray], start: int, stop: int) -> None:
        """Take the numbers of points that follow each other."""
        places: Any = slice(start, stop)
        chosen: Any = slice(None)
        if self.steps:
            grid = np.unravel_index(np.arange(start, stop), self._shape)
            chosen = np.all([one % step == 0 for one, step in zip(grid, self.steps, strict=True)], axis=0)
            thinned = [one[chosen] // step for one, step in zip(grid, self.steps, strict=True)]
            places = np.ravel_multi_index(thinned, self._thinned)
        for name, values in block.items():
            self.columns.setdefault(name, np.full(prod(self._thinned), np.nan))[places] = values[chosen]
            low, high = self.ranges.get(name, (math.nan, math.nan))
            self.ranges[name] = (
                float(np.fmin(low, np.fmin.reduce(values))),
                float(np.fmax(high, np.fmax.reduce(values))),
            )


class _Found(NamedTuple):
    """What some points give, and what was simulated for them."""

    quantities: tuple[Quantity, ...]
    failures: tuple[Failure, ...]
    simulated: frozenset[str]
    left_out: frozenset[str]
    error_bound: float

    def at(self, some: BoolArray) -> "_Found":
        """Return what some of the points give."""
        quantities = tuple(one._replace(value=one.value[some]) for one in self.quantities)
        failures = tuple(one._replace(value=one.value[some], fails=one.fails[some]) for one in self.failures)
        return self._replace(quantities=quantities, failures=failures)


Outcome = tuple[IntArray, _Found | RopefricError]


class _Run:
    """A sweep as it is solved: which effects may go is asked once, for the box of all axes.

    An effect that has a bound for each case goes wherever the bound allows; another goes everywhere, if the corners of
    the box and what lies between them show that it may. Where what is left then leaves a yes or no open, or a
    difference of two numbers less accurate than is wanted, the points are solved again with everything.
    """

    def __init__(self, scene: Scene, axes: tuple[Axis, ...], total: int) -> None:
        self.scene, self.axes, self.kind = scene, axes, scene.kind
        self.shape = tuple(axis.values.size for axis in axes)
        self.fields = [self.kind.sweep_fields.get(axis.key) for axis in axes]
        self.by_array = None not in self.fields and self.kind.in_one_call(scene.problem)
        self.gone: frozenset[str] = frozenset()
        self.spent = 0.0
        self.each: list[Effect[Any, Any]] = []
        self.room = room_for_effects(scene.accuracy)
        if scene.effects == "auto" and self.by_array:
            self._plan(total)

    def build(self, values: list[FloatArray]) -> Any:
        """Return the problem of some points from the values of all axes there."""
        if self.by_array:
            pairs = zip(self.fields, values, strict=True)
            return replace(
                self.scene.problem, **{one.field: one.factor * value for one, value in pairs if one}
            )
        table, kind = self.scene.table, self.kind
        for axis, value in zip(self.axes, values, strict=True):
            table = _replaced(table, axis.key, float(value[0]))
        source = source_of(kind, table, self.scene.folder)
        return kind.problem(table, None if source is None else source.friction)

    def _plan(self, total: int) -> None:
        """Find out what may go, from the corners of the box and what lies between them."""
        levels = _LEVELS.get(len(self.axes), 2)
        ordered = [np.unique(axis.values) for axis in self.axes]
        chosen = [one[np.unique(np.linspace(0, one.size - 1, levels).astype(int))] for one in ordered]
        try:
            box = self.build([one.ravel() for one in np.meshgrid(*chosen, indexing="ij")])
            possible = self.kind.answerable(box)
            applicable = [one for one in self.kind.system.effects.values() if not one.needs(box)]
            everywhere = [one for one in worth_asking(applicable, total, _LEAST_SAVED_S) if one.each is None]
            # Where the box ends at a machine that has no answer, nothing is known of what lies before it.
            if everywhere and possible.all():
                self._leave_out(box, applicable, sorted(everywhere, key=lambda one: -one.cost))
            self.each = [one for one in worth_asking(applicable, total) if one.each is not None]
            if self.each and not (self._bounds(box)[possible] <= self.room).any():
                self.each = []
        except RopefricError:  # the box has a point without an answer; the sweep will say which
            self.each = []

    def _leave_out(
        self, box: Any, applicable: list[Effect[Any, Any]], candidates: list[Effect[Any, Any]]
    ) -> None:
        names = frozenset(one.name for one in applicable)
        whole = self._solved(box, names)
        for one in candidates:
            try:
                found = self._solved(box, names - self.gone - {one.name})
            except RopefricError:
                continue
            spent = _BETWEEN * max(map(_log_change, found.quantities, whole.quantities))
            if spent <= (0.5 * self.room if any(other.each for other in applicable) else self.room):
                self.gone, self.spent = self.gone | {one.name}, spent

    def _bounds(self, problem: Any) -> FloatArray:
        """Return what leaving out all that may go changes at most, shape (n,)."""
        return np.asarray(
            self.spent + sum((one.each(problem) for one in self.each if one.each), np.zeros(problem.n))
        )

    def _solved(self, problem: Any, simulated: frozenset[str]) -> _Found:
        system, kind = self.kind.system, self.kind
        model = assemble(system, problem, simulated)
        method = system.method(model, self.scene.accuracy)
        answer = system.solve(model, method)
        gone = frozenset(system.effects) - simulated
        return _Found(
            kind.quantities(answer, problem), kind.failures(answer, problem), simulated, gone, method.error
        )

    def outcomes(self, start: int, stop: int, progress: Progress | None) -> Iterator[Outcome]:
        """Yield what the points of a block give; point by point where a key does not go in one call."""
        total, kind = prod(self.shape), self.kind
        size = stop - start if self.by_array else 1
        for first in range(start, stop, size):
            places = np.arange(first, first + size)
            grid = np.unravel_index(places, self.shape)
            values = [axis.values[place] for axis, place in zip(self.axes, grid, strict=True)]
            problem = self.build(values) if self.by_array else None
            possible = np.ones(1, dtype=np.bool_) if problem is None else kind.answerable(problem)
            if possible.all():
                yield from self._points(places, values, problem)
            else:
                # Of the points that cannot have an answer one is solved, to hear why not.
                hopeless = np.flatnonzero(~possible)
                for some in (hopeless[:1], np.flatnonzero(possible)):
                    if some.size:
                        yield from self._points(places[some], [value[some] for value in values])
                if hopeless.size > 1:
                    yield places[hopeless[1:]], InputError("there is no answer")
            if progress is not None:
                progress(int(places[-1]) + 1, total, "points")

    def _points(self, places: IntArray, values: list[FloatArray], problem: Any = None) -> Iterator[Outcome]:
        """Yield what points give, with less than everything where that may be."""
        rest = np.ones(places.size, dtype=np.bool_)
        if self.each or self.gone:
            for some, found in self._lessened(self.build(values) if problem is None else problem, values):
                rest[some] = False
                yield places[some], found
        if rest.all():
            yield from self._whole(places, values, problem)
        elif rest.any():
            yield from self._whole(places[rest], [value[rest] for value in values])

    def _lessened(self, problem: Any, values: list[FloatArray]) -> Iterator[tuple[slice | BoolArray, _Found]]:
        """Yield which points can be solved with less than everything, and what they give."""
        names = frozenset(one.name for one in self.kind.system.effects.values() if not one.needs(problem))
        with suppress(
            RopefricError
        ):  # what has no answer, or none without some effect, is left to everything
            bounds = self._bounds(problem)
            few = bounds <= self.room
            groups = [(few, self.gone | {one.name for one in self.each}, bounds)]
            if self.gone and self.each:
                groups.append((~few, self.gone, np.full(few.size, self.spent)))
            for group, without, bound in groups:
                if not group.any():
                    continue
                less = problem if group.all() else self.build([value[group] for value in values])
                error = np.expm1(bound[group])
                found = self._solved(less, names - without)
                sure = _is_settled(found, error, self.scene.accuracy)
                if sure.any():
                    most = float(error[sure].max())
                    off = most + found.error_bound * (1.0 + most)
                    if not sure.all():
                        group[np.flatnonzero(group)[~sure]] = False
                        found = found.at(sure)
                    yield (
                        slice(None) if group.all() else group,
                        found._replace(left_out=without, error_bound=off),
                    )

    def _whole(self, places: IntArray, values: list[FloatArray], problem: Any = None) -> Iterator[Outcome]:
        """Yield what points give, solved in one call; where one has no answer, they are halved until it stands alone."""
        try:
            found = self._planned(self.build(values) if problem is None else problem)
        except RopefricError as error:
            if places.size == 1:
                yield places, error
                return
            for half in np.array_split(np.arange(places.size), 2):
                yield from self._whole(places[half], [value[half] for value in values])
        else:
            yield places, found

    def _planned(self, problem: Any) -> _Found:
        """Return what a problem gives as planned by itself, with everything where sweeps are planned as a whole."""
        kind, scene = self.kind, self.scene
        effects = "all" if scene.effects == "auto" and self.by_array else scene.effects
        plan, model = make_plan(kind.system, problem, accuracy=scene.accuracy, effects=effects)
        answer = kind.system.solve(model, plan.method)
        return _Found(
            kind.quantities(answer, problem),
            kind.failures(answer, problem),
            frozenset(plan.simulated),
            frozenset(plan.left_out),
            plan.error_bound,
        )


def _log_change(one: Quantity, other: Quantity) -> float:
    """Return how far a number is from another, |Δ ln|, or as a share of what it errs by a share of."""
    value, reference = one.value, other.value
    same = (value == reference) | (np.isnan(value) & np.isnan(reference))
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.abs(np.log(value / reference))
        if other.scale is not None:
            share = np.abs(np.log1p((value - reference) / other.scale))
    return float(np.where(same, 0.0, np.where(np.isnan(share), np.inf, share)).max())


def _is_settled(found: _Found, error: FloatArray, accuracy: float) -> BoolArray:
    """Return at which points an answer that errs by a share `error` leaves no yes or no open, and no difference."""
    settled = np.ones(error.size, dtype=np.bool_)
    for one in found.quantities:
        if one.scale is not None:
            settled &= error * np.abs(one.scale) <= accuracy * np.abs(one.value)
    for way in found.failures:
        settled &= np.abs(way.value - way.limit) > error * np.abs(way.value)
    return settled


def header_of(axes: tuple[Axis, ...], columns: Iterable[str]) -> tuple[str, ...]:
    """Return the columns of a sweep's table: the swept keys with their units, then the numbers of the answer."""
    keys = (f"{axis.key} [{axis.unit}]" if axis.unit else axis.key for axis in axes)
    return (*keys, *columns)


class SweepTable:
    """A sweep's table while it is written, one row a point, the last axis fastest: CSV, or Parquet by its name.

    Swept values stand in the unit in which they were asked for; a point without an answer has empty cells.
    """

    def __init__(self, axes: tuple[Axis, ...], stream: BinaryIO, *, parquet: bool = False) -> None:
        self._axes, self._stream = axes, stream
        self._written = self._waiting = 0
        self._parquet: Any = _parquet() if parquet else None
        self._writer: Any = None
        # An axis has few values, so each is put into words once.
        self._words = [[f"{value / axis.factor:.10g}," for value in axis.values] for axis in axes]
        self._lines: list[str] = []

    def add(self, columns: Mapping[str, FloatArray], count: int) -> None:
        """Write the next points; those before the first that has an answer wait for the names of its numbers."""
        self._waiting += count
        if not columns:
            return
        if not self._lines:
            self._lines = [word + ",".join(["%.9g"] * len(columns)) + "\n" for word in self._words[-1]]
            self._names = tuple(columns)
            if self._parquet is None:
                self._stream.write(csv_text([map(csv_cell, header_of(self._axes, columns))]).encode())
        values = np.stack([columns[name] for name in self._names], axis=-1)
        while self._waiting > count:
            size = min(self._waiting - count, _BLOCK)
            self._write(np.full((size, len(self._names)), np.nan))
        self._write(values)

    def _write(self, values: FloatArray) -> None:
        start, stop = self._written, self._written + len(values)
        self._written, self._waiting = stop, self._waiting - len(values)
        if self._parquet is not None:
            self._write_group(start, stop, values)
            return
        shape, length = [axis.values.size for axis in self._axes[:-1]], len(self._lines)
        for outer in range(start // length, -(-stop // length)):
            first, last = max(start, outer * length), min(stop, (outer + 1) * length)
            rows = self._lines[first - outer * length : last - outer * length]
            words = "".join(
                word[i] for word, i in zip(self._words, np.unravel_index(outer, shape), strict=False)
            )
            self._stream.write(_rows(words, rows, values[first - start : last - start]).encode())

    def _write_group(self, start: int, stop: int, values: FloatArray) -> None:
        arrow, parquet = self._parquet
        grid = np.unravel_index(np.arange(start, stop), [axis.values.size for axis in self._axes])
        swept = [axis.values[i] / axis.factor for axis, i in zip(self._axes, grid, strict=True)]
        arrays = [arrow.array(column, from_pandas=True) for column in (*swept, *values.T)]
        group = arrow.table(arrays, names=list(header_of(self._axes, self._names)))
        if self._writer is None:
            self._writer = parquet.ParquetWriter(self._stream, group.schema)
        self._writer.write_table(group)

    def close(self) -> None:
        """End the table."""
        if self._lines and self._waiting:
            self._write(np.full((self._waiting, len(self._names)), np.nan))
        if self._writer is not None:
            self._writer.close()


def _parquet() -> tuple[Any, Any]:
    try:
        return import_module("pyarrow"), import_module("pyarrow.parquet")
    except ImportError:
        raise InputError(
            "Parquet needs pyarrow, which is not installed",
            code="RF107",
            key="--table",
            fix='pip install "ropefric[parquet]", or write CSV',
        ) from None


@contextmanager
def sweep_table(axes: tuple[Axis, ...], folder: Folder, name: str) -> Iterator[SweepTable]:
    """Yield the table of a sweep to be written into a folder; one that is broken off leaves no file."""
    with folder.stream(name) as stream:
        table = SweepTable(axes, stream, parquet=name.endswith(".parquet"))
        yield table
        table.close()


def write_sweep(sweep: Sweep, folder: Folder, name: str) -> Path:
    """Write a sweep that is at hand as CSV or Parquet, as `SweepTable` does; return the path."""
    with sweep_table(sweep.kept, folder, name) as table:
        size = prod(axis.values.size for axis in sweep.kept)
        for start in range(0, size, _BLOCK):
            block = {key: values[start : start + _BLOCK] for key, values in sweep.columns.items()}
            table.add(block, min(_BLOCK, size - start))
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
