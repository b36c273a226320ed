"""What a fit hands on: parameters with their uncertainty, how they were got, and whether to trust them.

`assemble` makes it of the minimum a search found: errors, intervals, statistics, findings, provenance.

The one verdict on a law and on what it predicts is supported, undecided or not judged, with the reason in words. All
rules stand here, and the terminal, the report, JSON and the exit code say what they say.

not judged
    The data leave no choice or no test: the fit has not converged, the data do not show its parameters or only one
    end of their range, there are fewer than `spare` = 3 more conditions than fitted parameters (as for AICc, which
    has no value below n = k + 2 with the scatter among the k), or no law but one could be weighed.
undecided
    Something speaks against the law. Its own fit: the residuals follow a regressor, the repeats scatter extremely,
    or the conditions scatter more than twice as far as their repeats (a third or more of the residuals then lie
    beyond ±2 of the scatter between repeats) while fewer than twenty conditions are left over, too few to show whether
    that is a new rope each time or an effect the law misses; with twenty, a trend would have been found, and the
    scatter counts as scatter, which the clustered errors and the prediction interval hold. Another law: one that
    stands more than 2 in AICc before it (an evidence ratio of e), or one within 2 that gives another lift force.
    The interval: the linear one and the one drawn from the parameters' covariance differ by more than a half width.
    The design: the law depends on a setting that all trials have alike, and is asked about others. They may show that
    μ is not constant, but another form that follows them as well may say something else of that setting.
supported
    Otherwise. A law within 2 that gives the same lift force is no contradiction. Two laws of which neither is a
    special case of the other do where the root mean square of ln F_A between them lies within the half width of the
    used law's interval, and the intervals differ by no more than a factor 2. A law and a richer one that contains
    it do where it lies within both half widths, added as squares: what the richer law knows of its extra effect is
    in its own, wider interval, and that it is wider says nothing against the simpler law.
"""

import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from math import inf, isfinite, nan, sqrt
from typing import Any, Literal, NamedTuple

import numpy as np
import scipy
from scipy.special import fdtrc

import ropefric
from ropefric import plugins
from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.files.disk import hash_file, kind_of_file
from ropefric.files.plain_text import GIVEN_DIGITS, STD_DIGITS, rounded_tree, significant, to_share
from ropefric.fitting import statistics as stats
from ropefric.fitting.problem import FitProblem, FitSettings
from ropefric.fitting.scatter import (
    CONDITION,
    REPEAT,
    Layout,
    ScatterModel,
    estimated,
    nothing_known,
    weighed,
)
from ropefric.friction.condition import SETTINGS, Conditions, distinct
from ropefric.friction.law import FrictionLaw
from ropefric.friction.laws import ALL_LAWS
from ropefric.glossary import AdvisedStatus, counted
from ropefric.registry import Registry
from ropefric.shown import Shown, in_words
from ropefric.trials.table import TrialTable
from ropefric.uncertainty.budget import quantile


class FitStatus(AdvisedStatus):
    """What became of a fit, from good to bad."""

    OK = "ok: The parameters are determined by the data within their intervals."
    EXTREME_SCATTER = (
        "extreme-scatter: The repeats scatter so widely that the logarithm of the force is no longer its own mean. "
        "Find the cause in the recordings before using the law."
    )
    RESIDUAL_STRUCTURE = (
        "residual-structure: What the law leaves over follows the wrap, the size or the load, so the law misses an "
        "effect. Compare other laws before using this one."
    )
    AT_BOUND = (
        "at-bound: A parameter lies on its bound, and that is not a measurement of it. Use the simpler law it "
        "amounts to, or measure the conditions that would show it."
    )
    UNIDENTIFIABLE = (
        "unidentifiable: The data cannot tell all parameters apart. Fix one of them, use a simpler law, or measure "
        "the conditions that are named."
    )
    TOO_FEW_POINTS = (
        "too-few-points: There are fewer conditions than parameters. Measure more, or use a simpler law."
    )
    NOT_CONVERGED = (
        "not-converged: The search did not reach a minimum. Give start values, or use a simpler law."
    )


