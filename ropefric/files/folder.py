"""The folder a command writes into: one run at a time, nothing of others replaced, no results mixed.

A command's folder keeps a list of what ropefric wrote there, with hashes, in `.ropefric/files.json`. A file that is
not on the list, or was changed since, belongs to somebody else. New files are written aside and put in place
together, and what an earlier run left and no longer fits goes at the same moment; so a run that is stopped leaves the
old result or the new one, and the list is written before the files it names.
"""

import errno
import glob
import json
import os
import platform
import shlex
import stat
import sys
from collections.abc import Iterable, Mapping
from contextlib import AbstractContextManager, suppress
from dataclasses import replace
from datetime import UTC, datetime
from itertools import chain
from pathlib import Path, PurePosixPath
from typing import BinaryIO, NamedTuple, Self

from ropefric.errors import DataError, Problem, data_error
from ropefric.files import disk
from ropefric.files.disk import hash_file
from ropefric.files.plain_text import json_document

if sys.platform != "win32":
    import fcntl


OWN = ".ropefric"
"""Folder within a command's folder: the list of its files, its lock, and unfinished files."""
CACHE = ".cache"
"""Folder within a command's folder for what can be made again at any time."""
SCHEMA = "ropefric.files/1"

_held: set[tuple[int, int]] = set()
_MOST_NAMED = 3
"""Files of others that a refusal names."""


