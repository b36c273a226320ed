"""A free span of blade, put together from parts, each of which may be left out, and its frequencies as a string.

The ends are held in one of several ways; what a beam may do there and at which compression it buckles is said once.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.registry import Registry
from ropefric.systems.checks import AnyNumber, Cases, Positive, Share, ZeroOrMore, checked, refuse

_PI_SQUARED = (9.869604401089358, 6.265295508739711e-16)


class Ends(NamedTuple):
    """A way of holding both ends of a span of length 1, and how many half waves it buckles in.

    Pinned ends are held in place and free to turn; clamped ones in direction, too, as a blade runs off a wheel or guide.
    """

    name: str
    turns: bool
    half_waves: int

    @property
    def buckling(self) -> float:
        """Return β of the load β EI/l² under which it buckles."""
        return self.half_waves**2 * _PI_SQUARED[0]

    @property
    def buckling_low(self) -> float:
        """Return what β lacks as a float."""
        return self.half_waves**2 * _PI_SQUARED[1]

    def buckled(self, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the buckling mode at places x, its slope and its curvature."""
        q = math.pi * self.half_waves
        sine, cosine = np.sin(q * x), np.cos(q * x)
        if self.turns:
            return sine, q * cosine, -(q**2) * sine
        return 1.0 - cosine, q * sine, q**2 * cosine


PINNED = Ends(name="pinned", turns=True, half_waves=1)
CLAMPED = Ends(name="clamped", turns=False, half_waves=2)
ENDS: Registry[Ends] = Registry("way of holding the ends", (PINNED, CLAMPED))
"""Every way of holding the ends by name."""

_SPLITTER = 134217729.0  # 2^27 + 1


class Pair:
    """high + low, which a single float could not hold, with about 32 digits: for differences of nearly equal numbers.

    Knuth's sum, Dekker's product; finite numbers whose products neither overflow nor fall below 1e-290.
    """

    __slots__ = ("high", "low")

    def __init__(self, high: FloatArray | float, low: FloatArray | float = 0.0) -> None:
        self.high, self.low = np.asarray(high), np.asarray(low)

    def __add__(self, other: "Pair") -> "Pair":
        """Return the sum."""
        first, second = _sum(self.high, other.high), _sum(self.low, other.low)
        first = _quick_sum(first.high, first.low + second.high)
        return _quick_sum(first.high, first.low + second.low)

    def __sub__(self, other: "Pair") -> "Pair":
        """Return the difference."""
        return self + Pair(-other.high, -other.low)

    def __mul__(self, other: "Pair") -> "Pair":
        """Return the product."""
        a, b, high = self.high, other.high, self.high * other.high
        (a_high, a_low), (b_high, b_low) = _split(a), _split(b)
        low = ((a_high * b_high - high) + a_high * b_low + a_low * b_high) + a_low * b_low
        return _quick_sum(high, low + (a * other.low + self.low * b))

    def total(self) -> FloatArray:
        """Return it as one float."""
        return np.asarray(self.high + self.low)


def _sum(a: FloatArray, b: FloatArray) -> Pair:
    high = a + b
    part = high - a
    return Pair(high, (a - (high - part)) + (b - part))


def _quick_sum(a: FloatArray, b: FloatArray) -> Pair:
    high = a + b
    return Pair(high, b - (high - a))


def _split(a: FloatArray) -> tuple[FloatArray, FloatArray]:
    scaled = _SPLITTER * a
    high = scaled - (scaled - a)
    return high, a - high


