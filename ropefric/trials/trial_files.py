"""Whether the recordings of a trial list are there, are listed once, and have names of their own."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path, PurePosixPath
from typing import Literal

from ropefric.errors import Problem
from ropefric.files.read import kind_of_file
from ropefric.trials.trial_cells import Row

MISSING_RECORDING = "RF124"
"""Code of the problem that a recording is not there."""

MAX_MISSING = 20
"""Missing recordings that are listed one by one."""


def check_files(rows: Sequence[Row], folder: Path | None, path: str) -> list[Problem]:
    """Return problems of recordings: listed twice, or missing.

    Parts of one recording that do not overlap in time are different trials.
    """
    problems = _listed_twice(rows, path)
    if folder is None:
        return problems
    kinds = {file: kind_of_file(folder / file) for file in dict.fromkeys(map(_file, rows)) if file}
    missing = [row for row in rows if kinds.get(_file(row), "file") in ("", "folder")]
    pipes = [row for row in rows if kinds.get(_file(row)) == "device or pipe"]
    problems += [_pipe(row, path) for row in pipes]
    kept = [row for row in missing if not row.texts.get("exclude")]
    excluded = [row for row in missing if row.texts.get("exclude")]
    return problems + _missing(kept, folder, path, "error") + _missing(excluded, folder, path, "warning")


def _pipe(row: Row, path: str) -> Problem:
    return Problem(
        code=MISSING_RECORDING,
        message=f"the recording {row.texts['file']} is a device or pipe, not a file",
        path=path,
        line=row.line,
        key="file",
        fix="write its content to a file, and name that",
        severity="warning" if row.texts.get("exclude") else "error",
    )


def _missing(
    rows: list[Row], folder: Path, path: str, severity: Literal["error", "warning"]
) -> list[Problem]:
    problems = [
        Problem(
            code=MISSING_RECORDING,
            message=f"the recording {row.texts['file']} is not there",
            path=path,
            line=row.line,
            key="file",
            fix=f"put it into {folder.as_posix()}, or correct the name",
            severity=severity,
        )
        for row in rows[:MAX_MISSING]
    ]
    if len(rows) > MAX_MISSING:
        last = replace(
            problems[-1],
            message=f"{len(rows) - MAX_MISSING} more recordings are not there, {len(rows)} in all",
            line=rows[MAX_MISSING].line,
            fix="check the key 'data' of the campaign file",
        )
        problems.append(last)
    return problems


def _listed_twice(rows: Sequence[Row], path: str) -> list[Problem]:
    by_file: dict[str, list[Row]] = {}
    for row in rows:
        if _file(row):
            by_file.setdefault(_file(row), []).append(row)
    problems = []
    for group in by_file.values():
        # '*' takes every block, so beside it no block is another recording.
        takes_all = any(row.texts.get("sample") == "*" for row in group)
        by_block: dict[str, list[Row]] = {}
        for row in group:
            by_block.setdefault("*" if takes_all else row.texts.get("sample", ""), []).append(row)
        for same in by_block.values():
            problems += _overlaps(same, path, takes_all=takes_all)
    return problems


def _overlaps(rows: list[Row], path: str, *, takes_all: bool) -> list[Problem]:
    ordered = sorted(rows, key=lambda row: (row.numbers.get("start_s", -math.inf), row.line))
    problems, latest = [], None
    for row in ordered:
        stop_s = row.numbers.get("stop_s", math.inf)
        if latest is not None and row.numbers.get("start_s", -math.inf) < latest[0]:
            first, second = sorted((latest[1], row), key=lambda item: item.line)
            sample = second.texts.get("sample", "")
            what = f"block '{sample}' of " if sample else ""
            fix = "remove one row, or give each its own part of the recording with from_s and until_s"
            if takes_all:
                fix = "remove one row; the sample '*' takes every block of the file"
            problems.append(
                Problem(
                    code="RF122",
                    message=f"{what}{second.texts['file']} is listed in line {first.line} already",
                    path=path,
                    line=second.line,
                    key="file",
                    fix=fix,
                )
            )
        if latest is None or stop_s > latest[0]:
            latest = (stop_s, row)
    return problems


def check_names(rows: Sequence[Row], path: str) -> tuple[list[str], list[Problem]]:
    """Return a unique name for every row, and problems of names given twice.

    A row without a name is called after its file, with the block where there is one, and a number where that
    name is taken.
    """
    given = Counter(row.texts["trial"] for row in rows if row.texts.get("trial"))
    first: dict[str, int] = {}
    taken = set(given)
    names, problems = [], []
    for row in rows:
        name = row.texts.get("trial", "")
        if name and name in first:
            problems.append(
                Problem(
                    code="RF122",
                    message=f"the name '{name}' is given in line {first[name]} already",
                    path=path,
                    line=row.line,
                    key="trial",
                    fix="give every trial its own name, or leave the cell empty",
                )
            )
        elif name:
            first[name] = row.line
        else:
            name = _free(_default_name(row), taken)
        names.append(name)
    return names, problems


def _default_name(row: Row) -> str:
    name = PurePosixPath(PurePosixPath(_file(row)).name.removesuffix(".gz")).stem
    sample = row.texts.get("sample", "")
    return f"{name}#{sample}" if sample and sample != "*" else name


def _free(name: str, taken: set[str]) -> str:
    """Return the name, numbered where it is taken, and take it."""
    free, number = name or "trial", 1
    while free in taken:
        number += 1
        free = f"{name or 'trial'}-{number}"
    taken.add(free)
    return free


def _file(row: Row) -> str:
    # Lists written on Windows name folders with backslashes.
    return row.texts.get("file", "").replace("\\", "/")
