"""The bytes of a recording file, and errors that name it."""

import gzip
import zlib
from dataclasses import dataclass
from pathlib import Path

from ropefric.errors import DataError
from ropefric.files.read import InputFile

__all__ = ["Source"]

GZIP_MAGIC = b"\x1f\x8b"


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """A file as it is opened, and as its owner wrote it.

    Attributes
    ----------
    path : Path
        Where the file is.
    shown : str
        What messages and results call it.
    file : InputFile, optional
        The file, open.

    Examples
    --------
    >>> str(Source(path=Path("/lab/run07.csv"), shown="run07.csv").error("the file is empty", fix="record again"))
    'run07.csv: the file is empty Fix: record again'
    """

    path: Path
    shown: str
    file: InputFile | None = None

    def error(
        self, message: str, *, code: str = "RF101", line: int | None = None, key: str = "", fix: str = ""
    ) -> DataError:
        """Return (not raise) an error that names this file."""
        return DataError(message, code=code, path=self.shown, line=line, key=key, fix=fix)

    def read_bytes(self) -> bytes:
        """Return the file's content, unpacked where it is gzip.

        Raises
        ------
        DataError
            RF101, if there is no such file, or it cannot be read, is empty, or is damaged gzip.
        """
        packed = self.raw_bytes()
        named_gzip = self.path.suffix.lower() == ".gz"
        if not packed.startswith(GZIP_MAGIC):
            if named_gzip:
                raise self.error(
                    "the name ends in .gz, but the content is not gzip",
                    fix="rename the file without .gz, or copy it again",
                )
            return packed
        try:
            data = gzip.decompress(packed)
        except (OSError, EOFError, zlib.error) as error:
            raise self.error(
                f"the gzip data are damaged or cut off ({error})", fix="copy the file again from the logger"
            ) from None
        if not data:
            raise self.error("the file is empty (gzip of 0 bytes)")
        return data

    def raw_bytes(self) -> bytes:
        """Return the file's content as it is on disk.

        Raises
        ------
        DataError
            RF101, if there is no such file, or it cannot be read, or is empty.
        """
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
