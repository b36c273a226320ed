"""Closed forms of ∫μ over the wrap, eqs. (11)-(17), that keep their digits where the textbook expressions cancel.

Local coefficients μ(φ) = a φ^b + c and a e^{bφ} + c over [p, p + δ], and the wrap φ0 equivalent to an end tension:
∫₀^{φ0} μ dφ = ln(F_B/F_0), eqs. (11)-(13). An end tension acts as if the rope had already gone round φ0. F_0 = 1 N is
a physical reference, not a free scale, and F_B < F_0 has no φ0.
"""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from scipy.special import exprel, wrightomega

from ropefric.arrays import FloatArray
from ropefric.errors import SolverError

# Below this the direct form has lost a factor 20, above it nine series terms leave 1e-16.
_SERIES_BELOW = 0.1
_EXPREL_SLOPE_SERIES = [
    1.0 / (factorial * (k + 2)) for k, factorial in enumerate(np.cumprod([1.0, *range(1, 10)]))
]
_LOG1PREL_SLOPE_SERIES = [(-1.0) ** (k + 1) * (k + 1) / (k + 2) for k in range(16)]
# e^-800 is zero in floats, so an integral from this far below differs from one from zero by nothing.
_FROM_ZERO = 800.0
# Each step roughly squares the error (constant <= 1/2), so a step below this leaves less than rounding.
_LAST_STEP = 1e-8
_LAST_RELATIVE_STEP = 1e-9
# b + 1 = 1e-16 needs about 45 steps, b >= -0.9 at most 6.
_MAX_STEPS = 80


def exprel_slope(z: npt.ArrayLike) -> FloatArray:
    """Return ψ(z) = ∫₀¹ t e^{zt} dt = (z e^z − expm1 z)/z², the derivative of exprel(z) = expm1(z)/z."""
    return _with_series(z, _EXPREL_SLOPE_SERIES, lambda z: (np.exp(z) - exprel(z)) / z)


def log1prel(z: npt.ArrayLike) -> FloatArray:
    """Return log1p(z)/z, and 1 at z = 0."""
    z = np.asarray(z, dtype=np.float64)
    safe = np.where(z == 0.0, 1.0, z)
    return np.where(z == 0.0, 1.0, np.log1p(safe) / safe)


def log1prel_slope(z: npt.ArrayLike) -> FloatArray:
    """Return the derivative of log1p(z)/z, that is (z/(1 + z) − log1p z)/z²; −1/2 at z = 0."""
    return _with_series(z, _LOG1PREL_SLOPE_SERIES, lambda z: (1.0 / (1.0 + z) - np.log1p(z) / z) / z)


def _with_series(
    z: npt.ArrayLike, series: list[float], direct: Callable[[FloatArray], FloatArray]
) -> FloatArray:
    """Return a function by its power series near zero, and directly elsewhere."""
    z = np.asarray(z, dtype=np.float64)
    small = np.abs(z) < _SERIES_BELOW
    near = np.polyval(series[::-1], np.where(small, z, 0.0))
    return np.where(small, near, direct(np.where(small, 1.0, z)))


class PowerSpan:
    """A stretch of wrap that starts at e^{log_start} rad and is wrap_rad long, seen through φ^b of eq. (15).

    The lower end enters as its logarithm and the wrap, above zero, as itself: p underflows as b → −1, and p + δ loses δ.
    """

    def __init__(self, log_start: npt.ArrayLike, wrap_rad: npt.ArrayLike, b: npt.ArrayLike) -> None:
        self.s = s = np.asarray(b, dtype=np.float64) + 1.0
        log_wrap = np.log(wrap_rad)
        with np.errstate(divide="ignore"):
            floor = np.where(s > 0.0, log_wrap - _FROM_ZERO / np.abs(s), -np.inf)
        self.log_start = u = np.maximum(log_start, floor)
        x = log_wrap - u
        above = np.log1p(np.exp(-np.abs(x)))
        self.length = np.maximum(x, 0.0) + above
        self.log_end = np.maximum(u, log_wrap) + above
        self.scale = np.exp(s * np.where(s >= 0.0, self.log_end, u)) * self.length
        self.z = -np.abs(s) * self.length

    def integral(self) -> FloatArray:
        """Return ∫ φ^b dφ = e^{s·u} L exprel(s L), exact through s = 0."""
        return np.asarray(self.scale * exprel(self.z))

    def slope(self) -> FloatArray:
        """Return ∂/∂b ∫ φ^b dφ = ∫ φ^b ln φ dφ."""
        from_end = self.s >= 0.0
        reference = np.where(from_end, self.log_end, self.log_start)
        inward = np.where(from_end, -self.length, self.length)
        return np.asarray(self.scale * (reference * exprel(self.z) + inward * exprel_slope(self.z)))


