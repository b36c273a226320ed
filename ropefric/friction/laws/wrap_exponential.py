"""Eq. (14): the local coefficient falls exponentially with the wrap angle."""

from functools import partial

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.friction.condition import Conditions
from ropefric.friction.exponential_wrap import ExponentialWrap
from ropefric.friction.law import FrictionLaw
from ropefric.friction.parameter import Parameter
from ropefric.friction.power_wrap import plateau_parameter
from ropefric.friction.start import mean_mu, product, searched_start
from ropefric.friction.variant import with_variant


def _candidates(conditions: Conditions, log_lift: FloatArray) -> FloatArray:
    mu = mean_mu(conditions, log_lift)
    turn = float(conditions.wrap_angle_rad.max()) or 1.0
    return product(
        mu * np.array([0.3, 1.0, 3.0]),
        np.array([-6.0, -2.0, -0.7, -0.2]) / turn,
        mu * np.array([0.2, 0.6, 0.9]),
    )


LAW = with_variant(
    FrictionLaw(
        name="wrap-exponential",
        equation="mu(phi) = a exp(b phi) + c; F_A = F_B exp(integral of mu from phi0 to phi0 + phi)",
        source="PRTH friction and lift-force model, eqs. (14), (17)",
        parameters=(
            Parameter(
                name="a",
                unit="-",
                start=0.1,
                lower=0.0,
                upper=5.0,
                meaning="part of the local μ at zero wrap that falls; with one load it is confounded with F_0",
            ),
            Parameter(name="b", unit="1/rad", start=-0.2, lower=-20.0, upper=0.0, meaning="rate of the fall"),
            # A trace of a plateau, because with none at all the integral saturates and a large F_B has no φ0.
            plateau_parameter("c", lower=1e-6),
        ),
        coefficient="local",
        effects=frozenset({"wrap-dependence", "end-tension"}),
        physics=ExponentialWrap(equivalence=True),
        start=partial(searched_start, candidates=_candidates),
    )
)
