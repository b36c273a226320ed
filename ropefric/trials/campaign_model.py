"""A measuring campaign: the tables of campaign.toml as pydantic models in SI, and the campaign that they make."""

import hashlib
import json
import os
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, fields
from functools import partial
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self
from zoneinfo import available_timezones

from pydantic import Field, PlainValidator, model_validator
from pydantic_core import to_jsonable_python

from ropefric.errors import InputError, Problem
from ropefric.files.stamps import ORDERS
from ropefric.files.toml_model import (
    StrictTable,
    any_quantity,
    choice,
    date_text,
    fraction,
    got,
    quantity,
    reject,
    text,
    whole_number,
)
from ropefric.quantities import si_unit_of
from ropefric.traces.breakaway import ENDINGS, PEAKS, SIDES
from ropefric.traces.calibration import Adc, ForceCell
from ropefric.traces.readers.profile import Channel, ImportProfile
from ropefric.trials.workers import Limits

SCHEMA = "ropefric.campaign/1"
_plain = partial(to_jsonable_python, by_alias=False)
_SI_UNITS = {"time": "s", "force": "N"}
_SEPARATORS = {"tab": "\t", "space": " "}

# What stands in the file under the `alias` of a field is in SI under its name.
Text = Annotated[str, PlainValidator(text)]
Row = Annotated[int, PlainValidator(whole_number(0))]
Length = Annotated[float, PlainValidator(quantity("m", "40 mm", above=0))]
Force = Annotated[float, PlainValidator(quantity("N", "60 N", above=0))]
Voltage = Annotated[float, PlainValidator(quantity("V", "5 V"))]
Time = Annotated[float | None, PlainValidator(quantity("s", "0.3 s"))]
Rate = Annotated[float, PlainValidator(quantity("Hz", "3 kHz", above=0))]
Share = Annotated[float, PlainValidator(fraction("0.02 %FS"))]


class Round(StrictTable):
    """A wheel or rope: its radius [m], or its diameter instead, and what it is made of."""

    example: ClassVar[str] = 'radius = "40 mm"'
    radius_m: Length = Field(default=0.0, alias="radius")
    diameter: Length = Field(default=0.0, exclude=True)
    material: Text = ""

    @model_validator(mode="after")
    def _has_one_size(self) -> Self:
        sizes = self.model_fields_set & {"radius_m", "diameter"}
        if not sizes:
            reject("RF121", "neither radius nor diameter is given", fix=f"add {self.example}")
        if len(sizes) == 2:
            reject("RF111", "radius and diameter are both given", fix="remove one of the two", key="diameter")
        if "diameter" in sizes:
            object.__setattr__(self, "radius_m", self.diameter / 2)
        return self


class Rope(Round):
    """`[rope]`: also its mass per length [kg/m], where it is known."""

    example: ClassVar[str] = 'diameter = "9.8 mm"'
    linear_density_kg_m: Annotated[float | None, PlainValidator(quantity("kg/m", "62 g/m", above=0))] = Field(
        default=None, alias="linear_density"
    )


def _pair(value: object, what: str, like: str) -> list[object]:
    if not isinstance(value, list) or len(value) != 2:
        reject("RF110", f"expected {what}, got {got(value)}", fix=f"write {like}")
    return value


_FORCE, _VOLTAGE, _TIME = quantity("N", "500 N"), quantity("V", "2.5 V"), quantity("s", "0.3 s")


def _point(value: object) -> tuple[float, float]:
    force, voltage = _pair(value, "a pair of force and voltage", '["500 N", "2.5 V"]')
    return _FORCE(force), _VOLTAGE(voltage)


class CellTable(StrictTable):
    """`[cells.NAME]`; what is not given is as `ForceCell` has it."""

    full_scale_N: Force = Field(alias="full_scale")
    zero_V: Voltage = Field(default=0.0, alias="zero_voltage")
    full_scale_V: Voltage = Field(default=0.0, alias="full_scale_voltage")
    linearity: Share = 0.0
    hysteresis: Share = 0.0
    repeatability: Share = 0.0
    transmitter: Share = 0.0
    points: tuple[Annotated[tuple[float, float], PlainValidator(_point)], ...] = Field(
        default=(), alias="calibration_points"
    )
    serial: Text = ""
    calibrated: Annotated[str, PlainValidator(date_text)] = ""

    @model_validator(mode="after")
    def _is_possible(self) -> Self:
        try:
            self.cell("")
        except InputError as error:
            message = error.problem.message.removeprefix("force cell '': ")
            found = type(self).model_fields.get(error.problem.key)
            reject("RF110", message, fix=error.fix, key=(found and found.alias) or error.problem.key)
        return self

    def cell(self, name: str) -> ForceCell:
        """Return the cell under its name."""
        return ForceCell(name=name, **self.given)


