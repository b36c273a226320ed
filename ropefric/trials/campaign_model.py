"""A measuring campaign: the tables of campaign.toml as pydantic models in SI, and the campaign that they make."""

import math
import os
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

from pydantic import AfterValidator, Field, PlainValidator, model_validator
from pydantic_core import to_jsonable_python

from ropefric.errors import Problem
from ropefric.files import toml_model as read
from ropefric.files.text_table import ORDERS, THOUSANDS
from ropefric.files.toml_model import StrictTable, Table, got, reject
from ropefric.plugins import provenance
from ropefric.registry import did_you_mean
from ropefric.shown import Shown
from ropefric.traces.breakaway import ENDINGS, PICKERS, RESTS, SIDES
from ropefric.traces.calibration import ASSUMED_LIMITS, Adc, ForceCell
from ropefric.traces.readers import READERS
from ropefric.traces.readers.profile import Channel, ImportProfile
from ropefric.trials.outliers import RULES
from ropefric.trials.workers import Limits

SCHEMA = "ropefric.campaign/1"
DECISIONS = "decisions.csv"
"""Beside the list of trials: what people decided about them."""
_plain = partial(to_jsonable_python, by_alias=False)
_SEPARATORS = {"tab": "\t", "space": " "}

_LENGTH, _FORCE = read.quantity("m", "40 mm", above=0), read.quantity("N", "60 N", above=0)
_VOLTAGE, _TIME = read.quantity("V", "2.5 V"), read.quantity("s", "0.3 s")
_RATE, _WINDOW = read.quantity("Hz", "3 kHz", above=0), read.quantity("s", "10 ms", above=0)

# What stands in the file under the `alias` of a field is in SI under its name.
Text = Annotated[str, PlainValidator(read.text)]
Length = Annotated[float, PlainValidator(_LENGTH)]
Time = Annotated[float | None, PlainValidator(_TIME)]
MinStep = Annotated[float | None, PlainValidator(read.quantity("N", "5 N", above=0))]
Angle = Annotated[float, PlainValidator(read.quantity("rad", "1 deg", above=0))]
Wheel = Annotated[float, PlainValidator(read.quantity("m", "35 mm", above=0))]
Wrap = Annotated[float, PlainValidator(read.quantity("rad", "400 deg", above=0))]
Force = Annotated[float, PlainValidator(_FORCE)]
Density = Annotated[float | None, PlainValidator(read.quantity("kg/m", "62 g/m", above=0))]


class Round(StrictTable):
    """A wheel or rope: its radius [m], or its diameter instead, and what it is made of."""

    example: ClassVar[str] = 'radius = "40 mm"'
    radius_m: Length = Field(default=0.0, alias="radius")
    diameter: Length = Field(default=0.0, exclude=True)
    tolerance: Annotated[float, PlainValidator(read.quantity("m", "0.1 mm", above=0))] = 0.0
    material: Text = ""

    @property
    def radius_std_m(self) -> float:
        """Return the standard uncertainty of the radius [m]: the tolerance, of what was given, is a limit of error."""
        return self.tolerance / math.sqrt(3.0) / (2.0 if "diameter" in self.model_fields_set else 1.0)

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
    linear_density_kg_m: Density = Field(default=None, alias="linear_density")


def _pair(value: object, what: str, like: str) -> list[object]:
    if not isinstance(value, list) or len(value) != 2:
        reject("RF110", f"expected {what}, got {got(value)}", fix=f"write {like}")
    return value


def _point(value: object) -> tuple[float, float]:
    force, voltage = _pair(value, "a pair of force and voltage", '["500 N", "2.5 V"]')
    return _POINT_N(force), _VOLTAGE(voltage)


_POINT_N = read.quantity("N", "500 N")


def protocol_names() -> Collection[str]:
    """Return the names of all protocols."""
    from ropefric.traces.protocols import PROTOCOLS  # noqa: PLC0415  (brings the pickers, which nothing here runs)

    return tuple(PROTOCOLS)


