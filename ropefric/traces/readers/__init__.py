"""Recording files: one reader a format, found by name or by the file's ending.

In: a file and an `ImportProfile` (profile.py). Out: `RawRecording`s, columns as they are in the file. A reader opens the
file as tables (table.py says how their columns become channels): delimited.py, several.py (many recordings in a text),
and texts that declare their layout, labview.py (.lvm) and headed.py (NI, Mitsubishi); vernier.py (.cmbl), excel.py,
matlab.py, hdf5.py, tdms.py. inspection.py examines an unknown file and suggests a profile.
"""

from pathlib import Path, PurePath

from ropefric.errors import DataError
from ropefric.files.disk import InputFile, use_file
from ropefric.files.text import Source, first_lines, is_text
from ropefric.registry import Registry
from ropefric.traces.readers import excel, hdf5, headed, labview, matlab, several, tdms, vernier
from ropefric.traces.readers.delimited import DELIMITED
from ropefric.traces.readers.profile import ImportProfile, RawRecording
from ropefric.traces.readers.table import Reader

_TABLES = (DELIMITED, several.WIDE, several.STACKED, several.LONG)
TEXT_FORMATS = tuple(reader.name for reader in _TABLES)
_WITH_ONE = (vernier, matlab, hdf5, tdms, excel)

READERS: Registry[Reader] = Registry(
    "file format",
    [*_TABLES, labview.READER, headed.NI, headed.MITSUBISHI, *(module.READER for module in _WITH_ONE)],
)
"""Every reader by name."""


def find_reader(path: str | PurePath, profile: ImportProfile, source: Source | None = None) -> Reader:
    """Return the reader of a file: the profile's format, else by the end of its name, and among texts by its head."""
    if profile.format != "auto":
        reader = READERS[profile.format]
    else:
        reader = _by_ending(path, source)
        if reader is DELIMITED and source is not None:
            head = first_lines(source)
            knowing = (other for other in READERS.values() if other.recognises and other.recognises(head))
            reader = next(knowing, reader)
    return several.WIDE if reader is DELIMITED and profile.block_columns > 0 else reader


def _by_ending(path: str | PurePath, source: Source | None) -> Reader:
    """Return the first reader that knows the end of a file's name; of any other text, the one of plain tables."""
    name, is_plain = PurePath(path).name.lower(), source is not None and is_text(source)
    for reader in READERS.values():
        if name.endswith(reader.suffixes) and not (is_plain and reader is excel.READER):  # text called .xls
            return reader
    if is_plain:
        return DELIMITED
    endings = ", ".join(suffix for reader in READERS.values() for suffix in reader.suffixes)
    why = f"no reader is known for files that end in {PurePath(path).suffix or 'nothing'!r}"
    fix = f'name the format, for example format = "delimited"; known: {", ".join(READERS)}'
    where = source.shown if source else str(path)
    raise DataError(f"{why}; known endings: {endings}", path=where, key="[import] format", fix=fix)


def read_recordings(
    path: str | PurePath, profile: ImportProfile, *, shown_as: str = "", file: InputFile | None = None
) -> tuple[RawRecording, ...]:
    r"""Return the recordings of a file, columns as they are in it."""
    shown = shown_as or str(path)

    def read(opened: InputFile) -> tuple[RawRecording, ...]:
        source = Source(path=Path(path), shown=shown, file=opened)
        return find_reader(path, profile, source).read(source, profile)

    return use_file(path, read, shown=shown) if file is None else read(file)
