"""Eq. (4): the coefficient approaches that of a very large wheel exponentially in R_w/R_r."""

from functools import partial

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.friction.condition import Conditions
from ropefric.friction.law import FrictionLaw
from ropefric.friction.size import (
    SIZE_PARAMETERS,
    exponential_size,
    exponential_size_by_radius,
    exponential_size_slopes,
    size_candidates,
)
from ropefric.friction.start import mean_mu, product, searched_start
from ropefric.friction.uniform import Uniform


def _candidates(conditions: Conditions, log_lift: FloatArray) -> FloatArray:
    mu = mean_mu(conditions, log_lift)
    return product(mu * np.array([1.0, 1.3, 2.0]), *size_candidates(conditions))


LAW = FrictionLaw(
    name="size-exponential",
    equation="mu = mu_inf (1 - exp(a R_w/R_r + b)); F_A = F_B exp(mu phi)",
    source="PRTH friction and lift-force model, eq. (4)",
    parameters=SIZE_PARAMETERS,
    coefficient="average",
    effects=frozenset({"size"}),
    physics=Uniform(
        mu=exponential_size,
        mu_slopes=exponential_size_slopes,
        mu_by_radius=exponential_size_by_radius,
        why_negative="a R_w/R_r + b is above 0 there, so e^(a r + b) > 1",
    ),
    start=partial(searched_start, candidates=_candidates),
)
