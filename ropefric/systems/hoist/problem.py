"""What is known of a rope on a wheel, for one case or many at once."""

from dataclasses import dataclass

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.systems.checks import Rule, refuse_out_of_scale, side_by_side
from ropefric.systems.friction import WrapFriction

GRAVITY_M_S2 = 9.80665
"""Standard acceleration of gravity [m/s2]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HoistProblem:
    """A rope on a wheel, n cases side by side; scalars are spread."""

    friction: WrapFriction
    wheel_radius_m: FloatArray
    rope_radius_m: FloatArray
    wrap_angle_rad: FloatArray
    end_tension_N: FloatArray
    speed_m_s: FloatArray | None = None
    linear_density_kg_m: FloatArray | None = None
    hanging_length_m: FloatArray | None = None
    bending_stiffness_N_m2: FloatArray | None = None
    payload_kg: FloatArray | None = None

    def __post_init__(self) -> None:
        for name, array in side_by_side({name: getattr(self, name) for name in _RULES}, _RULES).items():
            refuse_out_of_scale(name, array, may_vanish=name not in _DIVIDES)
            object.__setattr__(self, name, array)

    @property
    def n(self) -> int:
        """Return how many cases there are."""
        return self.wheel_radius_m.size

    @property
    def circling_N(self) -> FloatArray:
        """Return c = ρv² [N]; zero where the scene does not give it."""
        if self.linear_density_kg_m is None or self.speed_m_s is None:
            return np.zeros(self.n)
        return self.linear_density_kg_m * self.speed_m_s**2

    @property
    def bending_N(self) -> FloatArray:
        """Return E = EI/(2R²) at the centreline's R = R_w + R_r [N]; zero where the scene does not give it."""
        if self.bending_stiffness_N_m2 is None:
            return np.zeros(self.n)
        return self.bending_stiffness_N_m2 / (2.0 * (self.wheel_radius_m + self.rope_radius_m) ** 2)

    @property
    def weight_N(self) -> FloatArray:
        """Return the weight ρgh of the hanging rope [N]; zero where the scene does not give it."""
        if self.linear_density_kg_m is None or self.hanging_length_m is None:
            return np.zeros(self.n)
        return self.linear_density_kg_m * GRAVITY_M_S2 * self.hanging_length_m


_DIVIDES = {"wheel_radius_m", "rope_radius_m", "end_tension_N"}
_RULES: dict[str, Rule] = {
    **dict.fromkeys(("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N"), "positive"),
    "speed_m_s": "any",
    **dict.fromkeys(("linear_density_kg_m", "hanging_length_m", "bending_stiffness_N_m2"), "zero or more"),
    "payload_kg": "positive",
}
