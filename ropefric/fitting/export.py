"""Laws for others: a table μ(φ, F_B, R_w) of a fit for simulators and the constant that stands for it best, and lmfit.

A law as an `lmfit.Model` is for fits and plots of one's own; ropefric itself fits without lmfit.
"""

from dataclasses import dataclass
from inspect import Parameter, Signature
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.fitting.predict import outside_range
from ropefric.fitting.problem import law_named
from ropefric.fitting.result import FitResult
from ropefric.friction.condition import SETTINGS, Conditions
from ropefric.friction.law import FrictionLaw
from ropefric.shown import Shown

if TYPE_CHECKING:
    import lmfit

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
    mu, error = best_constant(rise[good], part.wrap_angle_rad)
    return FrictionTable(
        law=law.name, **grid, mu_average=rise / at.wrap_angle_rad, mu_local=local, lift_force_N=np.exp(log_lift),
        extrapolated=np.asarray(outside_range(fit.validity, at).any(axis=1)), constant_mu=mu, constant_error=error,
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


def lmfit_model(law: str | FrictionLaw) -> "lmfit.Model":
    """Return a friction law as an `lmfit.Model` of ln(F_A / 1 N), with its start values and bounds.

    The scatter of break-away forces is a part of the force, so the logarithm is what least squares should see.
    lmfit takes derivatives by differences and knows nothing of repeats of a condition: for a law with honest
    uncertainty use `fit`.

    Parameters
    ----------
    law : str or FrictionLaw
        "constant", "wrap-power", "coupled", …

    Returns
    -------
    lmfit.Model
        Its independent variables are `wheel_radius_m`, `rope_radius_m` [m], `wrap_angle_rad` [rad] and
        `end_tension_N` [N], numbers or arrays of one length; its parameters are those of the law. `make_params()`
        gives them the law's start values and bounds, and holds those that a fit of the law holds.

    Raises
    ------
    UnknownNameError
        If there is no such law.
    InputError
        RF420 on evaluation, where the law has no answer.

    Examples
    --------
    >>> import numpy as np
    >>> import ropefric as rf
    >>> model = rf.lmfit_model("constant")
    >>> pulls = {"wheel_radius_m": 0.04, "rope_radius_m": 0.005, "wrap_angle_rad": np.array([3.0, 6.0, 9.0]),
    ...     "end_tension_N": 20.0}
    >>> found = model.fit(np.log([36.6, 66.1, 121.7]), **pulls)
    >>> round(found.best_values["mu"], 3)
    0.2
    """
    import lmfit  # noqa: PLC0415  (slow to load, and nothing else needs it)

    chosen = law_named(law)

    def log_lift(**values: npt.ArrayLike) -> FloatArray:
        conditions = Conditions(**{name: np.asarray(values[name], np.float64) for name in SETTINGS})
        return chosen.log_lift([float(values[name]) for name in chosen.parameter_names], conditions)  # type: ignore[arg-type]

    # lmfit reads the names of a model from its signature.
    names = (*SETTINGS, *chosen.parameter_names)
    log_lift.__signature__ = Signature([Parameter(name, Parameter.KEYWORD_ONLY) for name in names])  # type: ignore[attr-defined]
    model = lmfit.Model(log_lift, independent_vars=list(SETTINGS), name=chosen.name)
    for item in chosen.parameters:
        model.set_param_hint(item.name, value=item.start, min=item.lower, max=item.upper, vary=not item.fixed)
    return model
