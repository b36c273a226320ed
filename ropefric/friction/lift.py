"""From ln F_A to the lift force itself, and to a rope that runs."""

import numpy as np
import numpy.typing as npt

from ropefric.errors import InputError
from ropefric.friction.condition import Conditions, FloatArray
from ropefric.friction.law import FrictionLaw

__all__ = ["lift_force_N", "log_lift_moving", "rim_speed_m_s"]

_LARGEST = float(np.log(np.finfo(np.float64).max))


def lift_force_N(law: FrictionLaw, theta: npt.ArrayLike, conditions: Conditions) -> FloatArray:
    """Return the lift force F_A [N], eq. (17).

    Parameters
    ----------
    law : FrictionLaw
        The law.
    theta : array_like, shape (p,) or (m, p)
        Its parameters.
    conditions : Conditions
        n conditions.

    Returns
    -------
    ndarray, shape (n,) or (m, n)
        F_A [N].

    Raises
    ------
    InputError
        As `FrictionLaw.log_lift`, and where ln F_A is above 709.78, so that the force overflows a float.

    Examples
    --------
    >>> from ropefric.friction.laws import LAWS
    >>> pull = Conditions(wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=10, end_tension_N=20)
    >>> lift_force_N(LAWS["constant"], [0.2], pull).round(2).tolist()
    [147.78]
    """
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

    Parameters
    ----------
    law, theta, conditions
        As in `FrictionLaw.log_lift`.
    linear_density_kg_m : array_like, scalar or shape (n,)
        Mass per length ρ [kg/m], zero or more.
    speed_m_s : array_like, scalar or shape (n,)
        Speed v of the rope's centreline [m/s]; the sign does not matter.

    Returns
    -------
    ndarray, shape (n,) or (m, n)
        ln F_A. For F_B → ρv² it is as exact as F_B − ρv² itself, whose digits cancel.

    Raises
    ------
    InputError
        As `FrictionLaw.log_lift` for the end tension F_B − ρv², and where F_B does not exceed ρv²: the rope
        lifts off the wheel.

    Examples
    --------
    >>> from ropefric.friction.laws import LAWS
    >>> pull = Conditions(wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=10, end_tension_N=20)
    >>> lift = log_lift_moving(LAWS["constant"], [0.2], pull, linear_density_kg_m=0.06, speed_m_s=10)
    >>> np.exp(lift).round(2).tolist()
    [109.45]
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
    """Return the speed of the rope's centreline v = ω (R_w + R_r) [m/s].

    Raises
    ------
    InputError
        If a number is not finite, or the speed is none.

    Examples
    --------
    >>> float(rim_speed_m_s(100.0, 0.04, 0.005).round(6))
    4.5
    """
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
