"""How a table in a text file is laid out: separator, decimal mark, header, units and first data row.

The user's settings hold; others are found in the first 64 kB, or refused where two readings are possible.
"""

import math
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import date
from itertools import islice, repeat
from typing import NamedTuple

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import DataError, InputError
from ropefric.files.head_facts import NO_FACTS, Facts, facts_of, is_fact
from ropefric.files.text import Source, Text, split_line
from ropefric.quantities import SUFFIX_UNITS, spelled_unit

NAN_TEXTS = ("nan", "NaN", "NAN", "Nan", "-nan", "-NaN")
"""Cell texts that mean "no value" in every file, beside the empty cell."""

THOUSANDS = (",", ".", "'", " ", "\u2019", "\u00a0", "\u202f")
"""Marks that may stand between thousands; a blank stands for those that do not break a line, too."""

SEPARATORS = ("\t", ";", "|", ",", " ")
"""By preference: TAB before blanks, and "," only where nothing stronger divides the numbers."""

_NUMBER = {
    mark: re.compile(
        rf"[+-]?(?:\d++(?:{re.escape(mark)}\d*+)?|{re.escape(mark)}\d++)(?:[eE][+-]?\d++)?", re.ASCII
    )
    for mark in ".,"
}
_GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}(?:,\d{3})+", re.ASCII)
_POINTED = re.compile(r"[+-]?[1-9]\d{0,2}(?:,\d{3})+\.\d*", re.ASCII)
_GROUPED_BY_POINTS = re.compile(r"[+-]?[1-9]\d{0,2}(?:\.\d{3})+,\d*", re.ASCII)
_HAS_COMMA = re.compile(r"[+-]?(?=[\d.]*+,)[\d.,]++(?:[eE][+-]?\d++)?", re.ASCII)
_COMMA_INSIDE = re.compile(r"[+-]?\d++,\d++", re.ASCII)
_NUMBER_SHAPED = re.compile(
    r"[+-]?(?:(?:\d++(?:[.,]\d*+)?|[.,]\d++)(?:[eE][+-]?\d++)?"
    r"|[1-9]\d{0,2}(?:,\d{3})+(?:\.\d*)?|[1-9]\d{0,2}(?:\.\d{3})+(?:,\d*)?)",
    re.ASCII,
)
_UNITS = (
    *("m", "g", "s", "N", "Nm", "Nmm", "Ncm", "Pa", "V", "A", "W", "J", "Hz", "K", "C", "°C", "°F", "bar", "psi"),
    *("rad", "deg", "°", "turn", "min", "h", "in", "ft", "lbf", "lb", "kgf", "gf", "ozf", "Ohm", "Ω", "l", "L", "%"),
    *("-", "1", "count", "counts", "rpm"),
)  # fmt: skip
_UNIT = re.compile(
    rf"(?:[nuµμmcdkMG]|da)?(?:{'|'.join(map(re.escape, _UNITS))})(?:(?:\^|\*\*)?[-+]?[1-4]|[⁻¹²³]+)?"
)
_BETWEEN_UNITS = re.compile(r"[*·⋅/ ]")
_WITH_UNIT = re.compile(r"[+-]?\d[\d.,]*+\s*+([^\s\d]\D*)")
_WIDE_BLANK, _BEFORE_BRACKET = re.compile(r" {2,}+|\t"), re.compile(r" ++(?=[\[(])")
_NO_SEPARATOR = frozenset("0123456789+-.eE\"'\r\n\0")
_MOST_LINES = 400
_N_SAMPLE = 20
"""Lines, or rows, by which the table is judged."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TableLayout:
    """A table's layout as the user states it; row numbers count from 1, `header_row` -1 is open and 0 none."""

    separator: str = ""
    decimal: str = ""
    encoding: str = ""
    header_row: int = -1
    units_row: int = 0
    data_row: int = 0
    missing: tuple[str, ...] = ()
    block_columns: int = 0
    block_names_row: int = 0
    skip_footer: int = 0
    thousands: str = ""
    date_order: str = ""

    @property
    def no_value(self) -> frozenset[str]:
        """Return every cell text that means "no value"."""
        return frozenset(("", *NAN_TEXTS, *(text.strip() for text in self.missing)))

    def no_value_numbers(self, decimal: str) -> tuple[float, ...]:
        """Return the numbers that stand for "no value", however many digits they are written with: -999 is -999.0."""
        texts = (text.strip() for text in self.missing)
        return tuple(float(text.replace(",", ".")) for text in texts if is_number(text, decimal))

    @property
    def last_head_row(self) -> int:
        """Return the last row that is said to stand above the data, 0 where none is."""
        return max(self.header_row, self.units_row, self.block_names_row, 0)


