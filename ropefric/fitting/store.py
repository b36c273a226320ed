"""Fits as files: readable JSON that loads in a clean process and predicts the same to the last digit."""

import json
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

from ropefric.errors import DataError
from ropefric.files.plain_text import json_document
from ropefric.files.read import read_file
from ropefric.files.write import refuse_input, refuse_special, write_file
from ropefric.fitting.result import SCHEMA, FitResult
from ropefric.fitting.soundness import faults
from ropefric.friction.laws import ALL_LAWS
from ropefric.registry import did_you_mean

MOST_BYTES = 256 * 2**20
"""A fit of a million conditions is smaller."""

_FAMILY, _VERSION = SCHEMA.split("/")
_FIELDS = {
    "parameters": dict,
    "parameter_order": list,
    "covariance": list,
    "covariance_kind": str,
    "statistics": dict,
    "status": str,
    "advice": list,
    "notes": list,
    "identifiability": dict,
    "validity": dict,
    "provenance": dict,
    "trials": dict,
}
_AGAIN = "fit again: `ropefric fit TRIALS.csv --law NAME --out FIT.json`, or save_fit in Python"


def fit_text(fit: FitResult, folder: str | os.PathLike[str] = ".") -> str:
    """Return a fit as the text of a JSON file in a folder; the same fit always gives the same text.

    Keys are sorted, there is no time of writing, and the data file is named relative to the folder.
    """
    provenance = dict(fit.provenance)
    source = dict(provenance.get("input", {}))
    if "sha256" in source and fit.problem is not None:
        # What was loaded from a file is relative to that file already.
        source["path"] = Path(os.path.relpath(source["path"], folder)).as_posix()
    tree = replace(fit, provenance=provenance | {"input": source}).to_dict()
    return json_document(tree)


def save_fit(fit: FitResult, path: str | os.PathLike[str], *, overwrite: bool = False) -> Path:
    """Write a fit as JSON of schema `ropefric.fit/1` and return the file's path.

    Parameters
    ----------
    fit : FitResult
        The fit.
    path : path-like
        The file; its folder is made if it is not there. A fit that stands there is replaced.
    overwrite : bool
        Replace any other file too, except the table the fit was made from.

    Raises
    ------
    DataError
        RF105 if the file cannot be written, RF150 if another than a fit stands there, RF151 if it is the fit's table.
    """
    target = Path(path)
    table = fit.provenance.get("input", {}).get("path")
    check_target(target, Path(str(table)) if table else None, overwrite=overwrite)
    return write_file(target, fit_text(fit, target.parent))


def check_target(path: Path, table: Path | None, *, overwrite: bool = False) -> None:
    """Refuse a place where a fit must not be stored: its own table, or what is there and is no fit."""
    refuse_special(path)
    refuse_input(path, table)
    if not overwrite and path.is_file() and not _is_fit(path):
        raise DataError(
            "the file is there already, and it is no stored fit",
            code="RF150",
            path=path.as_posix(),
            fix="choose another name, or replace it with --force (in Python, overwrite=True)",
        )


def _is_fit(path: Path) -> bool:
    try:
        tree = json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError):
        return False
    return isinstance(tree, dict) and str(tree.get("schema", "")).partition("/")[0] == _FAMILY


def load_fit(path: str | os.PathLike[str]) -> FitResult:
    """Return a fit from its file; it predicts what the fit that was saved predicts.

    Raises
    ------
    DataError
        RF101 if there is no such file or it is no JSON; RF430 if its schema is unknown or newer, RF431 if a field
        is missing or damaged.

    Examples
    --------
    >>> import tempfile
    >>> import numpy as np
    >>> from ropefric.fitting.fit import fit_law
    >>> from ropefric.trials.table import TrialTable
    >>> table = TrialTable(
    ...     trial=("a", "b", "c"), wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=[3, 6, 9],
    ...     end_tension_N=20, peak_N=[36.6, 66.1, 121.7],
    ... )
    >>> fit = fit_law(table, "constant")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     loaded = load_fit(save_fit(fit, Path(folder, "constant.json")))
    >>> bool(loaded["mu"] == fit["mu"])
    True
    """
    shown = Path(path).as_posix()
    content = read_file(path, shown=shown, limit=MOST_BYTES)
    try:
        tree = json.loads(content, parse_constant=_no_number)
    except UnicodeDecodeError:
        raise DataError("the file is no UTF-8 text", path=shown, fix=_AGAIN) from None
    except json.JSONDecodeError as error:
        raise DataError(
            f"the JSON is damaged: {error.msg}", path=shown, line=error.lineno, fix=_AGAIN
        ) from None
    except ValueError as error:  # NaN and Infinity, or a whole number of thousands of digits
        raise DataError(f"the JSON is damaged: {error}", path=shown, fix=_AGAIN) from None
    except RecursionError:
        raise DataError("the JSON is nested too deep for a fit", path=shown, fix=_AGAIN) from None
    _check_schema(tree, shown)
    _check_fields(tree, shown)
    try:
        fit = FitResult.from_dict(tree)
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
        what = f"the field {error} is missing" if isinstance(error, KeyError) else str(error)
        raise DataError(f"the fit is damaged: {what}", code="RF431", path=shown, fix=_AGAIN) from None
    p = len(fit.parameters)
    if fit.covariance.shape != (p, p) or fit.friction_law.parameter_names != tuple(
        item.name for item in fit.parameters
    ):
        names = ", ".join(fit.friction_law.parameter_names)
        raise DataError(
            f"the fit does not belong to the law {fit.law}, whose parameters are {names}",
            code="RF431",
            path=shown,
            fix=_AGAIN,
        )
    for fault in faults(fit):
        raise DataError(f"the fit is damaged: {fault}", code="RF431", path=shown, fix=_AGAIN)
    return fit


def _no_number(word: str) -> None:
    raise ValueError(f"{word} is no number in JSON")


def _check_schema(tree: Any, shown: str) -> None:
    schema = tree.get("schema") if isinstance(tree, dict) else None
    if schema == SCHEMA:
        return
    family, _, number = str(schema).partition("/")
    if family == _FAMILY and number.isdecimal() and len(number) < 10 and int(number) > int(_VERSION):
        raise DataError(
            f"the schema {schema} is newer than {SCHEMA}, the newest this version of ropefric reads",
            code="RF430",
            path=shown,
            key="schema",
            fix="upgrade ropefric",
        )
    found = "there is no schema" if schema is None else f"the schema is {str(schema)[:60]!r}"
    raise DataError(
        f"this is no stored fit: {found}, not {SCHEMA!r}",
        code="RF430",
        path=shown,
        key="schema",
        fix="give a file that save_fit or `ropefric fit` wrote",
    )


def _check_fields(tree: dict[str, Any], shown: str) -> None:
    law = tree.get("law")
    if not isinstance(law, str) or law not in ALL_LAWS:
        raise DataError(
            f"the friction law {str(law)[:60]!r} is not known",
            code="RF430",
            path=shown,
            key="law",
            fix=did_you_mean(str(law), ALL_LAWS),
        )
    for name, kind in _FIELDS.items():
        if name not in tree:
            raise DataError("the field is missing", code="RF431", path=shown, key=name, fix=_AGAIN)
        if not isinstance(tree[name], kind):
            message = f"the field is no {_KINDS[kind]}"
            raise DataError(message, code="RF431", path=shown, key=name, fix=_AGAIN)


_KINDS = {dict: "object", list: "list", str: "text"}
