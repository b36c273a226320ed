"""The effects a band saw's blade may be simulated with, and how much each can matter at most.

For a string ln f = ln(F − ρA v²) − ½ ln F and what does not depend on the effects, so the largest change over the
corners (each tension with or without the torque's and the wheels' part, each speed with or without the travel) bounds
every effect but the stiffness. A stiff blade is less sensitive to tension and speed than a string, as part of its
restoring force depends on neither.

Where the scene asks for the wheel's grip as well, its utilisation U = ΔF/((F_slack − ρA v²)(e^M − 1)) is bounded over
the same corners: without the difference there is none, and the stiffness has no part in it.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.registry import Registry
from ropefric.systems.bandsaw.answer import SawAnswer, SawModel, solve_saw
from ropefric.systems.bandsaw.ends import CLAMPED, Ends
from ropefric.systems.bandsaw.measured import Measurement
from ropefric.systems.bandsaw.resonance import Excitation
from ropefric.systems.bandsaw.saw import Side
from ropefric.systems.bandsaw.section import Section
from ropefric.systems.bandsaw.span import Span
from ropefric.systems.checks import Rule
from ropefric.systems.checks import side_by_side as spread
from ropefric.systems.effect import Effect, Method, System, worst_case
from ropefric.systems.friction import WrapFriction


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SawProblem:
    """A blade on two wheels, m cases side by side; scalars are spread."""

    free_span_m: FloatArray
    linear_density_kg_m: FloatArray
    preload_N: FloatArray
    n_modes: int
    wheel_radius_m: FloatArray | None = None
    wheel_speed_rad_s: FloatArray | None = None
    tension_difference_N: FloatArray | None = None
    mounting_factor: FloatArray | None = None
    bending_stiffness_N_m2: FloatArray | None = None
    ends: Ends = CLAMPED
    section: Section | None = None
    friction: WrapFriction | None = None
    wheel_wrap_rad: float = np.pi
    excitations: tuple[Excitation, ...] = ()
    measurements: tuple[Measurement, ...] = ()
    margin_wanted: float | None = None
    preload_range_N: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        for name, array in spread({name: getattr(self, name) for name in _RULES}, _RULES).items():
            object.__setattr__(self, name, array)
        if self.n_modes < 1:
            raise InputError(f"{self.n_modes} modes were asked for", key="n_modes", fix="ask for 1 or more")

    @property
    def m(self) -> int:
        """Return how many cases there are."""
        return self.preload_N.size

    @property
    def speed_m_s(self) -> FloatArray | None:
        """Return the blade's speed v = ω R [m/s], shape (m,), where the wheels are known."""
        if self.wheel_radius_m is None or self.wheel_speed_rad_s is None:
            return None
        return self.wheel_speed_rad_s * self.wheel_radius_m


_RULES: dict[str, Rule] = {
    "free_span_m": "positive",
    "linear_density_kg_m": "positive",
    "preload_N": "positive",
    "wheel_radius_m": "positive",
    "wheel_speed_rad_s": "zero or more",
    "tension_difference_N": "zero or more",
    "mounting_factor": "zero or more",
    "bending_stiffness_N_m2": "zero or more",
}


Bound = Callable[[SawProblem], FloatArray]

_ROUNDING = 1e-11


def bounded(bound: Bound) -> Callable[[SawProblem], float]:
    """Return the `influence` of a bound: the largest of all cases, `inf` where a blade is slack or too fast."""
    return worst_case(bound, rounding=_ROUNDING)


def _zeros(problem: SawProblem) -> FloatArray:
    return np.zeros(problem.m)


def _inertia_N(problem: SawProblem) -> FloatArray:
    """Return ρA v² [N]; zero where the scene does not give a speed."""
    speed = problem.speed_m_s
    return _zeros(problem) if speed is None else problem.linear_density_kg_m * speed**2


def _wheels_N(problem: SawProblem) -> FloatArray:
    """Return κ ρA v² [N]."""
    return (
        _zeros(problem) if problem.mounting_factor is None else problem.mounting_factor * _inertia_N(problem)
    )


def _pull_N(problem: SawProblem) -> FloatArray:
    """Return ΔF/2 [N]."""
    return _zeros(problem) if problem.tension_difference_N is None else 0.5 * problem.tension_difference_N