class Folder:
    """A folder whose files are replaced one by one as they are written; the caller knows that it may."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)

    def write(self, contents: Mapping[str, str | bytes]) -> tuple[Path, ...]:
        """Write files, named relative to the folder with "/"; return their paths."""
        return tuple(disk.write_file(self.path / name, content) for name, content in contents.items())

    def stream(self, name: str) -> AbstractContextManager[BinaryIO]:
        """Return a context whose stream becomes a file, for output too long to be held."""
        return disk.replacing(self.path / name)

    def publish(self, part: str) -> None:
        """Let everybody see what was written since the last time, as one part of the result."""


def as_folder(folder: "Folder | str | os.PathLike[str]") -> Folder:
    """Return a folder to write into, whichever way it is given."""
    return folder if isinstance(folder, Folder) else Folder(folder)


class _Entry(NamedTuple):
    """Facts about a file of ours: the hashes it may have, the parts it is of, and the hash it rests on."""

    sha256: tuple[str, ...]
    parts: frozenset[str]
    basis: str


class OutputFolder(Folder):
    """The folder of a command, as a context: locked, checked before the work, and never left half done.

    Written files appear at once when they are published; unpublished files are dropped at the end of the context.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        *,
        family: str,
        names: Iterable[str] = (),
        inputs: Iterable[Path] = (),
        basis: str = "",
        force: bool = False,
    ) -> None:
        super().__init__(path)
        self._family, self._basis, self._force = family, basis, force
        self._names, self._sources = tuple(names), tuple(inputs)
        self._own = self.path / OWN
        self._entries: dict[str, _Entry] = {}
        self._staged: dict[str, Path] = {}
        self._inputs: set[tuple[int, int]] = set()
        self._lock, self._key = -1, (0, 0)

    def __enter__(self) -> Self:
        self._inputs = {key for key in map(_file_key, self._sources) if key is not None}
        try:
            disk.refuse_special(self._own / "lock")
            self._entries = self._read_entries()
            self._refuse_others(self._existing())
            self._refuse_folder_of_others()
            self._take_lock()
        except OSError as error:
            raise disk.cannot_write(error, self.path) from None
        for left in self._own.glob(f".*{disk.PART}"):
            disk.discard(left)
        self._entries = self._read_entries()  # another run may just have ended
        return self

    def __exit__(self, *_why: object) -> None:
        for part in self._staged.values():
            disk.discard(part)
        self._staged.clear()
        os.ftruncate(self._lock, 0)
        os.close(self._lock)
        _held.discard(self._key)

    def write(self, contents: Mapping[str, str | bytes]) -> tuple[Path, ...]:
        """Write files aside until they are published; return the paths they will have."""
        for name, content in contents.items():
            with self.stream(name) as stream:
                stream.write(content.encode() if isinstance(content, str) else content)
        return tuple(self.path / name for name in contents)

    def stream(self, name: str) -> AbstractContextManager[BinaryIO]:
        """Return a context whose stream becomes a file when it is published."""

        def stage(part: Path) -> None:
            if name in self._staged:
                disk.discard(self._staged[name])
            self._staged[name] = part

        return disk.new_file(self._own, stage, meant=self.path / name)

    def publish(self, part: str) -> None:
        """Put in place what was written since the last time, as one whole part of the result.

        Files of this part that an earlier run wrote and this one did not are removed, and so is all of the family
        that rests on another basis; what was changed by hand meanwhile stays.
        """
        label = f"{self._family}/{part}"
        self._refuse_others(self._staged)
        try:
            new = {name: hash_file(path) for name, path in self._staged.items()}
            basis = new.get(self._basis, "")
            if not basis and self._basis in self._entries:
                basis = self._entries[self._basis].sha256[-1]
            kept, stale = self._sort_out(label, new, basis)
            # Before the files: whatever comes in between, a file of ours is never taken for somebody else's.
            both = dict(self._entries)  # a file about to be replaced is the old one or the new one
            for name, sha256 in new.items():
                before = both.get(name, _Entry((), frozenset({label}), basis))
                both[name] = before._replace(sha256=(*before.sha256, sha256))
            self._write_entries(both)
            for name in stale:
                self._remove(name)
            for name, staged in list(self._staged.items()):
                path = self.path / name
                path.parent.mkdir(parents=True, exist_ok=True)
                disk.put_in_place(staged, path)
                del self._staged[name]
            for name, sha256 in new.items():
                parts = kept[name].parts if name in kept else frozenset[str]()
                kept[name] = _Entry((sha256,), parts | {label}, basis)
            self._write_entries(kept)
        except OSError as error:
            raise disk.cannot_write(error, error.filename2 or error.filename or self.path) from None

    def _sort_out(
        self, label: str, new: Mapping[str, str], basis: str
    ) -> tuple[dict[str, _Entry], tuple[str, ...]]:
        """Return the entries that stay, without this part where it is not written again, and names that go."""
        kept: dict[str, _Entry] = {}
        for name, entry in self._entries.items():
            left = entry.parts - {label}
            if name in new or not any(part.startswith(f"{self._family}/") for part in entry.parts):
                kept[name] = entry
            elif left and entry.basis == basis:
                kept[name] = entry._replace(parts=left)
        return kept, tuple(name for name in self._entries if name not in kept)

    def _remove(self, name: str) -> None:
        path = self.path / name
        parents = PurePosixPath(name).parents
        behind_a_link = any((self.path / one).is_symlink() for one in parents if one.parts)
        if not behind_a_link and self._is_ours(name) and _file_key(path) not in self._inputs:
            path.unlink()
            if path.parent != self.path:
                with suppress(OSError):
                    path.parent.rmdir()

    # --- whose files these are ---

    def _existing(self) -> list[str]:
        """Return the names the command may write that are taken."""
        parents = {PurePosixPath(name).parent.as_posix() for name in self._names} - {"."}
        for folder in (OWN, CACHE, *sorted(parents)):
            disk.refuse_link(self.path / folder)
        # Also links that lead nowhere, which Path.glob passes over.
        found = (glob.glob(pattern, root_dir=self.path) for pattern in self._names)  # noqa: PTH207
        return sorted({Path(name).as_posix() for name in chain(*found)})

    def _refuse_others(self, names: Iterable[str]) -> None:
        """Refuse to replace what others wrote, telling of every such file."""
        problems = []
        for name in names:
            path = self.path / name
            for parent in PurePosixPath(name).parents[:-1]:
                disk.refuse_link(self.path / parent)
            disk.refuse_special(path)
            code, what, fix = "", "", "choose another folder, or move the file away"
            if _file_key(path) in self._inputs:
                code, what = "RF151", "this is an input of the same command and is never replaced"
                fix = "choose another folder for the results"
            elif os.path.lexists(path) and not self._force and not self._is_ours(name):
                known = "ropefric did not write this file, or an earlier version of it did"
                if name in self._entries:
                    known = "it was changed since ropefric wrote it"
                code, what = "RF150", f"{known}, and it is not replaced"
                fix += ", or replace it with --force"
            if code:
                problems.append(Problem(code=code, message=what, path=path.as_posix(), fix=fix))
        if len(problems) > _MOST_NAMED:
            more = f"{problems[_MOST_NAMED].message}; the same holds for {len(problems) - _MOST_NAMED - 1} more files"
            problems = [*problems[:_MOST_NAMED], replace(problems[_MOST_NAMED], message=more)]
        if problems:
            raise data_error(problems)

    def _refuse_folder_of_others(self) -> None:
        """Refuse a folder that is neither ropefric's own nor empty: nobody finds his files among the results."""
        if self._force or self._entries or not self.path.is_dir():
            return
        names = sorted(path.name for path in self.path.iterdir() if not path.name.startswith("."))
        if names:
            more = f" and {len(names) - 3} more" if len(names) > 3 else ""
            why = f"the folder is neither new nor one of ropefric's: it holds {', '.join(names[:3])}{more}"
            fix = "choose a new or empty folder, or have the results written among these files with --force"
            raise disk.not_written(self.path, why, fix, "RF150")

    def _is_ours(self, name: str) -> bool:
        path = self.path / name
        try:
            is_file = name in self._entries and stat.S_ISREG(path.lstat().st_mode)
            return is_file and hash_file(path) in self._entries[name].sha256
        except (OSError, DataError):
            return False

    def _read_entries(self) -> dict[str, _Entry]:
        """Return the list of our files; a damaged one lists none."""
        try:
            tree = json.loads((self._own / "files.json").read_bytes())
            if tree["schema"] != SCHEMA:
                return {}
            return {
                name: _Entry(tuple(item["sha256"]), frozenset(item["parts"]), str(item["basis"]))
                for name, item in tree["files"].items()
                if _stays_inside(name) and item["sha256"]
            }
        except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
            return {}

    def _write_entries(self, entries: Mapping[str, _Entry]) -> None:
        self._entries = dict(sorted(entries.items()))
        files = {
            name: {"sha256": list(entry.sha256), "parts": sorted(entry.parts), "basis": entry.basis}
            for name, entry in self._entries.items()
        }
        disk.write_file(self._own / "files.json", json_document({"schema": SCHEMA, "files": files}))

    # --- one run at a time ---

    def _take_lock(self) -> None:
        self._own.mkdir(parents=True, exist_ok=True)
        key = _file_key(self._own)
        assert key is not None  # noqa: S101  (it was just made)
        if key in _held:  # to open and close the file would end the lock
            raise _busy(self.path, _this_run())
        handle = os.open(self._own / "lock", os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o666)
        if not _lock_file(handle):
            run = os.read(handle, 4096).decode(errors="replace")
            os.close(handle)
            raise _busy(self.path, run)
        self._lock, self._key = handle, key
        os.ftruncate(handle, 0)
        os.write(handle, _this_run().encode(errors="replace"))
        _held.add(key)