class HeadRows(NamedTuple):
    """1-based line numbers of header, units (0: none) and first data row."""

    header_row: int
    units_row: int
    data_row: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Dialect:
    """The layout of a text table as found, and notes for when the text is read."""

    separator: str
    decimal: str
    rows: HeadRows
    header: tuple[str, ...]
    units: tuple[str, ...]
    first_row: Sequence[str]
    layout: TableLayout
    thousands: str = ""
    facts: Facts = NO_FACTS
    notes: list[str] = field(default_factory=list)

    @property
    def n_cells(self) -> int:
        """Return the number of cells of the first data row."""
        return len(self.first_row)

    @property
    def stamps(self) -> frozenset[int]:
        """Return the columns that hold text time stamps."""
        return frozenset(index for index, cell in enumerate(self.first_row) if is_stamp(cell))


def is_number(cell: str, decimal: str) -> bool:
    """Return whether a cell is a finite number with this decimal mark, written in plain digits."""
    return _NUMBER[decimal].fullmatch(cell) is not None


def number_of(cell: str, decimal: str, thousands: str) -> float:
    """Return the finite number of a cell with this decimal mark, its thousands grouped where they are; else infinity."""
    if thousands == " ":
        cell = " ".join(cell.split())
    if thousands and thousands in cell:
        first, *groups = cell.partition(decimal)[0].split(thousands)
        of_three = all(len(group) == 3 and group.isdecimal() for group in groups)
        cell = cell.replace(thousands, "") if of_three and 1 <= len(first.lstrip("+-")) <= 3 else ""
    return float(cell.replace(",", ".")) if is_number(cell, decimal) else math.inf


def looks_numeric(cell: str) -> bool:
    """Return whether a cell is written like a number in any country; it need not be readable."""
    return _NUMBER_SHAPED.fullmatch(cell) is not None and not cell.endswith(",")


def is_value(cell: str) -> bool:
    """Return whether a cell is written like a number, perhaps with its unit behind it, or a time stamp."""
    return looks_numeric(cell) or is_stamp(cell) or bool(unit_behind(cell))


def bare_unit(text: str) -> str:
    """Return a unit without the brackets people put around it."""
    text = text.strip()
    bare = text[1:-1].strip() if len(text) > 1 and text[0] + text[-1] in ("[]", "()", "{}", "<>") else text
    return spelled_unit(bare)


def is_unit(cell: str) -> bool:
    """Return whether a cell is written like a unit: a known one with a prefix and a power, or a product of such."""
    unit = bare_unit(cell)
    factors = map(spelled_unit, _BETWEEN_UNITS.split(unit))
    return unit in SUFFIX_UNITS or all(_UNIT.fullmatch(factor) for factor in factors)


def unit_behind(cell: str) -> str:
    """Return the unit behind the number of a cell, "" where there is none."""
    found = _WITH_UNIT.fullmatch(cell)
    return found[1] if found and is_unit(found[1]) else ""


