"""Eq. (16): size and wrap together, with the end tension counted as wrap."""

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.friction.condition import Conditions
from ropefric.friction.law import FrictionLaw, Sheet, combinations, with_variant
from ropefric.friction.laws import size_exponential, wrap_power
from ropefric.friction.laws.constant import LAW as CONSTANT


def _candidates(mu: float, conditions: Conditions, _log_lift: FloatArray) -> FloatArray:
    return combinations(
        mu * np.array([1.0, 2.0, 4.0]),
        *size_exponential.size_candidates(conditions),
        [-0.75, -0.4, -0.1],
        mu * np.array([0.1, 0.6]),
    )


def _by_hand(sheet: Sheet) -> float:
    size_exponential.coefficient_by_hand(sheet, "mu_R")
    return wrap_power.power_by_hand(sheet, "mu_R", "c", "d")


LAW = with_variant(
    FrictionLaw(
        name="coupled",
        equation="mu(phi) = mu_R phi^c + d, mu_R = mu_inf (1 - exp(a R_w/R_r + b)); "
        "F_A = F_B exp(integral of mu from phi0 to phi0 + phi)",
        source="PRTH friction and lift-force model, eqs. (16), (17), in the bracket of eq. (4)",
        parameters=(
            *size_exponential.SIZE_PARAMETERS,
            wrap_power.exponent_parameter("c"),
            wrap_power.plateau_parameter("d"),
        ),
        coefficient="local",
        effects=frozenset({"size", "wrap-dependence", "end-tension"}),
        weakens=True,
        physics=wrap_power.PowerWrap(strength=size_exponential.ExponentialSize(), equivalence=True),
        candidates=_candidates,
        special_cases=(CONSTANT, size_exponential.LAW, wrap_power.LAW),
        arithmetic=_by_hand,
    )
)
