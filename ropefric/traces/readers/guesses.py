"""The layout of an unknown file: arrangement of its recordings, column of the time, column of the force."""

import re
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ropefric.arrays import BoolArray, FloatArray
from ropefric.files.text import Text, split_line
from ropefric.files.text_table import Dialect, is_number, is_unit, is_value
from ropefric.quantities import split_unit_suffix
from ropefric.traces.readers.delimited import MOST_FOOTER, begins_with_word
from ropefric.traces.readers.profile import Channel, ImportProfile
from ropefric.traces.readers.several import blocks_of_header, stacked_parts
from ropefric.traces.readers.table import Table, guess_channels, is_time
from ropefric.traces.signals import is_of, signal_unit

_PULLS = ("force", "kraft", "load", "zug", "pull", "tension", "f_a", "fa")
_SLACKS = ("slack", "end_tension", "gegen", "halte", "lose", "endkraft", "f_b", "fb")
"""Parts of names that show on which side of the wheel a force was measured, the slack one first."""
_MOST_LABELS, _FEWEST_ROWS = 64, 10
"""A column that labels rows has at most this many words, and each occurs in at least this many rows."""
_SEEN_BYTES = 8 * 2**20
"""Several recordings are looked for in this much of a text."""
_LONGEST_S = 4 * 3600.0
_DAYS = (3e4, 1e6)
"""Days of our time, as spreadsheets count them from 1900 on, others from the year 0."""
_EVEN = 0.1
"""How far the steps of a time of any name may be from their median [-]."""
_SET_VALUES = re.compile(r"(?:^|[\s_./])(?:set|goal|target|soll|nominal|preload|vorlast|command|cmd|limit)")
"""Words of values that a machine is set to, beside those that it measures."""

_WEIGHTS = {"lb": "lbf", "kg": "kgf", "g": "gf"}
"""Units of mass that gauges write for the weight of it."""

Values = Sequence[FloatArray | None]


# --- how recordings stand in a text ---


def layouts(
    text: Text, dialect: Dialect, profile: ImportProfile
) -> Iterator[tuple[ImportProfile, list[str]]]:
    """Yield the profiles that a text may be read by, and what each assumes.

    First those of several recordings that it shows, then one of a table, with other rows as its header, or none.
    """
    plain = replace(profile, **dialect.rows._asdict())
    if profile.format == "auto" and not profile.block_columns:
        if wide := _side_by_side(text, dialect, profile):
            yield wide, []
            return
        seen = text.part(0, text.data.rfind(b"\n", 0, _SEEN_BYTES) + 1)
        if dialect.rows.header_row and len(stacked_parts(seen, dialect)) > 1:
            yield replace(plain, format="stacked"), []
            return
        if long := _in_rows(seen, dialect, plain):
            yield long
    if not plain.skip_footer and (n_footer := _footer_lines(text, dialect)):
        yield replace(plain, skip_footer=n_footer), []
    yield plain, []
    for header_row, units_row in _other_headers(text, dialect) if profile.header_row < 0 else ():
        yield replace(plain, header_row=header_row, units_row=units_row), []
    if dialect.rows.header_row:
        yield replace(plain, header_row=0, units_row=0), []


def _other_headers(text: Text, dialect: Dialect) -> Iterator[tuple[int, int]]:
    """Yield the rows right above the header that are as wide as the data, and the row of units below each, or 0."""
    below = split_line(text.line(dialect.rows.header_row), dialect.separator)
    for line in range(dialect.rows.header_row - 1, 0, -1):
        cells = split_line(text.line(line), dialect.separator)
        if len(cells) != dialect.n_cells or not any(cells):
            return
        yield line, line + 1 if any(map(is_unit, filter(None, below))) else 0
        below = cells


def _side_by_side(text: Text, dialect: Dialect, profile: ImportProfile) -> ImportProfile | None:
    """Return the profile of recordings side by side, or None for an ordinary table.

    Three layouts are known: names that come again but for a number; a row that names each recording above its first
    column; and a header that names the columns of the first recording and leaves the rest blank.
    """
    n, rows, header = dialect.n_cells, dialect.rows, dialect.header[: dialect.n_cells]
    lines = {line: split_line(text.line(line), dialect.separator)[:n] for line in range(1, rows.data_row)}
    head = {line: cells for line, cells in lines.items() if any(cells)}
    names_rows = {line: step for line, cells in head.items() if (step := _steps(cells, n))}
    if width := _width_by_names(header, n):
        above = (line for line, step in names_rows.items() if step == width and line < rows.header_row)
        return replace(profile, block_columns=width, block_names_row=next(above, 0), **rows._asdict())
    if n < 4 or (len(header) == n and all(header)):
        return None
    names_row, width = next(iter(names_rows.items()), (0, _width_written_once(head.values(), n)))
    head.pop(names_row, None)
    at: dict[str, Any] = {"block_names_row": names_row, "data_row": rows.data_row}
    return replace(profile, block_columns=width, **at, **_head_of_first(head, width)) if width else None


