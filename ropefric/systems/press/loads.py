"""What the sludge does to the rollers: the drag of its weight and the work of squeezing it, eqs. (5)-(9).

Both ways: from sludge and belt to torques, and from torques back to the products of sludge data that they stand for.
"""

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.errors import InputError

GRAVITY_M_S2 = 9.81
"""g [m/s²]."""


def gravity_pull_N(
    *,
    sludge_friction: npt.ArrayLike,
    belt_width_m: npt.ArrayLike,
    sludge_height_m: npt.ArrayLike,
    sludge_density_kg_m3: npt.ArrayLike,
    zone_length_m: npt.ArrayLike,
) -> FloatArray:
    """Return the pull T_G = μ_f b h ρ_s g l that the sludge's weight asks of the belt, eq. (5) [N]."""
    mu, b, h, rho, length = _arrays(
        sludge_friction=sludge_friction,
        belt_width_m=belt_width_m,
        sludge_height_m=sludge_height_m,
        sludge_density_kg_m3=sludge_density_kg_m3,
        zone_length_m=zone_length_m,
    )
    return np.asarray(mu * b * h * rho * GRAVITY_M_S2 * length)


def gravity_torque_N_m(pull_N: npt.ArrayLike, *, radius_m: npt.ArrayLike) -> FloatArray:
    """Return the torque M_G = R T_G on a roller that stands for a pull on its belt, eq. (6) [N m]."""
    pull, R = _arrays(pull_N=pull_N, radius_m=radius_m)
    return np.asarray(R * pull)


def distortion_energy_J_m3(
    *, strength_Pa: npt.ArrayLike, poisson_ratio: npt.ArrayLike, youngs_modulus_Pa: npt.ArrayLike
) -> FloatArray:
    """Return the limit of the distortion energy K_max = (1 + μ_c) σ_c²/(3 E_c) of sludge, eq. (7) [J/m³]."""
    sigma, nu, E = _arrays(
        strength_Pa=strength_Pa, poisson_ratio=poisson_ratio, youngs_modulus_Pa=youngs_modulus_Pa
    )
    _refuse_zero(youngs_modulus_Pa=E)
    return np.asarray((1.0 + nu) * sigma**2 / (3.0 * E))


def squeeze_torque_N_m(
    *,
    belt_width_m: npt.ArrayLike,
    radius_m: npt.ArrayLike,
    compression_m: npt.ArrayLike,
    distortion_energy_J_m3: npt.ArrayLike,
    units: npt.ArrayLike = 1,
) -> FloatArray:
    """Return the torque M_F = b R Δh K_max of squeezing the cake, eq. (9) [N m]."""
    b, R, dh, K, n = _arrays(
        belt_width_m=belt_width_m,
        radius_m=radius_m,
        compression_m=compression_m,
        distortion_energy_J_m3=distortion_energy_J_m3,
        units=units,
    )
    return np.asarray(n * b * R * dh * K)


def implied_squeeze_N_m(
    torque_N_m: npt.ArrayLike,
    *,
    belt_width_m: npt.ArrayLike,
    radius_m: npt.ArrayLike,
    units: npt.ArrayLike = 1,
) -> FloatArray:
    """Return the product Δh K_max [N/m] behind a squeeze torque; the two are never known apart from it."""
    M, b, R, n = _arrays(torque_N_m=torque_N_m, belt_width_m=belt_width_m, radius_m=radius_m, units=units)
    _refuse_zero(belt_width_m=b, radius_m=R, units=n)
    return np.asarray(M / (n * b * R))


def implied_drag_kg_m2(
    torque_N_m: npt.ArrayLike,
    *,
    belt_width_m: npt.ArrayLike,
    radius_m: npt.ArrayLike,
    sludge_height_m: npt.ArrayLike,
) -> FloatArray:
    """Return the product μ_f ρ_s l [kg/m²] behind a gravity torque of sludge of known height."""
    M, b, R, h = _arrays(
        torque_N_m=torque_N_m, belt_width_m=belt_width_m, radius_m=radius_m, sludge_height_m=sludge_height_m
    )
    _refuse_zero(belt_width_m=b, radius_m=R, sludge_height_m=h)
    return np.asarray(M / (R * b * h * GRAVITY_M_S2))


def _arrays(**values: npt.ArrayLike) -> list[FloatArray]:
    arrays = []
    for name, value in values.items():
        array = np.asarray(value, dtype=np.float64)
        bad = ~(np.isfinite(array) & (array >= 0.0))
        if bad.any():
            raise InputError(
                f"{name} is {array[bad].ravel()[0]:g}; it must be finite and zero or more", key=name
            )
        arrays.append(array)
    return arrays


def _refuse_zero(**values: FloatArray) -> None:
    for name, array in values.items():
        if not array.all():
            raise InputError(f"{name} is zero; it must be positive", key=name)
