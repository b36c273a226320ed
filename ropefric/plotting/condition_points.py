"""The measured conditions behind a fit, as points to draw a law against."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray, IntArray
from ropefric.errors import InputError
from ropefric.fitting.result import FitResult
from ropefric.friction.condition import Conditions, condition_groups, levels, same_setting

_SETTINGS = ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N")


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
    def log_rise(self) -> FloatArray:
        """Return ln(F_A/F_B), shape (k,)."""
        return self.log_lift - self.conditions.log_end_tension

    @property
    def mu(self) -> FloatArray:
        """Return the average coefficient μ̄ = ln(F_A/F_B)/φ, shape (k,); NaN at a wrap of zero."""
        return self._over_wrap(self.log_rise)

    @property
    def mu_std(self) -> FloatArray:
        """Return the standard uncertainty of μ̄, shape (k,)."""
        return self._over_wrap(self.std_log)

    def _over_wrap(self, values: FloatArray) -> FloatArray:
        wrap = self.conditions.wrap_angle_rad
        out = np.full(values.shape, np.nan)
        np.divide(values, wrap, out=out, where=wrap > 0.0)
        return out

    def reference(self, over: str) -> dict[str, float]:
        """Return the settings that most conditions share which differ in one regressor."""
        if not len(self):
            return {}
        others = [name for name in _SETTINGS if name != over]
        group = condition_groups(*(getattr(self.conditions, name) for name in others))
        along = levels(getattr(self.conditions, over))
        sizes = [np.unique(along[group == number]).size for number in range(int(group.max()) + 1)]
        first = int(np.argmax(group == int(np.argmax(sizes))))  # the first of equals
        return {name: float(getattr(self.conditions, name)[first]) for name in others}


def condition_points(fit: FitResult) -> ConditionPoints:
    """Return the conditions a fit rests on, from the summary that a stored fit carries too."""
    columns = {name: np.asarray(fit.trials.get(name, ()), dtype=np.float64) for name in _SETTINGS}
    n = np.asarray(fit.trials.get("n", ()), dtype=np.int64)
    log_lift = np.asarray(fit.trials.get("mean_log_lift", ()), dtype=np.float64)
    own = np.asarray(fit.trials.get("std_log_lift", ()), dtype=np.float64)
    instrument_N = np.asarray(fit.trials.get("peak_std_N", ()), dtype=np.float64)
    within = fit.statistics.scatter_within
    repeats = np.full(n.size, within) if math.isfinite(within) else own
    parts = np.stack([repeats / np.sqrt(n), instrument_N * np.exp(-log_lift)])
    std = np.where(np.isnan(parts).all(axis=0), np.nan, np.hypot(*np.nan_to_num(parts)))
    return ConditionPoints(conditions=Conditions(**columns), n=n, log_lift=log_lift, std_log=std)


def same_settings(conditions: Conditions, settings: Mapping[str, float]) -> BoolArray:
    """Return which conditions have the given settings, shape (n,)."""
    chosen = np.ones(len(conditions), dtype=np.bool_)
    for name, value in settings.items():
        chosen &= same_setting(getattr(conditions, name), value)
    return chosen


def settings_of(fit: FitResult, over: str, given: Mapping[str, float] | None) -> dict[str, float]:
    """Return the settings to hold while one regressor is swept."""
    for name in (over, *(given or ())):
        if name not in _SETTINGS:
            raise InputError(
                f"{name!r} is no setting of a pull", key=name, fix=f"one of {', '.join(_SETTINGS)}"
            )
    common = condition_points(fit).reference(over)
    middle = {name: math.sqrt(max(low, 0.0) * high) for name, (low, high) in fit.validity.items()}
    known = middle | common | dict(given or {})
    return {name: known[name] for name in _SETTINGS if name != over}


def swept(settings: Mapping[str, float], over: str, values: npt.ArrayLike) -> Conditions:
    """Return conditions that differ in one regressor only."""
    arrays = {name: np.float64(value) for name, value in settings.items() if name != over}
    return Conditions(**(arrays | {over: np.asarray(values, dtype=np.float64)}))  # type: ignore[arg-type]


def answered(fit: FitResult, conditions: Conditions) -> BoolArray:
    """Return for which conditions a fitted law has an answer that a float can hold, shape (n,)."""
    law, theta = fit.friction_law, fit.theta
    largest = math.log(np.finfo(np.float64).max)

    def holds(part: Conditions) -> BoolArray:
        try:
            return np.asarray(law.log_lift(theta, part) < largest)
        except InputError:
            if len(part) == 1:
                return np.zeros(1, dtype=np.bool_)
            half = len(part) // 2
            sides = (part.select(np.arange(half)), part.select(np.arange(half, len(part))))
            return np.concatenate([holds(side) for side in sides])

    return holds(conditions) if len(conditions) else np.zeros(0, dtype=np.bool_)
