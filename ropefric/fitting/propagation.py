"""From the covariance of a law's parameters to the uncertainty of ln F_A: J C Jᵀ, and draws that check it."""

from dataclasses import dataclass

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.friction.condition import Conditions
from ropefric.friction.law import FrictionLaw
from ropefric.friction.lift import log_lift_moving
from ropefric.uncertainty.quantity import joint_draws, quantile, symmetric_root

# Draws times conditions held in memory at once.
_BLOCK = 1_000_000
_ONE_SIGMA = 0.8413447460685429


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LiftModel:
    """A law and how fast its rope runs: ln F_A and its gradient, at rest or moving."""

    law: FrictionLaw
    linear_density_kg_m: float = 0.0
    speed_m_s: float = 0.0

    @property
    def inertia_N(self) -> float:
        """Return ρv² [N]."""
        return self.linear_density_kg_m * self.speed_m_s**2

    def log_lift(self, theta: FloatArray, conditions: Conditions) -> FloatArray:
        """Return ln(F_A / 1 N), shape (n,) or (m, n)."""
        if self.inertia_N == 0.0:
            return self.law.log_lift(theta, conditions)
        return log_lift_moving(
            self.law,
            theta,
            conditions,
            linear_density_kg_m=self.linear_density_kg_m,
            speed_m_s=self.speed_m_s,
        )

    def jacobian(self, theta: FloatArray, conditions: Conditions) -> FloatArray:
        """Return ∂ ln F_A/∂θ, shape (n, p) or (m, n, p); only F_A − ρv² depends on the parameters."""
        if self.inertia_N == 0.0:
            return self.law.jacobian(theta, conditions)
        share = -np.expm1(np.log(self.inertia_N) - self.log_lift(theta, conditions))
        return np.asarray(self.law.jacobian(theta, self.pressing(conditions)) * share[..., np.newaxis])

    def pressing(self, conditions: Conditions) -> Conditions:
        """Return the conditions with F_B − ρv², the part of the end tension that presses on the wheel."""
        left_N = conditions.end_tension_N - self.inertia_N
        if not (left_N > 0.0).all():
            raise InputError(
                f"rho v^2 = {self.inertia_N:.6g} N is not below F_B at "
                f"{conditions.describe(int(np.argmin(left_N)))}: the rope lifts off the wheel",
                code="RF420",
                fix="raise the end tension or lower the speed",
            )
        return Conditions(
            wheel_radius_m=conditions.wheel_radius_m,
            rope_radius_m=conditions.rope_radius_m,
            wrap_angle_rad=conditions.wrap_angle_rad,
            end_tension_N=left_N,
        )


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
