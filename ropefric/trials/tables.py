"""The extraction as three CSV files that a spreadsheet opens."""

import csv
import io
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ropefric.files.digits import significant
from ropefric.files.folder import Folder, as_folder
from ropefric.files.plain_text import to_spreadsheet
from ropefric.trials.result import Extraction

_PROBLEM_COLUMNS = ("severity", "code", "path", "line", "key", "message", "fix")
_NAME_SEPARATOR = "; "
_SETTINGS = frozenset({"wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "dwell_s"})
"""Columns that people set: they stay as they came out of the trial list."""
_RESIDUE = 1e-12
"""What a number in newtons or seconds is that should be zero."""


def write_tables(extraction: Extraction, folder: Folder | str | os.PathLike[str]) -> tuple[Path, ...]:
    """Write trials.csv, conditions.csv and problems.csv; return their paths.

    UTF-8, comma, decimal point, one header line with units in the names, empty cells where there is no number;
    what was measured to nine significant digits, so that the same recordings give the same bytes on every machine.
    Files of these names are replaced.
    """
    problems = [
        {
            "severity": p.severity,
            "code": p.code,
            "path": p.path,
            "line": p.line,
            "key": p.key,
            "message": p.message,
            "fix": p.fix,
        }
        for p in extraction.problems
    ]
    trials = [
        _rounded(trial.to_dict(), known="peak_N" if trial.measures_slack else "end_tension_N")
        for trial in extraction.trials
    ]
    return as_folder(folder).write(
        {
            "trials.csv": _text(trials),
            "conditions.csv": _text([_rounded(condition.to_dict()) for condition in extraction.conditions]),
            "problems.csv": _text(problems, columns=_PROBLEM_COLUMNS),
        }
    )


def _rounded(row: Mapping[str, Any], *, known: str = "") -> dict[str, Any]:
    """Return a row with what was measured to the digits that mean something; the force that was set is `known`."""
    return {
        key: significant(value, smallest=_RESIDUE)
        if isinstance(value, float) and key not in _SETTINGS and key != known
        else value
        for key, value in row.items()
    }


def _text(rows: Sequence[Mapping[str, Any]], columns: Sequence[str] = ()) -> str:
    stream = io.StringIO()
    writer = csv.DictWriter(stream, columns or list(rows[0] if rows else ()), lineterminator="\n")
    writer.writeheader()
    writer.writerows({key: _cell(value) for key, value in row.items()} for row in rows)
    return stream.getvalue()


def _cell(value: Any) -> Any:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        value = _NAME_SEPARATOR.join(value)
    return to_spreadsheet(value) if isinstance(value, str) else value
