"""Whether what a law leaves over follows the conditions: lack of fit, and trends in wrap, size and load."""

from dataclasses import dataclass
from math import nan, sqrt

import numpy as np
from scipy.special import fdtrc

from ropefric.arrays import FloatArray, IntArray
from ropefric.fitting.weights import Scatter, group_means
from ropefric.friction.condition import Conditions, distinct

_SAME = 1e-9
# Where there is no scatter at all, what is left over is rounding and where the search stopped: no trend.
_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class LackOfFit:
    """What the conditions scatter beyond their repeats."""

    between: float
    p_value: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Trend:
    """Residuals that follow a regressor."""

    regressor: str
    size: float
    p_value: float


def lack_of_fit(
    jacobian: FloatArray, log_residuals: FloatArray, std: FloatArray, group: IntArray, scatter: Scatter
) -> LackOfFit:
    """Return the scatter between conditions by the method of moments, and its F-test against the repeats.

    Q = Σ w_c r̄_c² over the conditions, w_c the inverse variance of a mean, has the expectation
    k − q + s_b² Σ w_c (1 − h_c).
    """
    k, q = int(group.max(initial=-1)) + 1, jacobian.shape[1]
    if not scatter.known or k <= q:
        return LackOfFit(between=nan, p_value=nan)
    weight = np.bincount(group, 1.0 / std**2)
    excess = float(weight @ group_means(log_residuals, group) ** 2)
    leverage = np.bincount(group, (_basis(jacobian) ** 2).sum(axis=1), k)
    variance = (excess - (k - q)) / float(weight @ (1.0 - np.minimum(leverage, 1.0)))
    p_value = float(fdtrc(k - q, scatter.dof, excess / (k - q)))
    return LackOfFit(between=sqrt(max(variance, 0.0)), p_value=p_value)


def find_trends(
    jacobian: FloatArray, log_residuals: FloatArray, std: FloatArray, group: IntArray, conditions: Conditions
) -> tuple[Trend, ...]:
    """Return how far the means of the conditions follow each regressor, the surest first.

    Linear and quadratic terms of the regressor are fitted beside the law's own parameters to the means of the
    conditions and tested (F) against what is left between conditions, so that a scatter between conditions alone
    makes no trend. A regressor with fewer than three values gets the linear term alone.
    """
    k = int(group.max(initial=-1)) + 1
    weight = np.sqrt(np.bincount(group, 1.0 / std**2))
    means = group_means(log_residuals, group)
    columns = [group_means(column * std, group) * weight for column in jacobian.T]
    own = np.stack(columns, axis=-1) if columns else np.zeros((k, 0))
    regressors = {
        "wrap angle": conditions.wrap_angle_rad,
        "size ratio": conditions.size_ratio,
        "end tension": conditions.log_end_tension,
    }
    trends = [
        _trend(name, group_means(values, group), own, means, weight) for name, values in regressors.items()
    ]
    return tuple(sorted((trend for trend in trends if trend is not None), key=lambda trend: trend.p_value))


def _trend(
    name: str, values: FloatArray, own: FloatArray, means: FloatArray, weight: FloatArray
) -> Trend | None:
    spread = np.ptp(values) if values.size else 0.0
    if spread <= _SAME * np.abs(values).max(initial=1.0):
        return None
    x = (values - values.mean()) / spread
    powers = 1 if distinct(x + 2.0).size < 3 else 2
    extra = np.stack([x ** (power + 1) for power in range(powers)], axis=-1) * weight[:, None]
    # Only what the law's own parameters cannot take up counts.
    basis = _basis(own)
    extra = _basis(extra - basis @ (basis.T @ extra), np.linalg.norm(extra, axis=0).max())
    left = weight * means
    left = left - basis @ (basis.T @ left)
    explained = extra.T @ left
    dof = values.size - basis.shape[1] - extra.shape[1]
    rest = float(left @ left - explained @ explained)
    if not extra.shape[1] or dof < 1 or rest <= 0.0:
        return None
    ratio = float(explained @ explained) / extra.shape[1] / (rest / dof)
    size = sqrt(float(np.mean((extra @ explained / weight) ** 2)))
    if size < _ROUNDING:
        return None
    return Trend(regressor=name, size=size, p_value=float(fdtrc(extra.shape[1], dof, ratio)))


def _basis(columns: FloatArray, scale: float = 0.0) -> FloatArray:
    """Return orthonormal columns that span the given ones, without those that are only rounding."""
    if not columns.shape[1]:
        return columns
    length = np.linalg.norm(columns, axis=0)
    length = np.maximum(np.where(length > 0.0, length, 1.0), scale)
    left, values, _ = np.linalg.svd(columns / length, full_matrices=False)
    return np.asarray(left[:, values > _SAME * max(values.max(initial=0.0), 1.0)])
