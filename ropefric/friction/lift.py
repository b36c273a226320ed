"""From ln F_A to the lift force itself, and to a rope that runs."""

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.friction.condition import Conditions
from ropefric.friction.law import FrictionLaw

_LARGEST = float(np.log(np.finfo(np.float64).max))


def lift_force_N(law: FrictionLaw, theta: npt.ArrayLike, conditions: Conditions) -> FloatArray:
    """Return the lift force F_A [N], eq. (17)."""
    log_force = law.log_lift(theta, conditions)
    beyond = log_force > _LARGEST
    if beyond.any():
        where = tuple(np.argwhere(beyond)[0])
        raise InputError(
            f"{law.name}: ln F_A = {log_force[where]:.1f} at {conditions.describe(int(where[-1]))}; "
            f"a force above e^{_LARGEST:.1f} N is no number",
            code="RF420",
            fix="use a smaller wrap; in Python, law.log_lift stays finite",
        )
    return np.exp(log_force)


def log_lift_moving(
    law: FrictionLaw,
    theta: npt.ArrayLike,
    conditions: Conditions,
    *,
    linear_density_kg_m: npt.ArrayLike,
    speed_m_s: npt.ArrayLike,
) -> FloatArray:
    """Return ln(F_A / 1 N) of a running rope: F_A − ρv² = (F_B − ρv²) exp ∫μ.

    The part ρv² of the tension only bends the rope's path and presses nothing. Friction sees F − ρv²
    everywhere, in the equivalence of end tension and wrap too, so every law holds with that in place of F.
    """
    density = np.asarray(linear_density_kg_m, dtype=np.float64)
    speed = np.asarray(speed_m_s, dtype=np.float64)
    if not (np.isfinite(density) & (density >= 0.0)).all() or not np.isfinite(speed).all():
        raise InputError("the mass per length must be finite and zero or more, and the speed finite")
    with np.errstate(over="ignore", invalid="ignore"):
        inertia_N = density * speed**2 + np.zeros(len(conditions))
    floating = ~(conditions.end_tension_N > inertia_N)
    if floating.any():
        first = int(np.argmax(floating))
        raise InputError(
            f"rho v^2 = {inertia_N[first]:.6g} N is not below F_B at {conditions.describe(first)}: "
            "the rope lifts off the wheel",
            code="RF420",
            fix="raise the end tension or lower the speed",
        )
    pressing = Conditions(
        wheel_radius_m=conditions.wheel_radius_m,
        rope_radius_m=conditions.rope_radius_m,
        wrap_angle_rad=conditions.wrap_angle_rad,
        end_tension_N=conditions.end_tension_N - inertia_N,
    )
    log_pressing = law.log_lift(theta, pressing)
    with np.errstate(divide="ignore"):
        return np.logaddexp(np.log(inertia_N), log_pressing)


def rim_speed_m_s(
    angular_speed_rad_s: npt.ArrayLike, wheel_radius_m: npt.ArrayLike, rope_radius_m: npt.ArrayLike
) -> FloatArray:
    """Return the speed of the rope's centreline v = ω (R_w + R_r) [m/s]."""
    omega, R_w, R_r = (
        np.asarray(value, dtype=np.float64) for value in (angular_speed_rad_s, wheel_radius_m, rope_radius_m)
    )
    with np.errstate(over="ignore", invalid="ignore"):
        speed = omega * (R_w + R_r)
    if not np.isfinite(speed).all():
        raise InputError(
            "the speed omega (R_w + R_r) is not finite", key="angular_speed_rad_s", fix="give SI numbers"
        )
    return speed
