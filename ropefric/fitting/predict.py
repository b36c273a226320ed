"""From a fitted law to the lift force of a wheel, with the interval of the law and of one new rope.

The covariance of the parameters becomes the uncertainty of ln F_A by J C Jᵀ; for laws that are curved in their
parameters the profile of ln F_A takes its place. For fits and plots of one's own a law is also an `lmfit.Model`;
ropefric itself fits without lmfit.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from inspect import Parameter, Signature
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.special import ndtr, ndtri

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError, UnknownNameError
from ropefric.files.plain_text import rounded_tree
from ropefric.fitting.intervals import is_curved, profile_lift
from ropefric.fitting.problem import law_named
from ropefric.fitting.reml import REPEAT
from ropefric.fitting.result import FitResult, FitStatus, Verdict
from ropefric.fitting.scatter import ScatterModel, measured_level
from ropefric.friction.condition import SETTINGS, Conditions
from ropefric.friction.law import FrictionLaw, LiftModel
from ropefric.registry import did_you_mean
from ropefric.shown import Shown
from ropefric.uncertainty.budget import check_level

if TYPE_CHECKING:
    import lmfit

Method = Literal["auto", "linear", "profile"]
METHODS = ("auto", "linear", "profile")
"""How the uncertainty of a law is carried over; "auto" is the profile for curved laws and 100 conditions at most."""
Validity = Mapping[str, tuple[float, float]]

REGRESSORS = {
    "wheel_radius_m": ("wheel radius", "mm", 1e3),
    "rope_radius_m": ("rope radius", "mm", 1e3),
    "wrap_angle_rad": ("wrap", "deg", math.degrees(1.0)),
    "end_tension_N": ("end tension", "N", 1.0),
}
"""Each regressor's name in words, the unit people read it in, and the factor to that unit."""

# Settings are written in round degrees and millimetres; the last digits of the conversion are no extrapolation.
_SLACK = 1e-6
_LARGEST = math.log(np.finfo(np.float64).max)
_ENDS_N = ("interval_N", "prediction_interval_N")
# The profile of a prediction is made unasked only where it is quick.
_PROFILED = 100
# Shares of a variance for which heavy tails are tabulated, ln ½χ² of the mixture, and Newton's steps, which settle.
_SHARES, _LOG_CHI2, _NEWTON = np.linspace(0.0, 1.0, 257), np.linspace(-18.0, 5.0, 231), 40
# Fewer degrees of freedom than this are said.
_FEW_DOF = 6.0
# Nothing is left to estimate an interval from: what was not found could be anything.
_NOTHING_TOLD = (FitStatus.TOO_FEW_POINTS, FitStatus.NOT_CONVERGED)


EXTRAPOLATED = "extrapolated"
"""The column of sweeps and draws that is 1 where a law is used outside what it was tested for, elsewhere 0."""


def outside_range(validity: Validity, conditions: Conditions) -> BoolArray:
    """Return which regressors lie outside the tested range, shape (n, 4), columns in the order of `REGRESSORS`."""
    values = np.stack([getattr(conditions, name) for name in REGRESSORS], axis=-1)
    low, high = np.array([validity.get(name, (-math.inf, math.inf)) for name in REGRESSORS]).T
    return np.asarray((values < low * (1.0 - _SLACK)) | (values > high * (1.0 + _SLACK)))


def outside_words(validity: Validity, conditions: Conditions, index: int = 0) -> tuple[str, ...]:
    """Return one sentence for each regressor of a condition that lies outside the tested range."""
    flags = outside_range(validity, conditions.select([index]))[0]
    words = []
    for flag, (name, (title, unit, factor)) in zip(flags, REGRESSORS.items(), strict=True):
        if flag:
            low, high = (value * factor for value in validity[name])
            value = float(getattr(conditions, name)[index]) * factor
            tested = f"{low:.4g}" if math.isclose(low, high, rel_tol=_SLACK) else f"{low:.4g}–{high:.4g}"
            words.append(f"{title} {value:.4g} {unit} is outside the tested {tested} {unit}")
    return tuple(words)


class RopePrediction(NamedTuple):
    """Lift forces with a rope that was measured, for n conditions: the law and the measured deviation of that rope.

    The force and its standard deviation (n,) [N], where the mean of the rope and where one pull with it lies (n, 2)
    [N], and the degrees of freedom of the former (n,).
    """

    rope: str
    lift_force_N: FloatArray
    std_N: FloatArray
    interval_N: FloatArray
    prediction_interval_N: FloatArray
    dof: FloatArray


