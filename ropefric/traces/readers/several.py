"""Text with several recordings: side by side ("wide"), one below the other ("stacked"), or mixed in rows ("long").

Each is recognised by its repetition: names of columns beside each other, the header below the data, the words of a
column that labels rows.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from itertools import chain
from typing import Any, NamedTuple

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.files.text import Source, Text, split_line
from ropefric.files.text_table import Dialect, HeadRows, is_value
from ropefric.quantities import unit_factor
from ropefric.traces.readers.delimited import ends_empty, open_text, text_table, without_footer
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.table import Reader, Table, is_time

_DIGITS = re.compile(r"\d+")
_MARKS = " \t:;,.-_/|#"


class Block(NamedTuple):
    """One of the recordings that a header shows side by side: its name, and those of its columns."""

    sample: str
    names: tuple[str, ...]


def blocks_of_header(header: Sequence[str]) -> list[Block]:
    """Return the recordings that a header shows side by side: names that come again but for a number; [] for none.

    The number and the words beside it that all columns of a block share, "Run 1: " or " Run #1", are the block's name.
    """
    width = _width_of_block(header)
    if not width:
        return []
    blocks = [_block(header[start : start + width]) for start in range(0, len(header), width)]
    samples = [block.sample for block in blocks]
    if "" in samples or len(set(samples)) < len(samples):
        blocks = [Block(str(place), block.names) for place, block in enumerate(blocks, start=1)]
    return blocks if len({block.names for block in blocks}) == 1 else []


def _width_of_block(header: Sequence[str]) -> int:
    """Return after how many names, which differ among themselves, a header comes again but for a number; 0 for none."""
    n, alike = len(header), [_DIGITS.sub("#", name).strip().lower() for name in header]
    for width in range(2, n // 2 + 1):
        first = alike[:width]
        if alike == first * (n // width) and len(set(first)) == width:
            return width if all(first) else 0
    return 0


def _block(names: Sequence[str]) -> Block:
    """Return a recording by what all its names begin or end with, or by their last number; "" where nothing names it."""
    before, after = _shared(names), _shared([name[::-1] for name in names])[::-1]
    for shared, without in ((before, str.removeprefix), (after, str.removesuffix)):
        if _DIGITS.search(shared):
            return Block(shared.strip(_MARKS), tuple(without(name, shared).strip() for name in names))
    last = {tuple(_DIGITS.findall(name)[-1:]) for name in names}
    if len(last) > 1 or () in last:
        return Block("", tuple(name.strip() for name in names))
    ((label,),) = last
    parts = (name.rpartition(label) for name in names)
    return Block(label, tuple((begin.rstrip(" _#.") + end).strip() for begin, _, end in parts))


def _shared(names: Sequence[str]) -> str:
    """Return what several names begin with, up to the end of a word."""
    same = [len(set(letters)) == 1 for letters in zip(*names, strict=False)]
    shared = names[0][: same.index(False) if False in same else len(same)]
    return shared[: max(shared.rfind(mark) for mark in _MARKS) + 1]


def _wide_tables(source: Source, profile: ImportProfile) -> tuple[Table, ...]:
    """Return one table per block of columns; rows that are empty at a block's end belong to longer blocks."""
    width = profile.block_columns
    if width < 1:
        why = "format 'wide' needs the number of columns of one recording"
        fix = "set [import] block_columns, for example block_columns = 4"
        raise source.error(why, code="RF105", key="[import] block_columns", fix=fix)
    text, dialect = open_text(source, profile)
    data_row, n_cells = dialect.rows.data_row, dialect.n_cells
    n_blocks, surplus = divmod(n_cells, width)  # a trailing separator makes no column
    if n_blocks == 0 or surplus > 1 or (surplus and not ends_empty(text, dialect, 1)):
        why = f"{n_cells} columns cannot be divided into recordings of {width} columns"
        fix = "correct [import] block_columns or data_row"
        raise source.error(why, code="RF103", line=data_row, key="[import] block_columns", fix=fix)
    expected = f"line {data_row} has {n_cells}: {n_blocks} blocks of {width}"
    names, units = (_by_block(cells, n_blocks, width) for cells in (dialect.header, dialect.units))
    blocks = blocks_of_header(dialect.header[: n_blocks * width])
    blocks = blocks if len(blocks) == n_blocks else []
    names = [block.names for block in blocks] or names
    dialect = replace(dialect, units=tuple(chain(*units)))
    whole = text_table(text, dialect, tuple(chain(*names)), expected=expected, block_columns=width)

    @lru_cache(maxsize=1)  # the file is parsed once for all blocks, which ask for the same columns
    def load(offsets: tuple[int, ...]) -> dict[int, FloatArray]:
        indices = [block * width + offset for block in range(n_blocks) for offset in offsets]
        return dict(zip(indices, whole.values(indices), strict=True))

    def values(block: int, offsets: Sequence[int]) -> list[FloatArray]:
        loaded = load(tuple(sorted(set(offsets))))
        columns = [loaded[block * width + offset] for offset in offsets]
        filled = np.flatnonzero(~np.all(np.isnan(columns), axis=0))
        return [column[: int(filled[-1]) + 1 if filled.size else 0] for column in columns]

    return tuple(
        replace(
            whole,
            names=names[block],
            units=whole.units[block * width : (block + 1) * width],
            values=partial(values, block),
            sample=sample,
            stamps=frozenset(index - block * width for index in whole.stamps),
        )
        for block, sample in enumerate(_block_names(text, dialect, profile, [one.sample for one in blocks]))
    )


