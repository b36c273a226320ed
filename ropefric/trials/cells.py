"""A table about trials as cells: separator found out, columns bound by name and unit, numbers in SI, with lines."""

import csv
import os
import re
from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from difflib import get_close_matches
from functools import lru_cache
from itertools import dropwhile
from math import isnan, nan
from pathlib import Path

from ropefric.errors import DataError, InputError, Problem
from ropefric.files.disk import use_file
from ropefric.files.plain_text import from_spreadsheet, parquet_as_csv
from ropefric.files.text import Source, load_text
from ropefric.quantities import example_unit, in_range, parse_quantity, split_unit_suffix, unit_factor
from ropefric.registry import did_you_mean
from ropefric.traces.readers.excel import READER, sheet_as_csv

STANDARD_GRAVITY_M_S2 = 9.80665
"""Weight per mass [m/s²], CGPM 1901; what turns `end_mass_kg` into a tension."""
SLIP = 0.8
"""Closer than this a strange name is more likely a slip than a column of the user's own."""

_NUMBER = re.compile(r"[+-]?(?:\d++(?:[.,]\d*+)?|[.,]\d++)(?:[eE][+-]?\d{1,4})?", re.ASCII)
POSITIVE = {
    "wheel_radius_m": "a wheel radius",
    "rope_radius_m": "a rope size",
    "wrap_angle_rad": "a wrap angle",
    "end_tension_N": "an end tension",
    "lift_force_N": "a lift force",
}
_BLANK = ",;\t\r\v\f "
"""Characters of empty cells: a spreadsheet writes empty rows as ";;;;"."""

