"""What a reader gives: tables whose columns become the channels of recordings."""

import re
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import PurePath
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import DataError
from ropefric.files.text import Source
from ropefric.files.text_table import Dialect, bare_unit, is_number, read_stamps
from ropefric.quantities import split_unit_suffix
from ropefric.registry import did_you_mean
from ropefric.traces.readers.profile import Channel, ImportProfile, RawRecording

SAFE_NAMES: dict[str, tuple[str, ...]] = {
    "time": ("time", "t"),
    "force": ("force", "load", "f"),
    "counts": ("counts", "adc"),
}
"""Bare headers that can mean nothing else, lower case; all other columns must be named by the profile."""

_DIGITS_AND_MARKS = re.compile(r"[+-]?[\d.,]++")
_DATE = re.compile(r"\d[-/:.]\d++[-/:.]\d")
_NAMED_MISSING = frozenset(
    ("na", "n/a", "#n/a", "null", "none", "-", "--", "---", "?", "missing", "error", "over", "ovl")
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Table:
    """One table of a file, one recording: its columns' names and units, and a way to their values.

    `stamps` are the columns of text time stamps, whose values are seconds from the first on; `clock` gives the time [s]
    that a column brings with it; `notes` say what was recognised, some only after the values were read.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Callable[[Sequence[int]], list[FloatArray]]
    sample: str = ""
    first_line: int = 0
    stamps: frozenset[int] = frozenset()
    clock: Callable[[int], FloatArray | None] | None = None
    notes: list[str] = field(default_factory=list)

    @property
    def has_header(self) -> bool:
        """Return whether any column has a name."""
        return any(self.names)

    def unit(self, index: int) -> str:
        """Return the unit of a column: the file's own, else the suffix of its header."""
        return bare_unit(self.units[index]) or split_unit_suffix(self.names[index])[1]

    def find(self, wanted: str | int, source: Source, key: str) -> int:
        """Return the index of a column by its number or name."""
        if isinstance(wanted, int):
            n = len(self.names)
            if 1 <= wanted <= n:
                return wanted - 1
            why, fix = f"column {wanted} was asked for; {self.listed}", f"give a column number from 1 to {n}"
        elif not self.has_header:
            why = f"column {wanted!r} was asked for by name, but the columns have no names; {self.listed}"
            name = key.rpartition(" ")[2]
            fix = f"give its number, for example {name} = {{ column = 1 }}, or set header_row"
        else:
            names = [header.strip() for header in self.names]
            for candidates in (names, [split_unit_suffix(header)[0] for header in names]):
                hits = [index for index, header in enumerate(candidates) if header == wanted.strip()]
                if len(hits) == 1:
                    return hits[0]
                if hits:
                    break
            why, fix = (
                f"there is no column {wanted!r}; {self.listed}",
                did_you_mean(wanted, filter(None, names)),
            )
            if hits:
                why = f"several columns are called {wanted!r}: numbers {', '.join(str(hit + 1) for hit in hits)}"
                fix = f"give the number of the one you mean, for example {{ column = {hits[0] + 1} }}"
        raise source.error(why, code="RF105", key=key, fix=fix)

    @property
    def listed(self) -> str:
        """Return the columns for a message."""
        if not self.has_header:
            return f"the file has {len(self.names)} columns without names"
        shown = [name.strip() or f"(column {i})" for i, name in enumerate(self.names[:30], start=1)]
        more = ", ..." if len(self.names) > len(shown) else ""
        return f"the file has the columns {', '.join(shown)}{more}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Reader:
    """A file format, found by the end of the file's name, or among texts by its first lines."""

    name: str
    suffixes: tuple[str, ...]
    description: str
    tables: Callable[[Source, ImportProfile], Sequence[Table]]
    recognises: Callable[[Sequence[str]], bool] | None = None

    def read(self, source: Source, profile: ImportProfile) -> tuple[RawRecording, ...]:
        """Return the file's recordings, columns as they are in the file; raises `DataError` RF101 to RF108."""
        return tuple(_recording(table, profile, source) for table in self.tables(source, profile))


def _recording(table: Table, profile: ImportProfile, source: Source) -> RawRecording:
    picks = _pick_columns(table, profile, source)
    arrays = table.values([index for index, _ in picks.values()])
    columns = dict(zip(picks, arrays, strict=True))
    units = {channel: unit for channel, (_, unit) in picks.items()}
    if table.clock is not None and "time" not in columns and profile.sampling_rate_Hz is None:
        time_s = _common_clock(table, [index for index, _ in picks.values()], source)
        if time_s is not None:
            columns["time"], units["time"] = time_s, "s"
    name = PurePath(source.shown).name
    return RawRecording(
        name=f"{name}#{table.sample}" if table.sample else name,
        source=source.shown,
        sample=table.sample,
        columns=columns,
        units=units,
        first_line=table.first_line,
        notes=tuple(dict.fromkeys(table.notes)),
    )


def _common_clock(table: Table, indices: Sequence[int], source: Source) -> FloatArray | None:
    """Return the time [s] that columns bring with them, which must be one time; None where they bring none."""
    assert table.clock is not None  # noqa: S101  (whoever asks has looked)
    clocks = {index: time_s for index in indices if (time_s := table.clock(index)) is not None}
    first = next(iter(clocks), 0)
    for index, time_s in clocks.items():
        if not np.array_equal(time_s, clocks[first], equal_nan=True):
            why = (
                f"{table.names[first]!r} and {table.names[index]!r} have clocks of their own, and they differ"
            )
            fix = "leave one of them out: a recording has one time"
            raise source.error(why, code="RF103", key="[import.channels]", fix=fix)
    return clocks.get(first)


def guess_channels(table: Table, *, needs_time: bool = True) -> dict[str, Channel]:
    """Return the channels whose headers can mean nothing else, or an empty dict where that is not enough.

    A single column of text time stamps is the time, whatever it is called.
    """
    bare = [split_unit_suffix(name.strip())[0].lower() for name in table.names]
    found = {
        channel: [number for number, name in enumerate(bare, start=1) if name in meanings]
        for channel, meanings in SAFE_NAMES.items()
    }
    if not found["time"] and len(table.stamps) == 1:
        found["time"] = [index + 1 for index in table.stamps]
    n_time, n_signal = len(found["time"]), len(found["force"]) + len(found["counts"])
    if n_signal != 1 or n_time > 1 or (needs_time and n_time == 0):
        return {}
    return {channel: Channel(column=numbers[0]) for channel, numbers in found.items() if numbers}


def _pick_columns(table: Table, profile: ImportProfile, source: Source) -> dict[str, tuple[int, str]]:
    """Return index and unit of the column of every channel the profile names, or of those that are plain by name.

    The unit is the profile's, else the file's own, else the suffix of the header.
    """
    channels: Mapping[str, Channel] = profile.channels
    if not channels:
        channels = guess_channels(table, needs_time=profile.sampling_rate_Hz is None and table.clock is None)
        if not channels:
            fix = (
                'name the columns, for example time = { column = 1, unit = "s" } and force = { column = 2, unit = '
                f'"N" }}; `ropefric inspect {source.shown}` suggests them'
            )
            why = f"cannot tell which column is what; {table.listed}"
            raise source.error(why, code="RF105", key="[import.channels]", fix=fix)
    picks = {}
    for name, channel in channels.items():
        index = table.find(channel.column, source, f"[import.channels] {name}")
        unit = "" if name in {"counts", "end_tension_counts"} else channel.unit or table.unit(index)
        picks[name] = (index, "s" if index in table.stamps else unit)
    return picks


def bad_cell(cell: str, name: str, decimal: str, source: Source, *, line: int | None) -> DataError:
    """Return the error for a cell that is no number, with a guess at what it is."""
    other = "," if decimal == "." else "."
    why, fix = (
        "",
        "mend or remove the cell, list its text in [import] missing, or skip_footer the last lines",
    )
    if is_number(cell, decimal):
        why, fix = "it is too large for a float", "mend the cell"
    elif cell.lower().lstrip("+-") in ("inf", "infinity"):
        why = "an infinite value is no measurement"
    elif is_number(cell, other):
        mark = "comma" if other == "," else "point"
        why, fix = f"it looks like a decimal {mark}", f'[import] decimal = "{other}"'
    elif "," in cell and _DIGITS_AND_MARKS.fullmatch(cell):
        why, fix = "it looks like a thousands separator", "save the file without thousands separators"
    elif cell.lower() in _NAMED_MISSING:
        why, fix = "it looks like a mark for a missing value", f'[import] missing = ["{cell}"]'
    elif _DATE.search(cell):
        why = "it looks like a date or a clock"
        fix = "export seconds since the start, or leave the column out and set [import] sampling_rate"
    shown = cell if len(cell) <= 40 else cell[:37] + "..."
    message = f"cannot read {shown!r} as a number" + (f"; {why}" if why else "")
    return source.error(message, code="RF102", line=line, key=name, fix=fix)


def stamp_column(cells: Iterable[tuple[int, str]], name: str, dialect: Dialect, source: Source) -> FloatArray:
    """Return a column of text time stamps in seconds from its first on, and note how they were understood."""

    def refuse(line: int, why: str, fix: str) -> DataError:
        return source.error(why, code="RF104", line=line, key=name, fix=fix)

    layout = dialect.layout
    found, said = read_stamps(
        cells, order=layout.date_order, zone=layout.time_zone, no_value=layout.no_value, refuse=refuse
    )
    dialect.notes.extend(f"{name}: {text}" for text in said)
    return found


@contextmanager
def foreign(source: Source, what: str, fix: str, *, code: str = "RF101", key: str = "") -> Iterator[None]:
    """Turn whatever a library raises on a damaged file, errors of a dozen kinds, into one that names the file."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except (MemoryError, DataError):
        raise
    except Exception as error:  # noqa: BLE001  (see above)
        why = f"{what} ({type(error).__name__}: {error})"
        raise source.error(why, code=code, key=key, fix=fix) from None


def check_choice(name: str, known: Iterable[str], kind: str, source: Source) -> None:
    """Refuse the name of a table that a file does not have."""
    known = list(known)
    if name and name not in known:
        fix = did_you_mean(name, known)
        raise source.error(f"there is no {kind} {name!r}", code="RF105", key="[import] table", fix=fix)


def needs_package(what: str, source: Source) -> DataError:
    """Return the error for a format whose package is not installed."""
    return source.error(f"reading {what}", code="RF107", fix='pip install "ropefric[lab]"')


def array_table(
    columns: Mapping[str, np.ndarray[Any, Any]],
    source: Source,
    *,
    units: Mapping[str, str] | None = None,
    sample: str = "",
    clock: Callable[[int], FloatArray | None] | None = None,
    notes: Sequence[str] = (),
) -> Table:
    """Return a table of named arrays of a binary file; blank names are columns that have numbers only."""
    names = tuple(key.strip() for key in columns)
    keys = [name or f"column {number}" for number, name in enumerate(names, start=1)]
    arrays = list(columns.values())

    def values(indices: Sequence[int]) -> list[FloatArray]:
        found = [_real(keys[index], arrays[index], source) for index in indices]
        sizes = {index: array.size for index, array in zip(indices, found, strict=True)}
        if len(set(sizes.values())) > 1:
            listed = ", ".join(
                f"{keys[i]} has {size}{' values' if i == indices[0] else ''}" for i, size in sizes.items()
            )
            why = f"the columns differ in length: {listed}"
            raise source.error(why, code="RF103", fix="save them with one length")
        if found and found[0].size == 0:
            raise source.error("there are no data rows")
        return found

    return Table(
        names=names,
        units=tuple((units or {}).get(key, "") for key in columns),
        values=values,
        sample=sample,
        clock=clock,
        notes=[*notes],
    )


def _real(key: str, values: np.ndarray[Any, Any], source: Source) -> FloatArray:
    why, fix = "", ""
    if values.dtype.kind not in "iuf":
        why = f"the column holds {values.dtype} values, not real numbers"
        fix = "name another column, or save this one as numbers"
    elif np.isinf(values).any():
        why = f"sample {int(np.argmax(np.isinf(values))) + 1} is infinite, which is no measurement"
        fix = "save NaN where a sample is missing"
    if why:
        raise source.error(why, code="RF102", key=key, fix=fix)
    return values.astype(np.float64)
