"""What is told to people: numbers as they read them, sections with tables, charts as data, and text of it all.

The terminal and summary.txt show sections by `as_text`; `ropefric.report.page` shows the same as HTML and Markdown.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import zip_longest
from textwrap import wrap
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from ropefric.arrays import FloatArray

WIDTH = 110
"""Columns that sentences are folded to."""


class Section(NamedTuple):
    """A heading with lines of text, and at most one table between them: cells as text under headings.

    Of the table the first `left` columns are words, and those whose heading ends in a space; the others are numbers.
    """

    title: str = ""
    lines: Sequence[str] = ()
    headings: Sequence[str] = ()
    rows: Sequence[Sequence[str]] = ()
    left: int = 1
    notes: Sequence[str] = ()
    verbatim: bool = False

    def is_words(self, column: int) -> bool:
        """Return whether a column holds words and not numbers."""
        return column < self.left or self.headings[column].endswith(" ")


class Line(NamedTuple):
    """A line of a chart; a point where it has one value; a limit drawn thin where `limit` says so."""

    name: str
    x: "FloatArray"
    y: "FloatArray"
    limit: bool = False


class Chart(NamedTuple):
    """A figure as data: lines over one axis, whose columns are named as in a table."""

    title: str
    x_column: str
    x_label: str
    y_column: str
    y_label: str
    lines: tuple[Line, ...]


def in_words(value: float | None, form: str = ".4g", factor: float = 1.0) -> str:
    """Return a number as a table shows it: a dash where there is none, 0 for what only rounding left; yes or no."""
    if value is None or not math.isfinite(value):
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return format(0.0 if abs(value) < 1e-12 else factor * value, form)


def plain(value: float | None, form: str = ".4g") -> str:
    """Return a number as text, a dash where there is none."""
    if value is None or math.isnan(value):
        return "–"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    return format(value, form)


def shorthand(value: float, std: float) -> str:
    """Return a value with its standard error in units of its last digits, as in 0.1192(12)."""
    if not (math.isfinite(value) and math.isfinite(std)) or std <= 0.0:
        return plain(value, ".5g")
    exponent = _last_place(std)
    last = f"{std / 10.0**exponent:.0f}" if exponent < 0 else to_error(std, std)
    return f"{to_error(value, std)}({last})"


def to_error(value: float, std: float) -> str:
    """Return a value down to the second digit of its standard error; to six digits where it has none."""
    if not (math.isfinite(value) and math.isfinite(std)) or std <= 0.0:
        return plain(value, ".6g")
    exponent = _last_place(std)
    scale = 10.0**exponent
    return f"{value:.{-exponent}f}" if exponent < 0 else f"{scale * round(value / scale):.0f}"


def _last_place(std: float) -> int:
    # Rounded first, because 0.0999 becomes 0.10 and has a digit less.
    return math.floor(math.log10(float(f"{std:.1e}"))) - 1


def interval(ends: Iterable[float], form: str = ".4g") -> str:
    """Return an interval as text."""
    low, high = (plain(float(end), form) for end in ends)
    return f"{low} … {high}" if (low, high) != ("–", "–") else "–"


def percent(share: float, form: str = ".2g") -> str:
    """Return a share in per cent, a dash where there is none."""
    return f"{format(100 * share, form)} %" if math.isfinite(share) else "–"


def as_text(sections: Sequence[Section], width: int | None = None) -> str:
    """Return sections as text with aligned columns; for a terminal of some width, all of it folded to it."""
    return "\n".join("".join(f"{line}\n" for line in _text_lines(section, width)) for section in sections)


def folded(text: str, width: int | None) -> str:
    """Return text with its lines folded at blanks to a terminal's width, if it is one; no word is broken."""
    if width is None:
        return text
    return "\n".join(part for line in text.split("\n") for part in fold(line, width))


def fold(line: str, width: int, indent: str = "", *, hang: str = "  ", more: str = "") -> list[str]:
    """Return a line folded at blanks, what follows standing a little further in than its beginning.

    `more` ends every line but the last; words that are longer than the width stay whole.
    """
    begin = indent + " " * (len(line) - len(line.lstrip()))
    whole: dict[str, Any] = {"break_long_words": False, "break_on_hyphens": False}
    if len(begin) + len(line.lstrip()) <= width:
        return [f"{indent}{line}"]
    parts = wrap(
        line.lstrip(), width - len(more), initial_indent=begin, subsequent_indent=begin + hang, **whole
    )
    return [*(f"{part}{more}" for part in parts[:-1]), *parts[-1:]] or [""]


def _text_lines(section: Section, width: int | None) -> list[str]:
    indent = "  " if section.title else ""
    narrow = min(WIDTH, width or WIDTH)
    lines = folded(section.title, width).split("\n") if section.title else []
    for line in section.lines:
        if section.verbatim and width is None:
            lines.append(f"{indent}{line}")
        else:
            lines += fold(line, width or WIDTH if section.verbatim else narrow, indent)
    if section.headings:
        lines += [f"{indent}{line}".rstrip() for line in _table_lines(section, width and width - len(indent))]
    return lines + [part for note in section.notes for part in fold(f"- {note}", narrow, indent)]


def _table_lines(section: Section, width: int | None) -> Iterator[str]:
    rows = [tuple(heading.rstrip() for heading in section.headings), *section.rows]
    columns = [*zip(*rows, strict=True)]
    widths = [max(map(len, column)) for column in columns]
    if width is not None and sum(widths) + 2 * len(widths) - 2 > width:
        least = [max(len(word) for cell in column for word in cell.split() or [""]) for column in columns]
        if sum(least) + 2 * len(least) - 2 > width:
            yield from _records(rows[0], section.rows, width)
            return
        # The widest column that still has a blank to fold at gives way first.
        while sum(widths) + 2 * len(widths) - 2 > width:
            can = [place for place, one in enumerate(widths) if one > least[place]]
            widths[max(can, key=widths.__getitem__)] -= 1
    forms = [f"{'<' if section.is_words(place) else '>'}{one}" for place, one in enumerate(widths)]
    whole: dict[str, Any] = {"break_long_words": False, "break_on_hyphens": False}
    for row in rows:
        pairs = zip(row, widths, strict=True)
        cells = (wrap(cell, one, **whole) if len(cell) > one else [cell] for cell, one in pairs)
        for line in zip_longest(*cells, fillvalue=""):
            yield "  ".join(f"{part:{form}}" for part, form in zip(line, forms, strict=True))


def _records(headings: Sequence[str], rows: Sequence[Sequence[str]], width: int) -> Iterator[str]:
    """Give a table that is too wide for its columns as one block a row, a line a cell, its heading before it."""
    for row in rows:
        told = [(name, cell) for name, cell in zip(headings, row, strict=True) if cell]
        for place, line in enumerate(f"{name}: {cell}" if name else cell for name, cell in told):
            yield from fold(line, width, "  " if place else "")