def find_dialect(text: Text, layout: TableLayout, *, last_column: int = 0) -> Dialect:
    """Return the layout of a text table that is said to have at least `last_column` columns."""
    _check(layout)
    head = text.data[: text.end_of_head]
    lines = b"\n".join(head.split(b"\n", _MOST_LINES)[:_MOST_LINES]).decode(errors="replace").split("\n")
    skip = max(layout.data_row - 1, layout.last_head_row)
    if len(lines) - skip < 2:  # an explicit data row far down the file
        lines = [line for _, line in islice(text.lines_from(1), skip + _MOST_LINES)]
    separator = layout.separator or _find_separator(lines, skip, layout, text.source, last_column)
    rows = _find_rows(lines, separator, layout, text.source)
    first_row = split_line(lines[rows.data_row - 1], separator)
    header, units = (_words(lines[row - 1], separator, len(first_row)) if row else () for row in rows[:2])
    decimal, thousands = _find_marks(head, rows.data_row, separator, layout, text.source)
    note = f"{thousands!r} groups thousands, {decimal!r} is the decimal mark"
    return Dialect(
        separator=separator,
        decimal=decimal,
        thousands=thousands,
        rows=rows,
        header=header,
        units=units,
        first_row=first_row,
        layout=layout,
        facts=facts_of(lines[: max(rows.data_row - 1, 0)], separator),
        notes=[note] if thousands and not layout.thousands else [],
    )


def _words(line: str, separator: str, n_cells: int) -> tuple[str, ...]:
    """Return the cells of a header; names of several words are separated by two blanks or end with a unit in brackets.

    numpy.savetxt, gnuplot and Matlab put the header into a comment.
    """
    line = line.lstrip("#%").lstrip(" ")
    ways = [split_line(line, separator)]
    if separator == " ":
        ways += [_WIDE_BLANK.split(line.rstrip()), split_line(_BEFORE_BRACKET.sub("", line), separator)]
    return tuple(next((cells for cells in ways if len(cells) == n_cells), ways[0]))


def _check(layout: TableLayout) -> None:
    mark, after = layout.separator, layout.last_head_row
    counts = ("units_row", "data_row", "block_names_row", "block_columns", "skip_footer")
    odd_mark = bool(mark) and (len(mark) != 1 or mark in _NO_SEPARATOR)
    refusals = (
        ("separator", odd_mark, 'use one character such as ";", "," or "\\t"; " " is any blanks'),
        ("separator", not mark.isascii(), 'use an ASCII character such as ";"'),
        ("decimal", layout.decimal not in ("", ".", ","), 'use "." or ","'),
        ("thousands", layout.thousands not in ("", *THOUSANDS), f"use one of {' '.join(THOUSANDS)}"),
        ("date_order", layout.date_order not in ("", *ORDERS), 'use "dmy", "mdy" or "ymd"'),
        ("header_row", layout.header_row < -1, "give a line number from 1, 0 for none, or leave it out"),
        *((key, getattr(layout, key) < 0, "give a number from 1, or leave it out") for key in counts),
        ("data_row", 0 < layout.data_row <= after, f"the data start after line {after}, the last head line"),
    )
    for key, is_wrong, fix in refusals:
        if is_wrong:
            what = f"[import] {key} = {getattr(layout, key)!r} cannot be used"
            raise InputError(what, key=f"[import] {key}", fix=fix)


def _typical_row(rows: Sequence[Sequence[str]]) -> Sequence[str]:
    """Return the last row that is as wide as most of them, the wider where two widths are as common."""
    widths = Counter(len(row) for row in rows)
    common = max(widths, key=lambda width: (widths[width], width), default=0)
    return next((row for row in reversed(rows) if len(row) == common), ())


def _with_numbers(rows: Sequence[Sequence[str]]) -> list[Sequence[str]]:
    """Return the rows that hold any number: words are a header or a preamble, and say nothing about the data."""
    return [row for row in rows if any(is_value(cell) for cell in row)]


def _find_separator(
    lines: Sequence[str], skip: int, layout: TableLayout, source: Source, last_column: int
) -> str:
    """Return the character that divides the data lines into the most alike rows of numbers."""
    sample = [line for line in lines[skip:] if line.strip()][-_N_SAMPLE:]
    judged = {mark: _divided(sample, mark, layout.no_value) for mark in _possible(sample, layout.decimal)}
    best = max(judged, key=lambda mark: judged[mark][1:], default="")
    if not best or judged[best][1:] == (0.0, 0.0):
        return ";" if layout.decimal == "," and sample else ","
    if best == "," and judged[best][0] == 2 and not layout.decimal and last_column < 2:
        _refuse_one_or_two(sample, lines, source)
    return best


