"""The measuring chain, counts -> volts -> newtons: force cell, converter, tare, limits, and what it leaves uncertain.

Limits of error count as flat distributions (JCGM 100, 4.3.7), and all are of the force itself, so every sensitivity
is 1. The end tension F_B hangs from dead weights, not from this chain; `end_tension_std_N` serves it.
"""

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass, field, fields, replace
from itertools import pairwise
from numbers import Integral, Real
from typing import Any, NamedTuple

import numpy as np

from ropefric.arrays import FloatArray, IntArray
from ropefric.errors import DataError, InputError, Problem
from ropefric.traces.noise import MAX_SPIKE_SAMPLES, noise_std, remove_spikes, resolution, runs_of
from ropefric.uncertainty.budget import Quantity, limit_of_error

SCHEMA = "ropefric.calibration/1"

MIN_TARE_SAMPLES, MIN_TARE_READINGS = 10, 3
"""Samples that a tare needs: of counts, and of a signal, which may be that of a slow sensor."""
_BLOCKS = 8
_RESTLESS = 4.0  # block means of white noise spread by 1 of this unit; 4 is out of reach of chance
_CLIPPED_SHARE = 0.02  # fewer samples at the floor are spikes or the tail of the noise
_DITHERED = 0.5  # in counts: noise this strong leaves less than 0.01 count of quantisation in a mean

_LARGEST_FRACTION = 0.1  # no force cell is sold with 10 % of error: such a number is a percentage by mistake
OVERLOAD = 1.2  # usual safe overload of a force cell; a calibration point beyond it is a slip of the unit


def _refused(message: str, key: str, fix: str = "") -> InputError:
    return InputError(message, code="RF210", key=key, fix=fix)


def _require_floats(owner: Any, what: str) -> None:
    """Turn every float field of a dataclass into a float, so that equal objects are equal in JSON too."""
    for item in fields(owner):
        if item.type is not float:
            continue
        value = getattr(owner, item.name)
        try:
            usable = not isinstance(value, bool) and isinstance(value, Real) and math.isfinite(value)
        except OverflowError:  # a whole number beyond every float
            usable = False
        if not usable:
            raise _refused(f"{what}: {item.name} = {value!r} is not a finite number", item.name)
        object.__setattr__(owner, item.name, float(value))


class Line(NamedTuple):
    """A straight line force = `gain_N_V` · (voltage − `zero_V`) and how well it is known."""

    gain_N_V: float
    zero_V: float
    scatter_N: float
    dof: float
    n: int
    mean_N: float
    squares_N2: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Adc:
    """A unipolar or offset analogue-to-digital converter.

    Count 0 is `low_V` and the largest count, 2^bits − 1, is `high_V`; one count is therefore
    (high − low)/(2^bits − 1), 1 kN/1023 = 0.978 N for a 10-bit converter behind a 1 kN cell.
    """

    bits: int = 10
    low_V: float = 0.0
    high_V: float = 5.0

    def __post_init__(self) -> None:
        bits: Any = self.bits
        if isinstance(bits, bool) or not isinstance(bits, Integral) or not 1 <= int(bits) <= 32:
            fix = "write the resolution on its data sheet, for example bits = 10"
            raise _refused(f"ADC: bits = {bits!r} is not a whole number from 1 to 32", "bits", fix)
        object.__setattr__(self, "bits", int(bits))
        _require_floats(self, "ADC")
        if not self.low_V < self.high_V:
            message = f"ADC: the range from {self.low_V:g} V to {self.high_V:g} V is empty"
            raise _refused(message, "high_V", "make high_V larger than low_V")

    @property
    def max_count(self) -> int:
        """Return the count at the ceiling, 2^bits − 1."""
        return int(2**self.bits - 1)

    @property
    def lsb_V(self) -> float:
        """Return the voltage of one count [V]."""
        return (self.high_V - self.low_V) / self.max_count


