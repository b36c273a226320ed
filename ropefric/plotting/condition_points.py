"""The measured conditions behind a fit, as points to draw a law against."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ropefric.errors import InputError
from ropefric.fitting.result import FitResult
from ropefric.friction.condition import Conditions, FloatArray, condition_groups, levels, same_setting

__all__ = ["ConditionPoints", "answered", "condition_points", "same_settings", "settings_of", "swept"]

_SETTINGS = ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ConditionPoints:
    """One point a condition.

    Attributes
    ----------
    conditions : Conditions
        The k conditions.
    n : ndarray of int, shape (k,)
        Trials behind each.
    log_lift : ndarray, shape (k,)
        Mean of ln(F_A / 1 N).
    std_log : ndarray, shape (k,)
        Standard uncertainty of that mean [-]: the scatter of the repeats over √n, and the instrument, which repeats
        do not average out; NaN where neither is known.
    """

    conditions: Conditions
    n: npt.NDArray[np.int64]
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
        """Return the settings that most conditions share which differ in one regressor.

        Parameters
        ----------
        over : str
            That regressor.

        Returns
        -------
        dict of str to float
            The other settings, SI; of equals, the first in the order of the data. Empty without points.
        """
        if not len(self):
            return {}
        others = [name for name in _SETTINGS if name != over]
        group = condition_groups(*(getattr(self.conditions, name) for name in others))
        along = levels(getattr(self.conditions, over))
        sizes = [np.unique(along[group == number]).size for number in range(int(group.max()) + 1)]
        first = int(np.argmax(group == int(np.argmax(sizes))))  # the first of equals
        return {name: float(getattr(self.conditions, name)[first]) for name in others}


def condition_points(fit: FitResult) -> ConditionPoints:
    """Return the conditions a fit rests on, from the summary that a stored fit carries too.

    Parameters
    ----------
    fit : FitResult
        Just made or loaded.

    Examples
    --------
    >>> from ropefric.fitting.fit import fit_law
    >>> from ropefric.fitting.table import TrialTable
    >>> table = TrialTable(
    ...     trial=tuple("abcd"), wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=[3.0, 3.0, 6.0, 6.0],
    ...     end_tension_N=20, peak_N=[36.0, 36.8, 66.0, 66.7],
    ... )
    >>> points = condition_points(fit_law(table, "constant"))
    >>> points.n.tolist(), points.mu.round(3).tolist()
    ([2, 2], [0.2, 0.2])
    """
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


def same_settings(conditions: Conditions, settings: Mapping[str, float]) -> npt.NDArray[np.bool_]:
    """Return which conditions have the given settings, shape (n,).

    Examples
    --------
    >>> pulls = Conditions(
    ...     wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=[3.0, 6.0], end_tension_N=20
    ... )
    >>> same_settings(pulls, {"wrap_angle_rad": 6.0}).tolist()
    [False, True]
    """
    chosen = np.ones(len(conditions), dtype=np.bool_)
    for name, value in settings.items():
        chosen &= same_setting(getattr(conditions, name), value)
    return chosen


def settings_of(fit: FitResult, over: str, given: Mapping[str, float] | None) -> dict[str, float]:
    """Return the settings to hold while one regressor is swept.

    Parameters
    ----------
    fit : FitResult
        The fit; its most common settings are taken, or the middle of what was tested where it has no trials.
    over : str
        The regressor swept.
    given : mapping of str to float, optional
        Settings that go before [SI].

    Raises
    ------
    InputError
        If `over` is no regressor, or a setting is none.
    """
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
    """Return conditions that differ in one regressor only.

    Examples
    --------
    >>> at = {"wheel_radius_m": 0.04, "rope_radius_m": 0.005, "end_tension_N": 20.0}
    >>> len(swept(at, "wrap_angle_rad", [1.0, 2.0]))
    2
    """
    arrays = {name: np.float64(value) for name, value in settings.items() if name != over}
    return Conditions(**(arrays | {over: np.asarray(values, dtype=np.float64)}))  # type: ignore[arg-type]


def answered(fit: FitResult, conditions: Conditions) -> npt.NDArray[np.bool_]:
    """Return for which conditions a fitted law has an answer that a float can hold, shape (n,).

    Examples
    --------
    >>> from ropefric.fitting.fit import fit_law
    >>> from ropefric.fitting.table import TrialTable
    >>> table = TrialTable(
    ...     trial=("a", "b"), wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=[3.0, 6.0],
    ...     end_tension_N=20, peak_N=[36.0, 66.0],
    ... )
    >>> pulls = swept({"wheel_radius_m": 0.04, "rope_radius_m": 0.005, "end_tension_N": 20}, "wrap_angle_rad",
    ...               [3.0, 1e5])
    >>> answered(fit_law(table, "constant"), pulls).tolist()
    [True, False]
    """
    law, theta = fit.friction_law, fit.theta
    largest = math.log(np.finfo(np.float64).max)

    def holds(part: Conditions) -> npt.NDArray[np.bool_]:
        try:
            return np.asarray(law.log_lift(theta, part) < largest)
        except InputError:
            if len(part) == 1:
                return np.zeros(1, dtype=np.bool_)
            half = len(part) // 2
            sides = (part.select(np.arange(half)), part.select(np.arange(half, len(part))))
            return np.concatenate([holds(side) for side in sides])

    return holds(conditions) if len(conditions) else np.zeros(0, dtype=np.bool_)