class Candidate(NamedTuple):
    """One of several laws that the data do not distinguish: lift force, its standard deviation and interval."""

    law: str
    lift_force_N: float
    std_N: float
    interval_N: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Prediction(Shown):
    """Lift forces of a fitted law for n conditions, with their intervals and verdicts.

    Attributes
    ----------
    law : str
        The law.
    conditions : Conditions
        n conditions.
    log_lift, std_log : ndarray, shape (n,)
        ln(F_A / 1 N) of the mean law and its standard deviation [-].
    lift_force_N, std_N : ndarray, shape (n,)
        F_A [N] and its standard deviation F_A · std_log [N].
    interval_N : ndarray, shape (n, 2)
        Confidence interval of the mean law [N]: where the average of many ropes lies. It is made in ln F_A and
        so is longer upward.
    prediction_interval_N : ndarray, shape (n, 2)
        Where the F_A of one pull with one new rope lies [N]: the scatter between repeats and between
        conditions comes on top, each with its own degrees of freedom. NaN where the fit knows no scatter.
    level : float
        Level of both.
    dof : ndarray, shape (n,)
        Degrees of freedom of Student's t in the confidence interval; 0 where nothing is left to estimate it from
        (no condition too many, data that agree to rounding, parameters that the data do not show), so that there is
        no standard deviation and no interval (NaN).
    method : {"linear", "profile"}
        How the uncertainty of the law was carried over: by J C Jᵀ, or along the profile of ln F_A.
    outside : ndarray of bool, shape (n, 4)
        Which of R_w, R_r, φ, F_B lie outside the tested range.
    validity : mapping
        Lowest and highest tested value of each.
    verdict : Verdict
        On the law: by its own fit, or by the comparison it comes from.
    candidates : tuple of Candidate
        Answers of the laws that the data cannot distinguish, the law used first; empty for a single law.
    of : {"peak", "kinetic"}
        Which force was fitted, so that `lift_force_N` is what sets the rope in motion or what keeps it sliding.
    this_rope : RopePrediction, optional
        The same for a rope that was measured, if one was asked for.
    trials : mapping of str to list
        The measured conditions of the fit, as in `FitResult.trials`; empty where the fit has none.
    tail_dof : float
        Degrees of freedom of the Student's t that repeats follow, and with them one pull; infinite where they are
        normal.
    """

    _said = ("law", "lift_force_N ± std_N", *_ENDS_N, "level", "extrapolated", "verdict=verdict.word")
    _settings = tuple(f"conditions.{name}" for name in SETTINGS)
    _framed = (*_settings, "lift_force_N", "std_N", *_ENDS_N, "extrapolated")

    law: str
    conditions: Conditions
    log_lift: FloatArray
    std_log: FloatArray
    lift_force_N: FloatArray
    std_N: FloatArray
    interval_N: FloatArray
    prediction_interval_N: FloatArray
    rope_interval_N: FloatArray | None
    level: float
    dof: FloatArray
    method: Method
    outside: BoolArray
    validity: Validity
    verdict: Verdict
    candidates: tuple[Candidate, ...] = ()
    of: str = "peak"
    this_rope: RopePrediction | None = None
    trials: Mapping[str, list[float]] = field(default_factory=dict)
    tail_dof: float = math.inf

    def __len__(self) -> int:
        return len(self.conditions)

    @property
    def extrapolated(self) -> BoolArray:
        """Return which conditions lie outside the tested range in any regressor, shape (n,)."""
        return np.asarray(self.outside.any(axis=1))

    @property
    def log_half_width(self) -> FloatArray:
        """Return half the confidence interval of ln F_A, shape (n,)."""
        return np.asarray(0.5 * np.diff(np.log(self.interval_N), axis=1)[:, 0])

    @property
    def spread_N(self) -> tuple[float, float] | None:
        """Return the lowest and highest end of the candidates' intervals, or of their forces where one has none."""
        if not self.candidates:
            return None
        ends = [end for item in self.candidates for end in (*item.interval_N, item.lift_force_N)]
        known = [end for end in ends if math.isfinite(end)]
        return min(known), max(known)

    def notes(self, index: int = 0) -> tuple[str, ...]:
        """Return what to know about one condition before trusting its numbers; empty if nothing."""
        words = outside_words(self.validity, self.conditions, index)
        if math.isfinite(self.tail_dof):
            text = "repeats have heavier tails than normal scatter, so the interval of one pull follows Student's t"
            words += (f"{text} with {self.tail_dof:.0f} degrees of freedom",)
        if 0.0 < self.dof[index] < _FEW_DOF:
            few = f"the interval rests on {self.dof[index]:.2g} degrees of freedom"
            return (*words, f"{few}: more ropes or conditions would narrow it most")
        return words

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON shape: one flat object for one condition, `{"predictions": [...]}` for several."""
        rows = [self._row(i) for i in range(len(self))]
        return rows[0] if len(rows) == 1 else {"predictions": rows}

    def _row(self, i: int) -> dict[str, Any]:
        arrays = ("lift_force_N", "std_N", *_ENDS_N, "extrapolated", "dof")
        found = {name: getattr(self, name)[i] for name in arrays}
        found |= {name: getattr(self, name) for name in ("level", "method", "spread_N", "of")} | {
            "rope_interval_N": None if self.rope_interval_N is None else self.rope_interval_N[i],
            "notes": self.notes(i),
            "verdict": self.verdict.to_dict(),
            "candidates": [item._asdict() for item in self.candidates],
        }
        found |= {"tail_dof": self.tail_dof} if math.isfinite(self.tail_dof) else {}
        if (of := self.this_rope) is not None:
            found["this_rope"] = {"rope": of.rope} | dict(
                zip(of._fields[1:], (x[i] for x in of[1:]), strict=True)
            )
        return {"law": self.law, **self.conditions.row(i), **rounded_tree(found)}


def predict(
    fit: FitResult,
    conditions: Conditions,
    *,
    level: float = 0.95,
    method: Method = "auto",
    linear_density_kg_m: float | None = None,
    speed_m_s: float | None = None,
    rope: str | None = None,
) -> Prediction:
    """Return the lift force of a fitted law for n conditions, with its intervals; also of a `rope` that was measured.

    Outside what was tested they hold those of the laws that a comparison does not exclude, `fit.rivals`.
    """
    model = _model(fit, linear_density_kg_m, speed_m_s)
    check_level(level)
    if method not in METHODS:
        raise InputError(f"unknown method {method!r}", key="method", fix=f"use {', '.join(METHODS)}")
    log_lift = model.log_lift(fit.theta, conditions)
    if (log_lift > _LARGEST).any():
        worst = int(np.argmax(log_lift))
        text = f"ln F_A = {log_lift[worst]:.6g} at {conditions.describe(worst)}: the force overflows"
        raise InputError(text, code="RF420", fix="use a smaller wrap; in Python, law.log_lift stays finite")
    spread, probability = _spread(fit, model, conditions), 0.5 + 0.5 * level
    ends = lift_ends(fit, model, conditions, probability, method)
    this = None if rope is None else _of_rope(fit, model, conditions, rope, probability)
    with np.errstate(over="ignore"):
        lift_N, mean_N, pull_N, rope_N = (np.exp(one) for one in (log_lift, *ends))
        return Prediction(
            law=fit.law,
            conditions=conditions,
            log_lift=log_lift,
            std_log=np.sqrt(spread.law),
            lift_force_N=lift_N,
            std_N=lift_N * np.sqrt(spread.law),
            interval_N=mean_N,
            prediction_interval_N=pull_N,
            rope_interval_N=rope_N if fit.scatter.groups else None,
            level=level,
            dof=spread.dof,
            method="profile" if _takes_profile(fit, model.pressing(conditions), method) else "linear",
            outside=outside_range(fit.validity, conditions),
            validity=fit.validity,
            verdict=fit.verdict_on(conditions),
            of=fit.of,
            this_rope=this,
            trials=fit.trials,
            tail_dof=fit.scatter.tail_dof,
        )


class LiftEnds(NamedTuple):
    """Ends of intervals of ln F_A at n conditions, shape (n, 2): of the mean law, one pull, the mean of one new rope."""

    mean: FloatArray
    pull: FloatArray
    rope: FloatArray


def lift_ends(
    fit: FitResult, model: LiftModel, conditions: Conditions, probability: float, method: Method = "auto"
) -> LiftEnds:
    """Return the intervals of ln F_A that end with a probability on either side.

    Outside what was tested they include those of all rivals.
    """
    own = _own_ends(fit, model, conditions, probability, method)
    return LiftEnds(*_with_rivals(fit, model, conditions, own, partial(_own_ends, probability=probability)))


def _own_ends(
    fit: FitResult, model: LiftModel, conditions: Conditions, probability: float, method: Method = "auto"
) -> LiftEnds:
    """Return `lift_ends` of the law itself."""
    spread, at = _spread(fit, model, conditions), model.log_lift(fit.theta, conditions)[:, None]
    reach = fit.scatter.reach(probability, spread.law, spread.rows, known=spread.known)
    half, signs = reach * np.sqrt(spread.law), np.array([-1.0, 1.0])
    mean = at + signs * half[:, None]
    if _takes_profile(fit, model.pressing(conditions), method):
        mean = _profiled(fit, model, conditions, half)
    groups = np.array([name in fit.scatter.groups for name in fit.scatter.names], np.bool_)
    # What one pull adds to the linear interval of the law is added to its profile as well.
    pull, new = (
        np.sqrt(np.maximum(_wide(fit, one, probability) ** 2 - half**2, 0.0)[:, None] + (mean - at) ** 2)
        for one in (spread, spread._replace(own=spread.own * groups))
    )
    # One pull of few degrees of freedom may seem to be known better than the mean of its rope.
    return LiftEnds(mean, at + signs * np.fmax(pull, new), at + signs * new)


def _takes_profile(fit: FitResult, conditions: Conditions, method: Method) -> bool:
    """Return whether the uncertainty of the law at conditions is carried over along its profile."""
    if method == "profile" and not has_interval(fit):
        text = f"the fit of {fit.law} leaves nothing to estimate an interval from"
        raise InputError(text, key="method", fix="measure more conditions")
    asked = method == "profile" or (method == "auto" and len(conditions) <= _PROFILED)
    return asked and has_interval(fit) and fit.weighted() is not None and is_curved(fit, conditions)


def _profiled(fit: FitResult, model: LiftModel, conditions: Conditions, half: FloatArray) -> FloatArray:
    """Return the ends of ln F_A along its profile, shape (n, 2), of a rope at rest or running."""
    pressing = model.pressing(conditions)
    # Of a running rope only F_A − ρv² depends on the parameters.
    share = np.exp(model.law.log_lift(fit.theta, pressing) - model.log_lift(fit.theta, conditions))
    ends = profile_lift(fit, pressing, half / share)
    return ends if model.inertia_N == 0.0 else np.logaddexp(math.log(model.inertia_N), ends)


def _of_rope(
    fit: FitResult, model: LiftModel, conditions: Conditions, rope: str, probability: float
) -> RopePrediction:
    """Return the lift forces with a rope of the trials by its name."""
    own, names = _measured_rope(fit, model, conditions, rope, probability), fit.scatter.labels.get("rope", ())
    if own is None and rope in (names or (rope,)):
        text = f"the fit of {fit.law} has no component of scatter by rope"
        fix = "fit trials with a column rope_id, in which each rope was pulled at several conditions"
        raise InputError(text, key="rope", fix=fix)
    if own is None:
        text = f"no trial of the fit was made with the rope {rope!r}"
        raise UnknownNameError(text, key="rope", fix=did_you_mean(rope, names))

    def of_rival(rival: FitResult, law: LiftModel, places: Conditions) -> tuple[FloatArray, ...]:
        found = _measured_rope(rival, law, places, rope, probability)
        return () if found is None else (found.interval_N, found.prediction_interval_N)

    ends_N = own.interval_N, own.prediction_interval_N
    mean_N, pull_N = _with_rivals(fit, model, conditions, ends_N, of_rival)
    return own._replace(interval_N=mean_N, prediction_interval_N=pull_N)


def _measured_rope(
    fit: FitResult, model: LiftModel, conditions: Conditions, rope: str, probability: float
) -> RopePrediction | None:
    """Return the lift forces with a rope by the law alone; None where the fit has no component for it."""
    scatter, cells = fit.scatter, fit.cells()
    if cells is None or rope not in scatter.labels.get("rope", ()):
        return None
    spread, (layout, errors) = _spread(fit, model, conditions), cells
    of, none = ("rope", scatter.labels["rope"].index(rope)), np.zeros_like(spread.rows)
    found = measured_level(layout, scatter, fit.theta, errors, of, spread.rows, spread.rise)
    # One pull with this rope: what is not the rope's comes new.
    new = spread.own * (np.array(scatter.names) != "rope")
    grouped = np.array([name in scatter.groups for name in scatter.names])
    shown = np.where(grouped, np.maximum(scatter.variance, 0.0), scatter.variance)
    stds, dofs, reach = [], [], []
    for more in (np.zeros_like(new), new):
        own = found.own + more
        known = found.known + found.estimated
        variance = np.maximum(found.own @ shown, 0.0) + more @ np.maximum(shown, 0.0) + known
        stds.append(np.sqrt(np.where(has_interval(fit), variance, np.nan)))
        dofs.append(scatter.dof(none, own, found.known))
        tails = _by_tails(scatter, probability, variance, more)
        reach.append(scatter.reach(probability, variance, none, own, known) * stds[-1] * tails)
    log_lift, signs = model.log_lift(fit.theta, conditions) + found.shift, np.array([-1.0, 1.0])
    with np.errstate(over="ignore"):
        force_N = np.exp(log_lift)
        mean_N, pull_N = (np.exp(log_lift[:, None] + signs * x[:, None]) for x in (reach[0], np.fmax(*reach)))
    return RopePrediction(rope, force_N, force_N * stds[0], mean_N, pull_N, dofs[0])


def _with_rivals(
    fit: FitResult,
    model: LiftModel,
    conditions: Conditions,
    ends: Sequence[FloatArray],
    of_rival: Callable[[FitResult, LiftModel, Conditions], Sequence[FloatArray]],
) -> list[FloatArray]:
    """Return ends of intervals (n, 2) which, outside what was tested, include those that `of_rival` gives of rivals."""
    outside, wider = outside_range(fit.validity, conditions).any(axis=1), [one.copy() for one in ends]
    for rival in fit.rivals if outside.any() else ():
        law, places = replace(model, law=rival.friction_law), np.flatnonzero(outside)
        places = places[law.law.answers(rival.theta, law.pressing(conditions.select(places)))]
        if places.size:
            theirs = of_rival(rival, law, conditions.select(places))
            for own, other in zip(wider, theirs, strict=False):
                own[places, 0] = np.fmin(own[places, 0], other[:, 0])
                own[places, 1] = np.fmax(own[places, 1], other[:, 1])
    return wider


def has_interval(fit: FitResult) -> bool:
    """Return whether the data leave anything to estimate an interval of the law from."""
    return fit.statistics.interval_dof != 0.0 and fit.status not in _NOTHING_TOLD and fit.has_errors


class Spread(NamedTuple):
    """Variances of ln F_A of n conditions: of the mean law, with degrees of freedom, and what one pull brings.

    `own` (n, m) says how much of each component of scatter one pull adds, `rise` (n,) is ln(F_A/F_B).
    """

    law: FloatArray
    dof: FloatArray
    rows: FloatArray
    known: FloatArray
    own: FloatArray
    rise: FloatArray


def _spread(fit: FitResult, model: LiftModel, conditions: Conditions) -> Spread:
    """Return the variances of ln F_A at conditions, NaN where they are unknown."""
    J, scatter = model.jacobian(fit.theta, conditions), fit.scatter
    # Rounding may turn a variance of zero a hair negative.
    variance = np.maximum(((J @ fit.covariance) * J).sum(axis=-1), 0.0)
    known = ((J @ fit.common_changes) ** 2).sum(axis=1)
    dof = scatter.dof(J, known=known) if scatter.names else np.zeros(len(J))
    if not has_interval(fit):
        variance, dof = np.full_like(variance, np.nan), np.zeros_like(dof)
    log_lift = model.log_lift(fit.theta, conditions)
    rise = log_lift - conditions.log_end_tension
    return Spread(variance, dof, J, known, scatter.one_pull(log_lift, rise), rise)


def _wide(fit: FitResult, spread: Spread, probability: float) -> FloatArray:
    """Return how far ln F_A of one pull, or of one rope, may lie to one side, with a probability, shape (n,)."""
    scatter = fit.scatter
    if not scatter.of_pulls:
        return np.full_like(spread.law, np.nan)
    variance = spread.law + spread.own @ np.maximum(scatter.variance, 0.0)
    reach = scatter.reach(probability, variance, spread.rows, spread.own, spread.known)
    return np.asarray(reach * np.sqrt(variance) * _by_tails(scatter, probability, variance, spread.own))


def _by_tails(scatter: ScatterModel, probability: float, variance: FloatArray, own: FloatArray) -> FloatArray:
    """Return how many times further than normal scatter one pull reaches, shape (n,): 1 where repeats are normal.

    Of the variances (n,) the part of one repeat follows Student's t, and the rest is normal.
    """
    if not (math.isfinite(scatter.tail_dof) and probability > 0.5):
        return np.ones_like(variance)
    by_repeat = np.array([name == REPEAT for name in scatter.names]) * np.maximum(scatter.variance, 0.0)
    share = own @ by_repeat / np.maximum(variance, np.finfo(np.float64).tiny)
    return np.asarray(np.interp(share, _SHARES, _reach_of_tails(scatter.tail_dof, probability)))


@cache
def _reach_of_tails(dof: float, probability: float) -> FloatArray:
    """Return the quantile over the normal's of a normal and a Student's t that has the part `_SHARES` of the variance.

    A t is a normal of variance (ν − 2)/χ²_ν, so the sum is a mixture of normals, by the trapezoidal rule in ln χ².
    Its distribution is concave above the median, so Newton's steps from there rise to the quantile.
    """
    half_chi2 = np.exp(_LOG_CHI2)
    weights = np.exp(0.5 * dof * _LOG_CHI2 - half_chi2)
    weights /= weights.sum()
    share = _SHARES[:, None]
    std = np.sqrt(1.0 - share + share * (0.5 * dof - 1.0) / half_chi2)
    quantile = np.zeros(_SHARES.size)
    for _ in range(_NEWTON):
        z = quantile[:, None] / std
        density = (np.exp(-0.5 * z**2) / std) @ weights / math.sqrt(2.0 * math.pi)
        quantile += (probability - ndtr(z) @ weights) / density
    return quantile / float(ndtri(probability))


def degrees_of_freedom(fit: FitResult) -> float:
    """Return the degrees of freedom behind a fit's covariance, the fewest of its parameters; infinite where known."""
    dof = fit.statistics.interval_dof
    # A file has no infinity, so an infinite number of degrees of freedom comes back as NaN.
    return math.inf if math.isnan(dof) else max(dof, 1.0)