def answerable(problem: SawProblem) -> BoolArray:
    """Return for which of m cases both sides are tight and slower than their critical speed, shape (m,)."""
    inertia_N = _inertia_N(problem)
    stiff_N = _zeros(problem)
    if problem.bending_stiffness_N_m2 is not None:
        stiff_N = problem.ends.buckling * problem.bending_stiffness_N_m2 / problem.free_span_m**2
    slack_N = problem.preload_N - _pull_N(problem) + _wheels_N(problem)
    return np.asarray((slack_N > 0.0) & (slack_N - inertia_N + stiff_N > 0.0))


def _log_frequency(tension_N: FloatArray, inertia_N: FloatArray) -> FloatArray:
    """Return ln(F − ρA v²) − ½ ln F; NaN for a slack or too fast blade."""
    return np.log(tension_N - inertia_N) - 0.5 * np.log(tension_N)


def _travels(problem: SawProblem) -> tuple[FloatArray, FloatArray]:
    return _zeros(problem), _inertia_N(problem)


def _tensions(problem: SawProblem) -> Iterator[FloatArray]:
    for pull, wheels in product((-1.0, 0.0, 1.0), (0.0, 1.0)):
        yield problem.preload_N + pull * _pull_N(problem) + wheels * _wheels_N(problem)


def _asks_for_grip(problem: SawProblem) -> bool:
    """Return whether the answer says how much of the wheel's friction the drive needs."""
    known = (
        problem.friction is not None and problem.wheel_radius_m is not None and problem.section is not None
    )
    return known and bool(_pull_N(problem).any())


def _log_grip(problem: SawProblem, wheels: float, travels: float) -> FloatArray:
    """Return ln of what U varies with, −ln((F_slack − ρA v²)(e^M − 1)); NaN where the slack side presses nothing."""
    assert problem.friction is not None  # noqa: S101  (`_asks_for_grip` has made sure of all three)
    assert problem.wheel_radius_m is not None  # noqa: S101
    assert problem.section is not None  # noqa: S101
    slack_N = problem.preload_N - _pull_N(problem) + wheels * _wheels_N(problem)
    pressing_N = slack_N - travels * _inertia_N(problem)
    exponent = problem.friction.exponent(
        wheel_radius_m=problem.wheel_radius_m,
        rope_radius_m=0.5 * problem.section.thickness_m,
        wrap_angle_rad=problem.wheel_wrap_rad,
        slack_tension_N=np.where(pressing_N > 0.0, pressing_N, 1.0),
    )
    return -np.log(pressing_N) - exponent - np.log(-np.expm1(-exponent))


def difference_bound(problem: SawProblem) -> FloatArray:
    """Return the largest change of ln f by ±ΔF/2."""
    changes = [np.where(_pull_N(problem) > 0.0, np.inf, 0.0) if _asks_for_grip(problem) else _zeros(problem)]
    for wheels, inertia_N, sign in product((0.0, 1.0), _travels(problem), (-1.0, 1.0)):
        base_N = problem.preload_N + wheels * _wheels_N(problem)
        changes.append(
            np.abs(
                _log_frequency(base_N + sign * _pull_N(problem), inertia_N)
                - _log_frequency(base_N, inertia_N)
            )
        )
    return np.asarray(np.max(changes, axis=0))


def wheels_bound(problem: SawProblem) -> FloatArray:
    """Return the largest change of ln f by κ ρA v²."""
    changes = [_zeros(problem)]
    for pull, inertia_N in product((-1.0, 0.0, 1.0), _travels(problem)):
        base_N = problem.preload_N + pull * _pull_N(problem)
        changes.append(
            np.abs(_log_frequency(base_N + _wheels_N(problem), inertia_N) - _log_frequency(base_N, inertia_N))
        )
    if _asks_for_grip(problem):
        changes += [
            np.abs(_log_grip(problem, 1.0, travels) - _log_grip(problem, 0.0, travels))
            for travels in (0.0, 1.0)
        ]
    return np.asarray(np.max(changes, axis=0))


