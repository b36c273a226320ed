"""Profile-likelihood intervals: how far a parameter can go while the others make up for it."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.stats import chi2 as chi2_distribution
from scipy.stats import f as f_distribution

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import FitError, InputError
from ropefric.fitting.levenberg import batched_fit
from ropefric.fitting.problem import FitProblem
from ropefric.fitting.profile_search import Search, search_ends
from ropefric.fitting.reduced import reduced

_RIDGE = 1e-12
_LOWER_MINIMUM = 1e-3
_ROUNDING = 1e-26


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ProfileCurve:
    """The profile of one parameter, for plotting."""

    name: str
    value: FloatArray
    delta_chi2: FloatArray
    threshold: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ProfileResult:
    """Profile-likelihood intervals of a fit."""

    level: float
    theta: FloatArray
    ci: FloatArray
    at_bound: BoolArray
    curves: tuple[ProfileCurve, ...]
    notes: tuple[str, ...]


def profile_intervals(
    problem: FitProblem,
    theta: npt.ArrayLike,
    *,
    level: float = 0.95,
    scale: npt.ArrayLike = 1.0,
    absolute_std: bool = False,
    dof: float | None = None,
) -> ProfileResult:
    """Return the profile-likelihood interval of every fitted parameter.

    A value belongs to the interval while Δχ² = χ²(value, others refitted) − χ²_min stays below scale · s² · F, with
    s² = χ²_min/(n − q) and F the quantile of F(1, dof); with absolute_std, below scale · the quantile of χ²(1).
    Correlated points make Δχ² too large by the ratio of the true variance to the one it believes in, parameter by
    parameter; dividing by that ratio (Chandler & Bate 2007, Biometrika 94:167, for one parameter at a time) gives
    back the size of the interval and keeps its shape.

    Each interval is connected: it ends at the first crossing on either side. Near a bound it is one-sided and ends
    at the bound; with the truth on the bound it then covers more than the level (97.5 % at 95 %). The intervals of
    parameters strongly correlated with one whose truth is exactly on its bound cover less (90 % at 95 % for the
    exponent of `wrap-power` without a plateau), because the bound pulls half of all fits to one side; from half a
    standard error off the bound they are right again.
    """
    if not 0.0 < level < 1.0:
        raise InputError(f"the level is {level:g}; it must lie between 0 and 1", key="level", fix="0.95")
    start = np.asarray(theta, dtype=np.float64)
    inflation = np.broadcast_to(np.asarray(scale, dtype=np.float64), start.shape)
    if not (np.isfinite(inflation) & (inflation > 0.0)).all():
        raise InputError("scale must be finite and positive", key="scale", fix="1 for independent points")
    fit = batched_fit(problem, starts=start)
    best, chi2_min = fit.theta[0], float(fit.chi2[0])
    if not np.isfinite(chi2_min):
        raise InputError(
            f"{problem.law.name} has no answer at theta = {start.tolist()}", code="RF420", key="theta"
        )
    notes = [] if fit.converged[0] else ["the fit had not converged, so the intervals are not to be trusted"]
    threshold = inflation * _unit_threshold(problem, chi2_min, level, absolute_std=absolute_std, dof=dof)
    # Exact data leave nothing but rounding, and rounding has no interval.
    threshold = np.where(threshold > _ROUNDING * float(reduced(problem).signal[0]), threshold, 0.0)
    direction, reach = _quadratic_guess(problem, best, threshold)
    search = Search(problem=problem, best=best, chi2_min=chi2_min, direction=direction)
    ends, kinds = search_ends(search, threshold, reach)
    ci = np.stack([best, best], axis=-1)
    at_bound = np.zeros(ci.shape, dtype=np.bool_)
    for (parameter, side), end, kind in zip(search.sides(), ends, kinds, strict=True):
        ci[parameter, side] = end
        at_bound[parameter, side] = kind == "bound"
        notes += _end_note(problem.law.parameter_names[parameter], side, end, kind)
    if search.lowest < -_LOWER_MINIMUM * max(chi2_min, 1e-300):
        notes.append(
            f"a lower minimum was met on the way (χ² {chi2_min + search.lowest:.6g} < {chi2_min:.6g}): "
            "fit again from more starts"
        )
    return ProfileResult(
        level=level,
        theta=best,
        ci=ci,
        at_bound=at_bound,
        curves=tuple(
            ProfileCurve(
                name=problem.law.parameter_names[j],
                value=value,
                delta_chi2=delta,
                threshold=float(threshold[j]),
            )
            for j, (value, delta) in search.curves().items()
        ),
        notes=tuple(notes),
    )


def _unit_threshold(
    problem: FitProblem, chi2_min: float, level: float, *, absolute_std: bool, dof: float | None
) -> float:
    if absolute_std:
        return float(chi2_distribution.ppf(level, 1))
    own = problem.n_points - problem.n_varying
    used = float(own) if dof is None else float(dof)
    if own <= 0 or not used > 0.0:
        raise FitError(
            f"{problem.n_points} points and {problem.n_varying} fitted parameters leave no degree of freedom to "
            "estimate the scatter from",
            fix="measure more, or fix a parameter; in Python, standard deviations may count as known (absolute_std)",
        )
    return float(f_distribution.ppf(level, 1, used)) * chi2_min / own


def _quadratic_guess(
    problem: FitProblem, best: FloatArray, threshold: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return how the others follow each parameter, column by column, and how far each would go on a parabola."""
    data, row = reduced(problem), np.zeros(1, dtype=np.intp)
    normal = data.evaluate(best[np.newaxis], row, np.full(1, np.inf))[1][0]
    size = np.sqrt(np.diag(normal))
    units = np.where(size > 0.0, size, 1.0)
    blocked = ~(problem.vary[:, np.newaxis] & problem.vary)
    scaled = np.where(blocked, 0.0, normal / np.outer(units, units))
    scaled += np.diag(np.where(np.diag(scaled) > 0.0, _RIDGE, 1.0))
    covariance = np.linalg.inv(scaled) / np.outer(units, units)
    variance = np.abs(np.diag(covariance))
    return covariance / variance, np.sqrt(variance * threshold)


def _end_note(name: str, side: int, end: float, kind: str) -> list[str]:
    which = ("lower", "upper")[side]
    if kind == "bound":
        return [
            f"{name}: the data set no {which} limit before its bound {end:.6g}; the interval is one-sided"
        ]
    if kind == "open":
        return [f"{name}: the data set no {which} limit at all"]
    if kind == "edge":
        return [f"{name}: the {which} end {end:.6g} is where the law stops having an answer"]
    return []
