"""From columns as they are in a file, and channels computed from them by a short formula, to a force trace in SI."""

import ast
import math
from collections.abc import Callable, Mapping
from collections.abc import Set as AbstractSet
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ropefric.arrays import FloatArray, IntArray
from ropefric.errors import DataError, InputError, RopefricError
from ropefric.quantities import si_unit_of, unit_factor
from ropefric.registry import did_you_mean
from ropefric.traces.calibration import Calibration
from ropefric.traces.clock import mend_clock
from ropefric.traces.readers.profile import ImportProfile, RawRecording
from ropefric.traces.trace import ForceTrace

_FIXED = {"time": "s", "force": "N", "end_tension": "N"}
_EXAMPLE = {"time": "ms", "force": "kN", "end_tension": "N"}


class _Cell(NamedTuple):
    """A force cell by its channels, in newtons or in counts, and by the column of `trials.csv` that names it."""

    newtons: str
    counts: str
    column: str


_PULL = _Cell("force", "counts", "cell")
_SLACK = _Cell("end_tension", "end_tension_counts", "end_cell")
COUNTS = (_PULL.counts, _SLACK.counts)
"""Channels of raw counts: of the pull, and of a second cell on the slack side."""

Channels = dict[str, FloatArray]
Refusal = Callable[..., DataError]


def si_factor(channel: str, unit: str, *, path: str = "") -> float:
    """Return the factor that turns a channel's numbers into SI.

    `time` comes to seconds, `force` to newtons, `counts` stays as it is; any other channel comes to the SI
    unit of its own dimension, and is taken as a bare number where it has no unit.
    """
    fixed = _FIXED.get(channel)
    if channel in COUNTS or unit == fixed or (fixed is None and not unit):
        return 1.0
    reason, hint = f"the {channel} has no unit", "give the unit"
    if unit:
        try:
            return unit_factor(unit, fixed or si_unit_of(unit), name=channel)
        except InputError as error:
            reason = f"unknown unit '{unit[:40]}'"
            if fixed or error.fix.startswith("write '"):  # a mistyped unit
                reason, hint = error.problem.message.split(": ", 1)[-1], error.fix or hint
    raise DataError(
        reason,
        code="RF106",
        path=path,
        key=f"[import.channels] {channel}",
        fix=f'{hint}, for example {channel} = {{ column = 1, unit = "{_EXAMPLE.get(channel, "mm")}" }}',
    )


def assemble_trace(
    raw: RawRecording,
    profile: ImportProfile,
    *,
    calibration: Calibration | None = None,
    end_calibration: Calibration | None = None,
    tared: Callable[[FloatArray, IntArray, Calibration], Calibration] | None = None,
) -> ForceTrace:
    """Return the force trace of a recording: in SI, derived channels computed, clock mended, counts calibrated.

    `tared` finds the tare from time and counts, before they are turned into forces, once.
    """

    def refuse(message: str, code: str, key: str, fix: str) -> DataError:
        return DataError(message, code=code, path=raw.source, key=key, fix=fix)

    told: dict[str, Any] = {"name": raw.name, "source": raw.source}
    channels = _channels(raw, profile, refuse)
    clock_s = _time_s(raw, channels, profile, refuse)
    others = [values for name, values in channels.items() if name != "time"]
    keep, time_s, notes = mend_clock(clock_s, others, first_line=raw.first_line, **told)
    kept = {name: values[keep] for name, values in channels.items()}
    for cell, known in ((_PULL, calibration), (_SLACK, end_calibration)):
        if cell.counts in kept and cell.newtons not in kept and known is None:
            message = f"{raw.name} holds ADC counts, and there is no calibration to turn them into newtons"
            fix = f"name the {cell.column} in trials.csv and [adc] in campaign.toml"
            raise refuse(message, "RF210", cell.counts, fix)
    try:
        slack = _measured(_SLACK, kept, end_calibration)
        pull = _measured(_PULL, kept, calibration, partial(tared, time_s) if tared else None)
    except RopefricError as error:
        problem = error.problem
        raise refuse(problem.message, problem.code, problem.key or "counts", problem.fix) from None
    notes = (*raw.notes, *notes)
    return ForceTrace(time_s=time_s, end_tension_N=slack["force_N"], notes=notes, **told, **pull)


