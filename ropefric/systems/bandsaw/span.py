"""A free span of blade, put together from parts, each of which may be left out, and its frequencies as a string.

The ends are held in one of several ways; what a beam may do there and at which compression it buckles is said once.
"""

import math
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.registry import Registry
from ropefric.systems.checks import AnyNumber, Cases, Positive, Share, ZeroOrMore, checked, refuse


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
        return (self.half_waves * math.pi) ** 2


PINNED = Ends(name="pinned", turns=True, half_waves=1)
CLAMPED = Ends(name="clamped", turns=False, half_waves=2)
ENDS: Registry[Ends] = Registry("way of holding the ends", (PINNED, CLAMPED))
"""Every way of holding the ends by name."""

NEXT_TO_CRITICAL = 1e-6
"""A net tension that is less than this share of F_0 ± ΔF/2 and the buckling load is none: next to the critical speed its
digits are lost, and its first frequency is as good as zero."""


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
        """Return F = F_0 ± ΔF/2 + κ ρA v_w² [N], shape (n,)."""
        wheels_N = self.mounting_factor * self.linear_density_kg_m * self.wheel_speed_m_s**2
        return np.asarray(self.preload_N + self.pull_N + wheels_N)

    @property
    def wave_speed_m_s(self) -> FloatArray:
        """Return c = √(F/ρA) [m/s], shape (n,), of waves as a traveller with the blade sees them."""
        return np.sqrt(self.tension_N / self.linear_density_kg_m)

    @cached_property
    def net_tension_N(self) -> FloatArray:
        """Return F − ρA v² [N], shape (n,)."""
        # κ v_w² − v² cancels for κ near 1, where (v_w² − v²) − (1 − κ) v_w² does not.
        v_w, v = self.wheel_speed_m_s, self.travel_speed_m_s
        through = (v_w - v) * (v_w + v) - (1.0 - self.mounting_factor) * v_w**2
        return np.asarray(self.preload_N + self.pull_N + self.linear_density_kg_m * through)

    def buckling_N(self, ends: Ends) -> FloatArray:
        """Return the load under which the span buckles, β EI/l² [N]."""
        return ends.buckling * self.bending_stiffness_N_m2 / self.free_span_m**2

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

    def select(self, index: npt.ArrayLike) -> "Span":
        """Return the cases at an index array or boolean mask, in that order."""
        chosen = np.asarray(index)
        return Span(**{one.name: getattr(self, one.name)[chosen] for one in fields(self) if one.init})


def refuse_overspeed(span: Span, ends: Ends) -> FloatArray:
    """Return the net tension above the buckling load, F − ρA v² + β EI/l² [N]; refuse what is next to none of it."""
    buckling_N = span.buckling_N(ends)
    margin_N = span.net_tension_N + buckling_N
    wrong = margin_N <= NEXT_TO_CRITICAL * (np.abs(span.preload_N + span.pull_N) + buckling_N)
    refuse(
        wrong,
        "the blade travels at {speed_m_s:.9g} m/s and its critical speed is {limit_m_s:.9g} m/s{place}: there its "
        "first frequency is zero and the theory ends",
        code="RF530",
        key="travel_speed_m_s",
        fix="run slower, or raise the preload",
        speed_m_s=span.travel_speed_m_s,
        limit_m_s=_tension_limit_m_s(span, ends) if wrong.any() else 0.0,
    )
    return np.asarray(margin_N)


def _tension_limit_m_s(span: Span, ends: Ends) -> FloatArray:
    """Return the critical speed at the tension there is: the one that was passed if v_w is not v."""
    same = span.wheel_speed_m_s == np.abs(span.travel_speed_m_s)
    held = np.sqrt((span.tension_N + span.buckling_N(ends)) / span.linear_density_kg_m)
    return np.where(same, span.critical_speed_m_s(ends), held)


def string_frequencies_Hz(span: Span, n_modes: int = 6) -> FloatArray:
    """Return the first frequencies of spans as strings; a stiffness they have is left out.

    Written with the net tension, f_n = n (F − ρA v²)/(2 l √(F ρA)), which for κ = 1 no speed takes away.
    """
    limp = replace(span, bending_stiffness_N_m2=np.zeros(1)) if span.bending_stiffness_N_m2.any() else span
    net_N = refuse_overspeed(limp, PINNED)
    first = net_N / (2.0 * span.free_span_m * np.sqrt(span.tension_N * span.linear_density_kg_m))
    return np.asarray(first[:, np.newaxis] * np.arange(1.0, n_modes + 1.0))