class AdcTable(StrictTable):
    """`[adc]`."""

    bits: Annotated[int, PlainValidator(whole_number(1, 32))]
    low_V: Annotated[float, PlainValidator(quantity("V", "0 V"))] = Field(default=0.0, alias="low")
    high_V: Voltage = Field(alias="high")

    @model_validator(mode="after")
    def _has_a_range(self) -> Self:
        if not self.low_V < self.high_V:
            reject("RF111", f"the range from {self.low_V:g} V to {self.high_V:g} V is empty", key="high")
        return self


class SamplingTable(StrictTable):
    """`[sampling]`."""

    rate: Rate


def protocol_names() -> Collection[str]:
    """Return the names of all protocols."""
    from ropefric.traces.protocols import PROTOCOLS  # noqa: PLC0415  (brings the pickers, which nothing here runs)

    return tuple(PROTOCOLS)


class Protocol(StrictTable):
    """`[protocol]`: what happens in a recording, and which part of it counts."""

    name: Annotated[str, PlainValidator(choice(protocol_names))] = "breakaway"
    start_s: Time = Field(default=None, alias="from")
    stop_s: Time = Field(default=None, alias="until")
    min_step_N: Annotated[float | None, PlainValidator(quantity("N", "5 N", above=0))] = Field(
        default=None, alias="min_step"
    )
    side: Annotated[str, PlainValidator(choice(lambda: SIDES))] = "slack"
    ending: Annotated[str, PlainValidator(choice(lambda: ENDINGS))] = "sliding"

    @model_validator(mode="after")
    def _has_an_interval(self) -> Self:
        if self.start_s is not None and self.stop_s is not None and not self.start_s < self.stop_s:
            message = f"the part from {self.start_s:g} s until {self.stop_s:g} s is empty"
            reject("RF111", message, key="until")
        return self

    @property
    def needs_lift_force(self) -> bool:
        """Return whether trials give the tight side and the sensor measures the slack one."""
        return self.name == "held" and self.side == "slack"


def _interval(value: object) -> tuple[float, float]:
    like = '["0 s", "0.3 s"]'
    start_s, stop_s = (_TIME(item) for item in _pair(value, "two times", like))
    if not start_s < stop_s:
        reject("RF111", f"the interval from {start_s:g} s to {stop_s:g} s is empty", fix=f"write {like}")
    return start_s, stop_s


class TareTable(StrictTable):
    """`[tare]`."""

    interval: Annotated[tuple[float, float], PlainValidator(_interval)]


def _window_s(value: object) -> float | None:
    if value in ("auto", "none"):
        return None if value == "auto" else 0.0
    if isinstance(value, str) and not value[:1].isdigit():
        fix = 'write "auto", "none" or a time such as "10 ms"'
        reject("RF120", f"{got(value)} is no smoothing window", fix=fix)
    return _WINDOW(value)


_WINDOW = quantity("s", "10 ms", above=0)


class Smoothing(StrictTable):
    """`[smoothing]`: the window [s], 0 for none, None for one that is found for each recording."""

    window_s: Annotated[float | None, PlainValidator(_window_s)] = Field(default=None, alias="window")
    peak: Annotated[str, PlainValidator(choice(lambda: PEAKS))] = "smoothed"

    @property
    def mode(self) -> str:
        """Return "auto", "none" or "fixed"."""
        return "auto" if self.window_s is None else "fixed" if self.window_s else "none"


def _rule_names() -> Collection[str]:
    from ropefric.trials.outliers import RULES  # noqa: PLC0415  (few files name a rule)

    return tuple(RULES)


class RejectionTable(StrictTable):
    """`[rejection]`."""

    rule: Annotated[str, PlainValidator(choice(_rule_names))] = "two-sigma"


class WeightsTable(StrictTable):
    """`[weights]`."""

    tolerance: Annotated[float, PlainValidator(fraction("0.05 %"))]


class DesignWheel(StrictTable):
    """`[design]`: a wheel whose lift force is to be predicted."""

    wheel_radius_m: Annotated[float, PlainValidator(quantity("m", "35 mm", above=0))] = Field(
        alias="wheel_radius"
    )
    wrap_angle_rad: Annotated[float, PlainValidator(quantity("rad", "400 deg", above=0))] = Field(
        alias="wrap_angle"
    )
    end_tension_N: Force = Field(alias="end_tension")


class LimitsTable(StrictTable):
    """`[limits]`."""

    memory_bytes: Annotated[float, PlainValidator(quantity("byte", "2 GB", above=0))] = Field(
        default=0.0, alias="memory"
    )
    time_s: Annotated[float, PlainValidator(quantity("s", "120 s", above=0))] = Field(
        default=0.0, alias="time"
    )


