"""Eq. (3): the coefficient grows with the wheel as a power of R_w/(R_w + R_r)."""

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.friction.condition import Conditions
from ropefric.friction.law import Columns, FrictionLaw, Parameter, Sheet, Slopes, combinations
from ropefric.friction.laws.constant import LAW as CONSTANT
from ropefric.friction.laws.constant import Uniform, mu_times_wrap


def _log_share(conditions: Conditions) -> FloatArray:
    """Return ln(R_w/(R_w + R_r)), without loss for very large wheels."""
    return -np.log1p(1.0 / conditions.size_ratio)


class PowerSize(Uniform):
    """The physics of μ = μ∞ (R_w/(R_w + R_r))^a + b."""

    def mu(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return the coefficient."""
        mu_inf, a, b = columns
        return mu_inf * np.exp(a * _log_share(conditions)) + b

    def mu_slopes(self, columns: Columns, conditions: Conditions) -> Slopes:
        """Return its derivatives."""
        mu_inf, a, _b = columns
        share = _log_share(conditions)
        power = np.exp(a * share)
        return power, mu_inf * power * share, np.array(1.0)

    def mu_by_radius(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return its derivative by R_w [1/m]."""
        mu_inf, a, _b = columns
        # d ln(R_w/(R_w + R_r))/dR_w = R_r/(R_w (R_w + R_r)), written so that neither a product of radii nor the
        # power by itself underflows
        by_wheel = np.exp(a * _log_share(conditions) - np.log(conditions.wheel_radius_m))
        return mu_inf * a * by_wheel / (1.0 + conditions.size_ratio)


def _candidates(mu: float, _conditions: Conditions, _log_lift: FloatArray) -> FloatArray:
    return combinations(
        mu * np.array([0.5, 1.0, 1.5]), [0.3, 1.0, 3.0, 10.0], mu * np.array([0.02, 0.3, 0.8])
    )


def _by_hand(sheet: Sheet) -> float:
    sheet.line("R_w/(R_r + R_w)", "R_w/(R_r + R_w)", "share")
    sheet.line("mu", "mu_inf * share^a + b")
    return mu_times_wrap(sheet)


LAW = FrictionLaw(
    name="size-power",
    equation="mu = mu_inf (R_w/(R_w + R_r))^a + b; F_A = F_B exp(mu phi)",
    source="PRTH friction and lift-force model, eq. (3)",
    parameters=(
        Parameter("mu_inf", "-", 0.2, 0.0, 5.0,
                  "part of μ that grows with the wheel; only mu_inf + b and mu_inf a are seen for large wheels"),
        Parameter("a", "-", 1.0, 0.0, 50.0, "exponent of the size effect"),
        Parameter("b", "-", 0.02, 0.0, 5.0, "part of μ that the wheel leaves alone"),
    ),
    coefficient="average",
    effects=frozenset({"size"}),
    weakens=True,
    physics=PowerSize(),
    candidates=_candidates,
    special_cases=(CONSTANT,),
    arithmetic=_by_hand,
)  # fmt: skip
