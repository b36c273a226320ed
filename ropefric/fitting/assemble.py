"""From the minimum a search found to a result: errors, intervals, statistics, findings, provenance."""

import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from math import inf, isfinite, nan, sqrt
from typing import Any

import numpy as np
import scipy

import ropefric
from ropefric import plugins
from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.files.digits import GIVEN_DIGITS, STD_DIGITS, significant, to_share
from ropefric.files.read import hash_file, kind_of_file
from ropefric.fitting.problem import LOSSES, FitProblem, FitSettings
from ropefric.fitting.result import ERRORS, CommonError, CovarianceKind, FitResult, FitStatus, FittedParameter
from ropefric.fitting.statistics import (
    SMALLEST_SCATTER,
    Identifiability,
    Scatter,
    TwoLevels,
    clustered_covariance,
    combined_dof,
    decomposed,
    find_trends,
    fit_statistics,
    group_means,
    identify,
    plain_covariance,
    rounded_covariance,
    two_levels,
)
from ropefric.friction.condition import SETTINGS, distinct
from ropefric.glossary import counted
from ropefric.trials.table import TrialTable
from ropefric.uncertainty.quantity import quantile

# Repeats of one value have a standard deviation of this or less, by rounding.
_RESIDUE = 1e-14

_REGRESSORS = ("wheel_radius_m", "rope_radius_m", "size_ratio", "wrap_angle_rad", "end_tension_N")
# Above this ratio a part in a hundred of noise in the data is more than the parameters' own size; below it the
# standard errors cannot be bad unless the scatter is, and that is no matter of the design.
_POOR_RATIO = 100.0
# Above this the errors of all parameters would be those of one that lies on its bound and is not seen there.
_HOPELESS_RATIO = 1e4
# A parameter whose standard error is more than this part of it is not known even to its sign at two sigma.
_UNKNOWN = 0.5
# Less will do where a regressor has one value: the error is then judged by the estimate, which may lie anywhere.
_UNKNOWN_BY_DESIGN = 0.1
# Errors of F_B reach ln F_A weakened by this; further down, agreement in ln F_A is no evidence.
_LEAST_SLACK_SLOPE = 0.9
_TREND_P = 1e-3
_LACK_OF_FIT_P = 1e-3
_EXTREME_SCATTER = 0.3
_NOTES: dict[CovarianceKind, str] = {
    "clustered": "errors clustered by condition: they include what the repeats of a condition share",
    "scaled": "the scatter is not known beforehand and taken from the residuals (scale_covar = True)",
}
_EXACT = "the data agree with the law to rounding: nothing is left to estimate a scatter from, so no interval is given"
_REMEDY = {
    "wrap angle": "a wrap effect (wrap-power, coupled) or an offset (constant-offset)",
    "size ratio": "a size effect (size-exponential, coupled, thickness)",
    "end tension": "a load effect (coupled, howell, bending)",
}
# Of a regressor with so few values or fewer: the effects that need more, how they are shown, and what to measure.
_FEW = 3
_EXPERIMENTS = {
    "size ratio": ({"size"}, "R_w/R_r = {}", (
        "measure wheels from less than 3 to more than 15 times the rope radius, the small ones above all."
    )),
    "wrap angle": ({"wrap-dependence", "offset", "bending-stiffness"}, "{} deg", (
        "measure more, from half a turn to several turns."
    )),
    "end tension": ({"end-tension", "bending-stiffness"}, "F_B = {} N", (
        "a wrap series at one load cannot fix the law; repeat it at loads from a few newtons to a hundred times that."
    )),
}  # fmt: skip

Finding = tuple[FitStatus, str]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Found:
    """What a search found."""

    problem: FitProblem
    theta: FloatArray
    at_bound: BoolArray
    converged: bool
    scatter: Scatter
    shared: FloatArray
    notes: tuple[str, ...]
    common: tuple[CommonError, ...]
    effects: FloatArray


