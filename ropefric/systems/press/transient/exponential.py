"""Exact steps of dy/dt = A y + B u(t) with polynomial u, and exact integrals of squares of the solution.

A polynomial of degree r is itself the solution of dp/dt = N p with p_j = τ^j/j!, so one exponential of the joint
matrix carries both over a step of any length: there is no error of discretisation, however stiff A is. Ways and
speeds differ by the frequencies in size; balanced by powers of two, slow motions keep their digits beside fast ones.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import expm, matrix_balance

from ropefric.arrays import FloatArray

_TAYLOR_TERMS = 24


@dataclass(frozen=True, kw_only=True, eq=False)
class Propagator:
    """Steps of z = (y, p_r … p_0), the state beside the powers of the time since the start of a piece."""

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
        """Return the generator G of dz/dt = G z over z divided by powers of two, and these."""
        state, (scale, _) = matrix_balance(self.state, permute=False, separate=True)
        acting = (self.drive @ self._reversed) / scale[:, None]
        # Large inputs would make the norm large, and with it the number of doublings and their rounding.
        excess = float(np.linalg.norm(acting, 1)) / max(float(np.linalg.norm(state, 1)), 1e-300)
        share = 2.0 ** -math.ceil(math.log2(excess)) if 1.0 < excess < math.inf else 1.0
        lower = np.zeros((len(self._shift), len(state)))
        generator = np.block([[state, share * acting], [lower, self._shift]])
        return generator, np.concatenate([scale, np.full(len(self._shift), share)])

    def step(self, length_s: float) -> FloatArray:
        """Return the matrix that carries z over a step, shape (n + r + 1, n + r + 1)."""
        generator, weights = self._balanced
        return np.asarray(weights[:, None] * expm(length_s * generator) / weights)

    def integrals(self, forms: FloatArray, length_s: float) -> FloatArray:
        """Return the matrices X with zᵀ X z = ∫ wᵀ S w dt over a step that starts at z."""
        generator, weights = self._balanced
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
