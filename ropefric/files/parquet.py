"""Tables as Parquet, which needs an extra: rows written with their types, and read as the CSV that they would be."""

import io
from collections.abc import Mapping, Sequence
from importlib import import_module
from math import isnan
from typing import Any

from ropefric.errors import DataError, InputError
from ropefric.files.plain_text import csv_cell, csv_text

MOST_CELLS = 100_000_000
MOST_BYTES = 2 * 2**30
"""Of a table that is read, once unpacked."""


def arrow(key: str = "") -> tuple[Any, Any]:
    """Return pyarrow and its Parquet; `key` is what asked for it."""
    try:
        return import_module("pyarrow"), import_module("pyarrow.parquet")
    except ImportError:
        message = "Parquet needs pyarrow, which is not installed"
        fix = 'pip install "ropefric[parquet]", or use CSV'
        raise InputError(message, code="RF107", key=key, fix=fix) from None


def parquet_bytes(rows: Sequence[Mapping[str, Any]], *, key: str) -> bytes:
    """Return rows of the same keys as a Parquet file; a column without any value is one of numbers."""
    pyarrow, parquet = arrow(key)
    columns = {name: pyarrow.array([row[name] for row in rows]) for name in (rows[0] if rows else ())}
    empty = pyarrow.null()
    typed = {name: one.cast("float64") if one.type == empty else one for name, one in columns.items()}
    stream = io.BytesIO()
    parquet.write_table(pyarrow.table(typed), stream)
    return stream.getvalue()


def parquet_as_csv(content: bytes, shown: str) -> str:
    """Return a Parquet file as CSV: numbers with all their digits, empty cells where there is none."""
    pyarrow, parquet = arrow()
    try:
        file = parquet.ParquetFile(io.BytesIO(content))
        about = file.metadata
        size = sum(about.row_group(i).total_byte_size for i in range(about.num_row_groups))
        if about.num_rows * about.num_columns > MOST_CELLS or size > MOST_BYTES:
            shape = f"{about.num_rows} rows of {about.num_columns} columns, {size} bytes"
            message = f"the table has {shape}: too many"
            raise DataError(message, path=shown, fix="check that this is the table you mean, or split it")
        table = file.read()
        columns = [table.column(i).to_pylist() for i in range(table.num_columns)]
    except (pyarrow.ArrowException, OSError, ValueError) as error:
        message = f"this is not a readable Parquet file: {error}"
        raise DataError(message, path=shown, fix="write it again, or save the table as CSV") from None
    rows = (table.column_names, *zip(*columns, strict=True))
    return csv_text(map(_cell, row) for row in rows)


def _cell(value: Any) -> Any:
    if value is None or (isinstance(value, float) and isnan(value)):
        return ""
    return csv_cell(value if isinstance(value, bool | int | float) else " ".join(str(value).split()))
