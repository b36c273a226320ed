"""Look at a recording file without knowing it: what is in it, and which import profile would read it."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from itertools import accumulate, islice
from pathlib import Path, PurePath
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import DataError
from ropefric.files.disk import InputFile, use_file
from ropefric.files.text import WHOLE_BYTES, Source, Text, split_line
from ropefric.files.text_table import Dialect, is_unit
from ropefric.quantities import split_unit_suffix
from ropefric.traces.clock import GAP_STEPS, mend_clock
from ropefric.traces.noise import runs_of
from ropefric.traces.readers import TEXT_FORMATS, find_reader
from ropefric.traces.readers.delimited import open_text
from ropefric.traces.readers.profile import Channel, ImportProfile, profile_to_toml
from ropefric.traces.readers.table import Table, guess_channels
from ropefric.traces.signals import si_scale, signal_unit

N_FIRST_ROWS = 5
PART_BYTES = 2**20
"""Of a text of more than `WHOLE_BYTES`, this much of the beginning and of the end is looked at."""
MIN_RUN = 3
"""Samples in a row at a converter's limit that make a hint."""

_TAIL_ENCODINGS = ("utf-8", "utf-8-sig", "cp1252")
_FULL_SCALES = {2**bits - 1: bits for bits in (8, 10, 12, 14, 16, 18, 20, 24)}
_UNIFORM = 0.05
_EXAMPLE = {"time": "ms", "force": "N"}


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnSummary:
    """One column of the file, in the file's own unit."""

    number: int
    name: str
    unit: str
    minimum: float | None
    maximum: float | None
    n_missing: int
    is_numeric: bool
    is_integer: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Inspection:
    """How a recording file looks, and the import profile that would read it."""

    file: str
    format: str
    encoding: str = ""
    separator: str = ""
    decimal: str = ""
    header_row: int = 0
    units_row: int = 0
    data_row: int = 0
    columns: tuple[ColumnSummary, ...] = ()
    n_rows: int = 0
    n_rows_about: int = 0
    samples: tuple[str, ...] = ()
    sampling_rate_Hz: float | None = None
    is_uniform: bool = False
    saturation: tuple[str, ...] = ()
    first_rows: tuple[tuple[str, ...], ...] = ()
    profile: ImportProfile = field(default_factory=ImportProfile)
    notes: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        r"""Return the inspection for JSON, the profile as its TOML text."""
        result = {name: getattr(self, name) for name in self.__slots__ if name not in ("profile", "columns")}
        for name in ("samples", "saturation", "first_rows", "notes", "doubts"):
            result[name] = list(result[name])
        result["first_rows"] = [list(row) for row in self.first_rows]
        result["columns"] = [asdict(column) for column in self.columns]
        result["profile_toml"] = profile_to_toml(self.profile)
        return {"schema": "ropefric.inspection/1", **result}


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
        reader = find_reader(source.path, known, shown_as=shown, source=source)
        if reader.name not in TEXT_FORMATS:
            found = Inspection(file=shown, format=reader.name, profile=replace(known, format=reader.name))
            return _summarise(found, reader.tables(source, known))
        sizes = accumulate(map(len, source.unpacked())) if source.is_packed else (source.file.size,)
        is_small = everything or all(size <= WHOLE_BYTES for size in sizes)
        return _inspect_text(source, known) if is_small else _inspect_ends(source, known)

    return use_file(path, look, shown=shown)


def _inspect_ends(source: Source, profile: ImportProfile) -> Inspection:
    """Return what the beginning and the end of a large text tell."""
    size = PART_BYTES
    found = _inspect_text(replace(source, most_bytes=size), profile)
    while not found.n_rows and size < WHOLE_BYTES:  # pragma: no cover - a head of megabytes
        size *= 2
        found = _inspect_text(replace(source, most_bytes=size), profile)
    n_about = found.n_rows if source.is_packed else round(found.n_rows * source.file.size / size)
    parts = "first megabyte was" if source.is_packed else "first and last megabytes were"
    doubts = [f"only the {parts} read: numbers of rows and ranges are at least these; --all reads everything"]
    if not source.is_packed and found.encoding in _TAIL_ENCODINGS:
        try:
            found = _inspect_text(replace(source, most_bytes=size), profile, _end_of(found, source))
        except DataError as error:
            doubts.append(f"near the end of the file: {error.problem.message}")
    return replace(found, n_rows_about=n_about, doubts=(*found.doubts, *doubts))