Word = Literal["supported", "undecided", "not judged"]
Doubt = tuple[Word, str]
"""The word a finding calls for, and the finding; "supported" for one that is only to be known."""

RIVAL = 2.0
"""Difference in AICc up to which two laws are not told apart."""

_WORDS: tuple[Word, ...] = ("supported", "undecided", "not judged")
_OF_PARAMETERS = (FitStatus.AT_BOUND, FitStatus.UNIDENTIFIABLE)
# The last digits of a conversion are no extrapolation.
_NEAR = 1e-6
_ONLY_DOUBTED = (FitStatus.EXTREME_SCATTER, FitStatus.RESIDUAL_STRUCTURE)
# Conditions beyond the fitted parameters: one for the scatter, one more for the small-sample term of AICc.
SPARE = 3
_MANY_SPARE = 20
_SCATTER_RATIO = 2.0
_LACK_OF_FIT_P = 1e-3
# Levels within a tenth are one, such as those of a weight with its pan and without.
_ALIKE = 1.1


class Verdict(NamedTuple):
    """What is to be thought of a law, or of a lift force."""

    word: Word
    reasons: tuple[str, ...]

    @property
    def supported(self) -> bool:
        """Return whether the result may be used as it stands."""
        return self.word == "supported"

    @property
    def reason(self) -> str:
        """Return the reasons as one text."""
        return " ".join(text if text.endswith((".", ")")) else f"{text}." for text in self.reasons)

    def to_dict(self) -> dict[str, Any]:
        """Return a JSON tree."""
        return {"word": self.word, "reason": self.reason, "reasons": list(self.reasons)}


def verdict_of(doubts: Iterable[Doubt], otherwise: str) -> Verdict:
    """Return the gravest word that doubts call for, with all that call for one; `otherwise` is why there is none."""
    grave = sorted((doubt for doubt in doubts if doubt[0] != "supported"), key=lambda d: -_WORDS.index(d[0]))
    if not grave:
        return Verdict(word="supported", reasons=(otherwise,))
    return Verdict(word=grave[0][0], reasons=tuple(dict.fromkeys(text for _, text in grave)))


CovarianceKind = Literal["scaled", "clustered"]

