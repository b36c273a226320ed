"""A band saw as a scene simulates it: its blade with the effects that are in, and its frequencies.

The limit under feed force: the push on the teeth at which a blade turns out of its plane and buckles sideways.

A force Q on the edge, at mid-span, bends the blade edgewise by m(x) Q, the moment of a pinned beam under the tension
P = F − ρA v². The blade gives way by a deflection u and a twist φ, whose energy per length is

    ½ EI u'' ² + ½ P u' ² + ½ (G J + P r²) φ' ² + Q m φ u'',   J = b h³/3,   r² = (b² + h²)/12,

less the work ½ Q e φ² that the force, standing off by e = b/2, does at mid-span (lateral buckling after Timoshenko and
Gere, Theory of Elastic Stability, 6.3, with the tension's part). The least Q at which it is no longer positive is the
limit; buckling is static, so that of a running blade only its net tension matters.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.linalg
from numpy.polynomial import legendre

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError, SolverError
from ropefric.systems.bandsaw.beam import beam_frequencies_Hz
from ropefric.systems.bandsaw.saw import Excitation, Section, Side
from ropefric.systems.bandsaw.span import CLAMPED, Ends, Span
from ropefric.systems.checks import Cases, Positive, Share, ZeroOrMore, refuse
from ropefric.systems.effect import Model
from ropefric.systems.friction import WrapFriction


@dataclass(frozen=True, kw_only=True, eq=False)
class SawProblem(Cases):
    """A blade on two wheels, n cases side by side."""

    free_span_m: Positive
    linear_density_kg_m: Positive
    preload_N: Positive
    n_modes: int
    wheel_radius_m: Positive | None = None
    wheel_speed_rad_s: ZeroOrMore | None = None
    tension_difference_N: ZeroOrMore | None = None
    mounting_factor: Share | None = None
    bending_stiffness_N_m2: ZeroOrMore | None = None
    ends: Ends = CLAMPED
    section: Section | None = None
    friction: WrapFriction | None = None
    wheel_wrap_rad: Positive = np.pi  # type: ignore[assignment]  # spread in __post_init__
    excitations: tuple[Excitation, ...] = ()
    margin_wanted: float | None = None
    preload_range_N: list[float] | None = None
    feed_force_N: Positive | None = None
    guided_m: Positive | None = None

    @property
    def speed_m_s(self) -> FloatArray | None:
        """Return the blade's speed v = ω R [m/s], shape (n,), where the wheels are known."""
        if self.wheel_radius_m is None or self.wheel_speed_rad_s is None:
            return None
        return self.wheel_speed_rad_s * self.wheel_radius_m

    @property
    def inertia_N(self) -> FloatArray:
        """Return ρA v² [N]; zero where the scene does not give a speed."""
        return self.product("linear_density_kg_m", "speed_m_s", "speed_m_s")

    @property
    def wheels_N(self) -> FloatArray:
        """Return κ ρA v² [N]; zero where the scene does not give it."""
        return self.product("mounting_factor", "inertia_N")

    @property
    def pull_N(self) -> FloatArray:
        """Return ΔF/2 [N]; zero where the scene does not give it."""
        return 0.5 * self.product("tension_difference_N")


class SawModel(Model[SawProblem]):
    """A saw's blade with the effects that are in it; without any on all sides a string at rest under its preload."""

    @cached_property
    def spans(self) -> Mapping[Side, Span]:
        """Return the blade's free span on each side, and at rest."""
        problem, found = self.problem, {}
        blade = {name: getattr(problem, name) for name in ("free_span_m", "linear_density_kg_m", "preload_N")}
        running = {
            "mounting_factor": self.part("wheel-inertia-tension", problem.mounting_factor),
            "wheel_speed_m_s": self.part("wheel-inertia-tension", problem.speed_m_s),
            "travel_speed_m_s": self.part("travel", problem.speed_m_s),
        }
        stiff, pull_N = self.part("bending", problem.bending_stiffness_N_m2), problem.pull_N
        for side in Side:
            blade["pull_N"] = side.sign * self.part("tension-difference", pull_N)
            if side is Side.SLACK and "tension-difference" in self.effects:
                Span(**blade)  # refuses a side that is slack before the wheels' inertia helps it
            runs = {name: abs(side.sign) * value for name, value in running.items()}
            found[side] = Span(**blade, **runs, bending_stiffness_N_m2=stiff)
        return found


def span_of(
    model: SawModel, side: Side, *, speed_m_s: npt.ArrayLike | None = None, **changed: npt.ArrayLike
) -> Span:
    """Return one side of a blade; another speed and other values may be given, one or many."""
    problem = model.problem
    if speed_m_s is not None:
        changed["wheel_speed_rad_s"] = np.asarray(speed_m_s) / problem.wheel_radius_m
    return replace(model, problem=replace(problem, **changed)).spans[side]  # type: ignore[arg-type]


