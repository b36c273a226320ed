"""How a text file is laid out: separator, decimal mark, header, units and first data row."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice

from ropefric.errors import InputError
from ropefric.traces.readers.cells import CellStyle, split_line
from ropefric.traces.readers.header import find_rows
from ropefric.traces.readers.marks import find_decimal, find_separator
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.text import HEAD_BYTES, HEAD_LINES, Text

_MOST_LINES = 400
_NO_SEPARATOR = frozenset("0123456789+-.eE\"'\r\n\0")


@dataclass(frozen=True, slots=True, kw_only=True)
class Dialect:
    """The layout of a text table."""

    style: CellStyle
    header_row: int
    units_row: int
    data_row: int
    header: tuple[str, ...]
    units: tuple[str, ...]
    n_cells: int


def find_dialect(text: Text, profile: ImportProfile) -> Dialect:
    r"""Return the layout of a text table: the profile's word, and what the file shows where that is open."""
    _check(profile)
    head = text.data[: _end_of_head(text.data)]
    lines = b"\n".join(head.split(b"\n", _MOST_LINES)[:_MOST_LINES]).decode(errors="replace").split("\n")
    skip = max(profile.data_row - 1, profile.header_row, profile.units_row, profile.block_names_row, 0)
    data_lines = lines[skip:]
    if len(data_lines) < 2:  # an explicit data row far down the file
        lines = [line for _, line in islice(text.lines_from(1), skip + _MOST_LINES)]
        data_lines = lines[skip:]
    separator = profile.separator or find_separator(data_lines, lines, profile, text.source)
    rows = find_rows(lines, separator, profile, text.source)
    decimal = profile.decimal or find_decimal(head, rows.data_row, separator, text.source)
    return Dialect(
        style=CellStyle(separator=separator, decimal=decimal, missing=tuple(profile.missing)),
        header_row=rows.header_row,
        units_row=rows.units_row,
        data_row=rows.data_row,
        header=_cells(lines, rows.header_row, separator),
        units=_cells(lines, rows.units_row, separator),
        n_cells=len(split_line(lines[rows.data_row - 1], separator)),
    )


def _end_of_head(data: bytes) -> int:
    """Return where the lines to look at end: after `HEAD_BYTES`, but at least after some lines; never within one."""
    end = 0
    for _ in range(HEAD_LINES):
        end = data.find(b"\n", end) + 1
        if end == 0:
            return len(data)
    return len(data) if len(data) <= HEAD_BYTES else max(end, data.rfind(b"\n", 0, HEAD_BYTES) + 1)


def _cells(lines: Sequence[str], row: int, separator: str) -> tuple[str, ...]:
    if row < 1:
        return ()
    # numpy.savetxt and gnuplot put the header into a comment.
    return tuple(split_line(lines[row - 1].lstrip("#").lstrip(" "), separator))


def _check(profile: ImportProfile) -> None:
    if profile.separator and (len(profile.separator) != 1 or profile.separator in _NO_SEPARATOR):
        _refuse(
            "separator", profile.separator, 'use one character such as ";", "," or "\\t"; " " is any blanks'
        )
    if profile.separator and not profile.separator.isascii():
        _refuse("separator", profile.separator, 'use an ASCII character such as ";"')
    if profile.decimal not in ("", ".", ","):
        _refuse("decimal", profile.decimal, 'use "." or ","')
    if profile.header_row < -1:
        _refuse("header_row", profile.header_row, "give a line number from 1, 0 for none, or leave it out")
    for key in ("units_row", "data_row", "block_names_row", "block_columns"):
        value = getattr(profile, key)
        if value < 0:
            _refuse(key, value, "give a number from 1, or leave it out")
    last_head = max(profile.header_row, profile.units_row, profile.block_names_row)
    if 0 < profile.data_row <= last_head:
        _refuse("data_row", profile.data_row, f"the data start after line {last_head}, the last head line")


def _refuse(key: str, value: object, fix: str) -> None:
    raise InputError(f"[import] {key} = {value!r} cannot be used", key=f"[import] {key}", fix=fix)
