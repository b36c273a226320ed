"""The bytes of a text file as clean lines: unpacked, encoding found, line ends alike; a large file block by block."""

import codecs
import csv
import zlib
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import NamedTuple

from ropefric.errors import DataError
from ropefric.files.disk import BLOCK_BYTES, InputFile

GZIP_MAGIC = b"\x1f\x8b"
_GZIP = 31  # as zlib calls it
_SEEN = 40  # lines by which a format is recognised

MOST_UNPACKED_BYTES = 4 * 2**30
"""Text that gzip may unpack to; a few megabytes can be made to unpack to terabytes."""
HEAD_BYTES = 65536
"""Marks are looked for in this much of a file; the whole file is then held to what was found."""
HEAD_LINES = 32
"""Lines that the head has at least, however long they are."""
WHOLE_BYTES = 8 * 2**20
"""Text up to this size is decoded once and kept; of a longer one only the head is."""
LONGEST_LINE_BYTES = 32 * 2**20

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
    most_bytes: int = 0

    def error(
        self, message: str, *, code: str = "RF101", line: int | None = None, key: str = "", fix: str = ""
    ) -> DataError:
        """Return (not raise) an error that names this file."""
        return DataError(message, code=code, path=self.shown, line=line, key=key, fix=fix)

    @property
    def is_packed(self) -> bool:
        """Return whether the content is gzip."""
        return self.file.part(0, len(GZIP_MAGIC)) == GZIP_MAGIC

    def unpacked(self) -> Iterator[bytes]:
        """Return an iterator over the file's content in blocks, unpacked where it is gzip; the whole is never held."""
        start = self.file.part(0, len(GZIP_MAGIC))
        if not start:
            raise self.error("the file is empty (0 bytes)", fix="record or copy it again")
        if start == GZIP_MAGIC:
            return self._gunzipped()
        if self.path.suffix.lower() == ".gz":
            fix = "rename the file without .gz, or copy it again"
            raise self.error("the name ends in .gz, but the content is not gzip", fix=fix)
        if self.most_bytes:
            return iter((self.file.part(0, min(self.most_bytes, self.file.size)),))
        return self.file.blocks()

    def _gunzipped(self) -> Iterator[bytes]:
        n_bytes = 0
        try:
            for block in _inflated(self.file.blocks()):
                yield block[: self.most_bytes - n_bytes] if self.most_bytes else block
                n_bytes += len(block)
                if 0 < self.most_bytes <= n_bytes:
                    return
                if n_bytes > MOST_UNPACKED_BYTES:
                    fix = "check what it holds; unpack it, and split it, if it is a recording"
                    most = f"{MOST_UNPACKED_BYTES / 2**30:g} GB"
                    raise self.error(f"the file unpacks to more than {most}", fix=fix)
        except zlib.error as error:
            fix = "copy the file again from the logger"
            raise self.error(f"the gzip data are damaged or cut off ({error})", fix=fix) from None
        if not n_bytes:
            raise self.error("the file is empty (gzip of 0 bytes)")

    def raw_bytes(self) -> bytes:
        """Return the file's content as it is on disk."""
        data = self.file.read()
        if not data:
            raise self.error("the file is empty (0 bytes)", fix="record or copy it again")
        return data


def _inflated(packed: Iterator[bytes]) -> Iterator[bytes]:
    """Yield what gzip has packed, a block at most at a time; a file may have several members and zeros at its end."""
    unpacker = zlib.decompressobj(_GZIP)
    for block in packed:
        rest = block
        while rest:
            if unpacker.eof:
                rest = rest.lstrip(b"\0")
                if not rest:
                    break
                unpacker = zlib.decompressobj(_GZIP)
            yield unpacker.decompress(rest, BLOCK_BYTES)
            rest = unpacker.unused_data or unpacker.unconsumed_tail
    yield unpacker.flush()  # some kilobytes at most
    if not unpacker.eof:
        raise zlib.error("the end is missing")


