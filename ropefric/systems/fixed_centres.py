"""Belts between fixed centres: a belt keeps the unstretched length that it had at rest under its pretension.

With strain T/EA the unstretched length is ∮ ds/(1 + T/EA) along spans and arcs. Where the belt creeps steadily, it
adheres to a pulley with the tension T_in with which it arrives, and slips over the last part of the arc. There
T' = T − ρAv² changes as e^(μθ) from its value before the pulley to that behind it, over θ = |ln(T'_out/T'_in)|/μ.

Over the slip arc s = ln(T'_out/T'_in), the share x of it has T = a + b e^(s x) with b = ΔT/(e^s − 1), and

    ∫ (T0 − T)/(1 + T/EA) dx = (T0 − a − (EA + T0) ln((EA + T_out)/(EA + T_in))/s) / (1 + a/EA).
"""

import numpy as np

from ropefric.arrays import FloatArray

_CRUSHED = -0.999
"""The least change of a belt's length that is followed: its tensions have an answer wherever a search for them goes."""


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
    that it runs onto. `growth` is ln(T'_out/T'_in) on the arc, `exponent` its whole ∫ μ dφ. EA may be infinite.
    """
    rest_N, softness_1_N = (
        np.asarray(one)[..., np.newaxis] for one in (pretension_N, 1.0 / axial_stiffness_N)
    )
    growth = np.clip(growth, -exponent, exponent)  # beyond, the belt slips on the whole arc
    slipping_m = arc_m * np.divide(np.abs(growth), exponent, out=np.zeros(growth.shape), where=exponent > 0.0)
    adhering_N_m = (span_m + arc_m - slipping_m) * (rest_N - arriving_N) / (1.0 + softness_1_N * arriving_N)
    steep = np.where(growth == 0.0, 1.0, growth)  # without growth no part slips
    gain_N = leaving_N - arriving_N
    still_N = arriving_N - gain_N / np.expm1(steep)
    stretch = 1.0 + softness_1_N * arriving_N
    gain = np.maximum(softness_1_N * gain_N / stretch, _CRUSHED)
    flatter = np.divide(np.log1p(gain), gain, out=np.ones(gain.shape), where=gain != 0.0)
    mean_N = rest_N - still_N - (1.0 + softness_1_N * rest_N) * gain_N / steep * flatter / stretch
    return np.asarray((adhering_N_m + slipping_m * mean_N / (1.0 + softness_1_N * still_N)).sum(axis=-1))
