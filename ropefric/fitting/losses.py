"""Loss functions of a residual: how much an outlier may pull."""

from typing import Literal

import numpy as np

from ropefric.arrays import FloatArray

Loss = Literal["linear", "soft_l1", "huber", "cauchy", "arctan"]

LOSSES: tuple[Loss, ...] = ("linear", "soft_l1", "huber", "cauchy", "arctan")
"""Loss functions of a residual in standard deviations; all but the first give outliers less weight."""


def loss_cost(residuals: FloatArray, loss: Loss) -> float:
    """Return the sum of a loss over residuals in standard deviations; χ² for the linear one."""
    z = residuals**2
    if loss == "soft_l1":
        z = 2.0 * (np.sqrt(1.0 + z) - 1.0)
    elif loss == "huber":
        z = np.where(z <= 1.0, z, 2.0 * np.sqrt(z) - 1.0)
    elif loss == "cauchy":
        z = np.log1p(z)
    elif loss == "arctan":
        z = np.arctan(z)
    return float(z.sum())


def loss_weights(residuals: FloatArray, loss: Loss) -> FloatArray:
    """Return the weight a loss leaves each squared residual, 1 for all with the linear loss."""
    z = residuals**2
    if loss == "soft_l1":
        return np.asarray(1.0 / np.sqrt(1.0 + z))
    if loss == "huber":
        return np.asarray(1.0 / np.sqrt(np.maximum(z, 1.0)))
    if loss == "cauchy":
        return np.asarray(1.0 / (1.0 + z))
    if loss == "arctan":
        return np.asarray(1.0 / (1.0 + z**2))
    return np.ones_like(z)
