"""Other 95 % intervals for a fit that was just made: from the profile likelihood, or from a bootstrap."""

from dataclasses import replace
from math import inf, isfinite

import numpy as np
from scipy.special import stdtrit

from ropefric.arrays import FloatArray
from ropefric.errors import InputError, UnknownNameError
from ropefric.files.digits import to_share
from ropefric.fitting.bootstrap import bootstrap
from ropefric.fitting.covariance import bread
from ropefric.fitting.problem import FitProblem
from ropefric.fitting.profile import profile_intervals
from ropefric.fitting.result import FitResult
from ropefric.registry import did_you_mean

INTERVALS = ("covariance", "profile", "bootstrap")
"""Ways to the 95 % intervals of the parameters."""

# With fewer conditions than this, drawing whole conditions gives intervals that are too narrow.
_ENOUGH_TO_DRAW = 20
_NORMAL = 1.959963984540054


def with_intervals(fit: FitResult, method: str, *, n: int = 2000, seed: int = 0) -> FitResult:
    """Return a fit with `ci95` of its parameters found in another way; all else stays, standard errors too."""
    if method not in INTERVALS:
        raise UnknownNameError(
            f"unknown way to intervals {method!r}", key="intervals", fix=did_you_mean(method, INTERVALS)
        )
    if method == "covariance":
        return fit
    if fit.problem is None:
        raise InputError(f"the fit of {fit.law} carries no data", key="intervals", fix="fit the trials again")
    if fit.provenance.get("settings", {}).get("loss", "linear") != "linear":
        raise InputError(
            f"{method} intervals are those of least squares, not of a robust loss",
            key="intervals",
            fix="use loss = 'linear', or intervals = 'covariance'",
        )
    ends, notes = _profile(fit, fit.problem) if method == "profile" else _bootstrap(fit, fit.problem, n, seed)
    parameters = tuple(
        replace(item, ci95=(to_share(float(low), item.std), to_share(float(high), item.std)))
        if item.vary
        else item
        for item, (low, high) in zip(fit.parameters, ends, strict=True)
    )
    how = {"method": method} | ({"n": n, "seed": seed} if method == "bootstrap" else {})
    return replace(
        fit,
        parameters=parameters,
        notes=(*fit.notes, f"95 % intervals by {method}", *notes),
        provenance=dict(fit.provenance) | {"intervals": how},
    )


def _profile(fit: FitResult, problem: FitProblem) -> tuple[FloatArray, tuple[str, ...]]:
    if fit.covariance_kind == "scaled":
        found = profile_intervals(problem, fit.theta)
        return found.ci, found.notes
    # χ² believes in independent trials and a normal quantile; the fit's own covariance and Student's t know better.
    variance = np.diag(fit.covariance)
    shown = variance > 0.0
    plain = np.ones_like(variance)
    plain[shown] = np.diag(bread(problem.jacobian(fit.theta)[:, shown]))
    ratio = np.where(shown & (plain > 0.0), variance / np.where(plain > 0.0, plain, 1.0), 1.0)
    ratio = np.where(np.isfinite(ratio) & (ratio > 0.0), ratio, 1.0)
    dof = fit.statistics.interval_dof
    quantile = float(stdtrit(dof, 0.975)) if isfinite(dof) and 0 < dof < inf else _NORMAL
    found = profile_intervals(problem, fit.theta, scale=ratio * (quantile / _NORMAL) ** 2, absolute_std=True)
    return found.ci, found.notes


def _bootstrap(fit: FitResult, problem: FitProblem, n: int, seed: int) -> tuple[FloatArray, tuple[str, ...]]:
    many = fit.statistics.n_conditions >= max(_ENOUGH_TO_DRAW, problem.n_varying + 1)
    repeated = fit.statistics.n_conditions < fit.statistics.n
    found = bootstrap(
        problem, fit.theta, kind="clustered" if many and repeated else "parametric", n=n, seed=seed
    )
    return found.ci95, found.notes
