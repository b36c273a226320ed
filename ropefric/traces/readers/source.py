"""The bytes of a recording file, and errors that name it."""

import gzip
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from ropefric.errors import DataError
from ropefric.files.read import BLOCK_BYTES, InputFile

GZIP_MAGIC = b"\x1f\x8b"

MOST_UNPACKED_BYTES = 4 * 2**30
"""Text that gzip may unpack to; a few megabytes can be made to unpack to terabytes."""


class _Stream:
    """Blocks as the file that gzip wants to read."""

    def __init__(self, blocks: Iterator[bytes]) -> None:
        self._blocks = blocks
        self._rest = memoryview(b"")

    def read(self, size: int) -> bytes:
        """Return `size` bytes, fewer at the end only: gzip takes a short read for the file's end."""
        pieces = []
        while size > 0:
            if not self._rest:
                self._rest = memoryview(next(self._blocks, b""))
                if not self._rest:
                    break
            pieces.append(self._rest[:size])
            size, self._rest = size - len(pieces[-1]), self._rest[size:]
        return b"".join(pieces)


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """A file as it is opened, and as its owner wrote it."""

    path: Path
    shown: str
    file: InputFile | None = None
    most_bytes: int = 0

    def error(
        self, message: str, *, code: str = "RF101", line: int | None = None, key: str = "", fix: str = ""
    ) -> DataError:
        """Return (not raise) an error that names this file."""
        return DataError(message, code=code, path=self.shown, line=line, key=key, fix=fix)

    @property
    def is_packed(self) -> bool:
        """Return whether the content is gzip."""
        return self.opened.part(0, len(GZIP_MAGIC)) == GZIP_MAGIC

    def unpacked(self) -> Iterator[bytes]:
        """Return an iterator over the file's content in blocks, unpacked where it is gzip; the whole is never held."""
        start = self.opened.part(0, len(GZIP_MAGIC))
        if not start:
            raise self.error("the file is empty (0 bytes)", fix="record or copy it again")
        if start == GZIP_MAGIC:
            return self._up_to_here(self._gunzipped())
        if self.path.suffix.lower() == ".gz":
            raise self.error(
                "the name ends in .gz, but the content is not gzip",
                fix="rename the file without .gz, or copy it again",
            )
        if self.most_bytes:
            size = min(abs(self.most_bytes), self.opened.size)
            return iter((self.opened.part(0 if self.most_bytes > 0 else self.opened.size - size, size),))
        return self.opened.blocks()

    def _up_to_here(self, blocks: Iterator[bytes]) -> Iterator[bytes]:
        left = self.most_bytes or MOST_UNPACKED_BYTES + BLOCK_BYTES
        for block in blocks:
            yield block[:left]
            left -= len(block)
            if left <= 0:
                return

    def _gunzipped(self) -> Iterator[bytes]:
        n_bytes = 0
        try:
            with gzip.GzipFile(fileobj=_Stream(self.opened.blocks()), mode="rb") as stream:  # type: ignore[call-overload]
                while block := stream.read(BLOCK_BYTES):
                    n_bytes += len(block)
                    if n_bytes > MOST_UNPACKED_BYTES:
                        raise self.error(
                            f"the file unpacks to more than {MOST_UNPACKED_BYTES / 2**30:g} GB",
                            fix="check what it holds; unpack it, and split it, if it is a recording",
                        )
                    yield block
        except (OSError, EOFError, zlib.error) as error:
            if isinstance(error, DataError):
                raise
            raise self.error(
                f"the gzip data are damaged or cut off ({error})", fix="copy the file again from the logger"
            ) from None
        if not n_bytes:
            raise self.error("the file is empty (gzip of 0 bytes)")

    def raw_bytes(self) -> bytes:
        """Return the file's content as it is on disk."""
        data = self.opened.read()
        if not data:
            raise self.error("the file is empty (0 bytes)", fix="record or copy it again")
        return data

    @property
    def opened(self) -> InputFile:
        """Return the file, which must be open."""
        if self.file is None:  # pragma: no cover - our own mistake
            raise self.error("the file is not open")
        return self.file
