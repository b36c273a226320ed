"""A scene solved over a grid of its own numbers: in one call where the system allows, point by point elsewhere.

An axis is a key of the scene and the values it is to take. There may be millions of points, so they are solved block by
block, planned once for their box.
"""

import math
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import chain, islice, tee
from math import prod
from typing import Any, NamedTuple

import numpy as np

from ropefric.arrays import BoolArray, FloatArray, IntArray
from ropefric.errors import InputError, RopefricError, UnknownNameError
from ropefric.executors import spread
from ropefric.files.toml import TomlDocument
from ropefric.registry import did_you_mean
from ropefric.scenes.kind import Failure, Quantity
from ropefric.scenes.plan import make_plan, room_for_effects, worth_asking
from ropefric.scenes.scene import Scene, read_scene, source_of
from ropefric.shown import Shown
from ropefric.systems.effect import Effect, assemble

MOST_POINTS = 10_000_000
"""Of an axis, and of a whole grid: some 2.5 GB."""
KEPT_POINTS = 1_000_000
"""Of a sweep whose table is written, for its figure."""
_NUMBER = re.compile(r"\s*+([+-]?[\d.]++(?:[eE][+-]?\d++)?)")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Axis:
    """A key of a scene and its values."""

    key: str
    values: FloatArray
    unit: str
    factor: float

    @property
    def label(self) -> str:
        """Return the key with the unit in which its values were asked for."""
        return f"{self.key} [{self.unit}]" if self.unit else self.key


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


BLOCK = 50_000
_ONE_BY_ONE = 20
"""Points of a piece of work that are solved one after another."""
_LEVELS = {1: 9, 2: 5, 3: 4, 4: 3}
"""Values of each axis at which the box of a sweep is looked at, by how many axes there are; more have two."""
_BETWEEN = 2.0
"""What an effect may change between the levels, over what it changes at them."""

_ROUNDING = 1e-12
_SEEN_S = 1.0
"""What is solved in one call takes at most about this long."""
_LEAST_SAVED_S = 5e-2
"""An effect that takes less than this over the whole grid is not worth solving the box without it."""