def _format_names() -> Collection[str]:
    from ropefric.traces.readers import READERS  # noqa: PLC0415  (brings the readers, and few files name one)

    return ("auto", *READERS)


def _channel(value: object) -> Channel:
    if not isinstance(value, dict):
        return Channel(column=_column(value))
    unknown = sorted(value.keys() - {"column", "unit"})
    if unknown:
        reject("RF120", f"unknown key '{unknown[0]}'", fix="a channel has column and unit", key=unknown[0])
    if "column" not in value:
        reject("RF121", "'column' is missing", fix='write { column = "time_s", unit = "s" }')
    return Channel(column=_column(value["column"]), unit=_unit(value.get("unit", "")))


def _column(value: object) -> str | int:
    if isinstance(value, str) and value.strip():
        return value
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value < 2**31:
        reject("RF110", f"expected a column's header or its number from 1, got {got(value)}")
    return value


def _unit(value: object) -> str:
    unit = text(value)
    if unit:
        try:
            si_unit_of(unit)
        except InputError as error:
            reject(error.code, error.problem.message.removeprefix("quantity: "), fix=error.fix, key="unit")
    return unit


def _separator(value: object) -> str:
    separator = _SEPARATORS.get(text(value), text(value))
    if len(separator) > 1:
        fix = 'write ",", ";", "tab" or "space", or leave it out'
        reject("RF110", f"expected one character between columns, got {got(value)}", fix=fix)
    return separator


def _encoding(value: object) -> str:
    encoding = text(value)
    try:
        "a".encode(encoding or "utf-8")
    except (LookupError, ValueError):
        fix = 'write "utf-8-sig", "cp1252" or leave it out'
        reject("RF110", f"{got(value)} is no text encoding", fix=fix)
    return encoding


class ImportTable(StrictTable):
    """`[import]`: the import profile of the recordings."""

    format: Annotated[str, PlainValidator(choice(_format_names))] = "auto"
    separator: Annotated[str, PlainValidator(_separator)] = ""
    decimal: Annotated[str, PlainValidator(choice(lambda: ("", ".", ",")))] = ""
    encoding: Annotated[str, PlainValidator(_encoding)] = ""
    header_row: Annotated[int, PlainValidator(whole_number(-1))] = -1
    units_row: Row = 0
    data_row: Row = 0
    sampling_rate_Hz: Annotated[float | None, PlainValidator(quantity("Hz", "3 kHz", above=0))] = Field(
        default=None, alias="sampling_rate"
    )
    missing: tuple[Text, ...] = ()
    block_columns: Row = 0
    block_names_row: Row = 0
    skip_footer: Row = 0
    date_order: Annotated[str, PlainValidator(choice(lambda: ("", *ORDERS)))] = ""
    time_zone: Annotated[str, PlainValidator(choice(available_timezones))] = ""
    table: Text = ""
    channels: dict[str, Annotated[Channel, PlainValidator(_channel)]] = Field(default_factory=dict)
    constants: dict[str, Annotated[float, PlainValidator(any_quantity)]] = Field(default_factory=dict)
    derived: dict[str, Text] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if self.separator and self.separator == self.decimal:
            reject("RF111", "separator and decimal mark are the same", key="decimal")
        for name, si_unit in _SI_UNITS.items():
            unit = self.channels[name].unit if name in self.channels else ""
            if unit and si_unit_of(unit) != si_unit:
                fix = f"use a unit such as '{si_unit}'"
                reject("RF130", f"'{unit}' is not a unit of {name}", fix=fix, key=f"channels.{name}.unit")
        if self.channels and not {"force", "counts"} & (self.channels.keys() | self.derived.keys()):
            fix = 'add force = { column = "...", unit = "N" }, or counts, or [import.derived] force = "..."'
            reject("RF121", "no channel gives the force", fix=fix, key="channels")
        return self


def _schema(value: object) -> str:
    if value != SCHEMA:
        reject("RF110", f"{got(value)} is not a campaign format this version reads", fix=f'write "{SCHEMA}"')
    return SCHEMA


