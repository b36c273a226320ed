"""A scene solved over a grid of its own numbers, and its table: CSV, or Parquet.

An axis is a key of the scene and the values it is to take. There may be a million points, so they are solved block by
block, planned once.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import prod
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray, IntArray
from ropefric.errors import InputError, UnknownNameError
from ropefric.files.folder import Folder
from ropefric.files.plain_text import arrow, csv_cell, csv_text
from ropefric.files.toml import TomlDocument
from ropefric.registry import did_you_mean
from ropefric.scenes.kind import value_at
from ropefric.scenes.points import BLOCK, MOST_CASES, Answers, Points, Progress, solve_points
from ropefric.scenes.scene import Scene, number_keys, read_scene, replaced, unit_of


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
    """Return the axis of "KEY=START:STOP:COUNT" or "KEY=A,B,C"."""
    key, equals, asked = (part.strip() for part in text.partition("="))
    if not equals or not key or not asked:
        raise InputError(
            f"--sweep {text!r} is not KEY=START:STOP:COUNT or KEY=A,B,C",
            key="--sweep",
            fix='write it like  --sweep "wheel.wrap=90deg:1440deg:50"',
        )
    known = number_keys(scene.document, scene.table)
    if key not in known:
        raise UnknownNameError(
            f"the scene gives no number {key!r} that could be swept",
            key="--sweep",
            fix=f"{did_you_mean(key, known)}; a key that the scene leaves out must be written into it first",
        )
    is_range = ":" in asked
    texts = [part.strip() for part in asked.split(":" if is_range else ",")]
    texts, spacing = (texts[:2], texts[2:]) if is_range else (texts, [])
    values = np.array([_si(scene, key, part) for part in texts])
    # The unit is that of the last value.
    unit, written = unit_of(texts[-1])
    factor = float(values[-1]) / written if unit and written else 1.0
    values = _between(asked, values, spacing) if is_range else values
    return Axis(key=key, values=values, unit=unit, factor=factor)


def _between(asked: str, ends: FloatArray, parts: list[str]) -> FloatArray:
    """Return the values of a range between two ends, spaced as asked."""
    count, spaced = parts if len(parts) == 2 else ("".join(parts[:1]), "linear")
    counted = int(count) if len(parts) <= 2 and count.isdecimal() and len(count) < 20 else 0
    if not 2 <= counted <= MOST_CASES or spaced not in {"linear", "log"}:
        raise InputError(
            f"{asked!r} is not START:STOP:COUNT with a count from 2 to {MOST_CASES}",
            key="--sweep",
            fix="write it like  90deg:1440deg:50  or, in equal ratios,  90deg:1440deg:50:log",
        )
    if spaced == "log" and not (ends > 0.0).all():
        raise InputError(f"{asked!r} has no equal ratios: both ends must be positive", key="--sweep")
    return (np.geomspace if spaced == "log" else np.linspace)(ends[0], ends[1], counted)


def _si(scene: Scene, key: str, text: str) -> float:
    """Return a value in SI, read and checked by the scene itself."""
    now = value_at(scene.document.data, key)
    try:
        written = text if isinstance(now, str) else float(text)
    except ValueError:
        raise InputError(
            f"{key}: {text!r} is no number", key="--sweep", fix="write it without unit"
        ) from None
    data = replaced(scene.document.data, key, written)
    changed = read_scene(TomlDocument(path=scene.document.path, data=data, lines={}), scene.folder)
    return float(value_at(changed.table, key))


class _Grid(Points):
    """The points of all combinations of values; the last axis runs fastest."""

    option = "--sweep"
    what = "point of the sweep"
    fix = "sweep over values that this scene can take"

    def __init__(self, axes: tuple[Axis, ...]) -> None:
        self.axes, self.keys = axes, tuple(axis.key for axis in axes)
        self.shape = tuple(axis.values.size for axis in axes)

    def at(self, places: IntArray) -> list[FloatArray]:
        grid = np.unravel_index(places, self.shape)
        return [axis.values[place] for axis, place in zip(self.axes, grid, strict=True)]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sweep(Answers):
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
        The message of the first of them.
    simulated : tuple of str
        Effects in the model, wherever on the grid.
    error_bound : float
        The largest of all points.
    accuracy : float
        The accuracy wanted.
    failures : mapping of str to int
        Number of points at which the machine fails, by the failure.
    left_out : mapping of str to int
        Number of points at which an effect was left out.
    extrapolated_at : mapping of str to int
        Number of points at which a regressor of the law is outside the tested range; with a fit, the column
        `extrapolated` is 1 there and 0 elsewhere.
    """

    _said = ("shape", "simulated", "error_bound", "failed", "warnings")
    _framed = "_all_columns"

    def _all_columns(self) -> dict[str, FloatArray]:
        return {axis.key: each for axis, each in zip(self.axes, self._grid(), strict=True)} | self.columns

    def _grid(self) -> list[FloatArray]:
        return [one.ravel() for one in np.meshgrid(*(axis.values for axis in self.axes), indexing="ij")]

    @property
    def table(self) -> dict[str, FloatArray]:
        """Return the table, one row a point: swept values in the unit in which they were asked for, and the numbers."""
        pairs = zip(self.axes, self._grid(), strict=True)
        return {axis.label: each / axis.factor for axis, each in pairs} | self.columns

    axes: tuple[Axis, ...]

    @property
    def warnings(self) -> tuple[str, ...]:
        """Return what speaks against using the answers, and where the machine does not do what it is for."""
        return self._warnings(f"at {{}} of {prod(self.shape)} points")

    @property
    def shape(self) -> tuple[int, ...]:
        """Return the lengths of the axes."""
        return tuple(axis.values.size for axis in self.axes)