def _channels(raw: RawRecording, profile: ImportProfile, refuse: Refusal) -> Channels:
    """Return what was recorded and what a profile derives from it, in SI, a force or its counts among it."""
    channels = _to_si(raw, refuse)
    if profile.derived:
        channels = evaluate_derived(profile.derived, channels, profile.constants, path=raw.source)
    if not {_PULL.newtons, _PULL.counts} & set(channels):
        message = f"{raw.name} has no channel 'force' or 'counts', only {', '.join(channels) or 'none'}"
        fix = f"name its column or derive it; {did_you_mean('force', channels)}"
        raise refuse(message, "RF105", "[import.channels] force", fix)
    return channels


def _measured(
    cell: _Cell,
    channels: Channels,
    calibration: Calibration | None,
    tared: Callable[[IntArray, Calibration], Calibration] | None = None,
) -> dict[str, Any]:
    """Return the force of a cell, and where it comes from counts, these, their calibration and their saturation."""
    if cell.newtons in channels or cell.counts not in channels or calibration is None:
        return {"force_N": channels.get(cell.newtons)}
    counts = calibration.checked(channels[cell.counts])
    calibration = tared(counts, calibration) if tared else calibration
    force_N, saturation = calibration.apply(counts)
    return {"force_N": force_N, "counts": counts, "calibration": calibration, "saturation": saturation}


def _to_si(raw: RawRecording, refuse: Refusal) -> Channels:
    channels: Channels = {}
    for name, values in raw.columns.items():
        factor = si_factor(name, raw.units.get(name, ""), path=raw.source)
        channels[name] = values
        if factor != 1.0:
            with np.errstate(over="ignore"):
                channels[name] = values * factor
            if (large := np.isinf(channels[name])).any():
                message = f"sample {int(np.argmax(large)) + 1} is too large for a float in SI"
                raise refuse(message, "RF102", name, "mend the value, or check the unit")
    return channels


def _time_s(raw: RawRecording, channels: Channels, profile: ImportProfile, refuse: Refusal) -> FloatArray:
    if "time" in channels:
        return channels["time"]
    rate_Hz = profile.sampling_rate_Hz
    if rate_Hz is None or not np.isfinite(rate_Hz) or rate_Hz <= 0:
        fix = (
            'name the time column, time = { column = 1, unit = "s" }, or set [import] sampling_rate = "3 kHz"'
        )
        message = f"{raw.name} has no time channel and no usable sampling rate"
        raise refuse(message, "RF105", "[import.channels] time", fix)
    # Divided, not added up: sample i is at exactly i / rate.
    return np.arange(next(iter(channels.values())).size, dtype=np.float64) / rate_Hz


FUNCTIONS: dict[str, Any] = {
    name: getattr(np, name)
    for name in (
        "abs", "sign", "sqrt", "cbrt", "exp", "log", "log10", "sin", "cos", "tan", "arcsin", "arccos", "arctan",
        "arctan2", "sinh", "cosh", "tanh", "hypot", "radians", "degrees", "minimum", "maximum", "clip", "where",
        "cumsum", "gradient", "mean", "median", "min", "max",
    )
}  # fmt: skip
"""What a formula may call: numpy's functions of these names."""

_CONSTANTS = {"pi": math.pi}
_GRAMMAR = (
    ast.Expression, ast.BinOp, ast.UnaryOp, ast.Compare, ast.Call, ast.Name, ast.Load, ast.Constant,
    ast.operator, ast.unaryop, ast.cmpop,
)  # fmt: skip
_NO_BITS = (ast.LShift, ast.RShift, ast.BitOr, ast.BitXor, ast.MatMult, ast.In, ast.NotIn, ast.Is, ast.IsNot)
_MAX_LENGTH = 1000
_HINT = 'write arithmetic with channels in SI, such as force = "pull - pressure * area"'


