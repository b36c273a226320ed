"""The cells of one row as texts and SI numbers."""

import re
from dataclasses import dataclass, field

from ropefric.errors import InputError, Problem
from ropefric.files.plain_text import from_spreadsheet
from ropefric.quantities import parse_quantity
from ropefric.trials.trial_columns import BoundColumn
from ropefric.trials.trial_table import CellTable

NUMBER = re.compile(r"[+-]?(?:\d++(?:[.,]\d*+)?|[.,]\d++)(?:[eE][+-]?\d{1,4})?", re.ASCII)
_GROUPED = re.compile(r"[+-]?\d{1,3}(?:[.,' \u00a0]\d{3})+(?:[.,]\d*+)?")
_WITH_UNIT = re.compile(rf"({NUMBER.pattern})\s*+[A-Za-z°%]++")
POSITIVE = {
    "wheel_radius_m": "a wheel radius",
    "rope_radius_m": "a rope size",
    "wrap_angle_rad": "a wrap angle",
    "end_tension_N": "an end tension",
    "lift_force_N": "a lift force",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One row of the trial list as far as it can be read."""

    line: int
    texts: dict[str, str]
    numbers: dict[str, float]
    problems: list[Problem] = field(default_factory=list)
    unreadable: frozenset[str] = frozenset()


def read_row(
    cells: tuple[str, ...], line: int, columns: dict[str, BoundColumn], path: str, decimal: str
) -> Row:
    """Return a row's cells as texts and SI numbers."""
    texts: dict[str, str] = {}
    numbers: dict[str, float] = {}
    problems: list[Problem] = []
    unreadable: set[str] = set()
    for name, column in columns.items():
        cell = cells[column.index]
        if not column.si_unit:
            texts[name] = from_spreadsheet(cell)
        elif cell:
            try:
                numbers[name] = _number(cell, column, decimal)
            except InputError as error:
                unreadable.add(name)
                problems.append(
                    Problem(
                        code=error.code,
                        message=error.problem.message,
                        path=path,
                        line=line,
                        key=column.header,
                        fix=error.fix,
                    )
                )
    return Row(line=line, texts=texts, numbers=numbers, problems=problems, unreadable=frozenset(unreadable))


def decimal_mark(table: CellTable, columns: dict[str, BoundColumn]) -> str:
    """Return "," where columns are not separated by it and any number has one, else "."."""
    numeric = [column.index for column in columns.values() if column.si_unit]
    if table.separator != "," and any("," in cells[index] for _, cells in table.rows for index in numeric):
        return ","
    return "."


def _number(cell: str, column: BoundColumn, decimal: str) -> float:
    if not NUMBER.fullmatch(cell):
        raise InputError(f"cannot read '{cell[:60]}' as a number", code="RF102", fix=_text_fix(cell, column))
    if decimal == "." and "," in cell:
        raise InputError(
            f"'{cell}' has a decimal comma in a table separated by commas",
            code="RF102",
            fix=f"write {cell.replace(',', '.')}, or separate the columns by ';'",
        )
    if decimal == "," and "." in cell:
        raise InputError(
            f"'{cell}' has a point, but other numbers of the table have decimal commas",
            code="RF102",
            fix=f"write {cell.replace('.', ',')} if the point is a decimal mark, or leave it out",
        )
    value = parse_quantity(f"{cell.replace(',', '.')} {column.unit}", column.si_unit) * column.scale
    # Written so that an overflow to infinity is refused like a zero.
    if column.field in POSITIVE and not 0 < value < 1e30:
        raise InputError(
            f"{cell} {column.unit} is no possible value; {POSITIVE[column.field]} must be above zero",
            code="RF110",
            fix="correct the number",
        )
    if column.field == "dwell_s" and value < 0:
        raise InputError(f"{cell} {column.unit} of dwell is negative", code="RF110", fix="write 0 or more")
    return value


def _text_fix(cell: str, column: BoundColumn) -> str:
    if _GROUPED.fullmatch(cell):
        return "write the number without marks between thousands"
    united = _WITH_UNIT.fullmatch(cell)
    if united:
        return f"write {united[1]}; the unit stands in the header, '{column.header}'"
    return "write a plain number, or leave the cell empty if it is optional"
