"""From the minimum that a search found to a result: errors, intervals, statistics, findings, provenance."""

import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, replace
from math import inf, isfinite, isnan, log, nan, sqrt
from typing import Any, NamedTuple

import numpy as np
import scipy

import ropefric
from ropefric import plugins
from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.files.disk import hash_file, kind_of_file
from ropefric.files.plain_text import GIVEN_DIGITS, STD_DIGITS, significant, to_share
from ropefric.fitting import scatter
from ropefric.fitting import statistics as stats
from ropefric.fitting.problem import FitProblem, FitSettings
from ropefric.fitting.reml import CONDITION, REPEAT
from ropefric.fitting.result import (
    DEPEND,
    ERRORS,
    EXPERIMENTS,
    TREND_P,
    CommonError,
    CovarianceKind,
    FitResult,
    FitStatus,
    FittedParameter,
)
from ropefric.friction.condition import SETTINGS, Conditions, distinct
from ropefric.friction.law import FrictionLaw
from ropefric.glossary import counted
from ropefric.trials.table import TrialTable

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
_EXTREME_SCATTER = 0.3
_NOTES: dict[CovarianceKind, str] = {
    "clustered": "errors clustered by condition: they include what the repeats of a condition share",
    "scaled": "no condition is repeated: the scatter is taken from the residuals",
}
_NOTHING_LEFT = (
    "there are no more conditions than parameters: the scatter between conditions is unknown, "
    "so no interval is given"
)
# Scatter so small that it is rounding; weights need some number.
_SMALLEST_STD = 1e-12
_EXACT = "the data agree with the law to rounding: nothing is left to estimate a scatter from, so no interval is given"
_REMEDY = {
    "wrap angle": "Compare laws with a wrap effect (wrap-power, coupled) or an offset (constant-offset).",
    "size ratio": "Compare laws with a size effect (size-exponential, coupled, thickness).",
    "end tension": "Compare laws with a load effect (coupled, howell, bending).",
    "settings together": "Compare laws with other effects, or measure more to see which.",
}
# A regressor with this many values or fewer leaves effects undetermined.
_FEW, _ONLY_ONE = 3, "only one"

Finding = tuple[FitStatus, str]


class Found(NamedTuple):
    """Result of a search: the problem of the trials, how they are put together, and the parameters."""

    problem: FitProblem
    layout: scatter.Layout
    theta: FloatArray
    at_bound: BoolArray
    converged: bool
    notes: tuple[str, ...]
    common: tuple[CommonError, ...]
    effects: FloatArray
    slack: bool


def assemble(found: Found, table: TrialTable, settings: FitSettings) -> FitResult:
    """Return the result of a search.

    A large ratio of singular values alone condemns nothing: with enough data the parameters are known all the
    same. A parameter counts as not seen if it can be traded for others without any trace, or if the ratio is
    above 100 and its standard error is more than half of it (a tenth, where a regressor the law needs has one value
    only). A trend with p < 0.001 is a fault of the law.
    """
    problem, layout = found.problem, found.layout
    shown = problem.vary & ~found.at_bound
    free = _free_for_errors(found, shown)
    errors, note = _errors(found, free)
    residuals, slopes = errors.weighted.residuals_and_jacobian(found.theta)
    covariance, std = _covariance(errors, free, stats.decomposed(slopes[:, free]).unseen)
    seen = stats.identify(slopes[:, shown], np.array(problem.law.parameter_names)[shown].tolist())
    has_scatter = bool(errors.model.names)
    trends = stats.find_trends(errors.weighted, slopes[:, shown], -residuals) if has_scatter else ()
    findings = _findings(found, seen, std, trends)
    dof = float(errors.model.dof(np.eye(std.size)[free]).min(initial=inf)) if has_scatter else 0.0
    trials = _trial_level(found)
    ranges = ((name, getattr(problem.conditions, name)) for name in _REGRESSORS)
    return FitResult(
        law=problem.law.name,
        parameters=_parameters(found, std, errors.model.reach(0.975, std**2, np.eye(std.size))),
        covariance=covariance,
        covariance_kind="clustered" if layout.repeated else "scaled",
        statistics=_statistics(found, trials, errors.model, dof, trends),
        scatter=errors.model,
        status=findings[0][0] if findings else FitStatus.OK,
        advice=tuple(text for _, text in findings),
        notes=(note, *found.notes),
        common_errors=_common_errors(found, free, errors.moved, np.sqrt(np.diag(covariance)).tolist()),
        identifiability=seen,
        validity={name: (float(values.min()), float(values.max())) for name, values in ranges},
        provenance=_provenance(table, settings),
        trials=_summary(found, table),
        problem=trials,
    )