def sweep_scene(
    scene: Scene,
    axes: tuple[Axis, ...],
    *,
    progress: Progress | None = None,
    executor: Any = None,
) -> Sweep:
    """Return the numbers of a scene's answer over the grid of all axes, solved here or by an executor."""
    grid = _Grid(axes)
    if not axes or len(set(grid.keys)) < len(axes):
        raise InputError("a sweep takes at least one key, and each key once", key="--sweep")
    total = prod(grid.shape)
    if total > MOST_CASES:
        raise InputError(
            f"a grid of {' × '.join(map(str, grid.shape))} is {total} points; the limit is {MOST_CASES}",
            key="--sweep",
            fix="use fewer values of each key",
        )
    found = solve_points(scene, grid, progress=progress, executor=executor)
    found["failures"] = {words: n for words, n in found["failures"].items() if n}
    return Sweep(axes=axes, **found)


def check_table(name: str) -> None:
    """Refuse, before the work, a table that cannot be written."""
    if name.endswith(".parquet"):
        arrow("--table")


def write_table(folder: Folder, name: str, columns: Mapping[str, FloatArray]) -> None:
    """Write columns of one length into a folder, a row a point: CSV, or Parquet by the file's name."""
    with folder.stream(name) as stream:
        if name.endswith(".parquet"):
            pyarrow, parquet = arrow("--table")
            arrays = [pyarrow.array(column, from_pandas=True) for column in columns.values()]
            parquet.write_table(pyarrow.table(arrays, names=list(columns)), stream)
            return
        stream.write(csv_text([map(csv_cell, columns)]).encode())
        values = np.stack(list(columns.values()), axis=-1)
        for start in range(0, len(values), BLOCK):
            stream.write(_rows(values[start : start + BLOCK]).encode())


def columns_text(columns: Mapping[str, FloatArray]) -> str:
    """Return columns of one length as CSV."""
    return csv_text([map(csv_cell, columns)]) + _rows(np.stack(list(columns.values()), axis=-1))


def _rows(values: FloatArray) -> str:
    """Return rows of numbers; an empty cell where there is no number."""
    row = ",".join(["%.9g"] * values.shape[1])
    text: str = f"{row}\n" * len(values) % tuple(values.ravel().tolist())
    return text.replace("nan", "") if np.isnan(values).any() else text
