"""How much ln F_A scatters between repeats of a condition, and between conditions, about a fitted law."""

from dataclasses import dataclass

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.fitting.problem import FitProblem


@dataclass(frozen=True, slots=True, kw_only=True)
class TwoLevelScatter:
    """Two levels of scatter of ln F_A."""

    within: float
    between: float


def two_level_scatter(problem: FitProblem, theta: FloatArray) -> TwoLevelScatter:
    """Return the scatter of the residuals at two levels, by analysis of variance."""
    residual = problem.log_lift - problem.law.log_lift(theta, problem.conditions)
    labels, group, size = np.unique(problem.group, return_inverse=True, return_counts=True)
    n, k, p = residual.size, labels.size, problem.n_varying
    mean = np.bincount(group, weights=residual) / size
    if n == k or k <= max(p, 1):
        return TwoLevelScatter(within=float(np.sqrt((residual**2).sum() / max(n - p, 1))), between=0.0)
    within2 = ((residual - mean[group]) ** 2).sum() / (n - k)
    between_square = (size * mean**2).sum() / (k - p)
    typical_size = (n - (size**2).sum() / n) / (k - 1)
    between2 = max(0.0, (between_square - within2) / typical_size)
    return TwoLevelScatter(within=float(np.sqrt(within2)), between=float(np.sqrt(between2)))
