"""From the columns of a recording to signals: in SI, each over its own mended clock, its hold reduced."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from ropefric.arrays import FloatArray, IntArray, median, sealed
from ropefric.errors import DataError, InputError
from ropefric.quantities import is_unit_of, scaled_by, si_unit_of, unit_factor
from ropefric.traces.clock import mean_step_s, mend_clock
from ropefric.traces.formulas import evaluate_derived
from ropefric.traces.readers.profile import ImportProfile, RawRecording

COUNTS = ("counts", "end_tension_counts")
"""Channels of raw counts: of the pull, and of a second cell on the slack side."""
FORCES = ("force", "end_tension")
RATE_TOLERANCE = 0.01
"""How far a stated sampling rate may be from that of the time stamps [-]."""

FIXED_UNITS = {"time": "s", "force": "N", "end_tension": "N"}
"""The SI units of channels that have one quantity only."""

_EXAMPLE = {"time": "s", "force": "kN", "end_tension": "N"}

_FEWEST_READINGS = 20
_NO_RUN = 0.02
"""Part of the readings that may stand for less than half as long as they usually do: one is cut by a lost line."""
_REGULAR = 0.9
_FINE = 0.5
"""Share of smallest steps above which the converter is too coarse to show a hold."""

Refusal = Callable[..., DataError]


class Signal(NamedTuple):
    """One channel over a clock of its own; its unit is SI, "V" or "V/V" where a cell is to make it a force."""

    time_s: FloatArray
    values: FloatArray
    unit: str


def si_scale(channel: str, unit: str, sensitivity: str = "", *, path: str = "") -> tuple[float, str]:
    """Return the factor that turns a channel's numbers into SI, and the unit that they have then.

    `time` comes to seconds, a force to newtons, or to the volts or volts per volt of its cell; counts stay as they are;
    any other channel comes to the SI unit of its own dimension, and is taken as a bare number where it has no unit.
    A sensitivity, such as 25 N/mV, makes of it what it says.
    """
    fixed = FIXED_UNITS.get(channel, "")
    if channel in COUNTS or (unit == fixed and not sensitivity):
        return 1.0, fixed
    example = f'unit = "{_EXAMPLE.get(channel, "mm")}"'
    if not unit:
        raise _no_scale(channel, f"the {channel} has no unit", "give the unit", example, path)
    try:
        factor, found = scaled_by(unit, sensitivity) if sensitivity else _by_unit(channel, unit)
    except InputError as error:
        is_stated = bool(sensitivity or fixed)
        raise _no_scale(channel, *_why_unknown(unit, error, is_stated=is_stated), example, path) from None
    if not sensitivity or fixed in ("", found):
        return factor, found
    reason = f"{unit} by a sensitivity of {sensitivity} gives no {fixed}"
    example = f'unit = "{unit}", sensitivity = "25 N/{unit}"'
    raise _no_scale(channel, reason, "give force per signal", example, path)


def _why_unknown(unit: str, error: InputError, *, is_stated: bool) -> tuple[str, str]:
    """Return why a unit has no factor, and what to do; of a column whose quantity is open, only that it is unknown."""
    if is_stated or error.fix.startswith("write '"):  # a mistyped unit
        return error.problem.message.split(": ", 1)[-1], error.fix or "give the unit"
    return f"unknown unit '{unit[:40]}'", "give the unit"


def _no_scale(channel: str, reason: str, hint: str, example: str, path: str) -> DataError:
    fix = f"{hint}, for example {channel} = {{ column = …, {example} }}"
    return DataError(reason, code="RF106", path=path, key=f"[import.channels] {channel}", fix=fix)


def _by_unit(channel: str, unit: str) -> tuple[float, str]:
    """Return the factor of a unit, and the unit after it; a force may be in volts, or in volts per volt."""
    signal = signal_unit(channel, unit)
    si_unit = signal or FIXED_UNITS.get(channel) or si_unit_of(unit)
    return unit_factor(unit, "" if signal == "V/V" else si_unit, name=channel), si_unit


def signal_unit(channel: str, unit: str) -> str:
    """Return "V" or "V/V" for the unit of a force that its amplifier or its bridge gives, "" for any other."""
    kinds = (("V", "V"), ("", "V/V")) if channel in FORCES and "V" in unit else ()
    return next((found for si_unit, found in kinds if is_unit_of(unit, si_unit)), "")


def is_of(channel: str, unit: str) -> bool:
    """Return whether a unit is one of a time or a force, or of what a cell gives for a force."""
    return is_unit_of(unit, FIXED_UNITS[channel]) or bool(signal_unit(channel, unit))


def signals_of(
    raw: RawRecording, profile: ImportProfile, refuse: Refusal
) -> tuple[dict[str, Signal], tuple[str, ...]]:
    """Return the channels of a recording but for the time as signals, and what was mended of them."""
    scaled = {name: _in_si(name, raw, profile, refuse) for name in raw.columns}
    columns = {name: values for name, (values, _) in scaled.items()}
    units = {name: unit for name, (_, unit) in scaled.items()}
    if "time" in profile.derived:
        columns = evaluate_derived(profile.derived, columns, profile.constants, path=raw.source)
    common_s = columns.pop("time", None)
    clocks: dict[int, tuple[FloatArray, list[str]]] = {}
    for name, values in columns.items():
        clock_s = raw.clocks.get(name, common_s)
        if clock_s is None:
            clock_s = common_s = _by_rate(values.size, raw, profile, refuse)
        if clock_s.size != values.size:
            message = f"{name} has {values.size} values, its time {clock_s.size}"
            fix = f'name the time of this channel, {name} = {{ column = "…", time = "…" }}'
            raise refuse(message, "RF103", f"[import.channels] {name}", fix)
        clocks.setdefault(id(clock_s), (clock_s, []))[1].append(name)
    signals, notes = dict[str, Signal](), [*raw.notes]
    for clock_s, names in clocks.values():
        keep, time_s, said = mend_clock(
            clock_s,
            [columns[name] for name in names],
            name=raw.name,
            source=raw.source,
            first_line=raw.first_line,
        )
        notes += said
        _compare_rates(time_s, raw, profile, refuse)
        for name in names:
            signals[name], said = _without_hold(
                name, Signal(time_s, columns[name][keep], units.get(name, "N"))
            )
            notes += said
    return {name: signals[name] for name in columns}, tuple(dict.fromkeys(notes))


def _in_si(name: str, raw: RawRecording, profile: ImportProfile, refuse: Refusal) -> tuple[FloatArray, str]:
    given, values = profile.channels.get(name), raw.columns[name]
    factor, si_unit = si_scale(
        name, raw.units.get(name, ""), given.sensitivity if given else "", path=raw.source
    )
    if factor != 1.0:
        with np.errstate(over="ignore"):
            values = sealed(values * factor)
        if (large := np.isinf(values)).any():
            message = f"sample {int(np.argmax(large)) + 1} is too large for a float in SI"
            raise refuse(message, "RF102", name, "mend the value, or check the unit")
    return values, si_unit


def _by_rate(n: int, raw: RawRecording, profile: ImportProfile, refuse: Refusal) -> FloatArray:
    rate_Hz = profile.sampling_rate_Hz or raw.rate_Hz
    if rate_Hz is None or not np.isfinite(rate_Hz) or rate_Hz <= 0:
        fix = (
            'name the time column, time = { column = 1, unit = "s" }, or set [import] sampling_rate = "3 kHz"'
        )
        message = f"{raw.name} has no time channel and no usable sampling rate"
        raise refuse(message, "RF105", "[import.channels] time", fix)
    # Divided, not added up: sample i is at exactly i / rate.
    return np.arange(n, dtype=np.float64) / rate_Hz


def _compare_rates(time_s: FloatArray, raw: RawRecording, profile: ImportProfile, refuse: Refusal) -> None:
    """Refuse a clock against the sampling rate that the profile states, or the head of the file where it states none."""
    stated_Hz, steps_s = profile.sampling_rate_Hz or raw.rate_Hz, np.diff(time_s)
    if not stated_Hz or not steps_s.size:
        return
    found_Hz = 1.0 / mean_step_s(steps_s)
    if abs(found_Hz / stated_Hz - 1.0) <= RATE_TOLERANCE:
        return
    where, key = "the profile", "[import] sampling_rate"
    fix = "correct the unit of the time column or the rate, or leave one of the two out"
    if not profile.sampling_rate_Hz:
        where, key = "the head of the file", "[import.channels] time"
        overruled = f'[import] sampling_rate = "{found_Hz:.6g} Hz"'
        fix = f"correct the unit of the time column, or set {overruled} if the head is wrong"
    message = f"the time stamps say {found_Hz:.6g} Hz, {where} {stated_Hz:.6g} Hz"
    raise refuse(message, "RF203", key, fix)


def _without_hold(name: str, signal: Signal) -> tuple[Signal, tuple[str, ...]]:
    """Return a signal with one sample a reading, and what to say where a slow sensor was written too often."""
    kept, period = held_readings(signal.values)
    if not kept.size:
        return signal, ()
    time_s = signal.time_s[kept]
    said = (
        f"{name}: each reading of the sensor is repeated {period:.3g} times; the first of each was kept, "
        f"{1.0 / median(np.diff(time_s)):.4g} Hz"
    )
    return Signal(time_s, signal.values[kept], signal.unit), (said,)


def held_readings(values: FloatArray) -> tuple[IntArray, float]:
    """Return the first sample of each reading, and over how many samples a reading is held; nothing for no hold.

    A hold changes at steps of one length only, also where the signal falls fast. A coarse converter, whose steps are
    mostly of one count, does not show it.
    """
    nothing = np.empty(0, dtype=np.int64), 1.0
    changes = values[1:] != values[:-1]
    changes &= ~(np.isnan(values[1:]) & np.isnan(values[:-1]))
    if not _FEWEST_READINGS <= np.count_nonzero(changes) <= 0.5 * values.size:
        return nothing
    starts = np.flatnonzero(changes) + 1
    lengths, usual = np.diff(starts), median(np.diff(starts).astype(np.float64))
    period = float(lengths[lengths < 1.5 * usual].mean())
    some = lengths[lengths < 3.5 * period]
    off = np.abs(some - period * np.round(some / period))
    is_regular = np.mean(off <= max(1.0, 0.1 * period)) >= _REGULAR
    if period < 2.0 or not is_regular or np.mean(lengths < max(2.0, 0.5 * period)) > _NO_RUN:
        return nothing
    steps = np.abs(np.diff(values))[changes]
    steps = steps[np.isfinite(steps)]
    if not steps.size or np.mean(steps <= 1.5 * steps.min()) > _FINE:
        return nothing
    bounds = np.append(starts, values.size)
    numbers = np.maximum(np.rint(np.diff(bounds) / period).astype(np.int64), 1)
    rank = np.arange(numbers.sum()) - np.repeat(np.cumsum(numbers) - numbers, numbers)
    later = np.repeat(starts, numbers) + np.rint(rank * period).astype(np.int64)
    # Of readings that began before the recording, none.
    first = np.arange(starts[0] - period, -0.5, -period)[::-1]
    kept = np.append(np.rint(first).astype(np.int64), later[later < values.size])
    return kept if kept.size and kept[0] >= 0 else later, period


def interpolated(signal: Signal, time_s: FloatArray) -> FloatArray:
    """Return a signal at other times, linear between its samples; NaN before its first and after its last."""
    if signal.time_s is time_s:
        return signal.values
    found = np.interp(time_s, signal.time_s, signal.values)
    found[(time_s < signal.time_s[0]) | (time_s > signal.time_s[-1])] = np.nan
    return found


def placed(signal: Signal, time_s: FloatArray) -> FloatArray:
    """Return a signal on a clock: where it is slower, each sample once, at the nearest time, and NaN between."""
    if signal.time_s is time_s or time_s.size < 2 or signal.time_s.size < 2:
        return interpolated(signal, time_s)
    if median(np.diff(signal.time_s)) < 1.5 * median(np.diff(time_s)):
        return interpolated(signal, time_s)
    found = np.full(time_s.size, np.nan)
    inside = (signal.time_s >= time_s[0]) & (signal.time_s <= time_s[-1])
    place = np.searchsorted(0.5 * (time_s[1:] + time_s[:-1]), signal.time_s[inside])
    found[place] = signal.values[inside]
    return found


def fastest(signals: Mapping[str, Signal]) -> FloatArray:
    """Return the clock of the signal of most samples."""
    return max(signals.values(), key=lambda signal: signal.values.size).time_s