def _end_of(found: Inspection, source: Source) -> list[FloatArray | None]:
    """Return the columns of the last lines."""
    known = replace(found.profile, format="delimited", channels={}, decimal=found.decimal)
    known = replace(known, header_row=0, units_row=0, block_names_row=0, data_row=2)  # the first line is cut
    (table, *_) = find_reader(source.path, known).tables(replace(source, most_bytes=-PART_BYTES), known)
    if len(table.names) != len(found.columns):
        raise source.error(f"there are {len(table.names)} columns, not {len(found.columns)}")
    return _load(table)[0]


def _inspect_text(
    source: Source, profile: ImportProfile, end: Sequence[FloatArray | None] = ()
) -> Inspection:
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
    profile = _find_blocks(text, dialect, profile) or replace(profile, **dialect.rows._asdict())
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
    lines = islice(text.lines_from(dialect.rows.data_row), N_FIRST_ROWS)
    found = Inspection(
        file=source.shown,
        format=reader.name,
        encoding=text.encoding,
        separator=dialect.separator,
        decimal=dialect.decimal,
        header_row=profile.header_row,
        units_row=profile.units_row,
        data_row=profile.data_row,
        first_rows=tuple(tuple(split_line(line, dialect.separator)) for _, line in lines),
        profile=replace(
            profile,
            format=reader.name,
            separator=dialect.separator,
            decimal="" if decimal_is_open else dialect.decimal,
            encoding="" if text.encoding in {"utf-8", "utf-8-sig"} else text.encoding,
        ),
        doubts=tuple(doubts),
    )
    return _summarise(found, tables, end)


