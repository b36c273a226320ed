"""Excel and OpenDocument sheets; needs the extra `lab`."""

import io
import math
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.files.stamps import is_stamp
from ropefric.files.text import Source
from ropefric.files.text_table import find_head_rows, is_number
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.table import (
    Reader,
    Table,
    bad_cell,
    check_choice,
    foreign,
    needs_package,
    stamp_column,
)

ERRORS = ("#DIV/0!", "#N/A", "#NAME?", "#NULL!", "#NUM!", "#REF!", "#VALUE!")
"""Cells whose formula failed; they hold no value, and python-calamine shows them empty."""


def _tables(source: Source, profile: ImportProfile) -> tuple[Table, ...]:
    """Return the table of one sheet: the profile's, else the first that has content."""
    grid = _load(source, profile.table)
    texts = [[_text(cell) for cell in row] for row in grid]
    rows = find_head_rows(texts, profile, source)
    n_columns = max(
        (i + 1 for row in texts[rows.data_row - 1 :] for i, cell in enumerate(row) if cell), default=0
    )
    names, units = (
        tuple([*(texts[row - 1] if row else []), *[""] * n_columns][:n_columns]) for row in rows[:2]
    )

    first = next((row for row in texts[rows.data_row - 1 :] if any(row)), [])
    stamps, notes = frozenset(index for index, cell in enumerate(first) if is_stamp(cell)), list[str]()

    def values(indices: Sequence[int]) -> list[FloatArray]:
        body = list(enumerate(grid[rows.data_row - 1 :], start=rows.data_row))
        while body and not any(_text(cell) for cell in body[-1][1]):
            body.pop()

        decimal = profile.decimal or "."
        no_value = profile.no_value_numbers(decimal)

        def number(cell: Any, index: int, line: int) -> float:
            if isinstance(cell, int | float) and not isinstance(cell, bool) and math.isfinite(cell):
                return math.nan if cell in no_value else float(cell)
            text = _text(cell)
            if text in profile.no_value:
                return math.nan
            value = (
                float(text.replace(",", "."))
                if isinstance(cell, str) and is_number(text, decimal)
                else math.inf
            )
            if math.isfinite(value):
                return value
            raise bad_cell(text, names[index] or f"column {index + 1}", decimal, source, line=line)

        def column(i: int) -> FloatArray:
            cells = [(line, row[i] if i < len(row) else None) for line, row in body]
            if i not in stamps:
                return np.array([number(cell, i, line) for line, cell in cells], dtype=np.float64)
            written = ((line, _text(cell)) for line, cell in cells)
            return stamp_column(written, names[i] or f"column {i + 1}", profile, source, notes)

        return [column(index) for index in indices]

    return (
        Table(
            names=names,
            units=tuple("s" if i in stamps else unit for i, unit in enumerate(units)),
            values=values,
            has_header=any(names),
            first_line=rows.data_row,
            stamps=stamps,
            notes=notes,
        ),
    )


def _text(cell: Any) -> str:
    """Return a cell as text; numbers with a decimal point, whatever the sheet shows."""
    if cell is None or cell in ERRORS:
        return ""
    return repr(cell) if isinstance(cell, float) else str(cell).strip()


def _load(source: Source, table: str) -> list[list[Any]]:
    """Return the cells of the sheet named, else of the first that has content."""
    raw = io.BytesIO(source.raw_bytes())
    with foreign(
        source,
        "this is not a readable sheet",
        "save it again as .xlsx or .csv, or name its format in [import] format",
    ):
        sheets, rows_of = _open(raw, source)
        check_choice(table, sheets, "sheet", source)
        grids = ([list(row) for row in rows_of(name)] for name in ([table] if table else sheets))
        return next((grid for grid in grids if grid), [])


def _open(raw: io.BytesIO, source: Source) -> tuple[Sequence[str], Callable[[str], Iterable[Sequence[Any]]]]:
    """Return the names of a book's sheets, and a way to the rows of each, by whichever package there is."""
    with suppress(ImportError):
        from python_calamine import CalamineWorkbook  # noqa: PLC0415  (an extra that is not always there)

        book = CalamineWorkbook.from_filelike(raw)
        # From the first row on, so that row numbers are those the sheet shows.
        return book.sheet_names, lambda name: book.get_sheet_by_name(name).to_python(skip_empty_area=False)
    try:
        from openpyxl import load_workbook  # noqa: PLC0415  (an extra that is not always there)
    except ImportError:
        raise needs_package("sheets needs the package python-calamine or openpyxl", source) from None
    pages = load_workbook(raw, read_only=True, data_only=True)
    return pages.sheetnames, lambda name: pages[name].iter_rows(values_only=True)


READER = Reader(
    name="excel",
    suffixes=(".xlsx", ".xls", ".ods"),
    description="Excel and OpenDocument sheets (extra lab)",
    tables=_tables,
)
