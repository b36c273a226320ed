"""From a fitted law to the lift force of a wheel, with the interval of the law and of one new rope; laws for others.

The covariance of the parameters becomes the uncertainty of ln F_A by J C Jᵀ, and draws check that. For others: a table
μ(φ, F_B, R_w) of a fit for simulators and the constant that stands for it best, and a law as an `lmfit.Model`, for fits
and plots of one's own; ropefric itself fits without lmfit.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from inspect import Parameter, Signature
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq
from scipy.special import ndtri, stdtr, stdtrit

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.files.plain_text import rounded_tree
from ropefric.fitting.problem import law_named
from ropefric.fitting.result import Doubt, FitResult, FitStatus, Verdict, verdict_of
from ropefric.fitting.statistics import combined_dof
from ropefric.friction.condition import SETTINGS, Conditions
from ropefric.friction.law import FrictionLaw, LiftModel
from ropefric.shown import Shown
from ropefric.uncertainty.budget import check_level, joint_draws, symmetric_root

if TYPE_CHECKING:
    import lmfit

Method = Literal["linear", "monte-carlo"]
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
_DISAGREEMENT = 0.1
_ENDS_N = ("interval_N", "prediction_interval_N")
# Forces that agree to this are the same whatever their intervals.
_SAME = 1e-6
# The check of the linear interval by draws is made unasked only where it is quick.
_CHECKED_CONDITIONS = 100
_CHECKING_DRAWS = 2000
# Draws times conditions held in memory at once.
_BLOCK = 1_000_000
# Student's t of so many degrees of freedom is normal; beyond so many scales lies none of a mixture's ends.
_MANY_DOF, _FARTHEST, _HALVINGS = 1e6, 1e3, 80
_ONE_SIGMA = 0.8413447460685429
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


class Candidate(NamedTuple):
    """What one of several laws that are not told apart answers: lift force, its standard deviation and interval."""

    law: str
    lift_force_N: float
    std_N: float
    interval_N: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Prediction(Shown):
    """Lift forces of a fitted law for n conditions, with what is known about them.

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
    method : {"linear", "monte-carlo"}
        How the uncertainty of the law was carried over.
    linear_agrees : ndarray of bool, shape (n,), or None
        Whether the ends of the linear and of the Monte-Carlo interval agree within 10 % of its half width;
        None where this was not looked at.
    drawn_interval_N : ndarray, shape (n, 2), or None
        The Monte-Carlo interval [N], where it was made.
    outside : ndarray of bool, shape (n, 4)
        Which of R_w, R_r, φ, F_B lie outside the tested range.
    validity : mapping
        Lowest and highest tested value of each.
    draws, seed : int
        Monte-Carlo draws and their seed; 0 draws if there were none.
    judged : Verdict
        On the law: by its own fit, or by the comparison it comes from.
    candidates : tuple of Candidate
        What the laws answer that the data do not tell apart, the law used first; empty where there is one only.
    averaged : tuple of str
        The laws whose answers were averaged, because the data leave them undecided; empty for one law.
    of : {"peak", "kinetic"}
        Which force was fitted, so that `lift_force_N` is what sets the rope in motion or what keeps it sliding.
    """

    _said = ("law", "lift_force_N ± std_N", *_ENDS_N, "level", "extrapolated", "verdict=judged.word")
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
    level: float
    dof: FloatArray
    method: Method
    linear_agrees: BoolArray | None
    drawn_interval_N: FloatArray | None
    outside: BoolArray
    validity: Validity
    draws: int
    seed: int
    judged: Verdict
    candidates: tuple[Candidate, ...] = ()
    averaged: tuple[str, ...] = ()
    of: str = "peak"

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

    def verdict(self, index: int = 0) -> Verdict:
        """Return the verdict on the lift force of one condition: that on the law, and on the interval."""
        doubts: list[Doubt] = [(self.judged.word, text) for text in self.judged.reasons]
        linear_N, drawn_N = self.interval_N[index], self.drawn_interval_N
        # By more than half a width: a gross disagreement.
        room = 0.5 * float(np.diff(linear_N)[0]) + _SAME * float(np.abs(linear_N).max())
        apart = math.inf if drawn_N is None else float(np.abs(drawn_N[index] - linear_N).max())
        if self.method == "linear" and apart > room:
            doubts += [("undecided", text) for text in self._disagreement(index)]
        return verdict_of(doubts, self.judged.reason.removesuffix("."))

    def notes(self, index: int = 0) -> tuple[str, ...]:
        """Return what to know about one condition before trusting its numbers; empty if nothing."""
        return (*outside_words(self.validity, self.conditions, index), *self._disagreement(index))

    def _disagreement(self, index: int) -> tuple[str, ...]:
        """Return how far the linear and the drawn interval lie apart, where they disagree."""
        if self.linear_agrees is None or self.linear_agrees[index]:
            return ()
        text = "the interval depends on how the parameters' uncertainty is carried over: linearly"
        if self.drawn_interval_N is None:
            return (f"{text} only, for the law has no answer for most of what they may be",)
        (near, far), (low, high) = self.interval_N[index], self.drawn_interval_N[index]
        return (f"{text} {near:.4g}–{far:.4g} N, drawn from their covariance {low:.4g}–{high:.4g} N",)

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON shape: one flat object for one condition, `{"predictions": [...]}` for several."""
        rows = [self._row(i) for i in range(len(self))]
        return rows[0] if len(rows) == 1 else {"predictions": rows}

    def _row(self, i: int) -> dict[str, Any]:
        arrays = ("lift_force_N", "std_N", *_ENDS_N, "extrapolated", "dof")
        found = {name: getattr(self, name)[i] for name in arrays}
        found |= {name: getattr(self, name) for name in ("level", "method", "spread_N", "of")} | {
            "linear_agrees": None if self.linear_agrees is None else self.linear_agrees[i],
            "notes": self.notes(i),
            "verdict": self.verdict(i).to_dict(),
            "candidates": [item._asdict() for item in self.candidates],
            "averaged": self.averaged,
        }
        return {"law": self.law, **self.conditions.row(i), **rounded_tree(found)}