ASSUMED_LIMITS = {"linearity": 0.0002, "hysteresis": 0.0002, "repeatability": 0.0002, "transmitter": 0.001}
"""Limits of error of a cell and its transmitter where none is stated: those of common ones, of full scale."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceCell:
    """A force cell and its transmitter."""

    name: str
    full_scale_N: float
    zero_V: float = 0.0
    full_scale_V: float = 5.0
    rated_output: float = 0.0
    linearity: float = None  # type: ignore[assignment]  # (these four: not given, so assumed)
    hysteresis: float = None  # type: ignore[assignment]
    repeatability: float = None  # type: ignore[assignment]
    transmitter: float = None  # type: ignore[assignment]
    points: tuple[tuple[float, float], ...] = ()
    serial: str = ""
    calibrated: str = ""
    assumed: tuple[str, ...] = field(default=(), compare=False)

    def __post_init__(self) -> None:
        what = f"force cell {self.name!r}"
        missing = [key for key in ASSUMED_LIMITS if getattr(self, key) is None]
        for key in missing:
            object.__setattr__(self, key, ASSUMED_LIMITS[key])
        object.__setattr__(self, "assumed", tuple(dict.fromkeys((*self.assumed, *missing))))
        _require_floats(self, what)
        if self.full_scale_N <= 0:
            raise _refused(f"{what}: full scale {self.full_scale_N:g} N is not positive", "full_scale_N")
        if self.full_scale_V <= self.zero_V:
            fix = "swap the signal wires if the voltage falls with the force"
            message = f"{self.full_scale_V:g} V at full scale is not above {self.zero_V:g} V at no load"
            raise _refused(f"{what}: {message}", "full_scale_V", fix)
        if self.rated_output and self.points:
            fix = "give the points for signals in volts, the rated output for those in mV/V"
            raise _refused(f"{what}: rated output and calibration points are both given", "points", fix)
        for key in ASSUMED_LIMITS:
            value = getattr(self, key)
            if not 0 <= value < _LARGEST_FRACTION:
                message = f"{key} = {value:g} is no fraction of full scale (below {_LARGEST_FRACTION:g})"
                raise _refused(f"{what}: {message}", key, "write 0.0002 for 0.02 %FS")
        object.__setattr__(self, "points", _checked_points(self.points, self.full_scale_N, what))
        gain_N_V = math.inf
        with suppress(OverflowError, ZeroDivisionError):
            gain_N_V = self.line.gain_N_V
        if not math.isfinite(gain_N_V):
            raise _refused(f"{what}: its line from volts to newtons is too steep to compute", "")

    @property
    def line(self) -> Line:
        """Return the line from volts to newtons: nominal, or least squares through the calibration points.

        The applied forces are dead weights and far better known than the voltages read at them, so voltage
        is regressed on force and the line then inverted.
        """
        if not self.points:
            gain_N_V = self.full_scale_N / (self.full_scale_V - self.zero_V)
            return Line(gain_N_V, self.zero_V, 0.0, math.inf, 0, 0.0, 0.0)
        n = len(self.points)
        mean_N = math.fsum(force for force, _ in self.points) / n
        mean_V = math.fsum(voltage for _, voltage in self.points) / n
        squares_N2 = math.fsum((force - mean_N) ** 2 for force, _ in self.points)
        slope_V_N = math.fsum((f - mean_N) * (v - mean_V) for f, v in self.points) / squares_N2
        squares_V2 = math.fsum((v - mean_V - slope_V_N * (f - mean_N)) ** 2 for f, v in self.points)
        # Two points lie on their line; what is left there is rounding, not scatter.
        scatter_V = math.sqrt(squares_V2 / (n - 2)) if n > 2 else 0.0
        zero_V = mean_V - slope_V_N * mean_N
        return Line(1.0 / slope_V_N, zero_V, scatter_V / slope_V_N, float(n - 2), n, mean_N, squares_N2)


def _checked_points(points: Any, full_scale_N: float, what: str) -> tuple[tuple[float, float], ...]:
    def refused(why: str, fix: str = "") -> InputError:
        return _refused(f"{what}: {why}", "points", fix)

    pairs: tuple[tuple[float, float], ...] | None = None
    with suppress(TypeError, ValueError, OverflowError):
        if not isinstance(points, str):
            pairs = tuple((float(force_N), float(voltage_V)) for force_N, voltage_V in points)
    if pairs is None:
        why = f"calibration points are pairs of force and voltage, not {points!r}"
        raise refused(why, "write [[0, 0.01], [500, 2.51], [1000, 5.0]], in N and V")
    if len(pairs) == 1:
        fix = "give two or more points, or none to use the nominal line"
        raise refused("one calibration point makes no line", fix)
    for number, (force_N, voltage_V) in enumerate(pairs, start=1):
        if not (math.isfinite(force_N) and math.isfinite(voltage_V)):
            raise refused(f"calibration point {number} is not finite")
        if abs(force_N) > OVERLOAD * full_scale_N:
            why = f"calibration point {number}, {force_N:g} N, is far beyond full scale"
            raise refused(why, "points are written force first, in newtons, then volts")
    for number, ((f_0, v_0), (f_1, v_1)) in enumerate(pairwise(pairs), start=1):
        if not (f_0 < f_1 and v_0 < v_1):
            which = f"{number} and {number + 1}, {f_0:g} N {v_0:g} V and {f_1:g} N {v_1:g} V"
            fix = "sort by force; average repeated loadings; swap the signal wires if the voltage falls"
            raise refused(f"calibration points {which}, do not increase", fix)
    return pairs


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Saturation:
    """Where a recording sat at the converter's ceiling and floor.

    At the ceiling the force is at least that high and unknown. At the floor it need not be a fault: an
    unloaded cell with 0 V at zero reads count 0.
    """

    high_runs: IntArray
    low_runs: IntArray

    @property
    def n_high(self) -> int:
        """Return the number of samples at the ceiling."""
        return int(np.diff(self.high_runs).sum())


def as_counts(values: Any) -> IntArray:
    """Return raw counts as integers, with −1 where a float is NaN."""
    array = np.asarray(values)
    if array.ndim != 1 or (array.size and array.dtype.kind not in "iuf"):
        raise InputError(
            f"raw counts are a row of whole numbers, not {array.dtype} of shape {array.shape}", code="RF211"
        )
    if array.dtype == np.uint64:
        array = np.minimum(array, np.uint64(2**62))  # larger ones would turn negative, which means missing
    if array.dtype.kind != "f":
        return array.astype(np.int64, copy=False)
    missing = np.isnan(array)
    filled = np.where(missing, 0.0, array)
    wrong = (filled < 0) | (filled > 2.0**32) | (filled != np.floor(filled))
    if wrong.any():
        index = int(np.argmax(wrong))
        why = f"sample {index} (the first is 0) is {array[index]:g}; a raw count is a whole number from 0"
        fix = "name the column of raw counts, or import this one as force or voltage with its unit"
        raise DataError(why, code="RF211", key="counts", fix=fix)
    filled[missing] = -1.0
    return filled.astype(np.int64)


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibration:
    """How counts, or without a converter volts, become newtons: converter, cell and tare."""

    cell: ForceCell
    adc: Adc | None = field(default_factory=Adc)
    tare_N: float = 0.0
    tare_std_N: float = 0.0

    def __post_init__(self) -> None:
        _require_floats(self, "calibration")
        if self.tare_std_N < 0:
            raise _refused(f"calibration: tare_std_N = {self.tare_std_N:g} is negative", "tare_std_N")

    @property
    def lsb_N(self) -> float:
        """Return the force of one count [N], 0 without a converter."""
        return self.adc.lsb_V * self.cell.line.gain_N_V if self.adc else 0.0

    def checked(self, values: Any) -> IntArray:
        """Return raw counts as integers, -1 where one is missing, after making sure that the converter can give them."""
        assert self.adc is not None  # noqa: S101  (volts are no counts)
        counts = as_counts(values)
        top, most = int(counts.max(initial=0)), self.adc.max_count
        if top > most:
            index = int(np.argmax(counts > most))
            why = (
                f"sample {index} (the first is 0) has count {counts[index]}, above the {most} of a "
                f"{self.adc.bits}-bit converter; the largest count is {top}"
            )
            fix = f"set bits = {top.bit_length()} or more, or check which column holds the counts"
            raise DataError(why, code="RF211", key="bits", fix=fix)
        return counts

    def apply(self, values: Any) -> tuple[FloatArray, Saturation]:
        """Return the forces of raw counts or volts, and where the converter sat at its limits."""
        line = self.cell.line
        if self.adc is None:
            nowhere = np.empty((0, 2), dtype=np.int64)
            force_N = np.asarray(values, dtype=np.float64) - line.zero_V
            force_N *= line.gain_N_V
            force_N -= self.tare_N
            return force_N, Saturation(high_runs=nowhere, low_runs=nowhere)
        counts = self.checked(values)
        gain_N = self.adc.lsb_V * line.gain_N_V
        offset_N = (self.adc.low_V - line.zero_V) * line.gain_N_V - self.tare_N
        force_N = np.asarray(counts * gain_N, dtype=np.float64)
        force_N += offset_N
        missing = counts < 0
        if missing.any():
            force_N[missing] = np.nan
        at_top = counts == self.adc.max_count
        return force_N, Saturation(high_runs=runs_of(at_top), low_runs=runs_of(counts == 0))

    def with_tare(self, counts: Any) -> tuple["Calibration", tuple[Problem, ...]]:
        """Return this calibration with the tare that makes the mean force of an idle stretch zero, and its doubts.

        The uncertainty comes from the scatter of the means of 8 blocks as well as from that of single samples,
        and the larger counts: hum and drift, whose samples are not independent, are not averaged away on paper.
        Isolated spikes are left out.
        """
        force_N, saturation = replace(self, tare_N=0.0).apply(counts)
        present_N = force_N[np.isfinite(force_N)]
        fewest = MIN_TARE_SAMPLES if self.adc else MIN_TARE_READINGS
        if present_N.size >= MIN_TARE_SAMPLES:
            # A spike of two samples at full scale moves the mean of a quarter second by more than a count.
            present_N = np.delete(present_N, remove_spikes(present_N, noise_std(present_N)).bad)
        if present_N.size < fewest or 2 * present_N.size < force_N.size:
            usable = f"{present_N.size} usable of {force_N.size} samples"
            message = f"the tare interval holds {usable}; at least {fewest} and half of them are needed"
            raise DataError(message, code="RF212", key="tare", fix="name a longer idle interval")
        if np.diff(saturation.high_runs).max(initial=0) > MAX_SPIKE_SAMPLES:
            n, fix = saturation.n_high, "name an interval in which the rope hangs free"
            message = f"{n} samples of the tare interval are at the ADC ceiling: the rig is not idle"
            raise DataError(message, code="RF212", key="tare", fix=fix)
        sample_std_N = float(present_N.std(ddof=1))
        lsb_N = self.lsb_N or resolution(present_N)
        n_blocks = max(min(_BLOCKS, present_N.size // 4), 1)
        means_N = [block.mean() for block in np.array_split(present_N, n_blocks)]
        block_std_N = float(np.std(means_N, ddof=1)) if n_blocks > 1 else 0.0
        slow_std_N = block_std_N / math.sqrt(n_blocks)
        quantisation_N = 0.0 if sample_std_N >= _DITHERED * lsb_N else lsb_N / math.sqrt(12.0)
        std_N = math.hypot(max(sample_std_N / math.sqrt(present_N.size), slow_std_N), quantisation_N)
        tared = replace(self, tare_N=float(present_N.mean()), tare_std_N=std_N)
        doubts = _doubts_of_tare(present_N, saturation, n_blocks, block_std_N, lsb_N)
        return tared, tuple(
            Problem(code="RF212", message=message, key="tare", fix=fix, severity="warning")
            for message, fix in doubts
        )

    def to_dict(self) -> dict[str, Any]:
        """Return everything as JSON-able values, under schema `ropefric.calibration/1`."""
        cell = asdict(self.cell)
        cell |= {"points": [list(point) for point in self.cell.points], "assumed": list(self.cell.assumed)}
        return {
            "schema": SCHEMA,
            "adc": asdict(self.adc) if self.adc else None,
            "cell": cell,
            "tare_N": self.tare_N,
            "tare_std_N": self.tare_std_N,
        }


IN_NEWTONS = Calibration(cell=ForceCell(name="", full_scale_N=1.0, full_scale_V=1.0), adc=None)
"""Of a signal that is in its own unit already: the tare of every signal is found in the same way."""


def tare_from_interval(
    time_s: FloatArray, counts: Any, calibration: Calibration, start_s: float, end_s: float
) -> tuple[Calibration, tuple[Problem, ...]]:
    """Return the calibration with the tare of an idle interval, and its warnings."""
    if not start_s < end_s:
        message = f"the tare interval from {start_s:g} s to {end_s:g} s is empty"
        raise InputError(message, code="RF212", key="tare", fix="write its start before its end")
    slack_s = 0.1 * (end_s - start_s)
    if start_s < time_s[0] - slack_s or end_s > time_s[-1] + slack_s:
        covered = f"{time_s[0]:g} s to {time_s[-1]:g} s"
        message = f"the tare interval from {start_s:g} s to {end_s:g} s is not in the recording, {covered}"
        raise DataError(message, code="RF212", key="tare", fix="name an interval inside the recording")
    first, stop = np.searchsorted(time_s, start_s, side="left"), np.searchsorted(time_s, end_s, side="right")
    return calibration.with_tare(counts[first:stop])


def _doubts_of_tare(
    present_N: FloatArray, saturation: Saturation, n_blocks: int, block_std_N: float, lsb_N: float
) -> Iterator[tuple[str, str]]:
    """Yield the warnings about an idle interval, with their fixes."""
    # Differences of neighbours hold the noise and next to nothing of a drift.
    noise_N = float(np.sqrt(np.mean(np.diff(present_N) ** 2) / 2.0))
    if block_std_N > max(lsb_N, _RESTLESS * noise_N / math.sqrt(present_N.size / n_blocks)):
        message = (
            f"the force is not constant in the tare interval: the means of its {n_blocks} parts "
            f"spread by {block_std_N:.3g} N, against {noise_N:.3g} N of noise of one sample"
        )
        yield message, "name an interval that ends before the motor starts"
    share = int(np.diff(saturation.low_runs).sum()) / present_N.size
    if share >= _CLIPPED_SHARE:
        message = (
            f"{100 * share:.0f} % of the tare interval is at the ADC floor: a zero below it cannot "
            f"be seen, and the tare of {float(present_N.mean()):.3g} N may be too high"
        )
        yield message, "set the transmitter's zero a few counts above the floor"


_LIMITS = {
    "linearity": ("linearity", "δ_lin"),
    "hysteresis": ("hysteresis", "δ_hys"),
    "repeatability": ("cell's repeatability", "δ_rep"),
    "transmitter": ("transmitter", "δ_tr"),
}


def chain_quantities(force_N: float, calibration: Calibration) -> tuple[Quantity, ...]:
    """Return what a chain leaves uncertain of one of its forces, corrections of zero that are not made.

    Linearity, hysteresis, repeatability, transmitter: limits as fractions of full scale. Calibration line: the scatter
    of three or more calibration points about it, n − 2 degrees of freedom; two points give none.
    """
    cell, line = calibration.cell, calibration.cell.line
    found = []
    for key, (name, symbol) in _LIMITS.items():
        assumed = f"cells.{cell.name}.{key}" if key in cell.assumed else ""
        limit_N = getattr(cell, key) * cell.full_scale_N
        found.append(limit_of_error(name, symbol, "N", limit_N, assumed=assumed))
    # Half a count, u = LSB/√12. Averaging reduces it only where noise dithers the converter, and a peak is
    # no place to rely on that: it stays whole.
    if calibration.adc:
        step_N, width = calibration.lsb_N, math.sqrt(12.0)
        found.append(Quantity("resolution", "δ_q", "N", step_N, divisor=width, distribution="rectangular"))
    if line.n:
        # The line saw the rope rig's untared reading, not the force after the tare.
        distance_N = force_N + calibration.tare_N - line.mean_N
        std_N = line.scatter_N * math.sqrt(1.0 + 1.0 / line.n + distance_N**2 / line.squares_N2)
        dof = line.dof if line.n > 2 else math.inf
        found.append(Quantity("calibration line", "δ_cal", "N", std_N, type="A", dof=dof))
    return tuple(found)


def cell_std_N(force_N: float, calibration: Calibration | None) -> float:
    """Return the part [N] of a force's standard uncertainty that all forces of its cell share; NaN without a chain.

    Linearity, hysteresis, transmitter and calibration line: what neither repeats nor other conditions average out.
    """
    if calibration is None:
        return math.nan
    own = ("cell's repeatability", "resolution")
    return math.hypot(*(item.std for item in chain_quantities(force_N, calibration) if item.name not in own))


def force_std_N(force_N: float, calibration: Calibration | None, *, picking_std_N: float = 0.0) -> float:
    """Return the standard uncertainty [N] of one force: its chain, its tare and the picking of its peak."""
    if calibration is None:
        return picking_std_N
    chain = (quantity.std for quantity in chain_quantities(force_N, calibration))
    return math.hypot(*chain, calibration.tare_std_N, picking_std_N)


def end_tension_std_N(end_tension_N: float, tolerance: float) -> float:
    """Return the standard uncertainty [N] of an end tension made by dead weights, F_B·tolerance/√3."""
    return limit_of_error("end tension", "F_B", "N", end_tension_N * tolerance).std
