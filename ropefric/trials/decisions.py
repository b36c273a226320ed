"""Decisions of people about trials: decisions.csv beside the list of trials, written by the tool.

A line is a decision. The last one of a trial holds, and replaces all its columns in the list: pick_s,
peak_N, exclude, why and by; a line without a decision takes back the one before. A decision is appended in
one piece: lines in the file, also those that others append meanwhile, are never written again.
"""

from collections.abc import Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import NamedTuple

from ropefric.errors import DataError, InputError, Problem
from ropefric.files.disk import append_file, kind_of_file, read_file
from ropefric.files.plain_text import csv_text, to_spreadsheet
from ropefric.quantities import unit_factor
from ropefric.trials.campaign_model import TrialSpec
from ropefric.trials.cells import CellTable, Column, Quantity, given_numbers, read_cells

_NUMBERS: dict[str, Quantity] = {"pick": ("pick_s", "s", 1.0), "peak": ("peak_N", "N", 1.0)}
_TEXTS = ("trial", "exclude", "why", "by", "when", "file")
_NEEDED = ("trial", "pick_s", "peak_N", "exclude", "why", "by", "when")


class Decision(NamedTuple):
    """The decision on a trial: F_A is reached at `pick_s`, or is `peak_N`, or the trial is excluded; or none.

    `file` is the recording it is about, "" for the one that the list names; `line` is its line.
    """

    trial: str
    pick_s: float | None = None
    peak_N: float | None = None
    exclude: str = ""
    why: str = ""
    by: str = ""
    when: str = ""
    file: str = ""
    line: int = 0

    @property
    def is_empty(self) -> bool:
        """Return whether it takes back what was decided before."""
        return self.pick_s is None and self.peak_N is None and not (self.exclude or self.why)


def decision_of(spec: TrialSpec) -> Decision:
    """Return the current decision on a trial, from the list or from decisions.csv."""
    return Decision(*(getattr(spec, name) for name in Decision._fields[:-1]))


def read_decisions(path: Path) -> tuple[dict[str, Decision], CellTable, tuple[Problem, ...]]:
    """Return the decision that holds for each trial, their table, and its errors; none without a file."""
    if not kind_of_file(path):
        return {}, CellTable(path=path.as_posix(), header=Decision._fields[:-1]), ()
    try:
        table, torn = read_cells(path)
    except DataError as error:
        return {}, CellTable(path=path.as_posix(), header=()), error.problems
    columns, _, refused = table.bind(_NUMBERS, _TEXTS)
    missing = [name for name in _NEEDED if name not in columns]
    problems = [*torn, *refused]
    if missing and not refused:
        fix = f"head the table {','.join(Decision._fields[:-1])}, or remove it: then nothing is decided"
        message = f"there is no column {', '.join(missing)}"
        problems.append(table.problem(table.header_line, missing[0], "RF121", message, fix))
    if problems:
        return {}, table, tuple(problems)
    numbers, wrong = table.numbers(columns)
    made = (
        Decision(line=line, **table.texts(columns, cells), **given_numbers(numbers, place))  # type: ignore[arg-type]
        for place, (line, cells) in enumerate(table.rows)
    )
    return {one.trial: one for one in made}, table, tuple(chain(*wrong.values()))


def add_decisions(path: Path, decisions: Sequence[Decision], before: bytes) -> bytes:
    """Put decisions at the end of the file, which said `before`, in one piece, and return the bytes that were added.

    They are written with the columns, separator and decimal mark that stand there.
    """
    _, table, problems = read_decisions(path)
    problem = next((one for one in problems if one.severity == "error"), None)
    if problem is not None:
        raise DataError(problem.message, code=problem.code, path=path, line=problem.line, fix=problem.fix)
    try:
        before.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(
            "the file is no UTF-8 text", code="RF108", path=path, fix="save it as UTF-8"
        ) from None
    head = [] if before else [table.header]
    ended = "\n" if before and not before.endswith(b"\n") else ""
    columns, _, _ = table.bind(_NUMBERS, _TEXTS)
    mark = table.decimal_mark(columns)
    rows = [_row(columns, mark, len(table.header), one) for one in decisions]
    added = (ended + csv_text([*head, *rows], separator=table.separator)).encode()
    append_file(path, added, is_new=not before)
    return added


def _row(columns: Mapping[str, Column], decimal_mark: str, width: int, decision: Decision) -> list[str]:
    """Return the line of a decision, with the columns and the decimal mark of a table of this many columns."""
    row = [""] * width
    for name, column in columns.items():
        value = getattr(decision, name)
        if isinstance(value, str):
            row[column.index] = to_spreadsheet(" ".join(value.split()))
        elif value is not None:
            number = value / unit_factor(column.unit, column.si_unit)
            row[column.index] = f"{number:.12g}".replace(".", decimal_mark)
    return row


def content_of(path: Path) -> bytes:
    """Return the bytes of the file; none where there is no such file."""
    return read_file(path) if kind_of_file(path) else b""
