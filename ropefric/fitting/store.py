"""Fits as files: readable JSON that predicts the same to the last digit, checked on loading, made again to verify."""

import json
import os
from collections.abc import Mapping
from dataclasses import replace
from math import inf, isfinite, isnan, nan
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ropefric import plugins
from ropefric.arrays import FloatArray
from ropefric.errors import PATH, DataError, Kind, RopefricError
from ropefric.files.disk import hash_file, kind_of_file, read_file, refuse_input, refuse_special, write_file
from ropefric.files.plain_text import json_document
from ropefric.fitting.fit import fit_law
from ropefric.fitting.predict import REGRESSORS
from ropefric.fitting.result import ERRORS, SCHEMA, FitResult, FitStatus, FittedParameter
from ropefric.friction.condition import SETTINGS
from ropefric.friction.laws import ALL_LAWS
from ropefric.registry import did_you_mean
from ropefric.trials.table import read_trial_table

MOST_BYTES = 256 * 2**20
"""A fit of a million conditions is smaller."""

_FAMILY, _VERSION = SCHEMA.split("/")
_AGAIN = "fit again: `ropefric fit TRIALS.csv --law NAME --out FIT.json`, or save_fit in Python"
_PARTS = ("input", "settings", "versions")
_ROUNDING = 1e-9
# Settings of earlier versions, without which a fit is made anew today.
_GONE = {"loss", "scale_covar", "clustered"}
# Part of a standard error that another processor's rounding may move an estimate by.
_MOST = 1e-3


def fit_text(fit: FitResult, folder: str | os.PathLike[str] = ".") -> str:
    """Return a fit as the text of a JSON file in a folder; the same fit always gives the same text.

    Keys are sorted, there is no time of writing, and the data file is named relative to the folder.
    """
    tree = fit.to_dict()
    source = tree["provenance"].setdefault("input", {})
    if "sha256" in source and fit.problem is not None:
        # What was loaded from a file is relative to that file already.
        source["path"] = Path(os.path.relpath(source["path"], folder)).as_posix()
    return json_document(tree)


def save_fit(fit: FitResult, path: str | os.PathLike[str], *, overwrite: bool = False) -> Path:
    """Write a fit as JSON of schema `ropefric.fit/1` and return the file's path.

    Parameters
    ----------
    fit : FitResult
        The fit.
    path : path-like
        The file; its folder is made if it is not there. A fit that is there already is replaced.
    overwrite : bool
        Replace any other file too, except the table the fit was made from.

    Raises
    ------
    DataError
        RF105 if the file cannot be written, RF150 if it exists and is no fit, RF151 if it is the fit's table.
    """
    PATH.check(path=path)
    Kind((FitResult,), "a fit").check(fit=fit)
    target = Path(path)
    table = fit.provenance.get("input", {}).get("path")
    check_target(target, Path(str(table)) if table else None, overwrite=overwrite)
    return write_file(target, fit_text(fit, target.parent))


def check_target(path: Path, table: Path | None, *, overwrite: bool = False) -> None:
    """Refuse to store a fit over its own table, or over a file that is no fit."""
    refuse_special(path)
    refuse_input(path, table)
    if not overwrite and path.is_file() and not _is_fit(path):
        text = "the file is there already, and it is no stored fit"
        fix = "choose another name, or replace it with --force (in Python, overwrite=True)"
        raise DataError(text, code="RF150", path=path.as_posix(), fix=fix)


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
    PATH.check(path=path)
    shown = Path(path).as_posix()
    content = read_file(path, shown=shown, limit=MOST_BYTES)
    try:
        tree = json.loads(content, parse_constant=_no_number)
    except UnicodeDecodeError:
        raise DataError("the file is no UTF-8 text", path=shown, fix=_AGAIN) from None
    except ValueError as error:  # also NaN and Infinity, or a whole number of thousands of digits
        what, line = getattr(error, "msg", error), getattr(error, "lineno", None)
        raise DataError(f"the JSON is damaged: {what}", path=shown, line=line, fix=_AGAIN) from None
    except RecursionError:
        raise DataError("the JSON is nested too deep for a fit", path=shown, fix=_AGAIN) from None
    _check_tree(tree, shown)
    try:
        fit = FitResult.from_dict(tree)
        fault = _fault(fit)
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
        fault = f"the field {error} is missing" if isinstance(error, KeyError) else str(error)
    if fault:
        raise DataError(f"the fit is damaged: {fault}", code="RF431", path=shown, fix=_AGAIN) from None
    declared = _declared_by(tree, fit.law)
    if declared is not None and declared[1] not in {one.sha256 for one in plugins.loaded()}:
        text = f"the plugin {declared[0]} has changed since this fit was made: fit again, or use it as it was"
        fit = replace(fit, notes=(text, *fit.notes))
    return fit


def _no_number(word: str) -> None:
    raise ValueError(f"{word} is no number in JSON")


