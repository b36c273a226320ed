"""The import profile: how the columns of a recording file are to be understood."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

__all__ = ["Channel", "ImportProfile", "RawRecording"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Channel:
    """One column of the file.

    Attributes
    ----------
    column : str or int
        The column's header, or its 1-based number (within a block, for wide files).
    unit : str
        Its unit as the file has it ("ms", "kN"); "" takes the unit from the units row or the header's suffix.
        Channel `counts` has none.
    """

    column: str | int
    unit: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ImportProfile:
    """How to read a file.

    Attributes
    ----------
    format : str
        Name of a reader, or "auto": by the file's suffix.
    separator : str
        Between columns; " " stands for any white space, "" for "find out" (refused where ambiguous).
    decimal : str
        "." or ","; "" for "find out" (refused where ambiguous).
    encoding : str
        "" tries UTF-8 (with or without byte-order mark), then cp1252.
    header_row, units_row, data_row : int
        1-based line numbers in the file; 0 = there is none (header, units) or "after the header" (data).
        `header_row = -1` means "find out".
    channels : mapping of str to Channel
        Channels by name. `time`, `force` and `counts` have a meaning of their own, others serve `derived`.
    sampling_rate_Hz : float, optional
        Used where there is no time channel.
    constants : mapping of str to float
        Named SI numbers for `derived`.
    derived : mapping of str to str
        Channels computed from others, all in SI: `force = "pull - pressure * area"`.
    missing : tuple of str
        Cell texts that mean "no value", beside empty and NaN.
    block_columns : int
        Wide files: columns per recording; 0 for ordinary files.
    block_names_row : int
        Wide files: 1-based line that names the recordings; 0 numbers them.
    table : str
        Excel sheet, MATLAB variable or TDMS group; "" for the first.
    """

    format: str = "auto"
    separator: str = ""
    decimal: str = ""
    encoding: str = ""
    header_row: int = -1
    units_row: int = 0
    data_row: int = 0
    channels: Mapping[str, Channel] = field(default_factory=dict)
    sampling_rate_Hz: float | None = None
    constants: Mapping[str, float] = field(default_factory=dict)
    derived: Mapping[str, str] = field(default_factory=dict)
    missing: tuple[str, ...] = ()
    block_columns: int = 0
    block_names_row: int = 0
    table: str = ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RawRecording:
    """Columns as a reader found them, before units, clock and calibration.

    Attributes
    ----------
    name : str
        File name, with the block's name for wide files: "pulls.csv#Sample 5".
    source : str
        Path as given.
    sample : str
        Block name within the file, "" for ordinary files.
    columns : mapping of str to ndarray
        The columns the profile's channels name, by channel name, float64, NaN where a cell is empty.
    units : mapping of str to str
        Unit per channel as far as file or profile tell, "" where unknown.
    first_line : int
        1-based file line of the first sample, if sample i stands in line `first_line + i`; 0 where unknown.
    """

    name: str
    source: str
    sample: str
    columns: Mapping[str, npt.NDArray[np.float64]]
    units: Mapping[str, str]
    first_line: int = 0
