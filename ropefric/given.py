"""Input of users in many forms, tables, arrays, quantities with units, converted to SI."""

import os
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError, Kind, RopefricWarning, UnknownNameError
from ropefric.quantities import example_unit, parse_quantity, split_unit_suffix, unit_factor
from ropefric.registry import did_you_mean
from ropefric.traces.calibration import IN_NEWTONS, tare_from_interval
from ropefric.traces.clock import mend_clock
from ropefric.traces.readers.table import SAFE_NAMES
from ropefric.traces.trace import ForceTrace
from ropefric.trials import cells
from ropefric.trials.table import TrialTable, read_trial_table, table_from_frame

if TYPE_CHECKING:
    import pandas as pd

Columns = Mapping[str, str] | Sequence[str] | None
"""Names that columns are to have: by those they have, or one after the other for an array without names."""
_NAMES = Kind((Mapping, list, tuple), "new names by the old ones, or names in order")

_ODD = {
    "wrap_angle_rad": (20.0 * np.pi, "{:g} rad is a wrap of {:.3g} turns", 0.5 / np.pi, "deg"),
    "wheel_radius_m": (5.0, "{:g} m is a wheel of {:.3g} m diameter", 2.0, "mm"),
    "rope_radius_m": (0.5, "{:g} m is a rope of {:.3g} m diameter", 2.0, "mm"),
}
"""The limit above which a setting is improbable, its message, and the unit that was probably meant."""
_SHOWN_HEADERS = 8
_USER = 4
"""Calls from a warning up to the line that called a function of `import ropefric` with settings."""


def in_si(value: Any, si_unit: str, name: str = "quantity") -> FloatArray:
    """Return numbers in SI: bare ones as they stand, text with a unit (`"35 mm"`) and pint quantities converted."""
    if isinstance(value, bool | bytes):
        raise InputError(f"{value!r} is no number", key=name, fix="give a number")
    if hasattr(value, "to") and hasattr(value, "magnitude"):
        try:
            value = value.to(si_unit or "dimensionless").magnitude
        except Exception as error:  # noqa: BLE001  (whatever pint says of another dimension)
            text = f"{value} cannot be given in {si_unit or '1'}: {error}"
            raise InputError(text, code="RF130", key=name, fix="give a quantity of that dimension") from None
    elif isinstance(value, str):
        value = parse_quantity(value, si_unit, name=name)
    elif isinstance(value, Sequence) or getattr(getattr(value, "dtype", None), "kind", "") in {"O", "U"}:
        value = [in_si(one, si_unit, name) for one in value]
    try:
        array = np.asarray(value)
        if array.dtype.kind in "mMc":  # as floats they would be nanoseconds, or lose their imaginary part
            raise TypeError  # noqa: TRY301
        return array.astype(np.float64, copy=False)
    except (TypeError, ValueError):
        fix = f"give numbers{f' in {si_unit}' if si_unit else ''}"
        raise InputError(f"{value!r:.60} is no number", key=name, fix=fix) from None


def number(value: Any, si_unit: str, name: str) -> float:
    """Return one number in SI, of what `in_si` takes."""
    found = in_si(value, si_unit, name)
    if found.size != 1 or found.ndim > 1:
        raise InputError(f"{found.size} values where one is meant", key=name, fix="give one")
    return float(found.item())


def numbers_given(**given: Any) -> dict[str, Any]:
    """Return numbers in the units of their names, None where none is given."""
    return {
        name: None if value is None else number(value, split_unit_suffix(name)[1], name)
        for name, value in given.items()
    }


def settings(**given: Any) -> dict[str, FloatArray]:
    """Return the settings that are given (not None) in SI, by name, and warn of improbable values."""
    known = {name: value for name, value in given.items() if value is not None}
    found = {name: in_si(value, split_unit_suffix(name)[1], name) for name, value in known.items()}
    for name, values in found.items():
        if not values.size:
            raise InputError(f"{name} is empty", key=name, fix="give one value or more")
    warn_of_odd(found)
    return found


