"""CSV exports of National Instruments' loggers: every row begins with its label, every channel brings its own time."""

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


def _recognises(lines: Sequence[str]) -> bool:
    labels = _labels(lines)
    return _NAMES in labels and _UNITS in labels and "Interval" in labels


def _tables(source: Source, profile: ImportProfile) -> tuple[Table, ...]:
    labels = _labels(first_lines(source))
    if not {_NAMES, _UNITS} <= labels.keys():
        why, fix = (
            "no row begins with 'Channel name'",
            'name its format, such as [import] format = "delimited"',
        )
        raise source.error(why, code="RF103", fix=fix)
    (row, names), (units_row, units) = labels[_NAMES], labels[_UNITS]
    data_row = 1 + max(row for row, _ in labels.values())
    layout = replace(profile, header_row=row, units_row=units_row, data_row=data_row)
    text, dialect = open_text(source, layout)
    header = [cell for name in names for cell in (f"time of {name}", name)]
    dialect = replace(
        dialect,
        header=tuple(header),
        units=tuple(cell for unit in units for cell in ("s", unit)),
    )
    dialect.notes.append(f"NI export: {', '.join(names)}, each with a time of its own")
    others = [(label, said) for label, (_, said) in labels.items() if label not in (_NAMES, _UNITS)]
    dialect.notes.extend(f"{label}: {', '.join(dict.fromkeys(said))}" for label, said in others)
    table = text_table(text, dialect)
    return (replace(table, clock=lambda index: table.values([index - 1])[0] if index % 2 else None),)


READER = Reader(
    name="ni-csv",
    suffixes=(),
    description="CSV of NI loggers: rows that begin with Timestamp, Interval, Channel name, Unit",
    tables=_tables,
    recognises=_recognises,
)
