"""The lift-force integral of eq. (17): the paper's segments, quadrature rules and the closed form.

All methods are written for arrays of conditions, so that one condition and ten thousand are compared like with like.
"""

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.integrate import quad

from ropefric.accuracy.study import Case, Setting, Study, against
from ropefric.arrays import FloatArray
from ropefric.friction.integral import PowerSpan

Function = Callable[[FloatArray], FloatArray]

A, C = 0.2, 0.1
NEARLY = -1.0 + 1e-12
COPIES = 1250

# 50-digit values of ∫ (0.2 φ^b + 0.1) dφ over [p, p + δ]; the tests compute them again with mpmath.
REGULAR = 1.7511303075004028079
MANY = (0.43284271247461903379, 2.3313708498984761685, 0.34400556038372082663, 2.1590042494495280094,
        0.27537671171864110273, 1.9548150592471484499, 0.22561434244422533054, 1.7292676305996860942)  # fmt: skip
FROM_ZERO = 2.1663767773404715115
NEAR_MINUS_ONE = 2.7697142691114408804
SHORT_WRAP = 1.6324555162222883729e-7

_PIECES = tuple(2**k for k in range(1, 15))
_ORDERS = (2, 3, 4, 6, 8, 12, 16, 24, 32, 64)
_MOST_PIECES = 64
"""Of many conditions, and of a wrap so short that two pieces are exact."""


def segment_sum(mu: Function, start: FloatArray, wrap: FloatArray, n: int) -> FloatArray:
    """Return Σ μ_m φ_m over n equal sub-angles, each with the local coefficient of its middle, eqs. (5)-(10).

    Second order where μ is smooth; order b + 1 where the wrap starts at φ = 0, since the first sub-angle alone then
    misses a part of φ^{b+1}, its own share of the integral.
    """
    middles = (np.arange(n) + 0.5)[:, np.newaxis] / n
    return np.asarray(wrap * mu(start + wrap * middles).mean(axis=0))


def trapezoid(mu: Function, start: FloatArray, wrap: FloatArray, n: int) -> FloatArray:
    """Return the trapezoidal sum over n intervals; arguments as in `segment_sum`.

    Second order where μ is smooth. Near φ = 0 its end point counts with h/2 · p^b, so it looks first order until the
    interval h is as short as p, and there is no answer at p = 0.
    """
    values = mu(start + wrap * (np.arange(n + 1)[:, np.newaxis] / n))
    return np.asarray(wrap / n * (values[1:-1].sum(axis=0) + 0.5 * (values[0] + values[-1])))


def gauss_legendre(mu: Function, start: FloatArray, wrap: FloatArray, n: int) -> FloatArray:
    """Return Gauss-Legendre's sum of n points; its error falls geometrically with n where μ is smooth.

    The nodes are computed once and kept. Arguments as in `segment_sum`.
    """
    nodes, weights = _legendre(n)
    return np.asarray(wrap * (weights @ mu(start + wrap * nodes)))


@cache
def _legendre(n: int) -> tuple[FloatArray, FloatArray]:
    nodes, weights = np.polynomial.legendre.leggauss(n)
    return (0.5 * (nodes + 1.0))[:, np.newaxis], 0.5 * weights


def adaptive(
    mu: Callable[[float], float], start: FloatArray, wrap: FloatArray, tolerance: float
) -> FloatArray:
    """Return scipy's adaptive Gauss-Kronrod quadrature, condition by condition, to a relative tolerance."""
    ends = zip(start.tolist(), (start + wrap).tolist(), strict=True)
    # With full_output a missed tolerance is a message and not a warning; the error shows it anyway.
    return np.array(
        [quad(mu, low, high, epsabs=0.0, epsrel=tolerance, limit=200, full_output=1)[0] for low, high in ends]
    )


def _settings(
    start: npt.ArrayLike, wrap: npt.ArrayLike, reference: npt.ArrayLike, b: float = -0.5, *,
    copies: int = 1, most_pieces: int = _PIECES[-1],
) -> tuple[Setting, ...]:  # fmt: skip
    p, delta, exact = (np.tile(np.array(values), copies) for values in (start, wrap, reference))

    def mu(phi: FloatArray) -> FloatArray:
        with np.errstate(divide="ignore"):
            return A * np.asarray(phi) ** b + C

    def float_mu(phi: float) -> float:
        return float(A * phi**b + C)

    judged = partial(against, exact)

    def closed_form() -> FloatArray:
        with np.errstate(divide="ignore"):  # a start at zero
            return A * PowerSpan(np.log(p), delta, b).integral() + C * delta

    def by(rule: Callable[..., FloatArray]) -> Callable[..., FloatArray]:
        return lambda n, function: rule(function, p, delta, n)

    pieces = [n for n in _PIECES if n <= most_pieces]
    tolerances = (1e-4, 1e-8, 1e-12) if copies == 1 else (1e-8,)
    return (
        *judged("segment sum", "{} pieces", by(segment_sum), mu, over=pieces),
        *judged("trapezoid", "{} pieces", by(trapezoid), mu, over=pieces),
        *judged("gauss-legendre", "{} points", by(gauss_legendre), mu, over=_ORDERS),
        *judged(
            "adaptive quad", "tolerance {:g}", by(adaptive), float_mu, over=tolerances, quick=copies == 1
        ),
        *judged("closed form", "", closed_form),
    )


def _case(name: str, title: str, *problem: Any, **more: int) -> Case:
    return Case(name, f"one condition, {title}", partial(_settings, *problem, **more))


STUDY = Study(
    name="integral",
    title="Lift-force integral of the power law μ = 0.2 φ^b + 0.1 over the wrap",
    question="Is the closed form better than the paper's segments and than quadrature rules?",
    reference="closed form in 50-digit arithmetic (mpmath)",
    counted="evaluations of μ(φ)",
    used="closed form, in its stable form; a hoist's plan takes it at every accuracy",
    cases=(
        _case("regular", "b = −0.5, wrap of 9.4 rad from φ0 = 1.7 rad (F_B = 2 N)", (1.7,), (9.4,), (REGULAR,)),
        Case(
            "many",
            "10 000 conditions at once, b = −0.5, wraps of 1.5 and 12 rad from φ0 = 0.5 to 15 rad",
            partial(_settings, np.repeat((0.5, 1.7, 5.0, 15.0), 2), (1.5, 12.0) * 4, MANY,
                    copies=COPIES, most_pieces=_MOST_PIECES),
        ),
        _case("from-zero", "b = −0.5, wrap of 9.4 rad from φ0 = 0 (F_B = F_0): μ is infinite at the start",
              (0.0,), (9.4,), (FROM_ZERO,)),
        _case("near-minus-one", "b = −1 + 1e-12, wrap of 9.4 rad from φ0 = 0.001 rad",
              (1e-3,), (9.4,), (NEAR_MINUS_ONE,), NEARLY),
        _case("short-wrap", "b = −0.5, wrap of 1e-6 rad from φ0 = 10 rad: a step of a longer sum",
              (10.0,), (1e-6,), (SHORT_WRAP,), most_pieces=_MOST_PIECES),
    ),
)  # fmt: skip