def _possible(sample: Sequence[str], decimal: str) -> list[str]:
    """Return the separators that lines hold, by preference; a blank means any, and no decimal comma divides."""
    joined = "\n".join(sample)
    there = [mark for mark in SEPARATORS if mark in joined or (mark == " " and "\t" in joined)]
    return [mark for mark in there if not mark == "," == decimal or '"' in joined]


def _divided(sample: Sequence[str], separator: str, no_value: frozenset[str]) -> tuple[int, float, float]:
    """Return how many cells a separator makes of most lines, the share of numbers in them, and of such lines."""
    rows = _with_numbers([split_line(line, separator) for line in sample])
    width = len(_typical_row(rows))
    if width < 2:
        return 1, 0.0, 0.0
    alike = [row for row in rows if len(row) == width]
    cells = [is_value(cell) for row in alike for cell in row if cell not in no_value]
    return width, round(sum(cells) / max(len(cells), 1), 2), len(alike) / len(rows)


def _refuse_one_or_two(sample: Sequence[str], lines: Sequence[str], source: Source) -> None:
    """Refuse `12,47` on every line, which is one decimal number or two whole ones."""
    numbers = [line.strip() for line in sample if not any(c.isalpha() for c in line)]
    names = (split_line(line, ",") for line in lines if any(c.isalpha() for c in line))
    if not numbers or not all(_COMMA_INSIDE.fullmatch(line) for line in numbers):
        return
    if not any(len(cells) > 1 and all(cells) for cells in names):
        why = f"{numbers[0]!r} is one number with a decimal comma or two whole numbers; the file does not show which"
        raise source.error(why, code="RF104", fix='set [import] separator = "," or decimal = ","')


def _find_marks(
    head: bytes, data_row: int, separator: str, layout: TableLayout, source: Source
) -> tuple[str, str]:
    """Return the decimal mark and the one between thousands that the head shows: "." and none where it shows nothing.

    A comma groups thousands where cells such as 1,234.5 or 1,234,567 say so and none says otherwise; else it is refused
    where it may be either.
    """
    if layout.decimal or layout.thousands:
        other = "," if layout.thousands == "." else "."
        return layout.decimal or other, layout.thousands
    if b"," not in head or (separator == "," and b'"' not in head):
        return ".", ""
    told: dict[str, tuple[int, str]] = {}
    for number, cell in _comma_cells(head, data_row, separator):
        told.setdefault(_says(cell), (number, cell))
    either, kinds = told.pop("either", None), frozenset(told)
    meant = {frozenset(): (".", ""), frozenset({"decimal"}): (",", ""), frozenset({"English"}): (".", ",")}
    meant |= dict.fromkeys((frozenset({"German"}), frozenset({"German", "decimal"})), (",", "."))
    if kinds not in meant:
        number, cell = told.get("neither") or max(told.values())
        why = f"{cell!r} mixes marks, or others do: which of them groups thousands is never guessed"
        fix = 'set [import] decimal and thousands, such as decimal = "." and thousands = ","'
        raise source.error(why, code="RF104", line=number, fix=fix)
    if either and not kinds:
        number, cell = either
        meanings = f"{cell.replace(',', '.')} or {cell.replace(',', '')}"
        why = f"{cell!r} may mean {meanings}; no cell in the first 64 kB shows which"
        fix = 'set [import] decimal = "," if it is a decimal comma, or thousands = "," if it groups thousands'
        raise source.error(why, code="RF104", line=number, fix=fix)
    return meant[kinds]


def _says(cell: str) -> str:
    """Return the marks that a number with a comma implies."""
    if _POINTED.fullmatch(cell) or (_GROUPED.fullmatch(cell) and cell.count(",") > 1):
        return "English"
    if _GROUPED_BY_POINTS.fullmatch(cell):
        return "German"
    if _GROUPED.fullmatch(cell):
        return "either"
    return "decimal" if is_number(cell, ",") else "neither"


