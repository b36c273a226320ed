"""Delimited text: CSV and its relatives, with or without a header."""

import io
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.files.read import FileChangedError
from ropefric.traces.readers.cells import NAN_TEXTS, is_blank_line, parse_rows, split_line
from ropefric.traces.readers.dialect import Dialect, find_dialect
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.reader import Reader
from ropefric.traces.readers.rows import check_rows
from ropefric.traces.readers.source import Source
from ropefric.traces.readers.table import Table
from ropefric.traces.readers.text import Block, Text, is_cut, load_text, start_of

TEXT_SUFFIXES = tuple(
    f"{kind}{gz}" for gz in ("", ".gz") for kind in (".csv", ".txt", ".tsv", ".dat", ".asc")
)


def open_text(source: Source, profile: ImportProfile) -> tuple[Text, Dialect]:
    """Return a text file and its layout."""
    text = load_text(source, profile.encoding)
    dialect = find_dialect(text, profile)
    return _without_cut_number(text, dialect), dialect


def _without_cut_number(text: Text, dialect: Dialect) -> Text:
    """Return a text without its last row where the file ends within a number."""
    if not text.is_whole:
        return replace(text, separator=dialect.style.separator)
    begin = text.data.rfind(b"\n", 0, -1) + 1
    above = text.data.rfind(b"\n", 0, max(begin - 1, 0)) + 1
    if text.is_ended or above < start_of(text.data, dialect.data_row):
        return text
    before, last = text.data[above : begin - 1], text.data[begin:-1]
    return replace(text, data=text.data[:begin]) if is_cut(before, last, dialect.style.separator) else text


def column_names(text: Text, dialect: Dialect) -> tuple[tuple[str, ...], str]:
    """Return the names of the data's columns, and where their number comes from.

    A header without its trailing separators may be shorter than the rows only if the surplus cells are empty
    throughout (trailing separators), and longer only by LabVIEW's `Comment`, which stays empty.
    """
    n_cells, names = dialect.n_cells, list(dialect.header)
    while names and not names[-1]:
        names.pop()
    if not names:
        return ("",) * n_cells, f"line {dialect.data_row} has {n_cells}"
    expected = f"the header (line {dialect.header_row}) names {len(names)} columns"
    surplus = n_cells - len(names)
    is_comment = surplus == -1 and names[-1].lower() == "comment"
    if (surplus > 0 and not ends_empty(text, dialect, surplus)) or (surplus < 0 and not is_comment):
        check_rows(text, dialect.data_row, dialect.style.separator, len(names), expected=expected)
    if is_comment or surplus > 0:
        expected = f"line {dialect.data_row} has {n_cells}"
    return tuple([*names, *[""] * surplus][:n_cells]), expected


def ends_empty(text: Text, dialect: Dialect, surplus: int) -> bool:
    """Return whether the last cells of every data row are empty: trailing separators."""
    separator = dialect.style.separator
    lines = (line for _, line in text.lines_from(dialect.data_row) if not is_blank_line(line, separator))
    return all(not any(split_line(line, separator)[-surplus:]) for line in lines)


def parse_columns(
    text: Text, dialect: Dialect, names: Sequence[str], indices: Sequence[int], n_rows: int
) -> list[FloatArray]:
    """Return columns of a text table, whose `n_rows` rows have been counted.

    The C parser of pandas reads clean files; whatever it does not take as numbers is read again cell by
    cell, which either finds a number after all or says which cell is none. Block by block: what is held of a large
    file is its columns.
    """
    wanted, place = sorted(set(indices)), 0
    columns = {index: np.empty(n_rows) for index in wanted}
    for block in text.blocks(dialect.data_row):
        arrays = _parse_block(block, text, dialect, names, wanted)
        size = len(arrays[0]) if arrays else 0
        if text.is_whole and size == n_rows:  # the only block
            columns = dict(zip(wanted, arrays, strict=True))
        elif place + size > n_rows:
            raise FileChangedError("the file changed while it was read", path=text.source.shown)
        else:
            for index, array in zip(wanted, arrays, strict=True):
                columns[index][place : place + size] = array
        place += size
    return [columns[index][:place] for index in indices]


def _parse_block(
    block: Block, text: Text, dialect: Dialect, names: Sequence[str], indices: Sequence[int]
) -> list[FloatArray]:
    # Quotes are tokenised here and by pandas by slightly different rules; one rule is safer than two.
    for tolerant in () if b'"' in block else (False, True):
        arrays = _parse_fast(block, dialect, len(names), indices, tolerant=tolerant)
        if arrays is not None and not any(np.isinf(array).any() for array in arrays):
            return arrays
    return parse_rows(block.lines(), indices, names, dialect.style, text.source)


def _parse_fast(
    block: Block, dialect: Dialect, n_columns: int, indices: Sequence[int], *, tolerant: bool
) -> list[FloatArray] | None:
    """Return columns as pandas reads them, or None where it finds a cell that is no number."""
    import pandas as pd  # noqa: PLC0415  (0.3 s to load)

    style, body = dialect.style, io.BytesIO(block.data)
    body.seek(block.start)
    try:
        frame = pd.read_csv(
            body,
            sep=r"\s+" if style.separator == " " else style.separator,
            decimal=style.decimal,
            header=None,
            names=list(range(n_columns)),
            usecols=list(indices),
            index_col=False,
            dtype=np.float64,
            engine="c",
            na_filter=tolerant,
            keep_default_na=False,
            na_values=["", *NAN_TEXTS, *style.missing],
            skipinitialspace=tolerant and style.separator not in "\t ",
            low_memory=False,
        )
    except (ValueError, OverflowError):  # pandas' own parser errors are ValueErrors
        return None
    return [frame[index].to_numpy(dtype=np.float64) for index in indices]


def _tables(source: Source, profile: ImportProfile) -> tuple[Table, ...]:
    text, dialect = open_text(source, profile)
    names, expected = column_names(text, dialect)
    n_rows, is_gapless = check_rows(
        text, dialect.data_row, dialect.style.separator, dialect.n_cells, expected=expected
    )
    units = (*dialect.units, *[""] * len(names))[: len(names)]
    table = Table(
        names=names,
        units=units,
        values=lambda indices: parse_columns(text, dialect, names, indices, n_rows),
        has_header=any(names),
        first_line=dialect.data_row if is_gapless else 0,
    )
    return (table,)


READER = Reader(
    name="delimited",
    suffixes=TEXT_SUFFIXES,
    description="text with columns: CSV, TAB, semicolon or blanks; plain or gzip",
    tables=_tables,
)
