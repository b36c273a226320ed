"""The keys of `[import]`: the import profile of the recordings."""

from collections.abc import Collection
from typing import Annotated, Self

from pydantic import Field, PlainValidator, model_validator

from ropefric.errors import InputError
from ropefric.quantities import si_unit_of
from ropefric.traces.readers.profile import Channel, ImportProfile
from ropefric.trials.toml_fields import (
    StrictTable,
    any_quantity,
    choice,
    got,
    quantity,
    reject,
    text,
    whole_number,
)

Text = Annotated[str, PlainValidator(text)]
Row = Annotated[int, PlainValidator(whole_number(0))]
SI_UNITS = {"time": "s", "force": "N"}
SEPARATORS = {"tab": "\t", "space": " "}


def format_names() -> Collection[str]:
    """Return the names of all readers."""
    from ropefric.traces.readers import READERS  # noqa: PLC0415  (brings the readers, and few files name one)

    return ("auto", *READERS)


def _channel(value: object) -> Channel:
    if isinstance(value, dict):
        unknown = sorted(value.keys() - {"column", "unit"})
        if unknown:
            reject(
                "RF120", f"unknown key '{unknown[0]}'", fix="a channel has column and unit", key=unknown[0]
            )
        if "column" not in value:
            reject("RF121", "'column' is missing", fix='write { column = "time_s", unit = "s" }')
        return Channel(column=_column(value["column"]), unit=_unit(value.get("unit", "")))
    return Channel(column=_column(value))


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
    separator = SEPARATORS.get(text(value), text(value))
    if len(separator) > 1:
        fix = 'write ",", ";", "tab" or "space", or leave it out'
        reject("RF110", f"expected one character between columns, got {got(value)}", fix=fix)
    return separator


def _encoding(value: object) -> str:
    encoding = text(value)
    try:
        "a".encode(encoding or "utf-8")
    except (LookupError, ValueError):
        reject(
            "RF110", f"{got(value)} is no text encoding", fix='write "utf-8-sig", "cp1252" or leave it out'
        )
    return encoding


class ImportTable(StrictTable):
    """`[import]`."""

    format: Annotated[str, PlainValidator(choice(format_names))] = "auto"
    separator: Annotated[str, PlainValidator(_separator)] = ""
    decimal: Annotated[str, PlainValidator(choice(lambda: ("", ".", ",")))] = ""
    encoding: Annotated[str, PlainValidator(_encoding)] = ""
    header_row: Annotated[int, PlainValidator(whole_number(-1))] = -1
    units_row: Row = 0
    data_row: Row = 0
    sampling_rate: Annotated[float | None, PlainValidator(quantity("Hz", "3 kHz", above=0))] = None
    missing: list[Text] = Field(default_factory=list)
    block_columns: Row = 0
    block_names_row: Row = 0
    table: Text = ""
    channels: dict[str, Annotated[Channel, PlainValidator(_channel)]] = Field(default_factory=dict)
    constants: dict[str, Annotated[float, PlainValidator(any_quantity)]] = Field(default_factory=dict)
    derived: dict[str, Text] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if self.separator and self.separator == self.decimal:
            reject("RF111", "separator and decimal mark are the same", key="decimal")
        for name, si_unit in SI_UNITS.items():
            unit = self.channels[name].unit if name in self.channels else ""
            if unit and si_unit_of(unit) != si_unit:
                fix = f"use a unit such as '{si_unit}'"
                reject("RF130", f"'{unit}' is not a unit of {name}", fix=fix, key=f"channels.{name}.unit")
        if self.channels and not {"force", "counts"} & (self.channels.keys() | self.derived.keys()):
            fix = 'add force = { column = "...", unit = "N" }, or counts, or [import.derived] force = "..."'
            reject("RF121", "no channel gives the force", fix=fix, key="channels")
        return self

    def profile(self, sampling_rate_Hz: float | None) -> ImportProfile:
        """Return the profile, with the campaign's sampling rate where it has none of its own."""
        return ImportProfile(
            format=self.format,
            separator=self.separator,
            decimal=self.decimal,
            encoding=self.encoding,
            header_row=self.header_row,
            units_row=self.units_row,
            data_row=self.data_row,
            channels=dict(self.channels),
            sampling_rate_Hz=sampling_rate_Hz if self.sampling_rate is None else self.sampling_rate,
            constants=dict(self.constants),
            derived=dict(self.derived),
            missing=tuple(self.missing),
            block_columns=self.block_columns,
            block_names_row=self.block_names_row,
            table=self.table,
        )
