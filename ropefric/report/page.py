"""Sections as one HTML page that needs nothing else."""

from collections.abc import Sequence
from html import escape

from ropefric.files.plain_text import visible
from ropefric.report.section import Section, Table

_STYLE = """\
body { font: 16px/1.45 system-ui, sans-serif; color: #1d2433; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin: 1.8rem 0 0.4rem; }
p { margin: 0.3rem 0; } table { border-collapse: collapse; margin: 0.6rem 0; }
th, td { padding: 0.2rem 0.9rem 0.2rem 0; text-align: right; vertical-align: top; }
th { border-bottom: 1px solid #8891a3; } .words { text-align: left; }
tbody tr:nth-child(even) { background: #f3f5f9; }
"""


def as_page(title: str, sections: Sequence[Section]) -> str:
    """Return sections as an HTML page."""
    body = "".join(_section(section) for section in sections)
    return visible(
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<title>{escape(title)}</title>\n'
        f"<style>\n{_STYLE}</style>\n</head>\n<body>\n<h1>{escape(title)}</h1>\n{body}</body>\n</html>\n"
    )


def _section(section: Section) -> str:
    parts = [f"<h2>{escape(section.title)}</h2>\n"] if section.title else []
    parts += [f"<p>{escape(line)}</p>\n" for line in section.lines]
    if section.table is not None:
        parts.append(_table(section.table))
    if section.notes:
        items = "".join(f"<li>{escape(note)}</li>\n" for note in section.notes)
        parts.append(f"<ul>\n{items}</ul>\n")
    return "".join(parts)


def _table(table: Table) -> str:
    head = _row(table, tuple(heading.rstrip() for heading in table.headings), "th")
    rows = "".join(_row(table, row, "td") for row in table.rows)
    return f"<table>\n<thead>\n{head}</thead>\n<tbody>\n{rows}</tbody>\n</table>\n"


def _row(table: Table, cells: tuple[str, ...], tag: str) -> str:
    marks = (' class="words"' if table.is_words(column) else "" for column in range(len(cells)))
    inner = "".join(f"<{tag}{mark}>{escape(cell)}</{tag}>" for mark, cell in zip(marks, cells, strict=True))
    return f"<tr>{inner}</tr>\n"
