"""What the sludge does to the rollers: the drag of its weight and the work of squeezing it, eqs. (5)-(9).

Both ways: from sludge and belt to torques, and from torques back to the products of sludge data that they stand for.
"""

import numpy as np
import numpy.typing as npt

from ropefric.errors import InputError

__all__ = [
    "GRAVITY_M_S2",
    "distortion_energy_J_m3",
    "gravity_pull_N",
    "gravity_torque_N_m",
    "implied_drag_kg_m2",
    "implied_squeeze_N_m",
    "squeeze_torque_N_m",
]

FloatArray = npt.NDArray[np.float64]

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
    """Return the pull T_G = μ_f b h ρ_s g l that the sludge's weight asks of the belt, eq. (5) [N].

    Parameters
    ----------
    sludge_friction : array_like
        Coefficient μ_f between sludge and belt [-].
    belt_width_m : array_like
        b [m].
    sludge_height_m : array_like
        Height h of the sludge [m]; the paper's section 4 writes h for the belt's thickness.
    sludge_density_kg_m3 : array_like
        ρ_s [kg/m³].
    zone_length_m : array_like
        Length l of the draining zone [m]. All are zero or more and broadcast.

    Raises
    ------
    InputError
        If a number is negative or not finite.

    Examples
    --------
    >>> float(gravity_pull_N(sludge_friction=0.3, belt_width_m=2, sludge_height_m=0.06, sludge_density_kg_m3=1000,
    ...     zone_length_m=1).round(2))
    353.16
    """
    mu, b, h, rho, length = _arrays(
        sludge_friction=sludge_friction,
        belt_width_m=belt_width_m,
        sludge_height_m=sludge_height_m,
        sludge_density_kg_m3=sludge_density_kg_m3,
        zone_length_m=zone_length_m,
    )
    return np.asarray(mu * b * h * rho * GRAVITY_M_S2 * length)


def gravity_torque_N_m(pull_N: npt.ArrayLike, *, radius_m: npt.ArrayLike) -> FloatArray:
    """Return the torque M_G = R T_G on a roller that stands for a pull on its belt, eq. (6) [N m].

    Raises
    ------
    InputError
        If a number is negative or not finite.

    Examples
    --------
    >>> float(gravity_torque_N_m(349.333, radius_m=0.075).round(3))
    26.2
    """
    pull, R = _arrays(pull_N=pull_N, radius_m=radius_m)
    return np.asarray(R * pull)


def distortion_energy_J_m3(
    *, strength_Pa: npt.ArrayLike, poisson_ratio: npt.ArrayLike, youngs_modulus_Pa: npt.ArrayLike
) -> FloatArray:
    """Return the limit of the distortion energy K_max = (1 + μ_c) σ_c²/(3 E_c) of sludge, eq. (7) [J/m³].

    Parameters
    ----------
    strength_Pa : array_like
        Unconfined strength σ_c [Pa].
    poisson_ratio : array_like
        μ_c [-], zero or more.
    youngs_modulus_Pa : array_like
        E_c [Pa], positive.

    Raises
    ------
    InputError
        If a number is negative or not finite, or the modulus is zero.

    Examples
    --------
    >>> float(distortion_energy_J_m3(strength_Pa=3e4, poisson_ratio=0.5, youngs_modulus_Pa=3e5))
    1500.0
    """
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
    """Return the torque M_F = b R Δh K_max of squeezing the cake, eq. (9) [N m].

    Parameters
    ----------
    belt_width_m, radius_m : array_like
        b and R [m].
    compression_m : array_like
        Loss of height Δh of the cake on the roller [m].
    distortion_energy_J_m3 : array_like
        K_max [J/m³], see `distortion_energy_J_m3`.
    units : array_like
        How many such squeezes the roller stands for; the paper's roller 5 has two, the wedge and its own.

    Raises
    ------
    InputError
        If a number is negative or not finite.

    Examples
    --------
    >>> float(squeeze_torque_N_m(belt_width_m=2, radius_m=0.2, compression_m=0.01, distortion_energy_J_m3=8400))
    33.6
    """
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
    """Return the product Δh K_max [N/m] behind a squeeze torque; the two are never known apart from it.

    Raises
    ------
    InputError
        If a number is negative or not finite, or width, radius or units are zero.

    Examples
    --------
    >>> implied_squeeze_N_m([33.6, 84.0], belt_width_m=2, radius_m=[0.2, 0.25], units=[1, 2]).round(6).tolist()
    [84.0, 84.0]
    """
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
    """Return the product μ_f ρ_s l [kg/m²] behind a gravity torque of sludge of known height.

    Raises
    ------
    InputError
        If a number is negative or not finite, or width, radius or height are zero.

    Examples
    --------
    >>> float(implied_drag_kg_m2(26.2, belt_width_m=2, radius_m=0.075, sludge_height_m=0.06).round(2))
    296.75
    """
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
