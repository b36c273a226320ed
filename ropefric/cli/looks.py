"""The looks of a recording file, told to people."""

from collections.abc import Sequence
from itertools import accumulate
from typing import TYPE_CHECKING

from ropefric.cli.tables import make_table, number

if TYPE_CHECKING:
    from rich.console import Console

    from ropefric.traces.readers.inspection import ColumnSummary, Inspection


_MARKS = {"\t": "tab", " ": "space", ",": "comma", ";": "semicolon", ".": "point", "|": "bar"}


def show_inspection(found: "Inspection", console: "Console") -> None:
    """Print what was found out about a file: how it is written, its columns, its first rows, what to check."""
    console.print(_headline(found), markup=False, soft_wrap=True)
    console.print()
    headings = ("no.", "column ", "unit ", "from", "to", "missing", "holds ")
    rows = [_column_row(found, column) for column in found.columns]
    console.print(make_table(*_without_empty_columns(headings, rows), left=0))
    if found.first_rows:
        _show_first_rows(found, console)
    if found.doubts:
        console.print("\nplease check:\n", style="bold yellow")
        for doubt in found.doubts:
            console.print(f"- {doubt}", markup=False, soft_wrap=True)


def _show_first_rows(found: "Inspection", console: "Console") -> None:
    console.print("\nfirst rows:\n", style="bold")
    names = [column.name or f"({column.number})" for column in found.columns]
    rows = [_padded(row, len(names)) for row in found.first_rows]
    widths = [max(map(len, cells)) + 3 for cells in zip(names, *rows, strict=True)]
    fitting = sum(total <= console.width for total in accumulate(widths))
    console.print(make_table(names[:fitting], [row[:fitting] for row in rows], left=0))
    hidden = max(len(row) for row in found.first_rows) - fitting
    if hidden > 0:
        console.print(f"({hidden} more columns)")


def _without_empty_columns(
    headings: Sequence[str], rows: Sequence[Sequence[str]]
) -> tuple[list[str], list[list[str]]]:
    shown = [place for place in range(len(headings)) if any(row[place] for row in rows)]
    return [headings[place] for place in shown], [[row[place] for place in shown] for row in rows]


def _headline(found: "Inspection") -> str:
    rows = f"{found.n_rows} rows"
    if found.n_rows_about:
        rows = f"at least {found.n_rows} rows, perhaps {found.n_rows_about:.2g}"
    facts = [found.format, rows]
    if found.samples:
        names = ", ".join(found.samples[:12]) + (" …" if len(found.samples) > 12 else "")
        facts.append(f"{len(found.samples)} recordings side by side ({names})")
    if found.separator:
        facts.append(f"separator {_MARKS.get(found.separator, found.separator)}")
    if found.decimal:
        facts.append(f"decimal {_MARKS.get(found.decimal, found.decimal)}")
    if found.encoding:
        facts.append(found.encoding)
    if found.header_row:
        facts.append(f"header in line {found.header_row}")
    if found.sampling_rate_Hz is not None:
        steps = "uniform" if found.is_uniform else "not uniform"
        facts.append(f"{number(found.sampling_rate_Hz, '.5g')} Hz, {steps}")
    return f"{found.file}: {', '.join(facts)}"


def _column_row(found: "Inspection", column: "ColumnSummary") -> tuple[str, ...]:
    holds = "whole numbers" if column.is_integer else "numbers" if column.is_numeric else "text"
    if column.name in found.saturation:
        holds += ", at a converter's limit"
    limits = ("" if limit is None else number(limit, ".6g") for limit in (column.minimum, column.maximum))
    return str(column.number), column.name, column.unit, *limits, str(column.n_missing or ""), holds


def _padded(row: tuple[str, ...], n: int) -> list[str]:
    return [*row[:n], *[""] * (n - len(row))]
