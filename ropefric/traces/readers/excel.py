"""Excel and OpenDocument sheets, read as the text that they would be saved as; needs the extra `lab`."""

import csv
import io
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

from ropefric.files.text import Source, Text
from ropefric.files.text_table import is_number
from ropefric.traces.readers.delimited import open_text, text_table
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.table import Reader, Table, check_choice, foreign, needs_package

ERRORS = ("#DIV/0!", "#N/A", "#NAME?", "#NULL!", "#NUM!", "#REF!", "#VALUE!")
"""Cells whose formula failed; they hold no value, and python-calamine shows them empty."""


def _tables(source: Source, profile: ImportProfile) -> tuple[Table, ...]:
    """Return the table of one sheet: the profile's, else the first that has content."""
    layout = replace(profile, separator=";", decimal=profile.decimal or ".")
    content, said = sheet_as_csv(source, profile.table, layout.decimal)
    text = Text(source=source, data=content.encode(), encoding="utf-8")
    text, dialect = open_text(source, layout, text)
    dialect.notes.extend([said] if said else [])
    # Every row of a sheet is as wide as the sheet, and a column needs no header.
    names = (*dialect.header, *[""] * dialect.n_cells)[: dialect.n_cells]
    return (text_table(text, dialect, names),)


def sheet_as_csv(source: Source, table: str = "", mark: str = "") -> tuple[str, str]:
    """Return the rows of a sheet as lines with ";" between the cells, and which sheet of several it was.

    Without a decimal mark all numbers get that of numbers that stand as text, "1,5" in German sheets, else a point.
    """
    raw = io.BytesIO(source.raw_bytes())
    fix = "save it again as .xlsx or .csv, or name its format in [import] format"
    with foreign(source, "this is not a readable sheet", fix):
        sheets, rows_of = _open(raw, source)
        check_choice(table, sheets, "sheet", source)
        grids = ((name, [list(row) for row in rows_of(name)]) for name in ([table] if table else sheets))
        name, grid = next((found for found in grids if found[1]), ("", []))
    while grid and not any(map(_text, grid[-1])):
        grid.pop()
    texts = (cell for row in grid for cell in row if isinstance(cell, str))
    if not mark:
        mark = "," if any("," in text and is_number(text.strip(), ",") for text in texts) else "."

    def written(cell: Any) -> str:
        if isinstance(cell, float):
            return str(int(cell)) if cell.is_integer() else repr(cell).replace(".", mark)
        return " ".join(_text(cell).split())

    stream = io.StringIO()
    csv.writer(stream, delimiter=";", lineterminator="\n").writerows([*map(written, row), ""] for row in grid)
    return stream.getvalue(), f"read from the sheet {name!r}, one of {len(sheets)}" if len(sheets) > 1 else ""


def _text(cell: Any) -> str:
    return "" if cell is None or cell in ERRORS else str(cell).strip()


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