def in_declared_units(others: Mapping[str, Any], **declared: Any) -> dict[str, Any]:
    """Return declared arguments, with those that came under another unit or name, such as wheel_diameter_mm, in SI.

    >>> found = in_declared_units({"wheel_diameter_mm": 70, "lift": "2 kN"}, wheel_radius_m=None, lift_N=None)
    >>> [float(one) for one in found.values()]
    [0.035, 2000.0]
    """
    known: dict[str, cells.Quantity] = {}
    for prefix in ("", "u_"):
        for stem, (field, unit, factor) in cells.SETTINGS.items():
            if prefix + field in declared:
                known[prefix + stem] = (prefix + field, unit, factor)
    for name in declared:
        stem, unit = split_unit_suffix(name)
        known[stem] = (name, unit, 1.0)
    for name, value in ((name, value) for name, value in others.items() if value is not None):
        stem, unit = split_unit_suffix(name)
        if stem not in known:
            fix = did_you_mean(name, [*declared, *known])
            raise UnknownNameError(f"there is no argument {name}", key=name, fix=fix)
        field, si_unit, factor = known[stem]
        if declared[field] is not None:
            text = f"{name} and another argument both give {field}"
            raise InputError(text, key=name, fix="leave one of them out")
        if not _has_units(value):
            if not unit:
                fix = f'write {stem}="… {example_unit(si_unit)}" or {stem}_{si_unit.replace("/", "_")}=…'
                raise InputError(f"{name} does not say its unit", key=name, fix=fix)
            factor *= unit_factor(unit, si_unit, name=name)
        declared[field] = in_si(value, si_unit, name) * factor
    return declared


def warn_of_odd(values: Mapping[str, FloatArray]) -> None:
    """Warn where a wrap was probably meant in degrees, or a size in millimetres."""
    for name, (most, what, factor, unit) in _ODD.items():
        some = values.get(name, np.zeros(0))
        largest = float(np.max(some, initial=0.0, where=np.isfinite(some)))
        if largest > most:
            said = what.format(largest, factor * largest)
            text = f'{name}: {said}. Fix: if {unit} was meant, write it with its unit, "{largest:g} {unit}"'
            warnings.warn(RopefricWarning(text), stacklevel=_USER)


def as_frame(table: Any, columns: Columns = None) -> "pd.DataFrame":
    """Return a DataFrame of a frame, a mapping of columns, or an array, its columns renamed, quantities as SI."""
    import pandas as pd  # noqa: PLC0415  (slow to load, and few calls need it)

    _NAMES.check_given(columns=columns)
    renamed = dict(columns) if isinstance(columns, Mapping) else {}
    if not (isinstance(table, Mapping) or hasattr(table, "columns")):
        table = _of_array(table, None if renamed else columns)
    _refuse_strangers(renamed, getattr(table, "columns", table))
    if isinstance(table, Mapping):
        return _of_columns({renamed.get(name, name): values for name, values in table.items()})
    frame: pd.DataFrame = table.rename(columns=renamed)
    texts = [name for name in frame.columns if not pd.api.types.is_numeric_dtype(frame[name])]
    if any(_has_units(frame[name]) for name in texts):
        return _of_columns({name: frame[name].tolist() for name in frame.columns})
    return frame


def _refuse_strangers(renamed: Mapping[str, str], known: Any) -> None:
    for name in renamed:
        if name not in known:
            fix = did_you_mean(str(name), map(str, known))
            raise UnknownNameError(f"there is no column {name!r} to be renamed", key="columns", fix=fix)


def _of_array(array: Any, columns: Columns) -> "pd.DataFrame":
    dtype = getattr(array, "dtype", None)
    if dtype is None:
        fix = "give a DataFrame, a mapping of columns, or an array"
        raise InputError(f"{type(array).__name__} is no table", key="wheels", fix=fix)
    return _whole(array, columns=None if columns is None or dtype.names else list(columns))


def _of_columns(columns: Mapping[Any, Any]) -> "pd.DataFrame":
    """Return the frame of columns by their headers: quantities in SI, one value for all rows where there is one."""
    known = {**cells.QUANTITIES, "time": ("", "s", 1.0), "force": ("", "N", 1.0)}
    plain: dict[Any, Any] = {}
    for header, values in columns.items():
        stem = split_unit_suffix(str(header))[0]
        meant = known.get(cells.word_of(stem))
        if meant is not None and _has_units(values):
            plain[f"{stem} [{meant[1]}]"] = np.atleast_1d(in_si(values, meant[1], str(header)))
        else:
            plain[header] = values if np.ndim(values) else [values]
    longest = max((len(values) for values in plain.values()), default=0)
    return _whole(
        {k: np.repeat(values, longest) if len(values) == 1 else values for k, values in plain.items()}
    )


