"""Eq. (2): one coefficient for every wheel, wrap and load; and the physics of every coefficient that is uniform."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.friction.arithmetic import Sheet
from ropefric.friction.condition import Conditions
from ropefric.friction.law import Columns, FrictionLaw, Parameter, Refusal


@dataclass(frozen=True, slots=True, kw_only=True)
class Uniform:
    """The physics of a coefficient that depends on the parameters and the size of the wheel alone.

    Local and average coefficient are the same here.
    """

    mu: Callable[[Columns, Conditions], FloatArray]
    mu_slopes: Callable[[Columns, Conditions], tuple[FloatArray, ...]]
    mu_by_radius: Callable[[Columns, Conditions], FloatArray]
    why_negative: str = "friction cannot push the rope forward"

    def rise(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return μ φ."""
        return self.mu(columns, conditions) * conditions.wrap_angle_rad

    def rise_and_slopes(
        self, columns: Columns, conditions: Conditions
    ) -> tuple[FloatArray, tuple[FloatArray, ...]]:
        """Return μ φ and ∂μ φ by each parameter."""
        slopes = tuple(slope * conditions.wrap_angle_rad for slope in self.mu_slopes(columns, conditions))
        return self.rise(columns, conditions), slopes

    def condition_slopes(
        self, columns: Columns, conditions: Conditions
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return ∂ ln F_A by R_w, φ and ln F_B."""
        by_radius = self.mu_by_radius(columns, conditions) * conditions.wrap_angle_rad
        return by_radius, self.mu(columns, conditions), np.array(1.0)

    def local_mu(self, columns: Columns, wrap_rad: FloatArray, conditions: Conditions) -> FloatArray:
        """Return μ, wherever on the wrap."""
        return self.mu(columns, conditions) + 0.0 * wrap_rad

    def refusals(self, columns: Columns, conditions: Conditions) -> Iterable[Refusal]:
        """Yield where μ is negative."""
        mu = self.mu(columns, conditions)
        what = f"the coefficient is {{value}}, negative: {self.why_negative}"
        yield Refusal(mu < 0.0, mu, what, "change the parameters, or leave out these conditions")


def same_for_all(columns: Columns, conditions: Conditions) -> FloatArray:
    """Return the first parameter for every condition: no size effect."""
    return columns[0] + 0.0 * conditions.wrap_angle_rad


def same_for_all_slopes(_columns: Columns, _conditions: Conditions) -> tuple[FloatArray, ...]:
    """Return the derivative of `same_for_all` by that parameter."""
    return (np.array(1.0),)


def unmoved_by_radius(_columns: Columns, _conditions: Conditions) -> FloatArray:
    """Return the derivative by R_w [1/m] of a coefficient that has no size effect."""
    return np.array(0.0)


def mu_times_wrap(sheet: Sheet) -> float:
    """Write the rise of a uniform coefficient mu."""
    return sheet.line("mu phi", "mu * phi")


def _candidates(mu: float, _conditions: Conditions, _log_lift: FloatArray) -> list[list[float]]:
    return [[mu]]


LAW = FrictionLaw(
    name="constant",
    equation="F_A = F_B exp(mu phi)",
    source="Euler's capstan equation; PRTH friction and lift-force model, eq. (2)",
    parameters=(Parameter("mu", "-", start=0.2, lower=0.0, upper=5.0, meaning="friction coefficient"),),
    coefficient="average",
    effects=frozenset(),
    physics=Uniform(mu=same_for_all, mu_slopes=same_for_all_slopes, mu_by_radius=unmoved_by_radius),
    candidates=_candidates,
    arithmetic=mu_times_wrap,
)
