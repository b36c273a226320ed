"""What a reader is: it opens a file as tables, and the tables' columns become recordings."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import PurePath

from ropefric.traces.readers.columns import pick_columns
from ropefric.traces.readers.profile import ImportProfile, RawRecording
from ropefric.traces.readers.source import Source
from ropefric.traces.readers.table import Table


@dataclass(frozen=True, slots=True, kw_only=True)
class Reader:
    """A file format."""

    name: str
    suffixes: tuple[str, ...]
    description: str
    tables: Callable[[Source, ImportProfile], Sequence[Table]]

    def read(self, source: Source, profile: ImportProfile) -> tuple[RawRecording, ...]:
        """Return the file's recordings, columns as they are in the file; raises `DataError` RF101 to RF108."""
        return tuple(_recording(table, profile, source) for table in self.tables(source, profile))


def _recording(table: Table, profile: ImportProfile, source: Source) -> RawRecording:
    picks = pick_columns(table, profile, source)
    arrays = table.values([pick.index for pick in picks.values()])
    columns = dict(zip(picks, arrays, strict=True))
    units = {channel: pick.unit for channel, pick in picks.items()}
    if table.time_s is not None and "time" not in columns and profile.sampling_rate_Hz is None:
        columns["time"], units["time"] = table.time_s, "s"
    name = PurePath(source.shown).name
    return RawRecording(
        name=f"{name}#{table.sample}" if table.sample else name,
        source=source.shown,
        sample=table.sample,
        columns=columns,
        units=units,
        first_line=table.first_line,
    )
