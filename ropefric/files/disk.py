"""Single files, read and written whole, whatever happens meanwhile.

A named file is read if it is a regular file: never blocked, never half of one version and half of another.
Writing leaves the whole new file or the whole old one.
"""

import errno
import hashlib
import os
import stat
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from pathlib import Path
from typing import BinaryIO, Self, TypeVar

from ropefric.errors import DataError, InputError

T = TypeVar("T")

BLOCK_BYTES = 2**20
"""How much of a file is read at a time."""

KEPT_BYTES = 8 * 2**20
"""Files up to this size are read once and kept; larger ones are read again for every pass over them."""

_FLAGS = (
    os.O_RDONLY
    | getattr(os, "O_NONBLOCK", 0)  # a pipe that took a file's place in between must not hold us up
    | getattr(os, "O_NOCTTY", 0)
    | getattr(os, "O_CLOEXEC", 0)
    | getattr(os, "O_BINARY", 0)
)


def kind_of_file(path: str | os.PathLike[str]) -> str:
    """Return the kind of a path: "file", "folder", "device or pipe", or "" for none."""
    try:
        return _kind(os.stat(path))  # noqa: PTH116  (a name with a null byte raises in either way)
    except (OSError, ValueError):
        return ""


def _kind(found: os.stat_result) -> str:
    if stat.S_ISREG(found.st_mode):
        return "file"
    return "folder" if stat.S_ISDIR(found.st_mode) else "device or pipe"


class FileChangedError(DataError):
    """A file was written to while it was read."""


def _changed(shown: str) -> FileChangedError:
    fix = "is a logger still writing it? Wait until it is complete"
    return FileChangedError("the file changed while it was read", path=shown, fix=fix)


class InputFile:
    """A regular file, open for reading, that gives the same bytes however often they are asked for.

    Use as a context manager. Made by `open_file`.
    """

    def __init__(self, descriptor: int, shown: str) -> None:
        self._stream = open(descriptor, "rb", buffering=0)  # noqa: SIM115  (closed by __exit__)
        self.shown = shown
        self.size, self._version = self._look()
        self._hash = ""
        self._kept: bytes | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_why: object) -> None:
        self._stream.close()

    @property
    def sha256(self) -> str:
        """Return the SHA-256 of the content."""
        if not self._hash:
            for _ in self.blocks():
                pass
        return self._hash

    def blocks(self, size: int = BLOCK_BYTES) -> Iterator[bytes]:
        """Return an iterator over the whole content, a block of this size at a time; at once where it is kept anyhow."""
        if self.size <= KEPT_BYTES:
            yield self.read()
        else:
            yield from self._pass(size)

    def read(self, limit: int | None = None) -> bytes:
        """Return the whole content."""
        if limit is not None and self.size > limit:
            message = f"the file has {self.size} bytes; more than {limit} are not read"
            raise DataError(message, path=self.shown, fix="check that this is the file you mean")
        if self._kept is not None:
            return self._kept
        content = b"".join(self._pass(BLOCK_BYTES))
        if self.size <= KEPT_BYTES:
            self._kept = content
        return content

    def part(self, start: int, size: int) -> bytes:
        """Return some bytes from a place on, without reading those before."""
        if self._kept is not None:
            return self._kept[start : start + size]
        self._stream.seek(start)
        pieces = []
        while size > 0 and (piece := self._stream.read(size)):
            pieces.append(piece)
            size -= len(piece)
        return b"".join(pieces)

    @property
    def is_steady(self) -> bool:
        """Return whether the file is still what was read of it."""
        return self._kept is not None or self._look()[1] == self._version

    def _look(self) -> tuple[int, tuple[int, ...]]:
        found = os.fstat(self._stream.fileno())
        return found.st_size, (found.st_size, found.st_mtime_ns)

    def _pass(self, size: int) -> Iterator[bytes]:
        self._stream.seek(0)
        hashed, n_read = hashlib.sha256(), 0
        while block := self._stream.read(size):
            n_read += len(block)
            if n_read > self.size:  # it grew
                break
            hashed.update(block)
            yield block
        digest = hashed.hexdigest()
        if n_read != self.size or self._look()[1] != self._version or (self._hash or digest) != digest:
            raise _changed(self.shown)
        self._hash = digest


