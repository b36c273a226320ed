"""Damped Gauss-Newton steps inside bounds for many small problems at once."""

import numpy as np

from ropefric.arrays import BoolArray, FloatArray

# Keeps the scaled normal equations invertible where the data do not see a direction at all.
_RIDGE = 1e-13
# Near the smallest floats a square is held only in part.
_NOTHING = 1e-280
# A scaled gradient below this is rounding.
_PUSH = 1e-12


def bounded_steps(
    normal: FloatArray,
    downhill: FloatArray,
    *,
    curvature: FloatArray,
    low: FloatArray,
    high: FloatArray,
    vary: BoolArray,
    damping: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the steps that lower ‖r + J s‖² + sᵀS s most among those inside the bounds, and their squared length.

    The columns are scaled to unit length first, so parameters of any units are solved alike. A parameter that
    presses against its bound is held there, one that would pass it stops at it, and the others are solved again
    with that known, until no parameter wants to change sides (or 2 p rounds are over).
    """
    whole = normal + curvature
    scale = column_scale(whole)
    A = whole / (scale[:, :, np.newaxis] * scale[:, np.newaxis, :])
    b = downhill / scale
    floor, roof = low * scale, high * scale
    held = ~vary | ((low >= 0.0) & (b < 0.0)) | ((high <= 0.0) & (b > 0.0))
    stop = np.zeros(b.shape)
    step = _solve(A, b, damping, held, stop)
    for _ in range(2 * b.shape[1]):
        beyond = ~held & ((step < floor) | (step > roof))
        inward = held & vary
        if not (np.count_nonzero(beyond) or np.count_nonzero(inward)):
            break
        if np.count_nonzero(inward):
            push = b - np.einsum("mij,mj->mi", A, step)
            inward &= np.where(step <= floor, push > _PUSH, push < -_PUSH)
            # Letting go waits until nothing is beyond a bound, or two parameters could swap for ever.
            inward &= ~beyond.any(axis=1, keepdims=True)
        again = np.flatnonzero((beyond | inward).any(axis=1))
        if not again.size:
            break
        stop = np.where(beyond, np.clip(step, floor, roof), np.where(inward, 0.0, stop))
        held = (held | beyond) & ~inward
        step[again] = _solve(A[again], b[again], damping[again], held[again], stop[again])
    step = np.minimum(np.maximum(step / scale, low), high)
    # Two products of two: einsum is slow with three.
    length2 = ((normal @ step[:, :, np.newaxis])[:, :, 0] * step).sum(axis=1)
    return step, np.maximum(length2, 0.0)


def column_scale(normal: FloatArray) -> FloatArray:
    """Return the lengths of the columns of J from JᵀJ, shape (m, p), and 1 where there is none."""
    square = normal.diagonal(axis1=1, axis2=2)
    return np.sqrt(np.where(square > _NOTHING, square, 1.0))


def _solve(
    A: FloatArray, b: FloatArray, damping: FloatArray, held: BoolArray, fixed: FloatArray
) -> FloatArray:
    """Return the minimum over the parameters that are not held, the others standing at their fixed steps."""
    system, right = A, b
    if np.count_nonzero(held):
        system = np.where(held[:, :, np.newaxis] | held[:, np.newaxis, :], 0.0, A)
        right = np.where(held, fixed, b - np.einsum("mij,mj->mi", A, fixed))
    system = np.array(system, order="C")
    # The diagonal is a view: what is added to it is added to the system.
    diagonal = system.reshape(len(b), -1)[:, :: b.shape[1] + 1]
    diagonal += np.where(diagonal > 0.0, damping[:, np.newaxis] + _RIDGE, 1.0)
    return np.asarray(np.linalg.solve(system, right[..., np.newaxis])[..., 0])
