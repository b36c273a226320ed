"""What was extracted before and has not changed since.

A stored result is found by the content of the recording, the settings it was extracted with and the code of this
package; time stamps and paths of files do not matter. A damaged entry counts as none.
"""

import hashlib
import json
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import fields, replace
from functools import lru_cache
from math import isfinite, nan
from pathlib import Path
from typing import Any

import numpy as np

from ropefric import __version__
from ropefric.errors import DataError, Problem
from ropefric.files.read import read_file
from ropefric.files.write import write_file
from ropefric.traces.breakaway import Breakaway, Phase, Status
from ropefric.traces.calibration import Calibration
from ropefric.trials.campaign_model import TrialSpec
from ropefric.trials.result import Outline, TrialResult

SCHEMA = "ropefric.extraction-cache/3"
"""Raise the number when the form of an entry changes."""
MADE_BY = ("errors.py", "quantities.py", "registry.py", "files", "traces", "trials")
"""What a result comes from, beside what is stored with it; a change in any line makes all entries old."""


@lru_cache(maxsize=1)
def hash_sources() -> str:
    """Return the SHA-256 of the code that results are made by; of nothing where it cannot be looked at."""
    package, found = Path(__file__).parents[1], hashlib.sha256()
    for name in MADE_BY:
        place = package / name
        for path in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            with suppress(OSError):
                found.update(path.read_bytes())
    return found.hexdigest()


class ResultCache:
    """Results of recordings in a folder, one small file each."""

    def __init__(self, folder: Path, settings: str) -> None:
        self._folder = folder
        self._made_by = json.dumps([SCHEMA, hash_sources(), __version__, settings])

    @property
    def is_new(self) -> bool:
        """Return whether nothing was ever stored here."""
        return not self._folder.exists()

    def _path(self, specs: Sequence[TrialSpec], sha256: str) -> Path:
        rows = [
            [repr(getattr(spec, f.name)) for f in fields(spec) if f.name not in ("path", "line", "note")]
            for spec in specs
        ]
        key = json.dumps([self._made_by, sha256, rows])
        return self._folder / f"{hashlib.sha256(key.encode()).hexdigest()[:32]}.json"

    def load(self, specs: Sequence[TrialSpec], sha256: str) -> tuple[tuple[TrialResult, ...], ...] | None:
        """Return the stored results of a recording's rows, or None if there are none that can be used."""
        if not sha256:
            return None
        try:
            checksum, _, text = read_file(self._path(specs, sha256)).decode().partition("\n")
            # A digit that changed on disk would still be a number.
            if checksum != _checksum(text):
                return None
            found = tuple(tuple(map(_from_plain, row)) for row in json.loads(text))
        # Whatever is wrong with an entry, and with a right checksum too, it can be made again.
        except Exception:  # noqa: BLE001
            return None
        return found if _fits(found, specs) else None

    def store(
        self, specs: Sequence[TrialSpec], sha256: str, results: Sequence[Sequence[TrialResult]]
    ) -> None:
        """Keep the results of a recording; a folder that cannot be written is no reason to stop."""
        if not sha256:
            return
        path = self._path(specs, sha256)
        text = json.dumps([[_to_plain(one) for one in row] for row in results], separators=(",", ":"))
        try:
            write_file(path, f"{_checksum(text)}\n{text}", durable=False)
        except DataError:
            return


def _checksum(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _fits(found: tuple[tuple[TrialResult, ...], ...], specs: Sequence[TrialSpec]) -> bool:
    """Return whether results are of the kinds they must be, and of these rows."""
    return len(found) == len(specs) and all(
        row and all(_is_sound(result) and result.file == spec.file for result in row)
        for row, spec in zip(found, specs, strict=True)
    )


def _is_sound(result: TrialResult) -> bool:
    things: tuple[Any, ...] = (result, result.breakaway, *result.problems)
    held = [(one.type, getattr(thing, one.name)) for thing in things for one in fields(thing)]
    return all(
        type(value) in (int, float) if kind in (float, "float") else isinstance(value, str)
        for kind, value in held
        if kind in (float, "float", str, "str")
    )


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
        outline=None if outline is None else _outline(outline),
        problems=tuple(Problem(**problem) for problem in entry["problems"]),
        own=tuple((name, cell) for name, cell in entry["own"]),
    )


def _outline(entry: dict[str, Any]) -> Outline:
    outline = Outline(**{name: np.array(values, dtype=np.float64) for name, values in entry.items()})
    if not (
        outline.time_s.shape == outline.low_N.shape == outline.high_N.shape
        and outline.smoothed_time_s.shape == outline.smoothed_N.shape
    ):
        raise ValueError("the curves differ in length")
    return outline


def _numbers(kind: Any, entry: dict[str, Any]) -> Any:
    """Rebuild a dataclass; a number that was not there comes back as NaN."""
    floats = {f.name for f in fields(kind) if f.type in (float, "float")}
    return kind(**{name: nan if value is None and name in floats else value for name, value in entry.items()})