def travel_bound(problem: SawProblem) -> FloatArray:
    """Return the largest change of ln f by the travel, −ln(1 − v²/c²)."""
    inertia_N = _inertia_N(problem)
    changes = [_log_frequency(F, _zeros(problem)) - _log_frequency(F, inertia_N) for F in _tensions(problem)]
    if _asks_for_grip(problem):
        changes += [
            np.abs(_log_grip(problem, wheels, 1.0) - _log_grip(problem, wheels, 0.0)) for wheels in (0.0, 1.0)
        ]
    return np.asarray(np.max(changes, axis=0))


def bending_bound(problem: SawProblem) -> FloatArray:
    """Return an upper bound of the change of ln f by the stiffness, for the highest mode wanted.

    Held ends shorten the string by a layer of δ = e/√(1 − V²) at each end, e = √(EI/F l²) and V = v/c; for ends that
    may turn δ = 0. Along what is left, mode n is the string's own e^(iκVx) sin κx, κ = nπ/(1 − 2δ), whose stiffness
    raises its frequency by ½κ²e² (1 + 6V² + V⁴)/(1 − V²) of itself, to first order. A mode yields to more stiffness
    by taking a softer shape, so a first order taken at the string's shape is too much: for mode 1 because it has
    the least of Rayleigh's quotients, for the others by trial. Both terms are exact as e → 0.
    """
    if problem.bending_stiffness_N_m2 is None:
        return _zeros(problem)
    n = float(problem.n_modes)
    worst = _zeros(problem)
    for tension_N in _tensions(problem):
        e = np.sqrt(problem.bending_stiffness_N_m2 / (tension_N * problem.free_span_m**2))
        for inertia_N in _travels(problem):
            V2 = inertia_N / tension_N
            layers = 2.0 * e / np.sqrt(1.0 - V2) if problem.ends.name == CLAMPED.name else _zeros(problem)
            kappa = n * math.pi / (1.0 - layers)
            bent = 0.5 * (kappa * e) ** 2 * (1.0 + 6.0 * V2 + V2**2) / (1.0 - V2)
            change = np.where(layers < 1.0, np.log1p(bent) - np.log1p(-layers), np.inf)
            worst = np.maximum(worst, np.where(np.isnan(change), np.inf, change))
    return worst


_KEYS = {
    "wheel_radius_m": "wheel.radius",
    "wheel_speed_rad_s": "wheel.speed",
    "tension_difference_N": "drive.power or drive.tension_difference",
    "mounting_factor": "tension.mounting_factor",
    "bending_stiffness_N_m2": "blade.bending_stiffness or blade.width, thickness and youngs_modulus",
    "section": "blade.width, thickness, density and shear_modulus",
}


def bare(problem: SawProblem) -> SawModel:
    """Return the model without any effect: on all sides a string at rest under its preload."""
    string = Span(
        free_span_m=problem.free_span_m,
        linear_density_kg_m=problem.linear_density_kg_m,
        preload_N=problem.preload_N,
    )
    return SawModel(
        spans=dict.fromkeys(Side, string),
        n_modes=problem.n_modes,
        ends=problem.ends,
        friction=problem.friction,
        wheel_radius_m=problem.wheel_radius_m,
        half_thickness_m=0.0 if problem.section is None else 0.5 * problem.section.thickness_m,
        wheel_wrap_rad=problem.wheel_wrap_rad,
    )


def _needs(*names: str) -> Callable[[SawProblem], tuple[str, ...]]:
    def missing(problem: SawProblem) -> tuple[str, ...]:
        return tuple(_KEYS[name] for name in names if getattr(problem, name) is None)

    return missing


def _changed(
    model: SawModel, parts: Callable[[Side], Mapping[str, FloatArray]], sides: tuple[Side, ...] = tuple(Side)
) -> SawModel:
    """Return the model with parts added to the spans of some of its sides."""
    spans = {
        side: replace(span, **parts(side)) if side in sides else span for side, span in model.spans.items()
    }
    return replace(model, spans=spans)


_RUNNING = (Side.TIGHT, Side.SLACK)


def _given(values: FloatArray | None) -> FloatArray:
    """Return data of which `needs` has made sure that they are there."""
    assert values is not None  # noqa: S101
    return values


def _pull(model: SawModel, problem: SawProblem) -> SawModel:
    half_N = 0.5 * _given(problem.tension_difference_N)
    return _changed(model, lambda side: {"pull_N": side.sign * half_N}, _RUNNING)


