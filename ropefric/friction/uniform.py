"""Laws whose coefficient is the same all along the wrap: ln F_A = ln F_B + μ φ, eq. (2)."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.friction.condition import Conditions
from ropefric.friction.physics import Columns, Refusal, refuse


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
        yield refuse(
            mu < 0.0,
            mu,
            f"the coefficient is {{value}}, negative: {self.why_negative}",
            "change the parameters, or leave out these conditions",
        )
