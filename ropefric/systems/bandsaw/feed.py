"""The limit under feed force: the push on the teeth at which a blade turns out of its plane and buckles sideways.

A force Q on the edge, at mid-span, bends the blade edgewise by m(x) Q, the moment of a pinned beam under the tension
P = F − ρA v². The blade gives way by a deflection u and a twist φ, whose energy per length is

    ½ EI u'' ² + ½ P u' ² + ½ (G J + P r²) φ' ² + Q m φ u'',   J = b h³/3,   r² = (b² + h²)/12,

less the work ½ Q e φ² that the force, standing off by e = b/2, does at mid-span (lateral buckling after Timoshenko and
Gere, Theory of Elastic Stability, 6.3, with the tension's part). The least Q at which it is no longer positive is the
limit; buckling is static, so that of a running blade only its net tension matters.
"""

import math

import numpy as np
import scipy.linalg
from numpy.polynomial import legendre

from ropefric.arrays import FloatArray
from ropefric.errors import SolverError
from ropefric.systems.bandsaw.saw import Section
from ropefric.systems.bandsaw.span import Ends

_ORDERS = (24, 48, 96, 192)
_SETTLED = 1e-9
_LEAST = 1e-9
"""Tension below which a blade may as well have none, of EI/l²."""


def feed_limit_N(
    net_tension_N: FloatArray, section: Section, ends: Ends, length_m: float, offset_m: float | None = None
) -> FloatArray:
    """Return the force on the edge at mid-span at which blades between guides buckle, shape (n,) [N].

    `offset_m` is how far from the middle of the blade it acts; half the width if not given.
    """
    e = 0.5 * section.width_m if offset_m is None else offset_m
    found = [
        _limit_N(float(one), section, ends, length_m=length_m, e=e) for one in np.atleast_1d(net_tension_N)
    ]
    return np.array(found, dtype=np.float64)


def _limit_N(P: float, section: Section, ends: Ends, *, length_m: float, e: float) -> float:
    before = math.inf
    for order in _ORDERS:
        found = _at_order(P, section, ends, order, length_m=length_m, e=e)
        if abs(found - before) <= _SETTLED * found:
            return found
        before = found
    raise SolverError(
        f"the limit under feed force does not settle; it is about {before:.4g} N",
        key="preload_N",
        fix="a blade under so much tension has next to no stiffness of its own",
    )


def _at_order(P: float, section: Section, ends: Ends, order: int, *, length_m: float, e: float) -> float:
    """Return the limit by polynomials on half the span: u'' and φ' are Legendre's, so held ends are kept exactly."""
    b, h = section.width_m, section.thickness_m
    EI = section.bending_stiffness_N_m2
    twist = section.shear_modulus_Pa * b * h**3 / 3.0 + P * (b**2 + h**2) / 12.0
    half_m, each = 0.5 * length_m, np.eye(order)
    points, weights = legendre.leggauss(order + 32)
    scale = 0.5 * half_m  # of dx on −1 … 1
    x, weights = scale * (points + 1.0), scale * weights
    # u' vanishes at mid-span; at a clamp, too: then u'' has no mean.
    curved = each if ends.turns else each[1:]
    bent = legendre.legval(points, curved.T)
    slope = scale * legendre.legval(points, legendre.legint(curved.T, lbnd=1.0))
    turned = scale * legendre.legval(points, legendre.legint(each, lbnd=-1.0))
    turning = legendre.legval(points, each)
    k = math.sqrt(max(abs(P), _LEAST * EI / length_m**2) / (EI * (b / h) ** 2))
    # sinh(kx)/(2k cosh(kl/2)), which does not overflow; a blade near its critical speed is under slight compression.
    moment = np.sin(k * x) / (2.0 * k * math.cos(k * half_m))
    if P >= 0.0:
        damped = np.exp(k * (x - half_m)) * -np.expm1(-2.0 * k * x)
        moment = damped / (2.0 * k * (1.0 + math.exp(-2.0 * k * half_m)))
    coupling = (bent * (weights * moment)) @ turned.T
    at_middle = scale * legendre.legval(1.0, legendre.legint(each, lbnd=-1.0))
    stiff = [
        EI * (bent * weights) @ bent.T + P * (slope * weights) @ slope.T,
        twist * (turning * weights) @ turning.T,
    ]
    n = len(curved)
    push = np.zeros((n + order, n + order))
    push[:n, n:], push[n:, :n] = -coupling, -coupling.T
    push[n:, n:] = 0.5 * e * np.outer(at_middle, at_middle)
    # Positive on one side and symmetric on both: the greatest 1/Q.
    last = n + order - 1
    inverse = scipy.linalg.eigh(
        push, scipy.linalg.block_diag(*stiff), eigvals_only=True, subset_by_index=[last, last]
    )
    return 1.0 / float(inverse[0])