def frequencies_Hz(
    model: SawModel, side: Side, n_modes: int = 6, *, accuracy: float = 1e-10, **changed: npt.ArrayLike
) -> FloatArray:
    """Return the first frequencies of one side of a blade [Hz], shape (n, n_modes)."""
    span = span_of(model, side, **changed)
    return beam_frequencies_Hz(span, model.problem.ends, n_modes, accuracy=accuracy)


class SideAnswer(NamedTuple):
    """One side of a blade."""

    tension_N: FloatArray
    wave_speed_m_s: FloatArray
    critical_speed_m_s: FloatArray
    frequencies_Hz: FloatArray
    torsion_Hz: FloatArray | None
    feed_limit_N: FloatArray | None


class SawAnswer(NamedTuple):
    """The frequencies of a saw, and the share of the driving wheel's grip that is used."""

    model: SawModel
    sides: Mapping[Side, SideAnswer]
    wheel_utilisation: FloatArray | None
    accuracy: float

    @property
    def feed_limit_N(self) -> FloatArray | None:
        """Return the limit under feed force of the side that bears less [N], shape (n,), where it is asked for."""
        limits = [one.feed_limit_N for one in self.sides.values()]
        found = [one for one in limits if one is not None]
        return np.min(found, axis=0) if found else None

    @property
    def logs(self) -> FloatArray:
        """Return the logarithms of all numbers but those of torsion, shape (k, n)."""
        numbers = [
            part
            for one in self.sides.values()
            for part in (one.frequencies_Hz.T, [one.tension_N, one.wave_speed_m_s, one.critical_speed_m_s])
        ]
        numbers += [one[np.newaxis] for one in (self.wheel_utilisation, self.feed_limit_N) if one is not None]
        with np.errstate(divide="ignore"):
            return np.log(np.concatenate(numbers))


def solve_saw(model: SawModel, *, accuracy: float = 1e-10) -> SawAnswer:
    """Return the frequencies of a model."""
    problem = model.problem
    section = problem.section if "torsion" in model.effects else None
    length_m = float(problem.free_span_m[0]) if problem.guided_m is None else float(problem.guided_m[0])

    def bears_N(side: Side, span: Span) -> FloatArray | None:
        if problem.feed_force_N is None or problem.section is None or side is Side.REST:
            return None
        return feed_limit_N(span.net_tension_N, problem.section, problem.ends, length_m)

    sides = {
        side: SideAnswer(
            tension_N=span.tension_N,
            wave_speed_m_s=span.wave_speed_m_s,
            critical_speed_m_s=span.critical_speed_m_s(problem.ends),
            frequencies_Hz=beam_frequencies_Hz(span, problem.ends, problem.n_modes, accuracy=accuracy),
            torsion_Hz=None if section is None else torsion_frequencies_Hz(span, section, problem.n_modes),
            feed_limit_N=bears_N(side, span),
        )
        for side, span in model.spans.items()
    }
    tight, slack = model.spans[Side.TIGHT], model.spans[Side.SLACK]
    # The difference of two large tensions loses a small pull, and what the wheels add is the same on both sides.
    use = grip_utilisation(problem, tight.pull_N - slack.pull_N, slack.net_tension_N)
    return SawAnswer(model, sides, use, accuracy)


def grip_utilisation(problem: SawProblem, needed_N: FloatArray, pressing_N: FloatArray) -> FloatArray | None:
    """Return required over available friction pull of the driving wheel, shape (n,) [-]; 1 at gross slip.

    U = (F_tight − F_slack) / ((F_slack − ρAv²)(e^M − 1)): what keeps the blade on its circle presses nothing. None
    where the scene does not say what friction there is.
    """
    if problem.friction is None or problem.wheel_radius_m is None or problem.section is None:
        return None
    touching = pressing_N > 0.0
    if not touching.any():
        return np.where(needed_N > 0.0, np.inf, 0.0)
    exponent = problem.friction.exponent(
        problem.wheel_radius_m,
        0.5 * problem.section.thickness_m,
        problem.wheel_wrap_rad,
        np.where(touching, pressing_N, 1.0),
    )
    # Both times e^{−M}: e^M itself may be beyond floats.
    available_N = np.where(touching, -pressing_N * np.expm1(-exponent), 0.0)
    share: FloatArray = np.divide(
        needed_N * np.exp(-exponent), available_N, out=np.full_like(needed_N, np.inf), where=available_N > 0.0
    )
    return share


def torsion_frequencies_Hz(span: Span, section: Section, n_modes: int = 6) -> FloatArray:
    """Return the first frequencies of torsion f_n = n (c_t² − v²)/(2 l c_t) [Hz], shape (n, n_modes).

    c_t² = F/ρA + 4 (G/ρ)(h/b)²: the strip's own stiffness G b h³/3 and the tension's, F b²/12 (outer fibres lie askew
    when it is twisted), over the inertia ρ h b³/12. The ends are held against twisting.
    """
    ratio = section.thickness_m / section.width_m
    own = 4.0 * section.shear_modulus_Pa / section.density_kg_m3 * ratio**2
    speed = np.sqrt(span.tension_N / span.linear_density_kg_m + own)
    squared = span.net_tension_N / span.linear_density_kg_m + own
    refuse(
        squared <= 0.0,
        "the blade travels at {travel_m_s:.9g} m/s{place} and the critical speed of torsion is {limit_m_s:.9g} m/s, "
        "where its frequency is zero",
        code="RF530",
        key="travel_speed_m_s",
        fix="run slower, or raise the preload",
        travel_m_s=span.travel_speed_m_s,
        limit_m_s=speed,
    )
    first_Hz = squared / (2.0 * span.free_span_m * speed)
    return np.asarray(first_Hz[:, np.newaxis] * np.arange(1.0, n_modes + 1.0))


