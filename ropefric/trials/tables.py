"""The extraction as three CSV files that a spreadsheet opens."""

import csv
import io
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ropefric.files.folder import Folder, as_folder
from ropefric.trials.result import Extraction

__all__ = ["write_tables"]

_PROBLEM_COLUMNS = ("severity", "code", "path", "line", "key", "message", "fix")
_NAME_SEPARATOR = "; "


def write_tables(extraction: Extraction, folder: Folder | str | os.PathLike[str]) -> tuple[Path, ...]:
    """Write trials.csv, conditions.csv and problems.csv; return their paths.

    UTF-8, comma, decimal point, one header line with units in the names, empty cells where there is no number; the
    same extraction gives the same bytes. Files of these names are replaced.

    Parameters
    ----------
    extraction : Extraction
        What to write.
    folder : Folder or path-like
        Made where it is missing.
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
    return as_folder(folder).write(
        {
            "trials.csv": _text([trial.to_dict() for trial in extraction.trials]),
            "conditions.csv": _text([condition.to_dict() for condition in extraction.conditions]),
            "problems.csv": _text(problems, columns=_PROBLEM_COLUMNS),
        }
    )


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
    return _NAME_SEPARATOR.join(value) if isinstance(value, list) else value