def _head_of_first(head: Mapping[int, Sequence[str]], width: int) -> dict[str, Any]:
    """Return the rows of names and units that stand above the first recording only."""
    narrow = {line for line, cells in head.items() if not any(cells[width:])}
    units = {line for line in narrow if all(is_unit(cell) for cell in head[line] if cell)}
    return {"header_row": max(narrow - units, default=0), "units_row": max(units, default=0)}


def _width_by_names(header: Sequence[str], n: int) -> int:
    """Return how many columns a recording has by names that come again, 0 where none do: two cells are no recordings."""
    blocks = blocks_of_header(header) if len(header) == n else []
    width = n // len(blocks) if blocks else 0
    is_same = width and list(header) == list(header[:width]) * len(blocks)
    return width if blocks and (is_same or any(map(is_time, blocks[0].names))) else 0


def _width_written_once(head: Iterable[Sequence[str]], n: int) -> int:
    """Return how many cells the first row of names has that stand at the beginning, and divide all columns."""
    filled = ((sum(map(bool, cells)), cells) for cells in head)
    return next((k for k, cells in filled if 1 < k < n and n % k == 0 and all(cells[:k])), 0)


def _steps(cells: Sequence[str], n: int) -> int:
    """Return the distance of filled cells that stand at even distances over all columns, 0 where they do not."""
    filled = [place for place, cell in enumerate(cells) if cell]
    step = filled[1] - filled[0] if len(filled) > 1 else 0
    return step if step > 1 and n % step == 0 and filled == list(range(0, n, step)) else 0


def _in_rows(text: Text, dialect: Dialect, plain: ImportProfile) -> tuple[ImportProfile, list[str]] | None:
    """Return the profile of a table whose rows belong to recordings, or channels, that a column names.

    Channels need the unit of the time, which is assumed where the file does not state it.
    """
    columns = _whole_columns(text, dialect)
    time, clock = _clock_of(dialect, columns)
    if time < 0:
        return None
    labels = {i: np.array(cells) for i, cells in enumerate(columns) if _are_labels(cells)}
    back = np.diff(clock) < 0
    found: dict[str, Any] = {}
    doubts: list[str] = []
    channel, value = _channel_and_value(columns, labels, time, clock)
    if channel >= 0:
        found = {f"{key}_column": _named(dialect, at) for key, at in (("channel", channel), ("value", value))}
        back &= _stays(labels.pop(channel))  # back to the begin of another channel is no other recording
        if not plain.channels and not _states_unit(dialect, time):
            unit = _assumed_unit(np.unique(clock), doubts)
            found["channels"] = {"time": Channel(column=_named(dialect, time), unit=unit)}
    recordings = [i for i, of in labels.items() if not (back & _stays(of)).any()] if back.any() else []
    if recordings:
        found["recording_column"] = _named(dialect, recordings[0])
    return (replace(plain, format="long", **found), doubts) if found else None


def _states_unit(dialect: Dialect, index: int) -> bool:
    return any(dialect.units[index : index + 1]) or bool(split_unit_suffix(dialect.header[index])[1])


def _named(dialect: Dialect, index: int) -> str | int:
    """Return the name of a column, or its number where others are called so."""
    name = dialect.header[index]
    return name if dialect.header.count(name) == 1 else index + 1


def _whole_columns(text: Text, dialect: Dialect) -> list[tuple[str, ...]]:
    """Return the cells of all columns, of the rows that are as wide as the first one."""
    rows = text.rows_from(dialect.rows.data_row, dialect.separator)
    return [*zip(*(row for _, row in rows if len(row) == dialect.n_cells), strict=True)]


def _channel_and_value(
    columns: Sequence[Sequence[str]], labels: Mapping[int, NDArray[np.str_]], time: int, clock: FloatArray
) -> tuple[int, int]:
    """Return the column that names channels and the only one that holds their values; -1 where there are no such."""
    values = [i for i in range(len(columns)) if i not in {time, *labels} and all(map(is_value, columns[i]))]
    channels = [i for i, of in labels.items() if _names_channels(of, clock)]
    return (channels[0], values[0]) if channels and len(values) == 1 else (-1, -1)


