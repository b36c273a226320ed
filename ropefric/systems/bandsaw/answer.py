"""A band saw as a scene simulates it: its blade with the effects that are in, its frequencies, the effects' worth."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import product
from typing import NamedTuple

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.registry import Registry
from ropefric.systems.bandsaw.beam import beam_frequencies_Hz
from ropefric.systems.bandsaw.measured import Measurement
from ropefric.systems.bandsaw.resonance import Excitation
from ropefric.systems.bandsaw.saw import Section, Side
from ropefric.systems.bandsaw.span import CLAMPED, Ends, Span, refuse_no_modes
from ropefric.systems.checks import Cases, Positive, ZeroOrMore, refuse
from ropefric.systems.effect import Effect, Method, Model, System, missing, worst_case
from ropefric.systems.friction import WrapFriction
from ropefric.systems.subsets import largest_changes, log_change


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
    mounting_factor: ZeroOrMore | None = None
    bending_stiffness_N_m2: ZeroOrMore | None = None
    ends: Ends = CLAMPED
    section: Section | None = None
    friction: WrapFriction | None = None
    wheel_wrap_rad: Positive = np.pi  # type: ignore[assignment]  # spread in __post_init__
    excitations: tuple[Excitation, ...] = ()
    measurements: tuple[Measurement, ...] = ()
    margin_wanted: float | None = None
    preload_range_N: list[float] | None = None

    def __post_init__(self) -> None:
        Cases.__post_init__(self)
        refuse_no_modes(self.n_modes)

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
        return {side: self._span(side) for side in Side}

    def _span(self, side: Side) -> Span:
        problem, runs = self.problem, abs(side.sign)
        static = {
            "free_span_m": problem.free_span_m,
            "linear_density_kg_m": problem.linear_density_kg_m,
            "preload_N": problem.preload_N,
            "pull_N": side.sign * self.part("tension-difference", problem.pull_N),
        }
        if side is Side.SLACK and "tension-difference" in self.effects:
            Span(**static)  # refuses a side that is slack before the wheels' inertia helps it
        return Span(
            **static,
            mounting_factor=runs * self.part("wheel-inertia-tension", problem.mounting_factor),
            wheel_speed_m_s=runs * self.part("wheel-inertia-tension", problem.speed_m_s),
            travel_speed_m_s=runs * self.part("travel", problem.speed_m_s),
            bending_stiffness_N_m2=self.part("bending", problem.bending_stiffness_N_m2),
        )


class SideAnswer(NamedTuple):
    """One side of a blade."""

    tension_N: FloatArray
    wave_speed_m_s: FloatArray
    critical_speed_m_s: FloatArray
    frequencies_Hz: FloatArray
    torsion_Hz: FloatArray | None


class SawAnswer(NamedTuple):
    """The frequencies of a saw, and the share of the driving wheel's grip that is used."""

    model: SawModel
    sides: Mapping[Side, SideAnswer]
    wheel_utilisation: FloatArray | None

    @property
    def logs(self) -> FloatArray:
        """Return the logarithms of all numbers but those of torsion, shape (k, n)."""
        numbers = [one.frequencies_Hz.T for one in self.sides.values()]
        if self.wheel_utilisation is not None:
            numbers.append(self.wheel_utilisation[np.newaxis])
        with np.errstate(divide="ignore"):
            return np.log(np.concatenate(numbers))


def solve_saw(model: SawModel, *, accuracy: float = 1e-10) -> SawAnswer:
    """Return the frequencies of a model."""
    problem = model.problem
    section = problem.section if "torsion" in model.effects else None
    sides = {
        side: SideAnswer(
            tension_N=span.tension_N,
            wave_speed_m_s=span.wave_speed_m_s,
            critical_speed_m_s=span.critical_speed_m_s(problem.ends),
            frequencies_Hz=beam_frequencies_Hz(span, problem.ends, problem.n_modes, accuracy=accuracy),
            torsion_Hz=None if section is None else torsion_frequencies_Hz(span, section, problem.n_modes),
        )
        for side, span in model.spans.items()
    }
    tight, slack = model.spans[Side.TIGHT], model.spans[Side.SLACK]
    # The difference of two large tensions loses a small pull, and what the wheels add is the same on both sides.
    return SawAnswer(
        model, sides, grip_utilisation(problem, tight.pull_N - slack.pull_N, slack.net_tension_N)
    )


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
        wheel_radius_m=problem.wheel_radius_m,
        rope_radius_m=0.5 * problem.section.thickness_m,
        wrap_angle_rad=problem.wheel_wrap_rad,
        slack_tension_N=np.where(touching, pressing_N, 1.0),
    )
    # Both times e^{−M}: e^M itself may be beyond floats.
    available_N = np.where(touching, -pressing_N * np.expm1(-exponent), 0.0)
    share: FloatArray = np.divide(
        needed_N * np.exp(-exponent), available_N, out=np.full_like(needed_N, np.inf), where=available_N > 0.0
    )
    return share