@dataclass(frozen=True, slots=True, kw_only=True)
class Text:
    r"""A text file's content: UTF-8 without byte-order mark, every line, the last one too, ending in `\n`.

    Or a part of it, from a line of the file on.
    """

    source: Source
    data: bytes
    encoding: str
    is_whole: bool = True
    is_ended: bool = True
    first_line: int = 1
    cut: Callable[[bytes, bool], bytes] | None = None

    def blocks(self, line: int = 1) -> Iterator["Block"]:
        """Return an iterator over pieces of whole lines, from a 1-based line on."""
        for block in (Block(self.first_line, self.data, 0),) if self.is_whole else self._read():
            start = start_of_line(block.data, line - block.line + 1)
            if start < len(block.data):
                yield Block(max(line, block.line), block.data, start)

    def _read(self) -> Iterator["Block"]:
        held = Block(1, b"", 0)  # the end is cut in one piece that is not small
        for block in _clean_blocks(self.source.unpacked(), self.encoding, self.source):
            if held.data and len(block.data) >= HEAD_BYTES:
                yield held
                held = block
            else:
                held = held._replace(data=held.data + block.data)
        is_ended = held.data.endswith(b"\n")
        data = held.data if is_ended else held.data + b"\n"
        yield held._replace(data=self.cut(data, is_ended) if self.cut is not None else data)

    def whole(self) -> "Text":
        """Return the text held whole, however long it is."""
        ended = [self.is_ended]

        def look(data: bytes, is_ended: bool) -> bytes:  # noqa: FBT001
            ended.append(is_ended)
            return data

        blocks = (self if self.is_whole else replace(self, cut=look)).blocks()
        data = b"".join(block.data for block in blocks)
        return replace(self, data=data, is_whole=True, is_ended=ended[-1])

    def part(self, start: int, stop: int) -> "Text":
        """Return some bytes of a text that is held whole, as a text of their own."""
        first_line, is_ended = 1 + self.data.count(b"\n", 0, start), self.is_ended or stop < len(self.data)
        return replace(self, data=self.data[start:stop], first_line=first_line, is_ended=is_ended)

    def without_end(self, data_row: int, cut: Callable[[bytes, bool], bytes]) -> "Text":
        """Return the text whose rows from a line on end as `cut` says of them and of whether their last line ends."""
        if not self.is_whole:
            return replace(self, cut=cut)
        start = start_of_line(self.data, data_row - self.first_line + 1)
        return replace(self, data=self.data[:start] + cut(self.data[start:], self.is_ended))

    @property
    def end_of_head(self) -> int:
        """Return where the lines to look at end: after `HEAD_BYTES`, but at least after some lines; never within one."""
        n = len(self.data)
        by_size = n if n <= HEAD_BYTES else self.data.rfind(b"\n", 0, HEAD_BYTES) + 1
        return max(by_size, start_of_line(self.data, HEAD_LINES + 1))

    def line(self, number: int) -> str:
        """Return the text of a 1-based line, "" where there is none."""
        return next((line for _, line in self.lines_from(number)), "")

    def lines_from(self, number: int) -> Iterator[tuple[int, str]]:
        """Return an iterator over the file's lines with their numbers, from a 1-based line on."""
        for block in self.blocks(number):
            yield from block.lines()

    def rows_from(self, number: int, separator: str) -> Iterator[tuple[int, list[str]]]:
        """Return an iterator over the cells of the lines that are not blank, with their numbers."""
        lines = self.lines_from(number)
        return ((n, split_line(line, separator)) for n, line in lines if not is_blank_line(line, separator))


class Block(NamedTuple):
    """Whole lines of a text from a byte on, and the number of the first of them; earlier lines are skipped."""

    line: int
    data: bytes
    start: int

    def __contains__(self, part: object) -> bool:
        return isinstance(part, bytes) and self.data.find(part, self.start) >= 0

    def lines(self) -> Iterator[tuple[int, str]]:
        """Return an iterator over the lines with their numbers."""
        return enumerate(self.data[self.start : -1].decode(errors="replace").split("\n"), start=self.line)


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
    head = next(source.file.blocks(HEAD_BYTES), b"")[:HEAD_BYTES]
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
    start, is_whole = _first_bytes(source)

    def blocks() -> Iterator[bytes]:
        return iter([start]) if is_whole else source.unpacked()

    found = encoding or _marked_encoding(start) or ("utf-8" if _is_utf8(blocks(), source) else "cp1252")
    data = b""
    for block in _clean_blocks(blocks(), found, source):
        data += block.data
        if not is_whole and len(data) >= HEAD_BYTES and data.count(b"\n") >= HEAD_LINES:
            break
    if data.isspace() or not data:
        raise source.error("the file holds nothing but blanks", fix="record or copy it again")
    is_ended = data.endswith(b"\n")
    data = data if is_ended else data + b"\n"
    return Text(source=source, data=data, encoding=found, is_whole=is_whole, is_ended=is_ended)


