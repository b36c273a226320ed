"""The moving beam by Chebyshev series over the whole span: another discretisation, to check the first by.

The differential equation itself is expanded, in the ultraspherical polynomials that make every derivative a single
diagonal (Olver and Townsend 2013), so nothing is shared with the weak form: neither the basis nor the integrals nor
the eigenproblem. Boundary layers need an order of some 3/√ε here, so it is no method for a blade that is nearly a
string.
"""

import numpy as np
import scipy.linalg

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.bandsaw.beam import ScaledBeam


def chebyshev_frequencies(beam: ScaledBeam, order: int, n_modes: int = 6) -> FloatArray:
    """Return the first scaled frequencies ω = 2π f l/c [-], shape (n_modes,).

    (λ² M + λ C + K) a = 0 for the coefficients a of Σ a_j T_j(2x − 1), with λ = iω; the four end conditions give the
    first four coefficients by the others, and the last four equations make room for them. The eigenvalues 1/λ of the
    companion matrix of the reversed problem are taken from the largest on.
    """
    if n_modes < 1 or order < 2 * n_modes + 4:
        raise InputError(
            f"{n_modes} modes need an order of {2 * max(n_modes, 1) + 4} or more, not {order}", key="order"
        )
    size = order + 1
    # Derivatives by x on a span of length 1 are twice those by the series' own variable.
    mass = _raised(np.eye(size), 0)
    travel = _raised(2.0 * beam.speed * 2.0 * _derivative(size, 1), 1)
    tension = _raised(-beam.net * 4.0 * _derivative(size, 2), 2)
    bending = beam.stiffness * 16.0 * _derivative(size, 4)
    inner = _inner_basis(size, turning_ends=beam.ends.turns)
    stiff = (tension + bending)[: size - 4] @ inner
    scale = 1.0 / np.max(np.abs(stiff), axis=0)
    solved = np.linalg.solve(
        stiff * scale, np.hstack([travel[: size - 4] @ inner * scale, mass[: size - 4] @ inner * scale])
    )
    half = size - 4
    companion = np.zeros((2 * half, 2 * half))
    companion[:half] = -solved
    companion[half:, :half] = np.eye(half)
    inverse = np.asarray(scipy.linalg.eigvals(companion), dtype=np.complex128)
    upper = inverse[inverse.imag < 0.0]
    first = upper[np.argsort(-np.abs(upper))][:n_modes]
    return np.sort((1.0 / first).imag)


def _derivative(size: int, times: int) -> FloatArray:
    """Return the derivative of T series as a series in C^(times): 2^(k−1) (k−1)! j on the k-th diagonal."""
    factor = 2.0 ** (times - 1) * float(np.prod(np.arange(1, times)))
    return np.asarray(np.diag(factor * np.arange(times, size), times))


def _raised(matrix: FloatArray, basis: int) -> FloatArray:
    """Return an operator into C^(basis) as one into C^(4), where C^(0) stands for T."""
    size = matrix.shape[0]
    for k in range(basis, 4):
        j = np.arange(size)
        if k == 0:
            diagonal = np.where(j == 0, 1.0, 0.5)
            convert = np.diag(diagonal) - np.diag(np.full(size - 2, 0.5), 2)
        else:
            convert = np.diag(k / (k + j)) - np.diag(k / (k + j[2:]), 2)
        matrix = convert @ matrix
    return matrix


def _inner_basis(size: int, *, turning_ends: bool) -> FloatArray:
    """Return the series that meet the end conditions, one a column, shape (size, size − 4)."""
    j = np.arange(size, dtype=np.float64)
    right = j**2 * (j**2 - 1.0) / 3.0 if turning_ends else j**2
    # T_j^(k)(−1) = (−1)^(j+k) T_j^(k)(1): even and odd terms stand apart.
    left_sign = (-1.0) ** j
    rows = np.stack([np.ones(size), left_sign, right, left_sign * right])
    return np.vstack([-np.linalg.solve(rows[:, :4], rows[:, 4:]), np.eye(size - 4)])
