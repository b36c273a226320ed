"""How much ln F_A scatters between repeats of a condition, and between conditions, about a fitted law."""

from dataclasses import dataclass

import numpy as np

from ropefric.fitting.problem import FitProblem
from ropefric.friction.condition import FloatArray

__all__ = ["TwoLevelScatter", "two_level_scatter"]


@dataclass(frozen=True, slots=True, kw_only=True)
class TwoLevelScatter:
    """Two levels of scatter of ln F_A.

    Attributes
    ----------
    within : float
        Standard deviation between repeats of one condition [-].
    between : float
        Standard deviation of what all repeats of a condition share [-]: its rope, its mounting, what the law leaves
        out.
    """

    within: float
    between: float


def two_level_scatter(problem: FitProblem, theta: FloatArray) -> TwoLevelScatter:
    """Return the scatter of the residuals at two levels, by analysis of variance.

    Parameters
    ----------
    problem : FitProblem
        n points in k conditions, p fitted parameters; all points count alike, whatever their std.
    theta : ndarray, shape (p,)
        The fitted parameters.

    Returns
    -------
    TwoLevelScatter
        With MSW the mean square within (n − k degrees of freedom) and MSB that of the condition means about the law
        (k − p): within² = MSW, between² = max(0, (MSB − MSW)/n̄), n̄ = (n − Σ nᵢ²/n)/(k − 1). Without repeats, or with
        no more conditions than parameters, the levels cannot be told apart: all is called within.

    Examples
    --------
    >>> from ropefric.friction.condition import Conditions
    >>> from ropefric.friction.laws import LAWS
    >>> pulls = Conditions(wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=[3, 3, 6, 6], end_tension_N=20)
    >>> law, one = LAWS["constant"], np.ones(4)
    >>> problem = FitProblem(
    ...     law=law, conditions=pulls, log_lift=law.log_lift([0.2], pulls) + [0.11, 0.09, -0.09, -0.11], std=one,
    ...     group=np.array([0, 0, 1, 1]), start=np.array([0.2]), lower=law.lower, upper=law.upper,
    ...     vary=np.array([True]),
    ... )
    >>> found = two_level_scatter(problem, np.array([0.2]))
    >>> round(found.within, 4), round(found.between, 4)
    (0.0141, 0.1411)
    """
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