def _marked_encoding(start: bytes) -> str:
    """Return the encoding that a byte-order mark states, "" where there is none."""
    return next((name for mark, name in _MARKS if start.startswith(mark)), "")


def _first_bytes(source: Source) -> tuple[bytes, bool]:
    """Return the content of a file, or a little more than `WHOLE_BYTES` of it, and whether it is the whole."""
    raw, size = list[bytes](), 0
    for block in source.unpacked():
        raw.append(block)
        size += len(block)
        if size > WHOLE_BYTES:
            break
    return b"".join(raw), size <= WHOLE_BYTES


def _is_utf8(blocks: Iterable[bytes], source: Source) -> bool:
    try:
        deque(_to_utf8(blocks, "utf-8", source), maxlen=0)
    except DataError as error:
        if error.code != "RF108":
            raise
        return False
    return True


def _clean_blocks(blocks: Iterable[bytes], encoding: str, source: Source) -> Iterator[Block]:
    r"""Give pieces of whole lines in UTF-8 that end in `\n`; a last line that nothing ends comes as it is."""
    line, rest = 1, b""
    for decoded in _to_utf8(blocks, encoding, source):
        if not decoded:
            continue
        data = rest + decoded
        if b"\r" in data:
            whole = data.removesuffix(b"\r")  # half of a line's end, perhaps
            data = whole.replace(b"\r\n", b"\n").replace(b"\r", b"\n") + data[len(whole) :]
        cut = data.rfind(b"\n") + 1
        whole, rest = data[:cut], data[cut:]
        if len(rest) > LONGEST_LINE_BYTES:
            why = f"the line has more than {LONGEST_LINE_BYTES // 2**20} million characters: this is no table"
            line, fix = line + whole.count(b"\n"), "check that this is the recording"
            raise source.error(why, line=line, fix=fix)
        if whole:
            yield Block(line, _without_zeros(whole, line, source), 0)
            line += whole.count(b"\n")
    if rest and not source.most_bytes:  # where a part ends, a line is cut
        last = rest.removesuffix(b"\r") + (b"\n" if rest.endswith(b"\r") else b"")
        yield Block(line, _without_zeros(last, line, source), 0)


def _without_zeros(data: bytes, line: int, source: Source) -> bytes:
    """Return lines without the zero that ends a line's string in C; any other zero is refused."""
    data = data.replace(b"\0\n", b"\n")
    at = data.find(b"\0")
    if at >= 0:
        why = "this is not a text file: a byte is zero"
        encoding = 'the encoding ([import] encoding = "utf-16-le") where it is text'
        fix = f'name the format ([import] format = "matlab", "tdms" or "excel"), or {encoding}'
        line += data.count(b"\n", 0, at)
        if line > HEAD_LINES:
            why, fix = "from here on bytes are zero: the logger or a copy lost them", "copy the file again"
        raise source.error(why, line=line, fix=fix)
    return data


def _to_utf8(blocks: Iterable[bytes], encoding: str, source: Source) -> Iterator[bytes]:
    def refused(why: str, fix: str, line: int | None = None) -> DataError:
        return source.error(why, code="RF108", line=line, key="[import] encoding", fix=fix)

    try:
        with suppress(ValueError, Warning):
            b"0,1\n".decode(encoding)  # which refuses codecs that are no encodings of text
        decoder = codecs.getincrementaldecoder(encoding)()
    except LookupError:
        fix = 'use "utf-8", "cp1252" or "utf-16", or leave it out'
        raise refused(f"there is no text encoding {encoding!r}", fix) from None
    line, is_first, keeps_ascii = 1, True, encoding in ("utf-8", "utf-8-sig", "cp1252")
    for block in chain(blocks, (None,)):
        try:
            if block is not None and keeps_ascii and block.isascii() and not decoder.getstate()[0]:
                yield block
            else:
                text = decoder.decode(block or b"", final=block is None and not source.most_bytes)
                yield (text.removeprefix("\ufeff") if is_first else text).encode()
        except (ValueError, Warning) as error:  # an encoding may be refused for its own reasons
            at, reason = None, str(error)
            if isinstance(error, UnicodeDecodeError):
                at = line + error.object.count(b"\n", 0, error.start)
                reason = f"byte 0x{error.object[error.start]:02x} has no meaning there"
            fix = "name its encoding, or save it as UTF-8; a binary file needs [import] format"
            raise refused(f"the file cannot be read as {encoding}: {reason}", fix, at) from None
        is_first = False
        line += block.count(b"\n") if block else 0
