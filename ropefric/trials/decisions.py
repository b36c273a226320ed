"""Decisions of people about trials: decisions.csv beside the list of trials, written by the tool.

A line is a decision. The last one of a trial holds, and replaces all its columns in the list: pick_s,
peak_N, exclude, why and by; a line without a decision takes back the one before. A decision is appended in
one piece: lines in the file, also those that others append meanwhile, are never written again.
"""

from collections.abc import Sequence
from itertools import chain
from pathlib import Path
from typing import NamedTuple

from ropefric.errors import DataError, InputError, Problem
from ropefric.files.disk import append_file, kind_of_file, read_file
from ropefric.files.plain_text import csv_text, to_spreadsheet
from ropefric.trials.campaign_model import TrialSpec
from ropefric.trials.cells import CellTable, Quantity, given_numbers, read_cells

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
    """Put decisions at the end of the file, which said `before`, in one piece, and return the bytes that were added."""
    names = Decision._fields[:-1]
    try:
        head = before.decode("utf-8-sig").split("\n", 1)[0].strip()
    except UnicodeDecodeError:
        head = "no UTF-8 text"
    if before and head != ",".join(names):
        why, fix = f"the file does not begin as ropefric writes it, but with {head[:60]}", ",".join(names)
        fix = f"save it as CSV in UTF-8 with the header {fix}, or move it away"
        raise InputError(why, code="RF108", path=path, fix=fix)
    ended = "\n" if before and not before.endswith(b"\n") else ""
    rows = [[_cell(getattr(one, name)) for name in names] for one in decisions]
    added = (ended + csv_text([*([] if before else [names]), *rows])).encode()
    append_file(path, added, is_new=not before)
    return added


def _cell(value: str | float | None) -> str:
    if isinstance(value, str):
        return to_spreadsheet(" ".join(value.split()))
    return "" if value is None else f"{value:.12g}"


def content_of(path: Path) -> bytes:
    """Return the bytes of the file; none where there is no such file."""
    return read_file(path) if kind_of_file(path) else b""
