"""Where the header, the units and the data of a text file start."""

from collections.abc import Sequence
from dataclasses import dataclass

from ropefric.errors import DataError
from ropefric.quantities import SUFFIX_UNITS
from ropefric.traces.readers.cells import CellStyle, split_line
from ropefric.traces.readers.columns import bare_unit
from ropefric.traces.readers.marks import looks_numeric, typical_row
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.source import Source

_MORE_UNITS = {
    "-",
    "1",
    "sec",
    "msec",
    "count",
    "counts",
    "%",
    "°",
    "°C",
    "C",
    "K",
    "l/min",
    "rpm",
    "mm/s",
    "mm/min",
}
_UNITS = {
    *SUFFIX_UNITS,
    *SUFFIX_UNITS.values(),
    *_MORE_UNITS,
    "µm",
    "µs",
    "Nm",
    "mbar",
    "N/mm",
    "N/mm^2",
    "daN",
}
_N_REFERENCE = 20


@dataclass(frozen=True, slots=True, kw_only=True)
class HeadRows:
    """1-based line numbers of header, units (0: none) and first data row."""

    header_row: int
    units_row: int
    data_row: int


def is_unit(cell: str) -> bool:
    """Return whether a cell looks like a unit."""
    return bare_unit(cell) in _UNITS


def find_rows(lines: Sequence[str], separator: str, profile: ImportProfile, source: Source) -> HeadRows:
    """Return where header, units and data of a text file start, see `find_table_rows`."""
    n_head = max(profile.header_row, profile.units_row, profile.data_row, profile.block_names_row, 0)
    last = [split_line(line, separator) for line in lines[-_N_REFERENCE:] if line.strip()]
    reference = _reference(last)
    for n_lines in (n_head + _N_REFERENCE, len(lines)):  # a clean file has its data in line 2
        rows = [split_line(line, separator) for line in lines[:n_lines]]
        found = _search(rows, reference, profile)
        if found is not None:
            return found
    raise _no_data(rows, profile, source)


def find_table_rows(rows: Sequence[Sequence[str]], profile: ImportProfile, source: Source) -> HeadRows:
    """Return where header, units and data start in a table of cell texts.

    What the profile says holds. Left open, the data start at the first row of numbers, and the header is the
    nearest row of words above it, with a row of units allowed between. Rows further up are a preamble.
    """
    reference = _reference(rows[-_N_REFERENCE:])
    found = _search(rows, reference, profile)
    if found is None:
        raise _no_data(rows, profile, source)
    return found


def _reference(rows: Sequence[Sequence[str]]) -> Sequence[str]:
    """Return a row that tells which columns are numbers."""
    return typical_row([row for row in rows if any(looks_numeric(cell) for cell in row)])


def _search(
    rows: Sequence[Sequence[str]], reference: Sequence[str], profile: ImportProfile
) -> HeadRows | None:
    inked = [number for number, row in enumerate(rows, start=1) if any(row)]
    after = max(profile.header_row, profile.units_row, profile.block_names_row, 0)
    if profile.data_row or profile.header_row >= 0:
        first = profile.data_row or after + 1
        data_row = next((number for number in inked if number >= first), 0)
    else:
        data_row = _first_data_row(rows, [number for number in inked if number > after], reference, profile)
    if data_row == 0:
        return None
    header_row, units_row = profile.header_row, profile.units_row
    if header_row == -1:
        header_row, units_row = _words_above(rows, inked, data_row, profile)
    return HeadRows(header_row=header_row, units_row=units_row, data_row=data_row)


def _first_data_row(
    rows: Sequence[Sequence[str]], below: Sequence[int], reference: Sequence[str], profile: ImportProfile
) -> int:
    """Return the first row that holds numbers wherever a typical row does, or nothing but numbers."""
    no_value = CellStyle(missing=profile.missing).no_value
    is_numeric = [looks_numeric(cell) for cell in reference]
    for place, number in enumerate(below):
        row = rows[number - 1]
        hits = [looks_numeric(cell) for cell in row]
        fits = [hit or cell in no_value for hit, cell in zip(hits, row, strict=True)]
        is_typical = len(row) == len(reference) and all(
            fit or not numeric for fit, numeric in zip(fits, is_numeric, strict=True)
        )
        if any(hits) and (all(fits) or is_typical):
            return _include_damaged(rows, below[:place], number)
    return 0


def _include_damaged(rows: Sequence[Sequence[str]], above: Sequence[int], data_row: int) -> int:
    """Return the data row, moved up over half-numeric rows right above it: damaged data that must be told."""
    width = len(rows[data_row - 1])
    for number in reversed(above):
        row = rows[number - 1]
        if len(row) != width or not any(looks_numeric(cell) for cell in row):
            break
        data_row = number
    return data_row


def _words_above(
    rows: Sequence[Sequence[str]], inked: Sequence[int], data_row: int, profile: ImportProfile
) -> tuple[int, int]:
    """Return header and units row: the nearest rows of words above the data that are as wide as a header."""
    width = len(rows[data_row - 1])
    units_row = profile.units_row
    above = [number for number in inked if number < (units_row or data_row)]
    above = [number for number in above if number != profile.block_names_row]
    if not above:
        return 0, units_row
    nearest = above[-1]
    if _is_header(rows[nearest - 1], width):
        if not units_row and len(above) > 1 and _is_header(rows[above[-2] - 1], width):
            cells = [cell for cell in rows[nearest - 1] if cell]
            if all(is_unit(cell) for cell in cells):
                return above[-2], nearest
        return nearest, units_row
    return 0, units_row


def _is_header(row: Sequence[str], width: int) -> bool:
    """Tell names from a preamble: words, and more than one wherever the data have more than one column."""
    words = [cell for cell in row if cell]
    return bool(words) and not any(looks_numeric(cell) for cell in words) and (width == 1 or len(row) > 1)


def _no_data(rows: Sequence[Sequence[str]], profile: ImportProfile, source: Source) -> DataError:
    if profile.data_row:
        last = max((number for number, row in enumerate(rows, start=1) if any(row)), default=0)
        return source.error(
            f"data_row = {profile.data_row}, but the last line with content is {last}",
            key="[import] data_row",
            fix="give the line of the first data row",
        )
    return source.error(
        "there are no data rows: no line below the header holds a number",
        fix="record it again, or set [import] data_row, separator and decimal",
    )
