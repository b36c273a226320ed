"""What the motor and the wheels do to the blade's tension, eqs. (13)-(17)."""

import math

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.errors import InputError

PRINTED_TORQUE_FACTOR = 9549.0
"""The factor of M = 9549 P/n with P in kW and n in 1/min; unrounded it is 30000/π = 9549.2966."""


def torque_N_m(
    power_W: npt.ArrayLike, wheel_speed_rad_s: npt.ArrayLike, *, printed: bool = False
) -> FloatArray:
    """Return the torque of the driven wheel M = P/ω [N m], eq. (16)."""
    power = _checked("power_W", power_W, "zero or more")
    speed = _checked("wheel_speed_rad_s", wheel_speed_rad_s, "positive")
    rounding = PRINTED_TORQUE_FACTOR / (30000.0 / math.pi) if printed else 1.0
    return np.asarray(power / speed * rounding)


def tension_difference_N(torque_N_m: npt.ArrayLike, wheel_radius_m: npt.ArrayLike) -> FloatArray:
    """Return the difference of the tensions on the two sides of the driven wheel ΔF = M/R [N], eq. (17)."""
    torque = _checked("torque_N_m", torque_N_m, "zero or more")
    return np.asarray(torque / _checked("wheel_radius_m", wheel_radius_m, "positive"))


def inertia_tension_N(
    linear_density_kg_m: npt.ArrayLike, speed_m_s: npt.ArrayLike, *, mounting_factor: npt.ArrayLike = 1.0
) -> FloatArray:
    """Return the inertia tension κ ρA v² that running adds [N], eqs. (13)-(15) for κ = 1."""
    density = _checked("linear_density_kg_m", linear_density_kg_m, "zero or more")
    speed = _checked("speed_m_s", speed_m_s, "")
    kappa = _checked("mounting_factor", mounting_factor, "zero or more")
    if (kappa > 1.0).any():
        raise InputError(
            f"the mounting factor is {kappa.max():g}; above 1 the wheels would add more than the inertia tension",
            key="mounting_factor",
            fix="give 0 for fixed axles, 1 for a constant-force mounting, or a number between",
        )
    return np.asarray(kappa * density * speed**2)


def _checked(name: str, value: npt.ArrayLike, rule: str) -> FloatArray:
    array = np.asarray(value, dtype=np.float64)
    fine = np.isfinite(array)
    if rule == "positive":
        fine &= array > 0.0
    elif rule:
        fine &= array >= 0.0
    if not fine.all():
        wanted = f"finite and {rule}" if rule else "finite"
        raise InputError(
            f"{name} is {array[~fine].ravel()[0]:g}; it must be {wanted}",
            key=name,
            fix="correct this value",
        )
    return array
