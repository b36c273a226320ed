"""Excel and OpenDocument sheets, read as the text that they would be saved as; needs the extra `lab`."""

import csv
import datetime as dt
import io
from dataclasses import replace
from typing import Any

from ropefric.errors import DataError
from ropefric.files.text import Source, Text
from ropefric.files.text_table import is_number
from ropefric.traces.readers.delimited import open_text, text_table
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.table import (
    Reader,
    Table,
    check_choice,
    foreign,
    package,
    recordings_among,
)


def _tables(source: Source, profile: ImportProfile) -> tuple[Table, ...]:
    """Return the table of the sheet that the profile names, else of every sheet that has the columns of the longest."""
    layout = replace(profile, separator=";", decimal=profile.decimal or ".")
    tables: dict[str, Table] = {}
    sizes: dict[str, int] = {}
    errors: list[DataError] = []
    for name, grid in _grids(source, profile.table).items():
        content = _as_csv([[*map(_with_clock, row)] for row in grid], layout.decimal)
        try:
            text = Text(source=source, data=content.encode(), encoding="utf-8")
            text, dialect = open_text(source, layout, text)
            # Every row of a sheet is as wide as the sheet, and a column needs no header.
            names = (*dialect.header, *[""] * dialect.n_cells)[: dialect.n_cells]
            tables[name] = text_table(text, dialect, names)
            sizes[name] = content.count("\n") - dialect.rows.data_row
        except DataError as error:
            errors.append(error)
    if not tables:
        raise errors[0] if errors else source.error("no sheet holds anything", fix="record it again")
    return recordings_among(tables, sizes, profile, "sheets")


def sheet_as_csv(source: Source) -> tuple[str, str]:
    """Return the rows of the first sheet that has any, and which of several it was.

    All numbers get the decimal mark of numbers that stand as text, "1,5" in German sheets, else a point.
    """
    grids = _grids(source)
    name, grid = next(((name, grid) for name, grid in grids.items() if grid), ("", []))
    texts = (cell for row in grid for cell in row if isinstance(cell, str))
    mark = "," if any("," in text and is_number(text.strip(), ",") for text in texts) else "."
    return _as_csv(grid, mark), f"read from the sheet {name!r}, one of {len(grids)}" if len(grids) > 1 else ""


_Grid = list[list[Any]]


def _grids(source: Source, table: str = "") -> dict[str, _Grid]:
    """Return the cells of a book's sheets, or of the one that is named, without empty rows at the end."""
    raw = io.BytesIO(source.raw_bytes())
    fix = "save it again as .xlsx or .csv, or name its format in [import] format"
    with foreign(source, "this is not a readable sheet", fix):
        book = package("python_calamine", "sheets", source).CalamineWorkbook.from_filelike(raw)
        check_choice(table, book.sheet_names, "sheet", source)
        sheets = {name: book.get_sheet_by_name(name) for name in ([table] if table else book.sheet_names)}
        # From the first row on, so that row numbers are those the sheet shows; a formula that failed is an empty cell.
        grids = {name: sheet.to_python(skip_empty_area=False) for name, sheet in sheets.items()}
    for grid in grids.values():
        while grid and not any(map(_text, grid[-1])):
            grid.pop()
    return grids


def _as_csv(grid: _Grid, mark: str) -> str:
    """Return rows as lines with ";" between the cells."""

    def written(cell: Any) -> str:
        if isinstance(cell, float):
            return str(int(cell)) if cell.is_integer() else repr(cell).replace(".", mark)
        return " ".join(_text(cell).split())

    stream = io.StringIO()
    csv.writer(stream, delimiter=";", lineterminator="\n").writerows([*map(written, row), ""] for row in grid)
    return stream.getvalue()


def _with_clock(cell: Any) -> Any:
    """Return a date with its time of day: a package shows the stamp of midnight as a day."""
    is_day = isinstance(cell, dt.date) and not isinstance(cell, dt.datetime)
    return dt.datetime.combine(cell, dt.time()) if is_day else cell


def _text(cell: Any) -> str:
    return "" if cell is None else str(cell).strip()


READER = Reader(
    name="excel",
    suffixes=(".xlsx", ".xls", ".ods"),
    description="Excel and OpenDocument sheets (extra lab)",
    tables=_tables,
)
