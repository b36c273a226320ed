"""The result of a fit: parameters with their uncertainty, how they were got, and whether to trust them.

`assembled` makes it of the minimum a search found.

The one verdict on a law and on what it predicts is supported, undecided or not judged, with the reason in words. All
rules stand here, and the terminal, the report, JSON and the exit code say what they say.

not judged
    The data leave no choice or no test: the fit has not converged, the data do not show its parameters or only one
    end of their range (and nothing else contradicts the law), there are fewer than `spare` = 3 more conditions than
    fitted parameters (as for AICc, which has no value below n = k + 2 with the scatter among the k), or no law but
    one could be weighed.
undecided
    Something speaks against the law. Its own fit: its residuals depend on a regressor or any smooth function of
    all (F-tests beside the scatter between conditions, p < 0.001), the repeats scatter extremely,
    or the conditions scatter more than twice as far as their repeats (a third or more of the residuals then lie
    beyond ±2 of the scatter between repeats) while fewer than twenty conditions are left over, too few to show whether
    that is a new rope each time or an effect the law lacks; with twenty, a trend would have been found, and the
    scatter counts as scatter, which the clustered errors and the prediction interval hold. Another law: one that
    is more than 2 in AICc before it (an evidence ratio of e), or one within 2 that gives another lift force.
    The design: the law depends on a setting that all trials have alike, and is asked about others. They may show that
    μ is not constant, but another form that follows them as well may say something else of that setting.
supported
    Otherwise. A law within 2 that gives the same lift force is no contradiction. Two laws of which neither is a
    special case of the other do where the root mean square of ln F_A between them lies within the half width of the
    used law's interval, and the intervals differ by no more than a factor 2. A law and a richer one that contains
    it do where it lies within both half widths, added as squares: what the richer law knows of its extra effect is
    in its own, wider interval, and that it is wider says nothing against the simpler law.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from math import hypot, inf, isfinite, nan, sqrt
from typing import Any, Literal, NamedTuple

import numpy as np
from scipy.special import fdtrc

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.files.plain_text import rounded_tree
from ropefric.fitting import statistics as stats
from ropefric.fitting.problem import FitProblem
from ropefric.fitting.scatter import ALL, Layout, ScatterModel, nothing_known, weighed
from ropefric.friction.condition import SETTINGS, Conditions
from ropefric.friction.law import FrictionLaw
from ropefric.friction.laws import ALL_LAWS
from ropefric.glossary import AdvisedStatus, counted
from ropefric.registry import Registry
from ropefric.shown import Shown, from_above, in_words


class FitStatus(AdvisedStatus):
    """Status of a fit, from good to bad."""

    OK = "ok: The data determine all parameters."
    EXTREME_SCATTER = (
        "extreme-scatter: The repeats scatter so widely that the logarithm of the force is no longer its own mean. "
        "Find the cause in the recordings before using the law."
    )
    RESIDUAL_STRUCTURE = (
        "residual-structure: The residuals depend on the wrap, the size or the load: the law lacks an effect. "
        "Compare other laws before using this one."
    )
    AT_BOUND = (
        "at-bound: A parameter lies on its bound, and that is not a measurement of it. Use the simpler law it "
        "amounts to, or measure the conditions that would show it."
    )
    UNIDENTIFIABLE = (
        "unidentifiable: The data cannot determine all parameters. Fix one of them, use a simpler law, or measure "
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
"""Difference in AICc up to which two laws are not distinguished."""

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


TREND_P = 1e-3
"""p-value of an F-test below which a dependence of the residuals speaks against a law."""
DEPEND = "depend on"
"""Words that a finding of that kind has."""
EXPERIMENTS = {
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
"""Of a regressor: its name, the effects that need several of its values, how they are shown, and what to measure."""


class Verdict(NamedTuple):
    """Verdict on a law, or on a lift force."""

    word: Word
    reasons: tuple[str, ...]

    @property
    def supported(self) -> bool:
        """Return whether the result may be used without reservation."""
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
        How well the data determine the parameters.
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
        Laws that a comparison does not exclude; outside what was tested the intervals hold theirs.
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
    def params(self) -> dict[str, FittedParameter]:
        """Return the parameters by name: `fit.params["mu"].value`."""
        return {item.name: item for item in self.parameters}

    def predict(self, wheels: Any = None, **settings: Any) -> Any:
        """Return the lift force for n wheels, as `ropefric.predict` does: `fit.predict(wheel_radius="35 mm", …)`."""
        return from_above("predict")(self, wheels, **settings)

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

    @property
    def has_errors(self) -> bool:
        """Return whether every parameter has a finite standard error, or lies on its bound."""
        return all(isfinite(item.std) or item.at_bound for item in self.parameters)

    def cells(self) -> tuple[Layout, FloatArray] | None:
        """Return how trials are put together, and how stated errors move the k means, shape (k, b).

        None where the scatter is unknown, or in an old fit.
        """
        if "condition" not in self.trials or not self.scatter.names:
            return None
        columns = {name: np.array(values, np.float64) for name, values in self.trials.items()}
        k, at = columns["n"].size, Conditions(**{name: columns[name] for name in SETTINGS})
        rows = [(item.lower, item.upper, item.vary) for item in self.parameters]
        lower, upper, vary = (np.array(column) for column in zip(*rows, strict=True))
        plain = FitProblem.plain(self.friction_law, at, columns["mean_log_lift"], start=self.theta)
        problem = replace(plain, lower=lower, upper=upper, vary=vary)
        groups = {name: columns[name].astype(np.int64) for name in self.scatter.groups}
        condition = columns["condition"].astype(np.int64)
        layout = Layout(
            problem, problem.group, columns["n"], condition, 0.0, 0, groups, uneven=self.scatter.uneven
        )
        effects = np.array([item.effect for item in self.common_errors]).reshape(-1, k).T
        return layout, effects

    def weighted(self) -> FitProblem | None:
        """Return the means of the cells as they are weighed; None where there are no cells."""
        found = self.cells()
        return None if found is None else weighed(found[0], self.scatter, self.theta, found[1])

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
        """Return whether the verdict on the law is "supported"."""
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
        forgiven = self.status in _OF_PARAMETERS and asked is not None and self._inside(asked)
        against = [*self._of_conditions()]
        if self.status in _OF_PARAMETERS and self.statistics.lack_of_fit_p < TREND_P:
            against = [*(("undecided", text) for text in self.advice if DEPEND in text), *against]
        if self.status is not FitStatus.OK and not forgiven:
            # What contradicts a law is a test of it, whatever its parameters are.
            tested = self.status in _OF_PARAMETERS and any(word == "undecided" for word, _ in against)
            word: Word = "undecided" if tested or self.status in _ONLY_DOUBTED else "not judged"
            against.insert(0, (word, self.advice[0] if self.advice else self.status.advice))
        return tuple(against)

    def _of_conditions(self) -> Iterator[Doubt]:
        """Yield that there are too few conditions to test the law, or to explain why they scatter more than repeats."""
        found, n, q = self.statistics, self.statistics.n_conditions, self.statistics.n - self.statistics.dof
        within, spare, lifts = found.scatter_within, n - q, self.trials.get("mean_log_lift", (0.0,))
        if own2 := self.scatter.own_mu_variance(
            len(lifts)
        ):  # a rope of each condition explains a misfit as well
            own2 *= float(np.mean((np.array(lifts) - np.log(self.trials["end_tension_N"])) ** 2))
        between = hypot(found.scatter_between, sqrt(own2))
        if spare < SPARE and self.status is not FitStatus.TOO_FEW_POINTS:
            text = f"{counted(n, 'condition')} cannot test {counted(q, 'fitted parameter')} of {self.law}"
            yield "not judged", f"{text}: {q + SPARE} are needed"
        elif spare < _MANY_SPARE and between > _SCATTER_RATIO * within > 0.0:
            F = 1.0 + found.n / n * (between / within) ** 2
            if float(fdtrc(spare, found.n - n, F)) < _LACK_OF_FIT_P:
                text = (
                    f"The condition means deviate from {self.law} by {100 * between:.2f} %, repeats scatter by "
                    f"{100 * within:.2f} %. {n} conditions do not show whether the cause is a new rope each time or "
                    "an effect that the law lacks"
                )
                yield "undecided", text

    def _inside(self, asked: Conditions) -> bool:
        """Return whether conditions lie inside what was tested, and the errors of all parameters there are finite."""
        sized = bool(self.friction_law.effects & {"size", "bending-stiffness"})
        for name in SETTINGS if sized else SETTINGS[2:]:
            values, (low, high) = getattr(asked, name), self.validity.get(name, (-inf, inf))
            if not ((values >= low * (1.0 - _NEAR)) & (values <= high * (1.0 + _NEAR))).all():
                return False
        return self.has_errors

    def untested(self, asked: Conditions | None = None) -> tuple[Doubt, ...]:
        """Return whether the law depends on a setting that is the same in all trials, but not in the request."""
        alone = []
        for title, (name, effects, *_) in EXPERIMENTS.items():
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
        seen = {name: tree["identifiability"][name] for name in stats.Identifiability._fields}
        seen = {name: tuple(x) if isinstance(x, list) else x for name, x in seen.items()}
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
            identifiability=stats.Identifiability(**seen | {"ratio": _number(seen["ratio"], inf)}),
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
    # One component that the whole covariance goes with, but for what is known for sure, and the scatter about the law.
    covariance = np.array([[_number(cell) for cell in row] for row in tree["covariance"]], np.float64)
    common = [[_number(x) for x in item["change"]] for item in tree.get("common_errors", ())]
    changes = np.array(common, np.float64).reshape(-1, p)
    covariance = covariance - changes.T @ changes
    found = {
        "condition": tree["statistics"]["scatter_between"],
        "repeat": tree["statistics"]["scatter_within"],
    }
    stds = {ALL: 1.0} | {name: _number(std) for name, std in found.items() if std is not None}
    variance = np.array([*stds.values()]) ** 2
    slopes = np.zeros((variance.size, p, p))
    slopes[0] = covariance
    known = np.diag(2.0 * variance**2 / dof)
    none = (0,) * variance.size
    return ScatterModel(names=tuple(stds), levels=none, variance=variance, covariance=known, slopes=slopes)


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
