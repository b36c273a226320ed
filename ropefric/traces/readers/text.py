"""Bytes to clean text: encoding found, line ends alike, nothing binary."""

from collections.abc import Iterator
from dataclasses import dataclass

from ropefric.errors import DataError
from ropefric.traces.readers.source import Source

__all__ = ["Text", "load_text"]

_MARKS = (  # UTF-32 first: its little-endian mark starts with UTF-16's
    (b"\xff\xfe\x00\x00", "utf-32"),
    (b"\x00\x00\xfe\xff", "utf-32"),
    (b"\xff\xfe", "utf-16"),
    (b"\xfe\xff", "utf-16"),
    (b"\xef\xbb\xbf", "utf-8-sig"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Text:
    r"""A text file's content.

    Attributes
    ----------
    source : Source
        The file.
    data : bytes
        UTF-8 without byte-order mark; every line, the last one too, ends in `\n`.
    encoding : str
        How the file itself is encoded.
    is_ended : bool
        Whether the file's own last line ends; where not, the file may have been cut within it.
    """

    source: Source
    data: bytes
    encoding: str
    is_ended: bool = True

    def start_of(self, line: int) -> int:
        """Return the byte at which a 1-based line starts; the end of the data where there is no such line."""
        start = 0
        for _ in range(line - 1):
            start = self.data.find(b"\n", start) + 1
            if start == 0:
                return len(self.data)
        return start

    def line(self, number: int) -> str:
        """Return the text of a 1-based line, "" where there is none."""
        begin = self.start_of(number)
        return self.data[begin : max(self.data.find(b"\n", begin), begin)].decode(errors="replace")

    def lines_from(self, number: int) -> Iterator[tuple[int, str]]:
        """Return an iterator over the file's lines with their numbers, from a 1-based line on."""
        body = self.data[self.start_of(number) : -1].decode(errors="replace")
        return enumerate(body.split("\n"), start=number)


def load_text(source: Source, encoding: str = "") -> Text:
    r"""Return a file's text, unpacked and decoded.

    Without an encoding a byte-order mark decides, else UTF-8, else cp1252, which is what Windows loggers
    write. Old Macintosh and Windows line ends become `\n`.

    Parameters
    ----------
    source : Source
        The file.
    encoding : str
        Its encoding; "" to find out.

    Raises
    ------
    DataError
        RF101 where the file cannot be read or is binary, RF108 where it cannot be decoded.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder) / "a.csv"
    ...     _ = path.write_bytes("Kraft [N]\r\n1 µ".encode("cp1252"))
    ...     text = load_text(Source(path=path, shown="a.csv"))
    >>> text.encoding, text.data
    ('cp1252', b'Kraft [N]\n1 \xc2\xb5\n')
    """
    raw = source.read_bytes()
    data, found = _to_utf8(raw, encoding, source)
    if b"\0" in data:
        at = data.index(b"\0")
        raise source.error(
            f"this is not a text file: byte {at} is zero",
            line=data.count(b"\n", 0, at) + 1,
            fix='name the format ([import] format = "matlab", "tdms" or "excel"), or the encoding '
            '([import] encoding = "utf-16-le") where it is text',
        )
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    if data.isspace() or not data:
        raise source.error("the file holds nothing but blanks", fix="record or copy it again")
    is_ended = data.endswith(b"\n")
    return Text(source=source, data=data if is_ended else data + b"\n", encoding=found, is_ended=is_ended)


def _to_utf8(raw: bytes, encoding: str, source: Source) -> tuple[bytes, str]:
    if not encoding:
        if raw.isascii():
            return raw, "utf-8"
        for mark, name in _MARKS:
            if raw.startswith(mark):
                return _decode(raw, name, source).encode(), name
        try:
            raw.decode("utf-8")
        except UnicodeDecodeError:
            return _decode(raw, "cp1252", source).encode(), "cp1252"
        return raw, "utf-8"
    text = _decode(raw, encoding, source).removeprefix("\ufeff")
    try:
        return text.encode(), encoding
    except UnicodeEncodeError as error:
        raise _undecodable(encoding, str(error), source) from None


def _decode(raw: bytes, encoding: str, source: Source) -> str:
    try:
        return raw.decode(encoding)
    except LookupError:
        raise source.error(
            f"there is no text encoding {encoding!r}",
            code="RF108",
            key="[import] encoding",
            fix='use "utf-8", "cp1252" or "utf-16", or leave it out',
        ) from None
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise _undecodable(
            encoding, f"byte 0x{raw[error.start]:02x} has no meaning there", source, line
        ) from None
    except (ValueError, Warning) as error:  # an encoding may be refused for its own reasons
        raise _undecodable(encoding, str(error), source) from None


def _undecodable(encoding: str, reason: str, source: Source, line: int | None = None) -> DataError:
    return source.error(
        f"the file cannot be read as {encoding}: {reason}",
        code="RF108",
        line=line,
        key="[import] encoding",
        fix="name its encoding, or save it as UTF-8; a binary file needs [import] format",
    )