def _check_tree(tree: Any, shown: str) -> None:
    """Refuse a tree of an unknown schema or law."""

    def refuse(message: str, key: str, fix: str) -> DataError:
        return DataError(message, code="RF430", path=shown, key=key, fix=fix)

    schema = tree.get("schema") if isinstance(tree, dict) else None
    family, _, number = str(schema).partition("/")
    if family == _FAMILY and number.isdecimal() and len(number) < 10 and int(number) > int(_VERSION):
        message = f"the schema {schema} is newer than {SCHEMA}, the newest this version of ropefric reads"
        raise refuse(message, "schema", "upgrade ropefric")
    if schema != SCHEMA:
        found = "there is no schema" if schema is None else f"the schema is {str(schema)[:60]!r}"
        message = f"this is no stored fit: {found}, not {SCHEMA!r}"
        raise refuse(message, "schema", "give a file that save_fit or `ropefric fit` wrote")
    law = str(tree.get("law"))
    if law not in ALL_LAWS:
        message, fix = f"the friction law {law[:60]!r} is not known", did_you_mean(law, ALL_LAWS)
        if declared := _declared_by(tree, law):
            file, sha256 = declared
            message = f"the friction law {law[:60]!r} is declared by the plugin {file}"
            message += f" (SHA-256 {sha256:.12}…), which is not loaded"
            fix = f"name it: --plugin {file} (in Python, rf.load_plugin)"
        raise refuse(message, "law", fix)


def _declared_by(tree: Mapping[str, Any], law: str) -> tuple[str, str] | None:
    """Return file and hash of the plugin that declared a law when it was fitted, as the fit's file says."""
    provenance = tree.get("provenance")
    named = provenance.get("plugins") if isinstance(provenance, Mapping) else None
    wanted = {f"LAW {law}", f"LAW {law.removesuffix('-from-zero')}"}
    for one in named if isinstance(named, list) else []:
        if isinstance(one, dict) and wanted.intersection(map(str, one.get("declares") or ())):
            return str(one.get("file")), str(one.get("sha256"))
    return None


def _fault(fit: FitResult) -> str:
    """Return the first part that no fit can have, in words; empty for a sound one.

    A file may be cut, merged or edited by hand, and a prediction from it would look like any other.
    """
    p, names = len(fit.parameters), fit.friction_law.parameter_names
    if fit.covariance.shape != (p, p) or names != tuple(item.name for item in fit.parameters):
        return f"it does not belong to the law {fit.law}, whose parameters are {', '.join(names)}"
    with np.errstate(all="ignore"):
        sound = {
            "parameters": all(_is_sound(fit, item) for item in fit.parameters),
            "covariance": _has_covariance(fit),
            "statistics": _has_statistics(fit),
            "common_errors": _has_common_errors(fit),
            "scatter": _has_scatter(fit),
            "status, advice or provenance": _has_words(fit),
        }
    return next((f"its {name} are none that a fit can have" for name, fine in sound.items() if not fine), "")


def _is_sound(fit: FitResult, item: FittedParameter) -> bool:
    """Return whether a parameter lies within its bounds, has an error, and an interval about it."""
    value, (low, high), slack = item.value, item.ci95, _ROUNDING * abs(item.value)
    known = item.std >= 0.0 or (isnan(item.std) and item.at_bound)
    # An interval from the covariance lies about the estimate, one by profile need not; on a bound there is none.
    around = "intervals" in fit.provenance or low - slack <= value <= high + slack
    none = item.at_bound or (fit.statistics.interval_dof == 0.0 and isnan(low) and isnan(high))
    return (
        isfinite(value) and item.lower <= value <= item.upper and known and (none or (low <= high and around))
    )


def _has_covariance(fit: FitResult) -> bool:
    """Return whether the covariance is one, and the errors of the parameters and in common are its own."""
    covariance, std = fit.covariance, np.sqrt(np.diag(fit.covariance))
    errors = np.array([item.std for item in fit.parameters])
    return bool(
        np.isfinite(covariance).all()
        and np.allclose(covariance, covariance.T, rtol=_ROUNDING, atol=0.0)
        and (np.abs(covariance) <= np.outer(std, std) * (1.0 + _ROUNDING)).all()
        and np.isclose(errors, std, rtol=1e-6, atol=0.0)[np.isfinite(errors)].all()
    )


def _has_common_errors(fit: FitResult) -> bool:
    """Return whether the errors that trials share are numbers, and part of the covariance."""
    p, std = len(fit.parameters), np.sqrt(np.diag(fit.covariance))
    for item in fit.common_errors:
        named = type(item.name) is type(item.unit) is str
        if not (named and 0.0 < item.std < inf and len(item.change) == p and np.isfinite(item.change).all()):
            return False
    return bool((np.sqrt((fit.common_changes**2).sum(axis=1)) <= std * (1.0 + _ROUNDING)).all())


def _has_statistics(fit: FitResult) -> bool:
    """Return whether the counts, sums and ranges are possible."""
    found, ranges = fit.statistics, [fit.validity.get(name, (1.0, 0.0)) for name in REGRESSORS]
    counts = all(isinstance(count, int) for count in (found.n, found.n_conditions, found.dof))
    possible = found.n >= found.n_conditions >= 1 and found.dof <= found.n and 0.0 <= found.chi2 < inf
    negative = any(x < 0.0 for x in (found.scatter_within, found.scatter_between, found.interval_dof))
    return counts and possible and not negative and all(0.0 <= low <= high < inf for low, high in ranges)