def _busy(folder: Path, run: str) -> DataError:
    fix = "wait until it has ended, or choose another folder"
    return disk.not_written(folder, f"another run works in this folder, {run}", fix, "RF152")


def _this_run() -> str:
    """Return process, machine, start and command of this run; the command last, for it may be long."""
    started = datetime.now(UTC).isoformat(timespec="seconds")
    program = Path(sys.argv[0])
    name = program.parent.name if program.name == "__main__.py" else program.name
    command = shlex.join([name, *sys.argv[1:]])
    return f"process {os.getpid()} on {platform.node()}, since {started}: `{command}`"


def _lock_file(handle: int) -> bool:
    """Return whether a file is locked for this process now, or the system knows no locks here."""
    if sys.platform == "win32":
        return True
    try:
        # Not flock: that lock would go on with every worker process that was forked from this one.
        fcntl.lockf(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        return error.errno not in {errno.EACCES, errno.EAGAIN}
    return True


def _file_key(file: Path | int) -> tuple[int, int] | None:
    """Return what identifies a file, or an open one, under all its names; None if there is none."""
    try:
        found = os.stat(file)  # noqa: PTH116  (an open one too)
    except (OSError, ValueError):
        return None
    return found.st_dev, found.st_ino


def _stays_inside(name: str) -> bool:
    path = PurePosixPath(name)
    return bool(path.parts) and not path.is_absolute() and ".." not in path.parts and "\\" not in name
