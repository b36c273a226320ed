"""Commented templates to start a campaign from."""

import os
from importlib.resources import files
from pathlib import Path

from ropefric.files.write import write_files

TEMPLATES = ("campaign.toml", "trials.csv")
"""The files of a new campaign."""


def write_templates(folder: str | os.PathLike[str], *, overwrite: bool = False) -> tuple[Path, ...]:
    """Return the paths of the commented campaign.toml and trials.csv just written."""
    source = files("ropefric.trials") / "templates"
    contents = {name: (source / name).read_bytes() for name in TEMPLATES}
    return write_files(folder, contents, overwrite=overwrite)
