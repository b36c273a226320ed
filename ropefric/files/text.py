"""The bytes of a text file as clean lines: unpacked, encoding found, line ends alike."""

import csv
import gzip
import io
import zlib
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

from ropefric.errors import DataError
from ropefric.files.disk import InputFile

GZIP_MAGIC = b"\x1f\x8b"
_GZIP = 31  # as zlib calls it
_SEEN = 40  # lines by which a format is recognised

MOST_UNPACKED_BYTES = 2**30
"""Text that gzip may unpack to; a few megabytes can be made to unpack to terabytes."""
HEAD_BYTES = 65536
"""Marks are looked for in this much of a file; the whole file is then held to what was found."""
HEAD_LINES = 32
"""Lines that the head has at least, however long they are."""
PIECE_BYTES = 2**20
"""How much of a text is taken apart at a time."""

_MARKS = (  # UTF-32 first: its little-endian mark starts with UTF-16's
    (b"\xff\xfe\x00\x00", "utf-32"),
    (b"\x00\x00\xfe\xff", "utf-32"),
    (b"\xff\xfe", "utf-16"),
    (b"\xfe\xff", "utf-16"),
    (b"\xef\xbb\xbf", "utf-8-sig"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """A file as it is opened, and as its owner wrote it."""

    path: Path
    shown: str
    file: InputFile

    def error(
        self, message: str, *, code: str = "RF101", line: int | None = None, key: str = "", fix: str = ""
    ) -> DataError:
        """Return (not raise) an error that names this file."""
        return DataError(message, code=code, path=self.shown, line=line, key=key, fix=fix)

    def raw_bytes(self) -> bytes:
        """Return the file's content as it is on disk."""
        data = self.file.read()
        if not data:
            raise self.error("the file is empty (0 bytes)", fix="record or copy it again")
        return data

    def unpacked(self) -> bytes:
        """Return the file's content, unpacked where it is gzip."""
        raw = self.raw_bytes()
        if not raw.startswith(GZIP_MAGIC):
            if self.path.suffix.lower() != ".gz":
                return raw
            fix = "rename the file without .gz, or copy it again"
            raise self.error("the name ends in .gz, but the content is not gzip", fix=fix)
        try:
            data = gzip.GzipFile(fileobj=io.BytesIO(raw)).read(MOST_UNPACKED_BYTES + 1)
        except (zlib.error, EOFError, gzip.BadGzipFile) as error:
            fix = "copy the file again from the logger"
            raise self.error(f"the gzip data are damaged or cut off ({error})", fix=fix) from None
        if len(data) > MOST_UNPACKED_BYTES:
            fix = "check what it holds; unpack it, and split it, if it is a recording"
            most = f"{MOST_UNPACKED_BYTES / 2**30:g} GB"
            raise self.error(f"the file unpacks to more than {most}", fix=fix)
        if not data:
            raise self.error("the file is empty (gzip of 0 bytes)")
        return data


@dataclass(frozen=True, slots=True, kw_only=True)
class Text:
    r"""A text file's content: UTF-8 without byte-order mark, every line, the last one too, ending in `\n`.

    Or a part of it, from a line of the file on.
    """

    source: Source
    data: bytes
    encoding: str
    is_ended: bool = True
    first_line: int = 1

    def blocks(self, line: int = 1) -> Iterator["Block"]:
        """Return an iterator over pieces of whole lines, from a 1-based line on."""
        number, start = max(line, self.first_line), self.start_of(line)
        while start < len(self.data):
            stop = self.data.find(b"\n", start + PIECE_BYTES) + 1 or len(self.data)
            block = Block(number, self.data[start:stop])
            yield block
            number += block.data.count(b"\n")
            start = stop

    def start_of(self, line: int) -> int:
        """Return the byte at which a 1-based line of the file starts; the end where there is no such line."""
        return start_of_line(self.data, line - self.first_line + 1)

    def part(self, start: int, stop: int) -> "Text":
        """Return some bytes of a text as a text of their own."""
        first_line, is_ended = (
            self.first_line + self.data.count(b"\n", 0, start),
            self.is_ended or stop < len(self.data),
        )
        return replace(self, data=self.data[start:stop], first_line=first_line, is_ended=is_ended)

    @property
    def end_of_head(self) -> int:
        """Return where the lines to look at end: after `HEAD_BYTES`, but at least after some lines; never within one."""
        n = len(self.data)
        by_size = n if n <= HEAD_BYTES else self.data.rfind(b"\n", 0, HEAD_BYTES) + 1
        return max(by_size, start_of_line(self.data, HEAD_LINES + 1))

    def line(self, number: int) -> str:
        """Return the text of a 1-based line, "" where there is none."""
        start = self.start_of(number)
        return self.data[start : self.data.find(b"\n", start)].decode(errors="replace")

    def lines_from(self, number: int) -> Iterator[tuple[int, str]]:
        """Return an iterator over the file's lines with their numbers, from a 1-based line on."""
        for block in self.blocks(number):
            yield from block.lines()

    def rows_from(self, number: int, separator: str) -> Iterator[tuple[int, list[str]]]:
        """Return an iterator over the cells of the lines that are not blank, with their numbers."""
        lines = self.lines_from(number)
        return ((n, split_line(line, separator)) for n, line in lines if not is_blank_line(line, separator))


class Block(NamedTuple):
    """Whole lines of a text, and the number of the first of them."""

    line: int
    data: bytes

    def lines(self) -> Iterator[tuple[int, str]]:
        """Return an iterator over the lines with their numbers."""
        return enumerate(self.data[:-1].decode(errors="replace").split("\n"), start=self.line)


def split_line(line: str, separator: str) -> list[str]:
    """Return a line's cells without blanks and quotes around them."""
    if separator == " ":
        return [cell.strip('"') for cell in line.split()]
    if '"' not in line:
        return [cell.strip() for cell in line.split(separator)]
    try:
        cells = next(csv.reader([line], delimiter=separator, skipinitialspace=separator != "\t"), [])
    except csv.Error:
        cells = line.split(separator)
    return [cell.strip() for cell in cells]


def is_blank_line(line: str, separator: str) -> bool:
    r"""Return whether a line holds nothing, not even an empty cell."""
    return not line.strip(" " if separator == "\t" else " \t")


def start_of_line(block: bytes, line: int) -> int:
    """Return the byte at which a 1-based line of a block starts; its end where there is no such line."""
    start = 0
    for _ in range(line - 1):
        start = block.find(b"\n", start) + 1
        if start == 0:
            return len(block)
    return start


def is_text(source: Source) -> bool:
    """Return whether a file begins as text does, with numbers and line ends and without control characters."""
    head = "\n".join(first_lines(source))
    return (
        "\n" in head
        and any(map(str.isdigit, head))
        and all(c.isprintable() or c in "\t\r\n\f\ufeff" for c in head)
    )


def first_lines(source: Source) -> list[str]:
    """Return the first lines of a text, as far as they can be read without knowing its encoding."""
    head = source.file.part(0, HEAD_BYTES)
    if head.startswith(GZIP_MAGIC):
        with suppress(zlib.error):  # which is told when the file is read
            head = zlib.decompressobj(_GZIP).decompress(head, HEAD_BYTES // 8)
    encoding = _marked_encoding(head) or "utf-8"
    return head[: HEAD_BYTES // 8].decode(encoding, errors="replace").split("\n", _SEEN)[:_SEEN]


def load_text(source: Source, encoding: str = "") -> Text:
    r"""Return a file's text, unpacked and decoded.

    Without an encoding a byte-order mark decides, else UTF-8, else cp1252, which is what Windows loggers
    write. Old Macintosh and Windows line ends become `\n`.
    """
    raw = source.unpacked()
    found = encoding or _marked_encoding(raw) or ("utf-8" if _is_utf8(raw) else "cp1252")
    data = raw if raw.isascii() and found in {"utf-8", "cp1252"} else _decoded(raw, found, source)
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    data = _without_zeros(data, source)
    if data.isspace() or not data:
        raise source.error("the file holds nothing but blanks", fix="record or copy it again")
    is_ended = data.endswith(b"\n")
    return Text(source=source, data=data if is_ended else data + b"\n", encoding=found, is_ended=is_ended)


def _marked_encoding(start: bytes) -> str:
    """Return the encoding that a byte-order mark states, "" where there is none."""
    return next((name for mark, name in _MARKS if start.startswith(mark)), "")


def _is_utf8(raw: bytes) -> bool:
    try:
        raw.decode()
    except UnicodeDecodeError:
        return False
    return True


def _decoded(raw: bytes, encoding: str, source: Source) -> bytes:
    """Return text in UTF-8 without byte-order mark, or refuse what has no meaning in its encoding."""
    refused = partial(source.error, code="RF108", key="[import] encoding")
    try:
        return raw.decode(encoding).removeprefix("\ufeff").encode()
    except LookupError:
        fix = 'use "utf-8", "cp1252" or "utf-16", or leave it out'
        raise refused(f"there is no text encoding {encoding!r}", fix=fix) from None
    except (ValueError, Warning) as error:  # an encoding may be refused for its own reasons
        line, reason = None, str(error)
        if isinstance(error, UnicodeDecodeError):
            line = 1 + raw.count(b"\n", 0, error.start)
            reason = f"byte 0x{raw[error.start]:02x} has no meaning there"
        fix = "name its encoding, or save it as UTF-8; a binary file needs [import] format"
        raise refused(f"the file cannot be read as {encoding}: {reason}", line=line, fix=fix) from None


def _without_zeros(data: bytes, source: Source) -> bytes:
    """Return lines without the zero that ends a line's string in C; any other zero is refused."""
    data = data.replace(b"\0\n", b"\n")
    at = data.find(b"\0")
    if at >= 0:
        why = "a byte is zero: this is not a text file, or the logger or a copy lost data"
        fix = (
            'copy the file again, or name its format ([import] format = "matlab"), or encoding = "utf-16-le"'
        )
        raise source.error(why, line=1 + data.count(b"\n", 0, at), fix=fix)
    return data