def predict(
    fit: FitResult,
    conditions: Conditions,
    *,
    level: float = 0.95,
    method: Method = "linear",
    n: int = 20_000,
    seed: int = 0,
    check: bool | None = None,
    linear_density_kg_m: float | None = None,
    speed_m_s: float | None = None,
) -> Prediction:
    """Return the lift force of a fitted law for n conditions, with its intervals."""
    model = _model(fit, linear_density_kg_m, speed_m_s)
    check_level(level)
    if method not in ("linear", "monte-carlo"):
        raise InputError(f"unknown method {method!r}", key="method", fix="use 'linear' or 'monte-carlo'")
    log_lift = model.log_lift(fit.theta, conditions)
    if (log_lift > _LARGEST).any():
        worst = int(np.argmax(log_lift))
        text = f"ln F_A = {log_lift[worst]:.6g} at {conditions.describe(worst)}: the force overflows"
        raise InputError(text, code="RF420", fix="use a smaller wrap; in Python, law.log_lift stays finite")
    (variance, dof), probability = _law_spread(fit, model, conditions), 0.5 + 0.5 * level
    told = has_interval(fit)
    if not told:
        variance, dof = np.full_like(variance, math.nan), np.zeros_like(dof)
    std = np.sqrt(variance)
    half = _quantiles(probability, dof) * std
    ends = np.stack([log_lift - half, log_lift + half], axis=1)
    if check is None:
        check = len(conditions) <= _CHECKED_CONDITIONS
    drawing = method == "monte-carlo" and told
    agrees, draws, drawn = None, 0, None
    if drawing or (check and told and np.isfinite(fit.covariance).all()):
        draws = n if drawing else _CHECKING_DRAWS
        try:
            half_68, drawn = drawn_range(model, parameter_draws(fit, draws, seed), conditions, level)
        except InputError:
            if drawing:
                raise
            agrees = np.zeros(len(conditions), dtype=np.bool_)
        else:
            # The 97.5 % point of N draws scatters by about 2.7 σ/√N; three times that is no disagreement.
            room = _DISAGREEMENT + 3.0 * 2.7 / 1.96 / math.sqrt(draws)
            agrees = np.asarray(
                (np.abs(drawn - ends) <= 0.5 * room * np.diff(ends, axis=1) + 1e-12).all(axis=1)
            )
            # A standard deviation is half the central 68.27 % less the t's heavier tails.
            std, ends = (half_68 / _quantiles(_ONE_SIGMA, dof), drawn) if drawing else (std, ends)
    # About the middle of the law's own interval, which is not quite log_lift where draws are skew; as much wider.
    middle, drawn_half = ends.mean(axis=1), 0.5 * np.diff(ends, axis=1)[:, 0]
    wide = half_width(fit, model, conditions, probability) if told else half
    wide = np.sqrt(np.maximum(wide**2 - half**2, 0.0) + drawn_half**2)
    with np.errstate(over="ignore"):
        lift = np.exp(log_lift)
        return Prediction(
            law=fit.law,
            conditions=conditions,
            log_lift=log_lift,
            std_log=std,
            lift_force_N=lift,
            std_N=lift * std,
            interval_N=np.exp(ends),
            prediction_interval_N=np.exp(np.stack([middle - wide, middle + wide], axis=1)),
            level=level,
            dof=dof,
            method=method,
            linear_agrees=agrees,
            drawn_interval_N=None if drawn is None else np.exp(drawn),
            outside=outside_range(fit.validity, conditions),
            validity=fit.validity,
            draws=draws,
            seed=seed,
            judged=fit.verdict_on(conditions),
            of=fit.of,
        )


