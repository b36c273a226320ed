"""Whether every row of a text table has as many cells as there are columns."""

import numpy as np

from ropefric.arrays import BoolArray, IntArray
from ropefric.traces.readers.cells import is_blank_line, split_line
from ropefric.traces.readers.text import Block, Text

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
    """
    n_rows, is_gapless, ends_blank = 0, True, False
    for block in text.blocks(start_line):
        n_regular = _rows_if_regular(block, separator, n_cells)
        if n_regular is None:
            counts = _cells_per_line(block, separator, text)
            full = counts > 0
            wrong = full & (counts != n_cells)
            if block_columns:
                wrong &= (counts > n_cells) | (counts % block_columns != 0)  # a row may end with a block
            if wrong.any():
                row = int(np.argmax(wrong))
                _refuse(text, block.line + row, int(counts[row]), n_cells=n_cells, expected=expected)
            places = np.flatnonzero(full)
            if not places.size:
                ends_blank = True
                continue
            is_gapless &= bool(full[: places[-1] + 1].all())
            n_regular, goes_blank = places.size, not full[-1]
        else:
            goes_blank = False
        is_gapless &= not ends_blank  # by blank lines between the blocks
        n_rows, ends_blank = n_rows + n_regular, goes_blank
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


def _rows_if_regular(block: Block, separator: str, n_cells: int) -> int | None:
    """Return the number of lines if every one has n - 1 separators and is not blank, else None.

    Takes a third of a millisecond a megabyte.
    """
    if separator == " " or b'"' in block:
        return None
    data, start = block.data, block.start
    if n_cells == 1 and (
        data.startswith(b"\n", start)
        or any(one in block for one in (b"\n\n", b" ", b"\t", separator.encode()))
    ):
        return None  # here a blank line would pass for a row
    wanted = separator.encode() * (n_cells - 1) + b"\n"
    others = bytes(set(range(256)) - set(wanted))
    # In pieces that stay in the cache.
    pieces = (data[i : i + _PIECE].translate(None, others) for i in range(start, len(data), _PIECE))
    marks = b"".join(pieces)
    n_rows = len(marks) // n_cells
    return n_rows if marks == wanted * n_rows else None


def _cells_per_line(block: Block, separator: str, text: Text) -> IntArray:
    """Return the number of cells of each line of a block, 0 for a blank one."""
    if b'"' in block:
        return _quoted_cells_per_line(block, separator, text)
    body = np.frombuffer(block.data, dtype=np.uint8, offset=block.start)
    ends = np.flatnonzero(body == _NEWLINE)
    is_blank = np.isin(body, (*_BLANKS, _NEWLINE))
    if separator == " ":
        starts = ~is_blank & np.concatenate(([True], is_blank[:-1]))
        return _per_line(starts, ends)
    marks = body == ord(separator)
    n_ink = _per_line(~is_blank | marks, ends)
    return np.where(n_ink > 0, _per_line(marks, ends) + 1, 0)


def _quoted_cells_per_line(block: Block, separator: str, text: Text) -> IntArray:
    counts = []
    for number, line in block.lines():
        if line.count('"') % 2:
            raise text.source.error(
                "a quotation mark is opened and not closed",
                code="RF103",
                line=number,
                fix="mend the line; a cell cannot run over several lines",
            )
        counts.append(0 if is_blank_line(line, separator) else len(split_line(line, separator)))
    return np.array(counts, dtype=np.int64)


def _per_line(flags: BoolArray, ends: IntArray) -> IntArray:
    """Return how many flags are set in each line; lines end at the given bytes."""
    return np.diff(np.cumsum(flags)[ends], prepend=0)


def _refuse(text: Text, line: int, n_found: int, *, n_cells: int, expected: str) -> None:
    is_last = next(text.lines_from(line + 1), None) is None
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
