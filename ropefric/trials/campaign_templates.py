"""Commented templates to start a campaign from."""

import os
from importlib.resources import files
from pathlib import Path

from ropefric.files.write import write_files

__all__ = ["TEMPLATES", "write_templates"]

TEMPLATES = ("campaign.toml", "trials.csv")
"""The files of a new campaign."""


def write_templates(folder: str | os.PathLike[str], *, overwrite: bool = False) -> tuple[Path, ...]:
    """Return the paths of the commented campaign.toml and trials.csv just written.

    Parameters
    ----------
    folder : path-like
        Where to; it is made if it is missing.
    overwrite : bool
        Replace files that are there.

    Raises
    ------
    InputError
        If a file is there already, and then nothing is written; or if the folder cannot be written to.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     [path.name for path in write_templates(folder)]
    ['campaign.toml', 'trials.csv']
    """
    source = files("ropefric.trials") / "templates"
    contents = {name: (source / name).read_bytes() for name in TEMPLATES}
    return write_files(folder, contents, overwrite=overwrite)
