"""Excel and OpenDocument sheets; needs the extra `lab`."""

import io
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.registry import did_you_mean
from ropefric.traces.readers.cells import CellStyle, bad_cell, is_number
from ropefric.traces.readers.header import find_table_rows
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.reader import Reader
from ropefric.traces.readers.source import Source
from ropefric.traces.readers.table import Table

Grid = list[list[Any]]

ERRORS = ("#DIV/0!", "#N/A", "#NAME?", "#NULL!", "#NUM!", "#REF!", "#VALUE!")
"""Cells whose formula failed; they hold no value, and python-calamine shows them empty."""


def _tables(source: Source, profile: ImportProfile) -> tuple[Table, ...]:
    """Return the table of one sheet: the profile's, else the first that has content."""
    grid = _load(source, profile.table)
    texts = [[_text(cell) for cell in row] for row in grid]
    rows = find_table_rows(texts, profile, source)
    n_columns = max(
        (i + 1 for row in texts[rows.data_row - 1 :] for i, cell in enumerate(row) if cell), default=0
    )
    header = texts[rows.header_row - 1] if rows.header_row else []
    units = texts[rows.units_row - 1] if rows.units_row else []
    names = tuple([*header, *[""] * n_columns][:n_columns])
    style = CellStyle(separator="\t", decimal=profile.decimal or ".", missing=tuple(profile.missing))

    def values(indices: Sequence[int]) -> list[FloatArray]:
        body = list(enumerate(grid[rows.data_row - 1 :], start=rows.data_row))
        while body and not any(_text(cell) for cell in body[-1][1]):
            body.pop()
        return [
            np.array(
                [_number(row, index, names, style, source, line=line) for line, row in body], dtype=np.float64
            )
            for index in indices
        ]

    return (
        Table(
            names=names,
            units=tuple([*units, *[""] * n_columns][:n_columns]),
            values=values,
            has_header=any(names),
            first_line=rows.data_row,
        ),
    )


def _text(cell: Any) -> str:
    """Return a cell as text; numbers with a decimal point, whatever the sheet shows."""
    if cell is None or cell in ERRORS:
        return ""
    return repr(cell) if isinstance(cell, float) else str(cell).strip()


def _number(
    row: Sequence[Any], index: int, names: Sequence[str], style: CellStyle, source: Source, *, line: int
) -> float:
    cell = row[index] if index < len(row) else None
    if isinstance(cell, int | float) and not isinstance(cell, bool) and math.isfinite(cell):
        return float(cell)
    text = _text(cell)
    if text in style.no_value:
        return math.nan
    if isinstance(cell, str) and is_number(text, style.decimal):
        value = float(text.replace(",", "."))
        if math.isfinite(value):
            return value
    raise bad_cell(text, index, names, style, source, line=line)


def _load(source: Source, table: str) -> Grid:
    raw = source.raw_bytes()
    try:
        from python_calamine import CalamineWorkbook  # noqa: PLC0415  (an extra that is not always there)
    except ImportError:
        return _load_openpyxl(raw, source, table)
    try:
        book = CalamineWorkbook.from_filelike(io.BytesIO(raw))
        sheets = book.sheet_names
        chosen = _choose(sheets, table, source)
        # From the first row on, so that row numbers are those the sheet shows.
        grids = (
            [list(r) for r in book.get_sheet_by_name(name).to_python(skip_empty_area=False)]
            for name in chosen
        )
        return next((grid for grid in grids if grid), [])
    except MemoryError:
        raise
    except Exception as error:
        if getattr(error, "code", "") == "RF105":
            raise
        raise _unreadable(error, source) from None


def _load_openpyxl(raw: bytes, source: Source, table: str) -> Grid:
    try:
        from openpyxl import load_workbook  # noqa: PLC0415  (an extra that is not always there)
    except ImportError:
        raise source.error(
            "reading sheets needs the package python-calamine or openpyxl",
            code="RF107",
            fix='pip install "ropefric[lab]"',
        ) from None
    try:
        book = load_workbook(io.BytesIO(raw), read_only=True, data_only=True)
        chosen = _choose(book.sheetnames, table, source)
        grids = ([list(row) for row in book[name].iter_rows(values_only=True)] for name in chosen)
        return next((grid for grid in grids if grid), [])
    except MemoryError:
        raise
    except Exception as error:
        if getattr(error, "code", "") == "RF105":
            raise
        raise _unreadable(error, source) from None


def _choose(sheets: Sequence[str], table: str, source: Source) -> Sequence[str]:
    if not table:
        return sheets
    if table not in sheets:
        raise source.error(
            f"there is no sheet {table!r}",
            code="RF105",
            key="[import] table",
            fix=did_you_mean(table, sheets),
        )
    return [table]


def _unreadable(error: Exception, source: Source) -> Exception:
    return source.error(
        f"this is not a readable sheet ({type(error).__name__}: {error})",
        fix="save it again as .xlsx or .csv, or name its format in [import] format",
    )


READER = Reader(
    name="excel",
    suffixes=(".xlsx", ".xls", ".ods"),
    description="Excel and OpenDocument sheets (extra lab)",
    tables=_tables,
)
