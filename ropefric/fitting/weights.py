"""What each trial weighs: scatter of the repeats, what the instrument adds, and errors of the settings."""

from dataclasses import dataclass
from math import nan, sqrt

import numpy as np

from ropefric.arrays import FloatArray, IntArray
from ropefric.errors import InputError
from ropefric.friction.law import FrictionLaw
from ropefric.trials.table import TrialTable

# Repeats that agree closer than this were not measured, or were copied.
_SMALLEST_SCATTER = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Scatter:
    """How far repeats of one condition lie apart."""

    within: float
    dof: int

    @property
    def known(self) -> bool:
        """Return whether there are repeats that scatter."""
        return self.dof > 0 and self.within > _SMALLEST_SCATTER


def group_means(values: FloatArray, group: IntArray) -> FloatArray:
    """Return the mean of each condition, shape (k,)."""
    return np.bincount(group, weights=values) / np.bincount(group)


def pooled_scatter(residuals: FloatArray, group: IntArray) -> Scatter:
    """Return the scatter of residuals in ln F_A about the mean of their condition, pooled over conditions.

    The scatter of a rope is a part of the force, so it is the same in ln F_A for all conditions.
    """
    dof = residuals.size - int(group.max(initial=-1)) - 1
    if dof <= 0:
        return Scatter(within=nan, dof=0)
    about = residuals - group_means(residuals, group)[group]
    return Scatter(within=sqrt(float(about @ about) / dof), dof=dof)


def shared_variance(law: FrictionLaw, theta: FloatArray, table: TrialTable) -> FloatArray:
    """Return the variance of ln F_A that all repeats of a condition share, shape (n,).

    The instrument's (u_F/F_A)² and those of the settings, (∂ ln F_A/∂φ u_φ)² + (∂ ln F_A/∂R_w u_R)² +
    (∂ ln F_A/∂ ln F_B · u_{F_B}/F_B)²: a wheel, a weight and a force cell are the same for every repeat, so these
    do not average out over them.
    """
    used = table.used
    # What overflows is refused right after.
    with np.errstate(over="ignore", invalid="ignore"):
        chain = np.nan_to_num(table.peak_std_N[used] / table.peak_N[used])
        settings = np.stack(
            [
                table.wheel_radius_std_m[used],
                table.wrap_std_rad[used],
                table.end_tension_std_N[used] / table.end_tension_N[used],
            ],
            axis=-1,
        )
        variance: FloatArray = chain**2
        if settings.any():
            slopes = law.log_lift_gradient_conditions(theta, table.conditions())
            variance = variance + ((slopes * settings) ** 2).sum(axis=-1)
    wrong = ~np.isfinite(variance)
    if wrong.any():
        trial = np.array(table.trial)[used][int(np.argmax(wrong))]
        raise InputError(
            f"the uncertainties given for trial '{trial}' amount to more than any number of ln F_A",
            code="RF410",
            fix="correct the columns that end in _std",
        )
    return variance


def trial_std(within: float, shared: FloatArray, group: IntArray) -> FloatArray:
    """Return the standard deviation that a trial enters a least-squares fit with, shape (n,).

    σ² = s_w² + n_c u². Independent trials with this variance give the condition's mean the variance s_w²/n_c + u²,
    and so the same estimates and covariance as generalised least squares with the correlated covariance
    s_w² I + u² 1 1ᵀ, because a law is constant over the repeats of a condition.
    """
    return np.sqrt(within**2 + np.bincount(group)[group] * shared)
