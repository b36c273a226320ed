"""Which column of a table is which channel, and in which unit."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ropefric.errors import DataError
from ropefric.quantities import split_unit_suffix
from ropefric.registry import did_you_mean
from ropefric.traces.readers.profile import Channel, ImportProfile
from ropefric.traces.readers.source import Source
from ropefric.traces.readers.table import Table

SAFE_NAMES: dict[str, tuple[str, ...]] = {
    "time": ("time", "t"),
    "force": ("force", "load", "f"),
    "counts": ("counts", "adc"),
}
"""Bare headers that can mean nothing else, lower case; all other columns must be named by the profile."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Pick:
    """The column a channel is read from."""

    index: int
    unit: str


def bare_unit(text: str) -> str:
    """Return a unit without the brackets people put around it."""
    text = text.strip()
    if len(text) > 1 and text[0] + text[-1] in ("[]", "()", "{}", "<>"):
        return text[1:-1].strip()
    return text


def guess_channels(names: Sequence[str], *, needs_time: bool = True) -> dict[str, Channel]:
    """Return the channels whose headers can mean nothing else, or an empty dict where that is not enough."""
    found: dict[str, list[int]] = {channel: [] for channel in SAFE_NAMES}
    for number, name in enumerate(names, start=1):
        bare = split_unit_suffix(name.strip())[0].lower()
        for channel, meanings in SAFE_NAMES.items():
            if bare in meanings:
                found[channel].append(number)
    n_time, n_signal = len(found["time"]), len(found["force"]) + len(found["counts"])
    if n_signal != 1 or n_time > 1 or (needs_time and n_time == 0):
        return {}
    return {channel: Channel(column=numbers[0]) for channel, numbers in found.items() if numbers}


def pick_columns(table: Table, profile: ImportProfile, source: Source) -> dict[str, Pick]:
    """Return the column and unit of every channel the profile names, or of those that are plain by name.

    The unit is the profile's, else the file's own, else the suffix of the header.
    """
    channels: Mapping[str, Channel] = profile.channels
    if not channels:
        needs_time = profile.sampling_rate_Hz is None and table.time_s is None
        channels = guess_channels(table.names, needs_time=needs_time)
        if not channels:
            raise source.error(
                f"cannot tell which column is what; {_listed(table)}",
                code="RF105",
                key="[import.channels]",
                fix="name the columns, for example time = { column = 1, unit = "
                f'"s" }} and force = {{ column = 2, unit = "N" }}; `ropefric inspect {source.shown}` '
                "suggests them",
            )
    picks = {}
    for name, channel in channels.items():
        index = _index(name, channel, table, source)
        suffix = split_unit_suffix(table.names[index])[1] if table.names[index] else ""
        unit = "" if name == "counts" else channel.unit or bare_unit(table.units[index]) or suffix
        picks[name] = Pick(index=index, unit=unit)
    return picks


def _index(name: str, channel: Channel, table: Table, source: Source) -> int:
    key = f"[import.channels] {name}"
    wanted, n = channel.column, len(table.names)
    if isinstance(wanted, int):
        if not 1 <= wanted <= n:
            raise source.error(
                f"column {wanted} was asked for; {_listed(table)}",
                code="RF105",
                key=key,
                fix=f"give a column number from 1 to {n}",
            )
        return wanted - 1
    if not table.has_header:
        raise source.error(
            f"column {wanted!r} was asked for by name, but the columns have no names; {_listed(table)}",
            code="RF105",
            key=key,
            fix=f"give its number, for example {name} = {{ column = 1 }}, or set header_row",
        )
    return _index_by_name(wanted, table, source, key)


def _index_by_name(wanted: str, table: Table, source: Source, key: str) -> int:
    names = [header.strip() for header in table.names]
    for candidates in (names, [split_unit_suffix(header)[0] for header in names]):
        hits = [index for index, header in enumerate(candidates) if header == wanted.strip()]
        if len(hits) > 1:
            numbers = ", ".join(str(hit + 1) for hit in hits)
            raise source.error(
                f"several columns are called {wanted!r}: numbers {numbers}",
                code="RF105",
                key=key,
                fix=f"give the number of the one you mean, for example {{ column = {hits[0] + 1} }}",
            )
        if hits:
            return hits[0]
    raise _missing(wanted, names, table, source, key)


def _missing(wanted: str, names: list[str], table: Table, source: Source, key: str) -> DataError:
    return source.error(
        f"there is no column {wanted!r}; {_listed(table)}",
        code="RF105",
        key=key,
        fix=did_you_mean(wanted, [header for header in names if header]),
    )


def _listed(table: Table) -> str:
    shown = [name.strip() or f"(column {i})" for i, name in enumerate(table.names[:30], start=1)]
    more = ", ..." if len(table.names) > len(shown) else ""
    if not table.has_header:
        return f"the file has {len(table.names)} columns without names"
    return f"the file has the columns {', '.join(shown)}{more}"
