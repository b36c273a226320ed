"""The findings on a fit: everything that keeps it from being trusted, and the experiment that would help."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import inf, isfinite

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.fitting.identifiability import Identifiability
from ropefric.fitting.status import FitStatus, worst
from ropefric.fitting.structure import LackOfFit, Trend
from ropefric.fitting.weights import Scatter
from ropefric.friction.condition import Conditions, distinct
from ropefric.friction.law import FrictionLaw
from ropefric.glossary import counted

# Above this ratio a part in a hundred of noise in the data is more than the parameters' own size; below it the
# standard errors cannot be bad unless the scatter is, and that is no matter of the design.
_POOR_RATIO = 100.0
# A parameter whose standard error is more than this part of it is not known even to its sign at two sigma.
_UNKNOWN = 0.5
# Less will do where a regressor has one value: the error is then judged by the estimate, which may lie anywhere.
_UNKNOWN_BY_DESIGN = 0.1
# Errors of F_B reach ln F_A weakened by this; further down, agreement in ln F_A is no evidence.
_LEAST_SLACK_SLOPE = 0.9
_TREND_P = 1e-3
_LACK_OF_FIT_P = 1e-3
_EXTREME_SCATTER = 0.3
_FEW_CONDITIONS = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class Findings:
    """What is to be said about a fit."""

    status: FitStatus
    advice: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Evidence:
    """What the findings are about."""

    law: FrictionLaw
    conditions: Conditions
    theta: FloatArray
    std: FloatArray
    vary: BoolArray
    at_bound: BoolArray
    converged: bool
    message: str
    n_conditions: int
    identifiability: Identifiability
    scatter: Scatter
    lack_of_fit: LackOfFit
    trends: Sequence[Trend]
    slack_slope: float = 1.0


def find(evidence: Evidence) -> Findings:
    """Return the findings.

    A large ratio of singular values alone condemns nothing: with enough data the parameters are known all the
    same. A parameter counts as not seen if it can be traded for others without any trace, or if the ratio is
    above 100 and its standard error is more than half of it (a tenth, where a regressor the law needs has one value
    only). Scatter between conditions is advice, not a fault:
    the clustered errors include it; a trend with p < 0.001 in wrap, size or load is a fault of the law.
    """
    found = [
        *_search(evidence),
        *_design(evidence),
        *_slack(evidence),
        *_bounds(evidence),
        *_residuals(evidence),
    ]
    status = worst(kind for kind, _ in found)
    rank = list(FitStatus)
    found.sort(key=lambda finding: -rank.index(finding[0]))
    return Findings(status=status, advice=tuple(text for _, text in found))


def _search(evidence: Evidence) -> Iterator[tuple[FitStatus, str]]:
    if not evidence.converged:
        yield FitStatus.NOT_CONVERGED, f"{FitStatus.NOT_CONVERGED.advice} (It ended with: {evidence.message})"
    q = int(evidence.vary.sum())
    if evidence.n_conditions < q:
        text = (
            f"{counted(evidence.n_conditions, 'condition')} cannot determine the "
            f"{counted(q, 'parameter')} of {evidence.law.name}: "
            "repeats of one condition count once. Measure more conditions, or use a simpler law."
        )
        yield FitStatus.TOO_FEW_POINTS, text


def _design(evidence: Evidence) -> Iterator[tuple[FitStatus, str]]:
    seen = evidence.identifiability
    lost = list(seen.unseen)
    if not lost and seen.ratio > _POOR_RATIO:
        names = evidence.law.parameter_names
        relative = dict(zip(names, _relative(evidence.std, evidence.theta), strict=True))
        one_value = any("only one" in text for text in _experiments(evidence))
        limit = _UNKNOWN_BY_DESIGN if one_value else _UNKNOWN
        lost = [name for name in seen.weak if relative[name] > limit]
    if not lost:
        return
    subject = f"The data do not show {_listed(lost)} of {evidence.law.name}"
    how = f": {seen.weak_direction} leaves the forces as they are" if len(seen.weak) > 1 else ""
    ratio = f" (ratio of singular values {seen.ratio:.3g})" if isfinite(seen.ratio) else ""
    experiment = " ".join(_experiments(evidence)) or (
        f"Fix one of {_listed(seen.weak)} at a value known from elsewhere, or use a simpler law."
    )
    yield FitStatus.UNIDENTIFIABLE, f"{subject}{how}{ratio}. {experiment}"


def _slack(evidence: Evidence) -> Iterator[tuple[FitStatus, str]]:
    if evidence.slack_slope < _LEAST_SLACK_SLOPE:
        text = (
            "The end tension was measured against a known lift force, and in this fit of "
            f"{evidence.law.name} the lift force follows it with the power {evidence.slack_slope:.2g} only: a law "
            "under which F_A does not depend on F_B would agree with any such data. Use a law without a load effect, "
            "or its form ending in '-from-zero', or measure F_A at known end tensions."
        )
        yield FitStatus.UNIDENTIFIABLE, text


def _relative(std: FloatArray, theta: FloatArray) -> list[float]:
    return [
        abs(s / value) if value and not np.isnan(s) else (inf if s > 0 else 0.0)
        for s, value in zip(std.tolist(), theta.tolist(), strict=True)
    ]


def _experiments(evidence: Evidence) -> Iterator[str]:
    effects, conditions = evidence.law.effects, evidence.conditions
    sizes, wraps, loads = (
        distinct(values)
        for values in (conditions.size_ratio, conditions.wrap_angle_rad, conditions.end_tension_N)
    )
    if "size" in effects and sizes.size <= _FEW_CONDITIONS:
        yield (
            f"There {_there(sizes.size, 'size ratio')} (R_w/R_r = {_values(sizes)}): measure wheels from less "
            "than 3 to more than 15 times the rope radius, the small ones above all."
        )
    if effects & {"wrap-dependence", "offset", "bending-stiffness"} and wraps.size <= _FEW_CONDITIONS:
        yield (
            f"There {_there(wraps.size, 'wrap angle')} ({_values(np.degrees(wraps))} deg): measure more, from half a "
            "turn to several turns."
        )
    if effects & {"end-tension", "bending-stiffness"} and loads.size <= _FEW_CONDITIONS:
        yield (
            f"There {_there(loads.size, 'end tension')} (F_B = {_values(loads)} N): a wrap series at one load cannot "
            "fix the law; repeat it at loads from a few newtons to a hundred times that."
        )


def _there(count: int, what: str) -> str:
    return f"is only one {what}" if count == 1 else f"are only {count} {what}s"


def _values(values: FloatArray) -> str:
    return ", ".join(f"{value:.4g}" for value in values)


def _bounds(evidence: Evidence) -> Iterator[tuple[FitStatus, str]]:
    law = evidence.law
    for i in np.flatnonzero(evidence.at_bound):
        text = (
            f"{law.parameter_names[i]} of {law.name} lies on its bound {evidence.theta[i]:.6g}, which is not a "
            "measurement of it; the errors of the others hold with it there. Use the simpler law it amounts to, or "
            "measure conditions that show it."
        )
        yield FitStatus.AT_BOUND, text


def _residuals(evidence: Evidence) -> Iterator[tuple[FitStatus, str]]:
    if evidence.scatter.within > _EXTREME_SCATTER:
        yield (
            FitStatus.EXTREME_SCATTER,
            f"Repeats scatter by {evidence.scatter.within:.0%} of the force. {FitStatus.EXTREME_SCATTER.advice}",
        )
    for trend in evidence.trends:
        if trend.p_value < _TREND_P:
            text = (
                f"What {evidence.law.name} leaves over follows the {trend.regressor} (by {trend.size:.2%} of the "
                f"force, p = {trend.p_value:.1g}): the law misses an effect. "
                f"Compare laws with {_REMEDY[trend.regressor]}."
            )
            yield FitStatus.RESIDUAL_STRUCTURE, text
    lack = evidence.lack_of_fit
    if lack.p_value < _LACK_OF_FIT_P:
        text = (
            f"The conditions scatter by {lack.between:.2%} beyond their repeats (p = {lack.p_value:.1g}): a new rope "
            "each time, a setting, or an effect no regressor shows. Clustered errors include it, others do not."
        )
        yield FitStatus.OK, text


_REMEDY = {
    "wrap angle": "a wrap effect (wrap-power, coupled) or an offset (constant-offset)",
    "size ratio": "a size effect (size-exponential, coupled, thickness)",
    "end tension": "a load effect (coupled, howell, bending)",
}


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
