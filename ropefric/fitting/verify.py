"""Stored fits made again from their data, and compared."""

import os
from dataclasses import dataclass
from math import inf, isfinite, nan
from pathlib import Path
from typing import Any

import numpy as np

from ropefric.errors import DataError, RopefricError
from ropefric.files.read import hash_file, kind_of_file
from ropefric.fitting.fit import fit_law
from ropefric.fitting.result import FitResult
from ropefric.fitting.settings import FitSettings, check_settings
from ropefric.fitting.store import load_fit
from ropefric.trials.table import read_trial_table

# Part of a standard error that another processor's rounding may move an estimate by.
_MOST = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class Verification:
    """What became of one stored fit."""

    path: str
    law: str
    ok: bool
    difference: float
    message: str


def verify_fits(folder: str | os.PathLike[str]) -> tuple[Verification, ...]:
    """Return, for every `*.json` of a folder by name, whether the fit comes out of its data again."""
    place = Path(folder)
    if not place.is_dir():
        raise DataError("there is no such folder", path=place, fix="give the folder of the stored fits")
    paths = sorted(place.glob("*.json"))
    if not paths:
        raise DataError(
            "the folder holds no *.json",
            path=place,
            fix="store one there: `ropefric fit … --out FIT.json`, or save_fit in Python",
        )
    return tuple(verify_fit(path) for path in paths)


def verify_fit(path: str | os.PathLike[str]) -> Verification:
    """Return whether one stored fit comes out of its data again.

    The data file is looked up relative to the fit's folder and must have the recorded hash.
    """
    shown = Path(path).as_posix()
    law = ""
    try:
        stored = load_fit(path)
        law = stored.law
        again = _again(stored, Path(path).parent)
    except RopefricError as error:
        return Verification(path=shown, law=law, ok=False, difference=nan, message=str(error))
    except Exception as error:  # noqa: BLE001  (whatever is wrong with one file, the others are to be told of)
        message = f"the fit cannot be made again: {type(error).__name__}: {error}"
        return Verification(path=shown, law=law, ok=False, difference=nan, message=message[:300])
    difference = _difference(stored, again)
    ok = difference <= _MOST and stored.status == again.status
    message = f"the data give the fit again, within {difference:.1g} standard errors"
    if not ok:
        message = f"the data give another fit: {difference:.3g} standard errors away, status {again.status}"
    return Verification(path=shown, law=law, ok=ok, difference=difference, message=message)


def _again(stored: FitResult, folder: Path) -> FitResult:
    source: dict[str, Any] = dict(stored.provenance.get("input", {}))
    if "sha256" not in source:
        raise DataError(
            "the fit names no data file, so it cannot be made again",
            code="RF432",
            fix="fit a CSV trial table and save the result",
        )
    path = source.get("path")
    if not isinstance(path, str) or not isinstance(source["sha256"], str):
        raise _damaged("provenance.input")
    data = folder / path
    if not kind_of_file(data):
        raise DataError("the data file of the fit is not there", code="RF432", path=data, fix="put it back")
    if hash_file(data) != source["sha256"]:
        raise DataError(
            "the data file has changed since the fit was made", code="RF432", path=data, fix="fit again"
        )
    return fit_law(read_trial_table(data), stored.law, **_settings(stored))


def _settings(stored: FitResult) -> dict[str, Any]:
    """Return the arguments of `fit_law` as they were, from a file that anybody may have edited."""
    try:
        settings = dict(stored.provenance["settings"])
        for key in ("fixed", "start"):
            settings[key] = {name: float(value) for name, value in settings[key].items()}
        settings["bounds"] = {
            name: (-inf if low is None else float(low), inf if high is None else float(high))
            for name, (low, high) in settings["bounds"].items()
        }
        check_settings(FitSettings(**settings), stored.friction_law)
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
        if isinstance(error, RopefricError):
            raise
        raise _damaged("provenance.settings") from None
    return settings


def _damaged(key: str) -> DataError:
    return DataError(
        "the field is damaged, so the fit cannot be made again", code="RF431", key=key, fix="fit again"
    )


def _difference(stored: FitResult, again: FitResult) -> float:
    """Return the largest change of a value or a standard error, in standard errors."""
    changes = []
    for old, new in zip(stored.parameters, again.parameters, strict=True):
        scale = old.std if isfinite(old.std) and old.std > 0 else max(abs(old.value), 1e-12)
        changes.append(abs(new.value - old.value) / scale)
        if isfinite(old.std) and old.std > 0:
            changes.append(abs(new.std - old.std) / scale)
    return float(np.max(changes, initial=0.0))