def torsion_wave_speed_m_s(span: Span, section: Section) -> FloatArray:
    """Return c_t = √(F/ρA + 4 (G/ρ)(h/b)²) [m/s], shape (n,).

    The strip's own stiffness G b h³/3 and the tension's, F b²/12 (outer fibres lie askew when it is twisted), over
    the inertia ρ h b³/12.
    """
    return np.sqrt(span.tension_N / span.linear_density_kg_m + _stiffness_part(section))


def torsion_frequencies_Hz(span: Span, section: Section, n_modes: int = 6) -> FloatArray:
    """Return the first frequencies of torsion f_n = n (c_t² − v²)/(2 l c_t) [Hz], shape (n, n_modes).

    The ends are held against twisting. Parameters as in `torsion_wave_speed_m_s`.
    """
    refuse_no_modes(n_modes)
    speed = torsion_wave_speed_m_s(span, section)
    squared = span.net_tension_N / span.linear_density_kg_m + _stiffness_part(section)
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


def _stiffness_part(section: Section) -> float:
    """Return 4 (G/ρ)(h/b)² [m2/s2]."""
    ratio = section.thickness_m / section.width_m
    return 4.0 * section.shear_modulus_Pa / section.density_kg_m3 * ratio**2


def answerable(problem: SawProblem) -> BoolArray:
    """Return for which of n cases both sides are tight and slower than their critical speed, shape (n,)."""
    slack_N = problem.preload_N - problem.pull_N + problem.wheels_N
    stiff_N = problem.ends.buckling * problem.product("bending_stiffness_N_m2") / problem.free_span_m**2
    return np.asarray((slack_N > 0.0) & (slack_N - problem.inertia_N + stiff_N > 0.0))


_ROUNDING = 1e-11


@lru_cache(maxsize=2)
def _string_changes(problem: SawProblem) -> dict[str, float]:
    """Return what every effect but the stiffness is worth on a string, by ln f = ln(F − ρA v²) − ½ ln F + const.

    A stiff blade is less sensitive to tension and speed, as part of its restoring force depends on neither; in the
    wheel's grip the stiffness has no part.
    """
    pulls_N, presses_N, inertia_N = problem.pull_N, problem.wheels_N, problem.inertia_N

    def logs(effects: frozenset[str]) -> FloatArray:
        model = SawModel(problem=problem, effects=effects)
        pull_N, wheels_N = (
            model.part("tension-difference", pulls_N),
            model.part("wheel-inertia-tension", presses_N),
        )
        static_N = problem.preload_N + np.stack([pull_N, -pull_N])
        tension_N = static_N + wheels_N
        net_N = tension_N - model.part("travel", inertia_N)
        if not ((static_N > 0.0) & (net_N > 0.0)).all():
            raise InputError("a blade that is slack or too fast has no frequency", key="preload_N")
        found, use = (
            np.log(net_N) - 0.5 * np.log(tension_N),
            grip_utilisation(problem, 2.0 * pull_N, net_N[1]),
        )
        return found if use is None else np.concatenate([found, np.log(use)[np.newaxis]])

    return largest_changes(
        ("tension-difference", "wheel-inertia-tension", "travel"), logs, rounding=_ROUNDING
    )


