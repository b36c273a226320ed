"""Texts that declare their layout: CSV of National Instruments' loggers, traces of Mitsubishi's MR Configurator.

NI begins every row of the head with its label, and every channel brings its own time. In one recording of Mitsubishi
the measured quantity of each slot is in the place of its unit.
"""

from collections.abc import Sequence
from dataclasses import replace

from ropefric.files.text import Source, first_lines, split_line
from ropefric.traces.readers.delimited import open_text, text_table
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.table import Reader, Table

_NAMES, _UNITS = "Channel name", "Unit"


def _labels(lines: Sequence[str]) -> dict[str, tuple[int, list[str]]]:
    """Return line number and values of every labelled row of the head: label, value, label, value."""
    found: dict[str, tuple[int, list[str]]] = {}
    for number, line in enumerate(lines, start=1):
        separator = next((mark for mark in ";\t," if mark in line), ",")
        cells = split_line(line, separator)
        if len(cells) > 1 and cells[0] and set(cells[::2]) == {cells[0]} and not cells[0][0].isdigit():
            found[cells[0]] = (number, cells[1::2])
    return found


def _is_ni(lines: Sequence[str]) -> bool:
    labels = _labels(lines)
    return _NAMES in labels and _UNITS in labels and "Interval" in labels


def _ni_tables(source: Source, profile: ImportProfile) -> tuple[Table, ...]:
    labels = _labels(first_lines(source))
    if not {_NAMES, _UNITS} <= labels.keys():
        fix = 'name its format, such as [import] format = "delimited"'
        raise source.error("no row begins with 'Channel name'", code="RF103", fix=fix)
    (row, names), (units_row, units) = labels[_NAMES], labels[_UNITS]
    data_row = 1 + max(row for row, _ in labels.values())
    layout = replace(profile, header_row=row, units_row=units_row, data_row=data_row)
    text, dialect = open_text(source, layout)
    header = [cell for name in names for cell in (f"time of {name}", name)]
    dialect = replace(
        dialect, header=tuple(header), units=tuple(cell for unit in units for cell in ("s", unit))
    )
    dialect.notes.append(f"NI export: {', '.join(names)}, each with a time of its own")
    others = [(label, said) for label, (_, said) in labels.items() if label not in (_NAMES, _UNITS)]
    dialect.notes.extend(f"{label}: {', '.join(dict.fromkeys(said))}" for label, said in others)
    table = text_table(text, dialect)
    return (replace(table, clock=lambda index: table.values([index - 1])[0] if index % 2 else None),)


NI = Reader(
    name="ni-csv",
    suffixes=(),
    description="CSV of NI loggers: rows that begin with Timestamp, Interval, Channel name, Unit",
    tables=_ni_tables,
    recognises=_is_ni,
)


_COUNT, _INTERVAL, _UNUSED = "Number of sampling data", "Sampling time interval", "Not selected"


def _is_mitsubishi(lines: Sequence[str]) -> bool:
    return len(lines) > 5 and lines[1].startswith(_COUNT) and lines[2].startswith(_INTERVAL)


def _mitsubishi_tables(source: Source, profile: ImportProfile) -> tuple[Table, ...]:
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
        f"Mitsubishi MR Configurator, {title}: {stated}; it has no unit but that of the time"
    )
    return (table,)


MITSUBISHI = Reader(
    name="mr-configurator",
    suffixes=(),
    description="servo traces of Mitsubishi MR Configurator (CSV)",
    tables=_mitsubishi_tables,
    recognises=_is_mitsubishi,
)
