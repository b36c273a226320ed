"""Text with columns: CSV and its relatives, one recording a file.

The C parser of pandas reads clean files; it fills short rows up and turns surplus cells into an index, both in silence,
so rows are counted first, on the bytes. Whatever it does not take as numbers is read again cell by cell, which either
finds a number after all or says which cell is none.
"""

import io
import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ropefric.arrays import FloatArray, IntArray
from ropefric.files.head_facts import UNIT_WORDS
from ropefric.files.text import Block, Source, Text, is_blank_line, load_text, split_line
from ropefric.files.text_table import (
    Dialect,
    bare_unit,
    find_dialect,
    is_unit,
    is_value,
    number_of,
    unit_behind,
)
from ropefric.glossary import counted
from ropefric.quantities import split_unit_suffix
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.table import Reader, Table, bad_cell, stamp_column

_NEWLINE = 10
_IS_BLANK = np.isin(np.arange(256), (9, _NEWLINE, 32))
"""Whether a byte is a tab, the end of a line or a blank."""
MOST_FOOTER = 20


def open_text(source: Source, profile: ImportProfile, text: Text | None = None) -> tuple[Text, Dialect]:
    """Return a text file and its layout."""
    text = text or load_text(source, profile.encoding)
    numbers = [channel.column for channel in profile.channels.values() if isinstance(channel.column, int)]
    dialect = find_dialect(text, profile, last_column=max(numbers, default=0))
    return without_footer(text, dialect), dialect


def without_footer(text: Text, dialect: Dialect) -> Text:
    """Return a text without empty rows at its end, footer, and a last row that breaks off within a number.

    Without a stated number of lines, a footer is lines of words, in another number of cells than the data have.
    """
    start = text.start_of(dialect.rows.data_row)
    return text.part(0, start + _end_of_data(dialect, text.data[start:], is_ended=text.is_ended))


def _end_of_data(dialect: Dialect, data: bytes, *, is_ended: bool) -> int:
    """Return the byte at which the rows of data end."""
    filled = data.find(b"\n", len(data.rstrip(b" \t\n" + dialect.separator.encode()))) + 1
    data, is_ended = data[:filled], is_ended or filled < len(data)
    n_most = max(dialect.layout.skip_footer, MOST_FOOTER)
    ends = [len(data)]  # of the last lines, backwards
    while ends[-1] and len(ends) <= n_most + 2:
        ends.append(data.rfind(b"\n", 0, ends[-1] - 1) + 1)
    lines = [data[start:stop].decode(errors="replace").strip() for stop, start in pairwise(ends)]
    rows = [split_line(line, dialect.separator) for line in lines]
    footer = _footer(lines, rows, dialect)
    if 0 < len(footer) <= n_most:
        text = "; ".join(lines[place] for place in reversed(footer))
        dialect.notes.append(f"{counted(len(footer), 'line')} without data left out at the end: {text[:100]}")
        return ends[footer[-1] + 1]
    return ends[0] if is_ended or not _breaks_off(rows) else ends[1]


def _footer(lines: Sequence[str], rows: Sequence[Sequence[str]], dialect: Dialect) -> list[int]:
    """Return the places of the footer's lines among the last lines of a text, the last line first."""
    n_footer = dialect.layout.skip_footer
    footer: list[int] = []
    for place, cells in enumerate(rows[:-1]):
        if not lines[place]:
            continue
        is_footer = len(cells) != dialect.n_cells and begins_with_word(cells, dialect)
        if len(footer) == n_footer if n_footer else not is_footer:
            break
        footer.append(place)
    return footer


def begins_with_word(cells: Sequence[str], dialect: Dialect) -> bool:
    """Return whether a row begins with a word, where the first row of data does not."""
    word, first = "".join(cells[:1]), "".join(dialect.first_row[:1])
    is_number = word.lstrip("+-.,")[:1].isdigit()  # or was one before it was damaged
    is_word = any(c.isalpha() for c in word) and not is_number and word not in dialect.layout.no_value
    return is_word and (not first or is_value(first))


