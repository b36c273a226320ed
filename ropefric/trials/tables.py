"""The extraction as three CSV files that a spreadsheet opens."""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ropefric.files.plain_text import to_spreadsheet
from ropefric.trials.result import Extraction

__all__ = ["write_tables"]

_PROBLEM_COLUMNS = ("severity", "code", "path", "line", "key", "message", "fix")
_NAME_SEPARATOR = "; "


def write_tables(extraction: Extraction, folder: Path) -> tuple[Path, ...]:
    """Write trials.csv, conditions.csv and problems.csv; return their paths.

    UTF-8, comma, decimal point, one header line with units in the names, empty cells where there is no number; the
    same extraction gives the same bytes. Files of these names are replaced.

    Parameters
    ----------
    extraction : Extraction
        What to write.
    folder : Path
        Made where it is missing.
    """
    folder.mkdir(parents=True, exist_ok=True)
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
    return (
        _write(folder / "trials.csv", [trial.to_dict() for trial in extraction.trials]),
        _write(folder / "conditions.csv", [condition.to_dict() for condition in extraction.conditions]),
        _write(folder / "problems.csv", problems, columns=_PROBLEM_COLUMNS),
    )


def _write(path: Path, rows: Sequence[Mapping[str, Any]], columns: Sequence[str] = ()) -> Path:
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.DictWriter(stream, columns or list(rows[0] if rows else ()), lineterminator="\n")
        writer.writeheader()
        writer.writerows({key: _cell(value) for key, value in row.items()} for row in rows)
    return path


def _cell(value: Any) -> Any:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        value = _NAME_SEPARATOR.join(value)
    return to_spreadsheet(value) if isinstance(value, str) else value