def _comma_cells(head: bytes, data_row: int, separator: str) -> Iterator[tuple[int, str]]:
    for number, line in enumerate(head.split(b"\n"), start=1):
        if number < data_row or b"," not in line:
            continue
        for cell in split_line(line.decode(errors="replace"), separator):
            if "," in cell and _HAS_COMMA.fullmatch(cell) and any(c.isdigit() for c in cell):
                yield number, cell


def _find_rows(lines: Sequence[str], separator: str, layout: TableLayout, source: Source) -> HeadRows:
    """Return where header, units and data start in a text.

    What the user says holds. Left open, the data start at the first row of numbers, and the header is the nearest
    row of words above it, with a row of units allowed between. Rows further up are a preamble.
    """
    rows = [split_line(line, separator) for line in lines]
    inked = [number for number, row in enumerate(rows, start=1) if any(row)]
    after = layout.last_head_row
    if layout.data_row or layout.header_row >= 0:
        first = layout.data_row or after + 1
        data_row = next((number for number in inked if number >= first), 0)
    else:
        data_row = _first_data_row(rows, [number for number in inked if number > after], layout)
    if data_row == 0:
        raise _no_data(rows, layout, source)
    if layout.header_row >= 0:
        return HeadRows(layout.header_row, layout.units_row, data_row)
    return HeadRows(*_words_above(rows, inked, data_row, layout), data_row)


def _first_data_row(rows: Sequence[Sequence[str]], below: Sequence[int], layout: TableLayout) -> int:
    """Return the first row that holds numbers wherever a typical row does, or nothing but numbers.

    A row above a line of words, or above `key=value`, is no data: the table begins further down.
    """
    typical = _typical_row(_with_numbers([rows[number - 1] for number in below[-_N_SAMPLE:]]))
    is_numeric = [is_value(cell) or not cell for cell in typical]  # no word where nothing is, either
    units = [("", unit_behind(cell)) for cell in typical]  # a row of other units is a head: 25 Hz
    for place, number in enumerate(below):
        row, after = rows[number - 1], rows[below[place + 1] - 1] if place + 1 < len(below) else ()
        is_typical = len(row) == len(typical) and _holds_numbers(row, is_numeric, layout.no_value)
        is_typical &= all(unit_behind(cell) in known for cell, known in zip(row, units, strict=False))
        if is_fact(after) or not (is_typical or _holds_numbers(row, repeat(True), layout.no_value)):
            continue
        if is_typical or not after or any(map(is_value, after)):
            return _with_damaged(rows, below[: place + 1])
    return 0


def _holds_numbers(row: Sequence[str], where: Iterable[bool], no_value: frozenset[str]) -> bool:
    """Return whether a row has any number, and numbers or nothing in all columns that `where` is true for."""
    asked = (cell for cell, is_asked in zip(row, where, strict=False) if is_asked)
    return any(map(is_value, row)) and all(is_value(cell) or cell in no_value for cell in asked)


def _with_damaged(rows: Sequence[Sequence[str]], numbers: Sequence[int]) -> int:
    """Return the first of the half-numeric rows right above the last of some rows: damaged data are not passed over."""
    *above, first = numbers
    for number in reversed(above):
        row = rows[number - 1]
        if len(row) != len(rows[first - 1]) or not any(map(looks_numeric, row)):
            break
        first = number
    return first


def _words_above(
    rows: Sequence[Sequence[str]], inked: Sequence[int], data_row: int, layout: TableLayout
) -> tuple[int, int]:
    """Return header and units row: the nearest rows of words above the data that are as wide as a header."""

    def over_data(number: int) -> list[str]:
        """Return the cells over columns that hold data; other cells are remarks."""
        row, data = rows[number - 1], rows[data_row - 1]
        pairs = zip(row, data, strict=False) if len(row) == len(data) else ((cell, cell) for cell in row)
        return [cell for cell, below in pairs if cell and below]

    def is_header(number: int) -> bool:
        """Distinguish names from a preamble: words, and more than one wherever the data have more than one column."""
        row, words = rows[number - 1], over_data(number)
        wide = len(row) > 1 or len(rows[data_row - 1]) == 1
        return wide and bool(words) and not any(is_value(cell) for cell in words) and not is_fact(row)

    units_row = layout.units_row
    above = [n for n in inked if n < (units_row or data_row) and n != layout.block_names_row]
    if not above or not is_header(above[-1]):
        return 0, units_row
    are_units = all(map(is_unit, over_data(above[-1])))
    if are_units and not units_row and len(above) > 1:
        names, data = rows[above[-2] - 1], rows[data_row - 1]
        # Right above units even numbers are names, those of an oscilloscope's channels.
        is_named = len(names) == len(data) and not all(map(is_value, names))
        if is_header(above[-2]) or (is_named and above[-2] == above[-1] - 1):
            return above[-2], above[-1]
    return above[-1], units_row


