"""The rows of a trial table as numbers, and everything that is wrong with them."""

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from decimal import Decimal

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import Problem
from ropefric.files.plain_text import from_spreadsheet
from ropefric.fitting.table_columns import OPTIONAL_NUMBERS, REQUIRED_NUMBERS
from ropefric.quantities import unit_factor
from ropefric.trials.trial_cells import NUMBER, POSITIVE, Row, decimal_mark, read_row
from ropefric.trials.trial_columns import BoundColumn
from ropefric.trials.trial_table import CellTable

_EMPTY = frozenset({"nan", "na", "n/a", "none", "null", "<na>", "-"})
_TRUE = frozenset({"", "true", "yes", "1", "1.0", "kept"})
_FALSE = frozenset({"false", "no", "0", "0.0", "rejected"})
# Warnings about single rows; beyond, only their number.
_MOST_TOLD = 20


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ParsedRows:
    """All trials as read, by column."""

    trial: list[str]
    status: list[str]
    kept: BoolArray
    numbers: dict[str, FloatArray]


def parse_rows(table: CellTable, columns: dict[str, BoundColumn]) -> tuple[ParsedRows, tuple[Problem, ...]]:
    """Return the trials and what is wrong with them, all at once.

    A row that is not kept, or whose recording gave no force, may lack numbers; a row that is to be used may not.
    Columns are read as a whole; only rows in which something is wrong are read again, cell by cell, to say what.
    """
    lines = [line for line, _ in table.rows]
    n, by_index = len(lines), list(zip(*(cells for _, cells in table.rows), strict=True))
    texts = {field: _cleaned(by_index[column.index]) for field, column in columns.items()} if n else {}
    names = [from_spreadsheet(name) for name in texts.get("trial", [""] * n)]
    decimal = decimal_mark(table, columns)
    numbers = {field: np.full(n, np.nan) for field in (*REQUIRED_NUMBERS, *OPTIONAL_NUMBERS)}
    doubtful = np.zeros(n, dtype=np.bool_)
    for field, cells in texts.items():
        if columns[field].si_unit:
            numbers[field], unread = _numbers(cells, columns[field], decimal)
            doubtful |= unread
    words = [word.lower() for word in texts.get("kept", [""] * n)]
    meaning = {word: word not in _FALSE for word in set(words)}
    kept = np.array([meaning[word] for word in words], dtype=np.bool_)
    status = [word.lower() or "ok" for word in texts.get("status", [""] * n)]
    wrong_word = meaning.keys() - _TRUE - _FALSE
    if wrong_word:
        doubtful |= np.array([word in wrong_word for word in words], dtype=np.bool_)
    doubtful |= (
        kept
        & np.array([word == "ok" for word in status], dtype=np.bool_)
        & _unusable(numbers, columns.keys())
    )
    problems: list[Problem] = []
    for i in np.flatnonzero(doubtful).tolist():
        cells = [""] * len(table.header)
        for field, column in columns.items():
            cells[column.index] = texts[field][i]
        row = read_row(tuple(cells), lines[i], columns, table.path, decimal)
        problems += _wrong(row, columns, table.path)
    trial = [name or f"row-{line}" for name, line in zip(names, lines, strict=True)]
    problems += _names_twice(trial, lines, table.path)
    problems += _rows_twice(numbers, kept, lines, table.path)
    return ParsedRows(trial=trial, status=status, kept=kept, numbers=numbers), tuple(problems)


def _cleaned(cells: Sequence[str]) -> list[str]:
    meaning = {cell: "" if cell.strip().lower() in _EMPTY else cell.strip() for cell in set(cells)}
    return [meaning[cell] for cell in cells]


def _numbers(cells: list[str], column: BoundColumn, decimal: str) -> tuple[FloatArray, BoolArray]:
    """Return a column's cells in SI, NaN where empty, and which must be read one by one to say what is wrong."""
    factor = unit_factor(column.unit, column.si_unit, name=column.header)
    exact, other = Decimal(repr(factor)), "," if decimal == "." else "."
    meaning: dict[str, float] = {"": math.nan}
    for cell in set(cells) - {""}:
        value = math.inf
        if NUMBER.fullmatch(cell) and other not in cell:
            plain = cell.replace(",", ".")
            # As `parse_quantity`: 9.8 * 0.001 is not 0.0098 in binary.
            value = (float(plain) if factor == 1.0 else float(Decimal(plain) * exact)) * column.scale
            if value == 0.0 and any(digit in plain for digit in "123456789"):
                value = math.inf
        meaning[cell] = value
    values = np.array([meaning[cell] for cell in cells], dtype=np.float64)
    unread = np.isinf(values)
    if column.field in POSITIVE:
        unread |= ~np.isnan(values) & ~((values > 0.0) & (values < 1e30))
    return values, unread


