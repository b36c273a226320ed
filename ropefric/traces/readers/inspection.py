"""What is found out about a recording file."""

from dataclasses import asdict, dataclass, field
from typing import Any

from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.profile_toml import profile_to_toml

__all__ = ["ColumnSummary", "Inspection"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnSummary:
    """One column of the file, in the file's own unit.

    Attributes
    ----------
    number : int
        1-based; within a recording for wide files.
    name : str
        Its header, "" where it has none.
    unit : str
        Its unit as far as the file tells, else "".
    minimum, maximum : float or None
        Range of its values; None where it holds text or nothing.
    n_missing : int
        Empty cells.
    is_numeric, is_integer : bool
        Whether all its values are numbers, whole numbers.
    """

    number: int
    name: str
    unit: str
    minimum: float | None
    maximum: float | None
    n_missing: int
    is_numeric: bool
    is_integer: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Inspection:
    """How a recording file looks, and the import profile that would read it.

    Attributes
    ----------
    file : str
        The file, as its owner wrote it.
    format : str
        Name of the reader.
    encoding, separator, decimal : str
        As found; "" for binary formats.
    header_row, units_row, data_row : int
        1-based lines; 0 where there is none.
    columns : tuple of ColumnSummary
        Columns of the (first) recording.
    n_rows : int
        Samples of the (first) recording, as far as they were read.
    n_rows_about : int
        Of a large file, of which only a part was read: how many there may be; 0 where `n_rows` is all.
    samples : tuple of str
        Names of the recordings in a wide file; empty for an ordinary one.
    sampling_rate_Hz : float or None
        Mean rate, gaps left out, of the column that looks like the time; None where its unit is unknown.
    is_uniform : bool
        Whether its steps are within 5 % of their mean.
    saturation : tuple of str
        Columns that sit at a converter's limit.
    first_rows : tuple of tuple of str
        The first data rows as text; empty for binary formats.
    profile : ImportProfile
        What to write into `[import]`; channels that nobody can guess are left out.
    doubts : tuple of str
        What somebody who knows the recording should check.
    """

    file: str
    format: str
    encoding: str = ""
    separator: str = ""
    decimal: str = ""
    header_row: int = 0
    units_row: int = 0
    data_row: int = 0
    columns: tuple[ColumnSummary, ...] = ()
    n_rows: int = 0
    n_rows_about: int = 0
    samples: tuple[str, ...] = ()
    sampling_rate_Hz: float | None = None
    is_uniform: bool = False
    saturation: tuple[str, ...] = ()
    first_rows: tuple[tuple[str, ...], ...] = ()
    profile: ImportProfile = field(default_factory=ImportProfile)
    doubts: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        r"""Return the inspection for JSON, the profile as its TOML text.

        Examples
        --------
        >>> Inspection(file="a.csv", format="delimited").to_dict()["profile_toml"]
        '[import]\n'
        """
        result = {name: getattr(self, name) for name in self.__slots__ if name not in ("profile", "columns")}
        result["samples"], result["saturation"] = list(self.samples), list(self.saturation)
        result["first_rows"] = [list(row) for row in self.first_rows]
        result["doubts"] = list(self.doubts)
        result["columns"] = [asdict(column) for column in self.columns]
        result["profile_toml"] = profile_to_toml(self.profile)
        return {"schema": "ropefric.inspection/1", **result}
