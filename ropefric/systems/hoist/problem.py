"""What is known of a rope on a wheel, for one case or many at once."""

from dataclasses import dataclass

from ropefric.arrays import FloatArray
from ropefric.systems.friction import WrapFriction
from ropefric.systems.reach import refuse_beyond_reach
from ropefric.systems.spread import Rule, spread

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
        for name, array in spread({name: getattr(self, name) for name in _RULES}, _RULES).items():
            refuse_beyond_reach(name, array, may_vanish=name not in _DIVIDES)
            object.__setattr__(self, name, array)

    @property
    def n(self) -> int:
        """Return how many cases there are."""
        return self.wheel_radius_m.size

    @property
    def centreline_radius_m(self) -> FloatArray:
        """Return R_w + R_r [m], shape (n,)."""
        return self.wheel_radius_m + self.rope_radius_m


_DIVIDES = {"wheel_radius_m", "rope_radius_m", "end_tension_N"}
_RULES: dict[str, Rule] = {
    "wheel_radius_m": "positive",
    "rope_radius_m": "positive",
    "wrap_angle_rad": "positive",
    "end_tension_N": "positive",
    "speed_m_s": "any",
    "linear_density_kg_m": "zero or more",
    "hanging_length_m": "zero or more",
    "bending_stiffness_N_m2": "zero or more",
    "payload_kg": "positive",
}