def _has_scatter(fit: FitResult) -> bool:
    """Return whether scatter and data of a fit belong together, or it has none."""
    model = fit.scatter
    arrays: tuple[FloatArray, ...] = (model.variance, model.covariance, model.slopes)
    sizes = fit.trials.get("n", ()) if "condition" in fit.trials and model.names else ()
    names = ("condition", "n", "mean_log_lift", *SETTINGS, *model.groups) if sizes else ()
    arrays += tuple(np.array(fit.trials.get(name, (nan,)), np.float64) for name in names)
    known = all(np.isfinite(array).all() for array in arrays) and model.tail_dof > 2.0
    if not known or (np.diag(model.covariance) < 0.0).any():
        return False
    try:
        weighted = fit.weighted()
    except (ValueError, IndexError, KeyError, RopefricError):
        return False
    weight = np.ones(1) if weighted is None else weighted.std if weighted.root is None else weighted.root
    return bool(np.isfinite(weight).all())


def _has_words(fit: FitResult) -> bool:
    """Return whether status, advice and notes are words that belong together, and the provenance a tree."""
    trees = all(isinstance(fit.provenance.get(name, {}), Mapping) for name in _PARTS)
    known = all(isfinite(item.std) for item in fit.parameters) or fit.statistics.interval_dof == 0.0
    fine = known and not any(item.at_bound for item in fit.parameters)
    right = fine if fit.status is FitStatus.OK else bool(fit.advice)
    return trees and right and all(type(text) is str for text in (*fit.advice, *fit.notes))


# ---- stored fits made again from their data ----


class Verification(NamedTuple):
    """Outcome for one stored fit."""

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
        text = "the folder holds no *.json"
        fix = "store one there: `ropefric fit … --out FIT.json`, or save_fit in Python"
        raise DataError(text, path=place, fix=fix)
    return tuple(verify_fit(path) for path in paths)


def verify_fit(path: str | os.PathLike[str]) -> Verification:
    """Return whether one stored fit comes out of its data again.

    The data file is looked up relative to the fit's folder and must have the recorded hash.
    """
    law, ok, difference = "", False, nan
    try:
        stored = load_fit(path)
        law, again = stored.law, _again(stored, Path(path).parent)
    except RopefricError as error:
        message = str(error)
    except Exception as error:  # noqa: BLE001  (one bad file must not hide the others)
        message = f"the fit cannot be made again, its settings or data are damaged: {error}"[:300]
    else:
        difference = _difference(stored, again)
        ok = difference <= _MOST and stored.status == again.status
        message = f"the data give another fit: {difference:.3g} standard errors away, status {again.status}"
        if ok:
            message = f"the data give the fit again, within {difference:.1g} standard errors"
    return Verification(path=Path(path).as_posix(), law=law, ok=ok, difference=difference, message=message)


def _again(stored: FitResult, folder: Path) -> FitResult:
    """Return the fit of the data that a stored one names; refuse data that are not those."""
    source: dict[str, Any] = dict(stored.provenance.get("input", {}))
    path, sha256 = source.get("path"), source.get("sha256")
    if "sha256" not in source:
        text = "the fit names no data file, so it cannot be made again"
        raise DataError(text, code="RF432", fix="fit a CSV trial table and save the result")
    data = folder / str(path)
    if not kind_of_file(data):
        raise DataError("the data file of the fit is not there", code="RF432", path=data, fix="put it back")
    if hash_file(data) != sha256:
        text = "the data file has changed since the fit was made"
        raise DataError(text, code="RF432", path=data, fix="fit again")
    settings = _settings_of(stored)
    return fit_law(read_trial_table(data), stored.law, **settings)


def _settings_of(stored: FitResult) -> dict[str, Any]:
    """Return the settings of a stored fit as `fit_law` takes them, without those of earlier versions."""
    settings = {key: value for key, value in stored.provenance["settings"].items() if key not in _GONE}
    if settings.get("groups") is not None:
        settings["groups"] = tuple(settings["groups"])
    bounds = {name: (_end(low, -inf), _end(high, inf)) for name, (low, high) in settings["bounds"].items()}
    return settings | {"bounds": bounds}


def _end(value: Any, gone: float) -> float:
    """Return an end of bounds, which a file has as nothing where it is infinite."""
    return gone if value is None else float(value)


def _difference(stored: FitResult, again: FitResult) -> float:
    """Return the largest change of a value or, of a fit with errors of today's kind, a standard error, in such."""
    changes = [0.0]
    of_today = stored.provenance.get("versions", {}).get("errors") == ERRORS
    for old, new in zip(stored.parameters, again.parameters, strict=True):
        known = isfinite(old.std) and old.std > 0
        scale = old.std if known else max(abs(old.value), 1e-12)
        changes.append(abs(new.value - old.value) / scale)
        changes.append(abs(new.std - old.std) / scale if known and of_today else 0.0)
    return float(np.max(changes))
