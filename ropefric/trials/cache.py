"""What was extracted before and has not changed since.

A stored result is found by the content of the recording, the settings it was extracted with and the version of this
package; time stamps and paths of files do not matter. A damaged entry counts as none.
"""

import hashlib
import json
import os
from collections.abc import Sequence
from dataclasses import fields, replace
from math import isfinite, nan
from pathlib import Path
from typing import Any

import numpy as np

from ropefric import __version__
from ropefric.errors import Problem
from ropefric.traces.breakaway import Breakaway, Phase, Status
from ropefric.traces.calibration import Calibration
from ropefric.trials.result import Outline, TrialResult
from ropefric.trials.trial_spec import TrialSpec

__all__ = ["ResultCache"]

SCHEMA = "ropefric.extraction-cache/2"
"""Raise the number when the form of an entry changes."""
ALGORITHM = 4
"""Raise by one whenever reading, calibrating, tare, smoothing or picking changes any number or status: results of
the same version before and after must not be mixed."""


class ResultCache:
    """Results of recordings in a folder, one small file each.

    Parameters
    ----------
    folder : Path
        Made when the first result is stored.
    settings : str
        Fingerprint of everything a result depends on beside the recording and its rows.

    Examples
    --------
    >>> ResultCache(Path("nowhere"), "settings").load((), "0" * 64) is None
    True
    """

    def __init__(self, folder: Path, settings: str) -> None:
        self._folder = folder
        self._settings = settings

    def _path(self, specs: Sequence[TrialSpec], sha256: str) -> Path:
        rows = [
            [repr(getattr(spec, f.name)) for f in fields(spec) if f.name not in ("path", "line", "note")]
            for spec in specs
        ]
        key = json.dumps([SCHEMA, ALGORITHM, __version__, self._settings, sha256, rows])
        return self._folder / f"{hashlib.sha256(key.encode()).hexdigest()[:32]}.json"

    def load(self, specs: Sequence[TrialSpec], sha256: str) -> tuple[TrialResult, ...] | None:
        """Return the stored results of a recording, or None if there are none that can be used."""
        if not sha256:
            return None
        try:
            checksum, _, text = self._path(specs, sha256).read_text(encoding="utf-8").partition("\n")
            # A digit that changed on disk would still be a number.
            if checksum != _checksum(text):
                return None
            return tuple(_from_plain(entry) for entry in json.loads(text))
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def store(self, specs: Sequence[TrialSpec], sha256: str, results: Sequence[TrialResult]) -> None:
        """Keep the results of a recording; a folder that cannot be written is no reason to stop."""
        if not sha256:
            return
        path = self._path(specs, sha256)
        text = json.dumps([_to_plain(result) for result in results], separators=(",", ":"))
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            # Written aside and renamed: an interrupted run leaves no half entry.
            partial = path.with_suffix(f".{os.getpid()}.part")
            partial.write_text(f"{_checksum(text)}\n{text}", encoding="utf-8", newline="\n")
            partial.replace(path)
        except OSError:
            return


def _checksum(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _to_plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, float) and not isfinite(value):
        return None
    if isinstance(value, TrialResult | Breakaway | Phase | Outline | Problem):
        return {f.name: _to_plain(getattr(value, f.name)) for f in fields(value)}
    if isinstance(value, Calibration):
        return value.to_dict()
    if isinstance(value, tuple):
        return [_to_plain(item) for item in value]
    return value


def _from_plain(entry: dict[str, Any]) -> TrialResult:
    outline, calibration = entry["outline"], entry["calibration"]
    breakaway = _numbers(Breakaway, entry["breakaway"])
    result: TrialResult = _numbers(TrialResult, entry)
    return replace(
        result,
        breakaway=replace(
            breakaway,
            status=Status(breakaway.status),
            phases=tuple(Phase(**phase) for phase in entry["breakaway"]["phases"]),
            notes=tuple(entry["breakaway"]["notes"]),
        ),
        calibration=None if calibration is None else Calibration.from_dict(calibration),
        outline=None if outline is None else Outline(**{k: np.array(v) for k, v in outline.items()}),
        problems=tuple(Problem(**problem) for problem in entry["problems"]),
        own=tuple((name, cell) for name, cell in entry["own"]),
    )


def _numbers(kind: Any, entry: dict[str, Any]) -> Any:
    """Rebuild a dataclass; a number that was not there comes back as NaN."""
    floats = {f.name for f in fields(kind) if f.type in (float, "float")}
    return kind(**{name: nan if value is None and name in floats else value for name, value in entry.items()})