class Protocol(StrictTable):
    """`[protocol]`: what happens in a recording, and which part of it counts."""

    name: Annotated[str, PlainValidator(read.choice(protocol_names))] = "breakaway"
    start_s: Time = Field(default=None, alias="from")
    stop_s: Time = Field(default=None, alias="until")
    min_step_N: MinStep = Field(default=None, alias="min_step")
    wrap_tolerance_rad: Angle = Field(default=0.0, alias="wrap_tolerance")
    side: Annotated[str, PlainValidator(read.choice(lambda: SIDES))] = "slack"
    ending: Annotated[str, PlainValidator(read.choice(lambda: ENDINGS))] = "sliding"
    rest: Annotated[str, PlainValidator(read.choice(lambda: RESTS))] = "unknown"
    picker: Annotated[str, PlainValidator(read.choice(lambda: PICKERS))] = "trained"

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


def _window_s(value: object) -> float | None:
    if value in ("auto", "none"):
        return None if value == "auto" else 0.0
    if isinstance(value, str) and not value[:1].isdigit():
        fix = 'write "auto", "none" or a time such as "10 ms"'
        reject("RF120", f"{got(value)} is no smoothing window", fix=fix)
    return _WINDOW(value)


class Smoothing(StrictTable):
    """`[smoothing]`: the window [s], 0 for none, None for one that is found for each recording."""

    window_s: Annotated[float | None, PlainValidator(_window_s)] = Field(default=None, alias="window")
    # The one way that is left; templates wrote it out.
    peak: Annotated[str, PlainValidator(read.choice(lambda: ("smoothed",)))] = "smoothed"

    @property
    def mode(self) -> str:
        """Return "auto", "none" or "fixed"."""
        return "auto" if self.window_s is None else "fixed" if self.window_s else "none"


class DesignWheel(StrictTable):
    """`[design]`: a wheel whose lift force is to be predicted."""

    wheel_radius_m: Wheel = Field(alias="wheel_radius")
    wrap_angle_rad: Wrap = Field(alias="wrap_angle")
    end_tension_N: Force = Field(alias="end_tension")


class ReportWords(StrictTable):
    """`[report]`: text for the first page of a report; all keys are optional."""

    gone: ClassVar[Mapping[str, str]] = {
        "language": "leave it out: reports have decimal points; decimal commas in lists and recordings are still read"
    }
    lab: Text = ""
    customer: Text = ""
    operator: Text = ""
    number: Text = ""
    date: Annotated[str, PlainValidator(read.date_text)] = ""
    question: Text = ""
    assumptions: tuple[Text, ...] = ()


_CHANNEL_KEYS = ("column", "unit", "sensitivity", "time", "tare", "instead_of")


def _channel(value: object) -> Channel:
    if not isinstance(value, dict):
        return Channel(column=_column(value))
    unknown = sorted(value.keys() - set(_CHANNEL_KEYS))
    if unknown:
        fix = did_you_mean(unknown[0], _CHANNEL_KEYS)
        reject("RF120", f"unknown key '{unknown[0]}'", fix=fix, key=unknown[0])
    if "column" not in value:
        reject("RF121", "'column' is missing", fix='write { column = "time_s", unit = "s" }')
    tare = value.get("tare")
    return Channel(
        column=_column(value["column"]),
        unit=read.text(value.get("unit", "")),
        sensitivity=read.text(value.get("sensitivity", "")),
        time=_column(value["time"]) if "time" in value else "",
        tare_s=None if tare is None else () if tare == "none" else _interval(tare),
        instead_of=read.text(value.get("instead_of", "")),
    )


def _column(value: object) -> str | int:
    if isinstance(value, str) and value.strip():
        return value
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value < 2**31:
        reject("RF110", f"expected a column's header or its number from 1, got {got(value)}")
    return value


def _separator(value: object) -> str:
    separator = _SEPARATORS.get(read.text(value), read.text(value))
    if len(separator) > 1:
        fix = 'write ",", ";", "tab" or "space", or leave it out'
        reject("RF110", f"expected one character between columns, got {got(value)}", fix=fix)
    return separator


def _encoding(value: object) -> str:
    encoding = read.text(value)
    try:
        "a".encode(encoding or "utf-8")
    except (LookupError, ValueError):
        fix = 'write "utf-8-sig", "cp1252" or leave it out'
        reject("RF110", f"{got(value)} is no text encoding", fix=fix)
    return encoding


def _import_profile(**given: Any) -> ImportProfile:
    profile = ImportProfile(**given)
    if profile.separator and profile.separator == profile.decimal:
        reject("RF111", "separator and decimal mark are the same", key="decimal")
    channels = profile.channels
    if channels and not {"force", "counts"} & (channels.keys() | profile.derived.keys()):
        fix = 'add force = { column = "...", unit = "N" }, or counts, or [import.derived] force = "..."'
        reject("RF121", "no channel gives the force", fix=fix, key="channels")
    return profile