@dataclass(frozen=True, kw_only=True, eq=False)
class Span(Cases):
    """A span of blade between two wheels, n cases side by side.

    The tension is F = F_0 ± ΔF/2 + κ ρA v_w². Every part but the first is zero unless it is given, so that a model
    has in it what was put there: the torque's part, the wheels' part, the motion through the span and the
    stiffness are separate. In a saw v_w and v are the same speed.
    """

    free_span_m: Positive
    linear_density_kg_m: Positive
    preload_N: AnyNumber
    pull_N: AnyNumber = 0.0  # type: ignore[assignment]  # spread in __post_init__
    mounting_factor: Share = 0.0  # type: ignore[assignment]
    wheel_speed_m_s: AnyNumber = 0.0  # type: ignore[assignment]
    travel_speed_m_s: AnyNumber = 0.0  # type: ignore[assignment]
    bending_stiffness_N_m2: ZeroOrMore = 0.0  # type: ignore[assignment]

    def __post_init__(self) -> None:
        Cases.__post_init__(self)
        refuse(
            self.tension_N <= 0.0,
            "the tension is {tension_N:.6g} N (preload {preload_N:.6g} N, pull {pull_N:+.6g} N){place}; it must be "
            "positive: a slack blade is no string",
            key="preload_N",
            fix="raise the preload above {least_N:.6g} N",
            least_N=self.preload_N - self.tension_N,
            tension_N=self.tension_N,
            preload_N=self.preload_N,
            pull_N=self.pull_N,
        )
        checked("tension_N", self.tension_N)

    @cached_property
    def tension_N(self) -> FloatArray:
        """Return F = F_0 ± ΔF/2 + κ ρA v_w² [N], shape (n,), to full relative precision."""
        wheels = Pair(self.wheel_speed_m_s) * Pair(self.wheel_speed_m_s)
        return (self._static + Pair(self.linear_density_kg_m) * (Pair(self.mounting_factor) * wheels)).total()

    @property
    def wave_speed_m_s(self) -> FloatArray:
        """Return c = √(F/ρA) [m/s], shape (n,), of waves as a traveller with the blade sees them."""
        return np.sqrt(self.tension_N / self.linear_density_kg_m)

    @cached_property
    def net_tension_N(self) -> FloatArray:
        """Return F − ρA v² = ρA (c − v)(c + v) [N], shape (n,), to full relative precision."""
        return self._net.total()

    def buckling_N(self, ends: Ends) -> FloatArray:
        """Return the load under which the span buckles, β EI/l² [N]."""
        return ends.buckling * self.bending_stiffness_N_m2 / self.free_span_m**2

    def margin_N(self, ends: Ends) -> FloatArray:
        """Return the net tension above the buckling load, F − ρA v² + β EI/l² [N], to full relative precision."""
        if not self.bending_stiffness_N_m2.any():
            return self.net_tension_N
        # Times l², so that nothing is divided before the sum.
        squared = Pair(self.free_span_m) * Pair(self.free_span_m)
        load = Pair(ends.buckling, ends.buckling_low) * Pair(self.bending_stiffness_N_m2)
        return (self._net * squared + load).total() / self.free_span_m**2

    def critical_speed_m_s(self, ends: Ends) -> FloatArray:
        """Return the speed at which the first frequency vanishes, shape (n,); infinite for κ = 1.

        v_c² (1 − κ) ρA = F_0 ± ΔF/2 + β EI/l². The mounting counts whether or not the wheels turn, because they
        would at that speed. Where the right side is not positive, only inertia tightens the blade and v_c is zero.
        """
        force_N = self.preload_N + self.pull_N + self.buckling_N(ends)
        held = self.linear_density_kg_m * (1.0 - self.mounting_factor)
        some = force_N > 0.0
        limited = np.divide(force_N, held, out=np.full(self.n, np.inf), where=some & (held > 0.0))
        return np.where(some, np.sqrt(limited), 0.0)

    @cached_property
    def _net(self) -> Pair:
        # κ v_w² − v² cancels for κ near 1, where (v_w² − v²) − (1 − κ) v_w² does not; F and ρA v² do as v nears c.
        held, v_w, v = Pair(self.mounting_factor), Pair(self.wheel_speed_m_s), Pair(self.travel_speed_m_s)
        by_loose = (v_w - v) * (v_w + v) - (Pair(1.0) - held) * (v_w * v_w)
        by_mounting = held * (v_w * v_w) - v * v
        near_one = self.mounting_factor >= 0.5
        through = Pair(
            np.where(near_one, by_loose.high, by_mounting.high),
            np.where(near_one, by_loose.low, by_mounting.low),
        )
        return self._static + Pair(self.linear_density_kg_m) * through

    @cached_property
    def _static(self) -> Pair:
        return Pair(self.preload_N) + Pair(self.pull_N)


def refuse_overspeed(span: Span, ends: Ends) -> FloatArray:
    """Return `Span.margin_N` where all of it is positive; refuse otherwise, naming the critical speed."""
    margin = span.margin_N(ends)
    refuse(
        margin <= 0.0,
        "the blade travels at {speed_m_s:.9g} m/s and its critical speed is {limit_m_s:.9g} m/s{place}: there its "
        "first frequency is zero and the theory ends",
        code="RF530",
        key="travel_speed_m_s",
        fix="run slower, or raise the preload",
        speed_m_s=span.travel_speed_m_s,
        limit_m_s=_tension_limit_m_s(span, ends) if (margin <= 0.0).any() else 0.0,
    )
    return margin


def _tension_limit_m_s(span: Span, ends: Ends) -> FloatArray:
    """Return the critical speed at the tension there is: the one that was passed if v_w is not v."""
    same = span.wheel_speed_m_s == np.abs(span.travel_speed_m_s)
    held = np.sqrt((span.tension_N + span.buckling_N(ends)) / span.linear_density_kg_m)
    return np.where(same, span.critical_speed_m_s(ends), held)


def string_frequencies_Hz(span: Span, n_modes: int = 6) -> FloatArray:
    """Return the first frequencies of spans as strings; a stiffness they have is left out.

    Written with the net tension, f_n = n (F − ρA v²)/(2 l √(F ρA)), which `Span` knows to full relative precision
    where F and ρA v² all but cancel, and for κ = 1, where they never do.
    """
    limp = replace(span, bending_stiffness_N_m2=np.zeros(1)) if span.bending_stiffness_N_m2.any() else span
    net_N = refuse_overspeed(limp, PINNED)
    first = net_N / (2.0 * span.free_span_m * np.sqrt(span.tension_N * span.linear_density_kg_m))
    return np.asarray(first[:, np.newaxis] * np.arange(1.0, n_modes + 1.0))
