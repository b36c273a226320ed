"""Results in words: formatted numbers, sections with tables, charts as data, and the text of all.

The terminal and summary.txt show sections by `as_text`; `ropefric.report.page` shows the same as HTML.
"""

import math
import sys
from collections.abc import Iterator, Sequence
from itertools import zip_longest
from textwrap import wrap
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from ropefric.arrays import FloatArray

WIDTH = 110
"""Columns that sentences are folded to."""
_FLOAT_DIGITS = sys.float_info.dig


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


def in_cell(value: float | None, form: str = ".4g", factor: float = 1.0) -> str:
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
    """Return a value down to the second digit of its standard error; to six digits where that is none or too far."""
    if not (math.isfinite(value) and math.isfinite(std)) or std <= 0.0:
        return plain(value, ".6g")
    exponent = _last_place(std)
    leading = math.floor(math.log10(abs(value))) if value else exponent
    if max(leading, 0) - min(exponent, 0) >= _FLOAT_DIGITS:
        return f"{value:.{min(max(leading - exponent, 0) + 1, 6)}g}"
    return f"{value:.{-exponent}f}" if exponent < 0 else f"{round(value, -exponent):.0f}"


def plus_minus(value: float, std: float) -> str:
    """Return a value and its standard deviation, both to the second digit of the latter: 1100 ± 110."""
    if not math.isfinite(std) or std <= 0.0:
        return plain(value, ".5g")
    return f"{to_error(value, std)} ± {to_error(std, std)}"


def _last_place(std: float) -> int:
    # Rounded first, because 0.0999 becomes 0.10 and has a digit less.
    return math.floor(math.log10(float(f"{std:.1e}"))) - 1


def percent(share: float, form: str = ".2g") -> str:
    """Return a share in per cent, a dash where there is none."""
    return f"{format(100 * share, form)} %" if math.isfinite(share) else "–"


def as_text(sections: Sequence[Section]) -> str:
    """Return sections as text: sentences folded, columns aligned."""
    return "\n".join("".join(f"{line}\n" for line in _text_lines(section)) for section in sections)


def _text_lines(section: Section) -> Iterator[str]:
    indent = "  " if section.title else ""
    if section.title:
        yield section.title
    for line in section.lines:
        yield from [f"{indent}{line}"] if section.verbatim else _fold(line, indent)
    if section.headings:
        yield from (f"{indent}{line}".rstrip() for line in _table_lines(section))
    for note in section.notes:
        yield from _fold(f"- {note}", indent)


def _fold(line: str, indent: str) -> list[str]:
    """Return a line folded at blanks, what follows standing a little further in than its beginning."""
    begin = indent + " " * (len(line) - len(line.lstrip()))
    whole: dict[str, Any] = {"break_long_words": False, "break_on_hyphens": False}
    if len(begin) + len(line.lstrip()) <= WIDTH:
        return [f"{indent}{line}"]
    return wrap(line.lstrip(), WIDTH, initial_indent=begin, subsequent_indent=f"{begin}  ", **whole)


def _table_lines(section: Section) -> Iterator[str]:
    rows = [tuple(heading.rstrip() for heading in section.headings), *section.rows]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    if section.rows and sum(widths) + 2 * len(widths) > WIDTH:
        head, widths = _folded_headings(rows[0], section.rows, widths)
        rows[:1] = head
    forms = [f"{'<' if section.is_words(place) else '>'}{one}" for place, one in enumerate(widths)]
    for row in rows:
        yield "  ".join(f"{cell:{form}}" for cell, form in zip(row, forms, strict=True))


def _folded_headings(
    headings: Sequence[str], rows: Sequence[Sequence[str]], whole: list[int]
) -> tuple[list[tuple[str, ...]], list[int]]:
    """Return headings over as few lines as make the table fit, and the widths; unfolded if none makes it fit."""
    least = [
        max(map(len, (*heading.split(), *cells)))
        for heading, cells in zip(headings, zip(*rows, strict=True), strict=True)
    ]
    for n_lines in range(2, 6):
        widths = [max(one, -(-len(text) // n_lines)) for one, text in zip(least, headings, strict=True)]
        if sum(widths) + 2 * len(widths) <= WIDTH:
            folded = [wrap(heading, width) for heading, width in zip(headings, widths, strict=True)]
            return [*zip_longest(*folded, fillvalue="")], widths
    return [tuple(headings)], whole
