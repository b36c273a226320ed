"""Ranking of a law on condition means: its likelihood, each mean left out, and against a simpler law."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.fitting import statistics as stats
from ropefric.fitting.problem import FitProblem, batched_fit

STRONG = 6.0
"""Difference of AICc from which on an effect is supported: it makes the data e^3 = 20 times likelier after its price."""

# Weights and parameters depend on each other only where conditions have unequal numbers of repeats.
_ROUNDS = 4
# A wild trial: so many standard deviations off the others, and once in so many tables by chance.
_FAR, _WILD = 8.0, 1e-4
# From so many conditions on, leaving one out is one step of the fit.
_MANY = 400
_LEAST_DOF, _EXACT = 5, 1e-6


class FTest(NamedTuple):
    """Whether a law's extra parameters explain more than chance."""

    simpler: str
    fuller: str
    f: float
    dof: tuple[int, int]
    p_value: float


class Standing(NamedTuple):
    """A law fitted to condition means."""

    problem: FitProblem
    theta: FloatArray
    scatter: stats.ScatterFit
    chi2: float
    k: int
    aicc: float
    bic: float


def wild_trial(problem: FitProblem, *, slack: bool) -> int | None:
    """Return which trial alone lies far off straight trends of μ with every setting; None if none does.

    By its deleted residual, in the scatter of all the others: what one trial does to the whole cannot hide it.
    """
    at, rise = problem.conditions, problem.log_lift - problem.conditions.log_end_tension
    wrap = at.wrap_angle_rad
    load = problem.log_lift if slack else at.log_end_tension
    levels = (np.exp(load - load.min()), at.size_ratio, np.maximum(wrap, 1e-9))
    trends = (np.log(level) * wrap for level in levels)
    svd = stats.decomposed(np.stack([wrap, np.ones_like(wrap), *trends], axis=-1))
    left = svd.left[:, ~svd.lost]
    residual, own = rise - left @ (left.T @ rise), 1.0 - (left**2).sum(axis=1)
    dof = rise.size - left.shape[1] - 1
    if dof < _LEAST_DOF or np.abs(residual).max() < _EXACT:
        return None
    worst, t, p_value = stats.furthest(residual, own, dof)
    return worst if t > _FAR and p_value < _WILD else None


def standing(problem: FitProblem, means: stats.ConditionMeans, theta: FloatArray) -> Standing:
    """Return the ranking of a law on condition means."""
    law, conditions, at, K = problem.law, means.conditions, theta, len(means)
    on_means = replace(
        problem, conditions=conditions, log_lift=means.log_lift, std=means.std, group=np.arange(K)
    )
    for _ in range(_ROUNDS):
        at = batched_fit(on_means, starts=at).theta[0]
        residual = law.log_lift(at, conditions) - means.log_lift
        scatter = stats.scatter_fit(residual, means)
        on_means = replace(on_means, std=np.sqrt(scatter.variance))
        if not means.repeated or float(np.ptp(means.std)) <= 1e-9 * float(means.std[0]):
            break
    k, deviance = problem.n_varying + 1, scatter.deviance
    chi2 = float((residual**2 / scatter.variance).sum())
    return Standing(on_means, at, scatter, chi2, k, stats.aicc(deviance, K, k), stats.bic(deviance, K, k))


def leave_one_out(law: Standing) -> float:
    """Return the leave-one-condition-out error: RMS of the ln F predicted by a fit to all other means, less measured.

    This is the relative error of the force at conditions the law has not seen. NaN where the other means cannot fix
    the parameters or a refit fails. K refits of K means grow as K²; of many, each is one
    step from the common fit, residual/(1 − leverage), which errs by the square of a leverage.
    """
    problem, K = law.problem, law.problem.n_points
    if K > _MANY:
        inside = problem.vary & (law.theta > problem.lower) & (law.theta < problem.upper)
        left = stats.decomposed(problem.jacobian(law.theta)[:, inside]).root()[1]
        own = problem.law.log_lift(law.theta, problem.conditions) - problem.log_lift
        return float(np.sqrt(np.mean((own / (1.0 - (left**2).sum(axis=1))) ** 2)))
    found = batched_fit(problem, starts=law.theta, multiplicity=1.0 - np.eye(K))
    if not (found.converged & problem.law.admissible(found.theta, problem.conditions)).all():
        return math.nan
    missed = np.diagonal(problem.law.log_lift(found.theta, problem.conditions) - problem.log_lift)
    return float(np.sqrt(np.mean(missed**2)))


def straight_fit(
    X: FloatArray, rise: FloatArray, means: stats.ConditionMeans
) -> tuple[FloatArray, stats.ScatterFit]:
    """Return the coefficients of columns, and the scatter of the means about them that makes them likeliest."""
    root = means.std
    for _ in range(_ROUNDS):
        theta = np.asarray(np.linalg.lstsq(X / root[:, None], rise / root, rcond=None)[0])
        scatter = stats.scatter_fit(X @ theta - rise, means)
        before, root = root, np.sqrt(scatter.variance)
        if (root == before).all():
            break
    return theta, scatter


def nested_test(simpler: Standing, fuller: Standing) -> FTest | None:
    """Return the test of two laws, both weighted as the fuller; None without degrees of freedom.

    Where the simpler law lies on a bound of the fuller (a = 0), the p-value is too large rather than too small.
    """
    n, p_simpler, p_fuller = fuller.problem.n_points, simpler.problem.n_varying, fuller.problem.n_varying
    if n <= p_fuller or p_fuller <= p_simpler:
        return None
    weighted = replace(simpler.problem, std=fuller.problem.std)
    chi2 = float(batched_fit(weighted, starts=simpler.theta).chi2[0])
    found = stats.f_test(chi2, fuller.chi2, n=n, p_simpler=p_simpler, p_fuller=p_fuller)
    return FTest(simpler.problem.law.name, fuller.problem.law.name, *found)