def _schema(value: object) -> str:
    if value != SCHEMA:
        reject("RF110", f"{got(value)} is not a campaign format this version reads", fix=f'write "{SCHEMA}"')
    return SCHEMA


_CELL = Table(
    partial(ForceCell, name=""),
    {
        "full_scale_N": ("full_scale", _FORCE),
        "zero_V": ("zero_voltage", _VOLTAGE),
        "full_scale_V": ("full_scale_voltage", _VOLTAGE),
        "rated_output": ("rated_output", read.quantity("", "2 mV/V", above=0)),
        **dict.fromkeys(ASSUMED_LIMITS, read.fraction("0.02 %FS")),
        "points": ("calibration_points", tuple[Annotated[Any, PlainValidator(_point)], ...]),
        "serial": read.text,
        "calibrated": read.date_text,
    },
    needed=("full_scale_N",),
    prefix="force cell '': ",
)
_ADC = Table(
    Adc,
    {"bits": read.whole_number(1, 32), "low_V": ("low", _VOLTAGE), "high_V": ("high", _VOLTAGE)},
    needed=("bits", "high_V"),
    code="RF111",
    prefix="ADC: ",
)
_LIMITS = Table(
    Limits,
    {
        "memory_bytes": ("memory", read.quantity("byte", "2 GB", above=0)),
        "time_s": ("time", read.quantity("s", "120 s", above=0)),
    },
)
_IMPORT = Table(
    _import_profile,
    {
        "format": read.choice(lambda: ("auto", *READERS)),
        "separator": _separator,
        "decimal": read.choice(lambda: ("", ".", ",")),
        "encoding": _encoding,
        "header_row": read.whole_number(-1),
        **dict.fromkeys(
            ("units_row", "data_row", "block_columns", "block_names_row", "skip_footer"), read.whole_number(0)
        ),
        "date_order": read.choice(lambda: ("", *ORDERS)),
        "sampling_rate_Hz": ("sampling_rate", _RATE),
        "missing": tuple[Text, ...],
        "table": read.text,
        "thousands": read.choice(lambda: ("", *THOUSANDS)),
        **dict.fromkeys(("recording_column", "channel_column", "value_column"), _column),
        "channels": dict[str, Annotated[Channel, PlainValidator(_channel)]],
        "constants": dict[str, Annotated[float, PlainValidator(read.any_quantity)]],
        "derived": dict[str, Text],
    },
)


def _of_one_key(key: str, reader: Callable[[object], Any]) -> Table:
    return Table(lambda **given: given[key], {key: reader}, needed=(key,))


class CampaignFile(StrictTable):
    """The whole file; each table is what it says in SI."""

    name: Text
    rope: Rope
    schema_name: Annotated[str, PlainValidator(_schema)] = Field(alias="schema")
    trial_list: Text = Field(alias="trials")
    data: Text = "."
    plugins: tuple[Text, ...] = ()
    wheels: dict[str, Round] = Field(default_factory=dict)
    cells: Annotated[
        dict[str, Annotated[ForceCell, _CELL]],
        AfterValidator(lambda cells: {name: replace(cell, name=name) for name, cell in cells.items()}),
    ] = Field(default_factory=dict)
    adc: Annotated[Adc | None, _ADC] = None
    protocol: Protocol = Protocol()
    sampling_rate_Hz: Annotated[float | None, _of_one_key("rate", _RATE), Field(alias="sampling")] = None
    tare_interval_s: Annotated[
        tuple[float, float] | None, _of_one_key("interval", _interval), Field(alias="tare")
    ] = None
    smoothing: Smoothing = Smoothing()
    rejection: Annotated[str, Table(lambda rule="two-sigma": rule, {"rule": read.choice(lambda: RULES)})] = (
        "two-sigma"
    )
    weights_tolerance: Annotated[
        float, _of_one_key("tolerance", read.fraction("0.05 %")), Field(alias="weights")
    ] = 0.0
    uncertainty: dict[str, Annotated[str, _of_one_key("by", read.text)]] = Field(default_factory=dict)
    design: DesignWheel | None = None
    report: ReportWords = ReportWords()
    profile: Annotated[ImportProfile, _IMPORT, Field(alias="import")] = ImportProfile()
    limits: Annotated[Limits, _LIMITS] = Limits()


