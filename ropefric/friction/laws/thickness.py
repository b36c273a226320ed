"""Finite rope thickness: Euler's equation with the moment balance taken about the axle."""

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.friction.condition import Conditions
from ropefric.friction.law import Columns, FrictionLaw, Parameter, Sheet, Slopes
from ropefric.friction.laws.constant import Uniform, mu_times_wrap


def _parts(columns: Columns, conditions: Conditions) -> tuple[FloatArray, ...]:
    """Return μ, A = R_r/(R_w + R_r), 1 − A, whose digits a difference would cancel for small wheels, and the root S."""
    (mu,), r = columns, conditions.size_ratio
    A, B = 1.0 / (1.0 + r), 1.0 / (1.0 + 1.0 / r)
    return mu, A, B, np.sqrt(1.0 + 4.0 * A * B * mu**2)


class Thickness(Uniform):
    """The physics of λ, the root of A μ λ² + λ = μ (1 − A), in place of μ."""

    def mu(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return the coefficient."""
        # λ = [−1 + S]/(2Aμ) rationalised, so that it keeps its digits for thin ropes and small μ
        mu, _A, B, S = _parts(columns, conditions)
        return 2.0 * mu * B / (1.0 + S)

    def mu_slopes(self, columns: Columns, conditions: Conditions) -> Slopes:
        """Return its derivatives."""
        _mu, _A, B, S = _parts(columns, conditions)
        return (2.0 * B / (S * (1.0 + S)),)

    def mu_by_radius(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return its derivative by R_w [1/m]."""
        mu, A, B, S = _parts(columns, conditions)
        by_share = -2.0 * mu / (1.0 + S) * (1.0 + 2.0 * mu**2 * B * (B - A) / (S * (1.0 + S)))
        return -by_share * A / conditions.centreline_radius_m


def _by_hand(sheet: Sheet) -> float:
    if sheet["mu"] > 0.0:
        sheet.line("A", "R_r/(R_w + R_r)")
        sheet.line("S", "sqrt(1 + 4 * A * mu^2 * (1 - A))")
        # The rationalised form: (S − 1)/(2 A mu) would lose the digits of the printed S.
        sheet.line("lambda", "2 * mu * (1 - A)/(1 + S)", "mu")
    return mu_times_wrap(sheet)


def _candidates(mu: float, _conditions: Conditions, _log_lift: FloatArray) -> FloatArray:
    return mu * np.array([[1.0], [1.2], [1.6]])


LAW = FrictionLaw(
    name="thickness",
    equation="lambda = (-1 + sqrt(1 + 4 A mu^2 (1 - A)))/(2 A mu), A = R_r/(R_w + R_r); F_A = F_B exp(lambda phi)",
    source="moment balance of a rope of finite thickness about the axle",
    parameters=(
        Parameter("mu", "-", 0.2, 0.0, 5.0,
                  "coefficient at the contact; the exponent per radian lambda is smaller"),
    ),
    coefficient="average",
    effects=frozenset({"size"}),
    weakens=True,
    physics=Thickness(),
    candidates=_candidates,
    arithmetic=_by_hand,
)  # fmt: skip
