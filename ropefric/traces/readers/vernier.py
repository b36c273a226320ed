"""Vernier Logger Pro (.cmbl): XML, a data set a run, its columns as lines of numbers."""

import math
from collections.abc import Iterator
from xml.etree.ElementTree import Element, ParseError, fromstring

import numpy as np

from ropefric.files.text import Source
from ropefric.files.text_table import is_number
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.table import Reader, Table, array_table, bad_cell, check_choice

_MISSED = "Z1"  # how a cell begins whose sample the sensor missed


def _tables(source: Source, profile: ImportProfile) -> tuple[Table, ...]:
    """Return a table for every run that has numbers, or for the one that the profile names."""
    root = _load(source)
    runs = {}
    for number, data_set in enumerate(root.iter("DataSet"), start=1):
        columns = [*data_set.iter("DataColumn")]
        if any((column.findtext("ColumnCells") or "").strip() for column in columns):
            name = (data_set.findtext("DataSetName") or "").strip() or str(number)
            runs[name if name not in runs else f"{name} ({number})"] = columns
    check_choice(profile.table, runs, "run", source)
    if not runs:
        raise source.error("no run of this Vernier file holds a number", fix="record it again")
    chosen = {profile.table: runs[profile.table]} if profile.table else runs
    said = f"Vernier Logger Pro, runs: {', '.join(runs)}"
    return tuple(
        _run(columns, name if len(chosen) > 1 else "", said, source) for name, columns in chosen.items()
    )


def _load(source: Source) -> Element:
    """Return the document; one with a DOCTYPE is refused, for a line of entities can unpack to gigabytes."""
    raw = source.raw_bytes()
    if b"<!DOCTYPE" in raw.replace(b"\0", b""):  # in UTF-16 too
        raise source.error("the file defines XML entities, which no logger writes", fix="save it again")
    try:
        return fromstring(raw)  # noqa: S314  (without a DOCTYPE there are no entities)
    except (ParseError, LookupError, ValueError) as error:
        line = error.position[0] if isinstance(error, ParseError) else None
        fix = "copy it again from the logger, or name its format in [import] format"
        raise source.error(f"this is not a readable Vernier file ({error})", line=line, fix=fix) from None


def _run(columns: list[Element], sample: str, said: str, source: Source) -> Table:
    arrays, units = {}, {}
    for number, column in enumerate(columns, start=1):
        name = (column.findtext("DataObjectName") or "").strip() or f"column {number}"
        name = name if name not in arrays else f"{name} ({number})"
        arrays[name] = np.array([*_numbers(column.findtext("ColumnCells") or "", name, source)])
        units[name] = (column.findtext("ColumnUnits") or "").strip()
    longest = max(array.size for array in arrays.values())
    # A run that was stopped early leaves calculated columns short.
    whole = {name: np.append(a, np.full(longest - a.size, np.nan)) for name, a in arrays.items()}
    return array_table(whole, source, units=units, sample=sample, notes=[said])


def _numbers(cells: str, name: str, source: Source) -> Iterator[float]:
    for row in cells.strip("\r\n \t").splitlines():
        cell = row.strip()
        if not cell or cell.startswith(_MISSED):
            yield math.nan
        elif is_number(cell, "."):
            yield float(cell)
        else:
            raise bad_cell(cell, name, ".", source, line=None)


READER = Reader(
    name="vernier", suffixes=(".cmbl",), description="Vernier Logger Pro: a recording a run", tables=_tables
)
