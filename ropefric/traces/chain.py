"""The measuring chain as its data sheets describe it: force cell, transmitter, converter."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, fields
from itertools import pairwise
from numbers import Integral, Real
from typing import Any, NamedTuple

from ropefric.errors import InputError

_LARGEST_FRACTION = 0.1  # no force cell is sold with 10 % of error: such a number is a percentage by mistake
_OVERLOAD = 1.2  # usual safe overload of a force cell; a calibration point beyond it is a slip of the unit


def require_floats(owner: Any, what: str) -> None:
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
            raise InputError(
                f"{what}: {item.name} = {value!r} is not a finite number", code="RF210", key=item.name
            )
        object.__setattr__(owner, item.name, float(value))


class Line(NamedTuple):
    """A straight line force = `gain_N_V` · (voltage − `zero_V`) and how well it is known."""

    gain_N_V: float
    zero_V: float
    scatter_N: float
    dof: float
    n: int
    mean_N: float
    spread_N2: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Adc:
    """A unipolar or offset analogue-to-digital converter.

    Count 0 stands for `low_V` and the largest count, 2^bits − 1, for `high_V`; one count is therefore
    (high − low)/(2^bits − 1), 1 kN/1023 = 0.978 N for a 10-bit converter behind a 1 kN cell.
    """

    bits: int = 10
    low_V: float = 0.0
    high_V: float = 5.0

    def __post_init__(self) -> None:
        bits: Any = self.bits
        if isinstance(bits, bool) or not isinstance(bits, Integral) or not 1 <= int(bits) <= 32:
            raise InputError(
                f"ADC: bits = {bits!r} is not a whole number from 1 to 32",
                code="RF210",
                key="bits",
                fix="write the resolution on its data sheet, for example bits = 10",
            )
        object.__setattr__(self, "bits", int(bits))
        require_floats(self, "ADC")
        if not self.low_V < self.high_V:
            raise InputError(
                f"ADC: the range from {self.low_V:g} V to {self.high_V:g} V is empty",
                code="RF210",
                key="high_V",
                fix="make high_V larger than low_V",
            )

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
        for key in ("name", "serial", "calibrated"):
            text: Any = getattr(self, key)
            if not isinstance(text, str):
                raise InputError(f"{what}: {key} = {text!r} is not text", code="RF210", key=key)
        require_floats(self, what)
        if self.full_scale_N <= 0:
            raise InputError(
                f"{what}: full scale {self.full_scale_N:g} N is not positive",
                code="RF210",
                key="full_scale_N",
            )
        if self.full_scale_V <= self.zero_V:
            raise InputError(
                f"{what}: {self.full_scale_V:g} V at full scale is not above {self.zero_V:g} V at no load",
                code="RF210",
                key="full_scale_V",
                fix="swap the signal wires if the voltage falls with the force",
            )
        for key in ("linearity", "hysteresis", "repeatability", "transmitter"):
            value = getattr(self, key)
            if not 0 <= value < _LARGEST_FRACTION:
                raise InputError(
                    f"{what}: {key} = {value:g} is no fraction of full scale (below {_LARGEST_FRACTION:g})",
                    code="RF210",
                    key=key,
                    fix="write 0.0002 for 0.02 %FS",
                )
        object.__setattr__(self, "points", _checked_points(self.points, self.full_scale_N, what))
        try:
            usable = math.isfinite(self.line.gain_N_V)
        except (OverflowError, ZeroDivisionError):
            usable = False
        if not usable:
            raise InputError(f"{what}: its line from volts to newtons is too steep to compute", code="RF210")

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
        spread_N2 = math.fsum((force - mean_N) ** 2 for force, _ in self.points)
        slope_V_N = math.fsum((f - mean_N) * (v - mean_V) for f, v in self.points) / spread_N2
        squares_V2 = math.fsum((v - mean_V - slope_V_N * (f - mean_N)) ** 2 for f, v in self.points)
        # Two points lie on their line; what is left there is rounding, not scatter.
        scatter_V = math.sqrt(squares_V2 / (n - 2)) if n > 2 else 0.0
        zero_V = mean_V - slope_V_N * mean_N
        return Line(1.0 / slope_V_N, zero_V, scatter_V / slope_V_N, float(n - 2), n, mean_N, spread_N2)


def _checked_points(points: Any, full_scale_N: float, what: str) -> tuple[tuple[float, float], ...]:
    try:
        pairs = tuple((float(force_N), float(voltage_V)) for force_N, voltage_V in _as_iterable(points))
    except (TypeError, ValueError, OverflowError):
        raise InputError(
            f"{what}: calibration points are pairs of force and voltage, not {points!r}",
            code="RF210",
            key="points",
            fix="write [[0, 0.01], [500, 2.51], [1000, 5.0]], in N and V",
        ) from None
    if len(pairs) == 1:
        raise InputError(
            f"{what}: one calibration point makes no line",
            code="RF210",
            key="points",
            fix="give two or more points, or none to use the nominal line",
        )
    for number, (force_N, voltage_V) in enumerate(pairs, start=1):
        if not (math.isfinite(force_N) and math.isfinite(voltage_V)):
            raise InputError(f"{what}: calibration point {number} is not finite", code="RF210", key="points")
        if abs(force_N) > _OVERLOAD * full_scale_N:
            raise InputError(
                f"{what}: calibration point {number}, {force_N:g} N, is far beyond full scale",
                code="RF210",
                key="points",
                fix="points are written force first, in newtons, then volts",
            )
    for number, ((f_0, v_0), (f_1, v_1)) in enumerate(pairwise(pairs), start=1):
        if not (f_0 < f_1 and v_0 < v_1):
            raise InputError(
                f"{what}: calibration points {number} and {number + 1}, {f_0:g} N {v_0:g} V and {f_1:g} N "
                f"{v_1:g} V, do not increase",
                code="RF210",
                key="points",
                fix="sort by force; average repeated loadings; swap the signal wires if the voltage falls",
            )
    return pairs


def _as_iterable(points: Any) -> Iterable[Any]:
    if isinstance(points, str):
        raise TypeError
    return tuple(points)
