"""A V-groove wedges the rope: the coefficient acts as μ/sin(half angle)."""

from functools import partial

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.friction.condition import Conditions
from ropefric.friction.law import FrictionLaw
from ropefric.friction.parameter import Parameter
from ropefric.friction.physics import Columns
from ropefric.friction.size import unmoved_by_radius
from ropefric.friction.start import mean_mu, searched_start
from ropefric.friction.uniform import Uniform

_HALF_ANGLE_RAD = float(np.radians(20.0))


def _effective(columns: Columns, conditions: Conditions) -> FloatArray:
    mu, half_angle = columns
    return mu / np.sin(half_angle) + 0.0 * conditions.wrap_angle_rad


def _slopes(columns: Columns, _conditions: Conditions) -> tuple[FloatArray, ...]:
    mu, half_angle = columns
    sine = np.sin(half_angle)
    return 1.0 / sine, -mu * np.cos(half_angle) / sine**2


def _candidates(conditions: Conditions, log_lift: FloatArray) -> FloatArray:
    return np.array([[mean_mu(conditions, log_lift) * np.sin(_HALF_ANGLE_RAD), _HALF_ANGLE_RAD]])


LAW = FrictionLaw(
    name="groove",
    equation="F_A = F_B exp(mu phi/sin(half_angle))",
    source="V-groove form of Euler's equation",
    parameters=(
        Parameter(
            name="mu",
            unit="-",
            start=0.07,
            lower=0.0,
            upper=5.0,
            meaning="coefficient at the flanks of the groove",
        ),
        Parameter(
            name="half_angle",
            unit="rad",
            start=_HALF_ANGLE_RAD,
            lower=0.02,
            upper=float(np.pi / 2),
            meaning="half the groove's angle; only mu/sin(half_angle) is seen, so measure it and hold it fixed",
            fixed=True,
        ),
    ),
    coefficient="average",
    effects=frozenset({"groove"}),
    physics=Uniform(mu=_effective, mu_slopes=_slopes, mu_by_radius=unmoved_by_radius),
    start=partial(searched_start, candidates=_candidates),
)