SCHEMA = "ropefric.fit/1"
ERRORS = "REML"
"""How the standard errors of a stored fit were found; those of fits without this word are not compared with today's."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedParameter:
    """One parameter of a fitted law."""

    name: str
    value: float
    std: float
    ci95: tuple[float, float]
    lower: float
    upper: float
    at_bound: bool
    vary: bool


class CommonError(NamedTuple):
    """A stated error that trials share, such as a cell's gain: of what, by whom, and what one standard uncertainty does.

    To the p parameters (`change`), and to ln F_A of the k cells of trials (`effect`).
    """

    name: str
    unit: str
    std: float
    change: tuple[float, ...]
    kind: str = ""
    by: str = ""
    effect: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FitResult(Shown):
    """A fitted friction law.

    Attributes
    ----------
    law : str
        Name of the law.
    parameters : tuple of FittedParameter
        In the law's order.
    covariance : ndarray, shape (p, p)
        Covariance of the parameters in the law's order; zero for those that are fixed, or on a bound where the data
        do not see them.
    covariance_kind : {"scaled", "clustered"}
        "clustered": from repeats and from how the means of the conditions scatter; "scaled": from the latter alone.
    statistics : FitStatistics
        How well it fits.
    scatter : ScatterModel
        What ropes, conditions, repeats scatter by, and what that leaves open of the parameters.
    status : FitStatus
        The gravest finding.
    advice : tuple of str
        All findings, gravest first; what was decided on the way is in `notes`.
    notes : tuple of str
        Decisions: whether the covariance was scaled and why, other minima, weights.
    identifiability : Identifiability
        How well the data tell the parameters apart.
    validity : dict of str to (min, max)
        Range of every regressor in the data, in SI.
    provenance : dict
        Resolved settings, input and its hash, versions.
    trials : dict of str to list
        The data by condition: enough to fit again.
    common_errors : tuple of CommonError
        The stated errors that trials share; the covariance includes them.
    problem : FitProblem, optional
        What was fitted; None after loading from a file.
    rivals : tuple of FitResult
        Laws that a comparison does not tell from this one; outside what was tested its intervals hold theirs.
    """

    _said = ("law", "status", "verdict=verdict.word", "statistics.n", "statistics.n_conditions")
    _framed = "parameters"

    def _more_said(self) -> Iterator[tuple[str, str]]:
        for item, declared in zip(self.parameters, self.friction_law.parameters, strict=True):
            unit = "" if declared.unit == "-" else declared.unit
            words = in_words(item.value, unit, item.std)
            yield item.name, f"{words} (on its bound)" if item.at_bound else words

    law: str
    parameters: tuple[FittedParameter, ...]
    covariance: FloatArray
    covariance_kind: CovarianceKind
    statistics: stats.FitStatistics
    scatter: ScatterModel
    status: FitStatus
    advice: tuple[str, ...]
    identifiability: stats.Identifiability
    validity: Mapping[str, tuple[float, float]]
    notes: tuple[str, ...] = ()
    provenance: Mapping[str, Any] = field(default_factory=dict)
    trials: Mapping[str, list[float]] = field(default_factory=dict)
    common_errors: tuple[CommonError, ...] = ()
    problem: FitProblem | None = None
    rivals: tuple["FitResult", ...] = ()

    @property
    def theta(self) -> FloatArray:
        """Return the parameter values, shape (p,)."""
        return np.array([parameter.value for parameter in self.parameters])

    @property
    def shown(self) -> BoolArray:
        """Return which parameters have a variance, shape (p,)."""
        return np.asarray(np.diag(self.covariance) > 0.0)

    @property
    def common_changes(self) -> FloatArray:
        """Return the changes of the parameters by one standard uncertainty of each common error, shape (p, b)."""
        changes = [item.change for item in self.common_errors]
        return np.array(changes, np.float64).reshape(-1, len(self.parameters)).T

    def weighted(self) -> FitProblem | None:
        """Return the means of the cells as they are weighed; None where nothing tells the scatter, or in an old fit."""
        if "condition" not in self.trials or not self.scatter.names:
            return None
        columns = {name: np.array(values, np.float64) for name, values in self.trials.items()}
        k = columns["n"].size
        rows = [(item.lower, item.upper, item.vary) for item in self.parameters]
        lower, upper, vary = (np.array(column) for column in zip(*rows, strict=True))
        problem = FitProblem(
            law=self.friction_law, conditions=Conditions(**{name: columns[name] for name in SETTINGS}),
            log_lift=columns["mean_log_lift"], std=np.ones(k), group=np.arange(k), start=self.theta, lower=lower,
            upper=upper, vary=vary,
        )  # fmt: skip
        groups = {name: columns[name].astype(np.int64) for name in self.scatter.groups}
        condition = columns["condition"].astype(np.int64)
        layout = Layout(
            problem, problem.group, columns["n"], condition, 0.0, 0, groups, uneven=self.scatter.uneven
        )
        effects = np.array([item.effect for item in self.common_errors]).reshape(-1, k).T
        return weighed(layout, self.scatter, self.theta, effects)

    @property
    def data(self) -> FitProblem:
        """Return what was fitted; refuse a fit from a file, which does not carry it."""
        if self.problem is None:
            raise InputError(f"the fit of {self.law} carries no data", fix="fit the trials again")
        return self.problem

    @property
    def friction_law(self) -> FrictionLaw:
        """Return the law itself."""
        return ALL_LAWS[self.law]

    @property
    def trustworthy(self) -> bool:
        """Return whether the result may be used as it stands: whether its verdict is "supported"."""
        return self.verdict.supported

    @property
    def doubts(self) -> tuple[Doubt, ...]:
        """Return what speaks against the law in its own fit, with the word each calls for."""
        return self.doubts_on(None)

    def doubts_on(self, asked: Conditions | None) -> tuple[Doubt, ...]:
        """Return what speaks against what the law says of conditions; of the whole law for None.

        A parameter that the data do not show by itself, or only on its bound, takes nothing from a force inside what
        was tested, whose interval holds all that the parameters may be.
        """
        doubts: list[Doubt] = []
        forgiven = self.status in _OF_PARAMETERS and asked is not None and self._inside(asked)
        if self.status is not FitStatus.OK and not forgiven:
            word: Word = "undecided" if self.status in _ONLY_DOUBTED else "not judged"
            doubts.append((word, self.advice[0] if self.advice else self.status.advice))
        if forgiven and self.statistics.lack_of_fit_p < _TREND_P:
            doubts += [("undecided", text) for text in self.advice if _LEAVES_OVER in text]
        found, n, q = self.statistics, self.statistics.n_conditions, self.statistics.n - self.statistics.dof
        within, between, spare = found.scatter_within, found.scatter_between, n - q
        if spare < SPARE and self.status is not FitStatus.TOO_FEW_POINTS:
            text = f"{counted(n, 'condition')} cannot test {counted(q, 'fitted parameter')} of {self.law}"
            doubts.append(("not judged", f"{text}: {q + SPARE} are needed"))
        elif spare < _MANY_SPARE and between > _SCATTER_RATIO * within > 0.0:
            F = 1.0 + found.n / n * (between / within) ** 2
            if float(fdtrc(spare, found.n - n, F)) < _LACK_OF_FIT_P:
                text = (
                    f"the conditions lie {between:.2%} off {self.law}, their repeats scatter by {within:.2%}: "
                    f"{n} conditions do not show whether that is a new rope each time or an effect it misses"
                )
                doubts.append(("undecided", text))
        return tuple(doubts)

    def _inside(self, asked: Conditions) -> bool:
        """Return whether conditions lie inside what was tested, and the errors of all parameters there are finite."""
        told = all(isfinite(item.std) or item.at_bound for item in self.parameters)
        ends = {name: self.validity.get(name, (-inf, inf)) for name in SETTINGS}
        within = (
            ((getattr(asked, name) >= low * (1.0 - _NEAR)) & (getattr(asked, name) <= high * (1.0 + _NEAR))).all()
            for name, (low, high) in ends.items()
        )
        return told and all(within)

    def untested(self, asked: Conditions | None = None) -> tuple[Doubt, ...]:
        """Return whether the law depends on a setting that all trials have alike, and what is asked for has not."""
        alone = []
        for title, (name, effects, *_) in _EXPERIMENTS.items():
            low, high = self.validity.get(name, (0.0, inf))
            values = np.array(inf) if asked is None else getattr(asked, name)
            elsewhere = ((values * _ALIKE < low) | (values > _ALIKE * high)).any()
            if effects & self.friction_law.effects and high < _ALIKE * low and elsewhere:
                alone.append(f"one {title}")
        text = (
            f"the trials have {' and '.join(alone)} only: what {self.law} says of others is not tested, "
            "and another form of law may follow the trials as well"
        )
        return (("undecided", text),) if alone else ()

    def verdict_on(self, asked: Conditions | None) -> Verdict:
        """Return the verdict by its own fit on what the law says of conditions; on the whole law for None."""
        doubts = self.doubts_on(asked) or self.untested(asked)
        return verdict_of(doubts, f"nothing in its own fit speaks against {self.law}")

    @property
    def verdict(self) -> Verdict:
        """Return the verdict on the law by its own fit; a comparison knows what other laws say."""
        return self.verdict_on(None)

    @property
    def of(self) -> str:
        """Return which force was fitted, "peak" or "kinetic"."""
        return str(self.provenance.get("settings", {}).get("of", "peak"))

    def only_rope_radius_m(self) -> float:
        """Return the rope radius of the trials [m], if they had one only.

        Raises
        ------
        InputError
            If they had several.
        """
        low, high = self.validity["rope_radius_m"]
        if high - low > 1e-9 * high:
            text = f"the fit rests on ropes of {2e3 * low:.4g} to {2e3 * high:.4g} mm, so none is meant by itself"
            raise InputError(text, key="rope_radius_m", fix="say which rope is meant")
        return low

    def __getitem__(self, name: str) -> FittedParameter:
        return Registry("parameter", self.parameters)[name]

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON tree of schema `ropefric.fit/1`; a number that is not there or infinite is None."""
        left_out = {"problem", "rivals", "parameters", "common_errors", "scatter"}
        tree = {item.name: getattr(self, item.name) for item in fields(self) if item.name not in left_out} | {
            "schema": SCHEMA,
            "status": self.status.value,
            "trustworthy": self.trustworthy,
            "parameters": {one.pop("name"): one for one in map(asdict, self.parameters)},
            "parameter_order": [item.name for item in self.parameters],
            "statistics": asdict(self.statistics),
            "scatter": self.scatter.to_dict(),
            "identifiability": self.identifiability._asdict(),
        }
        if self.common_errors:
            tree["common_errors"] = [item._asdict() for item in self.common_errors]
        return dict(rounded_tree(tree, None))

    @classmethod
    def from_dict(cls, tree: Mapping[str, Any]) -> "FitResult":
        """Return the result of such a tree; `ropefric.fitting.store.load_fit` checks one from a file.

        Raises
        ------
        KeyError, TypeError, ValueError
            If it is no such tree.
        """
        seen: dict[str, Any] = {
            key: tuple(x) if isinstance(x, list) else x for key, x in tree["identifiability"].items()
        }
        seen |= {"ratio": _number(seen["ratio"], inf), "correlation": _number(seen["correlation"])}
        return cls(
            law=ALL_LAWS[tree["law"]].name,
            parameters=tuple(_parameter(name, tree["parameters"][name]) for name in tree["parameter_order"]),
            covariance=np.array([[_number(cell) for cell in row] for row in tree["covariance"]], np.float64),
            covariance_kind=tree["covariance_kind"],
            statistics=stats.FitStatistics(**{key: _number(x) for key, x in tree["statistics"].items()}),
            scatter=_model_of(tree),
            status=FitStatus(tree["status"]),
            advice=tuple(tree["advice"]),
            notes=tuple(tree["notes"]),
            identifiability=stats.Identifiability(**seen),
            validity={name: (float(low), float(high)) for name, (low, high) in tree["validity"].items()},
            provenance=dict(tree["provenance"]),
            trials={name: [_number(cell) for cell in column] for name, column in tree["trials"].items()},
            common_errors=tuple(
                CommonError(
                    **item
                    | {"std": _number(item["std"])}
                    | {name: tuple(map(_number, item.get(name, ()))) for name in ("change", "effect")}
                )
                for item in tree.get("common_errors", ())
            ),
        )


