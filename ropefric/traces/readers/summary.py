"""What the columns of a file look like: ranges, clock, converter limits, likely channels."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import DataError
from ropefric.quantities import split_unit_suffix
from ropefric.traces.assemble import si_factor
from ropefric.traces.clock import GAP_STEPS, mend_clock
from ropefric.traces.readers.columns import bare_unit, guess_channels
from ropefric.traces.readers.inspection import ColumnSummary, Inspection
from ropefric.traces.readers.profile import Channel
from ropefric.traces.readers.table import Table

MIN_RUN = 3
"""Samples in a row at a converter's limit that make a hint."""

_FULL_SCALES = {2**bits - 1: bits for bits in (8, 10, 12, 14, 16, 18, 20, 24)}
_UNIFORM = 0.05


def summarise(found: Inspection, tables: Sequence[Table]) -> Inspection:
    """Return an inspection completed by what the columns of the first recording hold."""
    table = tables[0]
    values = _load(table)
    columns = tuple(_column(table, index, array) for index, array in enumerate(values))
    sizes = [array.size for array in values if array is not None]
    channels, doubts = _channels(found, table, values)
    rate_Hz, is_uniform, clock_doubts = _clock(table, values, channels)
    saturation = [
        hint for column, array in zip(columns, values, strict=True) for hint in _saturation(column, array)
    ]
    return replace(
        found,
        columns=columns,
        n_rows=max(sizes, default=0),
        samples=tuple(table.sample for table in tables if table.sample),
        sampling_rate_Hz=rate_Hz,
        is_uniform=is_uniform,
        saturation=tuple(saturation),
        profile=replace(found.profile, channels=channels),
        doubts=(*found.doubts, *doubts, *clock_doubts),
    )


def widen(one: ColumnSummary, other: ColumnSummary) -> ColumnSummary:
    """Return a column's summary together with that of another part of it."""
    low = [limit for limit in (one.minimum, other.minimum) if limit is not None]
    high = [limit for limit in (one.maximum, other.maximum) if limit is not None]
    is_numeric = one.is_numeric and other.is_numeric
    return replace(
        one,
        minimum=min(low) if low and is_numeric else None,
        maximum=max(high) if high and is_numeric else None,
        n_missing=one.n_missing + other.n_missing,
        is_numeric=is_numeric,
        is_integer=one.is_integer and other.is_integer,
    )


def _load(table: Table) -> list[FloatArray | None]:
    """Return every column, None where it holds something else than numbers."""
    indices = range(len(table.names))
    try:
        return list(table.values(indices))
    except DataError:
        return [_load_one(table, index) for index in indices]


def _load_one(table: Table, index: int) -> FloatArray | None:
    try:
        return table.values([index])[0]
    except DataError:
        return None


def _unit(table: Table, index: int) -> str:
    return bare_unit(table.units[index]) or split_unit_suffix(table.names[index])[1]


