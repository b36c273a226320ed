"""One way to write a file: the whole new one or the whole old one stands there, whatever happens meanwhile."""

import errno
import os
import stat
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from ropefric.errors import DataError, InputError

PART = ".part"
"""How the name of a file that is still being written ends."""

_NO_SPACE = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
_FIXES = {
    **dict.fromkeys(_NO_SPACE, "make room, or choose another place; what stood there before is as it was"),
    errno.ENAMETOOLONG: "choose a shorter name",
    errno.EISDIR: "name a file; this is a folder",
    errno.ENOTDIR: "a part of this path is a file, not a folder; choose another",
    errno.EEXIST: "a part of this path is a file, not a folder; choose another",
}


def cannot_write(error: OSError, path: str | os.PathLike[str]) -> DataError:
    """Return what the system answered to an attempt to write, as an error that says what to do."""
    reason = (error.strerror or str(error) or type(error).__name__).lower()
    fix = _FIXES.get(error.errno or 0, "choose another place, one you may write to")
    return DataError(f"cannot be written: {reason}", code="RF105", path=Path(path).as_posix(), fix=fix)


def not_written(path: Path, why: str, fix: str, code: str = "RF105") -> DataError:
    """Return the refusal to write something."""
    return DataError(why, code=code, path=path.as_posix(), fix=fix)


def refuse_link(path: Path) -> None:
    """Refuse a folder that is a link: what it leads to belongs to others."""
    if path.is_symlink():
        why = f"this is a link, to {path.readlink()}, and nothing is written through links"
        raise not_written(path, why, "remove the link, or choose another folder")


def refuse_special(path: Path) -> None:
    """Refuse to replace what is not a plain file: what a link leads to belongs to others, a device is none."""
    try:
        mode = path.lstat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        return
    except OSError as error:
        raise cannot_write(error, path) from None
    except ValueError:  # a null character
        raise DataError("this is not a usable file name", code="RF105", path=repr(str(path))) from None
    what = ""
    if stat.S_ISLNK(mode):
        what = f"this is a link, to {path.readlink()}, and nothing is written through links"
    elif stat.S_ISDIR(mode):
        what = "this is a folder, not a file"
    elif not stat.S_ISREG(mode):
        what = "this is a device or pipe, not a file"
    elif not os.access(path, os.W_OK):
        what = "the file is write-protected"
    if what:
        raise not_written(path, what, "choose another name, or remove it")


def refuse_input(path: Path, *inputs: Path | None) -> None:
    """Refuse to write over a file that the same command reads, under whatever name."""
    for source in inputs:
        try:
            same = source is not None and path.samefile(source)
        except (OSError, ValueError):  # one of them is not there
            continue
        if same:
            why = "this is an input of the same command and is never replaced"
            raise not_written(path, why, "choose another name for what is written", "RF151")


@contextmanager
def new_file(
    folder: Path, finish: Callable[[Path], None], *, meant: Path, durable: bool = True
) -> Iterator[BinaryIO]:
    """Yield a stream into a new file of a folder; `finish` takes it when the block ends well, else it is gone.

    `meant` is where it is to stand at last, for messages.
    """
    # Short, whatever the name of the file will be: the system allows names of 255 bytes only. None is used twice.
    part = folder / f".{os.urandom(6).hex()}{PART}"
    try:
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with part.open("xb") as stream:
                yield stream
                stream.flush()
                if durable:
                    os.fsync(stream.fileno())
            finish(part)
        except BaseException:
            discard(part)
            raise
    except OSError as error:
        raise cannot_write(error, meant) from None


def replacing(path: Path, *, durable: bool = True) -> AbstractContextManager[BinaryIO]:
    """Return a stream whose bytes become the file when the block ends well; else the file stays as it was."""
    refuse_special(path)
    return new_file(path.parent, lambda part: put_in_place(part, path), meant=path, durable=durable)


def put_in_place(part: Path, path: Path) -> None:
    """Give a finished file its name, and the permissions of the one it replaces."""
    if path.exists():
        part.chmod(stat.S_IMODE(path.stat().st_mode))
    part.replace(path)


def discard(part: Path) -> None:
    """Remove a file that did not become one; a folder that does not let go of it is not the trouble to tell of."""
    with suppress(OSError):
        part.unlink(missing_ok=True)


def write_file(path: str | os.PathLike[str], content: str | bytes, *, durable: bool = True) -> Path:
    r"""Write a text (UTF-8, line ends as they are) or bytes as one file, whole or not at all; return its path."""
    target = Path(path)
    with replacing(target, durable=durable) as stream:
        stream.write(content.encode() if isinstance(content, str) else content)
    return target


def write_files(
    folder: str | os.PathLike[str], contents: Mapping[str, bytes], *, overwrite: bool = False
) -> tuple[Path, ...]:
    """Write files that start something new: all of them or none, and never over somebody's work; return the paths."""
    paths = tuple(Path(folder) / name for name in contents)
    for path in paths:
        if not overwrite and os.path.lexists(path):
            fix = "choose another folder, or ask for overwriting (--force)"
            raise InputError("the file is there already", code="RF150", path=path.as_posix(), fix=fix)
    with ExitStack() as stack:  # none gets its name before all are written
        for path, content in zip(paths, contents.values(), strict=True):
            stream = stack.enter_context(replacing(path))
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
    return paths