def _breaks_off(rows: Sequence[Sequence[str]]) -> bool:
    """Return whether the last row, the first of these, breaks off within a number: 13 of 137 is no number.

    Loggers that never end their last line lose a sample by it where that is shorter than the one before, which costs
    nothing. A row cut to fewer cells is refused later.
    """
    if len(rows) < 2 or not rows[0] or len(rows[0]) != len(rows[1]):
        return False
    return 0 < len(rows[0][-1]) < len(rows[1][-1])


def text_table(
    text: Text, dialect: Dialect, names: tuple[str, ...] = (), *, expected: str = "", block_columns: int = 0
) -> Table:
    """Return the one table of a text; its columns are called as its header says, where no names are given."""
    n_optional = 0
    if not names:
        names, expected, n_optional = _column_names(text, dialect)
    n_rows, is_gapless = _check_rows(
        text,
        dialect,
        max(dialect.n_cells, len(names)),
        expected=expected,
        block_columns=block_columns,
        n_optional=n_optional,
    )
    units, stamps = (*dialect.units, *[""] * len(names))[: len(names)], dialect.stamps
    if len(names) == 1 and not any(units):
        units = (dialect.facts.unit,)
    pairs = zip(units, _units_in_cells(dialect, names), strict=True)
    units = _with_unit_columns(text, dialect, names, [unit or behind for unit, behind in pairs])

    def values(indices: Sequence[int]) -> list[FloatArray]:
        numbers = iter(_parse_columns(text, dialect, names, [i for i in indices if i not in stamps], n_rows))
        return [stamped(index) if index in stamps else next(numbers) for index in indices]

    def stamped(index: int) -> FloatArray:
        rows = text.rows_from(dialect.rows.data_row, dialect.separator)
        cells = ((number, row[index] if index < len(row) else "") for number, row in rows)
        return stamp_column(cells, names[index] or f"column {index + 1}", dialect, text.source)

    return Table(
        names=names,
        units=tuple("s" if index in stamps else unit for index, unit in enumerate(units)),
        values=values,
        first_line=dialect.rows.data_row if is_gapless else 0,
        stamps=stamps,
        facts=dialect.facts,
        notes=dialect.notes,
    )


def _units_in_cells(dialect: Dialect, names: Sequence[str]) -> list[str]:
    """Return the unit behind the numbers of each column, "" for none, and where the head states another."""
    found = [""] * len(names)
    for at, (name, cell) in enumerate(zip(names, dialect.first_row, strict=False)):
        stated = bare_unit("".join(dialect.units[at : at + 1])) or split_unit_suffix(name)[1]
        unit = unit_behind(cell)
        found[at] = unit if stated in ("", bare_unit(unit)) else ""
    return found


def _with_unit_columns(
    text: Text, dialect: Dialect, names: Sequence[str], units: Sequence[str]
) -> tuple[str, ...]:
    """Return the units of columns, of which one may be written beside every value in a column of its own."""
    found = [*units]
    for at, (value, unit) in enumerate(pairwise(dialect.first_row[: len(names)])):
        may_be = not any(names) or "".join(filter(str.isalpha, names[at + 1].lower())) in UNIT_WORDS
        if may_be and not found[at] and is_value(value) and is_unit(unit):
            rows = text.rows_from(dialect.rows.data_row, dialect.separator)
            if all(row[at + 1 : at + 2] == [unit] for _, row in rows):
                found[at] = unit
    return tuple(found)


def _column_names(text: Text, dialect: Dialect) -> tuple[tuple[str, ...], str, int]:
    """Return the names of the data's columns, where their number comes from, and how many a row may lack.

    A header without its trailing separators may be shorter than the rows only if the surplus cells are empty
    throughout (trailing separators). The last column may be LabVIEW's `Comment`, which few rows have.
    """
    n_cells, names = dialect.n_cells, list(dialect.header)
    while names and not names[-1]:
        names.pop()
    in_data = f"line {dialect.rows.data_row} has {n_cells}"
    if not names:
        return ("",) * n_cells, in_data, 0
    expected = f"the header (line {dialect.rows.header_row}) names {len(names)} columns"
    surplus = n_cells - len(names)
    if names[-1].lower() == "comment" and surplus in (-1, 0):
        return tuple(names), expected, 1
    if surplus < 0 or (surplus > 0 and not ends_empty(text, dialect, surplus)):
        _check_rows(text, dialect, len(names), expected=expected)
    return (*names, *[""] * surplus), in_data if surplus > 0 else expected, 0


