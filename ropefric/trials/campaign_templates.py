"""Commented templates to start a campaign from."""

import os
from importlib.resources import files
from pathlib import Path

from ropefric.errors import InputError

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
    paths = tuple(Path(folder) / name for name in TEMPLATES)
    source = files("ropefric.trials") / "templates"
    contents = [(source / name).read_bytes() for name in TEMPLATES]
    try:
        for path in paths:
            if not overwrite and (path.exists() or path.is_symlink()):
                fix = "choose another folder, or ask for overwriting"
                raise InputError("the file is there already", path=path.as_posix(), fix=fix)
        Path(folder).mkdir(parents=True, exist_ok=True)
        for path, content in zip(paths, contents, strict=True):
            path.write_bytes(content)
    except OSError as error:
        reason = error.strerror or "not a usable folder"
        raise InputError(f"the templates cannot be written: {reason}", path=str(folder)) from None
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise InputError("this is not a usable folder name", path=repr(str(folder))) from None
    return paths
