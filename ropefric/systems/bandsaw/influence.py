"""How much each effect of a saw can change an answer at most, before anything is simulated.

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
import numpy.typing as npt

from ropefric.friction.condition import FloatArray
from ropefric.systems.bandsaw.ends import CLAMPED
from ropefric.systems.bandsaw.problem import SawProblem
from ropefric.systems.bound import worst_case

__all__ = ["answerable", "bending_bound", "bounded", "difference_bound", "travel_bound", "wheels_bound"]

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


def answerable(problem: SawProblem) -> npt.NDArray[np.bool_]:
    """Return for which of m cases both sides are tight and slower than their critical speed, shape (m,).

    Examples
    --------
    >>> answerable(SawProblem(free_span_m=1.6, linear_density_kg_m=0.6, preload_N=3412.0, n_modes=1,
    ...     wheel_radius_m=0.35, wheel_speed_rad_s=[100.0, 300.0])).tolist()
    [True, False]
    """
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
