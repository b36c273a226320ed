"""Examine an unknown recording file: its contents, and the import profile that reads it, tried on the file."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from itertools import chain, islice
from pathlib import Path, PurePath
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import DataError
from ropefric.files.disk import InputFile, use_file
from ropefric.files.text import Source, split_line
from ropefric.glossary import counted
from ropefric.traces.assemble import assemble_trace
from ropefric.traces.calibration import Adc, Calibration, ForceCell
from ropefric.traces.clock import mean_step_s, mend_clock
from ropefric.traces.readers import TEXT_FORMATS, find_reader
from ropefric.traces.readers.delimited import open_text
from ropefric.traces.readers.guesses import guess_meaning, index_of, layouts, unit_of
from ropefric.traces.readers.profile import Channel, ImportProfile, RawRecording, profile_to_toml
from ropefric.traces.readers.table import Table, WordError
from ropefric.traces.signals import si_scale, signal_unit
from ropefric.traces.trace import ForceTrace

N_FIRST_ROWS = 5

_UNIFORM = 0.05
_TOP = 2.0**32 - 1.0
_AS_COUNTS = Calibration(
    cell=ForceCell(name="", full_scale_N=_TOP, full_scale_V=_TOP), adc=Adc(bits=32, low_V=0.0, high_V=_TOP)
)
"""Of a file that is only looked at, a count is a newton."""


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
    samples: tuple[str, ...] = ()
    sampling_rate_Hz: float | None = None
    is_uniform: bool = False
    first_rows: tuple[tuple[str, ...], ...] = ()
    profile: ImportProfile = field(default_factory=ImportProfile)
    notes: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    read: str = ""
    stopped: str = ""

    def to_dict(self) -> dict[str, Any]:
        r"""Return the inspection for JSON, the profile as its TOML text."""
        result = {name: getattr(self, name) for name in self.__slots__ if name not in ("profile", "columns")}
        for name in ("samples", "first_rows", "notes", "doubts"):
            result[name] = list(result[name])
        result["first_rows"] = [list(row) for row in self.first_rows]
        result["columns"] = [asdict(column) for column in self.columns]
        result["profile_toml"] = profile_to_toml(self.profile)
        return {"schema": "ropefric.inspection/1", **result}


def inspect_file(
    path: str | PurePath, profile: ImportProfile | None = None, *, shown_as: str = ""
) -> Inspection:
    r"""Return what can be found out about a recording file, and the profile that would read it."""
    shown, known = shown_as or str(path), profile or ImportProfile()

    def look(file: InputFile) -> Inspection:
        source = Source(path=Path(path), shown=shown, file=file)
        reader = find_reader(source.path, known, source)
        if reader.name not in TEXT_FORMATS:
            found = Inspection(file=shown, format=reader.name, profile=replace(known, format=reader.name))
            return _tried(_summarise(found, reader.tables(source, known)), source)
        return _inspect_text(source, known)

    return use_file(path, look, shown=shown)


def _inspect_text(source: Source, profile: ImportProfile) -> Inspection:
    """Return what the first profile that reads a text makes of it, or where none does, the first that opens it."""
    doubts = []
    decimal_is_open = False
    try:
        text, dialect = open_text(source, profile)
    except DataError as error:
        if error.code != "RF104" or profile.decimal:
            raise
        doubts.append(str(error))
        decimal_is_open = True  # in the profile too, so that reading still refuses until somebody decides
        profile = replace(profile, decimal=",")
        text, dialect = open_text(source, profile)
    found: list[Inspection] = []
    errors: list[DataError] = []
    for layout, assumed in layouts(text, dialect, profile):
        if found and dialect.rows.header_row and not layout.header_row:
            break  # a header that opens is not left out: it may contradict the cells
        reader = find_reader(
            source.path, replace(layout, format="delimited" if layout.format == "auto" else layout.format)
        )
        try:
            tables = reader.tables(source, layout)
        except DataError as error:
            errors.append(error)
            continue
        lines = islice(text.lines_from(layout.data_row), N_FIRST_ROWS)
        seen = Inspection(
            file=source.shown,
            format=reader.name,
            encoding=text.encoding,
            separator=dialect.separator,
            decimal=dialect.decimal,
            header_row=layout.header_row,
            units_row=layout.units_row,
            data_row=layout.data_row,
            first_rows=tuple(tuple(split_line(line, dialect.separator)) for _, line in lines),
            profile=replace(
                layout,
                format=reader.name,
                separator=dialect.separator,
                decimal="" if decimal_is_open else dialect.decimal,
                thousands=dialect.thousands,
                encoding="" if text.encoding in {"utf-8", "utf-8-sig"} else text.encoding,
            ),
            doubts=(*doubts, *map(str, errors), *assumed),
        )
        found.append(_tried(_summarise(seen, tables), source))
        if not found[-1].stopped:
            return found[-1]
    if not found:
        raise errors[0]
    return found[0]


def _tried(found: Inspection, source: Source) -> Inspection:
    """Return an inspection with what its own profile reads of the file, or what stops it."""
    profile = found.profile
    try:
        raws = find_reader(source.path, profile, source).read(source, profile)
        traces = [trace_as_it_is(raw, profile) for raw in raws]
    except DataError as error:
        fix = f" ({error.fix})" if error.fix else ""
        return replace(found, stopped=f"{error.problem.message}{fix}")
    signals = signals_of_cells(raws[0], profile)
    said = _summary_of(traces, signals.get("force", "N"))
    said += f"; not yet in newtons: {', '.join(signals)}" if signals else ""
    notes = dict.fromkeys(chain(found.notes, *(trace.notes for trace in traces)))
    return replace(found, read=said, notes=tuple(notes))


def signals_of_cells(raw: RawRecording, profile: ImportProfile) -> dict[str, str]:
    """Return the forces that only a cell turns into newtons, and their unit."""
    has_own = {name for name, channel in profile.channels.items() if channel.sensitivity}
    return {name: unit for name, unit in raw.units.items() if name not in has_own and signal_unit(name, unit)}


def trace_as_it_is(raw: RawRecording, profile: ImportProfile) -> ForceTrace:
    """Return the trace of a recording that is only looked at: nothing is tared, a count or a volt is a newton."""
    seen = replace(raw, units={**raw.units, **dict.fromkeys(signals_of_cells(raw, profile), "N")})
    return assemble_trace(seen, profile, calibration=_AS_COUNTS, end_calibration=_AS_COUNTS)


def _summary_of(traces: Sequence[ForceTrace], unit: str) -> str:
    """Return how many recordings of how many samples were read, at which rate, and from which force to which."""
    sizes = sorted({trace.force_N.size for trace in traces})
    size = " to ".join(map(str, dict.fromkeys((sizes[0], sizes[-1]))))
    rates = ", ".join(dict.fromkeys(f"{trace.sampling_rate_Hz:.4g} Hz" for trace in traces))
    present = np.concatenate([trace.force_N[np.isfinite(trace.force_N)] for trace in traces])
    unit = unit if traces[0].counts is None else "counts"
    span = f"{present.min():.4g} to {present.max():.4g} {unit}" if present.size else "no force"
    return f"{counted(len(traces), 'recording')} of {size} samples, {rates}, {span}"


def _summarise(found: Inspection, tables: Sequence[Table]) -> Inspection:
    """Return an inspection completed by what the columns of the first recording hold."""
    table = tables[0]
    values, wrong_stamps = _load(table)
    columns = tuple(_column(table, index, array) for index, array in enumerate(values))
    guess = guess_meaning(table, values, found.profile)
    rate_Hz, is_uniform, clock_doubts = _clock(table, values, guess.channels)
    samples = tuple(table.sample for table in tables if table.sample)
    several = "name one recording in the column 'sample' of the list of trials, or write '*' for all"
    doubts = (*found.doubts, *wrong_stamps, *guess.doubts, *clock_doubts)
    return replace(
        found,
        columns=columns,
        n_rows=max((array.size for array in values if array is not None), default=0),
        samples=samples,
        sampling_rate_Hz=rate_Hz or guess.rate_Hz,
        is_uniform=is_uniform or bool(guess.rate_Hz),
        notes=tuple(dict.fromkeys(table.notes)),
        profile=replace(found.profile, channels=guess.channels, sampling_rate_Hz=guess.rate_Hz),
        doubts=(*doubts, several) if samples else doubts,
    )


def _load(table: Table) -> tuple[list[FloatArray | None], list[str]]:
    """Return every column, None where it holds something else than numbers, and which cell of some numbers is none."""
    doubts: list[str] = []

    def load(indices: Sequence[int]) -> list[FloatArray | None]:
        try:
            return [*table.values(indices)]
        except DataError as error:
            if len(indices) > 1:
                return [array for index in indices for array in load([index])]
            if indices[0] in table.stamps or not isinstance(error, WordError):
                doubts.append(str(error))
            return [None]

    return load(range(len(table.names))), [*dict.fromkeys(doubts)]


def _column(table: Table, index: int, array: FloatArray | None) -> ColumnSummary:
    present = array[~np.isnan(array)] if array is not None else np.empty(0)
    return ColumnSummary(
        number=index + 1,
        name=table.names[index].strip(),
        unit=table.unit(index),
        minimum=float(present.min()) if present.size else None,
        maximum=float(present.max()) if present.size else None,
        n_missing=0 if array is None else int(array.size - present.size),
        is_numeric=array is not None,
        is_integer=bool(present.size and (present == np.floor(present)).all()),
    )


def _clock(
    table: Table, values: Sequence[FloatArray | None], channels: Mapping[str, Channel]
) -> tuple[float | None, bool, tuple[str, ...]]:
    """Return sampling rate, whether the steps are even, and the error of the clock."""
    try:
        time_s = _clock_s(table, channels)
        if "time" in channels and not table.brings_time:
            index, unit = index_of(table, channels["time"]), unit_of(table, channels["time"])
            array = values[index] if index is not None else None
            time_s = array * si_scale("time", unit)[0] if array is not None and unit else None
        if time_s is None or time_s.size < 2:
            return None, False, ()
        others = [array for array in values if array is not None and array.size == time_s.size]
        _, mended_s, notes = mend_clock(time_s, others, name="the time", first_line=table.first_line)
    except DataError as error:
        return None, False, (str(error),)
    steps_s = np.diff(mended_s)
    if not steps_s.size:
        return None, False, notes
    step_s = mean_step_s(steps_s)
    is_uniform = bool((np.abs(steps_s - step_s) <= _UNIFORM * step_s).all())
    return float(f"{1.0 / step_s:.6g}"), is_uniform, notes


def _clock_s(table: Table, channels: Mapping[str, Channel]) -> FloatArray | None:
    """Return the time that the channels, or else the first column that has one, bring with them."""
    if table.clock is None:
        return None
    chosen = [index for channel in channels.values() if (index := index_of(table, channel)) is not None]
    clocks = (table.clock(index) for index in (*chosen, *range(len(table.names))))
    return next((time_s for time_s in clocks if time_s is not None), None)