def _no_data(rows: Sequence[Sequence[str]], layout: TableLayout, source: Source) -> DataError:
    if layout.data_row:
        last = max((number for number, row in enumerate(rows, start=1) if any(row)), default=0)
        why = f"data_row = {layout.data_row}, but the last line with content is {last}"
        return source.error(why, key="[import] data_row", fix="give the line of the first data row")
    fix = "record it again, write numbers without labels, or set [import] data_row, separator and decimal"
    line = next((" ".join(row) for row in reversed(rows) if any(row)), "")
    why = (
        f"there are no data rows: no line below the header has a cell that is a number; one is {line[:60]!r}"
    )
    return source.error(why, fix=fix)


ORDERS = {"ymd": "year, month, day", "dmy": "day, month, year", "mdy": "month, day, year"}
"""Meaning of the numbers of a date, by the key `date_order`."""

_SEPARATORS = re.compile(r"[-/.]")
_STAMP = re.compile(
    r"(?:(?P<date>\d{4}([-/.])\d{1,2}\2\d{1,2}|\d{1,2}([-/.])\d{1,2}\3(?:\d{4}|\d\d))(?:T|,?\s++|[-_,]))?"
    r"(?P<hour>\d{1,3}):(?P<minute>[0-5]\d)(?::(?P<second>[0-5]\d|60)(?:[.,:](?P<part>\d{1,30}))?)?"
    r"(?:\s*+(?P<half>[AaPp])\.?[Mm]\.?)?(?:\s*+(?P<zone>Z|UTC|GMT|[+-]\d\d(?::?\d\d)?))?",
    re.ASCII,
)
_S = 10**9
_DAY = 86400 * _S
"""In nanoseconds."""
_HOUR_BACK = (3000 * _S, 3600 * _S)  # a step back of an hour, less the time that passed

_Refuse = Callable[[int, str, str], DataError]
_Stamp = re.Match[str]


def is_stamp(text: str) -> bool:
    """Return whether a text is a time of day with seconds, or a date with a time of day."""
    if ":" not in text[:16]:
        return False
    found = _STAMP.fullmatch(text)
    return found is not None and bool(found["date"] or found["second"])


def read_stamps(
    cells: Iterable[tuple[int, str]], *, order: str, no_value: Iterable[str], refuse: _Refuse
) -> tuple[FloatArray, tuple[str, ...]]:
    """Return the seconds from the first stamp of a column on, by whole nanoseconds, and how they were understood.

    Stamps with a zone count in UTC. Those without are of a clock that nobody sets; one that goes back by an hour is
    refused. Without a date, a fall by more than twelve hours is midnight. A date whose order only the writer can know
    is refused, unless all stamps are of one day.
    """
    rows = list(cells)
    stamps = _stamps_by_place(rows, frozenset(no_value), refuse)
    seconds = np.full(len(rows), np.nan)
    if not stamps:
        return seconds, ()
    first = next(iter(stamps.values()))
    dates: dict[str, int] = {}  # with the line in which each is first
    for at, match in stamps.items() if first["date"] else ():
        dates.setdefault(match["date"], rows[at][0])
    order = _order(dates, order, refuse)
    days, counts, n_midnights = _days(dates, order, refuse), list[int](), 0
    for at, match in stamps.items():
        count = days.get(match["date"], n_midnights) * _DAY + _since_midnight(match, rows[at][0], refuse)
        back = counts[-1] - count if counts else 0
        if dates and not match["zone"] and _HOUR_BACK[0] <= back <= _HOUR_BACK[1]:
            why = f"the clock goes back by an hour to {match[0]!r}: summer time ended"
            raise refuse(rows[at][0], why, "export times in UTC, or seconds since the start")
        if not dates and back > _DAY // 2:
            n_midnights += 1
            count += _DAY
        counts.append(count)
    seconds[list(stamps)] = [(count - counts[0]) / _S for count in counts]
    facts = [ORDERS.get(order, "all of one day") if dates else "without a date"]
    if n_midnights:
        facts.append(f"past midnight {n_midnights} times")
    return seconds, (f"text time stamps ({', '.join(facts)}) from {first[0]} on",)