def _clock_of(dialect: Dialect, columns: Sequence[Sequence[str]]) -> tuple[int, FloatArray]:
    """Return the first column that is called a time and its numbers; -1 where there is none."""
    time = next((i for i, name in enumerate(dialect.header[: len(columns)]) if is_time(name)), -1)
    if time < 0 or not all(is_number(cell, dialect.decimal) for cell in columns[time]):
        return -1, np.empty(0)
    return time, np.array([float(cell.replace(",", ".")) for cell in columns[time]])


def _stays(of: NDArray[np.str_]) -> BoolArray:
    return np.asarray(of[1:] == of[:-1])


def _are_labels(cells: Sequence[str]) -> bool:
    """Return whether a few words, or whole numbers, fill a column, each of them many rows."""
    n = len(set(cells))
    return 1 < n <= min(_MOST_LABELS, len(cells) / _FEWEST_ROWS) and all(cells)


def _names_channels(of: NDArray[np.str_], clock: FloatArray) -> bool:
    """Return whether labels name channels: words that alternate, or name a side, over times that rise in each."""
    words = [str(word) for word in np.unique(of)]
    if any(map(is_value, words)):
        return False
    n_back = sum(int((np.diff(clock[of == word]) < 0).sum()) for word in words)
    alternate = not _stays(of).mean() > 0.5 or any(map(_side, words))
    return alternate and n_back <= len(words)


def _footer_lines(text: Text, dialect: Dialect) -> int:
    """Return how many of the last lines begin with a word, unlike the first row of data, and from there on all."""
    rows = deque(text.rows_from(dialect.rows.data_row, dialect.separator), MOST_FOOTER + 1)
    data = [place for place, (_, row) in enumerate(rows) if not begins_with_word(row, dialect)]
    return len(rows) - 1 - data[-1] if data else 0


# --- what the columns of a table mean ---


class Guess(NamedTuple):
    """The channels of a table as far as names, units and values show them, its rate from its head, what was assumed."""

    channels: dict[str, Channel]
    rate_Hz: float | None
    doubts: list[str]


def guess_meaning(table: Table, values: Values, known: ImportProfile) -> Guess:
    """Return what the columns of a table mean, what the profile says first."""
    channels, rate_Hz, doubts = dict(known.channels), known.sampling_rate_Hz, list[str]()
    if not channels:
        named = guess_channels(table, needs_time=False, by_unit=False)
        channels = {name: _by_name(table, int(one.column) - 1) for name, one in named.items()}
    if "time" not in channels and rate_Hz is None and table.clock is None:
        channels, rate_Hz = _with_time(table, values, channels, doubts)
    channels |= _forces(table, values, known, channels, doubts)
    for name in ("time", "force", "end_tension"):
        if name in channels:
            channels[name] = _with_unit(name, table, values, channels[name], doubts)
    return Guess(channels, rate_Hz, doubts)


def index_of(table: Table, channel: Channel) -> int | None:
    """Return the column of a channel, None where there is not exactly one."""
    hits = table.hits(channel.column)
    return hits[0] if len(hits) == 1 else None


def unit_of(table: Table, channel: Channel) -> str:
    """Return the unit of a channel: its own, else the file's."""
    index = index_of(table, channel)
    return channel.unit or ("" if index is None else "s" if index in table.stamps else table.unit(index))


def _by_name(table: Table, index: int) -> Channel:
    """Return a guessed channel by its header, which survives a new column, where the header is unique."""
    names = [name.strip() for name in table.names]
    return Channel(column=names[index] if names[index] and names.count(names[index]) == 1 else index + 1)


def _with_time(
    table: Table, values: Values, channels: dict[str, Channel], doubts: list[str]
) -> tuple[dict[str, Channel], float | None]:
    ranked = sorted(
        (rank, index)
        for index, array in enumerate(values)
        if array is not None and (rank := _rank_of_time(table, index, array)) is not None
    )
    if ranked:
        rank, index = ranked[0]
        doubts.append(f"column {index + 1} is taken as the time because it {_REASONS[rank]}")
        return {"time": _by_name(table, index), **channels}, None
    if table.facts.rate_Hz:
        doubts.append(f"the sampling rate, {table.facts.rate_Hz:g} Hz, is that of the head of the file")
        return channels, table.facts.rate_Hz
    rate = 'set [import] sampling_rate, for example "3 kHz"'
    counter = next((i + 1 for i, array in enumerate(values) if array is not None and _counts(array)), 0)
    named = f'time = {{ column = {counter}, unit = "ms" }}'
    of_counter = f"column {counter} counts the rows: {rate}; or, if it is a time, {named}"
    doubts.append(of_counter if counter else f"no column looks like the time; {rate}")
    return channels, None


