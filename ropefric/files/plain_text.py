"""Output: numbers to their significant digits, and text of others made harmless.

Sine, logarithm and linear algebra differ in the last bits from processor to processor and from one version of a
library to the next. Measured numbers are known to four digits at best; rounded far below that, but far above the
last bits, the same input gives the same files everywhere. A number may still lie on the edge between two roundings:
with differences of 1e-15 and nine digits that is one number in a million.
"""

import csv
import io
import json
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from importlib import import_module
from typing import Any

from ropefric.errors import DataError, InputError

# Control characters (ESC steers a terminal), what turns the direction of a line round, what no UTF-8 or XML holds.
_UNSEEN = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ud800-\udfff\ufffe\uffff]")
_LONE = re.compile("[\ud800-\udfff]")
# A spreadsheet runs what begins so; the apostrophe is its own mark for text.
_RUN = re.compile("'*+[=+\\-@\t\r]")
_WRITTEN = re.compile("'++[=+\\-@\t\r]")


def visible(text: str) -> str:
    r"""Return text with every character that steers instead of showing itself written as its escape.

    Line breaks and tabs stay.
    """
    return _UNSEEN.sub(_escape, text)


def json_escaped(text: str) -> str:
    r"""Return a JSON document that UTF-8 can hold: halves of surrogate pairs, of odd file names, as escapes."""
    return _LONE.sub(_escape, text)


def json_document(tree: Any) -> str:
    """Return a tree as the JSON of a file: the same bytes for the same tree, keys sorted, no NaN."""
    text = json.dumps(tree, sort_keys=True, indent=1, ensure_ascii=False, allow_nan=False)
    return json_escaped(text) + "\n"


def to_spreadsheet(text: str) -> str:
    """Return the text of a CSV cell such that no spreadsheet takes it for a formula; numbers are not to be given."""
    shown = json_escaped(text)
    return f"'{shown}" if _RUN.match(shown) else shown


def csv_cell(value: Any) -> Any:
    """Return a value as a CSV cell holds it: words harmless, true and false in small letters."""
    if isinstance(value, bool):
        return str(value).lower()
    return to_spreadsheet(value) if isinstance(value, str) else value


def csv_text(rows: Iterable[Iterable[object]], *, separator: str = ",") -> str:
    """Return rows of cells as CSV, the same bytes on every machine."""
    stream = io.StringIO()
    csv.writer(stream, delimiter=separator, lineterminator="\n").writerows(rows)
    return stream.getvalue()


def from_spreadsheet(cell: str) -> str:
    """Return the text that `to_spreadsheet` has written into a cell."""
    return cell[1:] if _WRITTEN.match(cell) else cell


def _escape(found: re.Match[str]) -> str:
    return found[0].encode("unicode_escape").decode()


MEASURED_DIGITS = 9
"""Significant digits of forces, and of whatever else follows from measurements."""
GIVEN_DIGITS = 12
"""Significant digits of numbers that only arithmetic was done on."""
STD_DIGITS = 4
"""Significant digits of a standard error."""
_SHARE = 1e-4
"""Part of a standard error that rounding may be as large as."""


def significant(
    value: float, digits: int = MEASURED_DIGITS, *, smallest: float = 0.0, size: float = 0.0
) -> float:
    """Return a number with this many significant digits; zero where it is below `smallest`, the rest of a difference.

    Where it is the rest of a difference of numbers of a certain `size`, the digits count from that.
    """
    if abs(value) < smallest:
        return 0.0
    if abs(value) < size < math.inf:
        return round(value, digits - 1 - math.floor(math.log10(size))) + 0.0
    return float(f"{value:.{digits - 1}e}") + 0.0  # never -0.0


def to_share(value: float, std: float) -> float:
    """Return an estimate to a decimal between 1e-5 and 1e-4 of its standard error, and to twelve digits at most."""
    if not (math.isfinite(value) and value != 0.0 and 0.0 < std < math.inf):
        return significant(value, GIVEN_DIGITS)
    place = math.floor(math.log10(std * _SHARE))
    return round(value, -max(place, math.floor(math.log10(abs(value))) - GIVEN_DIGITS + 1)) + 0.0


def rounded_tree(tree: Any, digits: int | None = MEASURED_DIGITS) -> Any:
    """Return a JSON tree with its numbers to this many significant digits, standard errors (`std`, `std_*`) to four.

    A number that is not there or infinite is None; None for the digits leaves the others as they are.
    """
    tree = tree.tolist() if hasattr(tree, "tolist") else tree
    if isinstance(tree, float):
        return None if not math.isfinite(tree) else tree if digits is None else significant(tree, digits)
    if isinstance(tree, Mapping):
        few = digits and min(digits, STD_DIGITS)
        kept = {key: few if f"{key}_".startswith("std_") else digits for key in tree}
        return {key: rounded_tree(item, kept[key]) for key, item in tree.items()}
    return [rounded_tree(item, digits) for item in tree] if isinstance(tree, list | tuple) else tree


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
    parquet.write_table(pyarrow.table(typed), stream := io.BytesIO())
    return stream.getvalue()


def parquet_as_csv(content: bytes, shown: str) -> str:
    """Return a Parquet file as CSV: numbers with all their digits, empty cells where there is none."""
    pyarrow, parquet = arrow()
    try:
        table = parquet.read_table(io.BytesIO(content))
        columns = [table.column(i).to_pylist() for i in range(table.num_columns)]
    except (pyarrow.ArrowException, OSError, ValueError) as error:
        message = f"this is not a readable Parquet file: {error}"
        raise DataError(message, path=shown, fix="write it again, or save the table as CSV") from None
    rows = (table.column_names, *zip(*columns, strict=True))
    return csv_text(map(_cell, row) for row in rows)


def _cell(value: Any) -> Any:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    return csv_cell(value if isinstance(value, bool | int | float) else " ".join(str(value).split()))