def has_interval(fit: FitResult) -> bool:
    """Return whether the data leave anything to estimate an interval of the law from."""
    seen = all(math.isfinite(item.std) or item.at_bound for item in fit.parameters)
    return fit.statistics.interval_dof != 0.0 and fit.status not in _NOTHING_TOLD and seen


def _law_spread(fit: FitResult, model: LiftModel, conditions: Conditions) -> tuple[FloatArray, FloatArray]:
    """Return the variance of ln F_A of the mean law, J C Jᵀ, and its degrees of freedom, shape (n,) each."""
    variance = linear_std(model, fit.theta, fit.covariance, conditions) ** 2
    changes = fit.common_changes
    known = linear_std(model, fit.theta, changes @ changes.T, conditions) ** 2
    return variance, combined_dof(variance, known, degrees_of_freedom(fit))


def linear_std(
    model: LiftModel, theta: FloatArray, covariance: FloatArray, conditions: Conditions
) -> FloatArray:
    """Return the standard deviation of ln F_A of the mean law, √(J C Jᵀ), shape (n,)."""
    J = model.jacobian(theta, conditions)
    # Rounding may turn a variance of zero a hair negative.
    return np.asarray(np.sqrt(np.maximum(((J @ covariance) * J).sum(axis=-1), 0.0)))


def _quantiles(probability: float, dof: FloatArray) -> FloatArray:
    """Return Student's t quantiles, shape (n,); NaN without a degree of freedom."""
    finite = stdtrit(np.where((dof > 0.0) & np.isfinite(dof), dof, 1.0), probability)
    return np.where(dof > 0.0, np.where(np.isinf(dof), ndtri(probability), finite), np.nan)


def half_width(fit: FitResult, model: LiftModel, conditions: Conditions, probability: float) -> FloatArray:
    """Return how far ln F_A of one pull with a new rope may lie to one side, with a probability, shape (n,).

    What a new rope brings on top of the law, s_b² + s_w², is a mean square between conditions, with the degrees of
    freedom of the law's own errors, and what single pulls scatter beyond it, with those of the repeats (Welch and
    Satterthwaite).
    """
    (variance, dof), found, new = _law_spread(fit, model, conditions), fit.statistics, new_rope_std(fit)
    within = float(np.nan_to_num(found.scatter_within))
    # A product may be infinite; a power of a Python float raises.
    new2, pulls = new * new, within * within * (1.0 - found.n_conditions / found.n)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        shared = variance / np.sqrt(dof) + (new2 - pulls) / math.sqrt(degrees_of_freedom(fit))
        spread = shared**2 + pulls * pulls / max(found.n - found.n_conditions, 1)
        dof = np.where(spread > 0.0, (variance + new2) ** 2 / spread, np.inf)
    return np.asarray(_quantiles(probability, dof) * np.sqrt(variance + new2))


def averaged(own: Prediction, answers: Sequence[Prediction], weights: Sequence[float]) -> Prediction:
    """Return the weighted average of the answers of several laws; its intervals hold the spread between them.

    An end of an interval is a quantile of the mixture of the laws' Student distributions of ln F_A. A law whose own
    interval is not known enters with that of the first.
    """
    share = np.array(weights)[:, np.newaxis] / sum(weights)
    centre = np.stack([item.log_lift for item in answers])
    dof = np.stack([item.dof for item in answers])
    dof = np.where((dof > 0.0) & (dof < _MANY_DOF), dof, _MANY_DOF)
    reach = stdtrit(dof, 0.5 + 0.5 * own.level)

    def known(values: list[FloatArray]) -> FloatArray:
        table = np.stack(values)
        return np.asarray(np.where(np.isfinite(table) & (table > 0.0), table, table[0]))

    def ends_N(of: str) -> FloatArray:
        halves = [0.5 * np.diff(np.log(getattr(item, of)), axis=1)[:, 0] for item in answers]
        scale = known(halves) / reach
        ends = []
        for side in (0.5 - 0.5 * own.level, 0.5 + 0.5 * own.level):
            low, high = ((centre + sign * _FARTHEST * scale).T for sign in (-1.0, 1.0))
            low, high = low.min(axis=1), high.max(axis=1)
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                below = (share * stdtr(dof, (middle - centre) / scale)).sum(axis=0) < side
                low, high = np.where(below, middle, low), np.where(below, high, middle)
            ends.append(0.5 * (low + high))
        return np.asarray(np.exp(np.stack(ends, axis=1)))

    mean = (share * centre).sum(axis=0)
    variance = known([item.std_log for item in answers]) ** 2 + (centre - mean) ** 2
    std = np.sqrt((share * variance).sum(axis=0))
    with np.errstate(invalid="ignore"):
        return replace(
            own,
            log_lift=mean,
            std_log=std,
            lift_force_N=np.exp(mean),
            std_N=np.exp(mean) * std,
            interval_N=ends_N("interval_N"),
            prediction_interval_N=ends_N("prediction_interval_N"),
            linear_agrees=None,
            drawn_interval_N=None,
            averaged=tuple(item.law for item in answers),
        )


