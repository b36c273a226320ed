"""National Instruments TDMS; needs the extra `lab`."""

import io
import logging
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.files.text import Source
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.table import Reader, Table, array_table, check_choice, foreign, needs_package

_UNIT_KEYS = ("unit_string", "NI_UnitDescription", "Unit", "unit")


def _tables(source: Source, profile: ImportProfile) -> tuple[Table, ...]:
    """Return the table of one group: the profile's, else the first that has channels with data."""
    groups = {group.name: group.channels() for group in _load(source).groups()}
    check_choice(profile.table, groups, "group", source)
    filled = [name for name, channels in groups.items() if any(len(channel) for channel in channels)]
    if not filled:
        raise source.error("no group has data", fix="record it again")
    group = profile.table or filled[0]
    channels = groups[group]
    columns, units = {}, {}
    for channel in channels:
        what, fix = "the channel cannot be scaled", "save the scaled values"
        with foreign(source, what, fix, code="RF102", key=channel.name):
            columns[channel.name] = np.asarray(channel[:])
        found = (channel.properties.get(key) for key in _UNIT_KEYS)
        units[channel.name] = next((str(unit) for unit in found if unit), "")
    clocks = [_waveform_time(channel) for channel in channels]
    has_clock = any(clock is not None for clock in clocks)
    notes = [f"the group {group!r}, one of {len(groups)}"] if len(groups) > 1 else []
    notes += ["the time is that of the waveforms"] if has_clock else []
    clock = clocks.__getitem__ if has_clock else None
    return (array_table(columns, source, units=units, clock=clock, notes=notes),)


def _load(source: Source) -> Any:
    try:
        from nptdms import TdmsFile  # noqa: PLC0415  (an extra that is not always there)
    except ImportError:
        raise needs_package("TDMS needs the package nptdms", source) from None
    logging.getLogger("nptdms").setLevel(logging.CRITICAL)  # it writes damaged bytes to the terminal
    fix = "copy it again, or name its format in [import] format"
    with foreign(source, "this is not a readable TDMS file", fix):
        return TdmsFile.read(io.BytesIO(source.raw_bytes()))


def _waveform_time(channel: Any) -> FloatArray | None:
    """Return a waveform's own time from its first sample on.

    Relative on purpose: absolute starts carry time zones that writers and readers disagree about.
    """
    step_s, offset_s = (channel.properties.get(f"wf_{key}", 0.0) for key in ("increment", "start_offset"))
    if not isinstance(step_s, float) or not isinstance(offset_s, float) or not 0 < step_s < np.inf:
        return None
    return np.asarray(offset_s + step_s * np.arange(len(channel)), dtype=np.float64)


READER = Reader(
    name="tdms",
    suffixes=(".tdms",),
    description="National Instruments TDMS (extra lab)",
    tables=_tables,
)
