"""The keys of campaign.toml, table by table, and what each may hold."""

from collections.abc import Collection
from typing import Annotated, ClassVar, Self

from pydantic import Field, PlainValidator, model_validator

from ropefric.errors import InputError
from ropefric.traces.chain import Adc, ForceCell
from ropefric.traces.settings import ENDINGS, PEAKS, SIDES
from ropefric.trials.campaign_import import ImportTable
from ropefric.trials.campaign_model import SCHEMA
from ropefric.trials.toml_fields import (
    StrictTable,
    choice,
    date_text,
    fraction,
    got,
    quantity,
    reject,
    text,
    whole_number,
)
from ropefric.trials.workers import Limits

Text = Annotated[str, PlainValidator(text)]
Length = Annotated[float | None, PlainValidator(quantity("m", "40 mm", above=0))]
Force = Annotated[float, PlainValidator(quantity("N", "60 N", above=0))]
Voltage = Annotated[float | None, PlainValidator(quantity("V", "5 V"))]
Time = Annotated[float | None, PlainValidator(quantity("s", "0.3 s"))]
Share = Annotated[float | None, PlainValidator(fraction("0.02 %FS"))]


class RoundTable(StrictTable):
    """Something round: its radius, or its diameter instead."""

    example: ClassVar[str] = 'radius = "40 mm"'
    radius: Length = None
    diameter: Length = None
    material: Text = ""

    @model_validator(mode="after")
    def _has_one_size(self) -> Self:
        if self.radius is None and self.diameter is None:
            reject("RF121", "neither radius nor diameter is given", fix=f"add {self.example}")
        if self.radius is not None and self.diameter is not None:
            reject("RF111", "radius and diameter are both given", fix="remove one of the two", key="diameter")
        return self

    def radius_m(self) -> float:
        """Return the radius [m]."""
        return self.radius if self.radius is not None else (self.diameter or 0.0) / 2


class RopeTable(RoundTable):
    """`[rope]`."""

    example: ClassVar[str] = 'diameter = "9.8 mm"'
    linear_density: Annotated[float | None, PlainValidator(quantity("kg/m", "62 g/m", above=0))] = None


def _point(value: object) -> tuple[float, float]:
    if not isinstance(value, list) or len(value) != 2:
        reject(
            "RF110", f"expected a pair of force and voltage, got {got(value)}", fix='write ["500 N", "2.5 V"]'
        )
    return _FORCE(value[0]), _VOLTAGE(value[1])


_FORCE, _VOLTAGE = quantity("N", "500 N"), quantity("V", "2.5 V")


class CellTable(StrictTable):
    """`[cells.NAME]`; what is not given is as `ForceCell` has it."""

    full_scale: Force
    zero_voltage: Voltage = None
    full_scale_voltage: Voltage = None
    linearity: Share = None
    hysteresis: Share = None
    repeatability: Share = None
    transmitter: Share = None
    calibration_points: list[Annotated[tuple[float, float], PlainValidator(_point)]] = Field(
        default_factory=list
    )
    serial: Text = ""
    calibrated: Annotated[str, PlainValidator(date_text)] = ""

    @model_validator(mode="after")
    def _is_possible(self) -> Self:
        try:
            self.cell("")
        except InputError as error:
            keys = {"full_scale_V": "full_scale_voltage", "points": "calibration_points"}
            message = error.problem.message.removeprefix("force cell '': ")
            reject("RF110", message, fix=error.fix, key=keys.get(error.problem.key, error.problem.key))
        return self

    def cell(self, name: str) -> ForceCell:
        """Return the cell under its name."""
        given = {
            "zero_V": self.zero_voltage,
            "full_scale_V": self.full_scale_voltage,
            "linearity": self.linearity,
            "hysteresis": self.hysteresis,
            "repeatability": self.repeatability,
            "transmitter": self.transmitter,
        }
        return ForceCell(
            name=name,
            full_scale_N=self.full_scale,
            points=tuple(self.calibration_points),
            serial=self.serial,
            calibrated=self.calibrated,
            **{key: value for key, value in given.items() if value is not None},  # type: ignore[arg-type]
        )


class AdcTable(StrictTable):
    """`[adc]`."""

    bits: Annotated[int, PlainValidator(whole_number(1, 32))]
    low: Annotated[float, PlainValidator(quantity("V", "0 V"))] = 0.0
    high: Annotated[float, PlainValidator(quantity("V", "5 V"))]

    @model_validator(mode="after")
    def _has_a_range(self) -> Self:
        if not self.low < self.high:
            reject("RF111", f"the range from {self.low:g} V to {self.high:g} V is empty", key="high")
        return self

    def adc(self) -> Adc:
        """Return the converter."""
        return Adc(bits=self.bits, low_V=self.low, high_V=self.high)


