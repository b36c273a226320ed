"""The size effect: how μ grows with the ratio of wheel to rope radius, eqs. (3), (4), (16)."""

import math

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.friction.condition import Conditions
from ropefric.friction.parameter import Parameter
from ropefric.friction.physics import Columns

SIZE_PARAMETERS = (
    Parameter(
        name="mu_inf", unit="-", start=0.2, lower=0.0, upper=5.0, meaning="coefficient of a very large wheel"
    ),
    Parameter(
        name="a",
        unit="-",
        start=-0.2,
        lower=-20.0,
        upper=0.0,
        meaning="rate of the size effect per unit of R_w/R_r",
    ),
    Parameter(
        name="b",
        unit="-",
        start=-0.3,
        lower=-20.0,
        upper=0.0,
        meaning="strength of the size effect as ln: 0 no friction on a vanishing wheel, very negative none",
    ),
)
"""μ∞, a and b of eq. (4); at b <= 0 no wheel is too small to have a coefficient."""


def exponential_size(columns: Columns, conditions: Conditions) -> FloatArray:
    """Return μ_R = μ∞ (1 − e^{a r + b}) of the first three columns, eq. (4)."""
    mu_inf, a, b = columns[:3]
    return -mu_inf * np.expm1(a * conditions.size_ratio + b)


def exponential_size_slopes(columns: Columns, conditions: Conditions) -> tuple[FloatArray, ...]:
    """Return ∂μ_R by μ∞, a and b."""
    mu_inf, a, b = columns[:3]
    r = conditions.size_ratio
    exponent = a * r + b
    by_b = -mu_inf * np.exp(exponent)
    return -np.expm1(exponent), r * by_b, by_b


def exponential_size_by_radius(columns: Columns, conditions: Conditions) -> FloatArray:
    """Return ∂μ_R/∂R_w [1/m]."""
    mu_inf, a, b = columns[:3]
    return -mu_inf * a * np.exp(a * conditions.size_ratio + b) / conditions.rope_radius_m


def same_for_all(columns: Columns, conditions: Conditions) -> FloatArray:
    """Return the first parameter for every condition: no size effect."""
    return columns[0] + 0.0 * conditions.wrap_angle_rad


def same_for_all_slopes(_columns: Columns, _conditions: Conditions) -> tuple[FloatArray, ...]:
    """Return the derivative of `same_for_all` by that parameter."""
    return (np.array(1.0),)


def unmoved_by_radius(_columns: Columns, _conditions: Conditions) -> FloatArray:
    """Return the derivative by R_w [1/m] of a coefficient that has no size effect."""
    return np.array(0.0)


def size_candidates(conditions: Conditions) -> tuple[FloatArray, FloatArray]:
    """Return values of a and b worth trying on these wheels."""
    r = float(np.median(conditions.size_ratio))
    return np.array([-4.0, -1.5, -0.5, -0.15]) / r, np.array([-3.0, -1.0, -0.2])


def printed_form(mu_inf: float, b: float) -> tuple[float, float]:
    """Return (μ∞, b) of μ_R = μ∞ (1 − e^{a r}) + b, the bracket of eq. (16), from those of eq. (4).

    Both are one family A − B e^{a r}; the rate a is the same.
    """
    return mu_inf * math.exp(b), -mu_inf * math.expm1(b)


def from_printed_form(mu_inf: float, b: float) -> tuple[float, float]:
    """Return (μ∞, b) of μ_R = μ∞ (1 − e^{a r + b}), eq. (4), from those of μ_R = μ∞ (1 − e^{a r}) + b."""
    if not (mu_inf > 0.0 and mu_inf + b > 0.0):
        raise InputError(
            f"mu_inf = {mu_inf:g} and b = {b:g} have no form mu_inf (1 - exp(a r + b))",
            fix="both mu_inf and mu_inf + b must be positive",
        )
    return mu_inf + b, -math.log1p(b / mu_inf)


def amplitudes(mu_inf: float, b: float) -> tuple[float, float]:
    """Return (A, B) of μ_R = A − B e^{a r}, from (μ∞, b) of eq. (4)."""
    return mu_inf, mu_inf * math.exp(b)


def from_amplitudes(A: float, B: float) -> tuple[float, float]:
    """Return (μ∞, b) of eq. (4), from μ_R = A − B e^{a r}."""
    if not (A > 0.0 and B > 0.0):
        raise InputError(
            f"A = {A:g} and B = {B:g} have no form mu_inf (1 - exp(a r + b))", fix="both must be positive"
        )
    return A, math.log(B / A)
