"""Natural frequencies and decay rates of a press, and the step above which RK4 blows up."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigvals

from ropefric.arrays import FloatArray
from ropefric.systems.press.transient.mode import sticking
from ropefric.systems.press.transient.model import ElasticPress
from ropefric.systems.press.transient.motion import Motion


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Spectrum:
    """How a press swings while no belt slips."""

    frequencies_Hz: FloatArray
    eigenvalues: np.ndarray

    @property
    def decay_rates_1_s(self) -> FloatArray:
        """Return how fast each motion dies away, rising, shape (2 n_q,) [1/s]."""
        return np.sort(-self.eigenvalues.real)


def spectrum_of(model: ElasticPress) -> Spectrum:
    """Return frequencies and eigenvalues of a press whose drivers follow their drive."""
    motion = Motion(model=model, mode=sticking(model))
    n_q = motion.n_coordinates
    rows = motion.derivative[:, : 2 * n_q]
    # Belt damping is proportional to belt stiffness only, so the undamped part is read off the displacements.
    squares = eigvals(-rows[n_q:, :n_q]).real
    return Spectrum(
        frequencies_Hz=np.sqrt(np.sort(np.maximum(squares, 0.0))) / (2.0 * np.pi),
        eigenvalues=np.asarray(eigvals(rows)),
    )


def rk4_limit_s(eigenvalues: np.ndarray) -> float:
    """Return the greatest step at which the classical Runge-Kutta method does not amplify any motion [s].

    |1 + z + z²/2 + z³/6 + z⁴/24| ≤ 1 has to hold for z = hλ of every eigenvalue. Seen from 0 the region's border is
    more than 2 away in every direction of the left half-plane, 2√2 along the imaginary axis.
    """
    limits = [_border(value / abs(value)) / abs(value) for value in eigenvalues if abs(value) > 0.0]
    return float(min(limits, default=np.inf))


def _border(direction: complex) -> float:
    # |R|² − 1 is a polynomial in the distance; its root at 0 is divided out.
    series = direction ** np.arange(5) / np.array([1.0, 1.0, 2.0, 6.0, 24.0])
    squared = np.convolve(series, series.conj()).real[1:]
    roots = np.roots(squared[::-1])
    real = roots[np.abs(roots.imag) <= 1e-6 * np.abs(roots)].real
    beyond = real[real > 1.5]
    return float(beyond.min()) if beyond.size else 2.0 * np.sqrt(2.0)
