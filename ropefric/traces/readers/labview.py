"""LabVIEW measurement files (.lvm): tagged headers, then blocks of rows, each of which may have a header of its own."""

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import DataError
from ropefric.files.text import Source, Text, load_text, split_line
from ropefric.files.text_table import Dialect, HeadRows, read_stamps
from ropefric.glossary import counted
from ropefric.traces.clock import GAP_STEPS
from ropefric.traces.readers.delimited import text_table, without_footer
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.table import Reader, Table

_MAGIC = "LabVIEW Measurement"
_END = re.compile(rb"^\*\*\*End_of_Header\*\*\*[^\n]*\n", re.MULTILINE)
_SEPARATORS = {"Tab": "\t", "Comma": ",", "Semicolon": ";", "Space": " "}
_SPECIAL = (b"***Start_Special", b"***End_Special")

_Tags = Mapping[str, Sequence[str]]


def _without_special_blocks(data: bytes) -> bytes:
    """Return a file with the lines of its special blocks empty, so that the others keep their numbers."""
    kept, at, start = [], 0, data.find(_SPECIAL[0])
    while start >= 0 and (stop := data.find(_SPECIAL[1], start)) >= 0:
        end = data.find(b"\n", stop)
        end = len(data) if end < 0 else end
        if start == 0 or data[start - 1 : start] == b"\n":
            kept += [data[at:start], b"\n" * data.count(b"\n", start, end)]
            at = end
        start = data.find(_SPECIAL[0], max(start + 1, at))
    return b"".join([*kept, data[at:]])


def _tables(source: Source, profile: ImportProfile) -> tuple[Table, ...]:
    """Return the file's recordings; a block that continues the one before belongs to the same recording."""
    text = load_text(source, profile.encoding)
    data = _without_special_blocks(text.data)
    text = replace(text, data=data)
    ends = [found.end() for found in _END.finditer(data)]
    fix = 'describe the file, with [import] format = "delimited"'
    if len(ends) < 2:
        why = "this LabVIEW file has no second ***End_of_Header***, so no header of its channels"
        raise source.error(why, code="RF103", fix=f"write it with headers, or {fix}")
    general = _tags_of_any_mark(data[: ends[0]])
    layout = _layout(general, profile, source, fix)
    columns = _first(general, "X_Columns", "One").lower()
    notes = [f"LabVIEW measurement of {counted(len(ends) - 1, 'header block')}, X columns: {columns}"]
    starts = [ends[0], *(_start_of_header(data, *part) for part in pairwise(ends[1:])), len(data)]
    blocks = []
    for start, end, stop in zip(starts, ends[1:], starts[1:], strict=False):
        tags = _tags(data[start:end], layout.separator)
        block = _block(text.part(end, stop), tags, columns, layout, notes)
        blocks += [(block, tags)] if block is not None else []
    if not blocks:
        raise source.error("no block has data rows", fix="record it again")
    return _recordings(blocks, notes)


def _tags_of_any_mark(header: bytes) -> _Tags:
    """Return the tags of the first header, which itself says what separates them."""
    every = [_tags(header, mark) for mark in "\t,;"]
    return next((tags for tags in every if "Separator" in tags), every[0])


def _layout(general: _Tags, profile: ImportProfile, source: Source, fix: str) -> ImportProfile:
    """Return the profile with the separator and the decimal mark that a header states."""
    separator, decimal = _first(general, "Separator", "Tab"), _first(general, "Decimal_Separator", ".")
    separator = _SEPARATORS.get(separator, separator)
    if len(separator) != 1 or decimal not in (".", ",") or separator == decimal:
        why = f"its header states the separator {separator!r} and the decimal mark {decimal!r}"
        raise source.error(why, code="RF103", line=1, fix=fix)
    return replace(profile, separator=separator, decimal=decimal)


def _first(tags: _Tags, tag: str, usual: str = "") -> str:
    return next(iter(tags.get(tag, ())), usual)


def _start_of_header(data: bytes, low: int, end: int) -> int:
    """Return where the tags begin that end at a byte: they are lines that begin with a letter."""
    while end > low:
        start = data.rfind(b"\n", low, end - 1) + 1 or low
        if not (data[start : start + 1].isalpha() or data.startswith(b"***", start)):
            break
        end = start
    return end


def _tags(header: bytes, separator: str) -> _Tags:
    rows = (split_line(line, separator) for line in header.decode(errors="replace").split("\n"))
    return {row[0]: row[1:] for row in rows if row[0]}


