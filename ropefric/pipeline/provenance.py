"""Where a campaign's result comes from: inputs with their hashes, versions, seeds, settings, and the command."""

import json
import os
import shlex
from importlib.metadata import version
from pathlib import Path
from typing import Any

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


def trace_provenance(run: CampaignRun, evidence: Evidence) -> dict[str, Any]:
    """Return all that is needed to make a result again, without time or place, as a tree of schema `ropefric.run/1`.

    The inputs are the campaign, the trial list and the recordings, each with its path relative to the campaign's
    folder and the SHA-256 of its bytes, "" if it was not read.
    """
    campaign, fit, prediction = run.campaign, run.answer.fit, run.answer.prediction
    law = fit.law if run.answer.winner.forced else ""
    words = ["ropefric", "run", campaign.path.name, "--out", "out", *(("--law", law) if law else ())]
    seeds = {"fit": fit.provenance.get("settings", {}).get("seed", 0)}
    if prediction is not None:
        seeds["prediction"] = prediction.seed
    if evidence.lift is not None:
        seeds["uncertainty budget"] = evidence.lift.drawn.seed
    if evidence.plan is not None:
        seeds["plan of tests"] = evidence.plan.seed
    recordings: dict[str, str] = {}
    for trial in run.extraction.trials:
        recordings.setdefault(trial.file, trial.sha256)
    inputs = [
        (campaign.path.name, hash_file(campaign.path)),
        (campaign.relative(campaign.trial_list), hash_file(campaign.trial_list)),
        *recordings.items(),
    ]
    return {
        "schema": SCHEMA,
        "command": shlex.join(words),
        "law": law,
        "inputs": [{"path": path, "sha256": sha256} for path, sha256 in inputs],
        "versions": fit.provenance.get("versions", {}) | {name: version(name) for name in _DRAWN_WITH},
        "seeds": seeds,
        "settings": {key: value for key, value in campaign.resolved().items() if key not in _NO_SETTINGS},
    }


def manifest_text(provenance: dict[str, Any], campaign: Path, folder: Path) -> str:
    """Return the manifest, by which a folder of results finds its campaign again."""
    try:
        shown = Path(os.path.relpath(campaign, folder)).as_posix()
    except ValueError:  # another drive on Windows
        shown = campaign.resolve().as_posix()
    return json_document(provenance | {"campaign": shown})


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
