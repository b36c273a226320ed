"""A free span of blade, put together from parts, each of which may be left out.

Sums and products that keep what rounding drops, for differences of nearly equal numbers.

A pair (high, low) stands for high + low with about 32 digits. Knuth's sum, Dekker's product; finite numbers whose
products neither overflow nor fall below 1e-290.
"""

from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.bandsaw.ends import Ends
from ropefric.systems.checks import refuse_out_of_scale as refuse_beyond_reach

Pair = tuple[FloatArray, FloatArray]
"""An unevaluated sum of a float and what it lacks."""

_SPLITTER = 134217729.0  # 2^27 + 1


def as_pair(value: npt.ArrayLike) -> Pair:
    """Return a float as a pair."""
    high = np.asarray(value, dtype=np.float64)
    return high, np.zeros_like(high)


def add(a: Pair, b: Pair) -> Pair:
    """Return a + b."""
    high, low = _two_sum(a[0], b[0])
    low_high, low_low = _two_sum(a[1], b[1])
    high, low = _quick_two_sum(high, low + low_high)
    return _quick_two_sum(high, low + low_low)


def multiply(a: Pair, b: Pair) -> Pair:
    """Return a b."""
    high, low = _two_product(a[0], b[0])
    return _quick_two_sum(high, low + (a[0] * b[1] + a[1] * b[0]))


def divide(a: Pair, b: Pair) -> Pair:
    """Return a / b for b ≠ 0."""
    first = a[0] / b[0]
    left = add(a, multiply(as_pair(-first), b))
    second = left[0] / b[0]
    left = add(left, multiply(as_pair(-second), b))
    high, low = _quick_two_sum(first, second)
    return _quick_two_sum(high, low + left[0] / b[0])


def negative(a: Pair) -> Pair:
    """Return −a."""
    return np.negative(a[0]), np.negative(a[1])


def total(a: Pair) -> FloatArray:
    """Return a pair as one float."""
    return np.asarray(a[0] + a[1])


def _two_sum(a: FloatArray, b: FloatArray) -> Pair:
    high = np.asarray(a + b)
    part = high - a
    return high, np.asarray((a - (high - part)) + (b - part))


def _quick_two_sum(a: FloatArray, b: FloatArray) -> Pair:
    high = np.asarray(a + b)
    return high, np.asarray(b - (high - a))


def _two_product(a: FloatArray, b: FloatArray) -> Pair:
    high = np.asarray(a * b)
    a_high, a_low = _split(a)
    b_high, b_low = _split(b)
    return high, np.asarray(((a_high * b_high - high) + a_high * b_low + a_low * b_high) + a_low * b_low)


def _split(a: FloatArray) -> Pair:
    scaled = _SPLITTER * a
    high = np.asarray(scaled - (scaled - a))
    return high, np.asarray(a - high)


