"""Look at a recording file without knowing it: what is in it, and which import profile would read it."""

from dataclasses import replace
from itertools import accumulate, islice
from pathlib import Path, PurePath

from ropefric.errors import DataError
from ropefric.files.read import InputFile, use_file
from ropefric.traces.readers import TEXT_FORMATS, find_reader
from ropefric.traces.readers.cells import split_line
from ropefric.traces.readers.delimited import open_text
from ropefric.traces.readers.dialect import Dialect
from ropefric.traces.readers.inspection import ColumnSummary, Inspection
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.profile_toml import profile_to_toml
from ropefric.traces.readers.sidebyside import find_blocks
from ropefric.traces.readers.source import Source
from ropefric.traces.readers.summary import summarise, widen
from ropefric.traces.readers.text import WHOLE_BYTES, Text

__all__ = ["ColumnSummary", "Inspection", "inspect_file", "profile_to_toml"]

N_FIRST_ROWS = 5
PART_BYTES = 2**20
"""Of a text of more than `WHOLE_BYTES`, this much of the beginning and of the end is looked at."""
_TAIL_ENCODINGS = ("utf-8", "utf-8-sig", "cp1252")


def inspect_file(
    path: str | PurePath,
    profile: ImportProfile | None = None,
    *,
    shown_as: str = "",
    everything: bool = False,
) -> Inspection:
    r"""Return what can be found out about a recording file, and the profile that would read it."""
    shown, known = shown_as or str(path), profile or ImportProfile()

    def look(file: InputFile) -> Inspection:
        source = Source(path=Path(path), shown=shown, file=file)
        return _inspect(source, known, everything=everything)

    return use_file(path, look, shown=shown)


def _inspect(source: Source, profile: ImportProfile, *, everything: bool) -> Inspection:
    reader = find_reader(source.path, profile, shown_as=source.shown)
    if reader.name in TEXT_FORMATS:
        return (
            _inspect_text(source, profile)
            if everything or _is_small(source)
            else _inspect_ends(source, profile)
        )
    found = Inspection(file=source.shown, format=reader.name, profile=replace(profile, format=reader.name))
    return summarise(found, reader.tables(source, profile))


def _is_small(source: Source) -> bool:
    sizes = (
        accumulate(len(block) for block in source.unpacked()) if source.is_packed else (source.opened.size,)
    )
    return all(size <= WHOLE_BYTES for size in sizes)


def _inspect_ends(source: Source, profile: ImportProfile) -> Inspection:
    """Return what the beginning and the end of a large text tell."""
    size, head = PART_BYTES, replace(source, most_bytes=PART_BYTES)
    found = _inspect_text(head, profile)
    while not found.n_rows and size < WHOLE_BYTES:  # pragma: no cover - a head of megabytes
        size *= 2
        found = _inspect_text(replace(source, most_bytes=size), profile)
    parts = "first megabyte was" if source.is_packed else "first and last megabytes were"
    doubts = [f"only the {parts} read: numbers of rows and ranges are at least these; --all reads everything"]
    n_about = 0
    if not source.is_packed:
        n_about = round(found.n_rows * source.opened.size / size)
        if found.encoding in _TAIL_ENCODINGS:
            try:
                found = _widened(found, source)
            except DataError as error:
                doubts.append(f"near the end of the file: {error.problem.message}")
    return replace(found, n_rows_about=n_about or found.n_rows, doubts=(*found.doubts, *doubts))


def _widened(found: Inspection, source: Source) -> Inspection:
    """Return the inspection with what the last lines add to ranges and counts."""
    tail = replace(source, most_bytes=-PART_BYTES)
    profile = replace(
        found.profile,
        channels={},
        header_row=0,
        units_row=0,
        block_names_row=0,
        data_row=2,  # the first line is cut
        decimal=found.decimal,
    )
    (table, *_) = find_reader(source.path, replace(profile, format="delimited")).tables(tail, profile)
    last = summarise(Inspection(file=found.file, format=found.format, profile=profile), [table])
    if len(last.columns) != len(found.columns):
        raise source.error(f"there are {len(last.columns)} columns, not {len(found.columns)}")
    columns = tuple(widen(one, other) for one, other in zip(found.columns, last.columns, strict=True))
    hints = dict.fromkeys((*found.saturation, *last.saturation))
    return replace(found, columns=columns, n_rows=found.n_rows + last.n_rows, saturation=tuple(hints))


def _inspect_text(source: Source, profile: ImportProfile) -> Inspection:
    doubts = []
    decimal_is_open = False
    try:
        text, dialect = open_text(source, profile)
    except DataError as error:
        if error.code != "RF104" or profile.decimal:
            raise
        doubts.append(str(error))
        decimal_is_open = True  # in the profile too, so that reading still refuses until somebody decides
        profile = replace(profile, decimal=",")
        text, dialect = open_text(source, profile)
    profile = find_blocks(text, dialect, profile) or replace(
        profile, header_row=dialect.header_row, units_row=dialect.units_row, data_row=dialect.data_row
    )
    reader = find_reader(source.path, replace(profile, format="delimited"))
    try:
        tables = reader.tables(source, profile)
    except DataError as error:
        if error.code != "RF103" or profile.header_row == 0:
            raise
        doubts.append(str(error))
        profile = replace(profile, header_row=0, units_row=0)
        text, dialect = open_text(source, profile)
        tables = reader.tables(source, profile)
    style = dialect.style
    encoding = "" if text.encoding in {"utf-8", "utf-8-sig"} else text.encoding
    decimal = "" if decimal_is_open else style.decimal
    found = Inspection(
        file=source.shown,
        format=reader.name,
        encoding=text.encoding,
        separator=style.separator,
        decimal=style.decimal,
        header_row=profile.header_row,
        units_row=profile.units_row,
        data_row=profile.data_row,
        first_rows=_first_rows(text, dialect),
        profile=replace(
            profile, format=reader.name, separator=style.separator, decimal=decimal, encoding=encoding
        ),
        doubts=tuple(doubts),
    )
    return summarise(found, tables)


def _first_rows(text: Text, dialect: Dialect) -> tuple[tuple[str, ...], ...]:
    lines = islice(text.lines_from(dialect.data_row), N_FIRST_ROWS)
    return tuple(tuple(split_line(line, dialect.style.separator)) for _, line in lines)
