"""What was extracted before and has not changed since.

A stored result is found by the content of the recording, the settings it was extracted with and the code of this
package; time stamps and paths of files do not matter. A damaged entry counts as none.
"""

import hashlib
import json
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import fields
from functools import lru_cache
from pathlib import Path

from pydantic import ConfigDict, TypeAdapter

from ropefric import __version__
from ropefric.errors import DataError
from ropefric.files.read import read_file
from ropefric.files.write import write_file
from ropefric.trials.campaign_model import TrialSpec
from ropefric.trials.result import TrialResult

SCHEMA = "ropefric.extraction-cache/4"
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


Results = tuple[tuple[TrialResult, ...], ...]
"""Of a recording's rows, each with one or more."""


@lru_cache(maxsize=1)
def _entries() -> TypeAdapter[Results]:
    return TypeAdapter(Results, config=ConfigDict(extra="forbid", strict=True, ser_json_inf_nan="constants"))


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
        return self._folder / f"{_hash(key.encode())[:32]}.json"

    def load(self, specs: Sequence[TrialSpec], sha256: str) -> Results | None:
        """Return the stored results of a recording's rows, or None if there are none that can be used."""
        if not sha256:
            return None
        try:
            checksum, _, text = read_file(self._path(specs, sha256)).partition(b"\n")
            # A digit that changed on disk would still be a number.
            if checksum.decode() != _hash(text):
                return None
            found = _entries().validate_json(text)
        # Whatever is wrong with an entry, and with a right checksum too, it can be made again.
        except Exception:  # noqa: BLE001
            return None
        of_rows = len(found) == len(specs) and all(
            row and all(result.file == spec.file for result in row)
            for row, spec in zip(found, specs, strict=True)
        )
        return found if of_rows else None

    def store(self, specs: Sequence[TrialSpec], sha256: str, results: Results) -> None:
        """Keep the results of a recording; a folder that cannot be written is no reason to stop."""
        if sha256:
            text = _entries().dump_json(results)
            with suppress(DataError):
                write_file(self._path(specs, sha256), f"{_hash(text)}\n".encode() + text, durable=False)


def _hash(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