def assemble(found: Found, table: TrialTable, settings: FitSettings) -> FitResult:
    """Return the result of a search.

    A large ratio of singular values alone condemns nothing: with enough data the parameters are known all the
    same. A parameter counts as not seen if it can be traded for others without any trace, or if the ratio is
    above 100 and its standard error is more than half of it (a tenth, where a regressor the law needs has one value
    only). Scatter between conditions is advice, not a fault:
    the clustered errors include it; a trend with p < 0.001 in wrap, size or load is a fault of the law.

    A parameter on its bound counts as free for the errors of all, unless the data do not see it there: held, it
    would make the others look better known than they are (90 % of the 95 % intervals beside a bound held the truth).
    """
    problem, theta = found.problem, found.theta
    shown = problem.vary & ~found.at_bound
    residuals, slopes = problem.residuals_and_jacobian(theta)
    jacobian, free = slopes[:, shown], shown
    if found.at_bound.any():
        values = decomposed(slopes[:, problem.vary]).values
        # The data tell all parameters apart, those that lie on their bounds too.
        if values.max(initial=0.0) <= _HOPELESS_RATIO * values.min(initial=inf):
            free = problem.vary
    errors, left = slopes[:, free], (-residuals * problem.std, problem.std, problem.group)
    levels = None
    if problem.n_conditions > errors.shape[1]:
        levels = two_levels(errors, *left, found.scatter, found.effects)
    covariance, kind, dof, note = _errors(found, settings, errors, residuals, levels)
    common, svd = np.zeros((theta.size, len(found.common))), decomposed(errors)
    if levels is not None and settings.clustered and settings.scale_covar == "auto":
        common[free] = levels.common
        covariance = covariance + levels.common @ levels.common.T
    covariance = rounded_covariance(covariance, lost=int(svd.lost.sum()))
    full = np.zeros((theta.size, theta.size))
    full[np.ix_(free, free)] = covariance
    std = np.zeros(theta.size)
    known = [significant(sqrt(variance), STD_DIGITS) for variance in np.diag(covariance).tolist()]
    std[free] = np.where(svd.unseen, inf, known)
    seen = identify(jacobian, np.array(problem.law.parameter_names)[shown].tolist())
    between, p_value = (levels.between, levels.p_value) if levels else (nan, nan)
    findings = [*_of_search(found), *_of_design(found, seen, std)]
    if table.measures_slack:
        findings += _of_slack(found)
    for trend in find_trends(jacobian, *left, problem.conditions):
        if trend.p_value < _TREND_P:
            text = f"What {problem.law.name} leaves over follows the {trend.regressor} (by {trend.size:.2%} of the "
            text += f"force, p = {trend.p_value:.1g}): the law misses an effect. "
            text += f"Compare laws with {_REMEDY[trend.regressor]}."
            findings.append((FitStatus.RESIDUAL_STRUCTURE, text))
    if p_value < _LACK_OF_FIT_P:
        text = (
            f"The conditions scatter by {between:.2%} beyond their repeats (p = {p_value:.1g}): a new rope "
            "each time, a setting, or an effect no regressor shows. Clustered errors include it, others do not."
        )
        findings.append((FitStatus.OK, text))
    rank = list(FitStatus)
    findings.sort(key=lambda finding: -rank.index(finding[0]))
    ranges = ((name, getattr(problem.conditions, name)) for name in _REGRESSORS)
    # Of two parameters that are traded for each other a change may cancel: digits count from the error.
    sizes = np.sqrt(np.diag(full)).tolist()
    return FitResult(
        law=problem.law.name,
        parameters=_parameters(found, std, dof, common),
        covariance=full,
        covariance_kind=kind,
        statistics=fit_statistics(problem, residuals, found.scatter, between, dof),
        status=findings[0][0] if findings else FitStatus.OK,
        advice=tuple(text for _, text in findings),
        notes=(note, *found.notes),
        common_errors=tuple(
            item._replace(
                change=tuple(significant(x, GIVEN_DIGITS, size=y) for x, y in zip(column, sizes, strict=True))
            )
            for item, column in zip(found.common, common.T.tolist(), strict=True)
            if any(column)
        ),
        identifiability=seen,
        validity={name: (float(values.min()), float(values.max())) for name, values in ranges},
        provenance=_provenance(table, settings),
        trials=_summary(found, table),
        problem=problem,
    )