def _by_block(cells: Sequence[str], n_blocks: int, width: int) -> list[tuple[str, ...]]:
    """Return cells by block; a block without any takes those of the first, which vendors write only once."""
    padded = [*cells, *[""] * (n_blocks * width)]
    blocks = [tuple(padded[i * width : (i + 1) * width]) for i in range(n_blocks)]
    return [block if any(block) else blocks[0] for block in blocks]


def _block_names(
    text: Text, dialect: Dialect, profile: ImportProfile, in_header: Sequence[str]
) -> Sequence[str]:
    """Return the blocks' names: the first filled cell of each in the names row, else those of the header, or numbers."""
    row, width = profile.block_names_row, profile.block_columns
    n_blocks = dialect.n_cells // width
    cells = split_line(text.line(row), dialect.separator) if row >= 1 else []
    if not cells and in_header:
        return in_header
    names = [
        next(filter(None, cells[block * width : (block + 1) * width]), str(block + 1))
        for block in range(n_blocks)
    ]
    if len(set(names)) < n_blocks:
        twice = next(name for name in names if names.count(name) > 1)
        why, fix = f"two recordings are called {twice!r}", "set block_names_row = 0 to number them"
        raise text.source.error(why, code="RF105", line=row, key="[import] block_names_row", fix=fix)
    return names


class Part(NamedTuple):
    """One of several recordings below each other: its name, the lines of its header and its data, and where it ends."""

    name: str
    header_row: int
    data_row: int
    stop: int


def stacked_parts(text: Text, dialect: Dialect) -> list[Part]:
    """Return where the recordings of a text stand whose header comes again below data."""
    head, first, n_cells = _alike(dialect.header), dialect.rows, dialect.n_cells
    starts: list[tuple[str, int, int, int]] = []
    between: list[tuple[int, list[str]]] = []
    for number, cells in text.rows_from(1, dialect.separator):
        if number < first.data_row or len(cells) != n_cells or not is_value(next(filter(None, cells), "")):
            between.append((number, cells))
            continue
        heads = [place for place, (_, row) in enumerate(between) if _alike(row) == head]
        if heads:
            above = between[heads[-1] - 1][1] if heads[-1] else ()
            name = " ".join(filter(None, above))[:60]
            starts.append((name, between[heads[-1]][0], number, between[0][0]))
        between = []
    stops = [*(begin for *_, begin in starts[1:]), text.data.count(b"\n") + text.first_line]
    return [Part(*start[:3], stop) for start, stop in zip(starts, stops, strict=False)]


def _alike(cells: Sequence[str]) -> tuple[str, ...]:
    return tuple(_DIGITS.sub("#", cell.lower()) for cell in cells)


def _stacked_tables(source: Source, profile: ImportProfile) -> tuple[Table, ...]:
    """Return one table for each header that comes again below data; the words above it, or a number, are its name."""
    text, dialect = open_text(source, profile)
    parts = stacked_parts(text, dialect)
    if not parts:
        why = "there is no header that comes again below data"
        fix = 'set [import] header_row, or format = "delimited"'
        raise source.error(why, code="RF103", key="[import] format", fix=fix)
    names = [part.name for part in parts]
    if "" in names or len(set(names)) < len(names):
        names = [str(number) for number in range(1, len(parts) + 1)]
    is_one = len(parts) == 1
    return tuple(
        replace(_part_table(text, dialect, part), sample="" if is_one else name)
        for part, name in zip(parts, names, strict=True)
    )