Progress = Callable[[int, int, str], None]
Write = Callable[[Mapping[str, FloatArray], int], None]
"""Takes the numbers of the next points, and how many these are."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sweep(Shown):
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

    _said = ("shape", "simulated", "error_bound", "failed", "warnings")
    _framed = "_all_columns"

    def _all_columns(self) -> dict[str, FloatArray]:
        grid = np.meshgrid(*(axis.values for axis in self.kept), indexing="ij")
        return {axis.key: each.ravel() for axis, each in zip(self.kept, grid, strict=True)} | self.columns

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
    write: Write | None = None,
    keep: int = MOST_POINTS,
    executor: Any = None,
) -> Sweep:
    """Return the numbers of a scene's answer over the grid of all axes.

    They are solved block by block, here or by an executor, so that memory stays flat: each is handed on to be written,
    and in the result are at most some `keep` points, spread evenly.
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
    outcomes = run.spread(progress, executor)
    for start in range(0, total, BLOCK):
        stop = min(start + BLOCK, total)
        block: dict[str, FloatArray] = {}
        for places, found in chain.from_iterable(islice(outcomes, len(run.pieces(start, stop)))):
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
        if write is not None:
            write(block, stop - start)
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
        effects = self.kind.system.effects.values()
        cost_s = sum(one.cost for one in effects if not one.needs(scene.problem))
        # Of a dear machine few at once, so that people see how far it is.
        self.size = min(BLOCK, max(1, int(_SEEN_S / max(cost_s, 1e-9)))) if self.by_array else 1
        self.gone: frozenset[str] = frozenset()
        self.spent = 0.0
        self.bounded: tuple[str, ...] = ()
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
            self.bounded = tuple(one.name for one in worth_asking(applicable, total) if one.each is not None)
            if self.bounded and not (self._bounds(box)[possible] <= self.room).any():
                self.bounded = ()
        except RopefricError:  # the box has a point without an answer; the sweep will say which
            self.bounded = ()

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
            spent = math.log1p(_BETWEEN * max(map(_change, found.quantities, whole.quantities)))
            if spent <= (0.5 * self.room if any(other.each for other in applicable) else self.room):
                self.gone, self.spent = self.gone | {one.name}, spent

    def _bounds(self, problem: Any) -> FloatArray:
        """Return what leaving out all that may go changes at most, shape (n,)."""
        effects = (self.kind.system.effects[name] for name in self.bounded)
        each = (one.each(problem) for one in effects if one.each)
        return np.asarray(self.spent + sum(each, np.zeros(problem.n)))

    def _solved(self, problem: Any, simulated: frozenset[str]) -> _Found:
        system, kind = self.kind.system, self.kind
        model = assemble(system, problem, simulated)
        method = system.method(model, self.scene.accuracy)
        answer = system.solve(model, method)
        gone = frozenset(system.effects) - simulated
        return _Found(
            kind.quantities(answer, problem), kind.failures(answer, problem), simulated, gone, method.error
        )

    def pieces(self, start: int, stop: int) -> list[tuple[int, int]]:
        """Return the first point of each piece of a block, and the one after its last."""
        size = self.size if self.by_array else _ONE_BY_ONE
        return [(first, min(first + size, stop)) for first in range(start, stop, size)]

    def spread(self, progress: Progress | None, executor: Any) -> Iterator[list[Outcome]]:
        """Yield what the points of all pieces of all blocks give."""
        total = prod(self.shape)
        blocks = ((start, min(start + BLOCK, total)) for start in range(0, total, BLOCK))
        one, other = tee(piece for block in blocks for piece in self.pieces(*block))
        for (_, stop), found in zip(one, spread(self.outcomes, other, executor), strict=True):
            if progress is not None:
                progress(stop, total, "points")
            yield found

    def outcomes(self, piece: tuple[int, int]) -> list[Outcome]:
        """Return what the points of a piece give; point by point where a key does not go in one call."""
        step = self.size if self.by_array else 1
        return [
            found
            for first in range(*piece, step)
            for found in self._outcomes(first, min(first + step, piece[1]))
        ]

    def _outcomes(self, start: int, stop: int) -> Iterator[Outcome]:
        places = np.arange(start, stop)
        grid = np.unravel_index(places, self.shape)
        values = [axis.values[place] for axis, place in zip(self.axes, grid, strict=True)]
        problem = self.build(values) if self.by_array else None
        possible = np.ones(1, dtype=np.bool_) if problem is None else self.kind.answerable(problem)
        if possible.all():
            yield from self._points(places, values, problem)
            return
        # Of the points that cannot have an answer one is solved, to hear why not.
        hopeless = np.flatnonzero(~possible)
        for some in (hopeless[:1], np.flatnonzero(possible)):
            if some.size:
                yield from self._points(places[some], [value[some] for value in values])
        if hopeless.size > 1:
            yield places[hopeless[1:]], InputError("there is no answer")

    def _points(self, places: IntArray, values: list[FloatArray], problem: Any = None) -> Iterator[Outcome]:
        """Yield what points give, with less than everything where that may be."""
        rest = np.ones(places.size, dtype=np.bool_)
        if self.bounded or self.gone:
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
            groups = [(few, self.gone | {*self.bounded}, bounds)]
            if self.gone and self.bounded:
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
        """Return what a problem gives as asked for; with everything where sweeps are planned as a whole."""
        kind, scene = self.kind, self.scene
        if self.by_array and isinstance(scene.effects, tuple):
            return self._listed(problem, frozenset(scene.effects))
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

    def _listed(self, problem: Any, names: frozenset[str]) -> _Found:
        """Return what a list of effects gives; how far that is from everything is found by solving that, too.

        Without the effects that have a bound for each case: they may be dear.
        """
        effects = self.kind.system.effects
        if any(effects[name].needs(problem) for name in names):
            make_plan(
                self.kind.system, problem, accuracy=self.scene.accuracy, effects=tuple(names)
            )  # refuses
        missing = [one for one in effects.values() if one.name not in names and not one.needs(problem)]
        found, off = self._solved(problem, names), 0.0
        try:
            others = names | {one.name for one in missing if one.each is None}
            if others != names:
                whole = self._solved(problem, others)
                off = math.log1p(max(map(_change, found.quantities, whole.quantities)))
            off += sum(float(one.each(problem).max()) for one in missing if one.each is not None)
        except RopefricError:
            off = math.inf
        error = math.expm1(min(off, 700.0)) if off < math.inf else math.inf
        error += found.error_bound * (1.0 + error)
        return found._replace(left_out=frozenset(one.name for one in missing), error_bound=error)


def _change(one: Quantity, other: Quantity) -> float:
    """Return how far a number is from another, as a share of that, or of what it errs by a share of."""
    value, reference = one.value, other.value
    scale = np.abs(reference if other.scale is None else other.scale)
    # What rounding leaves of zero is no number to take shares of.
    rounding = _ROUNDING * float(np.nanmax(scale, initial=1.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.abs(value - reference) / scale
        same = (np.abs(value - reference) <= rounding) | (np.isnan(value) & np.isnan(reference))
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
