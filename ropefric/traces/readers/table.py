"""The tables of a reader, whose columns become the channels of recordings."""

import re
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from importlib import import_module
from pathlib import PurePath
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray, frozen_array, sealed
from ropefric.errors import DataError, InputError
from ropefric.files.head_facts import NO_FACTS, Facts
from ropefric.files.text import Source
from ropefric.files.text_table import THOUSANDS, Dialect, bare_unit, is_number, read_stamps, unit_behind
from ropefric.quantities import is_unit_of, same_unit, split_unit_suffix, unit_factor
from ropefric.registry import did_you_mean
from ropefric.traces.readers.profile import Channel, ImportProfile, RawRecording

SAFE_NAMES: dict[str, tuple[str, ...]] = {
    "time": ("time", "t"),
    "force": ("force", "load", "f"),
    "counts": ("counts", "adc"),
}
"""Bare headers that can mean nothing else, lower case; all other columns must be named by the profile."""

_TIME_WORDS = frozenset((
    "time", "t", "zeit", "temps", "tiempo", "tempo", "tijd", "seconds", "elapsed", "elapsed_time", "test_time",
    "time_stamp", "timestamp", "laufzeit", "messzeit",
))  # fmt: skip
_GROUPS = re.compile(rf"[+-]?\d+(?:[{''.join(THOUSANDS)}]\d+)+")
_DATE = re.compile(r"\d[-/:.]\d++[-/:.]\d")
_BETWEEN_WORDS = re.compile(r"[\s_.\d]++")
_NAMED_MISSING = frozenset(
    ("na", "n/a", "#n/a", "null", "none", "-", "--", "---", "?", "missing", "error", "over", "ovl")
)


