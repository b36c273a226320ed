"""Belts between fixed centres: a belt keeps the unstretched length that it had at rest under its pretension.

With strain T/EA the unstretched length is ∮ ds/(1 + T/EA) along spans and arcs. Where the belt creeps steadily, it
adheres to a pulley with the tension T_in with which it arrives, and slips over the last part of the arc. There
T' = T − ρAv² changes as e^(μθ) from its value before the pulley to that behind it, over θ = |ln(T'_out/T'_in)|/μ.
"""

from functools import cache

import numpy as np

from ropefric.arrays import FloatArray

_NODES = 24


@cache
def _nodes() -> tuple[FloatArray, FloatArray]:
    """Return Gauss-Legendre nodes and weights from 0 to 1."""
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    return 0.5 * (nodes + 1.0), 0.5 * weights


def excess_of_length(
    pretension_N: FloatArray,
    axial_stiffness_N: float | FloatArray,
    *,
    span_m: FloatArray,
    arc_m: FloatArray,
    arriving_N: FloatArray,
    leaving_N: FloatArray,
    growth: FloatArray,
    exponent: FloatArray,
) -> FloatArray:
    """Return ∮ (T0 − T)/(1 + T/EA) ds [N m], shape (...).

    It is zero where the belt has its unstretched length. The last axis follows the belt round: each span, and the arc
    that it runs onto. `growth` is ln(T'_out/T'_in) on the arc, `exponent` its whole ∫ μ dφ.
    """
    span_m, arc_m, arriving_N, leaving_N, growth, exponent = np.broadcast_arrays(
        span_m, arc_m, arriving_N, leaving_N, growth, exponent
    )
    growth = np.clip(growth, -exponent, exponent)  # beyond, the belt slips on the whole arc
    slips = np.divide(np.abs(growth), exponent, out=np.zeros(growth.shape), where=exponent > 0.0)
    place, weight = _nodes()
    share = np.broadcast_to(place, (*growth.shape, _NODES)).copy()
    steep = growth[..., np.newaxis]
    np.divide(np.expm1(steep * place), np.expm1(steep), out=share, where=steep != 0.0)
    slipping_N = arriving_N[..., np.newaxis] + (leaving_N - arriving_N)[..., np.newaxis] * share
    slipping_m = (arc_m * slips)[..., np.newaxis] * weight
    whole = (*growth.shape[:-1], -1)
    length_m = np.concatenate([span_m + arc_m * (1.0 - slips), slipping_m.reshape(whole)], axis=-1)
    tension_N = np.concatenate([arriving_N, slipping_N.reshape(whole)], axis=-1)
    rest_N, stiffness_N = (np.asarray(one)[..., np.newaxis] for one in (pretension_N, axial_stiffness_N))
    return np.asarray((length_m * (rest_N - tension_N) / (1.0 + tension_N / stiffness_N)).sum(axis=-1))
