"""What is told to people: numbers as they read them, sections with tables, and both as plain text.

The terminal and summary.txt show sections by `as_text`; `ropefric.report.page` shows the same as HTML and Markdown.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from textwrap import wrap

WIDTH = 110
"""Columns that sentences are folded to."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """Cells as text under headings; the first `left` columns, and the last if its heading ends in a space, are words."""

    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    left: int = 1

    def is_words(self, column: int) -> bool:
        """Return whether a column holds words and not numbers."""
        return column < self.left or self.headings[column].endswith(" ")


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """A heading with lines of text and at most one table between them."""

    title: str = ""
    lines: tuple[str, ...] = ()
    table: Table | None = None
    notes: tuple[str, ...] = ()
    verbatim: bool = False


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


def as_text(sections: Sequence[Section]) -> str:
    """Return sections as text with aligned columns."""
    return "\n".join("".join(f"{line}\n" for line in _text_lines(section)) for section in sections)


def _text_lines(section: Section) -> list[str]:
    indent = "  " if section.title else ""
    lines = [section.title] if section.title else []
    for line in section.lines:
        lines += [f"{indent}{line}"] if section.verbatim else _folded(line, indent)
    if section.table is not None:
        lines += [f"{indent}{line}" for line in _aligned(section.table)]
    return lines + [part for note in section.notes for part in _folded(f"- {note}", indent)]


def _folded(line: str, indent: str) -> list[str]:
    """Return a line folded at blanks, what follows standing a little further in than its beginning."""
    inner = indent + " " * (len(line) - len(line.lstrip(" -")))
    folded = wrap(
        line,
        WIDTH,
        initial_indent=indent,
        subsequent_indent=inner,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return folded or [""]


def _aligned(table: Table) -> list[str]:
    rows = [tuple(heading.rstrip() for heading in table.headings), *table.rows]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    sides = ["<" if table.is_words(column) else ">" for column in range(len(widths))]
    return [
        "  ".join(
            f"{cell:{side}{width}}" for cell, side, width in zip(row, sides, widths, strict=True)
        ).rstrip()
        for row in rows
    ]
