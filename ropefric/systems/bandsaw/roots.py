"""Roots of many functions of one number at once, each in a bracket of its own."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.errors import SolverError

_MAX_STEPS = 100


def roots_between(
    function: Callable[[FloatArray, npt.NDArray[np.intp]], FloatArray],
    low: FloatArray,
    high: FloatArray,
    *,
    tolerance: float,
) -> FloatArray:
    """Return the root of each case to a relative tolerance; `function(x, cases)` differs in sign at its two ends.

    Chandrupatla's method: inverse quadratic interpolation where it can be trusted, bisection elsewhere. Cases that
    are settled are not computed again.
    """
    every = np.arange(low.size)
    a, b = high.astype(np.float64), low.astype(np.float64)
    fa, fb = function(a, every), function(b, every)
    c, fc = a.copy(), fa.copy()
    share = np.full(low.size, 0.5)
    active = every
    for _ in range(_MAX_STEPS):
        x = a[active] + share[active] * (b[active] - a[active])
        fx = function(x, active)
        # The newest point replaces the end of its own sign; c is the end before it.
        same = np.sign(fx) == np.sign(fa[active])
        kept, flipped = active[same], active[~same]
        c[kept], fc[kept] = a[kept], fa[kept]
        c[flipped], fc[flipped] = b[flipped], fb[flipped]
        b[flipped], fb[flipped] = a[flipped], fa[flipped]
        a[active], fa[active] = x, fx
        best = np.where(np.abs(fa) < np.abs(fb), a, b)
        allowed = tolerance * np.abs(best[active])
        width = np.abs(b[active] - a[active])
        going = (fa[active] != 0.0) & (fb[active] != 0.0) & (width > 2.0 * allowed)
        nearest, active = allowed[going] / width[going], active[going]
        if not active.size:
            return best
        A, B, C, FA, FB, FC = (part[active] for part in (a, b, c, fa, fb, fc))
        with np.errstate(divide="ignore", invalid="ignore"):
            xi, phi = (A - B) / (C - B), (FA - FB) / (FC - FB)
            quadratic = FA / (FB - FA) * FC / (FB - FC) + (C - A) / (B - A) * FA / (FC - FA) * FB / (FC - FB)
            trusted = (phi**2 < xi) & ((1.0 - phi) ** 2 < 1.0 - xi)
        share[active] = np.clip(np.where(trusted, quadratic, 0.5), nearest, 1.0 - nearest)
    raise SolverError("the roots do not settle", fix="ask for less accuracy")