def _errors(
    found: Found, settings: FitSettings, jacobian: FloatArray, residuals: FloatArray, levels: TwoLevels | None
) -> tuple[FloatArray, CovarianceKind, float, str]:
    """Return the covariance of the parameters shown, its kind, the degrees of freedom of t, and why."""
    problem, (n, q), linear = found.problem, jacobian.shape, settings.loss == "linear"
    weights = LOSSES[settings.loss](residuals**2)[1]
    if settings.clustered and settings.scale_covar == "auto" and levels is not None:
        repeated = problem.n_conditions < n
        if linear:
            exact = sqrt(float(np.mean((residuals * problem.std) ** 2))) < SMALLEST_SCATTER
            kind: CovarianceKind = "clustered" if repeated else "scaled"
            return levels.covariance, kind, 0.0 if exact else levels.dof, _EXACT if exact else _NOTES[kind]
        if repeated:
            sandwich, each = clustered_covariance(jacobian, residuals, problem.group, weights)
            return sandwich, "clustered", min(each, default=0.0), _NOTES["clustered"]
    # A weighted residual has less variance than one; the sandwich over trials knows by how much.
    inverse = (
        plain_covariance(jacobian, weights)
        if linear
        else clustered_covariance(jacobian, residuals, np.arange(n), weights)[0]
    )
    known = found.scatter.known
    if known if settings.scale_covar == "auto" else not settings.scale_covar:
        if not (known or found.shared.all()):
            text = "there are no repeats and not every trial has an uncertainty"
            text = f"scale_covar = False needs a known scatter, but {text}"
            fix = "repeat conditions, give peak_std_N, or use scale_covar = 'auto'"
            raise InputError(text, code="RF403", key="scale_covar", fix=fix)
        note = "the scatter is known from the repeats and the budget (scale_covar = False)"
        return inverse, "absolute", float(found.scatter.dof) if known else inf, note
    dof = float(n - q)
    factor = float(residuals @ residuals) / dof if dof > 0 else 1.0
    if settings.scale_covar == "auto" and found.shared.any():
        # What is known of the instrument stays, however well the points happen to lie.
        factor = max(factor, 1.0)
    return inverse * factor, "scaled", max(dof, 0.0), _NOTES["scaled"]


def _parameters(found: Found, std: FloatArray, dof: float, common: FloatArray) -> tuple[FittedParameter, ...]:
    problem = found.problem
    parameters = []
    given = (problem.lower, problem.upper, found.at_bound, problem.vary)
    columns = (found.theta, std, *given, (common**2).sum(axis=1))
    for name, *row in zip(problem.law.parameter_names, *(column.tolist() for column in columns), strict=True):
        value, error, low, high, at_bound, vary, known = row
        reach = quantile(0.975, float(combined_dof(error**2, known, dof))) if dof > 0 else inf
        half = reach * error if error > 0 else 0.0
        # Rounded, but never past the estimate itself, which may have more digits than a tiny error has room for.
        near, far = min(to_share(value - half, error), value), max(to_share(value + half, error), value)
        interval = (max(near, low), min(far, high)) if vary else (value, value)
        parameters.append(
            FittedParameter(
                name=name, value=value, std=nan if at_bound else error, lower=low, upper=high, at_bound=at_bound,
                ci95=(nan, nan) if at_bound and not 0.0 < error < inf else interval, vary=vary,
            )
        )  # fmt: skip
    return tuple(parameters)


def _summary(found: Found, table: TrialTable) -> dict[str, list[float]]:
    """Return the data by condition: settings, number of trials, mean and sample standard deviation of ln F_A."""
    problem, group = found.problem, found.problem.group
    n, means = np.bincount(group), group_means(problem.log_lift, group)
    squares = np.bincount(group, (problem.log_lift - means[group]) ** 2)
    std = np.sqrt(squares / np.where(n > 1, n - 1, np.nan))
    columns = {name: getattr(problem.conditions, name) for name in SETTINGS}
    columns["peak_std_N"] = table.peak_std_N[table.used]
    return {name: group_means(values, group).tolist() for name, values in columns.items()} | {
        "n": n.tolist(),
        "mean_log_lift": [significant(value, GIVEN_DIGITS) for value in means.tolist()],
        "std_log_lift": [significant(value, smallest=_RESIDUE) for value in std.tolist()],
    }