_POSITIVE = {"free_span_m", "linear_density_kg_m"}
_ZERO_OR_MORE = {"bending_stiffness_N_m2", "mounting_factor"}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Span:
    """A span of blade between two wheels, m cases side by side; scalars are spread.

    The tension is F = F_0 ± ΔF/2 + κ ρA v_w². Every part but the first is zero unless it is given, so that a model
    has in it what was put there: the torque's part, the wheels' part, the motion through the span and the
    stiffness are separate. In a saw v_w and v are the same speed.
    """

    free_span_m: FloatArray
    linear_density_kg_m: FloatArray
    preload_N: FloatArray
    pull_N: FloatArray = 0.0  # type: ignore[assignment]  # spread in __post_init__
    mounting_factor: FloatArray = 0.0  # type: ignore[assignment]
    wheel_speed_m_s: FloatArray = 0.0  # type: ignore[assignment]
    travel_speed_m_s: FloatArray = 0.0  # type: ignore[assignment]
    bending_stiffness_N_m2: FloatArray = 0.0  # type: ignore[assignment]

    def __post_init__(self) -> None:
        arrays = {
            field.name: np.atleast_1d(np.array(getattr(self, field.name), dtype=np.float64))
            for field in fields(self)
        }
        try:
            shape = np.broadcast_shapes(*(array.shape for array in arrays.values()))
        except ValueError:
            lengths = ", ".join(
                f"{name} has {array.size}" for name, array in arrays.items() if array.size > 1
            )
            raise InputError(
                f"the cases disagree in length: {lengths}", fix="give one value each, or one for all"
            ) from None
        if len(shape) != 1:
            raise InputError(f"the parts have {len(shape)} axes; a span has one, its cases")
        for name, array in arrays.items():
            _check(name, array)
            refuse_beyond_reach(name, array, may_vanish=name not in _POSITIVE)
            spread = np.broadcast_to(array, shape)
            spread.flags.writeable = False
            object.__setattr__(self, name, spread)
        slack = self.tension_N <= 0.0
        if slack.any():
            first = int(np.argmax(slack))
            raise InputError(
                f"the tension is {self.tension_N[first]:.6g} N (preload {self.preload_N[first]:.6g} N, pull "
                f"{self.pull_N[first]:+.6g} N){self.place(first)}; it must be positive: a slack blade is no string",
                key="preload_N",
                fix=f"raise the preload above {self.preload_N[first] - self.tension_N[first]:.6g} N",
            )
        refuse_beyond_reach("tension_N", self.tension_N, may_vanish=False)

    @property
    def m(self) -> int:
        """Return how many cases there are."""
        return self.preload_N.size

    @property
    def tension_N(self) -> FloatArray:
        """Return F = F_0 ± ΔF/2 + κ ρA v_w² [N], shape (m,), to full relative precision."""
        wheels = multiply(as_pair(self.wheel_speed_m_s), as_pair(self.wheel_speed_m_s))
        density, held = as_pair(self.linear_density_kg_m), multiply(as_pair(self.mounting_factor), wheels)
        return total(add(self._static(), multiply(density, held)))

    @property
    def wave_speed_m_s(self) -> FloatArray:
        """Return c = √(F/ρA) [m/s], shape (m,), of waves as a traveller with the blade sees them."""
        return np.sqrt(self.tension_N / self.linear_density_kg_m)

    @property
    def net_tension_N(self) -> FloatArray:
        """Return F − ρA v² = ρA (c − v)(c + v) [N], shape (m,), to full relative precision."""
        return total(self._net())

    def margin_N(self, ends: Ends) -> FloatArray:
        """Return the net tension above the buckling load, F − ρA v² + β EI/l² [N], to full relative precision."""
        if not self.bending_stiffness_N_m2.any():
            return self.net_tension_N
        beta = (np.full(self.m, ends.buckling), np.full(self.m, ends.buckling_low))
        squared = multiply(as_pair(self.free_span_m), as_pair(self.free_span_m))
        load = divide(multiply(beta, as_pair(self.bending_stiffness_N_m2)), squared)
        return total(add(self._net(), load))

    def critical_speed_m_s(self, ends: Ends) -> FloatArray:
        """Return the speed at which the first frequency vanishes, shape (m,); infinite for κ = 1.

        v_c² (1 − κ) ρA = F_0 ± ΔF/2 + β EI/l². The mounting counts whether or not the wheels turn, because they
        would at that speed. Where the right side is not positive, only inertia tightens the blade and v_c is zero.
        """
        load_N = ends.buckling * self.bending_stiffness_N_m2 / self.free_span_m**2
        return speed_that_uses_up(self.preload_N + self.pull_N + load_N, self)

    def select(self, index: npt.ArrayLike) -> "Span":
        """Return the cases at an index array or boolean mask, in that order."""
        chosen = np.asarray(index)
        return Span(**{field.name: getattr(self, field.name)[chosen] for field in fields(self)})

    def place(self, index: int) -> str:
        """Return ` at case i` for messages, nothing where there is only one."""
        return f" at case {index}" if self.m > 1 else ""

    def _net(self) -> Pair:
        # κ v_w² − v² cancels for κ near 1, where (v_w² − v²) − (1 − κ) v_w² does not; F and ρA v² do as v nears c.
        wheel_speed, travel, mounting = (
            as_pair(value) for value in (self.wheel_speed_m_s, self.travel_speed_m_s, self.mounting_factor)
        )
        wheels, loose = multiply(wheel_speed, wheel_speed), add(as_pair(1.0), negative(mounting))
        ahead = multiply(add(wheel_speed, negative(travel)), add(wheel_speed, travel))
        by_loose = add(ahead, negative(multiply(loose, wheels)))
        by_mounting = add(multiply(mounting, wheels), negative(multiply(travel, travel)))
        near_one = self.mounting_factor >= 0.5
        through = (
            np.where(near_one, by_loose[0], by_mounting[0]),
            np.where(near_one, by_loose[1], by_mounting[1]),
        )
        return add(self._static(), multiply(as_pair(self.linear_density_kg_m), through))

    def _static(self) -> Pair:
        return add(as_pair(self.preload_N), as_pair(self.pull_N))


def speed_that_uses_up(force_N: FloatArray, span: Span) -> FloatArray:
    """Return the speed whose ρA v² takes up a force and the wheels' inertia, √(force/((1 − κ) ρA)) [m/s]."""
    held = np.broadcast_to(span.linear_density_kg_m * (1.0 - span.mounting_factor), force_N.shape)
    some = force_N > 0.0
    limited = np.divide(force_N, held, out=np.full(force_N.shape, np.inf), where=some & (held > 0.0))
    return np.where(some, np.sqrt(limited), 0.0)


def refuse_overspeed(span: Span, ends: Ends) -> FloatArray:
    """Return `Span.margin_N` where all of it is positive; refuse otherwise, naming the critical speed."""
    margin = span.margin_N(ends)
    beyond = margin <= 0.0
    if beyond.any():
        first = int(np.argmax(beyond))
        raise InputError(
            f"the blade travels at {span.travel_speed_m_s[first]:.9g} m/s and its critical speed is "
            f"{_tension_limit_m_s(span, ends)[first]:.9g} m/s{span.place(first)}: there its first frequency is zero "
            "and the theory ends",
            code="RF530",
            key="travel_speed_m_s",
            fix="run slower, or raise the preload",
        )
    return margin


def _tension_limit_m_s(span: Span, ends: Ends) -> FloatArray:
    """Return the critical speed at the tension there is: the one that was passed if v_w is not v."""
    same = span.wheel_speed_m_s == np.abs(span.travel_speed_m_s)
    load_N = ends.buckling * span.bending_stiffness_N_m2 / span.free_span_m**2
    held = np.sqrt((span.tension_N + load_N) / span.linear_density_kg_m)
    return np.where(same, span.critical_speed_m_s(ends), held)


def _check(name: str, array: FloatArray) -> None:
    fine = np.isfinite(array)
    rule = "finite"
    if name in _POSITIVE:
        fine, rule = fine & (array > 0.0), "finite and positive"
    elif name in _ZERO_OR_MORE:
        fine, rule = fine & (array >= 0.0), "finite and zero or more"
    if name == "mounting_factor":
        fine, rule = fine & (array <= 1.0), "from 0 (fixed wheel axles) to 1 (constant-force mounting)"
    if not fine.all():
        first = int(np.argmin(fine))
        place = f" at case {first}" if array.size > 1 else ""
        raise InputError(
            f"{name} is {array[first]:g}{place}; it must be {rule}", key=name, fix="correct this value"
        )
