"""Exact steps of dy/dt = A y + B u(t) with polynomial u, and exact integrals of squares of the solution.

A polynomial of degree r is itself the solution of dp/dt = N p with p_j = τ^j/j!, so one exponential of the joint
matrix carries both over a step of any length: there is no error of discretisation, however stiff A is.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import expm, matrix_balance, schur

from ropefric.systems.press.transient.polynomial import FloatArray

__all__ = ["Propagator"]

_STIFF = 50.0
"""Above this norm an exponential by squaring alone would lose the slow motions beside the fast ones."""
_TAYLOR_TERMS = 24


@dataclass(frozen=True, kw_only=True, eq=False)
class Propagator:
    """Steps of z = (y, p_r … p_0), the state beside the powers of the time since the start of a piece.

    Attributes
    ----------
    state : ndarray, shape (n, n)
        A.
    drive : ndarray, shape (n, m)
        B, the action of the m inputs.
    taylor : ndarray, shape (m, r + 1)
        Derivatives of the inputs at the start of the piece.

    Examples
    --------
    >>> fall = Propagator(state=np.array([[-1e9]]), drive=np.array([[1e9]]), taylor=np.array([[0.0, 1.0]]))
    >>> z = fall.step(1.0) @ fall.lift(np.array([0.0]), 0.0)
    >>> float(z[0].round(12))
    0.999999999
    """

    state: FloatArray
    drive: FloatArray
    taylor: FloatArray

    @cached_property
    def _reversed(self) -> FloatArray:
        return self.taylor[:, ::-1]

    @cached_property
    def _shift(self) -> FloatArray:
        return np.eye(self.taylor.shape[1], k=1)

    @cached_property
    def read(self) -> FloatArray:
        """Return the matrix that gives (y, u) from z, shape (n + m, n + r + 1)."""
        n, (m, powers) = len(self.state), self.taylor.shape
        return np.block([[np.eye(n), np.zeros((n, powers))], [np.zeros((m, n)), self._reversed]])

    def lift(self, y: FloatArray, tau_s: float) -> FloatArray:
        """Return z at the time `tau_s` after the start of the piece."""
        powers = np.ones(self.taylor.shape[1])
        for j in range(1, len(powers)):
            powers[j] = powers[j - 1] * tau_s / j
        return np.concatenate([y, powers[::-1]])

    @cached_property
    def _balanced(self) -> tuple[FloatArray, FloatArray]:
        balanced, (scale, _) = matrix_balance(self.state, permute=False, separate=True)
        return np.asarray(balanced), np.asarray(scale)

    @cached_property
    def _triangular(self) -> tuple[np.ndarray, np.ndarray]:
        triangle, basis = schur(self._balanced[0], output="complex")
        return triangle, basis

    def step(self, length_s: float) -> FloatArray:
        """Return the matrix that carries z over a step, shape (n + r + 1, n + r + 1)."""
        balanced, scale = self._balanced
        n = len(scale)
        acting = (self.drive @ self._reversed) / scale[:, None]
        if np.linalg.norm(balanced, 1) * length_s < _STIFF:
            whole = expm(length_s * _joined(balanced, acting, self._shift))
        else:
            # In Schur form the fast and the slow motions stand apart on the diagonal, where expm keeps each exact.
            triangle, basis = self._triangular
            inner = expm(length_s * _joined(triangle, basis.conj().T @ acting, self._shift))
            whole = np.block(
                [
                    [basis @ inner[:n, :n] @ basis.conj().T, basis @ inner[:n, n:]],
                    [inner[n:, :n], inner[n:, n:]],
                ]
            ).real
        whole = np.asarray(whole, dtype=np.float64)
        whole[:n] *= scale[:, None]
        whole[:, :n] /= scale
        return whole

    def integrals(self, forms: FloatArray, length_s: float) -> FloatArray:
        """Return the matrices X with zᵀ X z = ∫ wᵀ S w dt over a step that starts at z.

        Parameters
        ----------
        forms : ndarray, shape (k, n + m, n + m)
            Symmetric S over w = (y, u).
        length_s : float
            Length of the step [s].

        Returns
        -------
        ndarray, shape (k, n + r + 1, n + r + 1)
            From dX/dh = Gᵀ X + X G + S by its series over a short step and then
            X(2h) = X(h) + Φ(h)ᵀ X(h) Φ(h), which stays accurate where a closed formula overflows.
        """
        balanced, scale = self._balanced
        n = len(scale)
        generator = _joined(balanced, (self.drive @ self._reversed) / scale[:, None], self._shift)
        weights = np.concatenate([scale, np.ones(len(generator) - n)])
        reading = self.read * weights
        doublings = max(
            0, math.ceil(math.log2(max(float(np.linalg.norm(generator, 1)) * length_s, 1e-300))) + 1
        )
        h = length_s / 2.0**doublings
        term = h * (reading.T @ forms @ reading)
        total = term.copy()
        for order in range(2, _TAYLOR_TERMS):
            product = term @ generator
            term = (h / order) * (product + product.transpose(0, 2, 1))
            total += term
        flow = np.asarray(expm(h * generator))
        for _ in range(doublings):
            total = total + flow.T @ total @ flow
            flow = flow @ flow
        return np.asarray(total / np.outer(weights, weights))


def _joined(state: np.ndarray, acting: np.ndarray, shift: np.ndarray) -> np.ndarray:
    return np.block([[state, acting], [np.zeros((len(shift), len(state))), shift]])