def _block(text: Text, tags: _Tags, columns: str, layout: ImportProfile, notes: list[str]) -> Table | None:
    """Return the table of a block, None where it has no rows; each channel has its X column, or its X0 and Delta_X."""
    rows = text.rows_from(text.first_line, layout.separator)
    (row, names), (data_row, first_row) = next(rows, (0, [""])), next(rows, (0, [""]))
    if not data_row:
        return None
    while len(names) > 1 and not names[-1]:
        names.pop()
    n, every = len(names) - (names[-1].lower() == "comment"), 2 if columns == "multi" else 1
    channels = range(1, n, every)
    units, steps, starts, dimensions = (
        dict(zip(channels, tags.get(tag, ())[::every], strict=False))
        for tag in ("Y_Unit_Label", "Delta_X", "X0", "X_Dimension")
    )
    dimension = dimensions.get(1, "")
    if dimension not in ("", "Time"):
        why, fix = f"the X axis is {dimension!r}, not the time", "write the file with the time as X"
        raise text.source.error(why, code="RF103", line=row, fix=fix)
    # Where channels have steps of their own, the only X column is that of the first.
    own_x = {i: i - 1 if every == 2 else 0 for i in channels if every == 2 or steps.get(i) == steps.get(1)}
    dialect = Dialect(
        separator=layout.separator,
        decimal=layout.decimal,
        rows=HeadRows(row, 0, data_row),
        header=tuple(names),
        units=tuple(units.get(i, "") if i in channels else "s" for i in range(n)),
        first_row=first_row,
        layout=layout,
        notes=notes,
    )
    table = text_table(without_footer(text, dialect), dialect)

    def clock(index: int) -> FloatArray | None:
        if columns != "no":
            return table.values([own_x[index]])[0] if index in own_x else None
        start_s, step_s = (_float(tag.get(index, "")) for tag in (starts, steps))
        n_rows = table.values([index])[0].size if index in channels and step_s > 0 else 0
        return np.asarray(start_s + step_s * np.arange(n_rows), dtype=np.float64) if n_rows else None

    return replace(table, clock=clock)


def _float(cell: str) -> float:
    try:
        value = float(cell.replace(",", "."))
    except ValueError:
        return np.nan
    return value if np.isfinite(value) else np.nan


def _recordings(blocks: Sequence[tuple[Table, _Tags]], notes: list[str]) -> tuple[Table, ...]:
    """Return a table a recording: blocks are one where no more than five steps are missing between them."""
    began = [f"{_first(tags, 'Date')} {_first(tags, 'Time')}" for _, tags in blocks]
    began_s = np.full(len(blocks), np.nan)  # which no block goes on from
    with suppress(DataError):
        began_s, _ = read_stamps(
            enumerate(began),
            order="ymd",
            no_value=(),
            refuse=lambda _, why, fix: DataError(why, fix=fix),
        )
    groups: list[list[tuple[float, Table]]] = []
    end_s = np.nan
    for (table, tags), block_s in zip(blocks, began_s.tolist(), strict=True):
        clock_s = table.clock(1) if table.clock is not None and len(blocks) > 1 else None
        first_s, last_s = (np.nan, np.nan) if clock_s is None else block_s + clock_s[[0, -1]]
        is_next = 0 < first_s - end_s <= GAP_STEPS * _float(_first(tags, "Delta_X"))
        if is_next and table.names == groups[-1][0][1].names:
            groups[-1].append((block_s, table))
        else:
            groups.append([(block_s, table)])
        end_s = last_s
    if len(blocks) > 1:
        notes.append(f"by their times the blocks make {counted(len(groups), 'recording')}")
    samples = [str(number) for number in range(1, len(groups) + 1)] if len(groups) > 1 else [""]
    return tuple(_joined(group, sample) for group, sample in zip(groups, samples, strict=True))


def _joined(group: Sequence[tuple[float, Table]], sample: str) -> Table:
    (first_s, first), *rest = group
    if not rest:
        return replace(first, sample=sample)

    def values(indices: Sequence[int]) -> list[FloatArray]:
        parts = [table.values(indices) for _, table in group]
        return [np.concatenate(columns) for columns in zip(*parts, strict=True)]

    def clock(index: int) -> FloatArray | None:
        clocks = [table.clock(index) if table.clock else None for _, table in group]
        shifted = [c + (s - first_s) for c, (s, _) in zip(clocks, group, strict=True) if c is not None]
        return np.concatenate(shifted) if len(shifted) == len(clocks) else None

    return replace(first, sample=sample, values=values, clock=clock, first_line=0)


READER = Reader(
    name="labview",
    suffixes=(),
    description="LabVIEW measurement files (.lvm), one or many header blocks",
    tables=_tables,
    recognises=lambda lines: bool(lines) and lines[0].startswith(_MAGIC),
)
