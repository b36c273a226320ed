"""A CSV table as cells: separator found, comments left out, every row with its line."""

import csv
import os
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from ropefric.errors import DataError, Problem
from ropefric.files.read import use_file
from ropefric.files.text import Source, load_text


@dataclass(frozen=True, slots=True, kw_only=True)
class CellTable:
    """The cells of a table, without blanks around them."""

    path: str
    separator: str
    header: tuple[str, ...]
    header_line: int
    rows: tuple[tuple[int, tuple[str, ...]], ...]


def read_cells(path: str | os.PathLike[str]) -> tuple[CellTable, tuple[Problem, ...]]:
    r"""Return a CSV file's cells, and what is wrong with single rows.

    Cells are separated by ";", a tab or ",", whichever the header has first in this order. A line is a row;
    empty lines and lines that start with "#" are left out.
    """
    shown = Path(path).as_posix()
    try:
        text = use_file(
            path, lambda file: _whole(Source(path=Path(path), shown=shown, file=file)), shown=shown
        )
    except DataError as error:
        fix = error.fix if "no such file" in error.problem.message else "save the table as CSV text in UTF-8"
        raise DataError(error.problem.message, path=shown, line=error.problem.line, fix=fix) from None
    lines = [(number, line) for number, line in enumerate(text.split("\n"), start=1) if _counts(line)]
    if not lines:
        fix = "write a header such as file,wheel_radius_mm,wrap_angle_deg,end_tension_N"
        raise DataError("the table is empty", path=shown, fix=fix)
    header_line, head = lines[0]
    separator = next((mark for mark in (";", "\t") if mark in head), ",")
    problems: list[Problem] = []
    if '"' in text:
        split = [(number, _split(line, number, separator, shown, problems)) for number, line in lines]
    else:
        split = [(number, tuple(cell.strip() for cell in line.split(separator))) for number, line in lines]
    if split[0][1] is None:
        raise DataError(
            "a quoted cell of the header is not closed", path=shown, line=header_line, fix="close the quotes"
        )
    header = split[0][1]
    rows = [(number, cells) for number, cells in split[1:] if cells is not None]
    good = [(number, cells) for number, cells in rows if len(cells) == len(header)]
    problems += [
        _ragged(shown, n, cells, header, separator) for n, cells in rows if len(cells) != len(header)
    ]
    table = CellTable(
        path=shown, separator=separator, header=header, header_line=header_line, rows=tuple(good)
    )
    return table, tuple(problems)


def _whole(source: Source) -> str:
    return b"".join(block.data for block in load_text(source).blocks()).decode()


def _counts(line: str) -> bool:
    bare = line.strip()
    # A spreadsheet writes empty rows as ";;;;" and quotes a comment that holds a separator.
    return bool(bare.strip(",;\t ")) and not bare.lstrip('"').startswith("#")


def _split(
    line: str, number: int, separator: str, shown: str, problems: list[Problem]
) -> tuple[str, ...] | None:
    try:
        cells = next(csv.reader([line], delimiter=separator, skipinitialspace=True, strict=True))
    except csv.Error:
        problems.append(
            Problem(
                code="RF103",
                message="a quoted cell is not closed on its line, or text follows its end",
                path=shown,
                line=number,
                fix="keep each row on one line and close the quotes",
            )
        )
        return None
    return tuple(cell.strip() for cell in cells)


def _ragged(
    shown: str, line: int, cells: tuple[str, ...], header: tuple[str, ...], separator: str
) -> Problem:
    message = f"{len(cells)} cells, but the header has {len(header)} columns"
    fix = f"write a {_NAMES[separator]} for every column, also where a cell is empty"
    if separator == "," and len(cells) > len(header):
        digits = Counter(cell.lstrip("+-").isdigit() for cell in cells)[True]
        fix = 'put text with a comma in "quotes"'
        if digits > 1:
            fix = f"if numbers have a decimal comma, separate the columns by ';'; otherwise {fix}"
    return Problem(code="RF103", message=message, path=shown, line=line, fix=fix)


_NAMES = {",": "comma", ";": "semicolon", "\t": "tab"}