def ends_empty(text: Text, dialect: Dialect, surplus: int) -> bool:
    """Return whether the last cells of every data row are empty: trailing separators."""
    rows = text.rows_from(dialect.rows.data_row, dialect.separator)
    return not any(any(row[dialect.n_cells - surplus :]) for _, row in rows)


def _check_rows(
    text: Text,
    dialect: Dialect,
    n_cells: int,
    *,
    expected: str = "",
    block_columns: int = 0,
    n_optional: int = 0,
) -> tuple[int, bool]:
    """Return the number of data rows, all of them as wide as they must be, and whether no blank line is among them."""
    n_rows = n_lines = n_up_to_last_row = 0
    for block in text.blocks(dialect.rows.data_row):
        counts = _cells_per_line(block, dialect.separator, text)
        wrong = (counts > n_cells) | ((counts < n_cells - n_optional) & (counts > 0))
        if block_columns:
            wrong &= (counts > n_cells) | (counts % block_columns != 0)  # a row may end with a block
        if wrong.any():
            row = int(np.argmax(wrong))
            _refuse_row(text, block.line + row, int(counts[row]), n_cells=n_cells, expected=expected)
        rows = np.flatnonzero(counts)
        if rows.size:
            n_rows, n_up_to_last_row = n_rows + rows.size, n_lines + int(rows[-1]) + 1
        n_lines += counts.size
    is_gapless = n_up_to_last_row == n_rows
    if n_cells == 1 and not is_gapless:
        why = "there are blank lines among the values of the only column; each may be a missing sample or nothing"
        fix = "remove them, or write NaN where a sample is missing"
        raise text.source.error(why, code="RF103", fix=fix)
    if n_rows == 0:
        line, fix = dialect.rows.data_row, "record it again, or check [import] data_row"
        raise text.source.error("there are no data rows", line=line if line > 1 else None, fix=fix)
    return n_rows, is_gapless


def _cells_per_line(block: Block, separator: str, text: Text) -> IntArray:
    """Return the number of cells of each line of a block, 0 for a blank one."""
    if b'"' in block.data:
        return _quoted_cells_per_line(block, separator, text)
    body = np.frombuffer(block.data, dtype=np.uint8)
    begins = np.append(0, np.flatnonzero(body == _NEWLINE)[:-1] + 1)  # of the lines
    is_blank = _IS_BLANK[body]
    if separator == " ":
        begins_cell = ~is_blank & np.append(True, is_blank[:-1])
        return np.add.reduceat(begins_cell, begins, dtype=np.int64)
    marks = body == ord(separator)
    is_row = np.logical_or.reduceat(~is_blank | marks, begins)
    return np.where(is_row, np.add.reduceat(marks, begins, dtype=np.int64) + 1, 0)


def _quoted_cells_per_line(block: Block, separator: str, text: Text) -> IntArray:
    counts = []
    for number, line in block.lines():
        if line.count('"') % 2:
            why = "a quotation mark is opened and not closed"
            fix = "mend the line; a cell cannot run over several lines"
            raise text.source.error(why, code="RF103", line=number, fix=fix)
        counts.append(0 if is_blank_line(line, separator) else len(split_line(line, separator)))
    return np.array(counts, dtype=np.int64)


def _refuse_row(text: Text, line: int, n_found: int, *, n_cells: int, expected: str) -> None:
    is_last = next(text.lines_from(line + 1), None) is None
    cells = split_line(text.line(line), ",")
    if n_found == 2 * n_cells and all(cell.lstrip("+-").isdigit() for cell in cells):
        fix = 'it looks like a decimal comma between comma-separated columns; export with ";" between columns'
    elif n_found < n_cells and is_last:
        fix = "the last line looks cut off; remove it, copy the file again, or set [import] skip_footer = 1"
    else:
        fix = (
            "mend the line; or, where the names are wrong, set [import] header_row = 0 and "
            f"data_row = {line}, and give columns by number"
        )
    why = f"this line has {n_found} values, but {expected}; a shift by a column would go unseen"
    raise text.source.error(why, code="RF103", line=line, fix=fix)


