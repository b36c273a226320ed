"""How a fitted law stands on the condition means: refit there, judged by likelihood, with each mean left out.

Residuals are those of the force that was measured: the lift force or, where a known weight is lifted, the end
tension. Where the load is set and the slack side is measured, ln F_A has no scatter at all, and a law that answers
the same F_A whatever the end tension would seem perfect. Such a law says nothing of the force that was measured, and
dividing by ∂ ln F_A/∂ ln F_B shows it.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.fitting.levenberg import batched_fit
from ropefric.fitting.problem import FitProblem
from ropefric.fitting.statistics import ConditionMeans, ScatterFit, aicc, bic, f_test, scatter_fit

# Weights and parameters depend on each other only where conditions have unequal numbers of repeats.
_ROUNDS = 4
_NO_ANSWER = 1e3
_MAX_EVALUATIONS = 100


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Standing:
    """A law fitted to condition means, in the lift force or in the end tension (`slack`)."""

    problem: FitProblem
    theta: FloatArray
    slack: bool
    scatter: ScatterFit
    chi2: float
    k: int
    aicc: float
    bic: float

    def log_lift(self) -> FloatArray:
        """Return ln F_A of the law at the means, shape (K,)."""
        return self.problem.law.log_lift(self.theta, self.problem.conditions)


def standing(
    problem: FitProblem, means: ConditionMeans, theta: npt.ArrayLike, *, slack: bool = False
) -> Standing:
    """Return how the law of a problem stands on condition means."""
    at, K = np.asarray(theta, dtype=np.float64), len(means)
    on_means = replace(
        problem, conditions=means.conditions, log_lift=means.log_lift, std=means.std, group=np.arange(K)
    )
    for _ in range(_ROUNDS):
        at = refit(on_means, at, slack=slack)[0][0]
        residual = measured_residual(on_means, at, slack=slack)
        scatter = scatter_fit(residual, means)
        on_means = replace(on_means, std=np.sqrt(scatter.variance))
        if not means.repeated or float(np.ptp(means.std)) <= 1e-9 * float(means.std[0]):
            break
    k = problem.n_varying + 1
    return Standing(
        problem=on_means,
        theta=at,
        slack=slack,
        scatter=scatter,
        chi2=float((residual**2 / scatter.variance).sum()),
        k=k,
        aicc=aicc(scatter.deviance, K, k),
        bic=bic(scatter.deviance, K, k),
    )


def leave_one_out(law: Standing) -> float:
    """Return the leave-one-condition-out error: RMS of the ln F predicted by a fit to all other means, less measured.

    This is the relative error of the force at conditions the law has not seen. NaN where the other means cannot fix
    the parameters (K ≤ number of parameters) or a refit fails.
    """
    problem, K = law.problem, law.problem.n_points
    if law.problem.n_varying >= K:
        return math.nan
    theta, converged = refit(problem, law.theta, slack=law.slack, multiplicity=1.0 - np.eye(K))
    if not (converged & problem.law.admissible(theta, problem.conditions)).all():
        return math.nan
    missed = np.diagonal(measured_residual(problem, theta, slack=law.slack))
    return float(np.sqrt(np.mean(missed**2)))


def nested_test(simpler: Standing, fuller: Standing) -> tuple[float, tuple[int, int], float] | None:
    """Return F, degrees of freedom and p-value, both laws weighted as the fuller; None without degrees of freedom.

    Where the simpler law lies on a bound of the fuller (a = 0), the p-value is too large rather than too small.
    """
    n, p_simpler, p_fuller = fuller.problem.n_points, simpler.problem.n_varying, fuller.problem.n_varying
    if n <= p_fuller or p_fuller <= p_simpler:
        return None
    weighted = replace(simpler.problem, std=fuller.problem.std)
    at = refit(weighted, simpler.theta, slack=simpler.slack)[0][0]
    chi2 = float((measured_residual(weighted, at, slack=simpler.slack) ** 2 / weighted.std**2).sum())
    return f_test(chi2, fuller.chi2, n=n, p_simpler=p_simpler, p_fuller=p_fuller)


def measured_residual(problem: FitProblem, theta: FloatArray, *, slack: bool) -> FloatArray:
    """Return model less measurement in the logarithm of the measured force, shape (n,) or (m, n).

    For the end tension it is −(ln F_A − measured)/(∂ ln F_A/∂ ln F_B), to first order.
    """
    residual = problem.law.log_lift(theta, problem.conditions) - problem.log_lift
    if not slack or "end-tension" not in problem.law.effects:
        return residual
    slope = problem.law.log_lift_gradient_conditions(theta, problem.conditions)[..., 2]
    # A slope of zero leaves the end tension open, however small the residual.
    return np.asarray(residual / np.maximum(slope, 1e-12))


def refit(
    problem: FitProblem, theta: FloatArray, *, slack: bool, multiplicity: FloatArray | None = None
) -> tuple[FloatArray, BoolArray]:
    """Return the parameters that fit the measured force best, shape (m, p), and whether each search converged."""
    if slack and "end-tension" in problem.law.effects and problem.vary.any():
        counts = np.ones((1, problem.n_points)) if multiplicity is None else multiplicity
        fits = [_end_tension_fit(problem, theta, count, fresh=multiplicity is None) for count in counts]
        return np.stack([fit[0] for fit in fits]), np.array([fit[1] for fit in fits])
    found = batched_fit(problem, starts=theta, multiplicity=multiplicity)
    return np.where(np.isfinite(found.chi2)[:, np.newaxis], found.theta, theta), found.converged


def _end_tension_fit(
    problem: FitProblem, theta: FloatArray, count: FloatArray, *, fresh: bool
) -> tuple[FloatArray, bool]:
    """Return the fit of residuals whose slopes no law states: by differences, with scipy."""
    free, weight = problem.vary, np.sqrt(count) / problem.std

    def full(part: FloatArray) -> FloatArray:
        whole = theta.copy()
        whole[free] = part
        return whole

    def residuals(part: FloatArray) -> FloatArray:
        try:
            return np.asarray(measured_residual(problem, full(part), slack=True) * weight)
        except InputError:
            return _NO_ANSWER * weight

    low, high = problem.lower[free], problem.upper[free]
    margin = 1e-9 * (high - low)
    # A fit of ln F_A may have gone to where F_A does not depend on F_B, from which no gradient leads back.
    declared = np.array([parameter.start for parameter in problem.law.parameters])
    begins = [
        np.clip(start[free], low + margin, high - margin)
        for start in ((theta, declared) if fresh else (theta,))
    ]
    best = min(
        (
            least_squares(
                residuals,
                begin,
                bounds=(low, high),
                x_scale=np.maximum(np.abs(begin), 1e-3),
                max_nfev=_MAX_EVALUATIONS,
            )
            for begin in begins
        ),
        key=lambda found: float(found.cost),
    )
    return full(best.x), bool(best.success)
