"""The covariance of fitted parameters: from known scatter, scaled, or clustered by condition."""

from math import floor, log10

import numpy as np

from ropefric.arrays import BoolArray, FloatArray, IntArray
from ropefric.files.digits import GIVEN_DIGITS, STD_DIGITS, significant
from ropefric.fitting.identifiability import NOT_SEEN, RANK_RATIO

# A condition that fixes a parameter alone has a leverage of 1 and no residual to judge it by.
_LARGEST_LEVERAGE = 0.999
# Decimals of a correlation beside those its smallest eigenvalue needs, and the most that rounding leaves any.
_DECIMALS = 3
_MOST_DECIMALS = 17


def bread(jacobian: FloatArray, weights: FloatArray | None = None) -> FloatArray:
    """Return (Jᵀ W J)⁻¹, shape (q, q), the pseudo-inverse where combinations of parameters are not seen."""
    q = jacobian.shape[1]
    if not q:
        return np.zeros((0, 0))
    half, _ = _root(jacobian if weights is None else jacobian * np.sqrt(weights)[:, None])
    return np.asarray(half @ half.T)


def unseen_part(jacobian: FloatArray) -> BoolArray:
    """Return which parameters belong to a combination that changes nothing, shape (q,)."""
    q = jacobian.shape[1]
    if not q:
        return np.zeros(0, dtype=bool)
    _, _, values, rows = _decomposed(jacobian)
    lost = values <= values.max(initial=0.0) / RANK_RATIO
    return np.asarray(np.abs(rows[lost]).max(axis=0, initial=0.0) > 1e-6)


def _root(jacobian: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return H with H Hᵀ = (JᵀJ)⁻¹ and U with J = U H⁻¹, over the combinations that are seen."""
    length, left, values, rows = _decomposed(jacobian)
    seen = values > values.max(initial=0.0) / RANK_RATIO
    return rows.T[:, seen] / values[seen] / length[:, None], left[: len(jacobian), seen]


def _decomposed(jacobian: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    q = jacobian.shape[1]
    length = np.linalg.norm(jacobian, axis=0)
    seen = length > NOT_SEEN
    length = np.where(seen, length, 1.0)
    scaled = np.vstack([np.where(seen, jacobian, 0.0) / length, np.zeros((max(q - len(jacobian), 0), q))])
    left, values, rows = np.linalg.svd(scaled, full_matrices=False)
    return length, left, values, rows


def clustered_covariance(
    jacobian: FloatArray, residuals: FloatArray, group: IntArray, weights: FloatArray | None = None
) -> FloatArray:
    """Return the sandwich covariance with the conditions as clusters, shape (q, q).

    Right whatever the trials of one condition share (a new rope, a weight, a wrap set once), as long as the
    conditions are independent.

    Bell & McCaffrey's (2002) CR2: each condition's part is divided by √(1 − h), h its leverage, which makes the
    estimate unbiased if the scatter is even; the simple factor k/(k − 1) leaves it too small by about q/k.
    """
    w = np.ones_like(residuals) if weights is None else weights
    if not jacobian.shape[1]:
        return np.zeros((0, 0))
    # In the combinations that are seen, and not in the parameters: where these can be traded for each other the
    # inverse of JᵀWJ is so large that products with it lose twice the digits.
    half, left = _root(jacobian * np.sqrt(w)[:, None])
    k = int(group.max(initial=-1)) + 1
    scores = np.zeros((k, half.shape[1]))
    np.add.at(scores, group, left * (np.sqrt(w) * residuals)[:, None])
    leverage = np.minimum(np.bincount(group, (left**2).sum(axis=1), k), _LARGEST_LEVERAGE)
    spread = half @ (scores / np.sqrt(1.0 - leverage)[:, None]).T
    return np.asarray(spread @ spread.T)


def rank_lost(jacobian: FloatArray) -> int:
    """Return how many combinations of the parameters change nothing."""
    if not jacobian.shape[1]:
        return 0
    _, _, values, _ = _decomposed(jacobian)
    return int(np.count_nonzero(values <= values.max(initial=0.0) / RANK_RATIO))


def rounded_covariance(covariance: FloatArray, *, lost: int = 0) -> FloatArray:
    """Return a covariance to the digits that mean something, shape (q, q): standard errors to four.

    Correlations keep three decimals beyond the first of the smallest eigenvalue of their matrix, so that it stays
    positive definite and the best known combination of parameters keeps its error to a per cent or better; `lost`
    combinations, which change nothing, have no part in it.
    """
    size = np.sqrt(np.diag(covariance))
    if not (np.isfinite(covariance).all() and (size > 0.0).all()):
        return covariance
    correlation = covariance / size[:, None] / size
    correlation = 0.5 * (correlation + correlation.T)
    smallest = float(np.linalg.eigvalsh(correlation)[min(lost, size.size - 1)]) if size.size else 1.0
    decimals = min(_DECIMALS - floor(log10(max(smallest, 10.0**-_MOST_DECIMALS))), _MOST_DECIMALS)
    std = np.array([significant(value, STD_DIGITS) for value in size.tolist()])
    product = correlation.round(decimals) * std[:, None] * std
    product[np.diag_indices_from(product)] = std**2
    digits = min(max(GIVEN_DIGITS, decimals + 2), _MOST_DECIMALS)
    cells = [significant(cell, digits) for cell in product.ravel().tolist()]
    return np.array(cells).reshape(product.shape)