def _model_of(tree: Mapping[str, Any]) -> ScatterModel:
    """Return the model of scatter of a stored fit; of one from before there was one, with its degrees of freedom."""
    p = len(tree["parameter_order"])
    if "scatter" in tree:
        return ScatterModel.from_dict(tree["scatter"], p)
    dof = _number(tree["statistics"]["interval_dof"], inf)
    if not dof:
        return nothing_known(p)
    # One component that the whole covariance goes with.
    covariance = np.array([[_number(cell) for cell in row] for row in tree["covariance"]], np.float64)
    return ScatterModel(
        names=("all",),
        levels=(0,),
        variance=np.ones(1),
        covariance=np.array([[2.0 / dof]]),
        slopes=covariance[None],
    )


def _parameter(name: str, item: Mapping[str, Any]) -> FittedParameter:
    at_bound, (low, high) = bool(item["at_bound"]), item["ci95"]
    # On a bound there is no error; elsewhere a number that JSON cannot hold was infinite.
    gone = nan if at_bound else inf
    absent = {"value": nan, "std": gone, "lower": -inf, "upper": inf}
    numbers = {key: float(_number(item[key], default)) for key, default in absent.items()}
    both_gone = low is None and high is None and item["std"] is None
    ci95 = (nan, nan) if both_gone else (float(_number(low, -gone)), float(_number(high, gone)))
    return FittedParameter(name=name, ci95=ci95, at_bound=at_bound, vary=bool(item["vary"]), **numbers)


