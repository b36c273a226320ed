"""The effects a band saw's blade may be simulated with, and how much each can matter at most.

For a string ln f = ln(F − ρA v²) − ½ ln F and what does not depend on the effects, so the largest change over the
corners (each tension with or without the torque's and the wheels' part, each speed with or without the travel) bounds
every effect but the stiffness. A stiff blade is less sensitive to tension and speed than a string, as part of its
restoring force depends on neither.

Where the scene asks for the wheel's grip as well, its utilisation U = ΔF/((F_slack − ρA v²)(e^M − 1)) is bounded over
the same corners: without the difference there is none, and the stiffness has no part in it.
"""

import math
from collections.abc import Callable, Iterator
from itertools import product

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.registry import Registry
from ropefric.systems.bandsaw.answer import SawAnswer, SawModel, SawProblem, solve_saw
from ropefric.systems.effect import Effect, Method, System, missing, worst_case

Bound = Callable[[SawProblem], FloatArray]

_ROUNDING = 1e-11


def answerable(problem: SawProblem) -> BoolArray:
    """Return for which of m cases both sides are tight and slower than their critical speed, shape (m,)."""
    slack_N = problem.preload_N - problem.pull_N + problem.wheels_N
    stiff_N = np.zeros(problem.m)
    if problem.bending_stiffness_N_m2 is not None:
        stiff_N = problem.ends.buckling * problem.bending_stiffness_N_m2 / problem.free_span_m**2
    return np.asarray((slack_N > 0.0) & (slack_N - problem.inertia_N + stiff_N > 0.0))


def _log_frequency(tension_N: FloatArray, inertia_N: FloatArray | float) -> FloatArray:
    """Return ln(F − ρA v²) − ½ ln F; NaN for a slack or too fast blade."""
    return np.log(tension_N - inertia_N) - 0.5 * np.log(tension_N)


def _travels(problem: SawProblem) -> tuple[FloatArray, FloatArray]:
    return 0.0 * problem.inertia_N, problem.inertia_N


def _tensions(problem: SawProblem) -> Iterator[FloatArray]:
    for pull, wheels in product((-1.0, 0.0, 1.0), (0.0, 1.0)):
        yield problem.preload_N + pull * problem.pull_N + wheels * problem.wheels_N


def _asks_for_grip(problem: SawProblem) -> bool:
    """Return whether the answer says how much of the wheel's friction the drive needs."""
    return problem.knows_grip and bool(problem.pull_N.any())


def _log_grip(problem: SawProblem, wheels: float, travels: float) -> FloatArray:
    """Return ln of what U varies with, −ln((F_slack − ρA v²)(e^M − 1)); NaN where the slack side presses nothing."""
    slack_N = problem.preload_N - problem.pull_N + wheels * problem.wheels_N
    pressing_N = slack_N - travels * problem.inertia_N
    exponent = problem.grip_exponent(np.where(pressing_N > 0.0, pressing_N, 1.0))
    return -np.log(pressing_N) - exponent - np.log(-np.expm1(-exponent))


def difference_bound(problem: SawProblem) -> FloatArray:
    """Return the largest change of ln f by ±ΔF/2."""
    changes = [np.where(_asks_for_grip(problem) & (problem.pull_N > 0.0), np.inf, 0.0)]
    for wheels, inertia_N, sign in product((0.0, 1.0), _travels(problem), (-1.0, 1.0)):
        base_N = problem.preload_N + wheels * problem.wheels_N
        pulled_N = base_N + sign * problem.pull_N
        changes.append(np.abs(_log_frequency(pulled_N, inertia_N) - _log_frequency(base_N, inertia_N)))
    return np.asarray(np.max(changes, axis=0))


