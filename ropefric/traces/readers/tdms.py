"""National Instruments TDMS; needs the extra `lab`."""

import io
import logging
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.files.text import Source
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.table import (
    Reader,
    Table,
    array_table,
    check_choice,
    foreign,
    package,
    recordings_among,
    seconds_from_first,
)

_UNIT_KEYS = ("unit_string", "NI_UnitDescription", "Unit", "unit")


def _tables(source: Source, profile: ImportProfile) -> tuple[Table, ...]:
    """Return the table of the group that the profile names, else of every group that has the channels of the largest."""
    groups = {group.name: group.channels() for group in _load(source).groups()}
    check_choice(profile.table, groups, "group", source)
    filled = {name: channels for name, channels in groups.items() if any(map(len, channels))}
    if not filled:
        raise source.error("no group has data", fix="record it again")
    chosen = {profile.table: groups[profile.table]} if profile.table else filled
    sizes = {name: max(map(len, channels)) for name, channels in chosen.items()}
    return recordings_among(
        {name: _table(it, source) for name, it in chosen.items()}, sizes, profile, "groups"
    )


def _table(channels: Any, source: Source) -> Table:
    columns, units = {}, {}
    for channel in channels:
        what, fix = "the channel cannot be scaled", "save the scaled values"
        with foreign(source, what, fix, code="RF102", key=channel.name):
            columns[channel.name] = np.asarray(channel[:])
        found = (channel.properties.get(key) for key in _UNIT_KEYS)
        units[channel.name] = next((str(unit) for unit in found if unit), "")
    clocks = _waveform_times(channels)
    has_clock = any(clock is not None for clock in clocks)
    notes = ["the time is that of the waveforms"] if has_clock else []
    clock = clocks.__getitem__ if has_clock else None
    return array_table(columns, source, units=units, clock=clock, notes=notes)


def _load(source: Source) -> Any:
    nptdms = package("nptdms", "TDMS", source)
    logging.getLogger("nptdms").setLevel(logging.CRITICAL)  # it writes damaged bytes to the terminal
    fix = "copy it again, or name its format in [import] format"
    with foreign(source, "this is not a readable TDMS file", fix):
        return nptdms.TdmsFile.read(io.BytesIO(source.raw_bytes()))


def _waveform_times(channels: Any) -> list[FloatArray | None]:
    """Return the times of waveforms from the earliest start of them on, None for channels that are none.

    Relative on purpose: absolute starts carry time zones that writers and readers disagree about, within a file alike.
    """
    clocks: list[FloatArray | None] = []
    starts_s = seconds_from_first([channel.properties.get("wf_start_time") for channel in channels])
    for channel, start_s in zip(channels, starts_s, strict=True):
        step_s, offset_s = (channel.properties.get(f"wf_{key}", 0.0) for key in ("increment", "start_offset"))
        is_clock = isinstance(step_s, float) and isinstance(offset_s, float) and 0 < step_s < np.inf
        clocks.append(start_s + offset_s + step_s * np.arange(len(channel)) if is_clock else None)
    return clocks


READER = Reader(
    name="tdms", suffixes=(".tdms",), description="National Instruments TDMS (extra lab)", tables=_tables
)
