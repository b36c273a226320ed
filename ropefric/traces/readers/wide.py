"""Wide text: many recordings side by side in one table."""

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.traces.readers.cells import split_line
from ropefric.traces.readers.delimited import ends_empty, open_text, parse_columns
from ropefric.traces.readers.dialect import Dialect
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.reader import Reader
from ropefric.traces.readers.rows import check_rows
from ropefric.traces.readers.source import Source
from ropefric.traces.readers.table import Table
from ropefric.traces.readers.text import Text


def _tables(source: Source, profile: ImportProfile) -> tuple[Table, ...]:
    """Return one table per block of columns; rows that are empty at a block's end belong to longer blocks."""
    width = profile.block_columns
    if width < 1:
        raise source.error(
            "format 'wide' needs the number of columns of one recording",
            code="RF105",
            key="[import] block_columns",
            fix="set [import] block_columns, for example block_columns = 4",
        )
    text, dialect = open_text(source, profile)
    n_blocks = _count_blocks(text, dialect, width)
    n_rows, is_gapless = check_rows(
        text,
        dialect.data_row,
        dialect.style.separator,
        dialect.n_cells,
        expected=f"line {dialect.data_row} has {dialect.n_cells}: {n_blocks} blocks of {width}",
        block_columns=width,
    )
    names = _spread(dialect.header, n_blocks, width)
    units = _spread(dialect.units, n_blocks, width)
    load = _shared(text, dialect, [name for block in names for name in block], width, n_rows)
    return tuple(
        Table(
            names=names[block],
            units=units[block],
            values=_block_values(load, block),
            has_header=any(names[block]),
            sample=sample,
            first_line=dialect.data_row if is_gapless else 0,
        )
        for block, sample in enumerate(_samples(text, dialect, profile, n_blocks))
    )


def _count_blocks(text: Text, dialect: Dialect, width: int) -> int:
    """Return the number of recordings side by side; a trailing separator makes no column."""
    n_blocks, surplus = divmod(dialect.n_cells, width)
    if n_blocks == 0 or surplus > 1 or (surplus and not ends_empty(text, dialect, 1)):
        raise text.source.error(
            f"{dialect.n_cells} columns cannot be divided into recordings of {width} columns",
            code="RF103",
            line=dialect.data_row,
            key="[import] block_columns",
            fix="correct [import] block_columns or data_row",
        )
    return n_blocks


def _spread(cells: Sequence[str], n_blocks: int, width: int) -> list[tuple[str, ...]]:
    """Return cells by block; a block without any takes those of the first, which vendors write only once."""
    padded = [*cells, *[""] * (n_blocks * width)]
    blocks = [tuple(padded[i * width : (i + 1) * width]) for i in range(n_blocks)]
    return [block if any(block) else blocks[0] for block in blocks]


def _samples(text: Text, dialect: Dialect, profile: ImportProfile, n_blocks: int) -> list[str]:
    """Return the blocks' names: the first filled cell of each in the names row, else their numbers."""
    row = profile.block_names_row
    samples = [str(number) for number in range(1, n_blocks + 1)]
    if row < 1:
        return samples
    cells = split_line(text.line(row), dialect.style.separator)
    width = profile.block_columns
    for block in range(n_blocks):
        filled = [cell for cell in cells[block * width : (block + 1) * width] if cell]
        samples[block] = filled[0] if filled else samples[block]
    if len(set(samples)) < n_blocks:
        twice = next(sample for sample in samples if samples.count(sample) > 1)
        raise text.source.error(
            f"two recordings are called {twice!r}",
            code="RF105",
            line=row,
            key="[import] block_names_row",
            fix="set block_names_row = 0 to number them",
        )
    return samples


def _shared(
    text: Text, dialect: Dialect, names: Sequence[str], width: int, n_rows: int
) -> Callable[[tuple[int, ...]], dict[int, FloatArray]]:
    """Return a loader that parses the file once for all blocks that ask for the same columns."""
    n_blocks = len(names) // width

    @lru_cache(maxsize=1)
    def load(offsets: tuple[int, ...]) -> dict[int, FloatArray]:
        indices = [block * width + offset for block in range(n_blocks) for offset in offsets]
        return dict(zip(indices, parse_columns(text, dialect, names, indices, n_rows), strict=True))

    def load_block(block_and_offsets: tuple[int, ...]) -> dict[int, FloatArray]:
        block, *offsets = block_and_offsets
        columns = load(tuple(sorted(set(offsets))))
        return {offset: columns[block * width + offset] for offset in offsets}

    return load_block


def _block_values(
    load: Callable[[tuple[int, ...]], dict[int, FloatArray]], block: int
) -> Callable[[Sequence[int]], list[FloatArray]]:
    def values(offsets: Sequence[int]) -> list[FloatArray]:
        columns = load((block, *offsets))
        filled = ~np.all([np.isnan(column) for column in columns.values()], axis=0)
        n_rows = int(np.flatnonzero(filled)[-1]) + 1 if filled.any() else 0
        return [columns[offset][:n_rows] for offset in offsets]

    return values


READER = Reader(
    name="wide",
    suffixes=(),
    description="text with many recordings side by side, block_columns columns each",
    tables=_tables,
)
