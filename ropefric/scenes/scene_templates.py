"""Commented scenes to start from, with the fit that some of them take their friction from."""

import os
import re
from collections.abc import Iterable
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

from ropefric.errors import UnknownNameError
from ropefric.files.write import write_files
from ropefric.registry import did_you_mean

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable


# Where the bundled scenes find their fits, seen from data/scenes; elsewhere the fit stands in the scene's own folder.
_FIT = re.compile(r'"(fits/[\w-]+\.json)"')
_BUNDLED_FIT = re.compile(r'"\.\./\.\./(fits/[\w-]+\.json)"')


def bundled_scenes() -> dict[str, str]:
    """Return the scenes as they stand in data/scenes, by name."""
    entries = [entry for entry in _folder().iterdir() if entry.name.endswith(".toml")]
    return dict(sorted((Path(entry.name).stem, entry.read_bytes().decode("utf-8")) for entry in entries))


def scene_text(name: str) -> str:
    """Return a scene as `write_scenes` writes it: a fit that it names stands in `fits/` beside it."""
    known = bundled_scenes()
    if name not in known:
        raise UnknownNameError(f"unknown scene {name!r}", key="--scene", fix=did_you_mean(name, known))
    return _BUNDLED_FIT.sub(r'"\1"', known[name])


def write_scenes(
    folder: str | os.PathLike[str], names: Iterable[str] = (), *, overwrite: bool = False
) -> tuple[Path, ...]:
    """Return the paths of the scenes just written, and of the fits they name.

    Parameters
    ----------
    folder : path-like
        Where to; it is made if it is missing.
    names : iterable of str
        Which scenes; all of them by default.
    overwrite : bool
        Replace files that are there. A fit that is there and the same is left alone in any case.

    Raises
    ------
    UnknownNameError
        If there is no scene of a name.
    InputError
        If a file is there already, and then nothing is written; or if the folder cannot be written to.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     [path.name for path in write_scenes(folder, ["hoist"])]
    ['hoist.toml', 'prth-coupled.json']
    """
    texts = {f"{name}.toml": scene_text(name) for name in dict.fromkeys(names or bundled_scenes())}
    fits = dict.fromkeys(fit for text in texts.values() for fit in _FIT.findall(text))
    contents = {name: text.encode("utf-8") for name, text in texts.items()}
    for fit in fits:
        content = (_folder() / fit).read_bytes()
        if not _holds(Path(folder) / fit, content):
            contents[fit] = content
    return write_files(folder, contents, overwrite=overwrite)


def _holds(path: Path, content: bytes) -> bool:
    try:
        return path.read_bytes() == content
    except (OSError, ValueError):
        return False


def _folder() -> "Traversable":
    return files("ropefric.scenes") / "templates"
