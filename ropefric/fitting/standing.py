"""How a fitted law stands on the condition means: refit there, judged by likelihood, with each mean left out."""

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.fitting.criteria import ConditionMeans, ScatterFit, aicc, bic, f_test, scatter_fit
from ropefric.fitting.measured import Measured, measured_residual, refit
from ropefric.fitting.problem import FitProblem

# Weights and parameters depend on each other only where conditions have unequal numbers of repeats.
_ROUNDS = 4


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Standing:
    """A law fitted to condition means."""

    problem: FitProblem
    theta: FloatArray
    measured: Measured
    scatter: ScatterFit
    chi2: float
    k: int
    aicc: float
    bic: float

    def log_lift(self) -> FloatArray:
        """Return ln F_A of the law at the means, shape (K,)."""
        return self.problem.law.log_lift(self.theta, self.problem.conditions)


def on_means(problem: FitProblem, means: ConditionMeans, std: FloatArray) -> FitProblem:
    """Return a law's problem with one point per condition."""
    return replace(
        problem, conditions=means.conditions, log_lift=means.log_lift, std=std, group=np.arange(len(means))
    )


def standing(
    problem: FitProblem, means: ConditionMeans, theta: npt.ArrayLike, *, measured: Measured = "lift"
) -> Standing:
    """Return how the law of a problem stands on condition means."""
    at = np.asarray(theta, dtype=np.float64)
    std = means.std
    for _ in range(_ROUNDS):
        at = refit(on_means(problem, means, std), at, measured=measured)[0]
        residual = measured_residual(on_means(problem, means, std), at, measured)
        scatter = scatter_fit(residual, means)
        std = np.sqrt(scatter.variance)
        if not means.repeated or float(np.ptp(means.std)) <= 1e-9 * float(means.std[0]):
            break
    K, k = len(means), problem.n_varying + 1
    return Standing(
        problem=on_means(problem, means, std),
        theta=at,
        measured=measured,
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
    theta, converged = refit(problem, law.theta, measured=law.measured, multiplicity=1.0 - np.eye(K))
    if not (converged & problem.law.admissible(theta, problem.conditions)).all():
        return math.nan
    missed = np.diagonal(measured_residual(problem, theta, law.measured))
    return float(np.sqrt(np.mean(missed**2)))


def nested_test(simpler: Standing, fuller: Standing) -> tuple[float, tuple[int, int], float] | None:
    """Return F, degrees of freedom and p-value, both laws weighted as the fuller; None without degrees of freedom.

    Where the simpler law lies on a bound of the fuller (a = 0), the p-value is too large rather than too small.
    """
    n, p_simpler, p_fuller = fuller.problem.n_points, simpler.problem.n_varying, fuller.problem.n_varying
    if n <= p_fuller or p_fuller <= p_simpler:
        return None
    weighted = replace(simpler.problem, std=fuller.problem.std)
    at = refit(weighted, simpler.theta, measured=simpler.measured)[0]
    chi2 = float((measured_residual(weighted, at, simpler.measured) ** 2 / weighted.std**2).sum())
    return f_test(chi2, fuller.chi2, n=n, p_simpler=p_simpler, p_fuller=p_fuller)
