"""Recording files: one reader a format, found by name or by the file's ending."""

from pathlib import Path, PurePath

from ropefric.errors import DataError
from ropefric.files.read import InputFile, use_file
from ropefric.registry import Registry
from ropefric.traces.readers import delimited, excel, matlab, tdms, wide
from ropefric.traces.readers.profile import ImportProfile, RawRecording
from ropefric.traces.readers.reader import Reader
from ropefric.traces.readers.source import Source

__all__ = ["READERS", "TEXT_FORMATS", "find_reader", "read_recordings"]

TEXT_FORMATS = (delimited.READER.name, wide.READER.name)

READERS: Registry[Reader] = Registry(
    "file format", [delimited.READER, wide.READER, matlab.READER, tdms.READER, excel.READER]
)
"""Every reader by name."""


def find_reader(path: str | PurePath, profile: ImportProfile, *, shown_as: str = "") -> Reader:
    """Return the reader of a file: the profile's format, else by the end of the file's name.

    Parameters
    ----------
    path : str or path
        The file; it is not opened.
    profile : ImportProfile
        `format` "auto" goes by the name; text with `block_columns` set is wide.
    shown_as : str
        What the message calls the file.

    Raises
    ------
    UnknownNameError
        If there is no such format.
    DataError
        RF101, if the name's end belongs to no reader.

    Examples
    --------
    >>> find_reader("pull.CSV.gz", ImportProfile()).name
    'delimited'
    >>> find_reader("pulls.csv", ImportProfile(block_columns=4)).name
    'wide'
    """
    if profile.format != "auto":
        reader = READERS[profile.format]
    else:
        name = PurePath(path).name.lower()
        fitting = [reader for reader in READERS.values() if name.endswith(reader.suffixes)]
        if not fitting:
            endings = ", ".join(suffix for reader in READERS.values() for suffix in reader.suffixes)
            raise DataError(
                f"no reader is known for files that end in {PurePath(path).suffix or 'nothing'!r}; "
                f"known endings: {endings}",
                path=shown_as or str(path),
                key="[import] format",
                fix=f'name the format, for example format = "delimited"; known: {", ".join(READERS)}',
            )
        reader = fitting[0]
    return wide.READER if reader is delimited.READER and profile.block_columns > 0 else reader


def read_recordings(
    path: str | PurePath, profile: ImportProfile, *, shown_as: str = "", file: InputFile | None = None
) -> tuple[RawRecording, ...]:
    r"""Return the recordings of a file, columns as they are in it.

    Parameters
    ----------
    path : str or path
        The file; `.gz` of a text file is unpacked.
    profile : ImportProfile
        How to understand it; what it leaves open is found out or refused.
    shown_as : str
        What messages and results call the file; its path as given where empty.
    file : InputFile, optional
        The file, where it is open already; it stays open.

    Returns
    -------
    tuple of RawRecording
        One, or one per block of a wide file.

    Raises
    ------
    DataError
        RF101 unreadable or empty, RF102 a cell is no number, RF103 ragged rows, RF104 ambiguous separator or
        decimal mark, RF105 no such column, RF107 a package is missing, RF108 encoding; with path, and line
        and column where there is one.
    InputError
        RF110, if the profile contradicts itself.
    UnknownNameError
        RF120, if `profile.format` is not known.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder) / "pull.csv"
    ...     _ = path.write_text("t_ms;F_kN\n0;0,5\n10;0,75\n")
    ...     (recording,) = read_recordings(path, ImportProfile(), shown_as="pull.csv")
    >>> recording.columns["force"], recording.units
    (array([0.5 , 0.75]), {'time': 'ms', 'force': 'kN'})
    """
    shown = shown_as or str(path)

    def read(opened: InputFile) -> tuple[RawRecording, ...]:
        source = Source(path=Path(path), shown=shown, file=opened)
        return find_reader(path, profile, shown_as=shown).read(source, profile)

    return use_file(path, read, shown=shown) if file is None else read(file)
