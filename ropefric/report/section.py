"""What is told to people: numbers as they read them, sections with tables, and both as plain text.

The terminal and summary.txt show sections by `as_text`; `ropefric.report.page` shows the same as HTML and Markdown.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from itertools import zip_longest
from textwrap import wrap
from typing import Any, NamedTuple

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
    # Rounded first, because 0.0999 becomes 0.10 and has a digit less.
    exponent = math.floor(math.log10(float(f"{std:.1e}"))) - 1
    if exponent >= 0:
        scale = 10.0**exponent
        return f"{scale * round(value / scale):.0f}({scale * round(std / scale):.0f})"
    return f"{value:.{-exponent}f}({round(std * 10.0**-exponent):d})"


def interval(ends: Iterable[float], form: str = ".4g") -> str:
    """Return an interval as text."""
    low, high = (plain(float(end), form) for end in ends)
    return f"{low} … {high}" if (low, high) != ("–", "–") else "–"


def percent(share: float, form: str = ".2g") -> str:
    """Return a share in per cent, a dash where there is none."""
    return f"{format(100 * share, form)} %" if math.isfinite(share) else "–"


def as_text(sections: Sequence[Section], width: int | None = None) -> str:
    """Return sections as text with aligned columns; for a terminal of some width, tables folded to it too."""
    return "\n".join("".join(f"{line}\n" for line in _text_lines(section, width)) for section in sections)


def _text_lines(section: Section, width: int | None) -> list[str]:
    indent = "  " if section.title else ""
    fold = partial(_folded, indent=indent, width=min(WIDTH, width or WIDTH))
    lines = [section.title] if section.title else []
    for line in section.lines:
        lines += [f"{indent}{line}"] if section.verbatim else fold(line)
    if section.headings:
        lines += [f"{indent}{line}".rstrip() for line in _table_lines(section, width and width - len(indent))]
    return lines + [part for note in section.notes for part in fold(f"- {note}")]


def _table_lines(section: Section, width: int | None) -> Iterator[str]:
    rows = [tuple(heading.rstrip() for heading in section.headings), *section.rows]
    columns = [*zip(*rows, strict=True)]
    widths = [max(map(len, column)) for column in columns]
    if width is not None and sum(widths) + 2 * len(widths) - 2 > width:
        least = [max(len(word) for cell in column for word in cell.split() or [""]) for column in columns]
        # The widest column gives way first, within words only where no blank is left to fold at.
        while sum(widths) + 2 * len(widths) - 2 > width and max(widths) > 1:
            can = [place for place, one in enumerate(widths) if one > least[place]] or range(len(widths))
            widths[max(can, key=widths.__getitem__)] -= 1
    forms = [f"{'<' if section.is_words(place) else '>'}{one}" for place, one in enumerate(widths)]
    for row in rows:
        cells = (
            wrap(cell, one) if len(cell) > one else [cell] for cell, one in zip(row, widths, strict=True)
        )
        for line in zip_longest(*cells, fillvalue=""):
            yield "  ".join(f"{part:{form}}" for part, form in zip(line, forms, strict=True))


def _folded(line: str, indent: str, width: int) -> list[str]:
    """Return a line folded at blanks, what follows standing a little further in than its beginning."""
    inner = indent + " " * (len(line) - len(line.lstrip(" -")))
    whole: dict[str, Any] = {"break_long_words": False, "break_on_hyphens": False}
    return wrap(line, width, initial_indent=indent, subsequent_indent=inner, **whole) or [""]