_REASONS = (
    "holds time stamps",
    "is called so, and in a unit of time",
    "is in a unit of time",
    "holds time stamps, though some stand again",
    "is called so",
    "only rises",
)


def _rank_of_time(table: Table, index: int, array: FloatArray) -> int | None:
    """Return how surely a column is the time, 0 most; None for one that falls, or counts its rows."""
    present = array[~np.isnan(array)]
    if present.size < 3 or (np.diff(present) < 0).any() or present[-1] <= present[0]:
        return None
    if index in table.stamps:
        return 0 if (np.diff(present) > 0).all() else 3
    unit, is_named = table.unit(index), is_time(table.names[index])
    if unit and not is_of("time", unit):
        return None
    if unit:
        return 1 if is_named else 2
    if is_named:
        return 4
    # Where the head states the rate, what rises may be a path.
    return 5 if not table.facts.rate_Hz and _may_be_time(present, table.names[index].strip()) else None


def _may_be_time(rising: FloatArray, name: str) -> bool:
    """Return whether a rising column may be the time: it counts no rows, and rises evenly where it has another name."""
    steps = np.diff(rising)
    is_even = (np.abs(steps - np.median(steps)) <= _EVEN * np.median(steps)).all()
    return not _counts(rising) and bool(is_even or not name)


def _counts(values: FloatArray) -> bool:
    """Return whether a column counts its rows, as a record number, or a time in the unit of its step."""
    return bool(values.size > 1 and (np.diff(values) == 1.0).all())


def _side(name: str) -> str:
    """Return "slack" or "pull" for a name that contains a side of the wheel, "" for any other."""
    stem = "_".join(split_unit_suffix(name.strip())[0].lower().split())
    for side, words in (("slack", _SLACKS), ("pull", _PULLS)):
        if any(stem == word or (len(word) > 2 and word in stem) for word in words):
            return side
    return ""


def _forces(
    table: Table, values: Values, known: ImportProfile, channels: dict[str, Channel], doubts: list[str]
) -> dict[str, Channel]:
    """Return the channels force and end tension, where they are not known and one column each may be it."""
    free = _free_columns(table, values, channels)
    units = {i: unit for i in free if is_of("force", unit := _unit_of_force(table, i))}
    found: dict[str, Channel] = {}
    if not {"force", "counts"} & (channels.keys() | known.derived.keys()):
        force, why = _force_column(table, values, free, units)
        if force < 0:
            shown = ", ".join(table.names[i].strip() or f"column {i + 1}" for i in (units or free))
            doubts.append(f"which column is the force ({shown})? Name it in [import.channels]")
            return found
        found["force"] = _by_name(table, force)
        doubts.append(f"column {force + 1} is taken as the force because it {why}")
        units.pop(force, None)
    if "end_tension" not in channels and known.channels.keys() <= {"time"}:
        found |= _end_tension(table, units, doubts)
    return found


def _free_columns(table: Table, values: Values, channels: Mapping[str, Channel]) -> list[int]:
    """Return the columns of numbers that no channel has, those that change, and do not count rows, if any do.

    A gauge writes its peak and its limits beside every reading, a machine the force that it is set to.
    """
    taken = {index_of(table, channel) for channel in channels.values()}
    columns = {i: array for i, array in enumerate(values) if array is not None and i not in taken}
    lively = [
        i for i, some in columns.items() if np.nanmax(some, initial=-np.inf) > np.nanmin(some, initial=np.inf)
    ]
    measured = [
        i for i in lively if not (_SET_VALUES.search(table.names[i].strip().lower()) or _counts(columns[i]))
    ]
    return measured or lively or [*columns]


def _unit_of_force(table: Table, index: int) -> str:
    """Return the unit of a column, or that of the head of the file; of a mass, that of its weight."""
    unit = table.unit(index) or table.facts.unit
    return _WEIGHTS.get(unit, unit)


def _end_tension(table: Table, units: Iterable[int], doubts: list[str]) -> dict[str, Channel]:
    """Return the end tension where the name of just one of some columns shows it."""
    slack = [i for i in units if _side(table.names[i]) == "slack"]
    if len(slack) != 1:
        return {}
    doubts.append(
        f"column {slack[0] + 1} looks like a measured end tension and is taken as it; "
        "leave it out to use that of the trial list"
    )
    return {"end_tension": _by_name(table, slack[0])}


