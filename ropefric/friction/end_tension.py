"""The wrap angle φ0 that an end tension stands for: ∫₀^{φ0} μ dφ = ln(F_B/F_0), eqs. (11)-(13).

An end tension acts as if the rope had already gone round φ0. F_0 = 1 N is a physical reference, not a free
scale, and F_B < F_0 has no φ0.
"""

import numpy as np
import numpy.typing as npt
from scipy.special import exprel, wrightomega

from ropefric.arrays import FloatArray
from ropefric.errors import SolverError
from ropefric.friction.special import log1prel

# Each step roughly squares the error (constant <= 1/2), so a step below this leaves less than rounding.
_LAST_STEP = 1e-8
_LAST_RELATIVE_STEP = 1e-9
# b + 1 = 1e-16 needs about 45 steps, b >= -0.9 at most 6.
_MAX_STEPS = 80


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