def degrees_of_freedom(fit: FitResult) -> float:
    """Return the degrees of freedom behind a fit's covariance; infinite where the standard deviations were known.

    Errors clustered by condition rest on the conditions, not on the trials.
    """
    dof = fit.statistics.interval_dof
    # A file has no infinity, so an infinite number of degrees of freedom comes back as NaN.
    return math.inf if math.isnan(dof) else max(dof, 1.0)


def new_rope_std(fit: FitResult) -> float:
    """Return the standard deviation of ln F_A of one new rope about the law [-]; NaN where the fit knows none.

    A new rope brings both scatters of the trials: that between conditions and that between repeats.
    """
    parts = [fit.statistics.scatter_within, fit.statistics.scatter_between]
    known = [part for part in parts if math.isfinite(part)]
    return math.hypot(*known) if known else math.nan


def _model(fit: FitResult, density: float | None, speed: float | None) -> LiftModel:
    if (density is None) != (speed is None):
        missing = "speed_m_s" if speed is None else "linear_density_kg_m"
        text = f"a running rope needs its mass per length and its speed; {missing} is missing"
        raise InputError(text, key=missing, fix="give both, or neither for a rope at rest")
    return LiftModel(law=fit.friction_law, linear_density_kg_m=density or 0.0, speed_m_s=speed or 0.0)


def parameter_draws(fit: FitResult, n: int, seed: int) -> FloatArray:
    """Return n draws of the parameters, shape (n, p), moved onto the law's bounds where they cross them.

    From the multivariate t of their covariance, the part of it that common errors make from the normal.
    """
    if not np.isfinite(fit.covariance).all():
        text = "the covariance of the parameters is not finite, so nothing can be drawn from it"
        fix = "use method='linear', or a fit whose parameters are all seen by the data"
        raise InputError(text, key="covariance", fix=fix)
    rng, known, theta, law = np.random.default_rng(seed), fit.common_changes, fit.theta, fit.friction_law
    root = symmetric_root(fit.covariance - known @ known.T)
    draws = joint_draws(theta, root, dof=degrees_of_freedom(fit), n=n, rng=rng)
    if known.size:
        draws = draws + rng.standard_normal((n, known.shape[1])) @ known.T
    return np.clip(draws, np.minimum(law.lower, theta), np.maximum(law.upper, theta))


