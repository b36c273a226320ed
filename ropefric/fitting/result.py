"""What a fit hands on: parameters with their uncertainty, how they were got, and whether to trust them.

The one verdict on a law and on what it predicts is supported, undecided or not judged, with the reason in words. All
rules stand here, and the terminal, the report, JSON and the exit code say what they say.

not judged
    The data leave no choice or no test: the fit has not converged, the data do not show its parameters or only one
    end of their range, there are fewer than `spare` = 3 more conditions than fitted parameters (as for AICc, which
    has no value below n = k + 2 with the scatter among the k), or no law but one could be weighed.
undecided
    Something speaks against the law. Its own fit: the residuals follow a regressor, the repeats scatter extremely,
    or the conditions scatter more than twice as far as their repeats (a third or more of the residuals then lie
    beyond ±2 of the scatter between repeats) while fewer than ten conditions are left over, too few to show whether
    that is a new rope each time or an effect the law misses; with ten, a trend would have been found, and the
    scatter counts as scatter, which the clustered errors and the prediction interval hold. Another law: one that
    stands more than 2 in AICc before it (an evidence ratio of e), or one within 2 that gives another lift force.
    The interval: the linear one and the one drawn from the parameters' covariance differ by more than a half width.
supported
    Otherwise. A law within 2 that gives the same lift force is no contradiction. Two laws of which neither is a
    special case of the other do where the root mean square of ln F_A between them lies within the half width of the
    used law's interval, and the intervals differ by no more than a factor 2. A law and a richer one that contains
    it do where it lies within both half widths, added as squares: what the richer law knows of its extra effect is
    in its own, wider interval, and that it is wider says nothing against the simpler law.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, fields
from math import inf, isfinite, nan
from typing import Any, Literal, NamedTuple

import numpy as np
from scipy.special import fdtrc

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.fitting.problem import FitProblem
from ropefric.fitting.statistics import FitStatistics, Identifiability
from ropefric.friction.law import FrictionLaw
from ropefric.friction.laws import ALL_LAWS
from ropefric.glossary import AdvisedStatus, counted
from ropefric.registry import Registry
from ropefric.shown import Shown, in_words


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
_ONLY_DOUBTED = (FitStatus.EXTREME_SCATTER, FitStatus.RESIDUAL_STRUCTURE)
# Conditions beyond the fitted parameters: one for the scatter, one more for the small-sample term of AICc.
SPARE = 3
_MANY_SPARE = 10
_SCATTER_RATIO = 2.0
_LACK_OF_FIT_P = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
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


def doubts_of_fit(
    law: str, status: FitStatus, advice: tuple[str, ...], found: FitStatistics
) -> tuple[Doubt, ...]:
    """Return what speaks against a law in its own fit."""
    doubts: list[Doubt] = []
    if status is not FitStatus.OK:
        word: Word = "undecided" if status in _ONLY_DOUBTED else "not judged"
        doubts.append((word, advice[0] if advice else status.advice))
    n, n_fitted = found.n_conditions, found.n - found.dof
    within, between, spare = found.scatter_within, found.scatter_between, n - n_fitted
    if spare < SPARE and status is not FitStatus.TOO_FEW_POINTS:
        text = (
            f"{counted(n, 'condition')} cannot test {counted(n_fitted, 'fitted parameter')} of {law}: "
            f"{n_fitted + SPARE} are needed"
        )
        doubts.append(("not judged", text))
    elif spare < _MANY_SPARE and between > _SCATTER_RATIO * within:
        F = 1.0 + found.n / n * (between / within) ** 2
        if float(fdtrc(spare, found.n - n, F)) < _LACK_OF_FIT_P:
            text = (
                f"the conditions lie {between:.2%} off {law}, their repeats scatter by {within:.2%}: "
                f"{n} conditions do not show whether that is a new rope each time or an effect it misses"
            )
            doubts.append(("undecided", text))
    return tuple(doubts)


CovarianceKind = Literal["absolute", "scaled", "clustered"]

SCHEMA = "ropefric.fit/1"
ERRORS = "two levels"
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
    """An error that several conditions share, such as a cell's gain, and how one standard uncertainty moves the fit."""

    name: str
    unit: str
    std: float
    change: tuple[float, ...]


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
    covariance_kind : {"absolute", "scaled", "clustered"}
        "absolute": from the known scatter as it stands; "scaled": times χ²/dof, because the scatter is not known;
        "clustered": from how the means of the conditions scatter, which includes what the repeats of one share.
    statistics : FitStatistics
        How well it fits.
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
        What several conditions have in common and no scatter shows: cells, wheels, ropes, weights, wraps. `change`
        is that of the parameters by one standard uncertainty; the covariance includes it.
    problem : FitProblem, optional
        What was fitted; None after loading from a file.
    draws : ndarray, shape (n, p), optional
        Parameters refitted by the bootstrap that the intervals are from; None otherwise, and after loading.
    """

    _said = ("law", "status", "verdict=verdict.word", "statistics.n", "statistics.n_conditions")
    _framed = "parameters"

    def _more_said(self) -> Iterator[tuple[str, str]]:
        for item, declared in zip(self.parameters, self.friction_law.parameters, strict=True):
            unit = "" if declared.unit == "-" else declared.unit
            yield (
                item.name,
                in_words(item.value, unit, item.std) + (" (on its bound)" if item.at_bound else ""),
            )

    law: str
    parameters: tuple[FittedParameter, ...]
    covariance: FloatArray
    covariance_kind: CovarianceKind
    statistics: FitStatistics
    status: FitStatus
    advice: tuple[str, ...]
    identifiability: Identifiability
    validity: Mapping[str, tuple[float, float]]
    notes: tuple[str, ...] = ()
    provenance: Mapping[str, Any] = field(default_factory=dict)
    trials: Mapping[str, list[float]] = field(default_factory=dict)
    common_errors: tuple[CommonError, ...] = ()
    problem: FitProblem | None = None
    draws: FloatArray | None = None

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
        return doubts_of_fit(self.law, self.status, self.advice, self.statistics)

    @property
    def verdict(self) -> Verdict:
        """Return the verdict on the law by its own fit; a comparison knows what other laws say."""
        return verdict_of(self.doubts, f"nothing in its own fit speaks against {self.law}")

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
        tree = {item.name: getattr(self, item.name) for item in fields(self) if item.name != "problem"} | {
            "schema": SCHEMA,
            "status": self.status.value,
            "trustworthy": self.trustworthy,
            "parameters": {item.name: asdict(item) for item in self.parameters},
            "parameter_order": [item.name for item in self.parameters],
            "statistics": asdict(self.statistics),
            "identifiability": asdict(self.identifiability),
            "common_errors": [item._asdict() for item in self.common_errors],
        }
        if not self.common_errors:
            del tree["common_errors"]
        for item in tree["parameters"].values():
            del item["name"]
        return dict(_plain(tree))

    @classmethod
    def from_dict(cls, tree: Mapping[str, Any]) -> "FitResult":
        """Return the result of such a tree; `ropefric.fitting.store.load_fit` checks one from a file.

        Raises
        ------
        KeyError, TypeError, ValueError
            If it is no such tree.
        """
        return cls(
            law=ALL_LAWS[tree["law"]].name,
            parameters=tuple(_parameter(name, tree["parameters"][name]) for name in tree["parameter_order"]),
            covariance=np.array([[_number(cell) for cell in row] for row in tree["covariance"]], np.float64),
            covariance_kind=tree["covariance_kind"],
            statistics=FitStatistics(**{key: _number(value) for key, value in tree["statistics"].items()}),
            status=FitStatus(tree["status"]),
            advice=tuple(tree["advice"]),
            notes=tuple(tree["notes"]),
            identifiability=Identifiability.from_dict(tree["identifiability"]),
            validity={name: (float(low), float(high)) for name, (low, high) in tree["validity"].items()},
            provenance=dict(tree["provenance"]),
            trials={name: [_number(cell) for cell in column] for name, column in tree["trials"].items()},
            common_errors=tuple(
                CommonError(
                    item["name"], item["unit"], _number(item["std"]), tuple(map(_number, item["change"]))
                )
                for item in tree.get("common_errors", ())
            ),
        )


def _parameter(name: str, item: Mapping[str, Any]) -> FittedParameter:
    at_bound, (low, high) = bool(item["at_bound"]), item["ci95"]
    # On a bound there is no error; elsewhere a number that JSON cannot hold was infinite.
    gone = nan if at_bound else inf
    absent = {"value": nan, "std": gone, "lower": -inf, "upper": inf}
    numbers = {key: float(_number(item[key], default)) for key, default in absent.items()}
    ci95 = (float(_number(low, -gone)), float(_number(high, gone)))
    return FittedParameter(name=name, ci95=ci95, at_bound=at_bound, vary=bool(item["vary"]), **numbers)


def _number(value: Any, gone: float = nan) -> Any:
    if value is None:
        return gone
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError(f"{value!r:.40} is no number")
    if not isfinite(float(value)):
        raise TypeError(f"{value!r:.40} is no number that a fit can hold")
    return value


def _plain(value: Any) -> Any:
    """Return a tree of dict, list, str, int, float, bool and None only."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic | np.ndarray):
        return _plain(value.tolist())
    return None if isinstance(value, float) and not isfinite(value) else value