def open_file(path: str | os.PathLike[str], what: str = "file", *, shown: str = "") -> InputFile:
    """Return a file, open for reading."""
    shown = shown or Path(path).as_posix()
    try:
        kind = _kind(os.stat(path))  # noqa: PTH116  (opening a device may already do something)
        if kind == "file":
            descriptor = os.open(path, _FLAGS)
            kind = _kind(os.fstat(descriptor))
            if kind == "file":
                return InputFile(descriptor, shown)
            os.close(descriptor)
    except (FileNotFoundError, NotADirectoryError):
        raise DataError(f"there is no such {what}", path=shown, fix="check the path") from None
    except (OSError, ValueError) as error:  # ValueError: a null byte in the name
        raise _unreadable(error, what, shown) from None
    message, fix = "this is a device or pipe, not a file", "write its content to a file, and name that"
    if kind == "folder":
        message, fix = f"this is a folder, not a {what}", "name a file in it"
    raise DataError(message, path=shown, fix=fix)


def _unreadable(error: Exception, what: str, shown: str) -> DataError:
    reason = error.strerror if isinstance(error, OSError) and error.strerror else "not a usable file name"
    message, fix = f"the {what} cannot be read: {reason}", "check its name and permissions"
    return DataError(message, path=shown, fix=fix)


def read_file(
    path: str | os.PathLike[str], what: str = "file", *, shown: str = "", limit: int | None = None
) -> bytes:
    """Return a file's content."""
    return use_file(path, lambda file: file.read(limit), what, shown=shown)


def use_file(
    path: str | os.PathLike[str], use: Callable[[InputFile], T], what: str = "file", *, shown: str = ""
) -> T:
    """Return what comes of an open file, or refuse one that changed meanwhile."""
    with open_file(path, what, shown=shown) as file:
        try:
            found = use(file)
        except OSError as error:  # of a disk that fails, or of what only says that it is a file
            raise _unreadable(error, what, file.shown) from None
        except DataError:  # half a line, perhaps, that was being written
            if file.is_steady:
                raise
            raise _changed(file.shown) from None
        if not file.is_steady:
            raise _changed(file.shown)
        return found


def hash_file(path: str | os.PathLike[str]) -> str:
    """Return the SHA-256 of a file's content, which need not fit into memory."""
    return use_file(path, lambda file: file.sha256)


PART = ".part"
"""How the name of a file that is still being written ends."""

_NO_SPACE = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
_FIXES = {
    **dict.fromkeys(_NO_SPACE, "make room, or choose another place; what stood there before is as it was"),
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
    """Refuse to replace links and special files: the target of a link belongs to others."""
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
            raise not_written(path, why, "choose another name for the output", "RF151")


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
    """Remove a file that did not become one; an error of the folder is not the one to report."""
    with suppress(OSError):
        part.unlink(missing_ok=True)


def write_file(path: str | os.PathLike[str], content: str | bytes, *, durable: bool = True) -> Path:
    r"""Write a text (UTF-8, line ends as they are) or bytes as one file, whole or not at all; return its path."""
    target = Path(path)
    with replacing(target, durable=durable) as stream:
        stream.write(content.encode() if isinstance(content, str) else content)
    return target


def append_file(path: Path, content: bytes, *, is_new: bool) -> None:
    """Put bytes at the end of a file that only grows, in one piece or not at all; of a new one they are the begin.

    Whatever others put there meanwhile stays.
    """
    refuse_special(path)
    flags = os.O_WRONLY | os.O_APPEND | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0)
    try:
        descriptor = os.open(path, flags | (os.O_CREAT | os.O_EXCL if is_new else 0), 0o666)
        try:
            size = os.fstat(descriptor).st_size
            if os.write(descriptor, content) != len(content):
                os.ftruncate(descriptor, size)
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
    except OSError as error:
        raise cannot_write(error, path) from None


def take_back(path: Path, before: bytes, added: bytes) -> None:
    """Take away what was put at the end of a file, unless others have put something there since."""
    if read_file(path) != before + added:
        return
    if before:
        os.truncate(path, len(before))
    else:
        path.unlink()


def write_files(
    folder: str | os.PathLike[str], contents: Mapping[str, bytes], *, overwrite: bool = False
) -> tuple[Path, ...]:
    """Write files that start something new: all of them or none, and never over somebody's work; return the paths."""
    paths = tuple(Path(folder) / name for name in contents)
    for path in paths:
        if not overwrite and os.path.lexists(path):
            fix = "choose another folder, or allow overwriting (--force)"
            raise InputError("the file is there already", code="RF150", path=path.as_posix(), fix=fix)
    with ExitStack() as stack:  # none gets its name before all are written
        for path, content in zip(paths, contents.values(), strict=True):
            stream = stack.enter_context(replacing(path))
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
    return paths