def drawn_range(
    model: LiftModel, draws: FloatArray, conditions: Conditions, level: float
) -> tuple[FloatArray, FloatArray]:
    """Return half the central 68.27 % (c,) and the interval (c, 2) of ln F_A for c conditions, from n draws."""
    n, tail = len(draws), 50.0 * (1.0 - level)
    at = [tail, 100.0 - tail, 100.0 * (1.0 - _ONE_SIGMA), 100.0 * _ONE_SIGMA]
    found = np.empty((4, len(conditions)))
    step = max(1, _BLOCK // n)
    for first in range(0, len(conditions), step):
        rows = np.arange(first, min(first + step, len(conditions)))
        part = conditions.select(rows)
        usable = draws[model.law.admissible(draws, model.pressing(part))]
        if 2 * len(usable) < n:
            raise InputError(
                f"{model.law.name} has no answer for {n - len(usable)} of {n} parameter sets drawn from its "
                f"covariance at {part.describe(0)}",
                code="RF420",
                fix="the fit is too uncertain for this method; measure more conditions",
            )
        found[:, rows] = np.percentile(model.log_lift(usable, part), at, axis=0)
    return 0.5 * (found[3] - found[2]), found[:2].T.copy()


# ---- laws for others ----

_COUNTS = {"wheel_radius_m": 5, "rope_radius_m": 1, "wrap_angle_rad": 25, "end_tension_N": 5}
_MOST_ROWS = 10_000_000
_MOST_LOG = 700.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FrictionTable(Shown):
    """A law on a grid, and one constant instead of it.

    Attributes
    ----------
    law : str
        Its name.
    wheel_radius_m, rope_radius_m, wrap_angle_rad, end_tension_N : ndarray, shape (n,)
        The grid, the end tension running fastest.
    mu_average, mu_local : ndarray, shape (n,)
        μ̄ = ln(F_A/F_B)/φ of the whole wrap, and μ = d ln F/dφ where the wrap ends [-]; NaN where there is no answer.
    lift_force_N : ndarray, shape (n,)
        F_A of the mean law [N].
    extrapolated : ndarray of bool, shape (n,)
        Whether the point lies outside what was tested.
    constant_mu : float
        The constant whose largest relative error of F_A over the grid is smallest.
    constant_error : float
        That error [-].
    """

    _said = ("law", "lift_force_N", "mu_average", "constant_mu", "constant_error", "extrapolated")
    _framed = (*SETTINGS, "mu_average", "mu_local", "lift_force_N", "extrapolated")

    law: str
    wheel_radius_m: FloatArray
    rope_radius_m: FloatArray
    wrap_angle_rad: FloatArray
    end_tension_N: FloatArray
    mu_average: FloatArray
    mu_local: FloatArray
    lift_force_N: FloatArray
    extrapolated: BoolArray
    constant_mu: float
    constant_error: float


def friction_table(fit: FitResult, **levels: npt.ArrayLike | None) -> FrictionTable:
    """Return a law on the grid of levels of its four settings; of those not given, over what was tested."""
    axes = []
    for name in SETTINGS:
        low, high = fit.validity[name]
        given = levels.get(name)
        count = _COUNTS[name] if high > low else 1
        axes.append(np.ravel(np.linspace(low, high, count) if given is None else given))
    n = int(np.prod([axis.size for axis in axes]))
    if not 0 < n <= _MOST_ROWS:
        text = f"a table of {n} rows is empty or too long; {_MOST_ROWS} are the most"
        raise InputError(text, key="wrap_angle_rad", fix="ask for fewer levels")
    grid = dict(zip(SETTINGS, (one.ravel() for one in np.meshgrid(*axes, indexing="ij")), strict=True))
    at, law, theta = Conditions(**grid), fit.friction_law, fit.theta
    if (at.wrap_angle_rad == 0.0).any():
        text = "a wrap of zero has no coefficient"
        raise InputError(text, key="wrap_angle_rad", fix="begin above zero")
    good = law.answers(theta, at)
    if not good.any():
        raise InputError(
            f"{law.name} has no answer on this grid", key="wrap_angle_rad", fix=law.validity(theta, at)[0]
        )
    rise, local = np.full((2, n), np.nan)
    part = at.select(good)
    rise[good] = law.log_lift(theta, part) - part.log_end_tension
    local[good] = law.local_mu(theta, part.wrap_angle_rad, part)
    log_lift = rise + at.log_end_tension
    if np.nanmax(log_lift) > _MOST_LOG:
        text = f"ln F_A reaches {np.nanmax(log_lift):.4g}: the force overflows"
        raise InputError(text, code="RF420", key="wrap_angle_rad", fix="use fewer turns")
    mu, error = best_constant(rise[good], part.wrap_angle_rad)
    return FrictionTable(
        law=law.name, **grid, mu_average=rise / at.wrap_angle_rad, mu_local=local, lift_force_N=np.exp(log_lift),
        extrapolated=np.asarray(outside_range(fit.validity, at).any(axis=1)), constant_mu=mu, constant_error=error,
    )  # fmt: skip


def best_constant(rise: FloatArray, wrap_rad: FloatArray) -> tuple[float, float]:
    """Return the μ with the smallest largest |e^{μφ − ln(F_A/F_B)} − 1| over points, and that error.

    The most that it lifts too much grows with μ, the most that it lifts too little falls: the best is where they meet.
    """

    def off(mu: float) -> tuple[float, float]:
        change = np.expm1(np.clip(mu * wrap_rad - rise, -_MOST_LOG, _MOST_LOG))
        return float(change.max()), float(-change.min())

    low, high = float((rise / wrap_rad).min()), float((rise / wrap_rad).max())
    if high - low > 1e-15 * abs(high):
        low = float(brentq(lambda mu: off(mu)[0] - off(mu)[1], low, high, xtol=1e-15, rtol=1e-14))
    return low, max(off(low))


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
