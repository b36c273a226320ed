"""LabVIEW measurement files (.lvm): tagged headers, then blocks of rows, each of which may have a header of its own."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import DataError
from ropefric.files.stamps import read_stamps
from ropefric.files.text import Source, Text, is_blank_line, load_text, split_line
from ropefric.files.text_table import Dialect, HeadRows
from ropefric.glossary import counted
from ropefric.traces.clock import GAP_STEPS
from ropefric.traces.readers.delimited import text_table
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.table import Reader, Table

_MAGIC = "LabVIEW Measurement"
_END = re.compile(rb"^\*\*\*End_of_Header\*\*\*[^\n]*\n", re.MULTILINE)
_SPECIAL = re.compile(
    rb"^\*\*\*Start_Special\*\*\*.*?^\*\*\*End_Special\*\*\*[^\n]*", re.MULTILINE | re.DOTALL
)
_SEPARATORS = {"Tab": "\t", "Comma": ",", "Semicolon": ";", "Space": " "}
_UNITS = {
    "Newtons": "N",
    "Newton": "N",
    "Volts": "V",
    "Volt": "V",
    "Meters": "m",
    "Seconds": "s",
    "Kilograms": "kg",
}

_Tags = Mapping[str, Sequence[str]]


def _tables(source: Source, profile: ImportProfile) -> tuple[Table, ...]:
    """Return the file's recordings; a block that goes on where the one before ended belongs to the same."""
    text = load_text(source, profile.encoding)
    data = b"".join(block.data for block in text.blocks())
    data = _SPECIAL.sub(lambda found: b"\n" * found[0].count(b"\n"), data)
    text = replace(text, data=data, is_whole=True)
    ends = [found.end() for found in _END.finditer(data)]
    if len(ends) < 2:
        why = "this LabVIEW file has no second ***End_of_Header***, so no header of its channels"
        fix = 'write it with headers, or describe it, with [import] format = "delimited"'
        raise source.error(why, code="RF103", fix=fix)
    generals = [_tags(data[: ends[0]], mark) for mark in "\t,;"]
    general = next((tags for tags in generals if "Separator" in tags), generals[0])
    separator = "".join(general.get("Separator", ["Tab"])[:1])
    separator, decimal = (
        _SEPARATORS.get(separator, separator),
        "".join(general.get("Decimal_Separator", ".")[:1]),
    )
    if len(separator) != 1 or decimal not in (".", ",") or separator == decimal:
        why = (
            f"the header tells the separator {separator!r} and the decimal mark {decimal!r}, which cannot be"
        )
        raise source.error(
            why, code="RF103", line=1, fix='describe the file, with [import] format = "delimited"'
        )
    columns = "".join(general.get("X_Columns", ["One"])[:1]).lower()
    starts = [ends[0], *(_start_of_header(data, *part) for part in pairwise(ends[1:])), len(data)]
    notes = [f"LabVIEW measurement of {counted(len(ends) - 1, 'header block')}, X columns: {columns}"]
    blocks = []
    for start, end, stop in zip(starts, ends[1:], starts[1:], strict=False):
        header = _tags(data[start:end], separator)
        block = _block(text.part(end, stop), header, (separator, decimal, columns), profile, notes)
        if block is not None:
            blocks.append((block, header))
    if not blocks:
        raise source.error("no block has data rows", fix="record it again")
    return _recordings(blocks, notes)


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


def _block(
    text: Text, header: _Tags, layout: tuple[str, str, str], profile: ImportProfile, notes: list[str]
) -> Table | None:
    """Return the table of a block, None where it has no rows; each channel has its X column, or its X0 and Delta_X."""
    separator, decimal, columns = layout
    lines = [item for item, _ in zip(text.lines_from(text.first_line), range(9), strict=False)]
    (row, line), *below = [(n, line) for n, line in lines if not is_blank_line(line, separator)] or [(0, "")]
    if not below:
        return None
    names = split_line(line, separator)
    while len(names) > 1 and not names[-1]:
        names.pop()
    n = len(names) - (names[-1].lower() == "comment")
    is_multi = columns == "multi"
    channels = range(1, n, 2 if is_multi else 1)

    def told(tag: str) -> dict[int, str]:
        cells = header.get(tag, ())
        return dict(zip(channels, cells[:: 2 if is_multi else 1], strict=False))

    units, steps, starts = told("Y_Unit_Label"), told("Delta_X"), told("X0")
    dimension = told("X_Dimension").get(1, "")
    if dimension not in ("", "Time"):
        why, fix = f"the X axis is {dimension!r}, not the time", "write the file with the time as X"
        raise text.source.error(why, code="RF103", line=row, fix=fix)
    # Where channels have steps of their own, the only X column is that of the first.
    own_x = {i: i - 1 if is_multi else 0 for i in channels if is_multi or steps.get(i) == steps.get(1)}
    dialect = Dialect(
        separator=separator,
        decimal=decimal,
        rows=HeadRows(row, 0, below[0][0]),
        header=tuple(names),
        units=tuple("s" if i not in units else _UNITS.get(units[i], units[i]) for i in range(n)),
        n_cells=len(split_line(below[0][1], separator)),
        stamps=frozenset(),
        no_value=profile.no_value,
        no_value_numbers=profile.no_value_numbers(decimal),
    )
    table = text_table(text, dialect, notes, profile)

    def clock(index: int) -> FloatArray | None:
        if columns != "no":
            return table.values([own_x[index]])[0] if index in own_x else None
        start_s, step_s = (_float(told.get(index, "")) for told in (starts, steps))
        n_rows = table.values([index])[0].size if index in channels and step_s > 0 else 0
        return np.asarray(start_s + step_s * np.arange(n_rows), dtype=np.float64) if n_rows else None

    return replace(table, clock=clock)


def _float(cell: str) -> float:
    try:
        return float(cell.replace(",", "."))
    except ValueError:
        return np.nan


def _recordings(blocks: Sequence[tuple[Table, _Tags]], notes: list[str]) -> tuple[Table, ...]:
    """Return a table a recording: blocks are one where no more than five steps are missing between them."""
    began = [f"{''.join(tags.get('Date', ())[:1])} {''.join(tags.get('Time', ())[:1])}" for _, tags in blocks]
    try:
        began_s, _ = read_stamps(
            enumerate(began),
            order="ymd",
            zone="",
            no_value=(),
            refuse=lambda _, why, fix: DataError(why, fix=fix),
        )
    except DataError:
        began_s = np.full(len(blocks), np.nan)
    groups: list[list[tuple[float, Table]]] = []
    end_s = np.nan
    for (table, tags), block_s in zip(blocks, began_s.tolist(), strict=True):
        clock_s = table.clock(1) if table.clock is not None and len(blocks) > 1 else None
        step_s = _float("".join(tags.get("Delta_X", ())[:1]))
        if clock_s is not None and clock_s.size:
            gap_s = block_s + clock_s[0] - end_s
            if groups and table.names == groups[-1][0][1].names and 0 < gap_s <= GAP_STEPS * step_s:
                groups[-1].append((block_s, table))
            else:
                groups.append([(block_s, table)])
            end_s = block_s + float(clock_s[-1])
        else:
            groups.append([(block_s, table)])
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
