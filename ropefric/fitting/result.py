"""What a fit hands on: parameters with their uncertainty, how they were got, and whether to trust them."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from math import inf, isfinite, nan
from typing import Any, Literal

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.fitting.problem import FitProblem
from ropefric.fitting.statistics import FitStatistics, Identifiability
from ropefric.fitting.verdict import Doubt, FitStatus, Verdict, doubts_of_fit, verdict_of
from ropefric.friction.law import FrictionLaw
from ropefric.friction.laws import ALL_LAWS

CovarianceKind = Literal["absolute", "scaled", "clustered"]

SCHEMA = "ropefric.fit/1"


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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FitResult:
    """A fitted friction law.

    Attributes
    ----------
    law : str
        Name of the law.
    parameters : tuple of FittedParameter
        In the law's order.
    covariance : ndarray, shape (p, p)
        Covariance of the parameters in the law's order; zero for those that are fixed or on a bound.
    covariance_kind : {"absolute", "scaled", "clustered"}
        "absolute": from the known scatter as it stands; "scaled": times χ²/dof, because the scatter is not known;
        "clustered": sandwich over conditions, which includes what the repeats of a condition share.
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
    problem : FitProblem, optional
        What was fitted; None after loading from a file.
    """

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
    problem: FitProblem | None = None

    @property
    def theta(self) -> FloatArray:
        """Return the parameter values, shape (p,)."""
        return np.array([parameter.value for parameter in self.parameters])

    @property
    def shown(self) -> BoolArray:
        """Return which parameters were fitted and lie on no bound, shape (p,): those with a variance."""
        return np.array([item.vary and not item.at_bound for item in self.parameters], dtype=np.bool_)

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
            raise InputError(
                f"the fit rests on ropes of {2e3 * low:.4g} to {2e3 * high:.4g} mm, so none is meant by itself",
                key="rope_radius_m",
                fix="say which rope is meant",
            )
        return low

    def __getitem__(self, name: str) -> FittedParameter:
        return {parameter.name: parameter for parameter in self.parameters}[name]

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON tree of schema `ropefric.fit/1`; a number that is not there or infinite is None."""
        tree = {
            "schema": SCHEMA,
            "law": self.law,
            "parameters": {
                item.name: {key: value for key, value in asdict(item).items() if key != "name"}
                for item in self.parameters
            },
            "parameter_order": [item.name for item in self.parameters],
            "covariance": self.covariance.tolist(),
            "covariance_kind": self.covariance_kind,
            "statistics": asdict(self.statistics),
            "status": self.status.value,
            "trustworthy": self.trustworthy,
            "advice": list(self.advice),
            "notes": list(self.notes),
            "identifiability": asdict(self.identifiability),
            "validity": {name: list(span) for name, span in self.validity.items()},
            "provenance": dict(self.provenance),
            "trials": dict(self.trials),
        }
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
        )


def _parameter(name: str, item: Mapping[str, Any]) -> FittedParameter:
    at_bound = bool(item["at_bound"])
    # On a bound there is no error; elsewhere a number that JSON cannot hold was infinite.
    gone = nan if at_bound else inf
    low, high = item["ci95"]
    return FittedParameter(
        name=name,
        value=float(item["value"]),
        std=float(_number(item["std"], gone)),
        ci95=(float(_number(low, -gone)), float(_number(high, gone))),
        lower=float(_number(item["lower"], -inf)),
        upper=float(_number(item["upper"], inf)),
        at_bound=at_bound,
        vary=bool(item["vary"]),
    )


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
    if isinstance(value, np.generic):
        return _plain(value.item())
    return None if isinstance(value, float) and not isfinite(value) else value
