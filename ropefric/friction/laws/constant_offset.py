"""A constant coefficient with a constant offset of ln F: a bearing's friction, a cell's gain error."""

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.friction.condition import Conditions
from ropefric.friction.law import Columns, FrictionLaw, Parameter, Sheet, Slopes
from ropefric.friction.laws.constant import LAW as CONSTANT
from ropefric.friction.laws.constant import Uniform


class Offset(Uniform):
    """The physics of ln F_A = ln F_B + μ φ + k.

    The average coefficient over the wrap is μ + k/φ, which is a wrap effect with exponent −1 to the eye; the
    local one is μ. k may have either sign.
    """

    def rise(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return μ φ + k."""
        return columns[0] * conditions.wrap_angle_rad + columns[1]

    def rise_and_slopes(self, columns: Columns, conditions: Conditions) -> tuple[FloatArray, Slopes]:
        """Return μ φ + k and ∂ by μ and k."""
        return self.rise(columns, conditions), (conditions.wrap_angle_rad, np.array(1.0))


def _candidates(mu: float, _conditions: Conditions, _log_lift: FloatArray) -> list[list[float]]:
    return [[mu, 0.0]]


def _arithmetic(sheet: Sheet) -> float:
    return sheet.line("mu phi + k", "mu * phi + k")


LAW = FrictionLaw(
    name="constant-offset",
    equation="F_A = F_B exp(mu phi + k)",
    source="eq. (2) with a constant in ln F",
    parameters=(
        Parameter("mu", "-", 0.2, 0.0, 5.0, "friction coefficient; local"),
        Parameter("k", "-", 0.0, -5.0, 5.0,
                  "offset of ln F_A: bearing friction or a gain error, the same at every wrap"),
    ),
    coefficient="local",
    effects=frozenset({"offset"}),
    physics=Offset(),
    candidates=_candidates,
    special_cases=(CONSTANT,),
    arithmetic=_arithmetic,
)  # fmt: skip
