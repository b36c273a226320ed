"""Eq. (16): size and wrap together, with the end tension counted as wrap."""

from functools import partial

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.friction.condition import Conditions
from ropefric.friction.law import FrictionLaw
from ropefric.friction.power_wrap import PowerWrap, exponent_parameter, plateau_parameter
from ropefric.friction.size import (
    SIZE_PARAMETERS,
    exponential_size,
    exponential_size_by_radius,
    exponential_size_slopes,
    size_candidates,
)
from ropefric.friction.start import mean_mu, product, searched_start
from ropefric.friction.variant import with_variant


def _candidates(conditions: Conditions, log_lift: FloatArray) -> FloatArray:
    mu = mean_mu(conditions, log_lift)
    return product(
        mu * np.array([1.0, 2.0, 4.0]),
        *size_candidates(conditions),
        [-0.75, -0.4, -0.1],
        mu * np.array([0.1, 0.6]),
    )


LAW = with_variant(
    FrictionLaw(
        name="coupled",
        equation="mu(phi) = mu_R phi^c + d, mu_R = mu_inf (1 - exp(a R_w/R_r + b)); "
        "F_A = F_B exp(integral of mu from phi0 to phi0 + phi)",
        source="PRTH friction and lift-force model, eqs. (16), (17), in the bracket of eq. (4)",
        parameters=(*SIZE_PARAMETERS, exponent_parameter("c"), plateau_parameter("d")),
        coefficient="local",
        effects=frozenset({"size", "wrap-dependence", "end-tension"}),
        physics=PowerWrap(
            strength=exponential_size,
            strength_slopes=exponential_size_slopes,
            strength_by_radius=exponential_size_by_radius,
            equivalence=True,
            why_negative="a R_w/R_r + b is above 0 there, so e^(a r + b) > 1",
        ),
        start=partial(searched_start, candidates=_candidates),
    )
)
