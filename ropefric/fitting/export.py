"""A fitted law for simulators: a table μ(φ, F_B, R_w), and the constant that stands for it best over that range."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.fitting.predict import REGRESSORS
from ropefric.fitting.result import FitResult
from ropefric.friction.condition import SETTINGS, Conditions
from ropefric.shown import Shown

_COUNTS = {"wheel_radius_m": 5, "rope_radius_m": 1, "wrap_angle_rad": 25, "end_tension_N": 5}
_MOST_ROWS = 10_000_000
_MOST_LOG = 700.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FrictionTable(Shown):
    """A law on a grid, and one constant instead of it.

    Attributes
    ----------
    law : str
        Its name.
    wheel_radius_m, rope_radius_m, wrap_angle_rad, end_tension_N : ndarray, shape (n,)
        The grid, the end tension running fastest.
    mu_average, mu_local : ndarray, shape (n,)
        μ̄ = ln(F_A/F_B)/φ of the whole wrap, and μ = d ln F/dφ where the wrap ends [-]; NaN where there is no answer.
    lift_force_N : ndarray, shape (n,)
        F_A of the mean law [N].
    extrapolated : ndarray of bool, shape (n,)
        Whether the point lies outside what was tested.
    constant_mu : float
        The constant whose largest relative error of F_A over the grid is smallest.
    constant_error : float
        That error [-].
    """

    _said = ("law", "lift_force_N", "mu_average", "constant_mu", "constant_error", "extrapolated")
    _framed = (*SETTINGS, "mu_average", "mu_local", "lift_force_N", "extrapolated")

    law: str
    wheel_radius_m: FloatArray
    rope_radius_m: FloatArray
    wrap_angle_rad: FloatArray
    end_tension_N: FloatArray
    mu_average: FloatArray
    mu_local: FloatArray
    lift_force_N: FloatArray
    extrapolated: BoolArray
    constant_mu: float
    constant_error: float


def friction_table(fit: FitResult, **levels: npt.ArrayLike | None) -> FrictionTable:
    """Return a law on the grid of levels of its four settings; of those not given, over what was tested."""
    axes = []
    for name in SETTINGS:
        low, high = fit.validity[name]
        given = levels.get(name)
        count = _COUNTS[name] if high > low else 1
        axes.append(np.ravel(np.linspace(low, high, count) if given is None else given))
    n = int(np.prod([axis.size for axis in axes]))
    if not 0 < n <= _MOST_ROWS:
        text = f"a table of {n} rows is empty or too long; {_MOST_ROWS} are the most"
        raise InputError(text, key="wrap_angle_rad", fix="ask for fewer levels")
    grid = dict(zip(SETTINGS, (one.ravel() for one in np.meshgrid(*axes, indexing="ij")), strict=True))
    at, law, theta = Conditions(**grid), fit.friction_law, fit.theta
    if (at.wrap_angle_rad == 0.0).any():
        text = "a wrap of zero has no coefficient"
        raise InputError(text, key="wrap_angle_rad", fix="begin above zero")
    good = law.answers(theta, at)
    if not good.any():
        raise InputError(
            f"{law.name} has no answer on this grid", key="wrap_angle_rad", fix=law.validity(theta, at)[0]
        )
    rise, local = np.full((2, n), np.nan)
    part = at.select(good)
    rise[good] = law.log_lift(theta, part) - part.log_end_tension
    local[good] = law.local_mu(theta, part.wrap_angle_rad, part)
    log_lift = rise + at.log_end_tension
    if np.nanmax(log_lift) > _MOST_LOG:
        text = f"ln F_A reaches {np.nanmax(log_lift):.4g}: the force overflows"
        raise InputError(text, code="RF420", key="wrap_angle_rad", fix="use fewer turns")
    outside = np.zeros(n, dtype=np.bool_)
    for name in REGRESSORS:
        low, high = fit.validity[name]
        outside |= (grid[name] < low * (1 - 1e-9)) | (grid[name] > high * (1 + 1e-9))
    mu, error = best_constant(rise[good], part.wrap_angle_rad)
    return FrictionTable(
        law=law.name, **grid, mu_average=rise / at.wrap_angle_rad, mu_local=local, lift_force_N=np.exp(log_lift),
        extrapolated=outside, constant_mu=mu, constant_error=error,
    )  # fmt: skip


def best_constant(rise: FloatArray, wrap_rad: FloatArray) -> tuple[float, float]:
    """Return the μ with the smallest largest |e^{μφ − ln(F_A/F_B)} − 1| over points, and that error.

    The most that it lifts too much grows with μ, the most that it lifts too little falls: the best is where they meet.
    """

    def off(mu: float) -> tuple[float, float]:
        change = np.expm1(np.clip(mu * wrap_rad - rise, -_MOST_LOG, _MOST_LOG))
        return float(change.max()), float(-change.min())

    low, high = float((rise / wrap_rad).min()), float((rise / wrap_rad).max())
    if high - low > 1e-15 * abs(high):
        low = float(brentq(lambda mu: off(mu)[0] - off(mu)[1], low, high, xtol=1e-15, rtol=1e-14))
    return low, max(off(low))
