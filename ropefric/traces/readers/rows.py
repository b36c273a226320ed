"""Whether every row of a text table has as many cells as there are columns."""

import numpy as np
import numpy.typing as npt

from ropefric.traces.readers.cells import is_blank_line, split_line
from ropefric.traces.readers.text import Text

__all__ = ["check_rows"]

_NEWLINE = 10
_PIECE = 65536
_BLANKS = (9, 32)


def check_rows(
    text: Text,
    start_line: int,
    separator: str,
    n_cells: int,
    *,
    expected: str,
    block_columns: int = 0,
) -> tuple[int, bool]:
    """Return the number of rows from a line on, and whether there is no blank line among them.

    pandas fills short rows up and turns surplus cells into an index, both in silence; so rows are counted
    here, on the bytes.

    Parameters
    ----------
    text : Text
        The file.
    start_line : int
        1-based line of the first row.
    separator : str
        As in `CellStyle`.
    n_cells : int
        Cells a row must have.
    expected : str
        Where that number comes from, for the message: "the header (line 3) names 19 columns".
    block_columns : int
        In wide files a row may end early, at the end of a block of this many columns; 0 otherwise.

    Raises
    ------
    DataError
        RF103, naming the first line that has another number of cells; RF101, if there is no row.
    """
    start = text.start_of(start_line)
    n_rows = _rows_if_regular(text, start, separator, n_cells) if start < len(text.data) else 0
    is_gapless = True
    if n_rows is None:
        counts = _cells_per_line(text, start_line, separator)
        full = counts > 0
        n_rows = int(np.count_nonzero(full))
        wrong = full & (counts != n_cells)
        if block_columns:
            wrong &= (counts > n_cells) | (counts % block_columns != 0)  # a row may end with a block
        if wrong.any():
            _refuse(text, start_line, int(np.argmax(wrong)), counts, n_cells=n_cells, expected=expected)
        inside = full[: int(np.flatnonzero(full)[-1]) + 1] if n_rows else full
        is_gapless = bool(inside.all())
    if n_cells == 1 and not is_gapless:
        raise text.source.error(
            "there are blank lines among the values of the only column; each may be a missing sample or nothing",
            code="RF103",
            fix="remove them, or write NaN where a sample is missing",
        )
    if n_rows == 0:
        raise text.source.error(
            "there are no data rows",
            line=start_line if start_line > 1 else None,
            fix="record it again, or check [import] data_row",
        )
    return n_rows, is_gapless


def _rows_if_regular(text: Text, start: int, separator: str, n_cells: int) -> int | None:
    """Return the number of lines if every one has n - 1 separators and is not blank, else None.

    Takes a third of a millisecond a megabyte.
    """
    if separator == " " or b'"' in text.data:
        return None
    if n_cells == 1 and (b"\n\n" in text.data or b" " in text.data or b"\t" in text.data):
        return None  # here a blank line would pass for a row
    wanted = separator.encode() * (n_cells - 1) + b"\n"
    others = bytes(set(range(256)) - set(wanted))
    data = text.data  # in pieces that stay in the cache
    pieces = (data[i : i + _PIECE].translate(None, others) for i in range(start, len(data), _PIECE))
    marks = b"".join(pieces)
    if n_cells == 1 and text.data.find(separator.encode(), start) >= 0:
        return None
    n_rows = len(marks) // n_cells
    return n_rows if marks == wanted * n_rows else None


def _cells_per_line(text: Text, start_line: int, separator: str) -> npt.NDArray[np.int64]:
    """Return the number of cells of each line, 0 for a blank one."""
    if b'"' in text.data:
        return _quoted_cells_per_line(text, start_line, separator)
    body = np.frombuffer(text.data, dtype=np.uint8, offset=text.start_of(start_line))
    ends = np.flatnonzero(body == _NEWLINE)
    is_blank = np.isin(body, (*_BLANKS, _NEWLINE))
    if separator == " ":
        starts = ~is_blank & np.concatenate(([True], is_blank[:-1]))
        return _per_line(starts, ends)
    marks = body == ord(separator)
    n_ink = _per_line(~is_blank | marks, ends)
    return np.where(n_ink > 0, _per_line(marks, ends) + 1, 0)


def _quoted_cells_per_line(text: Text, start_line: int, separator: str) -> npt.NDArray[np.int64]:
    counts = []
    for number, line in text.lines_from(start_line):
        if line.count('"') % 2:
            raise text.source.error(
                "a quotation mark is opened and not closed",
                code="RF103",
                line=number,
                fix="mend the line; a cell cannot run over several lines",
            )
        counts.append(0 if is_blank_line(line, separator) else len(split_line(line, separator)))
    return np.array(counts, dtype=np.int64)


def _per_line(flags: npt.NDArray[np.bool_], ends: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Return how many flags are set in each line; lines end at the given bytes."""
    return np.diff(np.cumsum(flags)[ends], prepend=0)


def _refuse(
    text: Text, start_line: int, row: int, counts: npt.NDArray[np.int64], *, n_cells: int, expected: str
) -> None:
    n_found, line = int(counts[row]), start_line + row
    is_last = row == counts.size - 1
    cells = split_line(text.line(line), ",")
    is_doubled = n_found == 2 * n_cells and all(cell.lstrip("+-").isdigit() for cell in cells)
    if is_doubled:
        fix = 'it looks like a decimal comma between comma-separated columns; export with ";" between columns'
    elif n_found < n_cells and is_last:
        fix = "the last line looks cut off; remove it or copy the file again"
    else:
        fix = (
            "mend the line; or, where the names are wrong, set [import] header_row = 0 and "
            f"data_row = {line}, and give columns by number"
        )
    raise text.source.error(
        f"this line has {n_found} values, but {expected}; a shift by a column would go unseen",
        code="RF103",
        line=line,
        fix=fix,
    )
