"""From the covariance of a law's parameters to the uncertainty of ln F_A: J C Jᵀ, and draws that check it."""

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.friction.condition import Conditions
from ropefric.friction.law import LiftModel
from ropefric.uncertainty.quantity import joint_draws, quantile, symmetric_root

# Draws times conditions held in memory at once.
_BLOCK = 1_000_000
_ONE_SIGMA = 0.8413447460685429


def linear_std(
    model: LiftModel, theta: FloatArray, covariance: FloatArray, conditions: Conditions
) -> FloatArray:
    """Return the standard deviation of ln F_A of the mean law, √(J C Jᵀ), shape (n,)."""
    J = model.jacobian(theta, conditions)
    variance = ((J @ covariance) * J).sum(axis=-1)
    # Rounding may turn a variance of zero a hair negative; NaN stays NaN.
    return np.sqrt(np.where(variance < 0.0, 0.0, variance))


def drawn_range(
    model: LiftModel,
    theta: FloatArray,
    covariance: FloatArray,
    conditions: Conditions,
    *,
    dof: float,
    level: float,
    n: int,
    rng: np.random.Generator,
) -> tuple[FloatArray, FloatArray]:
    """Return the standard deviation (c,) and the interval (c, 2) of ln F_A for c conditions, from n draws.

    The parameters are drawn from the multivariate t of their covariance, moved onto the law's bounds where they
    cross them; the standard deviation is half the central 68.27 % of the draws, less the t's heavier tails.
    """
    if not np.isfinite(covariance).all():
        raise InputError(
            "the covariance of the parameters is not finite, so nothing can be drawn from it",
            key="covariance",
            fix="use method='linear', or a fit whose parameters are all seen by the data",
        )
    draws = joint_draws(theta, symmetric_root(covariance), dof=dof, n=n, rng=rng)
    draws = np.clip(draws, np.minimum(model.law.lower, theta), np.maximum(model.law.upper, theta))
    tail = 50.0 * (1.0 - level)
    at = [tail, 100.0 - tail, 100.0 * (1.0 - _ONE_SIGMA), 100.0 * _ONE_SIGMA]
    found = np.empty((4, len(conditions)))
    step = max(1, _BLOCK // n)
    for first in range(0, len(conditions), step):
        rows = np.arange(first, min(first + step, len(conditions)))
        part = conditions.select(rows)
        usable = draws[model.law.admissible(draws, model.pressing(part))]
        if 2 * len(usable) < n:
            raise InputError(
                f"{model.law.name} has no answer for {n - len(usable)} of {n} parameter sets drawn from its "
                f"covariance at {part.describe(0)}",
                code="RF420",
                fix="the fit is too uncertain for this method; measure more conditions",
            )
        found[:, rows] = np.percentile(model.log_lift(usable, part), at, axis=0)
    std = 0.5 * (found[3] - found[2]) / quantile(_ONE_SIGMA, dof)
    return std, found[:2].T.copy()