def evaluate_derived(
    derived: Mapping[str, str],
    channels: Mapping[str, FloatArray],
    constants: Mapping[str, float],
    *,
    path: str = "",
) -> dict[str, FloatArray]:
    """Return the channels together with the derived ones, computed in the order written.

    A formula sees every channel, those derived before it, the constants, `pi` and `FUNCTIONS`, all in SI.
    It may take the name of a channel, which it then replaces.
    """
    known: dict[str, FloatArray] = dict(channels)
    clash = sorted(set(constants) & (set(channels) | set(derived)))
    if clash:
        why, key = f"{clash[0]!r} is a constant and a channel at once", "[import.constants]"
        raise DataError(why, code="RF109", path=path, key=key, fix="rename one of them")
    for name, formula in derived.items():
        try:
            known[name] = _evaluate(formula.strip(), known, constants)
        except _FormulaError as error:
            shown = formula if len(formula) <= 80 else formula[:77] + "..."
            why, key = f"{shown!r} {error.args[0]}", f"[import.derived] {name}"
            raise DataError(why, code="RF109", path=path, key=key, fix=error.args[1] or _HINT) from None
    return known


class _FormulaError(Exception):
    """What is wrong with a formula."""

    def __init__(self, why: str, fix: str = "") -> None:
        super().__init__(why, fix)


def _evaluate(formula: str, channels: Mapping[str, FloatArray], constants: Mapping[str, float]) -> FloatArray:
    symbols = {**FUNCTIONS, **_CONSTANTS, **constants, **channels}
    tree, used = _parse(formula, symbols.keys())
    try:
        with np.errstate(all="ignore"):  # what comes of it is judged below
            code = compile(tree, "<derived>", "eval")
            result = np.asarray(eval(code, {"__builtins__": {}}, symbols))  # noqa: S307  (arithmetic only, see _parse)
    except Exception as error:  # noqa: BLE001  (whatever a formula does wrong, the user hears of the formula)
        reason = str(error).strip().splitlines()
        raise _FormulaError(f"fails: {reason[0] if reason else type(error).__name__}") from None
    inputs = [channels[word] for word in channels if word in used]
    if result.dtype.kind not in "buif":
        raise _FormulaError(f"gives {result.dtype} values, not real numbers")
    if not inputs:
        raise _FormulaError("uses no channel")
    if result.shape != inputs[0].shape:
        raise _FormulaError(f"gives shape {result.shape}, but the channels have {inputs[0].shape}")
    result = result.astype(np.float64)
    unexplained = ~np.isfinite(result) & np.all([np.isfinite(channel) for channel in inputs], axis=0)
    unexplained |= np.isinf(result)
    if unexplained.any():
        index = int(np.argmax(unexplained))
        raise _FormulaError(f"gives {result[index]} at sample {index + 1}")
    return np.ascontiguousarray(result)


def _parse(formula: str, known: AbstractSet[str]) -> tuple[ast.Expression, set[str]]:
    """Return the formula's tree and the names it uses, after checking that it is arithmetic only."""
    if len(formula) > _MAX_LENGTH:
        raise _FormulaError(f"is longer than {_MAX_LENGTH} characters")
    try:
        tree = ast.parse(formula, mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError, Warning):
        raise _FormulaError("is not a formula") from None
    used: set[str] = set()
    for node in ast.walk(tree):
        if not isinstance(node, _GRAMMAR) or isinstance(node, _NO_BITS):
            raise _FormulaError(f"is more than arithmetic ({type(node).__name__})")
        if isinstance(node, ast.Constant):
            node.value = _to_float(node.value)
        elif isinstance(node, ast.Call):
            called = node.func.id if isinstance(node.func, ast.Name) else ast.unparse(node.func)
            if called not in FUNCTIONS:
                raise _FormulaError(
                    f"calls {called!r}, which is not offered", did_you_mean(called, FUNCTIONS)
                )
        elif isinstance(node, ast.Name):
            if node.id not in known:
                hint = did_you_mean(node.id, known - FUNCTIONS.keys())
                raise _FormulaError(f"uses the unknown name {node.id!r}", hint)
            used.add(node.id)
    return tree, used


def _to_float(literal: object) -> float:
    """Return a literal as a float: 9**9**9 in integers would never end."""
    if isinstance(literal, bool) or not isinstance(literal, int | float):
        raise _FormulaError(f"holds {literal!r}, which is no number")
    try:
        return float(literal)
    except OverflowError:
        raise _FormulaError("holds a number too large for a float") from None
