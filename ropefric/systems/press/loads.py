"""What the sludge does to the rollers: the drag of its weight and the work of squeezing it, eqs. (5)-(9)."""

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.systems.checks import checked

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
    return GRAVITY_M_S2 * _product(
        sludge_friction=sludge_friction,
        belt_width_m=belt_width_m,
        sludge_height_m=sludge_height_m,
        sludge_density_kg_m3=sludge_density_kg_m3,
        zone_length_m=zone_length_m,
    )


def gravity_torque_N_m(pull_N: npt.ArrayLike, *, radius_m: npt.ArrayLike) -> FloatArray:
    """Return the torque M_G = R T_G on a roller that stands for a pull on its belt, eq. (6) [N m]."""
    return _product(pull_N=pull_N, radius_m=radius_m)


def distortion_energy_J_m3(
    *, strength_Pa: npt.ArrayLike, poisson_ratio: npt.ArrayLike, youngs_modulus_Pa: npt.ArrayLike
) -> FloatArray:
    """Return the limit of the distortion energy K_max = (1 + μ_c) σ_c²/(3 E_c) of sludge, eq. (7) [J/m³]."""
    sigma, nu = _product(strength_Pa=strength_Pa), _product(poisson_ratio=poisson_ratio)
    return np.asarray((1.0 + nu) * sigma**2 / (3.0 * checked("youngs_modulus_Pa", youngs_modulus_Pa)))


def squeeze_torque_N_m(
    *,
    belt_width_m: npt.ArrayLike,
    radius_m: npt.ArrayLike,
    compression_m: npt.ArrayLike,
    distortion_energy_J_m3: npt.ArrayLike,
    units: npt.ArrayLike = 1,
) -> FloatArray:
    """Return the torque M_F = b R Δh K_max of squeezing the cake, eq. (9) [N m]."""
    return _product(
        units=units,
        belt_width_m=belt_width_m,
        radius_m=radius_m,
        compression_m=compression_m,
        distortion_energy_J_m3=distortion_energy_J_m3,
    )


def _product(**values: npt.ArrayLike) -> FloatArray:
    product = np.ones(())
    for name, value in values.items():
        product = product * checked(name, value, "zero or more")
    return product