def _whole(table: Any, **options: Any) -> "pd.DataFrame":
    import pandas as pd  # noqa: PLC0415  (likewise)

    try:
        return pd.DataFrame(table, **options)
    except ValueError as error:
        text = f"this is no table: {error}"
        raise InputError(text, key="columns", fix="give columns of one length") from None


def _has_units(values: Any) -> bool:
    """Return whether a column holds pint quantities or texts such as "35 mm"."""
    if hasattr(values, "magnitude") or isinstance(values, str):
        first = values
    else:
        first = next(iter(values), None) if np.ndim(values) else None
    if isinstance(first, str):
        return first[:1].isdigit() and not first[-1].isdigit()
    return hasattr(first, "magnitude")


def as_table(table: Any, columns: Columns = None) -> TrialTable:
    """Return the trial table of a file, or of what `as_frame` takes."""
    _NAMES.check_given(columns=columns)
    if isinstance(table, str | os.PathLike):
        if columns is not None and not isinstance(columns, Mapping):
            text = "the columns of a file have names, so new ones are given by the old ones"
            raise InputError(text, key="columns", fix='write {"F [N]": "peak_N"}')
        found = read_trial_table(table, columns)
    else:
        found = table_from_frame(as_frame(table, columns))
    warn_of_odd({name: getattr(found, name)[found.used] for name in _ODD})
    return found


def wheels_of(table: Any, columns: Columns = None) -> dict[str, FloatArray]:
    """Return the settings of a table of wheels, or of one row of it, with headers as in a trial table."""
    is_row = hasattr(table, "index") and hasattr(table, "to_dict") and not hasattr(table, "columns")
    frame, found = as_frame(table.to_dict() if is_row else table, columns), {}
    for header in frame.columns:
        stem, unit = split_unit_suffix(str(header))
        field, si_unit, factor = cells.SETTINGS.get(cells.word_of(stem), ("", "", 0.0))
        if field and not unit:
            text, fix = f"the column {header!r} does not say its unit", "or rename it with columns="
            raise InputError(text, key=str(header), fix=f"call it {stem}_{si_unit}, {fix}")
        if field:
            found[field] = in_si(frame[header].to_numpy(), "", header) * unit_factor(unit, si_unit) * factor
    return settings(**found)


def as_trace(
    trace: Any, force_N: Any = None, columns: Columns = None, sampling_rate: Any = None
) -> ForceTrace:
    """Return a trace of itself, of times and forces, of forces at a rate, of a series over time, or of a table."""
    if isinstance(trace, ForceTrace):
        refuse_given(force_N=force_N, columns=columns, sampling_rate=sampling_rate)
        return trace
    if sampling_rate is not None and force_N is not None:
        text, fix = "either the times or a sampling rate is needed", "leave one of them out"
        raise InputError(text, key="sampling_rate", fix=fix)
    if force_N is not None:
        return _recorded(in_si(trace, "s", "time_s"), in_si(force_N, "N", "force_N"))
    if (
        isinstance(trace, Mapping)
        or hasattr(trace, "columns")
        or getattr(trace, "ndim", 1) > 1
        or _named_fields(trace)
    ):
        return _of_table(trace, columns, sampling_rate)
    if hasattr(trace, "dtype") or isinstance(trace, list | tuple):
        return _of_forces(trace, sampling_rate)
    fix = "give a file, a table, times and forces, or forces and their sampling_rate"
    raise InputError(f"{type(trace).__name__} is no recording", key="trace", fix=fix)


def _of_forces(trace: Any, sampling_rate: Any) -> ForceTrace:
    """Return the trace of forces at equal steps of time, or over the index of their series."""
    if np.ndim(next(iter(trace), 0.0)):
        fix = "give a file, a table, times and forces, or forces and their sampling_rate"
        raise InputError(f"{type(trace).__name__} is no recording", key="trace", fix=fix)
    if sampling_rate is not None:
        forces_N = in_si(trace, "N", "force_N")
        return _recorded(_times_s(forces_N.size, sampling_rate), forces_N)
    if hasattr(trace, "index") and hasattr(trace, "to_frame") and type(trace.index).__name__ != "RangeIndex":
        return _of_series(trace)
    fix = "give the times too, or sampling_rate"
    raise InputError("forces alone do not say when they were taken", key="sampling_rate", fix=fix)


