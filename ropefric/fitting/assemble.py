"""From the minimum a search found to a result: errors, intervals, statistics, verdict, provenance."""

import sys
from importlib.metadata import version
from math import inf, log, nan, sqrt
from typing import Any

import numpy as np
from scipy.special import stdtrit

import ropefric
from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.files.digits import GIVEN_DIGITS, STD_DIGITS, significant, to_share
from ropefric.files.read import hash_file, kind_of_file
from ropefric.fitting.covariance import (
    bread,
    clustered_covariance,
    rank_lost,
    rounded_covariance,
    unseen_part,
)
from ropefric.fitting.criteria import aicc, bic
from ropefric.fitting.findings import Evidence, find
from ropefric.fitting.identifiability import identify
from ropefric.fitting.losses import loss_weights
from ropefric.fitting.result import CovarianceKind, FitResult, FitStatistics, FittedParameter
from ropefric.fitting.search import Found
from ropefric.fitting.settings import FitSettings
from ropefric.fitting.structure import find_trends, lack_of_fit
from ropefric.fitting.weights import group_means
from ropefric.friction.condition import Conditions
from ropefric.trials.table import TrialTable

# Repeats of one value have a standard deviation of this or less, by rounding.
_RESIDUE = 1e-14
_REGRESSORS = ("wheel_radius_m", "rope_radius_m", "size_ratio", "wrap_angle_rad", "end_tension_N")


def assemble(found: Found, table: TrialTable, settings: FitSettings) -> FitResult:
    """Return the result of a search."""
    problem, minimum = found.problem, found.minimum
    law, theta = problem.law, minimum.theta
    shown = problem.vary & ~minimum.at_bound
    residuals, slopes = problem.residuals_and_jacobian(theta)
    jacobian = slopes[:, shown]
    n_conditions = int(problem.group.max()) + 1
    covariance, kind, dof, notes = _errors(found, settings, jacobian, n_conditions)
    seen = identify(jacobian, [name for name, free in zip(law.parameter_names, shown, strict=True) if free])
    covariance = rounded_covariance(covariance, lost=rank_lost(jacobian))
    std = np.where(minimum.at_bound, nan, 0.0)
    known = [significant(sqrt(variance), STD_DIGITS) for variance in np.diag(covariance).tolist()]
    std[shown] = np.where(unseen_part(jacobian), inf, known)
    log_residuals = -residuals * problem.std
    lack = lack_of_fit(jacobian, log_residuals, problem.std, problem.group, found.scatter)
    findings = find(
        Evidence(
            law=law,
            conditions=problem.conditions,
            theta=theta,
            std=std,
            vary=problem.vary,
            at_bound=minimum.at_bound,
            converged=minimum.converged,
            message=minimum.message,
            n_conditions=n_conditions,
            identifiability=seen,
            scatter=found.scatter,
            lack_of_fit=lack,
            trends=find_trends(jacobian, log_residuals, problem.std, problem.group, problem.conditions),
            slack_slope=_slack_slope(found) if table.measures_slack else 1.0,
        )
    )
    full = np.zeros((theta.size, theta.size))
    full[np.ix_(shown, shown)] = covariance
    return FitResult(
        law=law.name,
        parameters=_parameters(found, std, dof),
        covariance=full,
        covariance_kind=kind,
        statistics=_statistics(found, n_conditions, lack.between, dof),
        status=findings.status,
        advice=findings.advice,
        notes=(*notes, *found.notes),
        identifiability=seen,
        validity=_validity(problem.conditions),
        provenance=_provenance(table, settings),
        trials=_summary(found, table),
        problem=problem,
    )


def _slack_slope(found: Found) -> float:
    problem = found.problem
    try:
        slopes = problem.law.log_lift_gradient_conditions(found.minimum.theta, problem.conditions)
    except InputError:
        return 0.0  # the coefficient at the slack end is infinite: F_A does not depend on F_B at all
    return float(np.abs(slopes[:, 2]).min())


def _errors(
    found: Found, settings: FitSettings, jacobian: FloatArray, n_conditions: int
) -> tuple[FloatArray, CovarianceKind, float, list[str]]:
    """Return the covariance of the parameters shown, its kind, the degrees of freedom of t, and why."""
    problem = found.problem
    n, q = jacobian.shape
    residuals = problem.residuals(found.minimum.theta)
    weights = loss_weights(residuals, settings.loss)
    repeated = n_conditions < n
    if settings.clustered and repeated and n_conditions > q and settings.scale_covar == "auto":
        note = "errors clustered by condition: they include what the repeats of a condition share"
        covariance = clustered_covariance(jacobian, residuals, problem.group, weights)
        return covariance, "clustered", float(n_conditions - q), [note]
    inverse = bread(jacobian, weights)
    if settings.loss != "linear":
        # A weighted residual has less variance than one; the sandwich over trials knows by how much.
        inverse = clustered_covariance(jacobian, residuals, np.arange(n), weights)
    scaled = not found.scatter.known if settings.scale_covar == "auto" else bool(settings.scale_covar)
    if not scaled:
        if not (found.scatter.known or found.shared.all()):
            raise InputError(
                "scale_covar = False needs a known scatter, but there are no repeats and not every trial has an "
                "uncertainty",
                code="RF403",
                key="scale_covar",
                fix="repeat conditions, give peak_std_N, or use scale_covar = 'auto'",
            )
        note = "the scatter is known from the repeats and the budget (scale_covar = False)"
        return inverse, "absolute", float(found.scatter.dof) if found.scatter.known else inf, [note]
    dof = n - q
    factor = float(residuals @ residuals) / dof if dof > 0 else 1.0
    if settings.scale_covar == "auto" and found.shared.any():
        factor = max(
            factor, 1.0
        )  # what is known of the instrument stays, however well the points happen to lie
    note = "the scatter is not known beforehand and taken from the residuals (scale_covar = True)"
    return inverse * factor, "scaled", float(max(dof, 0)), [note]