def _stamps_by_place(
    rows: Sequence[tuple[int, str]], no_value: frozenset[str], refuse: _Refuse
) -> dict[int, _Stamp]:
    """Return the stamps of a column; all have a date or none has, and so with a zone."""
    read = {at: _STAMP.fullmatch(text) for at, (_, text) in enumerate(rows) if text not in no_value}
    first, found = next(filter(None, read.values()), None), dict[int, _Stamp]()
    if first is None:
        return found
    for at, match in read.items():
        if match is None or _form(match) != _form(first):
            line, text = rows[at]
            why = f"cannot read {text[:40]!r} as a time stamp like {first[0]!r}"
            raise refuse(line, why, "mend the cell")
        found[at] = match
    return found


def _form(match: _Stamp) -> tuple[bool, bool]:
    """Return whether a stamp has a date, and a zone."""
    return match["date"] is not None, match["zone"] is not None


def _order(lines: Mapping[str, int], stated: str, refuse: _Refuse) -> str:
    """Return the order of the numbers in dates: year first where four digits are, else as stated, else by what shows.

    Where nothing shows it, "" for one day, which the time is not counted over; more are refused.
    """
    if all(text[:4].isdigit() for text in lines):
        return "ymd"
    if stated or all("." in text for text in lines):
        return stated or "dmy"
    # Nobody can tell the fourth of March from the third of April, but the 25th of a month is a day.
    for order, at in (("dmy", 0), ("mdy", 1)):
        if any(int(_SEPARATORS.split(text)[at]) > 12 for text in lines):
            return order
    if len(lines) == 1:
        return ""
    some = min(lines)
    why = f"{some!r} may mean day, month, year or month, day, year"
    raise refuse(lines[some], why, 'set [import] date_order = "mdy" or "dmy"')


def _days(lines: Mapping[str, int], order: str, refuse: _Refuse) -> dict[str, int]:
    """Return the day number of every date, 0 for a day that may be two."""
    if not order:
        return dict.fromkeys(lines, 0)
    days = {}
    for text, line in lines.items():
        named = dict(zip(order, map(int, _SEPARATORS.split(text)), strict=True))
        try:
            year = named["y"] if named["y"] > 99 else 2000 + named["y"]
            days[text] = date(year, named["m"], named["d"]).toordinal()
        except ValueError:
            why = f"there is no date {text!r} in the order {ORDERS[order]}"
            raise refuse(line, why, "mend it, or correct [import] date_order") from None
    return days


def _since_midnight(match: _Stamp, line: int, refuse: _Refuse) -> int:
    """Return the time of day of a stamp in nanoseconds, less the offset of its zone."""
    hour, half, zone = int(match["hour"]), (match["half"] or "").lower(), match["zone"] or ""
    if half:
        hour = hour % 12 + 12 * (half == "p") if 1 <= hour <= 12 else 99
    if hour > 23 and (half or match["date"]):
        raise refuse(line, f"there is no such hour as in {match[0]!r}", "mend the cell")
    minute = hour * 60 + int(match["minute"])
    if zone[:1] in ("+", "-"):
        digits = zone[1:].replace(":", "").ljust(4, "0")
        minute -= int(zone[0] + "1") * (int(digits[:2]) * 60 + int(digits[2:]))
    return (minute * 60 + int(match["second"] or 0)) * _S + int((match["part"] or "").ljust(9, "0")[:9])