class AboutTable(StrictTable):
    """Tables beside a trial table: the wheel to predict, the words of its report; or how to read a recording."""

    design: DesignWheel | None = None
    report: ReportWords = ReportWords()
    profile: Annotated[ImportProfile, _IMPORT, Field(alias="import")] = ImportProfile()


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialRow:
    """The row of a trial in the trial list, in SI, which its result repeats."""

    trial: str
    file: str
    sample: str = ""
    wheel_radius_m: float
    rope_radius_m: float
    wrap_angle_rad: float
    wheel: str = ""
    cell: str = ""
    end_cell: str = ""
    rope_id: str = ""
    start_s: float | None = None
    stop_s: float | None = None
    note: str = ""
    why: str = ""
    by: str = ""
    when: str = ""
    own: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialSpec(TrialRow):
    """One row of the trial list: a recording, the conditions it was made under, and what a person decided of it.

    A decision is `pick_s`, when F_A was reached, or `peak_N`, F_A itself, `by` somebody who says `why`.
    """

    path: Path
    line: int
    end_tension_N: float | None = None
    lift_force_N: float | None = None
    dwell_s: float | None = None
    exclude: str = ""
    pick_s: float | None = None
    peak_N: float | None = None
    peak_std_N: float | None = None

    @property
    def decision(self) -> str:
        """Return what a person decided about F_A; "" where nobody did."""
        given = (("pick_s", self.pick_s, "s"), ("peak_N", self.peak_N, "N"))
        return "".join(f"{name} = {value:g} {unit}" for name, value, unit in given if value is not None)


class Campaign(CampaignFile, Shown):
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
        Rope, wheels, cells and converter; wheels and cells by name; `adc` is None without `[adc]`.
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
    uncertainty : mapping of str to str
        By what stated errors are shared, such as "wrap" by the "rig".
    design : DesignWheel, optional
        The wheel to predict.
    report : ReportWords
        Text for the first page of a report.
    trials : tuple of TrialSpec
        A row each, in the order of the table.
    limits : Limits
        Limits of reading one recording.
    warnings : tuple of Problem
        Warnings that do not stop the work.
    """

    _said: ClassVar = ("name", "trials", "rope.radius_m", "rejection", "protocol=protocol.name", "warnings")
    _framed: ClassVar = "trials"

    path: Path
    trial_list: Path  # type: ignore[assignment]  # (in the file as text)
    folder: Path
    trials: tuple[TrialSpec, ...]
    warnings: tuple[Problem, ...] = ()

    @property
    def decisions(self) -> Path:
        """Return where people's decisions about the trials stand, if there are any: beside the list."""
        return self.trial_list.with_name(DECISIONS)

    @property
    def schema(self) -> str:  # type: ignore[override]  # (pydantic's own, deprecated)
        """Return the version of the file format."""
        return self.schema_name

    def settings(self) -> dict[str, Any]:
        """Return all settings that every recording's extraction depends on.

        Cells, converter, protocol, sampling, tare, smoothing, weights and import profile count; names, the
        rope, wheels (but for their tolerances), rejection, design, limits and the trial list do not: what differs
        between trials (cell, sample, interval, end tension) is in their `TrialSpec`.
        """
        names = (
            *("cells", "adc", "protocol", "sampling_rate_Hz", "tare_interval_s", "smoothing"),
            *("weights_tolerance", "profile"),
        )
        settings = {name: getattr(self, name) for name in names}
        settings["plugins"] = [one["sha256"] for one in provenance("READER", "PROTOCOL")]
        return settings | {"radius_std_m": [one.radius_std_m for one in (self.rope, *self.wheels.values())]}

    def resolved(self) -> dict[str, Any]:
        """Return the campaign file, defaults included, as JSON-able data without paths."""
        elsewhere = {
            "trial_list",
            "data",
            "limits",
            "schema_name",
            "path",
            "folder",
            "trials",
            "warnings",
            "plugins",
        }
        tree: dict[str, Any] = {"schema": self.schema_name, **_plain(self, exclude=elsewhere)}
        tree["smoothing"]["mode"] = self.smoothing.mode
        if used := provenance():
            tree["plugins"] = used
        return tree

    def relative(self, path: Path) -> str:
        """Return a path as seen from the campaign file."""
        try:
            return Path(os.path.relpath(path, self.path.parent)).as_posix()
        except ValueError:  # another drive on Windows
            return path.name
