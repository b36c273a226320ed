"""Files that start something new: all of them or none, and never over somebody's work."""

import os
from collections.abc import Mapping
from pathlib import Path

from ropefric.errors import InputError

__all__ = ["write_new_files"]


def write_new_files(
    folder: str | os.PathLike[str], contents: Mapping[str, bytes], *, overwrite: bool = False
) -> tuple[Path, ...]:
    """Return the paths of the files just written into a folder.

    Parameters
    ----------
    folder : path-like
        Where to; it is made if it is missing.
    contents : mapping of str to bytes
        What each file holds, by its path below the folder.
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
    ...     [path.name for path in write_new_files(folder, {"one.txt": b"1", "more/two.txt": b"2"})]
    ['one.txt', 'two.txt']
    """
    paths = tuple(Path(folder) / name for name in contents)
    try:
        for path in paths:
            if not overwrite and (path.exists() or path.is_symlink()):
                fix = "choose another folder, or ask for overwriting (--force)"
                raise InputError("the file is there already", path=path.as_posix(), fix=fix)
        for path, content in zip(paths, contents.values(), strict=True):
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
    except OSError as error:
        reason = error.strerror or "not a usable folder"
        raise InputError(f"the templates cannot be written: {reason}", path=str(folder)) from None
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise InputError("this is not a usable folder name", path=repr(str(folder))) from None
    return paths
