"""A free span of blade, put together from parts, each of which may be left out, and its frequencies as a string.

The ends are held in one of several ways; what a beam may do there and at which compression it buckles is said once.

Differences of nearly equal numbers are taken in pairs: (high, low) stands for high + low with about 32 digits. Knuth's
sum, Dekker's product; finite numbers whose products neither overflow nor fall below 1e-290.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.registry import Registry
from ropefric.systems.checks import Rule, checked, refuse_out_of_scale, side_by_side


@dataclass(frozen=True, slots=True, kw_only=True)
class Ends:
    """A way of holding both ends of a span of length 1."""

    name: str
    meaning: str
    turns: bool
    buckling: float
    buckling_low: float
    buckled: Callable[[FloatArray], tuple[FloatArray, FloatArray, FloatArray]] = field(repr=False)


_PI_SQUARED = (9.869604401089358, 6.265295508739711e-16)


def _sine(x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    pi = math.pi
    return np.sin(pi * x), pi * np.cos(pi * x), -(pi**2) * np.sin(pi * x)


def _raised_cosine(x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    q = 2.0 * math.pi
    return 1.0 - np.cos(q * x), q * np.sin(q * x), q**2 * np.cos(q * x)


PINNED = Ends(
    name="pinned",
    meaning="held in place and free to turn",
    turns=True,
    buckling=_PI_SQUARED[0],
    buckling_low=_PI_SQUARED[1],
    buckled=_sine,
)
CLAMPED = Ends(
    name="clamped",
    meaning="held in place and in direction, as a blade that runs off a wheel or a guide",
    turns=False,
    buckling=4.0 * _PI_SQUARED[0],
    buckling_low=4.0 * _PI_SQUARED[1],
    buckled=_raised_cosine,
)
ENDS: Registry[Ends] = Registry("way of holding the ends", (PINNED, CLAMPED))
"""Every way of holding the ends by name."""

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


_RULES: dict[str, Rule] = {
    "free_span_m": "positive",
    "linear_density_kg_m": "positive",
    "preload_N": "any",
    "pull_N": "any",
    "mounting_factor": "any",
    "wheel_speed_m_s": "any",
    "travel_speed_m_s": "any",
    "bending_stiffness_N_m2": "zero or more",
}


def refuse_mounting(factor: npt.ArrayLike) -> None:
    """Refuse a mounting factor that is not from 0 to 1: above, the wheels would add more than the inertia tension."""
    factors = np.atleast_1d(np.asarray(factor, dtype=np.float64))
    wrong = ~((factors >= 0.0) & (factors <= 1.0))
    if wrong.any():
        raise InputError(
            f"mounting_factor is {factors[wrong][0]:g}; it must be from 0 (fixed wheel axles) to 1 (constant-force "
            "mounting)",
            key="mounting_factor",
            fix="give 0 for fixed wheel axles, 1 for a constant-force mounting, or a number between",
        )


@dataclass(frozen=True, kw_only=True, eq=False)  # no slots: the tensions are kept
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
        refuse_mounting(self.mounting_factor)
        given = {field.name: getattr(self, field.name) for field in fields(self)}
        for name, array in side_by_side(given, _RULES).items():
            if array.ndim != 1:
                raise InputError(f"the parts have {array.ndim} axes; a span has one, its cases")
            refuse_out_of_scale(name, array, may_vanish=_RULES[name] != "positive")
            object.__setattr__(self, name, array)
        slack = self.tension_N <= 0.0
        if slack.any():
            first = int(np.argmax(slack))
            raise InputError(
                f"the tension is {self.tension_N[first]:.6g} N (preload {self.preload_N[first]:.6g} N, pull "
                f"{self.pull_N[first]:+.6g} N){self.place(first)}; it must be positive: a slack blade is no string",
                key="preload_N",
                fix=f"raise the preload above {self.preload_N[first] - self.tension_N[first]:.6g} N",
            )
        refuse_out_of_scale("tension_N", self.tension_N, may_vanish=False)

    @property
    def m(self) -> int:
        """Return how many cases there are."""
        return self.preload_N.size

    @cached_property
    def tension_N(self) -> FloatArray:
        """Return F = F_0 ± ΔF/2 + κ ρA v_w² [N], shape (m,), to full relative precision."""
        wheels = multiply(as_pair(self.wheel_speed_m_s), as_pair(self.wheel_speed_m_s))
        density, held = as_pair(self.linear_density_kg_m), multiply(as_pair(self.mounting_factor), wheels)
        return total(add(self._static, multiply(density, held)))

    @property
    def wave_speed_m_s(self) -> FloatArray:
        """Return c = √(F/ρA) [m/s], shape (m,), of waves as a traveller with the blade sees them."""
        return np.sqrt(self.tension_N / self.linear_density_kg_m)

    @cached_property
    def net_tension_N(self) -> FloatArray:
        """Return F − ρA v² = ρA (c − v)(c + v) [N], shape (m,), to full relative precision."""
        return total(self._net)

    def buckling_N(self, ends: Ends) -> FloatArray:
        """Return the load under which the span buckles, β EI/l² [N]."""
        return ends.buckling * self.bending_stiffness_N_m2 / self.free_span_m**2

    def margin_N(self, ends: Ends) -> FloatArray:
        """Return the net tension above the buckling load, F − ρA v² + β EI/l² [N], to full relative precision."""
        if not self.bending_stiffness_N_m2.any():
            return self.net_tension_N
        beta = (np.full(self.m, ends.buckling), np.full(self.m, ends.buckling_low))
        squared = multiply(as_pair(self.free_span_m), as_pair(self.free_span_m))
        load = divide(multiply(beta, as_pair(self.bending_stiffness_N_m2)), squared)
        return total(add(self._net, load))

    def critical_speed_m_s(self, ends: Ends) -> FloatArray:
        """Return the speed at which the first frequency vanishes, shape (m,); infinite for κ = 1.

        v_c² (1 − κ) ρA = F_0 ± ΔF/2 + β EI/l². The mounting counts whether or not the wheels turn, because they
        would at that speed. Where the right side is not positive, only inertia tightens the blade and v_c is zero.
        """
        force_N = self.preload_N + self.pull_N + self.buckling_N(ends)
        held = self.linear_density_kg_m * (1.0 - self.mounting_factor)
        some = force_N > 0.0
        limited = np.divide(force_N, held, out=np.full(self.m, np.inf), where=some & (held > 0.0))
        return np.where(some, np.sqrt(limited), 0.0)

    def select(self, index: npt.ArrayLike) -> "Span":
        """Return the cases at an index array or boolean mask, in that order."""
        chosen = np.asarray(index)
        return Span(**{field.name: getattr(self, field.name)[chosen] for field in fields(self)})

    def place(self, index: int) -> str:
        """Return ` at case i` for messages, nothing where there is only one."""
        return f" at case {index}" if self.m > 1 else ""

    @cached_property
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
        return add(self._static, multiply(as_pair(self.linear_density_kg_m), through))

    @cached_property
    def _static(self) -> Pair:
        return add(as_pair(self.preload_N), as_pair(self.pull_N))


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
    held = np.sqrt((span.tension_N + span.buckling_N(ends)) / span.linear_density_kg_m)
    return np.where(same, span.critical_speed_m_s(ends), held)


def frequency_Hz(
    mode: npt.ArrayLike,
    free_span_m: npt.ArrayLike,
    wave_speed_m_s: npt.ArrayLike,
    speed_m_s: npt.ArrayLike = 0.0,
) -> FloatArray:
    """Return f_n = n (c − v)(c + v)/(2 l c) [Hz], eq. (8); eq. (7) at rest."""
    n, length = checked("mode", mode), checked("free_span_m", free_span_m)
    c, v = checked("wave_speed_m_s", wave_speed_m_s), np.asarray(speed_m_s, dtype=np.float64)
    slow, c_too = np.broadcast_arrays(np.abs(v) < c, c)
    if not slow.all():
        limit = c_too.ravel()[int(np.argmin(slow.ravel()))]
        raise InputError(
            f"the speed is not below the critical speed c = {limit:.9g} m/s, where the frequency is zero",
            code="RF530",
            key="speed_m_s",
            fix="run slower, or raise the tension",
        )
    return np.asarray(n * ((c - v) * (c + v)) / (2.0 * length * c))


def frequency_at_shortfall_Hz(
    mode: npt.ArrayLike, free_span_m: npt.ArrayLike, wave_speed_m_s: npt.ArrayLike, shortfall: npt.ArrayLike
) -> FloatArray:
    """Return the frequency at v = (1 − δ) c, f_n = n c δ (2 − δ)/(2 l) [Hz], as exact as δ is."""
    n, length = checked("mode", mode), checked("free_span_m", free_span_m)
    c, delta = checked("wave_speed_m_s", wave_speed_m_s), checked("shortfall", shortfall)
    if (delta >= 2.0).any():
        raise InputError("the shortfall is 2 or more: the blade runs backwards above its critical speed")
    return np.asarray(n * c * delta * (2.0 - delta) / (2.0 * length))


def running_mode(
    place_m: npt.ArrayLike,
    time_s: npt.ArrayLike,
    *,
    mode: int,
    free_span_m: float,
    wave_speed_m_s: float,
    speed_m_s: float,
) -> FloatArray:
    """Return the deflection of a running mode, sin(nπx/l) cos(2π f_n t + nπ v x/(l c)), with amplitude 1.

    The sum of a wave with the blade and one against it, w = ½ Σ ± sin(…), that vanishes at both ends. At rest it
    is a standing wave; on a running blade crests enter at one end and leave at the other.
    """
    x = np.atleast_1d(np.asarray(place_m, dtype=np.float64))
    t = np.atleast_1d(np.asarray(time_s, dtype=np.float64))
    f = float(frequency_Hz(mode, free_span_m, wave_speed_m_s, speed_m_s))
    if not ((x >= 0.0) & (x <= free_span_m)).all():
        raise InputError(f"a place lies outside the span from 0 to {free_span_m:g} m", key="place_m")
    share = x / free_span_m
    # sin(n pi) is not zero in floats; sin(n pi (1 - x/l)) is, there, and equal up to the sign.
    inner = np.minimum(share, 1.0 - share)
    sign = np.where((share > 0.5) & (mode % 2 == 0), -1.0, 1.0)
    envelope = sign * np.sin(mode * math.pi * inner)
    phase = 2.0 * math.pi * f * t[:, np.newaxis] + mode * math.pi * (speed_m_s / wave_speed_m_s) * share
    return np.asarray(envelope * np.cos(phase))


def refuse_no_modes(n_modes: int) -> None:
    """Refuse a number of modes below 1."""
    if n_modes < 1:
        raise InputError(f"{n_modes} modes were asked for", key="n_modes", fix="ask for 1 or more")


def string_frequencies_Hz(span: Span, n_modes: int = 6) -> FloatArray:
    """Return the first frequencies of spans as strings; a stiffness they have is left out.

    Written with the net tension, f_n = n (F − ρA v²)/(2 l √(F ρA)), which `Span` knows to full relative precision
    where F and ρA v² all but cancel, and for κ = 1, where they never do.
    """
    refuse_no_modes(n_modes)
    limp = replace(span, bending_stiffness_N_m2=np.zeros(1)) if span.bending_stiffness_N_m2.any() else span
    net_N = refuse_overspeed(limp, PINNED)
    first = net_N / (2.0 * span.free_span_m * np.sqrt(span.tension_N * span.linear_density_kg_m))
    return np.asarray(first[:, np.newaxis] * np.arange(1.0, n_modes + 1.0))
