"""The import profile: how the columns of a recording file are to be understood; and what a reader makes of them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ropefric.arrays import FloatArray
from ropefric.files.text_table import TableLayout
from ropefric.files.toml_edit import toml_key, toml_value

_TEXTS = (
    *("format", "separator", "decimal", "thousands", "encoding", "table", "date_order"),
    *("recording_column", "channel_column", "value_column"),
)
_ROWS = ("header_row", "units_row", "data_row", "block_columns", "block_names_row", "skip_footer")


@dataclass(frozen=True, slots=True, kw_only=True)
class Channel:
    """One column of the file: its unit, what a signal of that unit means, its own time and its own tare.

    `tare_s` is the interval in which it is unloaded, () for none, None for that of the campaign; `instead_of` is the
    unit that the file wrongly states.
    """

    column: str | int
    unit: str = ""
    sensitivity: str = ""
    time: str | int = ""
    tare_s: tuple[float, ...] | None = None
    instead_of: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ImportProfile(TableLayout):
    """How to read a file."""

    format: str = "auto"
    channels: Mapping[str, Channel] = field(default_factory=dict)
    sampling_rate_Hz: float | None = None
    constants: Mapping[str, float] = field(default_factory=dict)
    derived: Mapping[str, str] = field(default_factory=dict)
    table: str = ""
    recording_column: str | int = ""
    channel_column: str | int = ""
    value_column: str | int = ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RawRecording:
    """Columns as a reader found them, before units, clock and calibration.

    `clocks` are the times [s] of channels that have one of their own, the same array where they share it; `rate_Hz`
    is the sampling rate that the head of the file states.
    """

    name: str
    source: str
    sample: str
    columns: Mapping[str, FloatArray]
    units: Mapping[str, str]
    first_line: int = 0
    notes: tuple[str, ...] = ()
    clocks: Mapping[str, FloatArray] = field(default_factory=dict)
    rate_Hz: float | None = None


def profile_to_toml(profile: ImportProfile) -> str:
    r"""Return the `[import]` section of a profile, without keys that are left open.

    Constants are written as bare SI numbers.
    """
    default = ImportProfile()
    lines = ["[import]"]
    for key in (*_TEXTS, *_ROWS):
        value = getattr(profile, key)
        if value != getattr(default, key):
            lines.append(f"{key} = {toml_value(value)}")
    if profile.sampling_rate_Hz is not None:
        lines.append(f'sampling_rate = "{float(profile.sampling_rate_Hz)!r} Hz"')
    if profile.missing:
        lines.append(f"missing = {toml_value(profile.missing)}")
    for section, rows in (
        (
            "channels",
            {name: toml_value(channel_value(channel)) for name, channel in profile.channels.items()},
        ),
        ("constants", {name: repr(float(value)) for name, value in profile.constants.items()}),
        ("derived", {name: toml_value(formula) for name, formula in profile.derived.items()}),
    ):
        if rows:
            lines += ["", f"[import.{section}]"]
            lines += [f"{toml_key(name)} = {row}" for name, row in rows.items()]
    return "\n".join(lines) + "\n"


def channel_value(channel: Channel) -> str | dict[str, Any]:
    """Return a channel as a campaign file has it: the header of its column alone, or a table."""
    tare = None if channel.tare_s is None else [f"{time_s!r} s" for time_s in channel.tare_s] or "none"
    keys = {
        "column": channel.column,
        "unit": channel.unit,
        "sensitivity": channel.sensitivity,
        "time": channel.time,
        "tare": tare,
        "instead_of": channel.instead_of,
    }
    given = {key: value for key, value in keys.items() if value}
    return channel.column if len(given) == 1 and isinstance(channel.column, str) else given
