"""A scene solved over a grid of its own numbers: in one call where the system allows, point by point elsewhere."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from math import prod
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray, IntArray
from ropefric.errors import InputError, RopefricError
from ropefric.scenes.axis import MOST_POINTS, Axis, replaced
from ropefric.scenes.kind import Quantity
from ropefric.scenes.plan import make_plan
from ropefric.scenes.scene import Scene, source_of

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
    total = prod(axis.values.size for axis in axes)
    if total > MOST_POINTS:
        sizes = " × ".join(str(axis.values.size) for axis in axes)
        raise InputError(
            f"a grid of {sizes} is {total} points; the limit is {MOST_POINTS}",
            key="--sweep",
            fix="ask for fewer values of each key",
        )
    collected = _Collected(total=total)
    by_array = all(key in scene.kind.sweep_fields for key in keys) and scene.kind.in_one_call(scene.problem)
    solve = _solve_answerable if by_array else _solve_point
    for places, values in _blocks(axes, total, _BLOCK if by_array else 1):
        solve(scene, keys, values, places, collected)
        if progress is not None:
            progress(int(places[-1]) + 1, total, "points")
    if collected.failed == total:
        raise InputError(
            f"no point of the sweep has an answer; the first says: {collected.first_failure}",
            code="RF503",
            key="--sweep",
            fix="sweep over values that this scene can take",
        )
    return Sweep(
        axes=axes,
        columns=collected.columns,
        failed=collected.failed,
        first_failure=collected.first_failure,
        simulated=tuple(name for name in scene.kind.system.effects if name in collected.simulated),
        error_bound=collected.error_bound,
        accuracy=scene.accuracy,
        failures=collected.failures,
    )


@dataclass(slots=True, kw_only=True)
class _Collected:
    """What has come in so far."""

    total: int
    columns: dict[str, FloatArray] = field(default_factory=dict)
    failed: int = 0
    first_failure: str = ""
    error_bound: float = 0.0
    simulated: set[str] = field(default_factory=set)
    failures: dict[str, int] = field(default_factory=dict)

    def put(self, places: IntArray, quantities: tuple[Quantity, ...]) -> None:
        for quantity in quantities:
            column = self.columns.setdefault(quantity.name, np.full(self.total, np.nan))
            column[places] = quantity.value

    def fail(self, error: RopefricError) -> None:
        self.first_failure = self.first_failure or error.problem.message
        self.failed += 1


def _asked(scene: Scene, points: int) -> str | tuple[str, ...]:
    return "all" if scene.effects == "auto" and points > _PLANNED_POINTS else scene.effects


def _blocks(axes: tuple[Axis, ...], total: int, size: int) -> Iterator[tuple[IntArray, list[FloatArray]]]:
    shape = tuple(axis.values.size for axis in axes)
    for start in range(0, total, size):
        places = np.arange(start, min(start + size, total))
        grid = np.unravel_index(places, shape)
        yield places, [axis.values[place] for axis, place in zip(axes, grid, strict=True)]


def _solve_answerable(
    scene: Scene, keys: list[str], values: list[FloatArray], places: IntArray, collected: _Collected
) -> None:
    """Solve the points of a block that can have an answer in one call, and one of the others, to hear why not."""
    possible = scene.kind.answerable(_at(scene, keys, values))
    hopeless = np.flatnonzero(~possible)
    if hopeless.size:
        first = hopeless[:1]
        _solve_block(scene, keys, [value[first] for value in values], places[first], collected)
        collected.failed += hopeless.size - 1
    if possible.any():
        _solve_block(scene, keys, [value[possible] for value in values], places[possible], collected)


def _at(scene: Scene, keys: list[str], values: list[FloatArray]) -> Any:
    fields = {
        scene.kind.sweep_fields[key].field: scene.kind.sweep_fields[key].factor * value
        for key, value in zip(keys, values, strict=True)
    }
    return replace(scene.problem, **fields)


def _solve_block(
    scene: Scene, keys: list[str], values: list[FloatArray], places: IntArray, collected: _Collected
) -> None:
    """Solve many points in one call; where one of them has no answer, halve the block until it stands alone."""
    try:
        _solve(scene, _at(scene, keys, values), places, _asked(scene, collected.total), collected)
    except RopefricError as error:
        if places.size == 1:
            collected.fail(error)
            return
        for half in np.array_split(np.arange(places.size), 2):
            _solve_block(scene, keys, [value[half] for value in values], places[half], collected)


def _solve_point(
    scene: Scene, keys: list[str], values: list[FloatArray], places: IntArray, collected: _Collected
) -> None:
    table = scene.table
    for key, value in zip(keys, values, strict=True):
        table = replaced(table, key, float(value[0]))
    try:
        source = source_of(scene.kind, table, scene.folder)
        problem = scene.kind.problem(table, None if source is None else source.friction)
        _solve(scene, problem, places, scene.effects, collected)
    except RopefricError as error:
        collected.fail(error)


def _solve(
    scene: Scene, problem: Any, places: IntArray, effects: str | tuple[str, ...], collected: _Collected
) -> None:
    plan, model = make_plan(scene.kind.system, problem, accuracy=scene.accuracy, effects=effects)
    answer = scene.kind.system.solve(model, plan.method)
    collected.put(places, scene.kind.quantities(answer, problem))
    collected.simulated.update(plan.simulated)
    for failure in scene.kind.failures(answer, problem):
        if failure.fails.any():
            before = collected.failures.get(failure.words, 0)
            collected.failures[failure.words] = before + int(failure.fails.sum())
    collected.error_bound = max(collected.error_bound, plan.error_bound)
