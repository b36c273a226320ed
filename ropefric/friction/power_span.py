"""Closed forms for a local coefficient μ(φ) = a φ^b + c, eq. (15), from ln p to ln(p + δ).

The lower end enters as its logarithm u and the wrap as δ itself: p underflows as b → −1, and p + δ loses δ.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.friction.special import exprel, exprel_slope

# e^-800 is zero in floats, so an integral from this far below differs from one from zero by nothing.
_FROM_ZERO = 800.0


@dataclass(frozen=True, slots=True, kw_only=True)
class PowerSpan:
    """A stretch of wrap [p, p + δ] seen through φ^b: ∫ φ^b dφ over it and what its slope needs."""

    s: FloatArray
    log_start: FloatArray
    log_end: FloatArray
    length: FloatArray
    scale: FloatArray
    z: FloatArray

    def integral(self) -> FloatArray:
        """Return ∫ φ^b dφ = e^{s·u} L exprel(s L), exact through s = 0."""
        return self.scale * exprel(self.z)

    def slope(self) -> FloatArray:
        """Return ∂/∂b ∫ φ^b dφ = ∫ φ^b ln φ dφ."""
        from_end = self.s >= 0.0
        reference = np.where(from_end, self.log_end, self.log_start)
        inward = np.where(from_end, -self.length, self.length)
        return self.scale * (reference * exprel(self.z) + inward * exprel_slope(self.z))


def power_span(log_start: npt.ArrayLike, wrap_rad: npt.ArrayLike, b: npt.ArrayLike) -> PowerSpan:
    """Return the stretch of wrap that starts at e^{log_start} rad and is wrap_rad long."""
    s = np.asarray(b, dtype=np.float64) + 1.0
    log_wrap = np.log(wrap_rad)
    with np.errstate(divide="ignore"):
        floor = np.where(s > 0.0, log_wrap - _FROM_ZERO / np.abs(s), -np.inf)
    u = np.maximum(log_start, floor)
    x = log_wrap - u
    above = np.log1p(np.exp(-np.abs(x)))
    length = np.maximum(x, 0.0) + above
    log_end = np.maximum(u, log_wrap) + above
    reference = np.where(s >= 0.0, log_end, u)
    return PowerSpan(
        s=s,
        log_start=u,
        log_end=log_end,
        length=length,
        scale=np.exp(s * reference) * length,
        z=-np.abs(s) * length,
    )
