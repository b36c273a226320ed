"""The measured conditions behind a fit, as points to draw a law against, and the settings to draw it for."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray, IntArray
from ropefric.errors import InputError
from ropefric.fitting.result import FitResult
from ropefric.friction.condition import Conditions, condition_groups, levels, same_setting

SETTINGS = ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ConditionPoints:
    """One point a condition."""

    conditions: Conditions
    n: IntArray
    log_lift: FloatArray
    std_log: FloatArray

    def __len__(self) -> int:
        return self.log_lift.size

    @property
    def settings(self) -> dict[str, FloatArray]:
        """Return the settings as columns of a table, and how many trials rest on each."""
        return {name: getattr(self.conditions, name) for name in SETTINGS} | {"n": self.n}

    @property
    def log_rise(self) -> FloatArray:
        """Return ln(F_A/F_B), shape (k,)."""
        return self.log_lift - self.conditions.log_end_tension

    def over_wrap(self, values: FloatArray) -> FloatArray:
        """Return values over the wrap, shape (k,), as μ̄ = ln(F_A/F_B)/φ; NaN at a wrap of zero."""
        wrap = self.conditions.wrap_angle_rad
        return np.asarray(np.divide(values, wrap, out=np.full(values.shape, np.nan), where=wrap > 0.0))


def condition_points(fit: FitResult) -> ConditionPoints:
    """Return the conditions a fit rests on, from the summary that a stored fit carries too."""

    def column(name: str) -> FloatArray:
        return np.asarray(fit.trials.get(name, ()), dtype=np.float64)

    n, log_lift = column("n").astype(np.int64), column("mean_log_lift")
    within = fit.statistics.scatter_within
    repeats = np.full(n.size, within) if math.isfinite(within) else column("std_log_lift")
    parts = np.stack([repeats / np.sqrt(n), column("peak_std_N") * np.exp(-log_lift)])
    std = np.where(np.isnan(parts).all(axis=0), np.nan, np.hypot(*np.nan_to_num(parts)))
    conditions = Conditions(**{name: column(name) for name in SETTINGS})
    return ConditionPoints(conditions=conditions, n=n, log_lift=log_lift, std_log=std)


def same_settings(conditions: Conditions, settings: Mapping[str, float]) -> BoolArray:
    """Return which conditions have the given settings, shape (n,)."""
    chosen = np.ones(len(conditions), dtype=np.bool_)
    for name, value in settings.items():
        chosen &= same_setting(getattr(conditions, name), value)
    return chosen


def settings_of(fit: FitResult, over: str, given: Mapping[str, float] | None = None) -> dict[str, float]:
    """Return the settings to hold while one regressor is swept: those given, else those that most conditions share."""
    for name in (over, *(given or ())):
        if name not in SETTINGS:
            raise InputError(
                f"{name!r} is no setting of a pull", key=name, fix=f"one of {', '.join(SETTINGS)}"
            )
    others = [name for name in SETTINGS if name != over]
    known = {name: math.sqrt(max(low, 0.0) * high) for name, (low, high) in fit.validity.items()}
    points = condition_points(fit)
    if len(points):
        held = [getattr(points.conditions, name) for name in others]
        group, along = condition_groups(*held), levels(getattr(points.conditions, over))
        sizes = [np.unique(along[group == number]).size for number in range(int(group.max()) + 1)]
        first = int(np.argmax(group == int(np.argmax(sizes))))  # the first of equals
        known |= {name: float(values[first]) for name, values in zip(others, held, strict=True)}
    known |= dict(given or {})
    return {name: known[name] for name in others}


def swept(settings: Mapping[str, float], over: str, values: npt.ArrayLike) -> Conditions:
    """Return conditions that differ in one regressor only."""
    arrays = {name: np.float64(value) for name, value in settings.items() if name != over}
    return Conditions(**(arrays | {over: np.asarray(values, dtype=np.float64)}))  # type: ignore[arg-type]


def answered(fit: FitResult, conditions: Conditions) -> BoolArray:
    """Return for which conditions a fitted law has an answer that a float can hold, shape (n,)."""
    if not len(conditions):
        return np.zeros(0, dtype=np.bool_)
    try:
        lifts = fit.friction_law.log_lift(fit.theta, conditions)
        return np.asarray(lifts < math.log(np.finfo(np.float64).max))
    except InputError:
        if len(conditions) == 1:
            return np.zeros(1, dtype=np.bool_)
        halves = np.array_split(np.arange(len(conditions)), 2)
        return np.concatenate([answered(fit, conditions.select(half)) for half in halves])
