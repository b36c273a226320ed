"""Functions that keep the closed forms exact where the textbook expressions cancel."""

import numpy as np
import numpy.typing as npt
from scipy.special import exprel

from ropefric.arrays import FloatArray

__all__ = ["exprel", "exprel_slope", "log1prel", "log1prel_slope"]

# Below this the direct form has lost a factor 20, above it nine series terms leave 1e-16.
_SERIES_BELOW = 0.1
_EXPREL_SLOPE_SERIES = [
    1.0 / (factorial * (k + 2)) for k, factorial in enumerate(np.cumprod([1.0, *range(1, 10)]))
]
_LOG1PREL_SLOPE_SERIES = [(-1.0) ** (k + 1) * (k + 1) / (k + 2) for k in range(16)]


def exprel_slope(z: npt.ArrayLike) -> FloatArray:
    """Return ψ(z) = ∫₀¹ t e^{zt} dt = (z e^z − expm1 z)/z², the derivative of exprel(z) = expm1(z)/z."""
    z = np.asarray(z, dtype=np.float64)
    small = np.abs(z) < _SERIES_BELOW
    safe = np.where(small, 1.0, z)
    direct = (np.exp(safe) - exprel(safe)) / safe
    return np.where(small, _horner(_EXPREL_SLOPE_SERIES, np.where(small, z, 0.0)), direct)


def log1prel(z: npt.ArrayLike) -> FloatArray:
    """Return log1p(z)/z, and 1 at z = 0."""
    z = np.asarray(z, dtype=np.float64)
    safe = np.where(z == 0.0, 1.0, z)
    return np.where(z == 0.0, 1.0, np.log1p(safe) / safe)


def log1prel_slope(z: npt.ArrayLike) -> FloatArray:
    """Return the derivative of log1p(z)/z, that is (z/(1 + z) − log1p z)/z²; −1/2 at z = 0."""
    z = np.asarray(z, dtype=np.float64)
    small = np.abs(z) < _SERIES_BELOW
    safe = np.where(small, 1.0, z)
    direct = (1.0 / (1.0 + safe) - np.log1p(safe) / safe) / safe
    return np.where(small, _horner(_LOG1PREL_SLOPE_SERIES, np.where(small, z, 0.0)), direct)


def _horner(coefficients: list[float], z: FloatArray) -> FloatArray:
    total = np.full_like(z, coefficients[-1])
    for coefficient in coefficients[-2::-1]:
        total = total * z + coefficient
    return total
