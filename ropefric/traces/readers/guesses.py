"""What an unknown file may mean: how its recordings stand, which column is the time and which the force."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import DataError
from ropefric.files.text import Text, split_line
from ropefric.files.text_table import Dialect, HeadRows, is_unit, is_value
from ropefric.quantities import split_unit_suffix
from ropefric.traces.readers.profile import Channel, ImportProfile
from ropefric.traces.readers.several import blocks_of_header, stacked_parts
from ropefric.traces.readers.table import Table, guess_channels, is_time
from ropefric.traces.signals import si_scale, signal_unit

_PULLS = ("force", "kraft", "load", "last", "zug", "pull", "tension", "f_a", "fa")
_SLACKS = ("slack", "end_tension", "gegen", "halte", "lose", "endkraft", "f_b", "fb")
"""Parts of names that tell which side of the wheel a force was measured on, the slack one first."""
_MOST_LABELS, _FEWEST_ROWS = 64, 10
"""A column that says what a row belongs to has at most so many words, and each stands in at least so many rows."""
_MOST_FOOTER = 20
_LONGEST_S = 4 * 3600.0

Values = Sequence[FloatArray | None]


def is_of(channel: str, unit: str) -> bool:
    """Return whether a unit is one of a channel's."""
    try:
        return bool(si_scale(channel, unit)[0])
    except DataError:
        return False


# --- how recordings stand in a text ---


def layouts(text: Text, dialect: Dialect, profile: ImportProfile) -> Iterator[ImportProfile]:
    """Yield the profiles that a text may be read by: those of several recordings that it shows, then one of a table."""
    plain = replace(profile, **dialect.rows._asdict())
    if profile.format == "auto" and not profile.block_columns:
        if wide := _side_by_side(text, dialect, profile):
            yield wide
            return
        if text.is_whole and dialect.rows.header_row and len(stacked_parts(text, dialect)) > 1:
            yield replace(plain, format="stacked")
            return
        if text.is_whole and (long := _in_rows(text, dialect, plain)):
            yield long
    if not plain.skip_footer and (n_footer := _footer_lines(text, dialect)):
        yield replace(plain, skip_footer=n_footer)
    yield plain
    if dialect.rows.header_row:
        yield replace(plain, header_row=0, units_row=0)


