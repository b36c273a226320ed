"""Eq. (2): one coefficient for every wheel, wrap and load."""

from functools import partial

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.friction.condition import Conditions
from ropefric.friction.law import FrictionLaw
from ropefric.friction.parameter import Parameter
from ropefric.friction.size import same_for_all, same_for_all_slopes, unmoved_by_radius
from ropefric.friction.start import mean_mu, searched_start
from ropefric.friction.uniform import Uniform


def _candidates(conditions: Conditions, log_lift: FloatArray) -> FloatArray:
    return np.array([[mean_mu(conditions, log_lift)]])


LAW = FrictionLaw(
    name="constant",
    equation="F_A = F_B exp(mu phi)",
    source="Euler's capstan equation; PRTH friction and lift-force model, eq. (2)",
    parameters=(
        Parameter(name="mu", unit="-", start=0.2, lower=0.0, upper=5.0, meaning="friction coefficient"),
    ),
    coefficient="average",
    effects=frozenset(),
    physics=Uniform(mu=same_for_all, mu_slopes=same_for_all_slopes, mu_by_radius=unmoved_by_radius),
    start=partial(searched_start, candidates=_candidates),
)
