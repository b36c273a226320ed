"""What a number in a text file looks like, and the slow, exact way to read a column."""

import csv
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import DataError
from ropefric.traces.readers.source import Source

NAN_TEXTS = ("nan", "NaN", "NAN", "Nan", "-nan", "-NaN")
"""Cell texts that mean "no value" in every file, beside the empty cell."""

_NUMBER = {
    mark: re.compile(
        rf"[+-]?(?:\d++(?:{re.escape(mark)}\d*+)?|{re.escape(mark)}\d++)(?:[eE][+-]?\d++)?", re.ASCII
    )
    for mark in ".,"
}
_DIGITS_AND_MARKS = re.compile(r"[+-]?[\d.,]++")
_DATE = re.compile(r"\d[-/:.]\d++[-/:.]\d")
_NAMED_MISSING = (
    "na",
    "n/a",
    "#n/a",
    "null",
    "none",
    "-",
    "--",
    "---",
    "?",
    "missing",
    "error",
    "over",
    "ovl",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class CellStyle:
    """How cells are divided and written."""

    separator: str = ","
    decimal: str = "."
    missing: tuple[str, ...] = ()

    @property
    def no_value(self) -> frozenset[str]:
        """Return every cell text that stands for "no value"."""
        return frozenset(("", *NAN_TEXTS, *(text.strip() for text in self.missing)))


def split_line(line: str, separator: str) -> list[str]:
    """Return a line's cells without blanks and quotes around them."""
    if separator == " ":
        return [cell.strip('"') for cell in line.split()]
    if '"' not in line:
        return [cell.strip() for cell in line.split(separator)]
    try:
        cells = next(csv.reader([line], delimiter=separator, skipinitialspace=separator != "\t"), [])
    except csv.Error:
        cells = line.split(separator)
    return [cell.strip() for cell in cells]


def is_blank_line(line: str, separator: str) -> bool:
    r"""Return whether a line holds nothing, not even an empty cell."""
    return not line.strip(" " if separator == "\t" else " \t")


def is_number(cell: str, decimal: str) -> bool:
    """Return whether a cell is a finite number with this decimal mark, written in plain digits."""
    return _NUMBER[decimal].fullmatch(cell) is not None


def parse_rows(
    lines: Iterator[tuple[int, str]],
    columns: Sequence[int],
    names: Sequence[str],
    style: CellStyle,
    source: Source,
) -> list[FloatArray]:
    """Return columns of text lines, cell by cell: the definition that the fast way must agree with."""
    no_value, found = style.no_value, []
    for number, line in lines:
        if is_blank_line(line, style.separator):
            continue
        cells = split_line(line, style.separator)
        row = []
        for column in columns:
            cell = cells[column] if column < len(cells) else ""
            if cell in no_value:
                row.append(math.nan)
                continue
            value = float(cell.replace(",", ".")) if is_number(cell, style.decimal) else math.inf
            if math.isinf(value):
                raise bad_cell(cell, column, names, style, source, line=number)
            row.append(value)
        found.append(row)
    table = np.array(found, dtype=np.float64).reshape(len(found), len(columns))
    return [np.ascontiguousarray(table[:, i]) for i in range(len(columns))]


def bad_cell(
    cell: str, column: int, names: Sequence[str], style: CellStyle, source: Source, *, line: int | None
) -> DataError:
    """Return the error for a cell that is no number, with a guess at what it is."""
    name = names[column] if column < len(names) and names[column] else f"column {column + 1}"
    other = "," if style.decimal == "." else "."
    why, fix = "", "mend or remove the cell, or list its text in [import] missing"
    if is_number(cell, style.decimal):
        why, fix = "it is too large for a float", "mend the cell"
    elif cell.lower().lstrip("+-") in ("inf", "infinity"):
        why = "an infinite value is no measurement"
    elif is_number(cell, other):
        mark = "comma" if other == "," else "point"
        why, fix = f"it looks like a decimal {mark}", f'[import] decimal = "{other}"'
    elif "," in cell and _DIGITS_AND_MARKS.fullmatch(cell):
        why, fix = "it looks like a thousands separator", "save the file without thousands separators"
    elif cell.lower() in _NAMED_MISSING:
        why, fix = "it looks like a mark for a missing value", f'[import] missing = ["{cell}"]'
    elif _DATE.search(cell):
        why = "it looks like a date or a clock"
        fix = "export seconds since the start, or leave the column out and set [import] sampling_rate"
    shown = cell if len(cell) <= 40 else cell[:37] + "..."
    message = f"cannot read {shown!r} as a number" + (f"; {why}" if why else "")
    return source.error(message, code="RF102", line=line, key=name, fix=fix)
