"""Sections as plain text."""

from collections.abc import Sequence
from textwrap import wrap

from ropefric.report.section import Section, Table

WIDTH = 110
"""Columns that sentences are folded to."""


def as_text(sections: Sequence[Section]) -> str:
    r"""Return sections as text with aligned columns."""
    return "\n".join("".join(f"{line}\n" for line in _lines(section)) for section in sections)


def _lines(section: Section) -> list[str]:
    lines = [section.title] if section.title else []
    indent = "  " if section.title else ""
    for line in section.lines:
        lines += [f"{indent}{line}"] if section.verbatim else _wrapped(line, indent)
    if section.table is not None:
        lines += [f"{indent}{line}" for line in _aligned(section.table)]
    return lines + [part for note in section.notes for part in _wrapped(f"- {note}", indent)]


def _wrapped(line: str, indent: str) -> list[str]:
    """Return a line folded at blanks, what follows standing a little further in than its beginning."""
    inner = " " * (len(line) - len(line.lstrip(" -")))
    return wrap(
        line,
        WIDTH,
        initial_indent=indent,
        subsequent_indent=f"{indent}{inner}",
        break_long_words=False,
        break_on_hyphens=False,
    ) or [""]


def _aligned(table: Table) -> list[str]:
    rows = [tuple(heading.rstrip() for heading in table.headings), *table.rows]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    words = [table.is_words(column) for column in range(len(widths))]
    return [
        "  ".join(
            cell.ljust(width) if word else cell.rjust(width)
            for cell, width, word in zip(row, widths, words, strict=True)
        ).rstrip()
        for row in rows
    ]
