"""The parts a summary is made of, however it is shown."""

from dataclasses import dataclass


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

    title: str
    lines: tuple[str, ...] = ()
    table: Table | None = None
    notes: tuple[str, ...] = ()
    verbatim: bool = False
