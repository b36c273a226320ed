"""A sweep as a CSV file: written fast, because it may have a million rows."""

import csv
import io
from collections.abc import Iterable, Mapping
from itertools import product
from pathlib import Path

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.files.folder import Folder
from ropefric.files.plain_text import to_spreadsheet
from ropefric.scenes.sweep import Sweep

_BLOCK = 50_000


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
        stream.write(_header(header_of(sweep)).encode())
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
    return _header(columns) + _rows("", [row] * len(values), values)


def _header(names: Iterable[str]) -> str:
    stream = io.StringIO()
    csv.writer(stream, lineterminator="\n").writerow(map(to_spreadsheet, names))
    return stream.getvalue()


def _rows(outer: str, rows: list[str], values: FloatArray) -> str:
    """Return the rows of one block: what stands before all of them, and after it each row's template filled in."""
    text: str = outer.join(["", *rows]) % tuple(values.ravel().tolist())
    return text.replace("nan", "") if np.isnan(values).any() else text