def _part_table(text: Text, dialect: Dialect, part: Part) -> Table:
    rows = dialect.rows
    units_row = part.header_row + rows.units_row - rows.header_row if rows.units_row else 0
    has_units = 0 < units_row < part.data_row
    units = split_line(text.line(units_row), dialect.separator) if has_units else dialect.units
    start, stop = (text.start_of(line) for line in (part.header_row, part.stop))
    own = replace(
        dialect,
        rows=HeadRows(part.header_row, units_row, part.data_row),
        units=tuple(units),
        first_row=split_line(text.line(part.data_row), dialect.separator),
        notes=[*dialect.notes],
    )
    return text_table(without_footer(text.part(start, stop), own), own)


def _long_tables(source: Source, profile: ImportProfile) -> tuple[Table, ...]:
    """Return one table for each word of the column that names recordings, with the channels that a column names."""
    text, dialect = open_text(source, profile)
    whole = text_table(text, dialect)
    recording, channel, value = (
        whole.find(wanted, source, f"[import] {key}_column") if wanted else -1
        for key, wanted in (
            ("recording", profile.recording_column),
            ("channel", profile.channel_column),
            ("value", profile.value_column),
        )
    )
    if max(recording, channel) < 0 or (channel >= 0) != (value >= 0):
        why = "format 'long' needs a column that names recordings, or one that names channels and one of their values"
        fix = 'set [import] recording_column = "specimen", or channel_column = "channel" and value_column = "value"'
        raise source.error(why, code="RF105", key="[import] format", fix=fix)
    recordings, channels = _cells_of(text, dialect, (recording, channel))
    loaded = lru_cache(maxsize=None)(lambda index: whole.values([index])[0])
    samples = [*dict.fromkeys(recordings.tolist())]
    tables = []
    for sample in samples:
        here = recordings == sample
        table = replace(whole, sample=sample if len(samples) > 1 else "", first_line=0)
        if channel < 0:
            tables.append(replace(table, values=partial(_rows_of, loaded, here)))
            continue
        names = tuple(dict.fromkeys(channels[here].tolist()))
        masks = [here & (channels == name) for name in names]
        tables.append(_pivoted(table, names, masks, (value, *_time_of(whole, profile, source)), loaded))
    return tuple(tables)


def _cells_of(text: Text, dialect: Dialect, indices: Sequence[int]) -> list[np.ndarray[Any, Any]]:
    """Return the texts of columns, row by row; empty ones for a column -1, and where a row is too short."""
    rows = [row for _, row in text.rows_from(dialect.rows.data_row, dialect.separator)]
    return [np.array([row[i] if 0 <= i < len(row) else "" for row in rows]) for i in indices]


def _rows_of(
    loaded: Callable[[int], FloatArray], here: BoolArray, indices: Sequence[int]
) -> list[FloatArray]:
    return [loaded(index)[here] for index in indices]


def _time_of(whole: Table, profile: ImportProfile, source: Source) -> tuple[int, float]:
    """Return the column of the time of a long table, and the seconds of its unit."""
    given = profile.channels.get("time")
    index = whole.find(given.column, source, "[import.channels] time") if given else -1
    if index < 0:
        index = next((i for i, name in enumerate(whole.names) if is_time(name)), -1)
    unit = given.unit if given else ""
    if index >= 0:
        unit = "s" if index in whole.stamps else unit or whole.unit(index)
    try:
        return index, unit_factor(unit, "s", name="time")
    except InputError:
        why, fix = "no column is the time, with its unit", 'name it: time = { column = "t", unit = "s" }'
        raise source.error(why, code="RF105", key="[import.channels] time", fix=fix) from None


def _pivoted(
    table: Table,
    names: tuple[str, ...],
    masks: Sequence[BoolArray],
    at: tuple[int, int, float],
    loaded: Callable[[int], FloatArray],
) -> Table:
    """Return a table whose columns are the channels that a column of a long one names, each with its own clock."""
    value, time, second_s = at
    return replace(
        table,
        names=names,
        stamps=frozenset(),
        units=(table.unit(value),) * len(names),
        values=lambda indices: [loaded(value)[masks[index]] for index in indices],
        clock=lambda index: loaded(time)[masks[index]] * second_s,
        brings_time=True,
    )


WIDE = Reader(
    name="wide",
    suffixes=(),
    description="text with many recordings side by side, block_columns columns each",
    tables=_wide_tables,
)
STACKED = Reader(
    name="stacked",
    suffixes=(),
    description="text with many recordings one below the other, each with its header",
    tables=_stacked_tables,
)
LONG = Reader(
    name="long",
    suffixes=(),
    description="text with many recordings or channels in rows, distinguished by recording_column or channel_column",
    tables=_long_tables,
)
