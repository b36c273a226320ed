"""What Gauss-Newton leaves out, learnt from the steps themselves: the second derivatives of the model."""

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.fitting.bounded_step import column_scale

# A secant update divides by vᵀs; where that nearly vanishes it says nothing.
_SKIP = 1e-8
# The least part of JᵀJ that must remain in every direction.
_REMAINS = 0.05
_POSITIVE = 1e-11


def learnt_curvature(
    curvature: FloatArray, normal: FloatArray, step: FloatArray, change: FloatArray
) -> FloatArray:
    """Return S after a step, so that JᵀJ + S explains how the gradient changed over it."""
    v = change - np.einsum("mij,mj->mi", normal + curvature, step)
    along = np.einsum("mi,mi->m", v, step)
    size = np.sqrt((v**2).sum(axis=1) * (step**2).sum(axis=1))
    good = np.abs(along) > _SKIP * size
    update = v[:, :, np.newaxis] * v[:, np.newaxis, :] / np.where(good, along, 1.0)[:, np.newaxis, np.newaxis]
    return np.where(good[:, np.newaxis, np.newaxis], curvature + update, curvature)


def usable(normal: FloatArray, curvature: FloatArray) -> BoolArray:
    """Return where JᵀJ + S is safely positive definite, shape (m,): elsewhere a step might lead uphill."""
    scale = column_scale(normal + curvature)
    units = scale[:, :, np.newaxis] * scale[:, np.newaxis, :]
    remains = ((1.0 - _REMAINS) * normal + curvature) / units
    return np.asarray(np.linalg.eigvalsh(remains)[:, 0] > _POSITIVE)
