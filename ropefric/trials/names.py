"""A list of trials from the names of the recordings: what a pattern finds in each name becomes the columns."""

import csv
import glob
import io
import os
import re
from collections.abc import Mapping
from pathlib import Path, PurePath

from ropefric.errors import DataError, InputError, data_error
from ropefric.files.plain_text import to_spreadsheet
from ropefric.glossary import counted
from ropefric.trials.cells import CellTable
from ropefric.trials.trial_list import QUANTITIES, TEXTS

_DIGITS, _WILD = re.compile(r"([0-9]+)"), re.compile(r"[*?\[]")
_GROUP = re.compile(r"\{(\w+)\}")
_NUMBER = r"[+-]?\d+(?:[.,]\d+)?"
_NEEDED = {
    "wheel_radius_m": "wheel_radius_mm",
    "wrap_angle_rad": "wrap_angle_deg",
    "end_tension_N": "end_tension_N",
}
_SHOWN = 3


def list_from_names(files: str, pattern: str, folder: Path) -> tuple[bytes, str]:
    """Return a list of trials of the files that a glob pattern finds, and what to tell of names that do not match.

    In the pattern of names, `{wrap_angle_deg}` stands for a number or, where a column of that name holds text, for
    words; `*` stands for anything. A pattern with `(?P<name>...)` is a regular expression. Names of groups are headers
    of the list, with their units. Without "/" it is compared with the file's name, with or without its ending.
    """
    paths = glob.glob(files, recursive=True)  # noqa: PTH207  (whole paths too, which Path.glob refuses)
    found = sorted((path for path in paths if Path(path).is_file()), key=_natural)
    if not found:
        raise DataError("no file matches", path=files, fix=_what_is_there(files))
    rows: list[Mapping[str, str]] = []
    missed, compiled = [], _compiled(pattern)
    for path in found:
        match = _match(compiled, pattern, path) if compiled else None
        if match is None and compiled:
            missed.append(path)
        else:
            rows.append({"file": Path(os.path.relpath(path, folder)).as_posix(), **(match or {})})
    if not rows:
        why = f"none of {counted(len(found), 'name')} matches the pattern {pattern!r}; the first is {found[0]!r}"
        fix = (
            'write what changes from name to name as {header}, such as "{wheel}_{wrap_angle_deg}deg_{repeat}"'
        )
        raise InputError(why, key="--pattern", fix=f"{fix}; * stands for anything")
    names = list(rows[0])
    header = CellTable(path="--pattern", separator=",", header=tuple(names), header_line=None, rows=())
    columns, _, problems = header.bind(QUANTITIES, TEXTS)
    if problems:
        raise data_error(problems)
    known = columns.keys() | ({"wheel_radius_m"} if "wheel" in columns else set())
    known |= {"end_tension_N"} if "lift_force_N" in columns else set()
    names += [name for field, name in _NEEDED.items() if field not in known]
    numbers = {column.header for column in columns.values() if column.si_unit}
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(names)
    for row in rows:
        cells = {name: cell.replace(",", ".") if name in numbers else cell for name, cell in row.items()}
        writer.writerow([to_spreadsheet(cells.get(name, "")) for name in names])
    shown = f"{', '.join(missed[:_SHOWN])}{', …' if len(missed) > _SHOWN else ''}"
    told = (
        f"{len(missed)} of {len(found)} names do not match the pattern and are left out: {shown}"
        if missed
        else ""
    )
    return stream.getvalue().encode(), told


def _natural(path: str) -> tuple[list[tuple[int, str]], str]:
    return [(int(part), "") if part.isdigit() else (-1, part) for part in _DIGITS.split(path)], path


def _what_is_there(files: str) -> str:
    """Return what the folder holds that a glob pattern names."""
    folder = Path(_WILD.split(files)[0])
    folder = folder if folder.is_dir() else folder.parent
    names = sorted(path.name for path in folder.iterdir() if path.is_file()) if folder.is_dir() else []
    there = f"{folder.as_posix()} holds {counted(len(names), 'file')}"
    return (
        f"{there}, such as {', '.join(names[:_SHOWN])}"
        if names
        else f"{there}; quote the pattern, 'daq/*.csv'"
    )


def _compiled(pattern: str) -> re.Pattern[str] | None:
    text = pattern
    if "(?P<" not in pattern:
        parts = _GROUP.split(pattern)
        text = "".join(
            f"(?P<{part}>{_of_column(part)})" if place % 2 else re.escape(part).replace(r"\*", ".*?")
            for place, part in enumerate(parts)
        )
    try:
        found = re.compile(text)
    except re.error as error:
        fix = "each {name} is a word and stands once"
        raise InputError(f"{pattern!r} is no pattern: {error}", key="--pattern", fix=fix) from None
    if pattern and not found.groupindex:
        fix = 'write what changes as {header}, such as "{wheel}_{wrap_angle_deg}deg_{repeat}"'
        raise InputError(f"the pattern {pattern!r} names no column", key="--pattern", fix=fix)
    return found if pattern else None


def _of_column(name: str) -> str:
    table = CellTable(path="", separator=",", header=(name,), header_line=None, rows=())
    columns, _, _ = table.bind(QUANTITIES, TEXTS)
    return _NUMBER if any(column.si_unit for column in columns.values()) else ".+?"


def _match(compiled: re.Pattern[str], pattern: str, path: str) -> dict[str, str] | None:
    whole = "/".join(PurePath(path).parts[-1 - pattern.count("/") :])
    bare = whole.removesuffix(".gz")
    for name in (bare.removesuffix(PurePath(bare).suffix), whole):
        if found := compiled.fullmatch(name):
            return {key: value.strip() for key, value in found.groupdict(default="").items()}
    return None
