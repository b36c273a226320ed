"""Eq. (2): one coefficient for every wheel, wrap and load; and the physics of every coefficient that is uniform."""

from collections.abc import Iterable

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.friction.condition import Conditions
from ropefric.friction.law import Columns, FrictionLaw, Parameter, Refusal, Sheet, Slopes, negative


class Uniform:
    """The physics of a coefficient that depends on the parameters and the size of the wheel alone.

    Local and average coefficient are the same. This one is the first parameter itself, whatever the wheel; others say
    what theirs is.
    """

    why_negative = "friction cannot push the rope forward"

    def mu(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return the coefficient."""
        return columns[0] + 0.0 * conditions.wrap_angle_rad

    def mu_slopes(self, _columns: Columns, _conditions: Conditions) -> Slopes:
        """Return its derivative by each parameter that it depends on."""
        return (np.array(1.0),)

    def mu_by_radius(self, _columns: Columns, _conditions: Conditions) -> FloatArray:
        """Return its derivative by R_w [1/m]."""
        return np.array(0.0)

    def rise(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return μ φ."""
        return self.mu(columns, conditions) * conditions.wrap_angle_rad

    def rise_and_slopes(self, columns: Columns, conditions: Conditions) -> tuple[FloatArray, Slopes]:
        """Return μ φ and ∂μ φ by each parameter."""
        slopes = tuple(slope * conditions.wrap_angle_rad for slope in self.mu_slopes(columns, conditions))
        return self.rise(columns, conditions), slopes

    def condition_slopes(self, columns: Columns, conditions: Conditions) -> Slopes:
        """Return ∂ ln F_A by R_w, φ and ln F_B."""
        by_radius = self.mu_by_radius(columns, conditions) * conditions.wrap_angle_rad
        return by_radius, self.mu(columns, conditions), np.array(1.0)

    def refusals(self, columns: Columns, conditions: Conditions) -> Iterable[Refusal]:
        """Yield where μ is negative."""
        what = f"the coefficient is {{value}}, negative: {self.why_negative}"
        fix = "change the parameters, or leave out these conditions"
        yield negative(self.mu(columns, conditions), what, fix)


def mu_times_wrap(sheet: Sheet) -> float:
    """Write the rise of a uniform coefficient mu."""
    return sheet.line("mu phi", "mu * phi")


def _candidates(mu: float, _conditions: Conditions, _log_lift: FloatArray) -> list[list[float]]:
    return [[mu]]


LAW = FrictionLaw(
    name="constant",
    equation="F_A = F_B exp(mu phi)",
    source="Euler's capstan equation; PRTH friction and lift-force model, eq. (2)",
    parameters=(Parameter("mu", "-", 0.2, 0.0, 5.0, "friction coefficient"),),
    coefficient="average",
    effects=frozenset(),
    weakens=True,
    physics=Uniform(),
    candidates=_candidates,
    arithmetic=mu_times_wrap,
)
