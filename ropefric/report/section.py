"""The parts a summary is made of, however it is shown."""

from dataclasses import dataclass

__all__ = ["Section", "Table"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """Cells as text under headings; the first `left` columns, and the last if its heading ends in a space, are words.

    Attributes
    ----------
    headings : tuple of str
        One a column.
    rows : tuple of tuple of str
        As many cells each.
    left : int
        Columns of words at the left.
    """

    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    left: int = 1

    def is_words(self, column: int) -> bool:
        """Return whether a column holds words and not numbers."""
        return column < self.left or self.headings[column].endswith(" ")


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """A heading with lines of text and at most one table between them.

    Attributes
    ----------
    title : str
        The heading; "" for none.
    lines : tuple of str
        Text before the table.
    table : Table, optional
        The table.
    notes : tuple of str
        Text after it, an item each.
    verbatim : bool
        Whether the lines are to be left as they are: arithmetic, not sentences.
    """

    title: str
    lines: tuple[str, ...] = ()
    table: Table | None = None
    notes: tuple[str, ...] = ()
    verbatim: bool = False
