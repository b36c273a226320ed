"""Where a campaign's result comes from: inputs with their hashes, versions, seeds, settings, and the command."""

import json
import os
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

from ropefric.errors import DataError
from ropefric.files.plain_text import json_document
from ropefric.files.read import hash_file, read_file
from ropefric.pipeline.evidence import Evidence
from ropefric.pipeline.run import CampaignRun

SCHEMA = "ropefric.run/1"
MOST_BYTES = 256 * 2**20
"""The manifest of a million recordings is smaller."""
MANIFEST = "manifest.json"
"""Name of the file in a folder of results that says what they were made from."""

_DRAWN_WITH = ("matplotlib", "jinja2")
_NO_SETTINGS = frozenset({"trials", "warnings", "path", "folder"})


class InputFile(NamedTuple):
    """A file that went in: its path relative to the campaign's folder, and the SHA-256 of its bytes, "" if unread."""

    path: str
    sha256: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Provenance:
    """All that is needed to make a result again, without time or place."""

    command: str
    campaign: InputFile
    trial_list: InputFile
    recordings: tuple[InputFile, ...]
    versions: Mapping[str, str]
    seeds: Mapping[str, int]
    settings: Mapping[str, Any]
    law: str

    def to_dict(self) -> dict[str, Any]:
        """Return a JSON tree of schema `ropefric.run/1`."""
        return {
            "schema": SCHEMA,
            "command": self.command,
            "law": self.law,
            "inputs": [item._asdict() for item in (self.campaign, self.trial_list, *self.recordings)],
            "versions": dict(self.versions),
            "seeds": dict(self.seeds),
            "settings": dict(self.settings),
        }


def trace_provenance(run: CampaignRun, evidence: Evidence) -> Provenance:
    """Return where a result comes from."""
    campaign, fit = run.campaign, run.answer.fit
    law = fit.law if run.answer.winner.forced else ""
    words = ["ropefric", "run", campaign.path.name, "--out", "out", *(("--law", law) if law else ())]
    seeds = {"fit": fit.provenance.get("settings", {}).get("seed", 0)}
    if run.answer.prediction is not None:
        seeds["prediction"] = run.answer.prediction.seed
    if evidence.lift is not None:
        seeds["uncertainty budget"] = evidence.lift.drawn.seed
    if evidence.plan is not None:
        seeds["plan of tests"] = evidence.plan.seed
    recordings: dict[str, str] = {}
    for trial in run.extraction.trials:
        recordings.setdefault(trial.file, trial.sha256)
    settings = {key: value for key, value in campaign.resolved().items() if key not in _NO_SETTINGS}
    return Provenance(
        command=shlex.join(words),
        campaign=InputFile(campaign.path.name, hash_file(campaign.path)),
        trial_list=InputFile(campaign.relative(campaign.trial_list), hash_file(campaign.trial_list)),
        recordings=tuple(InputFile(*item) for item in recordings.items()),
        versions=dict(fit.provenance.get("versions", {})) | {name: version(name) for name in _DRAWN_WITH},
        seeds=seeds,
        settings=settings,
        law=law,
    )


def manifest_text(provenance: Provenance, campaign: Path, folder: Path) -> str:
    """Return the manifest, by which a folder of results finds its campaign again."""
    try:
        shown = Path(os.path.relpath(campaign, folder)).as_posix()
    except ValueError:  # another drive on Windows
        shown = campaign.resolve().as_posix()
    tree = provenance.to_dict() | {"campaign": shown}
    return json_document(tree)


def recorded_run(folder: Path) -> tuple[Path, str]:
    """Return the campaign file that a folder of results was made from, and the law that was asked for."""
    path = folder / MANIFEST
    try:
        tree = json.loads(read_file(path, limit=MOST_BYTES))
    except DataError:
        raise DataError(
            "no results stand here",
            code="RF101",
            path=path.as_posix(),
            fix="give a folder that `ropefric run` wrote, or the campaign",
        ) from None
    except (ValueError, RecursionError):
        tree = None
    known = isinstance(tree, dict) and tree.get("schema") == SCHEMA
    if not known or not all(isinstance(tree.get(key), str) for key in ("campaign", "law")):
        raise DataError(
            f"this is no {SCHEMA}", code="RF101", path=path.as_posix(), fix="give the campaign itself"
        )
    return Path(os.path.normpath(folder / tree["campaign"])), tree["law"]
