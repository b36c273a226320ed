"""What Gauss-Newton leaves out, learnt from the steps themselves: the second derivatives of the model."""

import numpy as np
import numpy.typing as npt

from ropefric.fitting.bounded_step import column_scale
from ropefric.friction.condition import FloatArray

__all__ = ["learnt_curvature", "usable"]

# A secant update divides by vᵀs; where that nearly vanishes it says nothing.
_SKIP = 1e-8
# The least part of JᵀJ that must remain in every direction.
_REMAINS = 0.05
_POSITIVE = 1e-11


def learnt_curvature(
    curvature: FloatArray, normal: FloatArray, step: FloatArray, change: FloatArray
) -> FloatArray:
    """Return S after a step, so that JᵀJ + S explains how the gradient changed over it.

    Parameters
    ----------
    curvature : ndarray, shape (m, p, p)
        S before.
    normal : ndarray, shape (m, p, p)
        JᵀJ at the new place.
    step : ndarray, shape (m, p)
        s.
    change : ndarray, shape (m, p)
        Change of the gradient Jᵀr over the step.

    Returns
    -------
    ndarray, shape (m, p, p)
        S + v vᵀ/(vᵀs) with v = change − (JᵀJ + S) s, the symmetric rank-one update (Nocedal & Wright, eq. 6.24);
        unchanged where vᵀs is too small to divide by.

    Examples
    --------
    >>> one = np.ones((1, 1, 1))
    >>> learnt_curvature(0 * one, 2 * one, np.array([[0.5]]), np.array([[1.5]])).tolist()
    [[[1.0]]]
    """
    v = change - np.einsum("mij,mj->mi", normal + curvature, step)
    along = np.einsum("mi,mi->m", v, step)
    size = np.sqrt((v**2).sum(axis=1) * (step**2).sum(axis=1))
    good = np.abs(along) > _SKIP * size
    update = v[:, :, np.newaxis] * v[:, np.newaxis, :] / np.where(good, along, 1.0)[:, np.newaxis, np.newaxis]
    return np.where(good[:, np.newaxis, np.newaxis], curvature + update, curvature)


def usable(normal: FloatArray, curvature: FloatArray) -> npt.NDArray[np.bool_]:
    """Return where JᵀJ + S is safely positive definite, shape (m,): elsewhere a step might lead uphill.

    Examples
    --------
    >>> one = np.ones((1, 1, 1))
    >>> usable(one, -0.5 * one).tolist(), usable(one, -0.99 * one).tolist()
    ([True], [False])
    """
    scale = column_scale(normal + curvature)
    units = scale[:, :, np.newaxis] * scale[:, np.newaxis, :]
    remains = ((1.0 - _REMAINS) * normal + curvature) / units
    return np.asarray(np.linalg.eigvalsh(remains)[:, 0] > _POSITIVE)