def power_log_start(y: npt.ArrayLike, a: npt.ArrayLike, b: npt.ArrayLike, c: npt.ArrayLike) -> FloatArray:
    """Return ln φ0 for μ = a φ^b + c, where a φ0^{b+1}/(b+1) + c φ0 = y.

    The logarithm comes back because φ0 underflows as b → −1 (b = −0.999, y = 1, a = 0.2: ln φ0 = −5298).

    With u = ln φ0 the equation reads ln(e^{s(u − u_a)} + e^{u − u_c}) = 0, s = b + 1, where u_a and u_c are the
    roots of the single terms. It is convex and increasing, so Newton's method from the smaller of them comes
    down on the root monotonically.
    """
    y, a, c = np.asarray(y, np.float64), np.asarray(a, np.float64), np.asarray(c, np.float64)
    s = np.asarray(b, np.float64) + 1.0
    positive = np.where(y > 0.0, y, 1.0)
    with np.errstate(divide="ignore", over="ignore"):
        # One logarithm of a ratio: a difference of two would lose |ln| digits, and 1/s multiplies the loss.
        from_power = np.log(positive * s / a) / s
        from_linear = np.log(positive / c)
    power_leads = from_power <= from_linear
    lead = np.where(power_leads, from_power, from_linear)
    rate = np.where(power_leads, s, 1.0)
    excess = np.where(power_leads, 1.0 - s, s - 1.0)
    with np.errstate(invalid="ignore"):
        gap = np.abs(from_power - from_linear)
    other = -np.where(power_leads, 1.0, s) * np.where(np.isnan(gap), 0.0, gap)
    return np.where(y > 0.0, lead + _descend(rate, excess, other), -np.inf)


def _descend(rate: FloatArray, excess: FloatArray, other: FloatArray) -> FloatArray:
    """Return the root t <= 0 of rate·t + log1p(e^{excess·t + other}) = 0."""
    t = np.zeros(np.broadcast_shapes(rate.shape, excess.shape, other.shape))
    for _ in range(_MAX_STEPS):
        term = np.exp(excess * t + other)
        step = (rate * t + np.log1p(term)) / (rate + excess * (term / (1.0 + term)))
        t -= step
        if not (step > _LAST_STEP).any():
            return t
    raise SolverError("the equivalent wrap angle of the end tension did not converge")  # pragma: no cover


def exponential_start_rad(
    y: npt.ArrayLike, a: npt.ArrayLike, b: npt.ArrayLike, c: npt.ArrayLike
) -> FloatArray:
    """Return φ0 [rad] for μ = a e^{bφ} + c, where a φ0 exprel(b φ0) + c φ0 = y.

    Starts from the Wright-omega form and finishes with Newton steps on the integral itself, which is concave:
    after one step the iteration rises to the root monotonically. The start alone cancels for b → 0 and c → 0.
    """
    y, a, b, c = np.broadcast_arrays(*(np.asarray(v, np.float64) for v in (y, a, b, c)))
    lower, upper = _exponential_bracket(y, a, b, c)
    phi = np.clip(_omega_start(y, a, b, c, lower), lower, upper)
    for _ in range(_MAX_STEPS):
        slope = a * np.exp(b * phi) + c
        step = (phi * (a * exprel(b * phi) + c) - y) / np.where(slope > 0.0, slope, 1.0)
        new = np.clip(phi - step, lower, upper)
        moved = np.abs(new - phi) > _LAST_RELATIVE_STEP * phi
        phi = new
        if not moved.any():
            break
    return phi


def _exponential_bracket(
    y: FloatArray, a: FloatArray, b: FloatArray, c: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return bounds of φ0: G lies below its tangent at 0 and its asymptote, and above each of its terms."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        filled = np.where(a > 0.0, -b * y / a, np.inf)
        below = filled < 1.0
        from_exponential = np.where(below, y / a * log1prel(-np.where(below, filled, 0.0)), np.inf)
        from_linear = np.where(c > 0.0, y / c, np.inf)
        asymptote = np.where((c > 0.0) & (b < 0.0), (y + a / b) / c, 0.0)
        tangent = np.where(a + c > 0.0, y / (a + c), 0.0)
    upper = np.where(y > 0.0, np.minimum(from_exponential, from_linear), 0.0)
    lower = np.where(c > 0.0, np.maximum(asymptote, tangent), upper)
    return np.minimum(lower, upper), upper


def _omega_start(y: FloatArray, a: FloatArray, b: FloatArray, c: FloatArray, lower: FloatArray) -> FloatArray:
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        shifted = y + a / b
        start = shifted / c - wrightomega(b * shifted / c + np.log(a / c)) / b
    return np.where(np.isfinite(start), start, lower)