def _unusable(numbers: dict[str, FloatArray], given: Collection[str]) -> BoolArray:
    """Return which rows lack a number, or have one that cannot be, if they are to be used."""
    peak_N, end_N = numbers["peak_N"], numbers["end_tension_N"]
    wrong = (peak_N <= end_N) | (peak_N == 0.0)
    for field in given:
        if field in numbers:
            wrong |= (numbers[field] < 0.0) | np.isinf(numbers[field])
            wrong |= np.isnan(numbers[field]) & (field in REQUIRED_NUMBERS)
    return np.asarray(wrong)


def _wrong(row: Row, columns: dict[str, BoundColumn], path: str) -> list[Problem]:
    """Return what is wrong with one row."""
    problems = list(row.problems)
    word = row.texts.get("kept", "").lower()
    if word not in _TRUE | _FALSE:
        problems.append(
            Problem(
                code="RF102",
                message=f"'{row.texts['kept'][:40]}' does not say whether the trial is kept",
                path=path,
                line=row.line,
                key=columns["kept"].header,
                fix="write true or false",
            )
        )
    if word not in _FALSE and (row.texts.get("status", "").lower() or "ok") == "ok":
        problems += _why_unusable(row, columns, path)
    return problems


def _why_unusable(row: Row, columns: dict[str, BoundColumn], path: str) -> Iterator[Problem]:
    fix = "write the number, or set the trial aside with kept = false"
    numbers = dict.fromkeys((*REQUIRED_NUMBERS, *OPTIONAL_NUMBERS), math.nan) | row.numbers
    for field in REQUIRED_NUMBERS:
        if field in columns and field not in row.unreadable and math.isnan(numbers[field]):
            yield Problem(
                code="RF121",
                message="the cell is empty or NaN, but the trial is to be used",
                path=path,
                line=row.line,
                key=columns[field].header,
                fix=fix,
            )
    for field in ("peak_N", *OPTIONAL_NUMBERS):
        value = numbers[field]
        if value < 0 or math.isinf(value) or (field == "peak_N" and value == 0):
            yield Problem(
                code="RF110",
                message=f"{value:g} (SI) is no possible value; it must be finite and "
                + ("above zero" if field == "peak_N" else "zero or more"),
                path=path,
                line=row.line,
                key=columns[field].header,
                fix="correct the number",
            )
            return
    peak_N, end_N = numbers["peak_N"], numbers["end_tension_N"]
    if peak_N <= end_N:
        yield Problem(
            code="RF411",
            message=f"the break-away force {peak_N:.6g} N is not above the end tension {end_N:.6g} N: "
            "friction can only add to it",
            path=path,
            line=row.line,
            key=columns["peak_N"].header,
            fix="check whether the two columns or their units are exchanged, or set the trial aside with "
            "kept = false",
        )


def _names_twice(names: Sequence[str], lines: Sequence[int], path: str) -> Iterator[Problem]:
    if len(set(names)) == len(names):
        return
    first: dict[str, int] = {}
    for name, line in zip(names, lines, strict=True):
        if name in first:
            yield Problem(
                code="RF122",
                message=f"the trial '{name}' stands in line {first[name]} already",
                path=path,
                line=line,
                key="trial",
                fix="remove one of the two rows, or give it a name of its own",
            )
        first.setdefault(name, line)


def _rows_twice(
    numbers: dict[str, FloatArray], kept: BoolArray, lines: Sequence[int], path: str
) -> Iterator[Problem]:
    """Yield a warning for rows that agree in every number: measured twice alike, or pasted twice."""
    values = np.stack([numbers[field] for field in REQUIRED_NUMBERS], axis=-1)
    rows = np.flatnonzero(kept & ~np.isnan(values).any(axis=1))
    if not rows.size:
        return
    order = rows[np.lexsort(values[rows].T)]  # stable: the first of equal rows comes first
    same = np.append(False, (values[order[1:]] == values[order[:-1]]).all(axis=1))
    begins = np.maximum.accumulate(np.where(same, 0, np.arange(order.size)))
    pairs = sorted(zip(order[same].tolist(), order[begins[same]].tolist(), strict=True))
    fix = "remove the row if it was pasted twice: it would count as a repeat"
    for row, earlier in pairs[:_MOST_TOLD]:
        message = f"all numbers are those of line {lines[earlier]}"
        yield Problem(code="RF122", message=message, path=path, line=lines[row], fix=fix, severity="warning")
    if len(pairs) > _MOST_TOLD:
        message = f"{len(pairs) - _MOST_TOLD} more rows have all the numbers of an earlier one"
        yield Problem(code="RF122", message=message, path=path, fix=fix, severity="warning")
