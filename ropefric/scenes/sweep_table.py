"""The table of a sweep, as CSV or Parquet, written block by block while the sweep runs; and other columns as CSV."""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, BinaryIO

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.files.folder import Folder
from ropefric.files.plain_text import arrow, csv_cell, csv_text
from ropefric.scenes.points import BLOCK
from ropefric.scenes.sweep import Axis


def header_of(axes: tuple[Axis, ...], columns: Iterable[str]) -> tuple[str, ...]:
    """Return the columns of a sweep's table: the swept keys with their units, then the numbers of the answer."""
    return (*(axis.label for axis in axes), *columns)


class SweepTable:
    """A sweep's table while it is written, one row a point, the last axis fastest: CSV, or Parquet by its name.

    Swept values stand in the unit in which they were asked for; a point without an answer has empty cells. Of draws,
    which have no axes, the columns hold what was drawn, too.
    """

    def __init__(self, axes: tuple[Axis, ...], stream: BinaryIO, *, parquet: bool = False) -> None:
        self._axes, self._stream = axes, stream
        self._written = self._waiting = 0
        self._parquet: Any = arrow("--table") if parquet else None
        self._writer: Any = None
        # An axis has few values, so each is put into words once.
        self._words = [[f"{value / axis.factor:.10g}," for value in axis.values] for axis in axes]
        self._outer = [axis.values.size for axis in axes[:-1]]
        self._lines: list[str] = []

    def add(self, columns: Mapping[str, FloatArray], count: int) -> None:
        """Write the next points; those before the first that has an answer wait for the names of its numbers."""
        self._waiting += count
        if not columns:
            return
        if not self._lines:
            inner = self._words[-1] if self._words else [""] * BLOCK
            self._lines = [word + ",".join(["%.9g"] * len(columns)) + "\n" for word in inner]
            self._names = tuple(columns)
            if self._parquet is None:
                self._stream.write(csv_text([map(csv_cell, header_of(self._axes, columns))]).encode())
        values = np.stack([columns[name] for name in self._names], axis=-1)
        while self._waiting > count:
            size = min(self._waiting - count, BLOCK)
            self._write(np.full((size, len(self._names)), np.nan))
        self._write(values)

    def _write(self, values: FloatArray) -> None:
        start, stop = self._written, self._written + len(values)
        self._written, self._waiting = stop, self._waiting - len(values)
        if self._parquet is not None:
            self._write_group(start, stop, values)
            return
        length = len(self._lines)
        for outer in range(start // length, -(-stop // length)):
            first, last = max(start, outer * length), min(stop, (outer + 1) * length)
            rows = self._lines[first - outer * length : last - outer * length]
            places = np.unravel_index(outer, self._outer) if self._outer else ()
            words = "".join(word[i] for word, i in zip(self._words, places, strict=False))
            self._stream.write(_rows(words, rows, values[first - start : last - start]).encode())

    def _write_group(self, start: int, stop: int, values: FloatArray) -> None:
        pyarrow, parquet = self._parquet
        shape = [axis.values.size for axis in self._axes]
        grid = np.unravel_index(np.arange(start, stop), shape) if shape else ()
        swept = [axis.values[i] / axis.factor for axis, i in zip(self._axes, grid, strict=True)]
        arrays = [pyarrow.array(column, from_pandas=True) for column in (*swept, *values.T)]
        group = pyarrow.table(arrays, names=list(header_of(self._axes, self._names)))
        if self._writer is None:
            self._writer = parquet.ParquetWriter(self._stream, group.schema)
        self._writer.write_table(group)

    def close(self) -> None:
        """End the table."""
        if self._lines and self._waiting:
            self._write(np.full((self._waiting, len(self._names)), np.nan))
        if self._writer is not None:
            self._writer.close()


@contextmanager
def sweep_table(axes: tuple[Axis, ...], folder: Folder, name: str) -> Iterator[SweepTable]:
    """Yield the table of a sweep to be written into a folder; one that is broken off leaves no file."""
    with folder.stream(name) as stream:
        table = SweepTable(axes, stream, parquet=name.endswith(".parquet"))
        yield table
        table.close()


def columns_text(columns: Mapping[str, FloatArray]) -> str:
    """Return columns of one length as CSV."""
    values = np.stack(list(columns.values()), axis=-1)
    row = ",".join(["%.9g"] * len(columns)) + "\n"
    return csv_text([map(csv_cell, columns)]) + _rows("", [row] * len(values), values)


def _rows(outer: str, rows: list[str], values: FloatArray) -> str:
    """Return the rows of one block: what stands before all of them, and after it each row's template filled in."""
    text: str = outer.join(["", *rows]) % tuple(values.ravel().tolist())
    return text.replace("nan", "") if np.isnan(values).any() else text