def _side_by_side(text: Text, dialect: Dialect, profile: ImportProfile) -> ImportProfile | None:
    """Return the profile of recordings side by side, or None for an ordinary table.

    Three layouts are known: names that come again but for a number; a row that names each recording above its first
    column; and a header that names the columns of the first recording and leaves the rest blank.
    """
    n, rows = dialect.n_cells, dialect.rows
    head = {line: split_line(text.line(line), dialect.separator)[:n] for line in range(1, rows.data_row)}
    head = {line: cells for line, cells in head.items() if any(cells)}
    blocks = blocks_of_header(dialect.header[:n]) if len(dialect.header[:n]) == n else []
    if blocks and (any(map(is_time, blocks[0].names)) or _are_same(dialect.header[:n], n // len(blocks))):
        width = n // len(blocks)
        names_row = next(
            (line for line in head if _steps(head[line], n) == width and line < rows.header_row), 0
        )
        return replace(profile, block_columns=width, block_names_row=names_row, **rows._asdict())
    if n < 4 or (len(dialect.header) >= n and all(dialect.header[:n])):
        return None
    names_row, width = next(
        ((line, step) for line, cells in head.items() if (step := _steps(cells, n))), (0, 0)
    )
    if not width:
        written_once = [sum(map(bool, c)) for c in head.values() if any(c) and all(c[: sum(map(bool, c))])]
        width = next((w for w in written_once if 1 < w < n and n % w == 0), 0)
    if not width:
        return None
    narrow = [line for line in head if line != names_row and not any(head[line][width:])]
    units = [line for line in narrow if all(is_unit(cell) for cell in head[line] if cell)]
    header_row = max(set(narrow).difference(units), default=0)
    found = HeadRows(header_row, max(units, default=0), rows.data_row)
    return replace(profile, block_columns=width, block_names_row=names_row, **found._asdict())


def _are_same(header: Sequence[str], width: int) -> bool:
    return list(header) == list(header[:width]) * (len(header) // width)


def _steps(cells: Sequence[str], n: int) -> int:
    """Return the distance of filled cells that stand at even distances over all columns, 0 where they do not."""
    filled = [place for place, cell in enumerate(cells) if cell]
    step = filled[1] - filled[0] if len(filled) > 1 else 0
    return step if step > 1 and n % step == 0 and filled == list(range(0, n, step)) else 0


def _in_rows(text: Text, dialect: Dialect, plain: ImportProfile) -> ImportProfile | None:
    """Return the profile of a table whose rows belong to recordings, or channels, that a column names."""
    rows = [row for _, row in text.rows_from(dialect.rows.data_row, dialect.separator)]
    rows = [row for row in rows if len(row) == dialect.n_cells]
    columns = [*zip(*rows, strict=True)] if len(rows) >= 2 * _FEWEST_ROWS else []
    labels = {i: cells for i, cells in enumerate(columns) if 1 < len(set(cells)) <= len(rows) / _FEWEST_ROWS}
    labels = {i: cells for i, cells in labels.items() if len(set(cells)) <= _MOST_LABELS and all(cells)}
    time = next((i for i, name in enumerate(dialect.header) if is_time(name) and i < len(columns)), -1)
    if time < 0 or not labels or not all(map(is_value, columns[time])):
        return None
    try:
        clock = np.array([float(cell.replace(",", ".")) for cell in columns[time]])
    except ValueError:
        return None
    back = np.diff(clock) < 0
    changes = {i: np.array([a != b for a, b in pairwise(cells)]) for i, cells in labels.items()}
    named = {i: dialect.header[i] if dialect.header.count(dialect.header[i]) == 1 else i + 1 for i in labels}
    words = [i for i, cells in labels.items() if not any(map(is_value, cells))]
    others = [
        i for i in range(len(columns)) if i != time and i not in labels and all(map(is_value, columns[i]))
    ]
    found: dict[str, str | int] = {}
    for i in words:  # of channels the times come again, or their rows alternate
        alternate = changes[i].mean() > 0.5 or any(_side(word) for word in set(labels[i]))
        if len(others) == 1 and alternate and _rises_in_each(clock, labels[i], back & ~changes[i]):
            found = {"channel_column": named[i], "value_column": dialect.header[others[0]] or others[0] + 1}
            back = back & ~changes[i]
            del labels[i]
            break
    for i in labels:
        if back.any() and not (back & ~changes[i]).any():
            found["recording_column"] = named[i]
            break
    return replace(plain, format="long", **found) if found else None  # type: ignore[arg-type]


def _rises_in_each(clock: FloatArray, labels: Sequence[str], back: BoolArray) -> bool:
    of = np.array(labels)
    return not back.any() or all((np.diff(clock[of == label]) >= 0).mean() > 0.9 for label in set(labels))


def _footer_lines(text: Text, dialect: Dialect) -> int:
    """Return how many of the last lines hold words where the first row of data holds numbers."""
    if not text.is_whole:
        return 0
    numeric = [is_value(cell) for cell in dialect.first_row]
    rows = [row for _, row in text.rows_from(dialect.rows.data_row, dialect.separator)][-_MOST_FOOTER - 1 :]
    fits = [
        len(row) == len(numeric)
        and all(is_value(c) or not n or not c for c, n in zip(row, numeric, strict=True))
        for row in rows
    ]
    return fits[::-1].index(True) if True in fits and not fits[-1] else 0


# --- what the columns of a table mean ---


class Guess(NamedTuple):
    """The channels of a table as far as names, units and values tell them, its rate from its head, what was assumed."""

    channels: dict[str, Channel]
    rate_Hz: float | None
    doubts: list[str]


def guess_meaning(table: Table, values: Values, known: ImportProfile) -> Guess:
    """Return what the columns of a table mean, what the profile says first."""
    channels, rate_Hz, doubts = dict(known.channels), known.sampling_rate_Hz, list[str]()
    if not channels:
        named = guess_channels(table, needs_time=False)
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
    if isinstance(channel.column, int):
        return channel.column - 1 if 1 <= channel.column <= len(table.names) else None
    names = [name.strip() for name in table.names]
    return names.index(channel.column.strip()) if names.count(channel.column.strip()) == 1 else None


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
        doubts.append(f"column {index + 1} is taken as the time because it {_REASONS[rank]}; check")
        return {"time": _by_name(table, index), **channels}, None
    if table.facts.rate_Hz:
        doubts.append(
            f"the sampling rate, {table.facts.rate_Hz:g} Hz, is what the head of the file says; check"
        )
        return channels, table.facts.rate_Hz
    doubts.append('no column looks like the time; set [import] sampling_rate, for example "3 kHz"')
    return channels, None


_REASONS = (
    "holds time stamps",
    "is called so, and in a unit of time",
    "is in a unit of time",
    "is called so",
    "only rises",
)


def _rank_of_time(table: Table, index: int, array: FloatArray) -> int | None:
    """Return how surely a column is the time, 0 most; None for one that falls, or counts its rows."""
    present = array[~np.isnan(array)]
    if present.size < 3 or (np.diff(present) < 0).any() or present[-1] <= present[0]:
        return None
    if index in table.stamps:
        return 0
    unit, is_named = table.unit(index), is_time(table.names[index])
    if unit and not is_of("time", unit):
        return None
    if unit:
        return 1 if is_named else 2
    steps = np.diff(present)
    is_counter = (present == np.floor(present)).all() and steps.min() == steps.max()
    return 3 if is_named else None if is_counter else 4


def _side(name: str) -> str:
    """Return "slack" or "pull" for a name that tells a side of the wheel, "" for any other."""
    stem = "_".join(split_unit_suffix(name.strip())[0].lower().split())
    short, long = (
        [word for word in words if (len(word) < 4) is is_short]
        for words, is_short in ((_SLACKS, True), (_SLACKS, False))
    )
    if any(word in stem for word in long) or stem in short:
        return "slack"
    return (
        "pull"
        if any(word in stem if len(word) > 3 or word == "zug" else stem == word for word in _PULLS)
        else ""
    )


def _forces(
    table: Table, values: Values, known: ImportProfile, channels: dict[str, Channel], doubts: list[str]
) -> dict[str, Channel]:
    """Return the channels force and end tension, where they are not known and one column each may be it."""
    taken = {index_of(table, channel) for channel in channels.values()}
    free = [i for i, array in enumerate(values) if array is not None and i not in taken]
    units = {i: table.unit(i) or table.facts.unit for i in free}
    in_newtons = [i for i in free if units[i] and is_of("force", units[i])]
    signals = [i for i in in_newtons if signal_unit("force", units[i])]
    in_newtons = [i for i in in_newtons if i not in signals]
    found: dict[str, Channel] = {}
    has_force = bool({"force", "counts"} & (channels.keys() | known.derived.keys()))
    if not has_force:
        pulls = [i for i in free if _side(table.names[i]) == "pull"]
        some = in_newtons or [i for i in signals if i in pulls] or signals
        some = some if len(some) == 1 else [i for i in some if i in pulls] or some
        some = (
            some
            or [i for i in pulls if not table.unit(i)]
            or [i for i in free if len(free) == 1 and not units[i]]
        )
        some = some[:1] if len({units[i] for i in some}) == 1 and _are_one(values, some) else some
        if len(some) != 1:
            doubts.append("which column is the force (or the ADC counts)? Name it in [import.channels]")
            return found
        (force,) = some
        found["force"] = _by_name(table, force)
        alone = f"alone is in {units[force]}" if units[force] else "alone is left"
        alone = (
            "is called so"
            if len(in_newtons or signals) > 1 or (pulls == some and not units[force])
            else alone
        )
        doubts.append(f"column {force + 1} is taken as the force because it {alone}; check")
    chosen = {index_of(table, channel) for channel in found.values()}
    slack = [i for i in (*in_newtons, *signals) if i not in chosen and _side(table.names[i]) == "slack"]
    if len(slack) == 1 and "end_tension" not in channels and not known.channels:
        found["end_tension"] = _by_name(table, slack[0])
        doubts.append(
            f"column {slack[0] + 1} looks like a measured end tension and is taken as it; "
            "leave it out to use that of the trial list"
        )
    return found


def _are_one(values: Values, columns: Sequence[int]) -> bool:
    """Return whether columns are one signal but for its zero."""
    arrays = [array for i in columns if (array := values[i]) is not None and array.size > 1]
    spans = [float(np.nanmax(array - arrays[0]) - np.nanmin(array - arrays[0])) for array in arrays[1:]]
    return bool(spans) and max(spans) <= 1e-6 * float(np.nanmax(arrays[0]) - np.nanmin(arrays[0]))


def _with_unit(name: str, table: Table, values: Values, channel: Channel, doubts: list[str]) -> Channel:
    """Return a channel with its unit, a likely one where the file tells none, and say what is to be added."""
    unit, index = unit_of(table, channel), index_of(table, channel)
    array = None if index is None else values[index]
    if not unit and name == "time" and array is not None and np.isfinite(array).sum() > 2:
        unit, why = _likely_unit(array[np.isfinite(array)])
        doubts.append(f"the unit of the time is not told; {unit} is taken, {why}; check")
        return replace(channel, unit=unit)
    if not unit and name != "time" and is_of(name, table.facts.unit or "?"):
        doubts.append(f"the unit of the {name}, {table.facts.unit}, is what the head of the file says; check")
        return replace(channel, unit=table.facts.unit)
    if not unit:
        doubts.append(f'the unit of the {name} is not told; add it, for example unit = "N"')
    elif signal_unit(name, unit) and not channel.sensitivity:
        how = f'sensitivity = "25 N/{unit}"' if "/" not in unit else 'rated_output = "2 mV/V" of its cell'
        doubts.append(f"the {name} is in {unit}; add what it means, {how}, or name a cell in the list")
        return replace(channel, unit=unit)
    elif not is_of(name, unit):
        doubts.append(f"the {name} is in {unit}, which is no unit of it; derive it in [import.derived]")
    return channel


def _likely_unit(present: FloatArray) -> tuple[str, str]:
    """Return the unit that makes a recording of a time, and why: loggers write whole milliseconds, parts of seconds."""
    span, step = float(present[-1] - present[0]), float(np.median(np.diff(present)))
    units = {"s": 1.0, "ms": 1e-3, "us": 1e-6}
    if (present == np.floor(present)).all():
        units.pop("s")
    fitting = (
        name for name, second_s in units.items() if span * second_s <= _LONGEST_S and step * second_s < 2.0
    )
    unit = next(fitting, "ms")
    rate_Hz = 1.0 / (step * units[unit]) if step else 0.0
    return unit, f"as that makes {rate_Hz:.4g} Hz over {span * units[unit]:.4g} s"