class SamplingTable(StrictTable):
    """`[sampling]`."""

    rate: Annotated[float, PlainValidator(quantity("Hz", "3 kHz", above=0))]


def protocol_names() -> Collection[str]:
    """Return the names of all protocols."""
    from ropefric.traces.protocols import PROTOCOLS  # noqa: PLC0415  (brings the pickers, which nothing here runs)

    return tuple(PROTOCOLS)


class ProtocolTable(StrictTable):
    """`[protocol]`."""

    name: Annotated[str, PlainValidator(choice(protocol_names))] = "breakaway"
    start: Time = Field(default=None, alias="from")
    until: Time = None
    min_step: Annotated[float | None, PlainValidator(quantity("N", "5 N", above=0))] = None
    side: Annotated[str, PlainValidator(choice(lambda: SIDES))] = "slack"
    ending: Annotated[str, PlainValidator(choice(lambda: ENDINGS))] = "sliding"

    @model_validator(mode="after")
    def _has_an_interval(self) -> Self:
        if self.start is not None and self.until is not None and not self.start < self.until:
            reject("RF111", f"the part from {self.start:g} s until {self.until:g} s is empty", key="until")
        return self


def _interval(value: object) -> tuple[float, float]:
    if not isinstance(value, list) or len(value) != 2:
        reject("RF110", f"expected two times, got {got(value)}", fix='write ["0 s", "0.3 s"]')
    start_s, stop_s = (_TIME(item) for item in value)
    if not start_s < stop_s:
        reject(
            "RF111", f"the interval from {start_s:g} s to {stop_s:g} s is empty", fix='write ["0 s", "0.3 s"]'
        )
    return start_s, stop_s


_TIME = quantity("s", "0.3 s")


class TareTable(StrictTable):
    """`[tare]`."""

    interval: Annotated[tuple[float, float], PlainValidator(_interval)]


def _window(value: object) -> tuple[str, float | None]:
    if value == "auto":
        return "auto", None
    if value == "none":
        return "none", 0.0
    if isinstance(value, str) and not value[:1].isdigit():
        reject(
            "RF120",
            f"{got(value)} is no smoothing window",
            fix='write "auto", "none" or a time such as "10 ms"',
        )
    return "fixed", _WINDOW(value)


_WINDOW = quantity("s", "10 ms", above=0)


class SmoothingTable(StrictTable):
    """`[smoothing]`."""

    window: Annotated[tuple[str, float | None], PlainValidator(_window)] = ("auto", None)
    peak: Annotated[str, PlainValidator(choice(lambda: PEAKS))] = "smoothed"


def rule_names() -> Collection[str]:
    """Return the names of all outlier rules."""
    from ropefric.trials.outliers import RULES  # noqa: PLC0415  (brings scipy.stats, and few files name a rule)

    return tuple(RULES)


class RejectionTable(StrictTable):
    """`[rejection]`."""

    rule: Annotated[str, PlainValidator(choice(rule_names))] = "two-sigma"


class WeightsTable(StrictTable):
    """`[weights]`."""

    tolerance: Annotated[float, PlainValidator(fraction("0.05 %"))]


class DesignTable(StrictTable):
    """`[design]`."""

    wheel_radius: Annotated[float, PlainValidator(quantity("m", "35 mm", above=0))]
    wrap_angle: Annotated[float, PlainValidator(quantity("rad", "400 deg", above=0))]
    end_tension: Force


class LimitsTable(StrictTable):
    """`[limits]`."""

    memory: Annotated[float | None, PlainValidator(quantity("byte", "2 GB", above=0))] = None
    time: Annotated[float | None, PlainValidator(quantity("s", "120 s", above=0))] = None

    def limits(self) -> Limits:
        """Return what reading one recording may take."""
        given = {"memory_bytes": self.memory, "time_s": self.time}
        return Limits(**{key: value for key, value in given.items() if value is not None})


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
    rope: RopeTable
    wheels: dict[str, RoundTable] = Field(default_factory=dict)
    cells: dict[str, CellTable] = Field(default_factory=dict)
    adc: AdcTable | None = None
    sampling: SamplingTable | None = None
    protocol: ProtocolTable = Field(default_factory=ProtocolTable)
    tare: TareTable | None = None
    smoothing: SmoothingTable = Field(default_factory=SmoothingTable)
    rejection: RejectionTable = Field(default_factory=RejectionTable)
    weights: WeightsTable | None = None
    design: DesignTable | None = None
    limits: LimitsTable = Field(default_factory=LimitsTable)
    import_: ImportTable = Field(default_factory=ImportTable, alias="import")