def _free_for_errors(found: Found, shown: BoolArray) -> BoolArray:
    """Return which parameters count as free for the errors of all.

    One on its bound does unless the data do not see it there: held, it would make the others look better known than
    they are (90 % of the 95 % intervals beside a bound held the truth).
    """
    if not found.at_bound.any():
        return shown
    values = stats.decomposed(found.layout.problem.jacobian(found.theta)[:, found.problem.vary]).values
    is_hopeless = values.max(initial=0.0) > _HOPELESS_RATIO * values.min(initial=inf)
    return shown if is_hopeless else found.problem.vary


def _covariance(
    errors: scatter.Estimate, free: BoolArray, unseen: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Return the rounded covariance of all p parameters and their standard errors, infinite for those not seen."""
    covariance, std = np.zeros((free.size, free.size)), np.zeros(free.size)
    covariance[np.ix_(free, free)] = rounded = stats.rounded_covariance(errors.covariance)
    known = [significant(sqrt(variance), STD_DIGITS) for variance in np.diag(rounded).tolist()]
    std[free] = np.where(unseen, inf, known)
    return covariance, std


def _common_errors(
    found: Found, free: BoolArray, moved: FloatArray, sizes: Sequence[float]
) -> tuple[CommonError, ...]:
    """Return the stated errors that trials share, rounded, with the changes of all p parameters by each."""
    changes = np.zeros((free.size, len(found.common)))
    changes[free] = moved
    # Of two parameters that are traded for each other a change may cancel: digits count from the error.
    return tuple(
        item._replace(
            std=significant(item.std, GIVEN_DIGITS),
            change=tuple(significant(x, GIVEN_DIGITS, size=s) for x, s in zip(row, sizes, strict=True)),
            effect=tuple(significant(x, GIVEN_DIGITS) for x in effect),
        )
        for item, row, effect in zip(found.common, changes.T.tolist(), found.effects.T.tolist(), strict=True)
    )


def _findings(
    found: Found, seen: stats.Identifiability, std: FloatArray, trends: Sequence[stats.Trend]
) -> list[Finding]:
    """Return all that speaks against a fit, gravest first."""
    findings = [*_of_search(found), *_of_design(found, seen, std)]
    findings += [*(_of_slack(found) if found.slack else ()), *_of_rest(found, trends)]
    rank = list(FitStatus)
    return sorted(findings, key=lambda finding: -rank.index(finding[0]))


def _errors(found: Found, free: BoolArray) -> tuple[scatter.Estimate, str]:
    """Return the errors of the parameters by the scatter, and a note; no intervals where the scatter is unknown."""
    layout, q = found.layout, int(free.sum())
    if (best := scatter.estimated(layout, found.theta, free, found.effects)) is not None:
        note = _NOTES["clustered" if layout.repeated else "scaled"]
        counts = zip(best.model.names, best.model.levels, strict=True)
        if named := ", ".join(f"{n} {name}s" for name, n in counts if name in best.model.groups):
            note += f"; the trials have {named}, each of which may have a μ of its own"
        hidden = [name for name in layout.groups if name not in best.model.names]
        if hidden:
            note += (
                f"; {' and '.join(hidden)} cannot be separated from the law, another group or the condition"
            )
        return best._replace(model=best.model.rounded()), note
    # What repeats scatter by is all that is known, and nothing between conditions.
    rest = layout.problem.residuals(found.theta)
    size = np.nan_to_num(layout.within) or sqrt(float(rest @ rest) / rest.size)
    weighted = replace(layout.problem, std=max(size, stats.SMALLEST_SCATTER) / np.sqrt(layout.size))
    covariance = stats.plain_covariance(weighted.jacobian(found.theta)[:, free])
    model, moved = scatter.nothing_known(found.theta.size), np.zeros((q, found.effects.shape[1]))
    return scatter.Estimate(weighted, model, covariance, moved), _EXACT if rest.size > q else _NOTHING_LEFT


def _trial_level(found: Found) -> FitProblem:
    """Return the problem of the trials, each weighed by what repeats scatter by; by all scatter without any."""
    residual = found.problem.log_lift - found.problem.law.log_lift(found.theta, found.problem.conditions)
    spare = max(residual.size - found.problem.n_varying, 1)
    within = np.nan_to_num(found.layout.within) or sqrt(float(residual @ residual) / spare)
    return replace(found.problem, std=np.full(residual.size, max(within, _SMALLEST_STD)))


def _statistics(
    found: Found, problem: FitProblem, model: scatter.ScatterModel, dof: float, trends: Sequence[stats.Trend]
) -> stats.FitStatistics:
    layout, n, q = found.layout, problem.n_points, problem.n_varying
    within = layout.within if layout.spare else model.std(REPEAT)
    residuals = problem.residuals(found.theta)
    chi2 = float(residuals @ residuals)
    # −2 ln L of equal, unknown scatters, without the n (1 + ln 2π) that all laws share.
    deviance = (n * log(chi2 / n) if chi2 > 0.0 else -inf) + 2.0 * float(np.log(problem.std).sum())
    return stats.FitStatistics(
        n=n,
        n_conditions=problem.n_conditions,
        dof=n - q,
        chi2=significant(chi2),
        chi2_reduced=significant(chi2 / (n - q)) if n > q else nan,
        aicc=significant(stats.aicc(deviance, n, q + 1)),
        bic=significant(stats.bic(deviance, n, q + 1)),
        scatter_within=significant(within),
        scatter_between=significant(model.std(CONDITION)),
        interval_dof=significant(dof) if isfinite(dof) else dof,
        lack_of_fit_p=significant(min((trend.p_value for trend in trends), default=nan)),
    )


def _of_rest(found: Found, trends: Iterable[stats.Trend]) -> Iterator[Finding]:
    """Yield the dependences of the residuals: an effect that the law lacks."""
    name = found.problem.law.name
    for trend in trends:
        if trend.p_value < TREND_P:
            text = (
                f"The residuals of {name} {DEPEND} the {trend.regressor} (by {100 * trend.size:.2f} % of the "
            )
            text += f"force, p = {trend.p_value:.1g}): the law lacks an effect. {_REMEDY[trend.regressor]}"
            yield FitStatus.RESIDUAL_STRUCTURE, text


def _parameters(found: Found, std: FloatArray, reach: FloatArray) -> tuple[FittedParameter, ...]:
    """Return the parameters, each interval `reach` (p,) standard errors long on either side; none where that is NaN."""
    problem = found.problem
    parameters = []
    given = (problem.lower, problem.upper, found.at_bound, problem.vary)
    columns = (found.theta, std, *given, reach)
    for name, *row in zip(problem.law.parameter_names, *(column.tolist() for column in columns), strict=True):
        value, error, low, high, at_bound, vary, errors = row
        error = inf if isnan(errors) and vary else error
        half = significant(errors) * error if 0.0 < error < inf else error
        # Rounded, but never past the estimate itself, which may have more digits than a tiny error has room for.
        near, far = min(to_share(value - half, error), value), max(to_share(value + half, error), value)
        interval = (max(near, low), min(far, high)) if vary else (value, value)
        if (at_bound or isnan(errors)) and vary and not 0.0 < error < inf:
            interval = (nan, nan)
        parameters.append(
            FittedParameter(
                name=name, value=value, std=nan if at_bound else error, lower=low, upper=high, at_bound=at_bound,
                ci95=interval, vary=vary,
            )
        )  # fmt: skip
    return tuple(parameters)


def _summary(found: Found, table: TrialTable) -> dict[str, list[float]]:
    """Return the data by cell: settings, number of trials, mean and sample standard deviation of ln F_A, and levels."""
    problem, layout = found.problem, found.layout
    n, means = layout.size, stats.group_means(problem.log_lift, layout.cell)
    squares = np.bincount(layout.cell, (problem.log_lift - means[layout.cell]) ** 2)
    std = np.sqrt(squares / np.where(n > 1, n - 1, np.nan))
    at = layout.problem.conditions
    peak_std_N = stats.group_means(table.peak_std_N[table.used], layout.cell)
    columns = {name: getattr(at, name).tolist() for name in SETTINGS}
    set_N = table.end_tension_set_N[table.used]
    if not np.isnan(set_N).all():  # of conditions whose end tension was measured: what they have in common
        set_N = np.where(np.isnan(set_N), problem.conditions.end_tension_N, set_N)
        columns["end_tension_set_N"] = stats.group_means(set_N, layout.cell).tolist()
    return columns | {
        "peak_std_N": peak_std_N.tolist(),
        "n": n.tolist(),
        "mean_log_lift": layout.problem.log_lift.tolist(),
        "std_log_lift": [significant(value, smallest=_RESIDUE) for value in std.tolist()],
        "condition": layout.condition.tolist(),
        **{name: level.tolist() for name, level in layout.groups.items()},
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
    problem, within = found.problem, found.layout.within
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
    if within > _EXTREME_SCATTER:
        kind = FitStatus.EXTREME_SCATTER
        yield kind, f"Repeats scatter by {within:.0%} of the force. {kind.advice}"


def _missing(law: FrictionLaw, at: Conditions) -> Iterator[str]:
    """Yield the regressors that a law needs and that have few values, with the experiment that would help."""
    levels = (at.size_ratio, np.degrees(at.wrap_angle_rad), at.end_tension_N)
    for (what, (_, effects, shown, do)), values in zip(
        EXPERIMENTS.items(), map(distinct, levels), strict=True
    ):
        if effects & law.effects and values.size <= _FEW:
            there = f"is {_ONLY_ONE} {what}" if values.size == 1 else f"are only {values.size} {what}s"
            given = shown.format(", ".join(f"{value:.4g}" for value in values))
            yield f"There {there} ({given}): {do}"


def _of_design(found: Found, seen: stats.Identifiability, std: FloatArray) -> Iterator[Finding]:
    lost, law = list(seen.unseen), found.problem.law
    experiments = [*_missing(law, found.problem.conditions)]
    if not lost and seen.ratio > _POOR_RATIO:
        one_value = any(_ONLY_ONE in text for text in experiments)
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