def _column(table: Table, index: int, array: FloatArray | None) -> ColumnSummary:
    present = array[~np.isnan(array)] if array is not None else np.empty(0)
    return ColumnSummary(
        number=index + 1,
        name=table.names[index].strip(),
        unit=_unit(table, index),
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
    channels: dict[str, Channel] = dict(found.profile.channels)
    doubts = []
    if not channels:
        named = guess_channels(table.names, needs_time=False)
        channels = {name: _by_name(table, channel) for name, channel in named.items()}
    has_time = "time" in channels or found.profile.sampling_rate_Hz is not None or table.time_s is not None
    rising = [i for i, array in enumerate(values) if array is not None and _rises(array, _unit(table, i))]
    if not has_time and rising:
        channels = {"time": Channel(column=rising[0] + 1, unit=_unit(table, rising[0])), **channels}
        doubts.append(f"column {rising[0] + 1} is taken as the time because it only rises; check")
    elif not has_time:
        doubts.append('no column looks like the time; set [import] sampling_rate, for example "3 kHz"')
    if not {"force", "counts"} & (channels.keys() | found.profile.derived.keys()):
        newtons = [i for i, array in enumerate(values) if array is not None and _is_force(_unit(table, i))]
        if len(newtons) == 1:
            (only,) = newtons
            by_number = Channel(column=only + 1)
            channels["force"] = _by_name(table, by_number) if table.names[only].strip() else by_number
            unit = _unit(table, only)
            doubts.append(f"column {only + 1} is taken as the force because it alone is in {unit}; check")
        else:
            doubts.append("which column is the force (or the ADC counts)? Name it in [import.channels]")
    doubts += [
        f"column {number} looks like a measured end tension: none is used, that of the trial list is"
        for number, name in enumerate(table.names, start=1)
        if "_".join(split_unit_suffix(name.strip())[0].lower().split()) == "end_tension"
    ]
    for name, channel in channels.items():
        if name in {"time", "force"} and not channel.unit and not _named_unit(table, channel):
            doubts.append(
                f'the unit of the {name} is not told; add it, for example unit = "{_EXAMPLE[name]}"'
            )
    return channels, doubts


_EXAMPLE = {"time": "ms", "force": "N"}


def _is_force(unit: str) -> bool:
    """Return whether a unit is one of force."""
    try:
        return bool(unit and si_factor("force", unit))
    except DataError:
        return False


def _by_name(table: Table, channel: Channel) -> Channel:
    """Return a guessed channel by its header, which survives a new column, where the header is unique."""
    name = table.names[int(channel.column) - 1].strip()
    return Channel(column=name) if [n.strip() for n in table.names].count(name) == 1 else channel


def _index(table: Table, channel: Channel) -> int | None:
    if isinstance(channel.column, int):
        return channel.column - 1 if 1 <= channel.column <= len(table.names) else None
    names = [name.strip() for name in table.names]
    return names.index(channel.column.strip()) if names.count(channel.column.strip()) == 1 else None


def _named_unit(table: Table, channel: Channel) -> str:
    index = _index(table, channel)
    return _unit(table, index) if index is not None else ""


def _rises(array: FloatArray, unit: str) -> bool:
    """Tell whether a column may be a time: it never falls, and its unit does not speak against it."""
    try:
        si_factor("time", unit or "s")
    except DataError:
        return False
    return bool(array.size > 2 and (np.diff(array) >= 0).all() and array[-1] > array[0])


def _clock(
    table: Table, values: Sequence[FloatArray | None], channels: dict[str, Channel]
) -> tuple[float | None, bool, list[str]]:
    """Return sampling rate, whether the steps are even, and what is wrong with the clock."""
    time_s = table.time_s
    if "time" in channels:
        index = _index(table, channels["time"])
        array = values[index] if index is not None else None
        unit = channels["time"].unit or _named_unit(table, channels["time"])
        if array is None or not unit:
            return None, False, []
        try:
            time_s = array * si_factor("time", unit)
        except DataError as error:
            return None, False, [str(error)]
    if time_s is None or time_s.size < 2:
        return None, False, []
    others = [array for array in values if array is not None and array.size == time_s.size]
    try:
        _, mended_s, notes = mend_clock(time_s, others, name="the time", first_line=table.first_line)
    except DataError as error:
        return None, False, [str(error)]
    steps_s = np.diff(mended_s)
    if not steps_s.size:
        return None, False, list(notes)
    # The mean step sees through rounded stamps, but a gap would spoil it.
    step_s = float(steps_s[steps_s <= GAP_STEPS * np.median(steps_s)].mean())
    is_uniform = bool((np.abs(steps_s - step_s) <= _UNIFORM * step_s).all())
    return float(f"{1.0 / step_s:.6g}"), is_uniform, list(notes)


def _saturation(column: ColumnSummary, array: FloatArray | None) -> list[str]:
    """Return a hint where whole numbers stay at a converter's full scale or at zero."""
    if array is None or not column.is_integer or column.minimum is None or column.minimum < 0:
        return []
    label = column.name or f"column {column.number}"
    hints = []
    top = int(column.maximum or 0)
    run = _longest_run(array == top)
    if top in _FULL_SCALES and run >= MIN_RUN:
        hints.append(
            f"{label} sits at {top}, the ceiling of {_FULL_SCALES[top]} bits, for {run} samples in a row"
        )
    run = _longest_run(array == 0)
    if top in _FULL_SCALES and run >= MIN_RUN:
        hints.append(f"{label} sits at 0, the floor, for {run} samples in a row")
    return hints


def _longest_run(flags: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> int:
    edges = np.flatnonzero(np.diff(np.concatenate(([False], flags, [False])).astype(np.int8)))
    return int((edges[1::2] - edges[::2]).max(initial=0))