def _number(value: Any, gone: float = nan) -> Any:
    if value is None:
        return gone
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(float(value)):
        raise TypeError(f"{value!r:.40} is no number that a fit can hold")
    return value


# ---- from the minimum a search found to a result ----

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
_LEAVES_OVER = "leaves over follows"
_EXTREME_SCATTER = 0.3
_NOTES: dict[CovarianceKind, str] = {
    "clustered": "errors clustered by condition: they include what the repeats of a condition share",
    "scaled": "no condition is repeated: the scatter is taken from the residuals",
}
_NOTHING_LEFT = (
    "there are no more conditions than parameters: nothing tells what conditions scatter by, so no interval is given"
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
# Of a regressor with so few values or fewer: the effects that need more, how they are shown, and what to measure.
_FEW = 3
_EXPERIMENTS = {
    "size ratio": ("size_ratio", {"size"}, "R_w/R_r = {}", (
        "measure wheels from less than 3 to more than 15 times the rope radius, the small ones above all."
    )),
    "wrap angle": ("wrap_angle_rad", {"wrap-dependence", "offset", "bending-stiffness"}, "{} deg", (
        "measure more, from half a turn to several turns."
    )),
    "end tension": ("end_tension_N", {"end-tension", "bending-stiffness"}, "F_B = {} N", (
        "a wrap series at one load cannot fix the law; repeat it at loads from a few newtons to a hundred times that."
    )),
}  # fmt: skip

Finding = tuple[FitStatus, str]


class Found(NamedTuple):
    """What a search found: the problem of the trials, how they are put together, and the parameters."""

    problem: FitProblem
    layout: Layout
    theta: FloatArray
    at_bound: BoolArray
    converged: bool
    notes: tuple[str, ...]
    common: tuple[CommonError, ...]
    effects: FloatArray


class _Errors(NamedTuple):
    """What the scatter leaves open of the free parameters: weighed means, covariance (q, q), its model, and why."""

    weighted: FitProblem
    covariance: FloatArray
    moved: FloatArray
    model: ScatterModel
    note: str


def assemble(found: Found, table: TrialTable, settings: FitSettings) -> FitResult:
    """Return the result of a search.

    A large ratio of singular values alone condemns nothing: with enough data the parameters are known all the
    same. A parameter counts as not seen if it can be traded for others without any trace, or if the ratio is
    above 100 and its standard error is more than half of it (a tenth, where a regressor the law needs has one value
    only). A trend with p < 0.001 is a fault of the law.

    A parameter on its bound counts as free for the errors of all, unless the data do not see it there: held, it
    would make the others look better known than they are (90 % of the 95 % intervals beside a bound held the truth).
    """
    layout, theta = found.layout, found.theta
    shown = found.problem.vary & ~found.at_bound
    slopes, free = layout.problem.jacobian(theta), shown
    if found.at_bound.any():
        values = stats.decomposed(slopes[:, found.problem.vary]).values
        # The data tell all parameters apart, those that lie on their bounds too.
        if values.max(initial=0.0) <= _HOPELESS_RATIO * values.min(initial=inf):
            free = found.problem.vary
    errors = _errors(found, free)
    residuals, slopes = errors.weighted.residuals_and_jacobian(theta)
    svd = stats.decomposed(slopes[:, free])
    covariance = stats.rounded_covariance(errors.covariance, lost=int(svd.lost.sum()))
    full, common = np.zeros((theta.size, theta.size)), np.zeros((theta.size, len(found.common)))
    full[np.ix_(free, free)], common[free] = covariance, errors.moved
    std, told = np.zeros(theta.size), bool(errors.model.names)
    known = [significant(sqrt(variance), STD_DIGITS) for variance in np.diag(covariance).tolist()]
    std[free] = np.where(svd.unseen, inf, known)
    seen = stats.identify(slopes[:, shown], np.array(found.problem.law.parameter_names)[shown].tolist())
    trials = _trial_level(found)
    findings = [*_of_search(found), *_of_design(found, seen, std)]
    if table.measures_slack:
        findings += _of_slack(found)
    trends = stats.find_trends(errors.weighted, slopes[:, shown], -residuals) if told else ()
    findings += _of_rest(found, trends)
    rank = list(FitStatus)
    findings.sort(key=lambda finding: -rank.index(finding[0]))
    ranges = ((name, getattr(found.problem.conditions, name)) for name in _REGRESSORS)
    # Of two parameters that are traded for each other a change may cancel: digits count from the error.
    sizes = np.sqrt(np.diag(full)).tolist()
    dof = errors.model.dof(np.eye(theta.size)) if told else np.zeros(theta.size)
    dof = np.array([significant(x) if isfinite(x) else x for x in dof.tolist()])
    interval_dof = float(dof[free].min(initial=inf)) if told else 0.0
    return FitResult(
        law=found.problem.law.name,
        parameters=_parameters(found, std, dof),
        covariance=full,
        covariance_kind="clustered" if layout.spare else "scaled",
        statistics=_statistics(found, trials, errors.model, interval_dof, trends),
        scatter=errors.model,
        status=findings[0][0] if findings else FitStatus.OK,
        advice=tuple(text for _, text in findings),
        notes=(errors.note, *found.notes),
        common_errors=tuple(
            item._replace(
                change=tuple(significant(x, GIVEN_DIGITS, size=s) for x, s in zip(row, sizes, strict=True)),
                effect=tuple(effect),
            )
            for item, row, effect in zip(
                found.common, common.T.tolist(), found.effects.T.tolist(), strict=True
            )
        ),
        identifiability=seen,
        validity={name: (float(values.min()), float(values.max())) for name, values in ranges},
        provenance=_provenance(table, settings),
        trials=_summary(found, table),
        problem=trials,
    )


def _errors(found: Found, free: BoolArray) -> _Errors:
    """Return what the scatter leaves open of the parameters; without an interval where nothing tells the scatter."""
    layout, q = found.layout, int(free.sum())
    if (best := estimated(layout, found.theta, free, found.effects)) is not None:
        note = _NOTES["clustered" if layout.spare else "scaled"]
        counts = zip(best.model.names, best.model.levels, strict=True)
        if named := ", ".join(f"{n} {name}s" for name, n in counts if name in best.model.groups):
            note += f"; the trials have {named}, which may differ in μ and count as so many"
        hidden = [name for name in layout.groups if name not in best.model.names]
        if hidden:
            note += f"; {' and '.join(hidden)} cannot be told from the law or from another group"
        return _Errors(best.weighted, best.covariance, best.moved, best.model.rounded(), note)
    # What repeats scatter by is all that is known, and nothing between conditions.
    rest = layout.problem.residuals(found.theta)
    size = np.nan_to_num(layout.within) or sqrt(float(rest @ rest) / rest.size)
    weighted = replace(layout.problem, std=max(size, stats.SMALLEST_SCATTER) / np.sqrt(layout.size))
    slopes = weighted.jacobian(found.theta)[:, free]
    note = _EXACT if rest.size > q else _NOTHING_LEFT
    moved = np.zeros((q, found.effects.shape[1]))
    return _Errors(weighted, stats.plain_covariance(slopes), moved, nothing_known(found.theta.size), note)


def _trial_level(found: Found) -> FitProblem:
    """Return the problem of the trials, each weighed by what repeats scatter by; by all scatter without any."""
    residual = found.problem.log_lift - found.problem.law.log_lift(found.theta, found.problem.conditions)
    spare = max(residual.size - found.problem.n_varying, 1)
    within = np.nan_to_num(found.layout.within) or sqrt(float(residual @ residual) / spare)
    return replace(found.problem, std=np.full(residual.size, max(within, _SMALLEST_STD)))


def _statistics(
    found: Found, problem: FitProblem, model: ScatterModel, dof: float, trends: Sequence[stats.Trend]
) -> stats.FitStatistics:
    layout, theta = found.layout, found.theta
    within, between = layout.within, model.std(CONDITION)
    if not layout.spare and not layout.nested and REPEAT in model.names:
        within = model.std(REPEAT)
    lack = min((trend.p_value for trend in trends), default=nan)
    return stats.fit_statistics(problem, problem.residuals(theta), within, between, dof, lack)


def _of_rest(found: Found, trends: Iterable[stats.Trend]) -> Iterator[Finding]:
    """Yield what the law leaves over: an effect that it misses."""
    name = found.problem.law.name
    for trend in trends:
        if trend.p_value < _TREND_P:
            text = f"What {name} {_LEAVES_OVER} the {trend.regressor} (by {trend.size:.2%} of the "
            text += f"force, p = {trend.p_value:.1g}): the law misses an effect. {_REMEDY[trend.regressor]}"
            yield FitStatus.RESIDUAL_STRUCTURE, text


def _parameters(found: Found, std: FloatArray, dof: FloatArray) -> tuple[FittedParameter, ...]:
    """Return the parameters with Student's intervals; none where nothing tells the scatter."""
    problem = found.problem
    parameters = []
    given = (problem.lower, problem.upper, found.at_bound, problem.vary)
    columns = (found.theta, std, *given, dof)
    for name, *row in zip(problem.law.parameter_names, *(column.tolist() for column in columns), strict=True):
        value, error, low, high, at_bound, vary, nu = row
        error = error if nu > 0.0 or not vary else inf
        half = quantile(0.975, nu) * error if 0.0 < error < inf else error
        # Rounded, but never past the estimate itself, which may have more digits than a tiny error has room for.
        near, far = min(to_share(value - half, error), value), max(to_share(value + half, error), value)
        interval = (max(near, low), min(far, high)) if vary else (value, value)
        parameters.append(
            FittedParameter(
                name=name, value=value, std=nan if at_bound else error, lower=low, upper=high, at_bound=at_bound,
                ci95=(nan, nan) if (at_bound or not nu) and vary and not 0.0 < error < inf else interval, vary=vary,
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
    return {name: getattr(at, name).tolist() for name in SETTINGS} | {
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
    problem, scatter = found.problem, found.layout.within
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


def _of_design(found: Found, seen: stats.Identifiability, std: FloatArray) -> Iterator[Finding]:
    lost, law, at, experiments = list(seen.unseen), found.problem.law, found.problem.conditions, []
    levels = (at.size_ratio, np.degrees(at.wrap_angle_rad), at.end_tension_N)
    for (what, (_, effects, shown, do)), values in zip(
        _EXPERIMENTS.items(), map(distinct, levels), strict=True
    ):
        if effects & law.effects and values.size <= _FEW:
            there = f"is only one {what}" if values.size == 1 else f"are only {values.size} {what}s"
            given = shown.format(", ".join(f"{value:.4g}" for value in values))
            experiments.append(f"There {there} ({given}): {do}")
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