def _parameters(found: Found, std: FloatArray, dof: float) -> tuple[FittedParameter, ...]:
    problem, minimum = found.problem, found.minimum
    quantile = float(stdtrit(dof, 0.975)) if 0 < dof < inf else (1.959963984540054 if dof == inf else inf)
    parameters = []
    for i, item in enumerate(problem.law.parameters):
        value, low, high = float(minimum.theta[i]), float(problem.lower[i]), float(problem.upper[i])
        half = quantile * float(std[i]) if std[i] > 0 else 0.0
        # Rounded, but never past the estimate itself, which may have more digits than a tiny error has room for.
        ends = (
            min(to_share(value - half, float(std[i])), value),
            max(to_share(value + half, float(std[i])), value),
        )
        interval = (max(ends[0], low), min(ends[1], high)) if problem.vary[i] else (value, value)
        parameters.append(
            FittedParameter(
                name=item.name,
                value=value,
                std=float(std[i]),
                ci95=(nan, nan) if minimum.at_bound[i] else interval,
                lower=low,
                upper=high,
                at_bound=bool(minimum.at_bound[i]),
                vary=bool(problem.vary[i]),
            )
        )
    return tuple(parameters)


def _statistics(found: Found, n_conditions: int, between: float, interval_dof: float) -> FitStatistics:
    problem = found.problem
    residuals = problem.residuals(found.minimum.theta)
    chi2, n, q = float(residuals @ residuals), problem.n_points, problem.n_varying
    deviance = n * log(chi2 / n) + 2.0 * float(np.log(problem.std).sum()) if chi2 > 0.0 else -inf
    return FitStatistics(
        n=n,
        n_conditions=n_conditions,
        dof=n - q,
        chi2=significant(chi2),
        chi2_reduced=significant(chi2 / (n - q)) if n > q else nan,
        aicc=significant(aicc(deviance, n, q + 1)),
        bic=significant(bic(deviance, n, q + 1)),
        scatter_within=significant(found.scatter.within),
        scatter_between=significant(between),
        interval_dof=interval_dof,
    )


def _validity(conditions: Conditions) -> dict[str, tuple[float, float]]:
    columns = {name: getattr(conditions, name) for name in _REGRESSORS}
    return {name: (float(values.min()), float(values.max())) for name, values in columns.items()}


def _summary(found: Found, table: TrialTable) -> dict[str, list[float]]:
    """Return the data by condition: settings, number of trials, mean and sample standard deviation of ln F_A."""
    problem, used = found.problem, table.used
    conditions, group = problem.conditions, problem.group
    n = np.bincount(group)
    means = group_means(problem.log_lift, group)
    squares = np.bincount(group, (problem.log_lift - means[group]) ** 2)
    columns = {
        "wheel_radius_m": conditions.wheel_radius_m,
        "rope_radius_m": conditions.rope_radius_m,
        "wrap_angle_rad": conditions.wrap_angle_rad,
        "end_tension_N": conditions.end_tension_N,
        "peak_std_N": table.peak_std_N[used],
    }
    summary = {name: group_means(values, group).tolist() for name, values in columns.items()}
    std = np.sqrt(squares / np.where(n > 1, n - 1, np.nan))
    return summary | {
        "n": n.tolist(),
        "mean_log_lift": [significant(value, GIVEN_DIGITS) for value in means.tolist()],
        "std_log_lift": [significant(value, smallest=_RESIDUE) for value in std.tolist()],
    }


def _provenance(table: TrialTable, settings: FitSettings) -> dict[str, Any]:
    """Return where the result comes from; nothing in it changes from run to run."""
    libraries = {name: version(name) for name in ("lmfit", "numpy", "scipy")}
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    source: dict[str, Any] = {"path": table.source, "n_trials": len(table), "n_used": int(table.used.sum())}
    if table.source and kind_of_file(table.source) == "file":
        source["sha256"] = hash_file(table.source)
    return {
        "input": source,
        "settings": settings.to_dict(),
        "versions": {"ropefric": ropefric.__version__, "python": python} | libraries,
    }