def refuse_given(**others: Any) -> None:
    """Refuse the first argument that is given beside a trace or a file."""
    for name in (name for name, value in others.items() if value is not None):
        text = "a trace or a file has times and forces of its own"
        raise InputError(text, key=name, fix=f"leave {name} out, or give times and forces as arrays")


def _named_fields(array: Any) -> bool:
    return getattr(getattr(array, "dtype", None), "names", None) is not None


def _of_table(table: Any, columns: Columns, sampling_rate: Any) -> ForceTrace:
    """Return the trace of a table: its columns of times and forces, or the times by a rate."""
    if getattr(getattr(table, "index", None), "name", None) is not None:
        table = table.reset_index()
    frame = as_frame(table, columns)
    headers = [str(name) for name in frame.columns]

    def channel(kind: str, unit: str) -> FloatArray:
        name = _named(headers, kind, unit)
        return unit_factor(split_unit_suffix(name)[1], unit, name=name) * in_si(
            frame[name].to_numpy(), "", name
        )

    time_s = channel("time", "s") if sampling_rate is None else _times_s(len(frame), sampling_rate)
    return _recorded(time_s, channel("force", "N"))


def _named(headers: Sequence[str], channel: str, unit: str) -> str:
    """Return the one header that is a channel with its unit."""
    names = [name for name in headers if split_unit_suffix(name)[0].lower() in SAFE_NAMES[channel]]
    if len(names) == 1 and split_unit_suffix(names[0])[1]:
        return names[0]
    found = "more than one" if len(names) > 1 else "no"
    known = f"{', '.join(headers[:_SHOWN_HEADERS])}{', …' if len(headers) > _SHOWN_HEADERS else ''}"
    text = f"{found} {channel} column with its unit in {known or 'an empty table'}"
    fix = f'name one with its unit, columns={{"…": "{channel}_{unit}"}}, or give times and forces'
    raise InputError(text, key="columns", fix=fix)


def _times_s(n: int, sampling_rate: Any) -> FloatArray:
    """Return the times of samples at equal steps."""
    rate_Hz = number(sampling_rate, "Hz", "sampling_rate")
    if not 0.0 < rate_Hz < np.inf:
        text = f"sampling_rate = {rate_Hz:g} Hz must be positive"
        raise InputError(text, key="sampling_rate", fix="give samples per second")
    return np.arange(n) / rate_Hz


def _of_series(series: Any) -> ForceTrace:
    """Return the trace of a series of forces whose index is a time: seconds, durations or time stamps."""
    index = series.index
    kind = getattr(index.dtype, "kind", "")
    if kind in {"m", "M"}:
        time_s = np.asarray((index - index[0]).total_seconds()) if len(index) else np.empty(0)
    else:
        time_s = in_si(index.to_numpy(), "s", "the index of the series")
    unit = split_unit_suffix(str(series.name or ""))[1] or "N"
    factor = unit_factor(unit, "N", name=f"the series {series.name!r}")
    return _recorded(time_s, factor * in_si(series.to_numpy(), "N", "force_N"))


def _recorded(time_s: FloatArray, force_N: FloatArray) -> ForceTrace:
    """Return a trace of what was recorded, its clock mended by the rule for files."""
    if time_s.ndim != 1 or time_s.shape != force_N.shape:
        text = f"the times have the shape {time_s.shape}, the forces {force_N.shape}"
        raise InputError(text, key="force_N", fix="give one list of times, and a force for each")
    if not time_s.size:
        raise InputError("the recording has no samples", key="trace", fix="give times and forces")
    keep, time_s, notes = mend_clock(time_s, [force_N], name="trace")
    return ForceTrace(time_s=time_s, force_N=force_N[keep], notes=notes)


def tared(trace: ForceTrace, tare: Any) -> ForceTrace:
    """Return a trace counted from what the sensor showed without load: a force, or its mean over an interval."""
    if tare is None:
        return trace
    if isinstance(tare, str) or np.ndim(tare) == 0:
        return replace(trace, force_N=trace.force_N - number(tare, "N", "tare"))
    if np.shape(tare) != (2,):
        fix = "give (from, until) in seconds, or the force that was shown without load"
        raise InputError("tare is an interval or one force", key="tare", fix=fix)
    interval_s = in_si(list(tare), "s", "tare").tolist()
    found, doubts = tare_from_interval(trace.time_s, trace.force_N, IN_NEWTONS, *interval_s)
    notes = (*trace.notes, *(one.message for one in doubts))
    return replace(trace, force_N=trace.force_N - found.tare_N, notes=notes)