def _parse_columns(
    text: Text, dialect: Dialect, names: Sequence[str], indices: Sequence[int], n_rows: int
) -> list[FloatArray]:
    """Return columns of a text table, whose `n_rows` rows have been counted."""
    wanted, place = sorted(set(indices)), 0
    columns = {index: np.empty(n_rows) for index in wanted}
    for block in text.blocks(dialect.rows.data_row):
        arrays = _parse_block(block, dialect, names, wanted, text.source)
        stop = place + (len(arrays[0]) if arrays else 0)
        for index, array in zip(wanted, arrays, strict=True):
            columns[index][place:stop] = array
        place = stop
    if none := dialect.layout.no_value_numbers(dialect.decimal):
        columns = {i: np.where(np.isin(array, none), np.nan, array) for i, array in columns.items()}
    return [columns[index] for index in indices]


def _parse_block(
    block: Block, dialect: Dialect, names: Sequence[str], indices: Sequence[int], source: Source
) -> list[FloatArray]:
    """Return columns of a piece of a text, the fast way where it finds numbers in all cells."""
    # Quotes are tokenised here and by pandas by slightly different rules; one rule is safer than two.
    if b'"' not in block.data and not dialect.thousands:
        for tolerant in (False, True):
            arrays = _parse_fast(block, dialect, len(names), indices, tolerant=tolerant)
            if arrays is not None:
                return arrays
    return _parse_rows(block, dialect, names, indices, source)


def _parse_fast(
    block: Block, dialect: Dialect, n_columns: int, indices: Sequence[int], *, tolerant: bool
) -> list[FloatArray] | None:
    """Return columns as pandas reads them, or None where it finds a cell that is no finite number."""
    import pandas as pd  # noqa: PLC0415  (0.3 s to load)

    try:
        frame = pd.read_csv(
            io.BytesIO(block.data),
            sep=r"\s+" if dialect.separator == " " else dialect.separator,
            decimal=dialect.decimal,
            header=None,
            names=list(range(n_columns)),
            usecols=list(indices),
            index_col=False,
            dtype=np.float64,
            engine="c",
            na_filter=tolerant,
            keep_default_na=False,
            na_values=sorted(dialect.layout.no_value),
            skipinitialspace=tolerant and dialect.separator not in "\t ",
            low_memory=False,
        )
    except (ValueError, OverflowError):  # pandas' own parser errors are ValueErrors
        return None
    arrays = [frame[index].to_numpy(dtype=np.float64) for index in indices]
    return None if any(np.isinf(array).any() for array in arrays) else arrays


def _parse_rows(
    block: Block, dialect: Dialect, names: Sequence[str], indices: Sequence[int], source: Source
) -> list[FloatArray]:
    """Return columns of text lines, cell by cell: the definition that the fast way must agree with."""
    found, no_value, in_cells = [], dialect.layout.no_value, _units_in_cells(dialect, names)
    for number, line in block.lines():
        if is_blank_line(line, dialect.separator):
            continue
        cells, row = split_line(line, dialect.separator), []
        for index in indices:
            cell = cells[index] if index < len(cells) else ""
            cell = cell.removesuffix(in_cells[index]).rstrip()
            value = math.nan if cell in no_value else number_of(cell, dialect.decimal, dialect.thousands)
            if math.isinf(value):
                name = names[index] if index < len(names) and names[index] else f"column {index + 1}"
                raise bad_cell(cell, name, dialect.decimal, source, line=number)
            row.append(value)
        found.append(row)
    table = np.array(found, dtype=np.float64).reshape(len(found), len(indices))
    return [np.ascontiguousarray(table[:, i]) for i in range(len(indices))]


DELIMITED = Reader(
    name="delimited",
    suffixes=tuple(
        f".{kind}{gz}" for gz in ("", ".gz") for kind in ("csv", "txt", "tsv", "dat", "asc", "lvm")
    ),
    description="text with columns: CSV, TAB, semicolon or blanks; plain or gzip",
    tables=lambda source, profile: (text_table(*open_text(source, profile)),),
)
