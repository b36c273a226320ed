"""From columns as they are in a file to a force trace in SI."""

from collections.abc import Mapping

import numpy as np

from ropefric.arrays import FloatArray, IntArray
from ropefric.errors import DataError, InputError, RopefricError
from ropefric.quantities import si_unit_of, unit_factor
from ropefric.registry import did_you_mean
from ropefric.traces.calibration import Calibration, as_counts
from ropefric.traces.clock import mend_clock
from ropefric.traces.derived import evaluate_derived
from ropefric.traces.readers.profile import ImportProfile, RawRecording
from ropefric.traces.trace import ForceTrace

_FIXED = {"time": "s", "force": "N"}
_EXAMPLE = {"time": "ms", "force": "kN"}


def si_factor(channel: str, unit: str, *, path: str = "") -> float:
    """Return the factor that turns a channel's numbers into SI.

    `time` comes to seconds, `force` to newtons, `counts` stays as it is; any other channel comes to the SI
    unit of its own dimension, and is taken as a bare number where it has no unit.
    """
    fixed = _FIXED.get(channel)
    if channel == "counts" or unit == fixed or (fixed is None and not unit):
        return 1.0
    if fixed and not unit:
        raise _unit_error(channel, f"the {channel} has no unit", path)
    try:
        return unit_factor(unit, fixed or si_unit_of(unit), name=channel)
    except InputError as error:
        reason, hint = f"unknown unit '{unit[:40]}'", ""
        if fixed or error.fix.startswith("write '"):  # a mistyped unit
            reason, hint = error.problem.message.split(": ", 1)[-1], error.fix
    raise _unit_error(channel, reason, path, hint)


def _unit_error(channel: str, reason: str, path: str, hint: str = "") -> DataError:
    example = f'{channel} = {{ column = 1, unit = "{_EXAMPLE.get(channel, "mm")}" }}'
    return DataError(
        reason,
        code="RF106",
        path=path,
        key=f"[import.channels] {channel}",
        fix=f"{hint or 'give the unit'}, for example {example}",
    )


def assemble_trace(
    raw: RawRecording, profile: ImportProfile, *, calibration: Calibration | None = None
) -> ForceTrace:
    """Return the force trace of a recording: in SI, derived channels computed, clock mended, counts calibrated."""
    channels = _to_si(raw)
    if profile.derived:
        channels = evaluate_derived(profile.derived, channels, profile.constants, path=raw.source)
    if "force" not in channels and "counts" not in channels:
        raise _no_force(raw, channels)
    others = [values for name, values in channels.items() if name != "time"]
    keep, time_s, notes = mend_clock(
        _time(raw, channels, profile), others, name=raw.name, source=raw.source, first_line=raw.first_line
    )
    if "force" in channels:
        return ForceTrace(
            time_s=time_s, force_N=channels["force"][keep], name=raw.name, source=raw.source, notes=notes
        )
    if calibration is None:
        raise DataError(
            f"{raw.name} holds ADC counts, and there is no calibration to turn them into newtons",
            code="RF210",
            path=raw.source,
            key="counts",
            fix="name the cell in trials.csv and [adc] in campaign.toml",
        )
    try:
        counts: IntArray = as_counts(channels["counts"][keep])
        force_N, saturation = calibration.apply(counts)
    except RopefricError as error:
        raise _in_file(error, raw) from None
    return ForceTrace(
        time_s=time_s,
        force_N=force_N,
        name=raw.name,
        source=raw.source,
        counts=counts,
        calibration=calibration,
        saturation=saturation,
        notes=notes,
    )


def _to_si(raw: RawRecording) -> dict[str, FloatArray]:
    channels = {}
    for name, values in raw.columns.items():
        factor = si_factor(name, raw.units.get(name, ""), path=raw.source)
        channels[name] = values if factor == 1.0 else _scaled(values, factor, name, raw.source)
    return channels


def _scaled(values: FloatArray, factor: float, name: str, path: str) -> FloatArray:
    with np.errstate(over="ignore"):
        scaled = values * factor
    if np.isinf(scaled).any():
        raise DataError(
            f"sample {int(np.argmax(np.isinf(scaled))) + 1} is too large for a float in SI",
            code="RF102",
            path=path,
            key=name,
            fix="mend the value, or check the unit",
        )
    return scaled


def _time(raw: RawRecording, channels: Mapping[str, FloatArray], profile: ImportProfile) -> FloatArray:
    if "time" in channels:
        return channels["time"]
    rate_Hz = profile.sampling_rate_Hz
    if rate_Hz is None or not np.isfinite(rate_Hz) or rate_Hz <= 0:
        raise DataError(
            f"{raw.name} has no time channel and no usable sampling rate",
            code="RF105",
            path=raw.source,
            key="[import.channels] time",
            fix='name the time column, time = { column = 1, unit = "s" }, or set [import] sampling_rate = "3 kHz"',
        )
    # Divided, not added up: sample i is at exactly i / rate.
    return np.arange(next(iter(channels.values())).size, dtype=np.float64) / rate_Hz


def _no_force(raw: RawRecording, channels: Mapping[str, FloatArray]) -> DataError:
    return DataError(
        f"{raw.name} has no channel 'force' or 'counts', only {', '.join(channels) or 'none'}",
        code="RF105",
        path=raw.source,
        key="[import.channels] force",
        fix=f"name its column or derive it; {did_you_mean('force', channels)}",
    )


def _in_file(error: RopefricError, raw: RawRecording) -> DataError:
    problem = error.problem
    return DataError(
        problem.message, code=problem.code, path=raw.source, key=problem.key or "counts", fix=problem.fix
    )
