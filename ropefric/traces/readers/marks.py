"""Which characters separate the columns and the decimals of a text file."""

import re
from collections import Counter
from collections.abc import Iterator, Sequence

from ropefric.traces.readers.cells import CellStyle, is_number, split_line
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.source import Source

CANDIDATES = ("\t", ";", "|", ",", " ")
"""Separators by preference: TAB before blanks, and "," only where nothing stronger divides the numbers."""

_N_SAMPLE = 20
_GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}(?:,\d{3})+", re.ASCII)
_DIGITS_AND_MARKS = re.compile(r"[+-]?(?=[\d.]*+,)[\d.,]++(?:[eE][+-]?\d++)?", re.ASCII)
_COMMA_INSIDE = re.compile(r"[+-]?\d++,\d++", re.ASCII)
_NUMBER_SHAPED = re.compile(
    r"[+-]?(?:(?:\d++(?:[.,]\d*+)?|[.,]\d++)(?:[eE][+-]?\d++)?"
    r"|[1-9]\d{0,2}(?:,\d{3})+(?:\.\d*)?|[1-9]\d{0,2}(?:\.\d{3})+(?:,\d*)?)",
    re.ASCII,
)


def looks_numeric(cell: str) -> bool:
    """Return whether a cell is written like a number in any country; it need not be readable."""
    return _NUMBER_SHAPED.fullmatch(cell) is not None and not cell.endswith(",")


def typical_row(rows: Sequence[Sequence[str]]) -> Sequence[str]:
    """Return the last row that is as wide as most of them, the wider where two widths are as common."""
    widths = Counter(len(row) for row in rows)
    common = max(widths, key=lambda width: (widths[width], width), default=0)
    return next((row for row in reversed(rows) if len(row) == common), ())


def find_separator(
    data_lines: Sequence[str], lines: Sequence[str], profile: ImportProfile, source: Source
) -> str:
    r"""Return the character that divides the data lines into the most alike rows of numbers."""
    inked = [line for line in data_lines if line.strip()]
    sample = inked[-_N_SAMPLE:]
    if not sample:
        return ","
    no_value = CellStyle(missing=profile.missing).no_value
    best, best_score, best_width = (";" if profile.decimal == "," else ","), (0.0, 0.0), 1
    joined = "\n".join(sample)
    for candidate in CANDIDATES:
        if candidate not in joined and not (candidate == " " and "\t" in joined):
            continue
        if best_score == (1.0, 1.0):
            break  # nothing later can be better, only as good
        if candidate == "," == profile.decimal and not any('"' in line for line in sample):
            continue
        # Rows of words are a header or a preamble, and say nothing about numbers.
        rows = [split_line(line, candidate) for line in sample]
        rows = [row for row in rows if any(looks_numeric(cell) for cell in row)]
        width = len(typical_row(rows))
        if width < 2:
            continue
        alike = [row for row in rows if len(row) == width]
        cells = [cell for row in alike for cell in row if cell not in no_value]
        numeric = sum(looks_numeric(cell) for cell in cells) / max(len(cells), 1)
        score = (round(numeric, 2), len(alike) / len(rows))
        if score > best_score:
            best, best_score, best_width = candidate, score, width
    if best == "," and best_width == 2 and not profile.decimal:
        _refuse_one_or_two(sample, lines, profile, source)
    return best


def _refuse_one_or_two(
    sample: Sequence[str], lines: Sequence[str], profile: ImportProfile, source: Source
) -> None:
    """Refuse `12,47` on every line, where nothing tells one decimal number from two whole ones."""
    numbers = [line.strip() for line in sample if not any(c.isalpha() for c in line)]
    if not numbers or not all(_COMMA_INSIDE.fullmatch(line) for line in numbers):
        return
    wanted = [channel.column for channel in profile.channels.values() if isinstance(channel.column, int)]
    names = (split_line(line, ",") for line in lines if any(c.isalpha() for c in line))
    if any(len(cells) > 1 and all(cells) for cells in names) or max(wanted, default=0) > 1:
        return
    raise source.error(
        f"{numbers[0]!r} is one number with a decimal comma or two whole numbers; nothing tells which",
        code="RF104",
        fix='set [import] separator = "," or decimal = ","',
    )


def find_decimal(head: bytes, data_row: int, separator: str, source: Source) -> str:
    r"""Return the decimal mark that the first 64 kB show; "." where there is none.

    A comma is never taken as a thousands separator.
    """
    if b"," not in head or (separator == "," and b'"' not in head):
        return "."
    grouped = (0, "")
    for number, cell in _comma_cells(head, data_row, separator):
        if _GROUPED.fullmatch(cell):
            if cell.count(",") > 1:
                raise _grouped_error(number, cell, source)
            grouped = grouped if grouped[0] else (number, cell)
        elif "." in cell or not is_number(cell, ","):
            raise _grouped_error(number, cell, source)
        else:
            return ","
    if grouped[0]:
        cell = grouped[1]
        raise source.error(
            f"{cell!r} may mean {cell.replace(',', '.')} or {cell.replace(',', '')}; no cell in the first "
            "64 kB tells which",
            code="RF104",
            line=grouped[0],
            fix='set [import] decimal = "," if it is a decimal comma; if the comma groups thousands, save the '
            'file without them (with decimal = "." such a cell is refused)',
        )
    return "."


def _comma_cells(head: bytes, data_row: int, separator: str) -> Iterator[tuple[int, str]]:
    for number, line in enumerate(head.split(b"\n"), start=1):
        if number < data_row or b"," not in line:
            continue
        for cell in split_line(line.decode(errors="replace"), separator):
            if "," in cell and _DIGITS_AND_MARKS.fullmatch(cell) and any(c.isdigit() for c in cell):
                yield number, cell


def _grouped_error(line: int, cell: str, source: Source) -> Exception:
    return source.error(
        f"{cell!r} mixes marks: it looks like a number with thousands separators, which are never guessed",
        code="RF104",
        line=line,
        fix='save the file without thousands separators, or set [import] decimal = "." or ","',
    )