def answerable(problem: SawProblem) -> BoolArray:
    """Return for which of n cases both sides are tight and slower than their critical speed, shape (n,)."""
    slack_N = problem.preload_N - problem.pull_N + problem.wheels_N
    stiff_N = problem.ends.buckling * problem.product("bending_stiffness_N_m2") / problem.free_span_m**2
    return np.asarray((slack_N > 0.0) & (slack_N - problem.inertia_N + stiff_N > 0.0))


_ORDERS = (24, 48, 96, 192)
_SETTLED = 1e-9
_LEAST = 1e-9
"""Tension below which a blade may as well have none, of EI/l²."""


def feed_limit_N(
    net_tension_N: FloatArray, section: Section, ends: Ends, length_m: float, offset_m: float | None = None
) -> FloatArray:
    """Return the force on the edge at mid-span at which blades between guides buckle, shape (n,) [N].

    `offset_m` is how far from the middle of the blade it acts; half the width if not given.
    """
    e = 0.5 * section.width_m if offset_m is None else offset_m
    return np.array(
        [_limit_N(float(one), section, ends, length_m, e) for one in np.atleast_1d(net_tension_N)]
    )


def _limit_N(P: float, section: Section, ends: Ends, length_m: float, e: float) -> float:
    before = math.inf
    for order in _ORDERS:
        try:
            found = _at_order(P, section, ends, order, length_m=length_m, e=e)
        except np.linalg.LinAlgError:  # what it resists with is not positive: bending, or twisting
            raise InputError(
                f"the blade buckles by itself, without any feed: its net tension is {P:.6g} N",
                code="RF530",
                key="travel_speed_m_s",
                fix="run slower, or raise the preload",
            ) from None
        if abs(found - before) <= _SETTLED * found:
            return found
        before = found
    raise SolverError(
        f"the limit under feed force does not settle; it is about {before:.4g} N",
        key="preload_N",
        fix="a blade under this tension has almost no stiffness of its own",
    )


def _at_order(P: float, section: Section, ends: Ends, order: int, *, length_m: float, e: float) -> float:
    """Return the limit by polynomials on half the span: u'' and φ' are Legendre's, so held ends are kept exactly."""
    b, h = section.width_m, section.thickness_m
    EI = section.bending_stiffness_N_m2
    twist = section.shear_modulus_Pa * b * h**3 / 3.0 + P * (b**2 + h**2) / 12.0
    half_m, each = 0.5 * length_m, np.eye(order)
    points, weights = legendre.leggauss(order + 32)
    scale = 0.5 * half_m  # of dx on −1 … 1
    x, weights = scale * (points + 1.0), scale * weights
    # u' vanishes at mid-span; at a clamp, too: then u'' has no mean.
    curved = each if ends.turns else each[1:]
    bent = legendre.legval(points, curved.T)
    slope = scale * legendre.legval(points, legendre.legint(curved.T, lbnd=1.0))
    turned = scale * legendre.legval(points, legendre.legint(each, lbnd=-1.0))
    turning = legendre.legval(points, each)
    k = math.sqrt(max(abs(P), _LEAST * EI / length_m**2) / (EI * (b / h) ** 2))
    # sinh(kx)/(2k cosh(kl/2)), which does not overflow; a blade near its critical speed is under slight compression.
    moment = np.sin(k * x) / (2.0 * k * math.cos(k * half_m))
    if P >= 0.0:
        damped = np.exp(k * (x - half_m)) * -np.expm1(-2.0 * k * x)
        moment = damped / (2.0 * k * (1.0 + math.exp(-2.0 * k * half_m)))
    coupling = (bent * (weights * moment)) @ turned.T
    at_middle = scale * legendre.legval(1.0, legendre.legint(each, lbnd=-1.0))
    stiff = [
        EI * (bent * weights) @ bent.T + P * (slope * weights) @ slope.T,
        twist * (turning * weights) @ turning.T,
    ]
    n = len(curved)
    push = np.zeros((n + order, n + order))
    push[:n, n:], push[n:, :n] = -coupling, -coupling.T
    push[n:, n:] = 0.5 * e * np.outer(at_middle, at_middle)
    # Positive on one side and symmetric on both: the greatest 1/Q.
    last = n + order - 1
    inverse = scipy.linalg.eigh(
        push, scipy.linalg.block_diag(*stiff), eigvals_only=True, subset_by_index=[last, last]
    )
    return 1.0 / float(inverse[0])
