"""The rows of a trial table as numbers, and everything that is wrong with them."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from ropefric.errors import Problem
from ropefric.fitting.table_columns import OPTIONAL_NUMBERS, REQUIRED_NUMBERS
from ropefric.trials.trial_cells import Row, decimal_mark, read_row
from ropefric.trials.trial_columns import BoundColumn
from ropefric.trials.trial_table import CellTable

__all__ = ["ParsedRow", "parse_rows"]

_EMPTY = frozenset({"nan", "na", "n/a", "none", "null", "<na>", "-"})
_TRUE = frozenset({"", "true", "yes", "1", "1.0", "kept"})
_FALSE = frozenset({"false", "no", "0", "0.0", "rejected"})


@dataclass(frozen=True, slots=True, kw_only=True)
class ParsedRow:
    """One trial as read.

    Attributes
    ----------
    line : int
        1-based line, or row of a frame.
    trial, status : str
        Its name and what became of its recording.
    kept : bool
        Whether it may be used.
    numbers : dict of str to float
        SI numbers by field; NaN where there is none.
    """

    line: int
    trial: str
    status: str
    kept: bool
    numbers: dict[str, float]


def parse_rows(
    table: CellTable, columns: dict[str, BoundColumn]
) -> tuple[tuple[ParsedRow, ...], tuple[Problem, ...]]:
    """Return the trials and what is wrong with them, all at once.

    A row that is not kept, or whose recording gave no force, may lack numbers; a row that is to be used may not.

    Parameters
    ----------
    table : CellTable
        The cells.
    columns : dict
        From `bind_table_columns`.

    Examples
    --------
    >>> from ropefric.fitting.table_columns import bind_table_columns
    >>> cells = CellTable(
    ...     path="a.csv",
    ...     separator=",",
    ...     header=("wheel_radius_mm", "rope_diameter_mm", "wrap_turns", "end_tension_N", "peak_N"),
    ...     header_line=1,
    ...     rows=((2, ("40", "9.8", "1.5", "80", "60")),),
    ... )
    >>> columns, _, _ = bind_table_columns(cells.header, cells.path, 1)
    >>> print(parse_rows(cells, columns)[1][0].message)
    the break-away force 60 N is not above the end tension 80 N: friction can only add to it
    """
    cleaned = [(line, tuple(_cleaned(cell) for cell in cells)) for line, cells in table.rows]
    table = replace(table, rows=tuple(cleaned))
    decimal = decimal_mark(table, columns)
    problems: list[Problem] = []
    parsed: list[ParsedRow] = []
    for line, cells in cleaned:
        row = read_row(cells, line, columns, table.path, decimal)
        found, wrong = _parse(row, columns, table.path)
        parsed.append(found)
        problems += wrong
    problems += _names_twice(parsed, table.path)
    problems += _rows_twice(parsed, table.path)
    return tuple(parsed), tuple(problems)


def _cleaned(cell: str) -> str:
    return "" if cell.strip().lower() in _EMPTY else cell.strip()


def _parse(row: Row, columns: dict[str, BoundColumn], path: str) -> tuple[ParsedRow, list[Problem]]:
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
    numbers = dict.fromkeys((*REQUIRED_NUMBERS, *OPTIONAL_NUMBERS), math.nan) | row.numbers
    parsed = ParsedRow(
        line=row.line,
        trial=row.texts.get("trial", "") or f"row-{row.line}",
        status=row.texts.get("status", "").lower() or "ok",
        kept=word not in _FALSE,
        numbers=numbers,
    )
    if parsed.kept and parsed.status == "ok":
        problems += _unusable(parsed, row.unreadable, columns, path)
    return parsed, problems


def _unusable(
    row: ParsedRow, unreadable: frozenset[str], columns: dict[str, BoundColumn], path: str
) -> Iterator[Problem]:
    fix = "write the number, or set the trial aside with kept = false"
    for field in REQUIRED_NUMBERS:
        if field in columns and field not in unreadable and math.isnan(row.numbers[field]):
            yield Problem(
                code="RF121",
                message="the cell is empty or NaN, but the trial is to be used",
                path=path,
                line=row.line,
                key=columns[field].header,
                fix=fix,
            )
    for field in ("peak_N", *OPTIONAL_NUMBERS):
        value = row.numbers[field]
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
    peak_N, end_N = row.numbers["peak_N"], row.numbers["end_tension_N"]
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


def _names_twice(rows: Sequence[ParsedRow], path: str) -> Iterator[Problem]:
    first: dict[str, int] = {}
    for row in rows:
        if row.trial in first:
            yield Problem(
                code="RF122",
                message=f"the trial '{row.trial}' stands in line {first[row.trial]} already",
                path=path,
                line=row.line,
                key="trial",
                fix="remove one of the two rows, or give it a name of its own",
            )
        first.setdefault(row.trial, row.line)


def _rows_twice(rows: Sequence[ParsedRow], path: str) -> Iterator[Problem]:
    """Yield a warning for rows that agree in every number: measured twice alike, or pasted twice."""
    first: dict[tuple[str, ...], int] = {}
    for row in rows:
        key = tuple(repr(row.numbers[field]) for field in REQUIRED_NUMBERS)
        if "nan" in key or not row.kept:
            continue
        if key in first:
            yield Problem(
                code="RF122",
                message=f"all numbers are those of line {first[key]}",
                path=path,
                line=row.line,
                fix="remove the row if it was pasted twice: it would count as a repeat",
                severity="warning",
            )
        first.setdefault(key, row.line)