def _find_blocks(text: Text, dialect: Dialect, profile: ImportProfile) -> ImportProfile | None:
    """Return the profile with the block layout that the head shows, or None for an ordinary table.

    Two layouts are known: a row that names each recording above its first column; and a header that names
    the columns of the first recording and leaves the rest blank.
    """
    n, names_row, width = dialect.n_cells, 0, 0
    if profile.block_columns or n < 4 or sum(map(bool, dialect.header)) == n:  # every column has a name
        return None
    head = {}
    for line in range(1, dialect.rows.data_row):
        cells = split_line(text.line(line), dialect.separator)
        filled = [i for i, cell in enumerate(cells[:n]) if cell]
        if len(filled) > 0:
            head[line] = (cells, filled)
    for line, (_, filled) in head.items():
        step = filled[1] - filled[0] if len(filled) > 1 else 0
        if step > 1 and n % step == 0 and filled == list(range(0, n, step)):
            names_row, width = line, step
            break
    else:
        widths = (len(filled) for _, filled in head.values() if filled[-1] == len(filled) - 1)
        width = next((w for w in widths if w > 1 and n % w == 0 and n // w > 1), 0)
    if not width:
        return None
    rows = [line for line, (_, filled) in head.items() if line != names_row and filled[-1] < width]
    units = [line for line in rows if all(is_unit(cell) for cell in head[line][0] if cell)]
    return replace(
        profile,
        block_columns=width,
        block_names_row=names_row,
        header_row=max(set(rows).difference(units), default=0),
        units_row=max(units, default=0),
        data_row=dialect.rows.data_row,
    )


def _summarise(
    found: Inspection, tables: Sequence[Table], end: Sequence[FloatArray | None] = ()
) -> Inspection:
    """Return an inspection completed by what the columns of the first recording hold, and by those of its end."""
    table = tables[0]
    values, wrong_stamps = _load(table)
    pairs = zip(values, end, strict=True) if end else ((array, np.empty(0)) for array in values)
    whole = [None if a is None or b is None else np.append(a, b) for a, b in pairs]
    columns = tuple(_column(table, index, array) for index, array in enumerate(whole))
    channels, doubts = _channels(found, table, values)
    rate_Hz, is_uniform, clock_doubts = _clock(table, values, channels)
    hints = [hint for column, array in zip(columns, whole, strict=True) for hint in _at_limits(column, array)]
    return replace(
        found,
        columns=columns,
        n_rows=max((array.size for array in whole if array is not None), default=0),
        samples=tuple(table.sample for table in tables if table.sample),
        sampling_rate_Hz=rate_Hz,
        is_uniform=is_uniform,
        saturation=tuple(hints),
        notes=tuple(dict.fromkeys(table.notes)),
        profile=replace(found.profile, channels=channels),
        doubts=(*found.doubts, *wrong_stamps, *doubts, *clock_doubts),
    )


def _load(table: Table) -> tuple[list[FloatArray | None], list[str]]:
    """Return every column, None where it holds something else than numbers, and why time stamps cannot be read."""
    doubts: list[str] = []

    def load(indices: Sequence[int]) -> list[FloatArray | None]:
        try:
            return [*table.values(indices)]
        except DataError as error:
            if len(indices) > 1:
                return [array for index in indices for array in load([index])]
            doubts.extend([str(error)] if indices[0] in table.stamps else [])
            return [None]

    return load(range(len(table.names))), doubts


def _column(table: Table, index: int, array: FloatArray | None) -> ColumnSummary:
    present = array[~np.isnan(array)] if array is not None else np.empty(0)
    return ColumnSummary(
        number=index + 1,
        name=table.names[index].strip(),
        unit=table.unit(index),
        minimum=float(present.min()) if present.size else None,
        maximum=float(present.max()) if present.size else None,
        n_missing=0 if array is None else int(array.size - present.size),
        is_numeric=array is not None,
        is_integer=bool(present.size and (present == np.floor(present)).all()),
    )


def _channels(
    found: Inspection, table: Table, values: Sequence[FloatArray | None]
) -> tuple[dict[str, Channel], list[str]]:
    """Return the channels as far as names or values tell them, and what is left to the user."""
    names = [name.strip() for name in table.names]

    def by_name(number: int) -> Channel:
        """Return a guessed channel by its header, which survives a new column, where the header is unique."""
        name = names[number - 1]
        return Channel(column=name if name and names.count(name) == 1 else number)

    channels: dict[str, Channel] = dict(found.profile.channels)
    doubts = []
    if not channels:
        named = guess_channels(table, needs_time=False)
        channels = {name: by_name(int(channel.column)) for name, channel in named.items()}
    has_time = "time" in channels or found.profile.sampling_rate_Hz is not None or table.clock is not None
    units = [table.unit(index) for index in range(len(names))]
    numeric = [(i, array) for i, array in enumerate(values) if array is not None]
    # What never falls may be a time.
    rising = [
        i
        for i, array in numeric
        if array.size > 2 and (np.diff(array) >= 0).all() and array[-1] > array[0]
        if not has_time and _is_of("time", units[i] or "s")
    ]
    if rising:
        is_stamp = rising[0] in table.stamps
        time = by_name(rising[0] + 1) if is_stamp else Channel(column=rising[0] + 1, unit=units[rising[0]])
        channels = {"time": time, **channels}
        why = "holds time stamps" if is_stamp else "only rises"
        doubts.append(f"column {rising[0] + 1} is taken as the time because it {why}; check")
    elif not has_time:
        doubts.append('no column looks like the time; set [import] sampling_rate, for example "3 kHz"')
    if not {"force", "counts"} & (channels.keys() | found.profile.derived.keys()):
        newtons = [i for i, _ in numeric if units[i] and _is_of("force", units[i])]
        if len(newtons) == 1:
            (only,) = newtons
            channels["force"] = by_name(only + 1)
            doubts.append(
                f"column {only + 1} is taken as the force because it alone is in {units[only]}; check"
            )
        else:
            doubts.append("which column is the force (or the ADC counts)? Name it in [import.channels]")
    doubts += [
        f"column {number} looks like a measured end tension: none is used, that of the trial list is"
        for number, name in enumerate(names, start=1)
        if "_".join(split_unit_suffix(name)[0].lower().split()) == "end_tension"
    ]
    for name in sorted(_EXAMPLE.keys() & channels.keys(), reverse=True):
        unit = _unit(table, channels[name])
        if not unit:
            doubts.append(
                f'the unit of the {name} is not told; add it, for example unit = "{_EXAMPLE[name]}"'
            )
        elif signal_unit(name, unit):
            doubts.append(
                f'the {name} is in {unit}; add what it means, sensitivity = "25 N/mV", or name a cell in the list'
            )
        elif not _is_of(name, unit):
            doubts.append(f"the {name} is in {unit}, which is no unit of it; derive it in [import.derived]")
    return channels, doubts


def _index(table: Table, channel: Channel) -> int | None:
    if isinstance(channel.column, int):
        return channel.column - 1 if 1 <= channel.column <= len(table.names) else None
    names = [name.strip() for name in table.names]
    return names.index(channel.column.strip()) if names.count(channel.column.strip()) == 1 else None


def _unit(table: Table, channel: Channel) -> str:
    index = _index(table, channel)
    return channel.unit or ("" if index is None else table.unit(index))


def _is_of(channel: str, unit: str) -> bool:
    try:
        return bool(si_scale(channel, unit)[0])
    except DataError:
        return False


def _clock(
    table: Table, values: Sequence[FloatArray | None], channels: Mapping[str, Channel]
) -> tuple[float | None, bool, tuple[str, ...]]:
    """Return sampling rate, whether the steps are even, and what is wrong with the clock."""
    try:
        time_s = _clock_s(table, channels)
        if "time" in channels:
            index, unit = _index(table, channels["time"]), _unit(table, channels["time"])
            array = values[index] if index is not None else None
            time_s = array * si_scale("time", unit)[0] if array is not None and unit else None
        if time_s is None or time_s.size < 2:
            return None, False, ()
        others = [array for array in values if array is not None and array.size == time_s.size]
        _, mended_s, notes = mend_clock(time_s, others, name="the time", first_line=table.first_line)
    except DataError as error:
        return None, False, (str(error),)
    steps_s = np.diff(mended_s)
    if not steps_s.size:
        return None, False, notes
    # The mean step sees through rounded stamps, but a gap would spoil it.
    step_s = float(steps_s[steps_s <= GAP_STEPS * np.median(steps_s)].mean())
    is_uniform = bool((np.abs(steps_s - step_s) <= _UNIFORM * step_s).all())
    return float(f"{1.0 / step_s:.6g}"), is_uniform, notes


def _clock_s(table: Table, channels: Mapping[str, Channel]) -> FloatArray | None:
    """Return the time that the channels, or else the first column that has one, bring with them."""
    if table.clock is None:
        return None
    chosen = [index for channel in channels.values() if (index := _index(table, channel)) is not None]
    clocks = (table.clock(index) for index in (*chosen, *range(len(table.names))))
    return next((time_s for time_s in clocks if time_s is not None), None)


def _at_limits(column: ColumnSummary, array: FloatArray | None) -> list[str]:
    """Return a hint where whole numbers stay at a converter's full scale or at zero."""
    if array is None or not column.is_integer or column.minimum is None or column.minimum < 0:
        return []
    label, top = column.name or f"column {column.number}", int(column.maximum or 0)
    if top not in _FULL_SCALES:
        return []
    limits = {top: f"the ceiling of {_FULL_SCALES[top]} bits", 0: "the floor"}
    runs = {limit: int(np.diff(runs_of(array == limit)).max(initial=0)) for limit in limits}
    return [
        f"{label} sits at {limit}, {what}, for {runs[limit]} samples in a row"
        for limit, what in limits.items()
        if runs[limit] >= MIN_RUN
    ]
