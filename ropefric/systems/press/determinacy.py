"""Which combinations of tensions a set of balances leaves open, and how to say so."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

__all__ = ["free_motions", "in_words", "matrix_rank"]

FloatArray = npt.NDArray[np.float64]

# The entries are cosines and ones, so singular values are of order one or zero by rounding.
_TINY = 1e-9


def matrix_rank(matrix: FloatArray) -> int:
    """Return the rank of a matrix of balances.

    Examples
    --------
    >>> matrix_rank(np.array([[1.0, -1.0], [-1.0, 1.0]]))
    1
    """
    return int(np.linalg.matrix_rank(matrix, tol=_TINY)) if matrix.size else 0


def free_motions(matrix: FloatArray) -> FloatArray:
    """Return a sparse basis of the null space, shape (deficiency, n): what no row of the matrix sees.

    The basis is in reduced echelon form: each vector begins with a 1 where all others are 0.

    Examples
    --------
    >>> free_motions(np.array([[0.0, 2.0, 2.0]])).tolist()
    [[1.0, 0.0, 0.0], [0.0, 1.0, -1.0]]
    """
    rank = matrix_rank(matrix)
    basis = np.linalg.svd(matrix)[2][rank:].copy()
    row = 0
    for column in range(basis.shape[1]):
        if row == len(basis):
            break
        pivot = row + int(np.argmax(np.abs(basis[row:, column])))
        if abs(basis[pivot, column]) < _TINY:
            continue
        basis[[row, pivot]] = basis[[pivot, row]]
        basis[row] /= basis[row, column]
        others = np.arange(len(basis)) != row
        basis[others] -= np.outer(basis[others, column], basis[row])
        row += 1
    basis[np.abs(basis) < _TINY] = 0.0
    return basis


def in_words(motion: FloatArray, names: Sequence[str]) -> str:
    """Return a combination of tensions as words.

    Examples
    --------
    >>> in_words(np.array([0.0, 1.0, -1.0]), ["8", "9", "10"])
    'T9 may rise while T10 falls as much'
    >>> in_words(np.array([1.0, 1.0, 0.0]), ["1", "2", "3"])
    'T1, T2 may rise together'
    """
    parts = [(name, value) for name, value in zip(names, motion, strict=True) if value != 0.0]
    if all(abs(abs(value) - 1.0) < _TINY for _, value in parts):
        rising = ", ".join(f"T{name}" for name, value in parts if value > 0.0)
        falling = ", ".join(f"T{name}" for name, value in parts if value < 0.0)
        if falling:
            return f"{rising} may rise while {falling} falls as much"
        return f"{rising} may rise together"
    return "may change together: " + ", ".join(f"{value:+.4g} T{name}" for name, value in parts)
