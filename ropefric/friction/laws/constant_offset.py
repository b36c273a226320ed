"""A constant coefficient with a constant offset of ln F: a bearing's friction, a cell's gain error."""

from collections.abc import Iterable

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.friction.arithmetic import Sheet
from ropefric.friction.condition import Conditions
from ropefric.friction.law import Columns, FrictionLaw, Parameter, Refusal
from ropefric.friction.laws.constant import LAW as CONSTANT


class Offset:
    """The physics of ln F_A = ln F_B + μ φ + k.

    The average coefficient over the wrap is μ + k/φ, which is a wrap effect with exponent −1 to the eye; the
    local one is μ.
    """

    def rise(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return μ φ + k."""
        mu, k = columns
        return mu * conditions.wrap_angle_rad + k

    def rise_and_slopes(
        self, columns: Columns, conditions: Conditions
    ) -> tuple[FloatArray, tuple[FloatArray, ...]]:
        """Return μ φ + k and ∂ by μ and k."""
        return self.rise(columns, conditions), (conditions.wrap_angle_rad, np.array(1.0))

    def condition_slopes(
        self, columns: Columns, _conditions: Conditions
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return ∂ ln F_A by R_w, φ and ln F_B."""
        return np.array(0.0), columns[0], np.array(1.0)

    def local_mu(self, columns: Columns, wrap_rad: FloatArray, _conditions: Conditions) -> FloatArray:
        """Return μ."""
        return columns[0] + 0.0 * wrap_rad

    def refusals(self, columns: Columns, _conditions: Conditions) -> Iterable[Refusal]:
        """Yield where μ is negative; k may have either sign."""
        mu = columns[0]
        yield Refusal(mu < 0.0, mu, "the coefficient is {value}, negative", "keep it at zero or more")


def _candidates(mu: float, _conditions: Conditions, _log_lift: FloatArray) -> FloatArray:
    return np.array([[mu, 0.0]])


def _by_hand(sheet: Sheet) -> float:
    return sheet.line("mu phi + k", "mu * phi + k")


LAW = FrictionLaw(
    name="constant-offset",
    equation="F_A = F_B exp(mu phi + k)",
    source="eq. (2) with a constant in ln F",
    parameters=(
        Parameter("mu", "-", start=0.2, lower=0.0, upper=5.0, meaning="friction coefficient; local"),
        Parameter(
            "k",
            "-",
            start=0.0,
            lower=-5.0,
            upper=5.0,
            meaning="offset of ln F_A: bearing friction or a gain error, the same at every wrap",
        ),
    ),
    coefficient="local",
    effects=frozenset({"offset"}),
    physics=Offset(),
    candidates=_candidates,
    special_cases=(CONSTANT,),
    arithmetic=_by_hand,
)
