"""Residuals of the force that was measured: the lift force, or, where a known weight is lifted, the end tension.

Where the load is set and the slack side is measured, ln F_A has no scatter at all, and a law that answers the
same F_A whatever the end tension would seem perfect. Such a law says nothing of the force that was measured, and
dividing by ∂ ln F_A/∂ ln F_B shows it.
"""

from typing import Literal

import numpy as np
from scipy.optimize import least_squares

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.fitting.levenberg import batched_fit
from ropefric.fitting.problem import FitProblem
from ropefric.friction.condition import distinct
from ropefric.trials.table import TrialTable

Measured = Literal["lift", "end-tension"]

_NO_ANSWER = 1e3
_MAX_EVALUATIONS = 100


def measured_force(table: TrialTable) -> Measured:
    """Return which force of a table was measured: the one that takes more values."""
    used = table.used
    set_lift = distinct(table.peak_N[used]).size < distinct(table.end_tension_N[used]).size
    return "end-tension" if set_lift else "lift"


def measured_residual(problem: FitProblem, theta: FloatArray, measured: Measured) -> FloatArray:
    """Return model less measurement in the logarithm of the measured force, shape (n,) or (m, n).

    For the end tension it is −(ln F_A − measured)/(∂ ln F_A/∂ ln F_B), to first order.
    """
    residual = problem.law.log_lift(theta, problem.conditions) - problem.log_lift
    if measured == "lift" or "end-tension" not in problem.law.effects:
        return residual
    slope = problem.law.log_lift_gradient_conditions(theta, problem.conditions)[..., 2]
    # A slope of zero leaves the end tension open, however small the residual.
    return np.asarray(residual / np.maximum(slope, 1e-12))


def refit(
    problem: FitProblem, theta: FloatArray, *, measured: Measured, multiplicity: FloatArray | None = None
) -> tuple[FloatArray, BoolArray]:
    """Return the least-squares parameters in the measured force, and whether the search converged."""
    if measured == "lift" or "end-tension" not in problem.law.effects:
        found = batched_fit(problem, starts=theta, multiplicity=multiplicity)
        at = np.where(np.isfinite(found.chi2)[:, np.newaxis], found.theta, theta)
        return (at[0], found.converged[0]) if multiplicity is None else (at, found.converged)
    counts = np.ones((1, problem.n_points)) if multiplicity is None else multiplicity
    fits = [_end_tension_fit(problem, theta, count, fresh=multiplicity is None) for count in counts]
    at, converged = np.stack([fit[0] for fit in fits]), np.array([fit[1] for fit in fits])
    return (at[0], converged[0]) if multiplicity is None else (at, converged)


def _end_tension_fit(
    problem: FitProblem, theta: FloatArray, count: FloatArray, *, fresh: bool
) -> tuple[FloatArray, bool]:
    free, weight = problem.vary, np.sqrt(count) / problem.std
    if not free.any():
        return theta, True

    def full(part: FloatArray) -> FloatArray:
        whole = theta.copy()
        whole[free] = part
        return whole

    def residuals(part: FloatArray) -> FloatArray:
        try:
            return np.asarray(measured_residual(problem, full(part), "end-tension") * weight)
        except InputError:
            return _NO_ANSWER * weight

    low, high = problem.lower[free], problem.upper[free]
    margin = 1e-9 * (high - low)
    # A fit of ln F_A may have gone to where F_A does not depend on F_B, from which no gradient leads back.
    declared = np.array([parameter.start for parameter in problem.law.parameters])
    best = None
    for start in (theta, declared) if fresh else (theta,):
        begin = np.clip(start[free], low + margin, high - margin)
        found = least_squares(
            residuals,
            begin,
            bounds=(low, high),
            x_scale=np.maximum(np.abs(begin), 1e-3),
            max_nfev=_MAX_EVALUATIONS,
        )
        if best is None or found.cost < best.cost:
            best = found
    assert best is not None  # noqa: S101  (at least one start was tried)
    return full(best.x), bool(best.success)
