"""Traces of Mitsubishi's MR Configurator: one recording; what each slot measured stands where units usually do."""

from collections.abc import Sequence
from dataclasses import replace

from ropefric.files.text import Source, split_line
from ropefric.traces.readers.delimited import open_text, text_table
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.table import Reader, Table

_COUNT, _INTERVAL, _UNUSED = "Number of sampling data", "Sampling time interval", "Not selected"


def _recognises(lines: Sequence[str]) -> bool:
    return len(lines) > 5 and lines[1].startswith(_COUNT) and lines[2].startswith(_INTERVAL)


def _tables(source: Source, profile: ImportProfile) -> tuple[Table, ...]:
    text, dialect = open_text(source, replace(profile, header_row=4, units_row=5, data_row=6))
    slots, measured = dialect.header, dialect.units
    names = [slots[0]]
    for slot, what in zip(slots[1:], measured[1:], strict=False):
        names.append(
            slot if what in ("", _UNUSED) else what if measured.count(what) == 1 else f"{what} ({slot})"
        )
    dialect = replace(dialect, header=tuple(names), units=measured[:1])
    table = text_table(text, dialect)
    title, *facts = (text.line(number) for number in (1, 2, 3))
    stated = ", ".join(" ".join(split_line(fact, dialect.separator)) for fact in facts)
    dialect.notes.append(
        f"Mitsubishi MR Configurator, {title}: {stated}; of units it tells only that of the time"
    )
    return (table,)


READER = Reader(
    name="mr-configurator",
    suffixes=(),
    description="servo traces of Mitsubishi MR Configurator (CSV)",
    tables=_tables,
    recognises=_recognises,
)
