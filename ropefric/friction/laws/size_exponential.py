"""Eq. (4): the coefficient approaches that of a very large wheel exponentially in R_w/R_r."""

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.friction.condition import Conditions
from ropefric.friction.law import Columns, FrictionLaw, Parameter, Sheet, Slopes, combinations
from ropefric.friction.laws.constant import LAW as CONSTANT
from ropefric.friction.laws.constant import Uniform, mu_times_wrap

SIZE_PARAMETERS = (
    Parameter("mu_inf", "-", 0.2, 0.0, 5.0, "coefficient of a very large wheel"),
    Parameter("a", "-", -0.2, -20.0, 0.0, "rate of the size effect per unit of R_w/R_r"),
    Parameter("b", "-", -0.3, -20.0, 0.0,
              "strength of the size effect as ln: 0 no friction on a vanishing wheel, very negative none"),
)  # fmt: skip
"""μ∞, a and b of eq. (4); at b <= 0 no wheel is too small to have a coefficient."""


class ExponentialSize(Uniform):
    """The physics of μ_R = μ∞ (1 − e^{a r + b}) of the first three parameters, eq. (4)."""

    why_negative = "a R_w/R_r + b is above 0 there, so e^(a r + b) > 1"

    def mu(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return μ_R = μ∞ (1 − e^{a r + b}) of the first three columns, eq. (4)."""
        mu_inf, a, b = columns[:3]
        return -mu_inf * np.expm1(a * conditions.size_ratio + b)

    def mu_slopes(self, columns: Columns, conditions: Conditions) -> Slopes:
        """Return ∂μ_R by μ∞, a and b."""
        mu_inf, a, b = columns[:3]
        r = conditions.size_ratio
        exponent = a * r + b
        by_b = -mu_inf * np.exp(exponent)
        return -np.expm1(exponent), r * by_b, by_b

    def mu_by_radius(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return ∂μ_R/∂R_w [1/m]."""
        mu_inf, a, b = columns[:3]
        return -mu_inf * a * np.exp(a * conditions.size_ratio + b) / conditions.rope_radius_m


def size_candidates(conditions: Conditions) -> tuple[FloatArray, FloatArray]:
    """Return values of a and b worth trying on these wheels."""
    r = float(np.median(conditions.size_ratio))
    return np.array([-4.0, -1.5, -0.5, -0.15]) / r, np.array([-3.0, -1.0, -0.2])


def _candidates(mu: float, conditions: Conditions, _log_lift: FloatArray) -> FloatArray:
    return combinations(mu * np.array([1.0, 1.3, 2.0]), *size_candidates(conditions))


def coefficient_by_hand(sheet: Sheet, name: str) -> float:
    """Write μ_R of these conditions."""
    sheet.line("r", "R_w/R_r")
    return sheet.line(name, "mu_inf * (1 - exp(a * r + b))")


def _by_hand(sheet: Sheet) -> float:
    coefficient_by_hand(sheet, "mu")
    return mu_times_wrap(sheet)


LAW = FrictionLaw(
    name="size-exponential",
    equation="mu = mu_inf (1 - exp(a R_w/R_r + b)); F_A = F_B exp(mu phi)",
    source="PRTH friction and lift-force model, eq. (4)",
    parameters=SIZE_PARAMETERS,
    coefficient="average",
    effects=frozenset({"size"}),
    weakens=True,
    physics=ExponentialSize(),
    candidates=_candidates,
    special_cases=(CONSTANT,),
    arithmetic=_by_hand,
)