Quantity = tuple[str, str, float]
"""A column: field, SI unit of the written number, and the factor from there to the field."""
SETTINGS: Mapping[str, Quantity] = {
    "wheel_radius": ("wheel_radius_m", "m", 1.0),
    "wheel_diameter": ("wheel_radius_m", "m", 0.5),
    "rope_diameter": ("rope_radius_m", "m", 0.5),
    "rope_radius": ("rope_radius_m", "m", 1.0),
    "wrap_angle": ("wrap_angle_rad", "rad", 1.0),
    "wrap": ("wrap_angle_rad", "rad", 1.0),
    "end_tension": ("end_tension_N", "N", 1.0),
    "end_mass": ("end_tension_N", "kg", STANDARD_GRAVITY_M_S2),
}
"""The settings of a trial, by what a header calls them without its unit."""
QUANTITIES = {
    **SETTINGS,
    "peak": ("peak_N", "N", 1.0),
    "breakaway_force": ("peak_N", "N", 1.0),
    "lift_force": ("peak_N", "N", 1.0),
    "lift_mass": ("peak_N", "kg", STANDARD_GRAVITY_M_S2),
    "peak_std": ("peak_std_N", "N", 1.0),
    "lift_force_std": ("peak_std_N", "N", 1.0),
    "end_tension_std": ("end_tension_std_N", "N", 1.0),
    "wrap_angle_std": ("wrap_std_rad", "rad", 1.0),
    "wrap_std": ("wrap_std_rad", "rad", 1.0),
    "wheel_radius_std": ("wheel_radius_std_m", "m", 1.0),
    "wheel_diameter_std": ("wheel_radius_std_m", "m", 0.5),
    "rope_radius_std": ("rope_radius_std_m", "m", 1.0),
    "rope_diameter_std": ("rope_radius_std_m", "m", 0.5),
    "cell_std": ("cell_std_N", "N", 1.0),
}
"""All numbers of a trial table, likewise."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CellTable:
    """The cells of a table, without blanks around them, each row with its line."""

    path: str
    separator: str = ","
    header: tuple[str, ...]
    header_line: int | None = None
    rows: tuple[tuple[int, tuple[str, ...]], ...] = ()

    def problem(
        self, line: int | None, key: str, code: str, message: str, fix: str, *, warning: bool = False
    ) -> Problem:
        """Return a problem of this table."""
        problem = Problem(code=code, message=message, path=self.path, line=line, key=key, fix=fix)
        return replace(problem, severity="warning") if warning else problem

    def refusal(self, line: int | None, key: str, error: InputError) -> Problem:
        """Return a refused name or number as a problem of this table."""
        message = error.problem.message.removeprefix(f"{key}: ")
        return self.problem(line, key, error.code, message, error.fix)

    def bind(
        self, quantities: Mapping[str, Quantity], texts: Collection[str]
    ) -> tuple[dict[str, "Column"], list[str], list[Problem]]:
        """Return the columns that are known, by field, the names of the others, and the errors of the header.

        Columns whose name is empty or starts with "_" are neither.
        """
        bound: dict[str, Column] = {}
        others: list[str] = []
        problems: list[Problem] = []
        for index, name in enumerate(self.header):
            word = word_of(name)
            if not word or word.startswith("_"):
                continue
            column: Column | None = Column(index=index, header=name, field=word)
            try:
                if word not in texts:
                    column = _quantity_column(index, name, quantities)
            except InputError as error:
                problems.append(self.refusal(self.header_line, name, error))
                continue
            if column is None:
                others.append(name)
            elif column.field in bound:
                message = f"this column says the same as '{bound[column.field].header}'"
                twice = InputError(message, code="RF122", fix="remove one of the two")
                problems.append(self.refusal(self.header_line, name, twice))
            else:
                bound[column.field] = column
        return bound, others, problems

    def near_miss(
        self, name: str, quantities: Mapping[str, Quantity], texts: Collection[str]
    ) -> list[Problem]:
        """Return a warning if a column that is not known has nearly the name of a quantity that is."""
        stem = stem_of(name)
        if not get_close_matches(stem[:80], quantities, n=1, cutoff=SLIP):
            return []
        known = (*texts, *(example_of(stem, quantities) for stem in quantities))
        fix = f"{did_you_mean(name[:80], known)} Otherwise nothing is to be done."
        message = "this column is not known; it is kept, but not used"
        return [self.problem(self.header_line, name, "RF120", message, fix, warning=True)]

    def texts(self, columns: "Columns", cells: Sequence[str]) -> dict[str, str]:
        """Return the texts of a row."""
        return {
            n: from_spreadsheet(cells[column.index]) for n, column in columns.items() if not column.si_unit
        }

    def decimal_mark(self, columns: "Columns") -> str:
        """Return "," where columns are not separated by it and any number has one, else "."."""
        numeric = [column.index for column in columns.values() if column.si_unit]
        if self.separator != "," and any("," in cells[index] for _, cells in self.rows for index in numeric):
            return ","
        return "."

    def numbers(
        self, columns: "Columns", *, empty: Collection[str] = ("",), doubted: Collection[str] = ()
    ) -> tuple["Numbers", dict[int, list[Problem]]]:
        """Return the numbers of the columns in SI, NaN where there is none; and by place what cannot be read in a row.

        In `doubted` columns what cannot be read is none.
        """
        decimal, wrong = self.decimal_mark(columns), defaultdict[int, list[Problem]](list)
        found = {}
        for name, column in columns.items():
            if not column.si_unit:
                continue
            cells = [row[column.index] for _, row in self.rows]
            meaning, refused = dict[str, float](), dict[str, InputError]()
            for cell in set(cells):  # a number of settings is repeated in many rows
                try:
                    meaning[cell] = nan if cell.lower() in empty else read_number(cell, column, decimal)
                except InputError as error:
                    meaning[cell], refused[cell] = nan, error
            found[name] = [meaning[cell] for cell in cells]
            for i, cell in enumerate(cells if refused and name not in doubted else ()):
                if cell in refused:
                    wrong[i].append(self.refusal(self.rows[i][0], column.header, refused[cell]))
        return found, wrong


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """A column of a table and what it means; a text where it has no unit."""

    index: int
    header: str
    field: str
    unit: str = ""
    si_unit: str = ""
    scale: float = 1.0


Columns = Mapping[str, Column]
"""Columns that are known, by field."""
Numbers = dict[str, list[float]]
"""Of such columns."""


def given_numbers(numbers: Numbers, place: int) -> dict[str, float]:
    """Return the numbers of the row at a place, without those that are empty."""
    return {name: values[place] for name, values in numbers.items() if not isnan(values[place])}


def read_cells(path: str | os.PathLike[str]) -> tuple[CellTable, tuple[Problem, ...]]:
    r"""Return the cells of a CSV or Parquet file or of a workbook's first sheet, and the errors of single rows.

    Cells are separated by ";", a tab or ",", whichever the header has first in this order. A line is a row; empty lines
    are left out, and lines above the header that start with "#". Below it such a line is a row: names may begin so.
    """
    shown = Path(path).as_posix()
    text, sheet = _read_text(Path(path), shown)
    lines = _lines_from_header(text)
    if not lines:
        fix = "write a header such as file,wheel_radius_mm,wrap_angle_deg,end_tension_N"
        raise DataError("the table is empty", path=shown, fix=fix)
    header_line, head = lines[0]
    separator = next((mark for mark in (";", "\t") if mark in head), ",")
    quoted = '"' in text
    split = [(number, _split(line, separator, quoted=quoted)) for number, line in lines]
    header = split[0][1]
    if header is None:
        message, fix = "a quoted cell of the header is not closed", "close the quotes"
        raise DataError(message, path=shown, line=header_line, fix=fix)
    good = tuple((n, cells) for n, cells in split[1:] if cells is not None and len(cells) == len(header))
    table = CellTable(path=shown, separator=separator, header=header, header_line=header_line, rows=good)
    notes = (
        [table.problem(header_line, "", "RF141", sheet, "put the table first", warning=True)] if sheet else []
    )
    return table, (*notes, *_torn(table, split))


def _lines_from_header(text: str) -> list[tuple[int, str]]:
    """Return the lines that hold anything, from the first on that is no comment, with their numbers."""
    filled = ((n, line) for n, line in enumerate(text.split("\n"), start=1) if line.strip(_BLANK))
    # A spreadsheet quotes a comment that holds a separator.
    return [*dropwhile(lambda item: item[1].lstrip(_BLANK).lstrip('"').startswith("#"), filled)]


def _read_text(path: Path, shown: str) -> tuple[str, str]:
    """Return the text of a table, and a note on the sheet it is from."""
    try:
        return use_file(path, lambda file: _text(Source(path=path, shown=shown, file=file)), shown=shown)
    except DataError as error:
        if error.code == "RF107":  # a package is missing
            raise
        fix = error.fix if "no such file" in error.problem.message else "save the table as CSV text in UTF-8"
        raise DataError(error.problem.message, path=shown, line=error.problem.line, fix=fix) from None


def _text(source: Source) -> tuple[str, str]:
    if source.path.suffix.lower() in READER.suffixes:
        return sheet_as_csv(source)
    if source.path.suffix.lower() == ".parquet":
        return parquet_as_csv(source.raw_bytes(), source.shown), ""
    return load_text(source).data.decode(), ""


def _split(line: str, separator: str, *, quoted: bool) -> tuple[str, ...] | None:
    cells = line.split(separator)
    if quoted:
        try:
            (cells,) = csv.reader([line], delimiter=separator, skipinitialspace=True, strict=True)
        except csv.Error:
            return None
    return tuple(cell.strip() for cell in cells)


def _torn(table: CellTable, split: Sequence[tuple[int, tuple[str, ...] | None]]) -> Iterator[Problem]:
    """Yield the rows whose quotes are not closed, or that have too few or too many cells."""
    n = len(table.header)
    for line, cells in split:
        if cells is None:
            message = "a quoted cell is not closed on its line, or text follows its end"
            fix = "keep each row on one line and close the quotes"
            yield table.problem(line, "", "RF103", message, fix)
        elif len(cells) != n:
            fix = "write a cell for every column, also an empty one; put comments above the header"
            if len(cells) > n:
                fix = 'put text with separators in "quotes"'
                if table.separator == ",":
                    fix = f"if numbers have a decimal comma, separate the columns by ';'; {fix}"
            message = f"{len(cells)} cells, but the header has {n} columns"
            yield table.problem(line, "", "RF103", message, fix)


def word_of(name: str) -> str:
    """Return a column's name as it is looked up."""
    return "_".join(name.lower().split())