def _press_wheels(model: SawModel, problem: SawProblem) -> SawModel:
    parts = {
        "mounting_factor": _given(problem.mounting_factor),
        "wheel_speed_m_s": _given(problem.speed_m_s),
    }
    return _changed(model, lambda side: parts, _RUNNING)  # noqa: ARG005  (the same on both sides)


def _travel(model: SawModel, problem: SawProblem) -> SawModel:
    parts = {"travel_speed_m_s": _given(problem.speed_m_s)}
    return _changed(model, lambda side: parts, _RUNNING)  # noqa: ARG005  (the same on both sides)


def _bend(model: SawModel, problem: SawProblem) -> SawModel:
    parts = {"bending_stiffness_N_m2": _given(problem.bending_stiffness_N_m2)}
    return _changed(model, lambda side: parts)  # noqa: ARG005  (the same on all sides)


def _twist(model: SawModel, problem: SawProblem) -> SawModel:
    return replace(model, torsion=problem.section)


def _none(problem: SawProblem) -> float:  # noqa: ARG001  (the signature of `influence`)
    return 0.0


EFFECTS: Registry[Effect[SawProblem, SawModel]] = Registry(
    "effect of a band saw",
    (
        Effect(
            name="tension-difference",
            adds="half the pull of the saw's torque on the tight side, and less on the slack side",
            instead="the preload on both sides",
            needs=_needs("tension_difference_N"),
            influence=bounded(difference_bound),
            apply=_pull,
            cost=0.05,
        ),
        Effect(
            name="wheel-inertia-tension",
            adds="the tension kappa rho A v^2 by which wheels that may give way follow the running blade",
            instead="wheel axles that do not give way",
            needs=_needs("mounting_factor", "wheel_radius_m", "wheel_speed_rad_s"),
            influence=bounded(wheels_bound),
            apply=_press_wheels,
            cost=0.05,
        ),
        Effect(
            name="travel",
            adds="the motion of the blade through its span, which its waves run with and against",
            instead="a blade that stands still",
            needs=_needs("wheel_radius_m", "wheel_speed_rad_s"),
            influence=bounded(travel_bound),
            apply=_travel,
            cost=0.05,
        ),
        Effect(
            name="bending",
            adds="the blade's stiffness EI, with a boundary layer at held ends",
            instead="a string",
            needs=_needs("bending_stiffness_N_m2"),
            influence=bounded(bending_bound),
            apply=_bend,
            cost=50.0,
        ),
        Effect(
            name="torsion",
            adds="the frequencies of twisting, beside those of bending",
            instead="no frequencies of twisting; those of bending do not depend on them",
            needs=_needs("section"),
            influence=_none,
            apply=_twist,
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
    if not any(span.bending_stiffness_N_m2.any() for span in model.spans.values()):
        return _CLOSED_FORM
    accuracy = min(max(budget, _FINEST), _COARSEST)
    return Method(
        name="spectral elements",
        settings={"accuracy": _MARGIN * accuracy},
        error=accuracy,
        why="the order is raised until a coarser solution agrees to a quarter of this",
    )


def _solve(model: SawModel, method: Method) -> SawAnswer:
    return solve_saw(model, accuracy=method.settings.get("accuracy", _FINEST))


def _distance(answer: SawAnswer, reference: SawAnswer) -> float:
    found = [
        float(np.max(np.abs(answer.sides[side].frequencies_Hz / other.frequencies_Hz - 1.0)))
        for side, other in reference.sides.items()
    ]
    if answer.wheel_utilisation is not None and reference.wheel_utilisation is not None:
        found.append(_relative(answer.wheel_utilisation, reference.wheel_utilisation))
    return max(found)


def _relative(values: FloatArray, reference: FloatArray) -> float:
    """Return the largest relative difference where there is one: a wheel that pulls nothing needs no grip."""
    differs = values != reference
    share = np.divide(values, reference, out=np.full_like(values, np.inf), where=differs & (reference != 0.0))
    return float(np.max(np.where(differs, np.abs(share - 1.0), 0.0)))


SYSTEM: System[SawProblem, SawModel, SawAnswer] = System(
    name="bandsaw", effects=EFFECTS, bare=bare, method=_method, solve=_solve, distance=_distance
)
"""A blade on two wheels."""