def _provenance(table: TrialTable, settings: FitSettings) -> dict[str, Any]:
    """Return where the result comes from; nothing in it changes from run to run."""
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    versions = {"ropefric": ropefric.__version__, "python": python}
    versions |= {"numpy": np.__version__, "scipy": scipy.__version__, "errors": ERRORS}
    source: dict[str, Any] = {"path": table.source, "n_trials": len(table), "n_used": int(table.used.sum())}
    if table.source and kind_of_file(table.source) == "file":
        source["sha256"] = hash_file(table.source)
    how = asdict(settings)
    if settings.of == "peak":  # what older versions can read
        del how["of"]
    used = {"plugins": found} if (found := plugins.provenance()) else {}
    return {"input": source, "settings": how, "versions": versions, **used}


# ---- what keeps a fit from being trusted, and the experiment that would help ----


def _of_search(found: Found) -> Iterator[Finding]:
    problem, scatter = found.problem, found.scatter.within
    law, n, q = problem.law, problem.n_conditions, problem.n_varying
    if not found.converged:
        yield FitStatus.NOT_CONVERGED, FitStatus.NOT_CONVERGED.advice
    if n < q:
        text = f"{counted(n, 'condition')} cannot determine the {counted(q, 'parameter')} of {law.name}: "
        text += "repeats of one condition count once. Measure more conditions, or use a simpler law."
        yield FitStatus.TOO_FEW_POINTS, text
    for i in np.flatnonzero(found.at_bound):
        text = (
            f"{law.parameter_names[i]} of {law.name} lies on its bound {found.theta[i]:.6g}, which is not a "
            "measurement of it; the errors of the others hold with it there. Use the simpler law it amounts to, or "
            "measure conditions that show it."
        )
        yield FitStatus.AT_BOUND, text
    if scatter > _EXTREME_SCATTER:
        kind = FitStatus.EXTREME_SCATTER
        yield kind, f"Repeats scatter by {scatter:.0%} of the force. {kind.advice}"


def _of_design(found: Found, seen: Identifiability, std: FloatArray) -> Iterator[Finding]:
    lost, law, at, experiments = list(seen.unseen), found.problem.law, found.problem.conditions, []
    regressors = (at.size_ratio, np.degrees(at.wrap_angle_rad), at.end_tension_N)
    for (what, (effects, shown, advice)), values in zip(
        _EXPERIMENTS.items(), map(distinct, regressors), strict=True
    ):
        if effects & law.effects and values.size <= _FEW:
            there = f"is only one {what}" if values.size == 1 else f"are only {values.size} {what}s"
            given = shown.format(", ".join(f"{value:.4g}" for value in values))
            experiments.append(f"There {there} ({given}): {advice}")
    if not lost and seen.ratio > _POOR_RATIO:
        one_value = any("only one" in text for text in experiments)
        limit = _UNKNOWN_BY_DESIGN if one_value else _UNKNOWN
        unknown = np.array(law.parameter_names)[std > limit * np.abs(found.theta)]
        lost = [name for name in seen.weak if name in unknown]
    if lost:
        how = f": {seen.weak_direction} leaves the forces as they are" if len(seen.weak) > 1 else ""
        ratio = f" (ratio of singular values {seen.ratio:.3g})" if isfinite(seen.ratio) else ""
        simpler = f"Fix one of {_listed(seen.weak)} at a value known from elsewhere, or use a simpler law."
        text = f"The data do not show {_listed(lost)} of {law.name}{how}{ratio}. {' '.join(experiments) or simpler}"
        yield FitStatus.UNIDENTIFIABLE, text


def _of_slack(found: Found) -> Iterator[Finding]:
    """Return that the law does not let the lift force follow the end tension that was measured."""
    problem = found.problem
    try:
        slopes = problem.law.log_lift_gradient_conditions(found.theta, problem.conditions)
        slope = float(np.abs(slopes[:, 2]).min())
    except InputError:
        slope = 0.0  # the coefficient at the slack end is infinite: F_A does not depend on F_B at all
    if slope < _LEAST_SLACK_SLOPE:
        text = (
            "The end tension was measured against a known lift force, and in this fit of "
            f"{problem.law.name} the lift force follows it with the power {slope:.2g} only: a law "
            "under which F_A does not depend on F_B would agree with any such data. Use a law without a load effect, "
            "or its form ending in '-from-zero', or measure F_A at known end tensions."
        )
        yield FitStatus.UNIDENTIFIABLE, text


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