def is_time(name: str) -> bool:
    """Return whether a header is a word for the time, in the languages of loggers."""
    words = _BETWEEN_WORDS.split(split_unit_suffix(name.strip())[0].lower())
    ends = {word for word in words[:1] + words[-1:] if len(word) > 1}
    return "_".join(filter(None, words)) in _TIME_WORDS or not _TIME_WORDS.isdisjoint(ends)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Table:
    """One table of a file, one recording: its columns' names and units, and a way to their values.

    `stamps` are the columns of text time stamps, whose values are seconds from the first on; `clock` gives the time
    [s] that a column brings with it, the only one where the table `brings_time`; `facts` are what
    the head of the file states; `notes` say what was recognised, some only after the values were read.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Callable[[Sequence[int]], list[FloatArray]]
    sample: str = ""
    first_line: int = 0
    stamps: frozenset[int] = frozenset()
    clock: Callable[[int], FloatArray | None] | None = None
    brings_time: bool = False
    facts: Facts = NO_FACTS
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
        hits = self.hits(wanted)
        if len(hits) == 1:
            return hits[0]
        if isinstance(wanted, int):
            why = f"column {wanted} was asked for; {self.listed}"
            fix = f"give a column number from 1 to {len(self.names)}"
        elif not self.has_header:
            why = f"column {wanted!r} was asked for by name, but the columns have no names; {self.listed}"
            name = key.rpartition(" ")[2]
            fix = f"give its number, for example {name} = {{ column = 1 }}, or set header_row"
        elif hits:
            why = f"several columns are called {wanted!r}: numbers {', '.join(str(hit + 1) for hit in hits)}"
            fix = f"give the number of the one you mean, for example {{ column = {hits[0] + 1} }}"
        else:
            why = f"there is no column {wanted!r}; {self.listed}"
            fix = did_you_mean(wanted, filter(None, map(str.strip, self.names)))
        raise source.error(why, code="RF105", key=key, fix=fix)

    def hits(self, wanted: str | int) -> list[int]:
        """Return the indices of the columns with a number or name; a name may lack its unit."""
        if isinstance(wanted, int):
            return [wanted - 1] if 1 <= wanted <= len(self.names) else []
        names = [header.strip() for header in self.names]
        for candidates in (names, [split_unit_suffix(header)[0] for header in names]):
            if found := [index for index, header in enumerate(candidates) if header == wanted.strip()]:
                return found
        return []

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
    own_time = {
        name: table.find(channel.time, source, f"[import.channels] {name}.time")
        for name, channel in profile.channels.items()
        if name in picks and channel.time
    }
    wanted = [*dict.fromkeys((*(index for index, _ in picks.values()), *own_time.values()))]
    loaded = {i: frozen_array(sealed(one)) for i, one in zip(wanted, table.values(wanted), strict=True)}
    columns = {name: loaded[index] for name, (index, _) in picks.items()}
    seconds = {i: _in_seconds(i, loaded[i], table, picks, source) for i in own_time.values()}
    has_time = "time" in columns or profile.sampling_rate_Hz is not None
    clocks = {} if has_time else _own_clocks(table, picks)
    clocks |= {name: seconds[index] for name, index in own_time.items()}
    _check_lengths(table, picks, columns, clocks, source)
    name, rate_Hz = PurePath(source.shown).name, table.facts.rate_Hz if table.facts.is_sure else None
    notes = dict.fromkeys(table.notes)
    if rate_Hz and not has_time and not clocks:
        notes[f"the sampling rate, {rate_Hz:g} Hz, is that of the head of the file"] = None
    return RawRecording(
        name=f"{name}#{table.sample}" if table.sample else name,
        source=source.shown,
        sample=table.sample,
        columns=columns,
        units={channel: unit for channel, (_, unit) in picks.items()},
        first_line=table.first_line,
        notes=tuple(notes),
        clocks=clocks,
        rate_Hz=rate_Hz,
    )


def _check_lengths(
    table: Table,
    picks: Mapping[str, tuple[int, str]],
    columns: Mapping[str, FloatArray],
    clocks: Mapping[str, FloatArray],
    source: Source,
) -> None:
    """Refuse columns of several lengths that are to share one clock."""
    sizes = {picks[name][0]: columns[name].size for name in columns if name not in clocks}
    if len(set(sizes.values())) > 1:
        names = [table.names[index].strip() or f"column {index + 1}" for index in sizes]
        (first, n), *more = zip(names, sizes.values(), strict=True)
        why = f"the columns differ in length: {first} has {n} values"
        why += "".join(f", {name} has {n}" for name, n in more)
        fix = 'name the time of each, such as end_tension = { column = "…", time = "…" }, or save them with one length'
        raise source.error(why, code="RF103", key="[import.channels]", fix=fix)


def _in_seconds(
    index: int, values: FloatArray, table: Table, picks: Mapping[str, tuple[int, str]], source: Source
) -> FloatArray:
    """Return the time column of a channel in seconds, by its own unit or that of the time of the others."""
    unit = table.unit(index) or picks.get("time", (0, ""))[1]
    try:
        return values if unit == "s" else values * unit_factor(unit, "s", name="time")
    except InputError as error:
        fix = f"write the unit into the header of {table.names[index] or f'column {index + 1}'!r}"
        key = "[import.channels] time"
        raise source.error(error.problem.message, code="RF106", key=key, fix=fix) from None


def _own_clocks(table: Table, picks: Mapping[str, tuple[int, str]]) -> dict[str, FloatArray]:
    """Return the times [s] that the columns of channels bring with them, one array where they are one time."""
    clocks: dict[str, FloatArray] = {}
    for name, (index, _) in picks.items():
        time_s = table.clock(index) if table.clock else None
        if time_s is not None:
            alike = (one for one in clocks.values() if np.array_equal(one, time_s, equal_nan=True))
            clocks[name] = next(alike, time_s)
    return clocks


def guess_channels(table: Table, *, needs_time: bool = True, by_unit: bool = True) -> dict[str, Channel]:
    """Return the channels whose headers can mean nothing else, or an empty dict where that is not enough.

    A single column of text time stamps is the time, whatever it is called. So is the only column in a unit of time, and
    the only one in a unit of force is the force, where `by_unit`.
    """
    found = _by_words(table)
    has_none = {"time": needs_time and not found["time"], "force": not found["force"] + found["counts"]}
    for channel, unit in (("time", "s"), ("force", "N")) if by_unit else ():
        if has_none[channel]:
            found[channel] = [i + 1 for i in range(len(table.names)) if is_unit_of(table.unit(i), unit)]
    n_time, n_signal = len(found["time"]), len(found["force"]) + len(found["counts"])
    if n_signal != 1 or n_time > 1 or (needs_time and n_time == 0):
        return {}
    return {channel: Channel(column=numbers[0]) for channel, numbers in found.items() if numbers}


def _by_words(table: Table) -> dict[str, list[int]]:
    """Return the numbers of the columns that are called as a channel is, or hold the only time stamps."""
    bare = [split_unit_suffix(name.strip())[0].lower() for name in table.names]
    found = {
        channel: [number for number, name in enumerate(bare, start=1) if name in meanings]
        for channel, meanings in SAFE_NAMES.items()
    }
    if not found["time"] and len(table.stamps) == 1:
        found["time"] = [index + 1 for index in table.stamps]
    return found


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
            why = f"cannot determine the meaning of the columns; {table.listed}"
            raise source.error(why, code="RF105", key="[import.channels]", fix=fix)
    picks = {}
    for name, channel in channels.items():
        if name == "time" and table.brings_time:
            continue
        index = table.find(channel.column, source, f"[import.channels] {name}")
        if name in {"counts", "end_tension_counts"}:
            unit = ""
        elif index in table.stamps:
            unit = "s"
        else:
            unit = channel.unit or table.unit(index)
            _compare_units(name, channel, table, index, source)
        picks[name] = (index, unit)
    return picks


def _compare_units(name: str, channel: Channel, table: Table, index: int, source: Source) -> None:
    """Refuse a unit of the profile that contradicts the one in the file: a kilonewton read as a newton is no newton."""
    stated, given = table.unit(index), channel.unit
    if not given or stated in ("", given, channel.instead_of) or same_unit(stated, given) is not False:
        return
    header = table.names[index].strip() or f"column {index + 1}"
    why = f"the profile says {given}, the file {stated} (column {header!r})"
    fix = f'leave unit out to take that of the file; if the file is wrong, add instead_of = "{stated}"'
    raise source.error(why, code="RF106", key=f"[import.channels] {name}", fix=fix)


class WordError(DataError):
    """A cell or column holds words where numbers are needed, not damaged numbers."""


def bad_cell(cell: str, name: str, decimal: str, source: Source, *, line: int | None) -> DataError:
    """Return the error for a cell that is no number, with a guess at what it is."""
    other = "," if decimal == "." else "."
    why, fix = "", "mend or remove the cell, list its text in [import] missing, or skip_footer the last lines"
    if is_number(cell, decimal):
        why, fix = "it is too large for a float", "mend the cell"
    elif cell.lower().lstrip("+-") in ("inf", "infinity", "∞"):
        why = "an infinite value is no measurement"
    elif is_number(cell, other):
        mark = "comma" if other == "," else "point"
        why, fix = f"it looks like a decimal {mark}", f'[import] decimal = "{other}"'
    elif unit := unit_behind(cell):
        why, fix = f"it is in {unit}, other cells or the header are not", "write one unit, into the header"
    elif _GROUPS.fullmatch(cell):
        mark = next(mark if mark.strip() else " " for mark in cell if mark in THOUSANDS)
        why, fix = "it looks like a thousands separator", f'[import] thousands = "{mark}"'
    elif cell.lower() in _NAMED_MISSING:
        why, fix = "it looks like a mark for a missing value", f'[import] missing = ["{cell}"]'
    elif _DATE.search(cell):
        why = "it looks like a date or a clock"
        fix = "export seconds since the start, or leave the column out and set [import] sampling_rate"
    shown = cell if len(cell) <= 40 else cell[:37] + "..."
    message = f"cannot read {shown!r} as a number"
    if not why:
        return WordError(message, code="RF102", path=source.shown, line=line, key=name, fix=fix)
    return source.error(f"{message}; {why}", code="RF102", line=line, key=name, fix=fix)


def stamp_column(cells: Iterable[tuple[int, str]], name: str, dialect: Dialect, source: Source) -> FloatArray:
    """Return a column of text time stamps in seconds from its first on, and note how they were understood."""

    def refuse(line: int, why: str, fix: str) -> DataError:
        return source.error(why, code="RF104", line=line, key=name, fix=fix)

    layout = dialect.layout
    found, said = read_stamps(cells, order=layout.date_order, no_value=layout.no_value, refuse=refuse)
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


def package(name: str, kind: str, source: Source) -> Any:
    """Return a package of the extra `lab`, which is loaded only for a file that needs it."""
    try:
        return import_module(name)
    except ImportError:
        why = f"reading {kind} needs the package {name}"
        raise source.error(why, code="RF107", fix='pip install "ropefric[lab]"') from None


def recordings_among(
    tables: Mapping[str, Table], sizes: Mapping[str, int], profile: ImportProfile, kind: str
) -> tuple[Table, ...]:
    """Return those tables of a file that are recordings: with the columns that the profile names, and alike.

    Where it names none, or none has them, the largest says which columns a recording has.
    """
    wanted = {channel.column for channel in profile.channels.values() if isinstance(channel.column, str)}
    fitting = [name for name, table in tables.items() if wanted <= {*table.names}] or [*tables]
    largest = tables[max(fitting, key=lambda name: sizes[name])]
    found = [name for name in fitting if tables[name].names == largest.names and sizes[name]]
    several = len(found) > 1
    if len(tables) > 1:
        alike = f"those with the columns {', '.join(largest.names)[:200]}: {len(found)}"
        note = f"of the {kind} {', '.join(map(repr, tables))[:200]} {alike if several else repr(found[0])}"
        for name in found:
            tables[name].notes.insert(0, note)
    return tuple(replace(tables[name], sample=name if several else "") for name in found)


def seconds_from_first(stamps: Sequence[Any]) -> list[float]:
    """Return time stamps in seconds from the earliest of them on; 0 where there is none, NaN where it is missing."""
    known: list[Any] = [None if stamp is None else np.datetime64(stamp, "ns") for stamp in stamps]
    first = min((stamp for stamp in known if stamp is not None and not np.isnat(stamp)), default=None)
    return [
        0.0 if stamp is None or first is None else float((stamp - first) / np.timedelta64(1, "ns")) / 1e9
        for stamp in known
    ]


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
    stamps = frozenset(index for index, array in enumerate(arrays) if array.dtype.kind == "M")

    def values(indices: Sequence[int]) -> list[FloatArray]:
        found = [_real(keys[index], arrays[index], source) for index in indices]
        if found and not max(array.size for array in found):
            raise source.error("there are no data rows")
        return found

    return Table(
        names=names,
        units=tuple("s" if i in stamps else (units or {}).get(key, "") for i, key in enumerate(columns)),
        values=values,
        stamps=stamps,
        sample=sample,
        clock=clock,
        notes=[*notes],
    )


def _real(key: str, values: np.ndarray[Any, Any], source: Source) -> FloatArray:
    if values.dtype.kind == "M":  # time stamps, from the first of them on
        first = values[~np.isnat(values)][:1]
        return np.asarray((values - first) / np.timedelta64(1, "s"), dtype=np.float64)
    if values.dtype.kind not in "iuf":
        why = f"the column holds {values.dtype} values, not real numbers"
        fix = "name another column, or save this one as numbers"
        raise WordError(why, code="RF102", path=source.shown, key=key, fix=fix)
    if np.isinf(values).any():
        why = f"sample {int(np.argmax(np.isinf(values))) + 1} is infinite, which is no measurement"
        raise source.error(why, code="RF102", key=key, fix="save NaN where a sample is missing")
    return values.astype(np.float64)