def _model(fit: FitResult, density: float | None, speed: float | None) -> LiftModel:
    if (density is None) != (speed is None):
        missing = "speed_m_s" if speed is None else "linear_density_kg_m"
        text = f"a running rope needs its mass per length and its speed; {missing} is missing"
        raise InputError(text, key=missing, fix="give both, or neither for a rope at rest")
    return LiftModel(law=fit.friction_law, linear_density_kg_m=density or 0.0, speed_m_s=speed or 0.0)


def lmfit_model(law: str | FrictionLaw) -> "lmfit.Model":
    """Return a friction law as an `lmfit.Model` of ln(F_A / 1 N), with its start values and bounds.

    The scatter of break-away forces is a part of the force, so the logarithm is what least squares should see.
    lmfit takes derivatives by differences and knows nothing of repeats of a condition: for a law with honest
    uncertainty use `fit`.

    Parameters
    ----------
    law : str or FrictionLaw
        "constant", "wrap-power", "coupled", …

    Returns
    -------
    lmfit.Model
        Its independent variables are `wheel_radius_m`, `rope_radius_m` [m], `wrap_angle_rad` [rad] and
        `end_tension_N` [N], numbers or arrays of one length; its parameters are those of the law. `make_params()`
        gives them the law's start values and bounds, and holds those that a fit of the law holds.

    Raises
    ------
    UnknownNameError
        If there is no such law.
    InputError
        RF420 on evaluation, where the law has no answer.

    Examples
    --------
    >>> import numpy as np
    >>> import ropefric as rf
    >>> model = rf.lmfit_model("constant")
    >>> pulls = {"wheel_radius_m": 0.04, "rope_radius_m": 0.005, "wrap_angle_rad": np.array([3.0, 6.0, 9.0]),
    ...     "end_tension_N": 20.0}
    >>> found = model.fit(np.log([36.6, 66.1, 121.7]), **pulls)
    >>> round(found.best_values["mu"], 3)
    0.2
    """
    import lmfit  # noqa: PLC0415  (slow to load, and nothing else needs it)

    chosen = law_named(law)

    def log_lift(**values: npt.ArrayLike) -> FloatArray:
        conditions = Conditions(**{name: np.asarray(values[name], np.float64) for name in SETTINGS})
        return chosen.log_lift([float(values[name]) for name in chosen.parameter_names], conditions)  # type: ignore[arg-type]

    # lmfit reads the names of a model from its signature.
    names = (*SETTINGS, *chosen.parameter_names)
    log_lift.__signature__ = Signature([Parameter(name, Parameter.KEYWORD_ONLY) for name in names])  # type: ignore[attr-defined]
    model = lmfit.Model(log_lift, independent_vars=list(SETTINGS), name=chosen.name)
    for item in chosen.parameters:
        model.set_param_hint(item.name, value=item.start, min=item.lower, max=item.upper, vary=not item.fixed)
    return model
