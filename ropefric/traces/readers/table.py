"""A table in a file: its columns' names and units, and a way to their values."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ropefric.traces.arrays import FloatArray

__all__ = ["Table"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Table:
    """One table of a file; one recording.

    Attributes
    ----------
    names : tuple of str
        Column headers, "" where a column has none.
    units : tuple of str
        Units as the file gives them apart from the header, "" where it does not.
    values : callable
        `values(indices)` returns the columns with these 0-based numbers, float64, NaN where a cell is
        empty; it raises `DataError` RF102 where a cell is no number.
    has_header : bool
        False where the columns have numbers only.
    sample : str
        Name of the table within its file, "" where it is the only one.
    first_line : int
        1-based line of the first row, if row i stands in line `first_line + i`; else 0.
    time_s : ndarray, optional
        Time stamps [s] that come with the table without being a column of it (TDMS waveforms).

    Examples
    --------
    >>> import numpy as np
    >>> table = Table(names=("t",), units=("ms",), values=lambda indices: [np.zeros(3) for _ in indices])
    >>> len(table.values([0])[0])
    3
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Callable[[Sequence[int]], list[FloatArray]]
    has_header: bool = True
    sample: str = ""
    first_line: int = 0
    time_s: FloatArray | None = None
