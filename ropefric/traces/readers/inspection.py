"""What is found out about a recording file."""

from dataclasses import asdict, dataclass, field
from typing import Any

from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.profile_toml import profile_to_toml


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnSummary:
    """One column of the file, in the file's own unit."""

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
    """How a recording file looks, and the import profile that would read it."""

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
        r"""Return the inspection for JSON, the profile as its TOML text."""
        result = {name: getattr(self, name) for name in self.__slots__ if name not in ("profile", "columns")}
        result["samples"], result["saturation"] = list(self.samples), list(self.saturation)
        result["first_rows"] = [list(row) for row in self.first_rows]
        result["doubts"] = list(self.doubts)
        result["columns"] = [asdict(column) for column in self.columns]
        result["profile_toml"] = profile_to_toml(self.profile)
        return {"schema": "ropefric.inspection/1", **result}