def bending_bound(problem: SawProblem) -> FloatArray:
    """Return an upper bound of the change of ln f by the stiffness, for the highest mode wanted.

    Held ends shorten the string by a layer of δ = e/√(1 − V²) at each end, e = √(EI/F l²) and V = v/c; for ends that
    may turn δ = 0. Along what is left, mode n is the string's own e^(iκVx) sin κx, κ = nπ/(1 − 2δ), whose stiffness
    raises its frequency by ½κ²e² (1 + 6V² + V⁴)/(1 − V²) of itself, to first order. A mode yields to more stiffness
    by taking a softer shape, so a first order taken at the string's shape is too much: for mode 1 because it has
    the least of Rayleigh's quotients, for the others by trial. Both terms are exact as e → 0.
    """
    stiffness, worst = problem.product("bending_stiffness_N_m2"), np.zeros(problem.n)
    pull_N, wheels_N, inertia_N = problem.pull_N, problem.wheels_N, problem.inertia_N
    for pull, wheels, travels in product((-1.0, 0.0, 1.0), (0.0, 1.0), (0.0, 1.0)):
        tension_N = problem.preload_N + pull * pull_N + wheels * wheels_N
        e, V2 = (
            np.sqrt(stiffness / (tension_N * problem.free_span_m**2)),
            travels * inertia_N / tension_N,
        )
        layers = 0.0 * e if problem.ends.turns else 2.0 * e / np.sqrt(1.0 - V2)
        kappa = problem.n_modes * math.pi / (1.0 - layers)
        bent = 0.5 * (kappa * e) ** 2 * (1.0 + 6.0 * V2 + V2**2) / (1.0 - V2)
        change = np.where(layers < 1.0, np.log1p(bent) - np.log1p(-layers), np.inf)
        worst = np.maximum(worst, np.where(np.isnan(change), np.inf, change))
    return worst


_SPEED = {"wheel_radius_m": "wheel.radius", "wheel_speed_rad_s": "wheel.speed"}
EFFECTS: Registry[Effect[SawProblem, SawModel]] = Registry(
    "effect of a band saw",
    (
        Effect(
            name="tension-difference",
            adds="half the pull of the saw's torque on the tight side, and less on the slack side",
            instead="the preload on both sides",
            needs=missing({"tension_difference_N": "drive.power or drive.tension_difference"}),
            influence=lambda problem: _string_changes(problem)["tension-difference"],
            cost=0.05,
        ),
        Effect(
            name="wheel-inertia-tension",
            adds="the tension kappa rho A v^2 by which wheels that may give way follow the running blade",
            instead="wheel axles that do not give way",
            needs=missing({"mounting_factor": "tension.mounting_factor", **_SPEED}),
            influence=lambda problem: _string_changes(problem)["wheel-inertia-tension"],
            cost=0.05,
        ),
        Effect(
            name="travel",
            adds="the motion of the blade through its span, which its waves run with and against",
            instead="a blade that stands still",
            needs=missing(_SPEED),
            influence=lambda problem: _string_changes(problem)["travel"],
            cost=0.05,
        ),
        Effect(
            name="bending",
            adds="the blade's stiffness EI, with a boundary layer at held ends",
            instead="a string",
            needs=missing(
                {
                    "bending_stiffness_N_m2": "blade.bending_stiffness or blade.width, thickness and "
                    "youngs_modulus"
                }
            ),
            influence=worst_case(bending_bound, rounding=_ROUNDING),
            cost=50.0,
        ),
        Effect(
            name="torsion",
            adds="the frequencies of twisting, beside those of bending",
            instead="no frequencies of twisting; those of bending do not depend on them",
            needs=missing({"section": "blade.width, thickness, density and shear_modulus"}),
            influence=lambda problem: 0.0,  # noqa: ARG005
            cost=0.2,
        ),
    ),
)
"""In the order in which they are applied."""
_CLOSED_FORM = Method(name="closed form", error=1e-13, why="a string's travelling waves have one")
_FINEST = 1e-12
"""What rounding leaves is a few units of 1e-14."""
_COARSEST = 1e-3
"""A beam to a thousandth takes at most two orders more than to a hundredth: both need their boundary layers."""

_MARGIN = 0.25
"""What two orders may differ by, of the error allowed: the finer one can err by nearly twice what they differ by."""


def _method(model: SawModel, budget: float) -> Method:
    if not model.part("bending", model.problem.bending_stiffness_N_m2).any():
        return _CLOSED_FORM
    accuracy = min(max(budget, _FINEST), _COARSEST)
    return Method(
        name="spectral elements",
        settings={"accuracy": _MARGIN * accuracy},
        error=accuracy,
        why="the order is raised until a coarser solution agrees to a quarter of this",
    )


SYSTEM: System[SawProblem, SawModel, SawAnswer] = System(
    name="bandsaw",
    effects=EFFECTS,
    bare=lambda problem: SawModel(problem=problem),
    method=_method,
    solve=lambda model, method: solve_saw(model, accuracy=method.settings.get("accuracy", _FINEST)),
    distance=lambda answer, reference: float(np.expm1(log_change(answer.logs, reference.logs))),
)
"""A blade on two wheels."""
