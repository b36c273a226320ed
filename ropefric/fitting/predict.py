"""From a fitted law to the lift force of a wheel, with the interval of the law and that of one new rope."""

import math
from typing import Any

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.fitting.extrapolation import outside_range
from ropefric.fitting.prediction import Method, Prediction
from ropefric.fitting.propagation import drawn_range, linear_std
from ropefric.fitting.result import FitResult
from ropefric.friction.condition import Conditions
from ropefric.friction.law import LiftModel
from ropefric.friction.laws import ALL_LAWS
from ropefric.uncertainty.quantity import quantile

_LARGEST = math.log(np.finfo(np.float64).max)
_DISAGREEMENT = 0.1
# The check of the linear interval by draws is made unasked only where it is quick.
_CHECKED_CONDITIONS = 100
_MOST_DRAWS = 10_000_000
_CHECKING_DRAWS = 2000


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
    if not 0.0 < level < 1.0:
        raise InputError(
            f"the level is {level:g}", key="level", fix="give a level between 0 and 1, such as 0.95"
        )
    if method not in {"linear", "monte-carlo"}:
        raise InputError(f"unknown method {method!r}", key="method", fix="use 'linear' or 'monte-carlo'")
    if not 100 <= n <= _MOST_DRAWS:
        few = "few" if n < 100 else "many"
        raise InputError(f"{n} draws are too {few}", key="n", fix=f"draw 100 to {_MOST_DRAWS}")
    theta, covariance = np.asarray(fit.theta), np.asarray(fit.covariance)
    log_lift = model.log_lift(theta, conditions)
    if (log_lift > _LARGEST).any():
        worst = int(np.argmax(log_lift))
        raise InputError(
            f"ln F_A = {log_lift[worst]:.6g} at {conditions.describe(worst)}: the force overflows",
            code="RF420",
            fix="use a smaller wrap; in Python, law.log_lift stays finite",
        )
    dof = 0.0 if fit.statistics.interval_dof == 0.0 else degrees_of_freedom(fit)
    std = linear_std(model, theta, covariance, conditions)
    if dof == 0.0:
        std = np.full_like(std, math.nan)  # nothing is left over that could tell the scatter
    reach = quantile(0.5 + 0.5 * level, dof) if dof > 0.0 else math.nan
    ends = np.stack([log_lift - reach * std, log_lift + reach * std], axis=1)
    if check is None:
        check = len(conditions) <= _CHECKED_CONDITIONS
    check = check and dof > 0.0 and bool(np.isfinite(covariance).all())
    agrees, draws, drawn = None, 0, None
    if (method == "monte-carlo" and dof > 0.0) or check:
        draws = n if method == "monte-carlo" else _CHECKING_DRAWS
        rng = np.random.default_rng(seed)
        drawn = _drawn(
            model, fit, conditions, dof=dof, level=level, n=draws, rng=rng, needed=method != "linear"
        )
        if drawn is None:
            agrees = np.zeros(len(conditions), dtype=np.bool_)
        else:
            agrees = _ends_agree(ends, drawn[1], draws)
            std, ends = drawn if method == "monte-carlo" else (std, ends)
    # About the middle of the law's own interval, which is not quite log_lift where draws are skew.
    middle, half = ends.mean(axis=1), 0.5 * np.diff(ends, axis=1)[:, 0]
    wide = np.hypot(half, reach * new_rope_std(fit))
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
            drawn_interval_N=None if drawn is None else np.exp(drawn[1]),
            outside=outside_range(fit.validity, conditions),
            validity=fit.validity,
            draws=draws,
            seed=seed,
            judged=fit.verdict,
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
        raise InputError(
            f"a running rope needs its mass per length and its speed; {missing} is missing",
            key=missing,
            fix="give both, or neither for a rope at rest",
        )
    return LiftModel(law=ALL_LAWS[fit.law], linear_density_kg_m=density or 0.0, speed_m_s=speed or 0.0)


def _drawn(
    model: LiftModel, fit: FitResult, conditions: Conditions, *, needed: bool, **options: Any
) -> tuple[FloatArray, FloatArray] | None:
    """Return the range of the draws; None where they fail and only served as a check."""
    try:
        return drawn_range(model, np.asarray(fit.theta), np.asarray(fit.covariance), conditions, **options)
    except InputError:
        if needed:
            raise
        return None


def _ends_agree(linear: FloatArray, drawn: FloatArray, draws: int) -> BoolArray:
    """Return where both ends agree within 10 % of the half width, with room for the noise of few draws."""
    half = 0.5 * np.diff(linear, axis=1)
    # The 97.5 % point of N draws scatters by about 2.7 σ/√N; three times that is no disagreement.
    room = _DISAGREEMENT + 3.0 * 2.7 / 1.96 / math.sqrt(draws)
    return np.asarray((np.abs(drawn - linear) <= room * half + 1e-12).all(axis=1))