def stem_of(name: str) -> str:
    """Return a column's name without its unit, as it is looked up."""
    return word_of(split_unit_suffix(name)[0])


def example_of(stem: str, quantities: Mapping[str, Quantity]) -> str:
    """Return how a header may call a column."""
    si_unit = quantities[stem][1]
    return f"{stem}_{'turns' if stem == 'wrap' else example_unit(si_unit)}"


def _quantity_column(index: int, name: str, quantities: Mapping[str, Quantity]) -> Column | None:
    stem, unit = split_unit_suffix(name)
    stem = word_of(stem)
    if stem not in quantities:
        return None
    field, si_unit, scale = quantities[stem]
    if not unit:
        fix = f"name it with the unit of its numbers, for example {example_of(stem, quantities)}"
        raise InputError("the column has no unit", code="RF130", fix=fix)
    unit_factor(unit, si_unit, name=name)
    return Column(index=index, header=name, field=field, unit=unit, si_unit=si_unit, scale=scale)


@lru_cache(maxsize=64)
def _factor(unit: str, si_unit: str) -> Decimal:
    return Decimal(repr(unit_factor(unit, si_unit)))


def read_number(cell: str, column: Column, decimal: str) -> float:
    """Return a cell's number in SI, or refuse it."""
    if not _NUMBER.fullmatch(cell):
        fix = "write a plain number without a unit or marks between thousands, or leave the cell empty if it is optional"
        raise InputError(f"cannot read '{cell[:60]}' as a number", code="RF102", fix=fix)
    plain = cell.replace(",", ".")
    if decimal == "." and "," in cell:
        message = f"'{cell}' has a decimal comma in a table separated by commas"
        raise InputError(message, code="RF102", fix=f"write {plain}, or separate the columns by ';'")
    if decimal == "," and "." in cell:
        message = f"'{cell}' has a point, but other numbers of the table have decimal commas"
        fix = f"write {cell.replace('.', ',')} if the point is a decimal mark, or leave it out"
        raise InputError(message, code="RF102", fix=fix)
    factor = _factor(column.unit, column.si_unit)
    # As `parse_quantity`, which takes longer: 9.8 * 0.001 is not 0.0098 in binary.
    value = float(plain) if factor == 1 else float(Decimal(plain) * factor)
    if not value or not in_range(value) or len(plain) > 40:  # it may refuse it
        value = parse_quantity(f"{plain} {column.unit}", column.si_unit)
    value *= column.scale
    written = f"{cell} {column.unit}"
    # Written so that an overflow to infinity is refused like a zero.
    if column.field in POSITIVE and not 0 < value < 1e30:
        message = f"{written} is no possible value; {POSITIVE[column.field]} must be above zero"
        raise InputError(message, code="RF110", fix="correct the number")
    if column.field == "dwell_s" and value < 0:
        raise InputError(f"{written} of dwell is negative", code="RF110", fix="write 0 or more")
    return value
