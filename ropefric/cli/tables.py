"""Tables for people: as wide as their content, headings with units."""

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Table


def number(value: float, form: str = ".4g") -> str:
    """Return a number for a table cell; a dash where there is none."""
    return format(value, form) if math.isfinite(value) else "–"


def make_table(headings: Sequence[str], rows: Iterable[Sequence[str]], *, left: int = 1) -> "Table":
    """Return a table whose first `left` columns (and the last, if its heading ends in a space) hold words."""
    from rich import box  # noqa: PLC0415  (rich costs half the start-up time)
    from rich.table import Table  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False, header_style="bold")
    for place, heading in enumerate(headings):
        words = place < left or heading.endswith(" ")
        table.add_column(Text(heading.rstrip()), justify="left" if words else "right", overflow="fold")
    for row in rows:
        table.add_row(*(Text(cell) for cell in row))  # Text, because file names may look like markup
    return table
