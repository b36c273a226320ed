"""Look at a recording file without knowing it: what is in it, and which import profile would read it."""

from dataclasses import replace
from itertools import islice
from pathlib import Path, PurePath

from ropefric.errors import DataError
from ropefric.files.read import use_file
from ropefric.traces.readers import find_reader
from ropefric.traces.readers.cells import split_line
from ropefric.traces.readers.delimited import open_text
from ropefric.traces.readers.dialect import Dialect
from ropefric.traces.readers.inspection import ColumnSummary, Inspection
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.profile_toml import profile_to_toml
from ropefric.traces.readers.sidebyside import find_blocks
from ropefric.traces.readers.source import Source
from ropefric.traces.readers.summary import summarise
from ropefric.traces.readers.text import Text

__all__ = ["ColumnSummary", "Inspection", "inspect_file", "profile_to_toml"]

N_FIRST_ROWS = 5
_TEXT_FORMATS = ("delimited", "wide")


def inspect_file(
    path: str | PurePath, profile: ImportProfile | None = None, *, shown_as: str = ""
) -> Inspection:
    r"""Return what can be found out about a recording file, and the profile that would read it.

    Parameters
    ----------
    path : str or path
        The file.
    profile : ImportProfile, optional
        What is known already; it holds.
    shown_as : str
        What messages and the result call the file; its path as given where empty.

    Raises
    ------
    DataError
        As `read_recordings`, where the file cannot be read in any way. An ambiguous decimal mark and a header
        that does not fit its rows become doubts instead.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder) / "pull.csv"
    ...     _ = path.write_text("Time (ms);Force (kN)\n0;0,5\n10;0,75\n20;1,0\n")
    ...     found = inspect_file(path, shown_as="pull.csv")
    >>> found.decimal, found.sampling_rate_Hz, found.columns[1].maximum
    (',', 100.0, 1.0)
    """
    shown, known = shown_as or str(path), profile or ImportProfile()
    return use_file(
        path, lambda file: _inspect(Source(path=Path(path), shown=shown, file=file), known), shown=shown
    )


def _inspect(source: Source, profile: ImportProfile) -> Inspection:
    reader = find_reader(source.path, profile, shown_as=source.shown)
    if reader.name in _TEXT_FORMATS:
        return _inspect_text(source, profile)
    found = Inspection(file=source.shown, format=reader.name, profile=replace(profile, format=reader.name))
    return summarise(found, reader.tables(source, profile))


def _inspect_text(source: Source, profile: ImportProfile) -> Inspection:
    doubts = []
    decimal_is_open = False
    try:
        text, dialect = open_text(source, profile)
    except DataError as error:
        if error.code != "RF104" or profile.decimal:
            raise
        doubts.append(str(error))
        decimal_is_open = True  # in the profile too, so that reading still refuses until somebody decides
        profile = replace(profile, decimal=",")
        text, dialect = open_text(source, profile)
    profile = find_blocks(text, dialect, profile) or replace(
        profile, header_row=dialect.header_row, units_row=dialect.units_row, data_row=dialect.data_row
    )
    reader = find_reader(source.path, replace(profile, format="delimited"))
    try:
        tables = reader.tables(source, profile)
    except DataError as error:
        if error.code != "RF103" or profile.header_row == 0:
            raise
        doubts.append(str(error))
        profile = replace(profile, header_row=0, units_row=0)
        text, dialect = open_text(source, profile)
        tables = reader.tables(source, profile)
    style = dialect.style
    encoding = "" if text.encoding in {"utf-8", "utf-8-sig"} else text.encoding
    decimal = "" if decimal_is_open else style.decimal
    found = Inspection(
        file=source.shown,
        format=reader.name,
        encoding=text.encoding,
        separator=style.separator,
        decimal=style.decimal,
        header_row=profile.header_row,
        units_row=profile.units_row,
        data_row=profile.data_row,
        first_rows=_first_rows(text, dialect),
        profile=replace(
            profile, format=reader.name, separator=style.separator, decimal=decimal, encoding=encoding
        ),
        doubts=tuple(doubts),
    )
    return summarise(found, tables)


def _first_rows(text: Text, dialect: Dialect) -> tuple[tuple[str, ...], ...]:
    lines = islice(text.lines_from(dialect.data_row), N_FIRST_ROWS)
    return tuple(tuple(split_line(line, dialect.style.separator)) for _, line in lines)