def wheels_bound(problem: SawProblem) -> FloatArray:
    """Return the largest change of ln f by κ ρA v²."""
    changes = [np.zeros(problem.m)]
    for pull, inertia_N in product((-1.0, 0.0, 1.0), _travels(problem)):
        base_N = problem.preload_N + pull * problem.pull_N
        pressed_N = base_N + problem.wheels_N
        changes.append(np.abs(_log_frequency(pressed_N, inertia_N) - _log_frequency(base_N, inertia_N)))
    if _asks_for_grip(problem):
        changes += [np.abs(_log_grip(problem, 1.0, way) - _log_grip(problem, 0.0, way)) for way in (0.0, 1.0)]
    return np.asarray(np.max(changes, axis=0))


def travel_bound(problem: SawProblem) -> FloatArray:
    """Return the largest change of ln f by the travel, −ln(1 − v²/c²)."""
    changes = [_log_frequency(F, 0.0) - _log_frequency(F, problem.inertia_N) for F in _tensions(problem)]
    if _asks_for_grip(problem):
        changes += [
            np.abs(_log_grip(problem, held, 1.0) - _log_grip(problem, held, 0.0)) for held in (0.0, 1.0)
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
        return np.zeros(problem.m)
    n = float(problem.n_modes)
    worst = np.zeros(problem.m)
    for tension_N in _tensions(problem):
        e = np.sqrt(problem.bending_stiffness_N_m2 / (tension_N * problem.free_span_m**2))
        for inertia_N in _travels(problem):
            V2 = inertia_N / tension_N
            layers = 2.0 * e / np.sqrt(1.0 - V2) if not problem.ends.turns else np.zeros(problem.m)
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


def _effect(
    name: str, adds: str, instead: str, needs: tuple[str, ...], *, bound: Bound | None, cost: float = 0.05
) -> Effect[SawProblem, SawModel]:
    """Return an effect with the largest of a bound over all cases; `inf` where a blade is slack or too fast."""
    return Effect(
        name=name,
        adds=adds,
        instead=instead,
        needs=missing({field: _KEYS[field] for field in needs}),
        influence=worst_case(bound, rounding=_ROUNDING) if bound else lambda problem: 0.0,  # noqa: ARG005
        cost=cost,
    )


EFFECTS: Registry[Effect[SawProblem, SawModel]] = Registry(
    "effect of a band saw",
    (
        _effect(
            "tension-difference",
            "half the pull of the saw's torque on the tight side, and less on the slack side",
            "the preload on both sides",
            ("tension_difference_N",),
            bound=difference_bound,
        ),
        _effect(
            "wheel-inertia-tension",
            "the tension kappa rho A v^2 by which wheels that may give way follow the running blade",
            "wheel axles that do not give way",
            ("mounting_factor", "wheel_radius_m", "wheel_speed_rad_s"),
            bound=wheels_bound,
        ),
        _effect(
            "travel",
            "the motion of the blade through its span, which its waves run with and against",
            "a blade that stands still",
            ("wheel_radius_m", "wheel_speed_rad_s"),
            bound=travel_bound,
        ),
        _effect(
            "bending",
            "the blade's stiffness EI, with a boundary layer at held ends",
            "a string",
            ("bending_stiffness_N_m2",),
            bound=bending_bound,
            cost=50.0,
        ),
        _effect(
            "torsion",
            "the frequencies of twisting, beside those of bending",
            "no frequencies of twisting; those of bending do not depend on them",
            ("section",),
            bound=None,
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
    stiffness = model.problem.bending_stiffness_N_m2
    if "bending" not in model.effects or stiffness is None or not stiffness.any():
        return _CLOSED_FORM
    accuracy = min(max(budget, _FINEST), _COARSEST)
    return Method(
        name="spectral elements",
        settings={"accuracy": _MARGIN * accuracy},
        error=accuracy,
        why="the order is raised until a coarser solution agrees to a quarter of this",
    )


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
    name="bandsaw",
    effects=EFFECTS,
    bare=lambda problem: SawModel(problem=problem),
    method=_method,
    solve=lambda model, method: solve_saw(model, accuracy=method.settings.get("accuracy", _FINEST)),
    distance=_distance,
)
"""A blade on two wheels."""
