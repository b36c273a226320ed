"""The import profile: how the columns of a recording file are to be understood."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from ropefric.arrays import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Channel:
    """One column of the file."""

    column: str | int
    unit: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ImportProfile:
    """How to read a file."""

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
    """Columns as a reader found them, before units, clock and calibration."""

    name: str
    source: str
    sample: str
    columns: Mapping[str, FloatArray]
    units: Mapping[str, str]
    first_line: int = 0