def _force_column(
    table: Table, values: Values, free: Sequence[int], units: Mapping[int, str]
) -> tuple[int, str]:
    """Return the column that is the force by the first rule that leaves one, and why; -1 where none does.

    Columns in newtons go before those in volts, and these before columns without a unit.
    """
    kind, some = _likeliest(table, free, units)
    called = [i for i in some if _side(table.names[i]) == "pull"]
    if len(some) == 1 and (kind or len(free) == 1):
        return some[0], f"alone is {f'in {units[some[0]]}' if kind else 'left'}"
    if len(called) == 1:
        return called[0], "is called so"
    if kind and _are_one(values, some, units):
        return some[0], "is the first of those that differ by their zero"
    return -1, ""


def _likeliest(table: Table, free: Sequence[int], units: Mapping[int, str]) -> tuple[str, list[int]]:
    """Return the likeliest kind of unit of a force that free columns have, and those columns."""
    kinds = {i: signal_unit("force", unit) or "N" for i, unit in units.items()}
    kinds |= {i: "" for i in free if i not in units and not table.unit(i)}
    found = ((kind, [i for i in free if kinds.get(i) == kind]) for kind in ("N", "V", "V/V", ""))
    return next((one for one in found if one[1]), ("", []))


def _are_one(values: Values, columns: Sequence[int], units: Mapping[int, str]) -> bool:
    """Return whether columns are one signal but for its zero."""
    arrays = [array for i in columns if (array := values[i]) is not None and array.size > 1]
    apart = [float(np.ptp(array - arrays[0])) for array in arrays[1:] if array.size == arrays[0].size]
    is_one = 0 < len(apart) == len(columns) - 1 and len({units[i] for i in columns}) == 1
    return is_one and max(apart) <= 1e-6 * float(np.ptp(arrays[0]))


def _with_unit(name: str, table: Table, values: Values, channel: Channel, doubts: list[str]) -> Channel:
    """Return a channel with its unit, a likely one where the file has none, and say what to add."""
    unit = unit_of(table, channel)
    if name == "time":
        index = index_of(table, channel)
        array = None if index is None else values[index]
        if not unit and array is not None and np.isfinite(array).sum() > 2:
            return replace(channel, unit=_assumed_unit(array[np.isfinite(array)], doubts))
    else:
        of_head = table.facts.unit
        if not unit and is_of(name, _WEIGHTS.get(of_head, of_head)):
            doubts.append(f"the unit of the {name}, {of_head}, is that of the head of the file")
            unit, channel = of_head, replace(channel, unit=of_head)
        if unit in _WEIGHTS:
            doubts.append(f"the {name} is in {unit}, a mass; its weight, in {_WEIGHTS[unit]}, is taken")
            return replace(channel, unit=_WEIGHTS[unit])
    doubts += _doubts_of(name, unit, channel)
    return replace(channel, unit=unit) if signal_unit(name, unit) and not channel.sensitivity else channel


def _doubts_of(name: str, unit: str, channel: Channel) -> Iterator[str]:
    """Yield a doubt where a unit is missing, is that of a signal, or is of another quantity."""
    if not unit:
        yield f'the unit of the {name} is not stated; add it, for example unit = "N"'
    elif signal_unit(name, unit) and not channel.sensitivity:
        how = f'add sensitivity = "25 N/{unit}" to its channel, or name a force cell in the list of trials'
        if "/" in unit:
            how = 'name a force cell with rated_output = "2 mV/V" in the list of trials'
        yield f"the {name} is in {unit}; {how}"
    elif not is_of(name, unit):
        yield f"the {name} is in {unit}, which is no unit of it; derive it in [import.derived]"


def _assumed_unit(present: FloatArray, doubts: list[str]) -> str:
    """Return the unit that makes a recording of a time: loggers write whole milliseconds, parts of seconds or days."""
    span, step = float(present[-1] - present[0]), float(np.median(np.diff(present)))
    units = {"s": 1.0, "ms": 1e-3, "us": 1e-6}
    if (present == np.floor(present)).all():
        units.pop("s")
    elif _DAYS[0] < present[0] < _DAYS[1]:
        units = {"d": 86400.0, **units}
    fitting = (
        name for name, second_s in units.items() if span * second_s <= _LONGEST_S and step * second_s < 2.0
    )
    unit = next(fitting, "ms")
    rate_Hz = 1.0 / (step * units[unit]) if step else 0.0
    why = f"as that makes {rate_Hz:.4g} Hz over {span * units[unit]:.4g} s"
    doubts.append(f"the file does not state the unit of the time; {unit} is taken, {why}")
    return unit
