"""A table in a file: its columns' names and units, and a way to their values."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ropefric.arrays import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Table:
    """One table of a file; one recording."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Callable[[Sequence[int]], list[FloatArray]]
    has_header: bool = True
    sample: str = ""
    first_line: int = 0
    time_s: FloatArray | None = None
