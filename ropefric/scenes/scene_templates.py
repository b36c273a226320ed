"""Commented scenes to start from, with the fit that some of them take their friction from."""

import os
import re
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from ropefric.errors import PATH, UnknownNameError
from ropefric.files.disk import write_files
from ropefric.registry import did_you_mean

_PACKAGE = Path(__file__).parents[1]
# Where the bundled scenes find their fits, seen from data/scenes; elsewhere the fit stands in the scene's own folder.
_FIT = re.compile(r'"(fits/[\w-]+\.json)"')
_BUNDLED_FIT = re.compile(r'"\.\./\.\./(fits/[\w-]+\.json)"')


def bundled_scenes() -> dict[str, str]:
    """Return the scenes of all machines, which stand in their folders of `systems` and in data/scenes, by name."""
    found = {path.stem: path for path in _PACKAGE.glob("systems/*/*.toml")}
    return {name: found[name].read_bytes().decode("utf-8") for name in sorted(found)}


def scene_text(name: str) -> str:
    """Return a scene as `write_scenes` writes it, with its fit in `fits/` beside it."""
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
    PATH.check(folder=folder)
    texts = {f"{name}.toml": scene_text(name) for name in dict.fromkeys(names or bundled_scenes())}
    contents = {name: text.encode("utf-8") for name, text in texts.items()}
    for fit in {fit for text in texts.values() for fit in _FIT.findall(text)}:
        contents[fit] = (_PACKAGE / "scenes" / fit).read_bytes()
        with suppress(OSError, ValueError):
            if (Path(folder) / fit).read_bytes() == contents[fit]:
                del contents[fit]
    return write_files(folder, contents, overwrite=overwrite)
