"""Whether a text table holds several recordings side by side."""

from collections.abc import Sequence
from dataclasses import replace

from ropefric.traces.readers.cells import split_line
from ropefric.traces.readers.dialect import Dialect
from ropefric.traces.readers.header import is_unit
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.text import Text


def find_blocks(text: Text, dialect: Dialect, profile: ImportProfile) -> ImportProfile | None:
    """Return the profile with the block layout that the head shows, or None for an ordinary table.

    Two layouts are known: a row that names each recording above its first column; and a header that names
    the columns of the first recording and leaves the rest blank.
    """
    n = dialect.n_cells
    if profile.block_columns or n < 4:
        return None
    head = {}
    for line in range(1, dialect.data_row):
        cells = split_line(text.line(line), dialect.style.separator)
        filled = [i for i, cell in enumerate(cells[:n]) if cell]
        if filled:
            head[line] = (cells, filled)
    names_row, width = _names_row({line: filled for line, (_, filled) in head.items()}, n)
    if not width:
        width = _header_width([filled for _, filled in head.values()], n)
    if not width:
        return None
    rows = [line for line, (_, filled) in head.items() if line != names_row and filled[-1] < width]
    units = [line for line in rows if all(is_unit(cell) for cell in head[line][0] if cell)]
    headers = [line for line in rows if line not in units]
    return replace(
        profile,
        block_columns=width,
        block_names_row=names_row,
        header_row=headers[-1] if headers else 0,
        units_row=units[-1] if units else 0,
        data_row=dialect.data_row,
    )


def _names_row(head: dict[int, list[int]], n: int) -> tuple[int, int]:
    """Return the line whose filled cells stand at even distances over the whole width, and the distance."""
    for line, filled in head.items():
        if len(filled) < 2:
            continue
        width = filled[1] - filled[0]
        if width > 1 and filled == list(range(0, n, width)) and n % width == 0:
            return line, width
    return 0, 0


def _header_width(rows: Sequence[Sequence[int]], n: int) -> int:
    for filled in rows:
        width = len(filled)
        if width > 1 and filled[-1] == width - 1 and n % width == 0 and n // width > 1:
            return width
    return 0
