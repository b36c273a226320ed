"""The import profile: how the columns of a recording file are to be understood; and what a reader makes of them."""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from ropefric.arrays import FloatArray
from ropefric.files.text_table import TableLayout

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+", re.ASCII)
_TEXTS = ("format", "separator", "decimal", "encoding", "table", "date_order", "time_zone")
_ROWS = ("header_row", "units_row", "data_row", "block_columns", "block_names_row", "skip_footer")


@dataclass(frozen=True, slots=True, kw_only=True)
class Channel:
    """One column of the file."""

    column: str | int
    unit: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ImportProfile(TableLayout):
    """How to read a file."""

    format: str = "auto"
    channels: Mapping[str, Channel] = field(default_factory=dict)
    sampling_rate_Hz: float | None = None
    constants: Mapping[str, float] = field(default_factory=dict)
    derived: Mapping[str, str] = field(default_factory=dict)
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
    notes: tuple[str, ...] = ()


def profile_to_toml(profile: ImportProfile) -> str:
    r"""Return the `[import]` section that says what a profile says; what is left open is left out.

    Constants are written as bare SI numbers.
    """
    default = ImportProfile()
    lines = ["[import]"]
    for key in (*_TEXTS, *_ROWS):
        value = getattr(profile, key)
        if value != getattr(default, key):
            lines.append(f"{key} = {value if key in _ROWS else _string(value)}")
    if profile.sampling_rate_Hz is not None:
        lines.append(f'sampling_rate = "{float(profile.sampling_rate_Hz)!r} Hz"')
    if profile.missing:
        lines.append(f"missing = [{', '.join(_string(text) for text in profile.missing)}]")
    for section, rows in (
        ("channels", {name: _channel(channel) for name, channel in profile.channels.items()}),
        ("constants", {name: repr(float(value)) for name, value in profile.constants.items()}),
        ("derived", {name: _string(formula) for name, formula in profile.derived.items()}),
    ):
        if rows:
            lines += ["", f"[import.{section}]"]
            lines += [
                f"{name if _BARE_KEY.fullmatch(name) else _string(name)} = {row}"
                for name, row in rows.items()
            ]
    return "\n".join(lines) + "\n"


def _channel(channel: Channel) -> str:
    column = channel.column if isinstance(channel.column, int) else _string(channel.column)
    if channel.unit:
        return f"{{ column = {column}, unit = {_string(channel.unit)} }}"
    return str(column) if isinstance(channel.column, str) else f"{{ column = {column} }}"


def _string(text: str) -> str:
    # JSON's escapes are TOML's, but for the delete character.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
