"""Functions of time that are polynomials between given moments: what a drive prescribes, without rounding."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import comb

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.errors import InputError


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PiecewisePolynomial:
    """A function Σ c_j (t − t_i)^j on each piece from t_i to t_(i+1); the first starts at 0, the last never ends."""

    starts_s: FloatArray
    coefficients: FloatArray

    @classmethod
    def of(cls, starts_s: npt.ArrayLike, coefficients: npt.ArrayLike) -> "PiecewisePolynomial":
        """Return the function from lists of numbers."""
        return cls(
            starts_s=np.array(starts_s, dtype=np.float64),
            coefficients=np.array(coefficients, dtype=np.float64),
        )

    def __post_init__(self) -> None:
        starts = np.array(self.starts_s, dtype=np.float64)
        coefficients = np.array(self.coefficients, dtype=np.float64)
        if starts.ndim != 1 or coefficients.ndim != 2 or len(starts) != len(coefficients) or not starts.size:
            raise InputError("a piecewise polynomial needs one row of coefficients for each piece")
        if not (np.isfinite(starts).all() and np.isfinite(coefficients).all()):
            raise InputError("a piecewise polynomial needs finite numbers")
        if starts[0] != 0.0 or (np.diff(starts) <= 0.0).any():
            raise InputError(f"the pieces start at {starts.tolist()} s; they must start at 0 and rise")
        for name, array in (("starts_s", starts), ("coefficients", coefficients)):
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    @property
    def final(self) -> float:
        """Return the value the function ends with."""
        if self.coefficients[-1, 1:].any():
            raise InputError("the function never settles", fix="let its last piece be constant")
        return float(self.coefficients[-1, 0])

    def __call__(self, time_s: npt.ArrayLike) -> FloatArray:
        """Return the value at each time, of the same shape; at a jump the value after it."""
        time = np.asarray(time_s, dtype=np.float64)
        piece = np.clip(np.searchsorted(self.starts_s, time, side="right") - 1, 0, None)
        tau = time - self.starts_s[piece]
        value = np.zeros_like(tau)
        for power in reversed(range(self.coefficients.shape[1])):
            value = value * tau + self.coefficients[piece, power]
        return value

    def derivative(self) -> "PiecewisePolynomial":
        """Return the derivative inside the pieces; jumps between them leave no trace."""
        powers = np.arange(1, self.coefficients.shape[1])
        slopes = self.coefficients[:, 1:] * powers
        return PiecewisePolynomial(
            starts_s=self.starts_s, coefficients=slopes if powers.size else np.zeros((len(self.starts_s), 1))
        )

    def integral(self) -> "PiecewisePolynomial":
        """Return the continuous integral from 0."""
        powers = np.arange(1, self.coefficients.shape[1] + 1)
        grown = np.hstack([np.zeros((len(self.starts_s), 1)), self.coefficients / powers])
        for i, length in enumerate(np.diff(self.starts_s)):
            grown[i + 1, 0] = np.polynomial.polynomial.polyval(length, grown[i])
        return PiecewisePolynomial(starts_s=self.starts_s, coefficients=grown)

    def squared(self) -> "PiecewisePolynomial":
        """Return the square."""
        rows = [np.convolve(row, row) for row in self.coefficients]
        return PiecewisePolynomial(starts_s=self.starts_s, coefficients=np.array(rows))

    def times(self, factor: float) -> "PiecewisePolynomial":
        """Return the function times a number."""
        return PiecewisePolynomial(starts_s=self.starts_s, coefficients=factor * self.coefficients)

    def piece_from(self, start_s: float) -> FloatArray:
        """Return the coefficients in powers of t − start_s of the piece that holds from `start_s` on, (r + 1,)."""
        piece = int(np.searchsorted(self.starts_s, start_s, side="right")) - 1
        shift, row = start_s - self.starts_s[piece], self.coefficients[piece]
        return np.array(
            [sum(row[k] * comb(k, j) * shift ** (k - j) for k in range(j, len(row))) for j in range(len(row))]
        )


def common_pieces(functions: Sequence[PiecewisePolynomial]) -> tuple[FloatArray, FloatArray]:
    """Return the starts of pieces on which all n functions are polynomials, and their Taylor coefficients."""
    starts = np.unique(np.concatenate([function.starts_s for function in functions]))
    degree = max(function.coefficients.shape[1] for function in functions)
    taylor = np.zeros((len(starts), len(functions), degree))
    factorials = np.cumprod(np.concatenate([[1.0], np.arange(1.0, degree)]))
    for i, start in enumerate(starts):
        for j, function in enumerate(functions):
            row = function.piece_from(float(start))
            taylor[i, j, : len(row)] = row * factorials[: len(row)]
    return starts, taylor