class CampaignFile(StrictTable):
    """The whole file."""

    schema_name: Annotated[str, PlainValidator(_schema)] = Field(alias="schema")
    name: Text
    trials: Text
    data: Text = "."
    rope: Rope
    wheels: dict[str, Round] = Field(default_factory=dict)
    cells: dict[str, CellTable] = Field(default_factory=dict)
    adc: AdcTable | None = None
    sampling: SamplingTable | None = None
    protocol: Protocol = Field(default_factory=Protocol)
    tare: TareTable | None = None
    smoothing: Smoothing = Field(default_factory=Smoothing)
    rejection: RejectionTable = Field(default_factory=RejectionTable)
    weights: WeightsTable | None = None
    design: DesignWheel | None = None
    limits: LimitsTable = Field(default_factory=LimitsTable)
    import_: ImportTable = Field(default_factory=ImportTable, alias="import")


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialSpec:
    """One row of the trial list in SI: a recording and the conditions it was made under."""

    trial: str
    file: str
    path: Path
    line: int
    wheel_radius_m: float
    rope_radius_m: float
    wrap_angle_rad: float
    end_tension_N: float | None = None
    lift_force_N: float | None = None
    sample: str = ""
    wheel: str = ""
    cell: str = ""
    rope_id: str = ""
    dwell_s: float | None = None
    start_s: float | None = None
    stop_s: float | None = None
    exclude: str = ""
    note: str = ""
    own: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Campaign:
    """A campaign file and its trial list, checked, with every default filled in, in SI.

    Attributes
    ----------
    path, trial_list : Path
        The campaign file, and the trial list it names.
    folder : Path
        The folder that the `file` column is relative to.
    name, schema : str
        Title, and version of the file format.
    rope, wheels, cells, adc
        What was measured with what; wheels and cells by name; `adc` is None without `[adc]`.
    protocol, smoothing
        How F_A is to be picked.
    profile : ImportProfile
        How recordings are to be read; its `sampling_rate_Hz` includes `[sampling] rate`.
    sampling_rate_Hz : float, optional
        Nominal sampling rate [Hz].
    tare_interval_s : tuple of float, optional
        The idle interval [s]; None for no tare.
    rejection : str
        Name of an outlier rule.
    weights_tolerance : float
        Limit of error of the end tension, as a fraction of it [-].
    design : DesignWheel, optional
        The wheel to predict.
    trials : tuple of TrialSpec
        A row each, in the order of the table.
    limits : Limits
        What reading one recording may take.
    warnings : tuple of Problem
        What is doubtful, but does not stop the work.
    """

    path: Path
    trial_list: Path
    folder: Path
    name: str
    rope: Rope
    trials: tuple[TrialSpec, ...]
    schema: str = SCHEMA
    wheels: Mapping[str, Round] = field(default_factory=dict)
    cells: Mapping[str, ForceCell] = field(default_factory=dict)
    adc: Adc | None = None
    protocol: Protocol = field(default_factory=Protocol)
    sampling_rate_Hz: float | None = None
    tare_interval_s: tuple[float, float] | None = None
    smoothing: Smoothing = field(default_factory=Smoothing)
    rejection: str = "two-sigma"
    weights_tolerance: float = 0.0
    design: DesignWheel | None = None
    profile: ImportProfile = field(default_factory=ImportProfile)
    limits: Limits = field(default_factory=Limits)
    warnings: tuple[Problem, ...] = ()

    def settings_fingerprint(self) -> str:
        """Return the SHA-256 of all settings that every recording's extraction depends on.

        Cells, converter, protocol, sampling, tare, smoothing, weights and import profile count; names, the
        rope, wheels, rejection, design, limits and the trial list do not: what differs between trials (cell, sample,
        interval, end tension) is in their `TrialSpec`.
        """
        names = (
            *("cells", "adc", "protocol", "sampling_rate_Hz", "tare_interval_s", "smoothing"),
            *("weights_tolerance", "profile"),
        )
        settings = {name: _plain(getattr(self, name)) for name in names}
        text = json.dumps(settings, sort_keys=True, separators=(",", ":"), allow_nan=False)
        return hashlib.sha256(text.encode()).hexdigest()

    def resolved(self) -> dict[str, Any]:
        """Return the whole campaign, defaults included, as JSON-able data without absolute paths."""
        skipped = {"path", "trial_list", "folder", "warnings", "trials", "limits"}
        tree = {f.name: _plain(getattr(self, f.name)) for f in fields(self) if f.name not in skipped}
        tree["smoothing"]["mode"] = self.smoothing.mode
        tree["path"] = self.path.name
        tree["folder"] = self.relative(self.folder)
        tree["trials"] = []
        for trial in self.trials:
            row = _plain(trial) | {"file": self.relative(trial.path)}
            tree["trials"].append({key: row[key] for key in row if key not in ("path", "line")})
        tree["warnings"] = [problem.message for problem in self.warnings]
        return tree

    def relative(self, path: Path) -> str:
        """Return a path as seen from the campaign file."""
        try:
            return Path(os.path.relpath(path, self.path.parent)).as_posix()
        except ValueError:  # another drive on Windows
            return path.name
