"""Eq. (15): the local coefficient falls as a power of the wrap angle."""

from functools import partial

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.friction.condition import Conditions
from ropefric.friction.law import FrictionLaw
from ropefric.friction.parameter import Parameter
from ropefric.friction.power_wrap import PowerWrap, exponent_parameter, plateau_parameter
from ropefric.friction.size import same_for_all, same_for_all_slopes, unmoved_by_radius
from ropefric.friction.start import mean_mu, product, searched_start
from ropefric.friction.variant import with_variant


def _candidates(conditions: Conditions, log_lift: FloatArray) -> FloatArray:
    mu = mean_mu(conditions, log_lift)
    return product(mu * np.array([0.3, 1.0, 3.0]), [-0.9, -0.6, -0.3, -0.1], mu * np.array([0.05, 0.4, 0.8]))


LAW = with_variant(
    FrictionLaw(
        name="wrap-power",
        equation="mu(phi) = a phi^b + c; F_A = F_B exp(integral of mu from phi0 to phi0 + phi)",
        source="PRTH friction and lift-force model, eqs. (15), (17)",
        parameters=(
            Parameter(
                name="a",
                unit="-",
                start=0.2,
                lower=0.0,
                upper=5.0,
                meaning="part of the local μ at 1 rad that falls with the wrap",
            ),
            exponent_parameter("b"),
            plateau_parameter("c"),
        ),
        coefficient="local",
        effects=frozenset({"wrap-dependence", "end-tension"}),
        physics=PowerWrap(
            strength=same_for_all,
            strength_slopes=same_for_all_slopes,
            strength_by_radius=unmoved_by_radius,
            equivalence=True,
            why_negative="a must be zero or more",
        ),
        start=partial(searched_start, candidates=_candidates),
    )
)
