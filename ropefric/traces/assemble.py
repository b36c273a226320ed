"""From columns as they are in a file to a force trace in SI: every channel tared, and on the clock of the force."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ropefric.arrays import sealed
from ropefric.errors import DataError, Problem, RopefricError
from ropefric.registry import did_you_mean
from ropefric.traces.calibration import IN_NEWTONS, Calibration, ForceCell, tare_from_interval
from ropefric.traces.formulas import evaluate_derived
from ropefric.traces.readers.profile import ImportProfile, RawRecording
from ropefric.traces.segments import MIN_SAMPLES
from ropefric.traces.signals import Refusal, Signal, fastest, interpolated, placed, signals_of
from ropefric.traces.trace import ForceTrace


class _Cell(NamedTuple):
    """A force cell by its channels, newtons or volts and counts, and by the column of `trials.csv` that names it."""

    newtons: str
    counts: str
    column: str


_PULL = _Cell("force", "counts", "cell")
_SLACK = _Cell("end_tension", "end_tension_counts", "end_cell")
_NAME = re.compile(r"\w+")

Interval = Sequence[float] | None


def assemble_trace(
    raw: RawRecording,
    profile: ImportProfile,
    *,
    calibration: Calibration | None = None,
    end_calibration: Calibration | None = None,
    tare_s: Interval = None,
) -> ForceTrace:
    """Return the force trace of a recording: in SI, clocks mended, counts and volts calibrated, tared, channels derived.

    `tare_s` is the interval [s] in which the cells are unloaded, where the channel says nothing of it.
    """

    def refuse(message: str, code: str, key: str, fix: str) -> DataError:
        return DataError(message, code=code, path=raw.source, key=key, fix=fix)

    signals, notes = signals_of(raw, profile, refuse)
    doubts: list[Problem] = []
    tare = partial(_tared, profile=profile, campaign_s=tare_s, doubts=doubts)
    for name in signals.keys() - {*_PULL, *_SLACK}:
        signals[name] = tare(name, signals[name], IN_NEWTONS, campaign_s=None).signal
    signals = _with_derived(signals, profile, raw, refuse)
    try:
        found = {
            cell: _measured(cell, signals, known, tare, raw)
            for cell, known in ((_SLACK, end_calibration), (_PULL, calibration))
        }
    except RopefricError as error:
        problem = error.problem
        if problem.path:
            raise
        raise refuse(problem.message, problem.code, problem.key or "counts", problem.fix) from None
    pull, slack = found[_PULL], found[_SLACK]
    assert pull is not None  # noqa: S101  (there is a force, or it was refused)
    return ForceTrace(
        time_s=sealed(pull.signal.time_s),
        force_N=sealed(pull.signal.values),
        name=raw.name,
        source=raw.source,
        notes=notes,
        tare_N=pull.tare_N,
        doubts=tuple(replace(doubt, path=raw.source) for doubt in doubts),
        calibration=pull.calibration,
        end_tension_N=None if slack is None else placed(slack.signal, pull.signal.time_s),
        end_calibration=None if slack is None else slack.calibration,
        **pull.more,
    )


class _Measured(NamedTuple):
    """A force, what was taken off it [N], its measuring chain where that is known, and its counts and saturation."""

    signal: Signal
    tare_N: float
    calibration: Calibration | None
    more: Mapping[str, Any]


def _with_derived(
    signals: dict[str, Signal], profile: ImportProfile, raw: RawRecording, refuse: Refusal
) -> dict[str, Signal]:
    """Return the signals together with derived ones, on the clock of the fastest that these are made of."""
    if profile.derived and "time" not in profile.derived:
        words = {word for formula in profile.derived.values() for word in _NAME.findall(formula)}
        time_s = fastest({name: signals[name] for name in signals if name in words} or signals)
        aligned = {name: interpolated(signal, time_s) for name, signal in signals.items()}
        found = evaluate_derived(profile.derived, aligned, profile.constants, path=raw.source)
        # A channel that is computed from itself, -force, still holds the volts that its cell turns into newtons.
        units = {name: signals[name].unit if name in signals else "N" for name in profile.derived}
        signals = signals | {name: Signal(time_s, found[name], unit) for name, unit in units.items()}
    if not {_PULL.newtons, _PULL.counts} & signals.keys():
        others = f"; its channels are {', '.join(signals)}" if signals else ""
        message = f"no column of {raw.name} is named as the channel 'force' or 'counts'{others}"
        hint = f"; {did_you_mean('force', signals)}" if signals else ""
        fix = f"name its column in [import.channels], or derive it{hint}"
        raise refuse(message, "RF105", "[import.channels] force", fix)
    return signals


def _measured(
    cell: _Cell,
    signals: Mapping[str, Signal],
    known: Calibration | None,
    tare: "partial[_Measured]",
    raw: RawRecording,
) -> _Measured | None:
    """Return the force of a cell, tared; None where it has no channel."""
    if cell.newtons in signals:
        signal = signals[cell.newtons]
        if signal.unit == "N":
            return tare(cell.newtons, signal, IN_NEWTONS)._replace(calibration=None, more={})
        if known is None:
            message = f"{raw.name} holds {signal.unit.replace('V/V', 'mV/V')}, and nothing says how much force that is"
            fix = f'write sensitivity = "25 N/mV" beside its unit, or name the {cell.column} in trials.csv'
            raise DataError(message, code="RF210", key=f"[import.channels] {cell.newtons}", fix=fix)
        return tare(cell.newtons, _in_volts(signal, known.cell), replace(known, adc=None))
    if cell.counts not in signals:
        return None
    if known is None or known.adc is None:
        message = f"{raw.name} holds ADC counts, and there is no calibration to turn them into newtons"
        fix = f"name the {cell.column} in trials.csv and [adc] in campaign.toml"
        raise DataError(message, code="RF210", key=cell.counts, fix=fix)
    counts: Any = known.checked(signals[cell.counts].values)
    return tare(cell.counts, signals[cell.counts]._replace(values=counts), known)


def _in_volts(signal: Signal, cell: ForceCell) -> Signal:
    """Return the signal of a bridge as the volts that its transmitter would give."""
    if signal.unit == "V":
        return signal
    if not cell.rated_output:
        fix = f'add rated_output = "2 mV/V" to [cells.{cell.name}], from its sheet'
        raise DataError(
            f"the cell {cell.name} has no rated output for a signal in mV/V", code="RF210", fix=fix
        )
    share = signal.values / cell.rated_output
    return signal._replace(values=cell.zero_V + share * (cell.full_scale_V - cell.zero_V), unit="V")


def _tared(
    name: str,
    signal: Signal,
    calibration: Calibration,
    *,
    profile: ImportProfile,
    campaign_s: Interval,
    doubts: list[Problem],
) -> _Measured:
    """Return a signal by its calibration with the tare of the interval that its channel names, or else the campaign."""
    given = profile.channels.get(name)
    interval_s = campaign_s if given is None or given.tare_s is None else given.tare_s
    readings: Any = signal.values
    tare_N = 0.0
    if interval_s:
        present = np.isfinite(readings) if readings.dtype.kind == "f" else readings >= 0
        tare_N = np.nan  # of a recording that is too short, which picking says
        if np.count_nonzero(present) >= MIN_SAMPLES:
            calibration, found = tare_from_interval(signal.time_s, readings, calibration, *interval_s)
            doubts += (replace(one, key=f"{one.key} of {name}") for one in found)
            tare_N = calibration.tare_N
    force, saturation = calibration.apply(readings)
    more = {"counts": readings, "saturation": saturation} if calibration.adc else {}
    return _Measured(signal._replace(values=force), tare_N, calibration, more)
