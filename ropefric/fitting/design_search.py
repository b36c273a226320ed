"""How a design is found: the mean law by Newton's method, then the first place where its lower bound suffices."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.fitting.design_result import QUANTITIES, DesignStatus, SolveFor
from ropefric.fitting.predict import degrees_of_freedom, new_rope_std
from ropefric.fitting.propagation import linear_std
from ropefric.fitting.result import FitResult
from ropefric.fitting.rising_root import first_crossing, rising_root
from ropefric.friction.condition import Conditions
from ropefric.friction.law import FrictionLaw, LiftModel
from ropefric.friction.laws import ALL_LAWS
from ropefric.uncertainty.quantity import quantile

LIMITS: dict[str, tuple[float, float]] = {
    "wrap": (0.0, 40.0 * math.pi),
    "radius": (1e-3, 10.0),
    "end_tension": (1.0, 1e5),
}
"""Where each quantity is looked for unless told otherwise: rad, m, N."""

CHUNK = 16384
"""Designs worked on at a time: their temporaries stay in the processor's cache."""

_COLUMN = {"radius": 0, "wrap": 1, "end_tension": 2}
# A wrap of zero has no slope in some laws; this much wrap lifts nothing.
_LEAST_WRAP_RAD = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LiftBound:
    """ln F_A of a fitted law and what one new rope exceeds with a probability."""

    law: FrictionLaw
    theta: FloatArray
    covariance: FloatArray
    reach: float
    scatter: float

    @classmethod
    def of(cls, fit: FitResult, probability: float | None) -> "LiftBound":
        """Return the bound of a fit."""
        reach, scatter = 0.0, 0.0
        if probability is not None:
            if not 0.5 <= probability < 1.0:
                raise InputError(
                    f"the probability is {probability:g}",
                    key="probability",
                    fix="give 0.5 or more and less than 1; or take the mean law (--on-average, None in Python)",
                )
            reach, scatter = quantile(probability, degrees_of_freedom(fit)), new_rope_std(fit)
            if not (math.isfinite(scatter) and np.isfinite(fit.covariance).all()):
                raise InputError(
                    f"the fit of {fit.law} knows no scatter, or no finite errors, so it gives no probability",
                    key="probability",
                    fix="repeat some trials and fit again, or design for the mean law (--on-average, None in Python)",
                )
        return cls(
            law=ALL_LAWS[fit.law],
            theta=np.asarray(fit.theta),
            covariance=np.asarray(fit.covariance),
            reach=reach,
            scatter=scatter,
        )

    def evaluate(self, conditions: Conditions) -> tuple[FloatArray, FloatArray]:
        """Return ln F_A of the mean law and of the bound, shape (n,); NaN where the law has no answer."""
        eta, bound = np.full((2, len(conditions)), np.nan)
        rows = np.flatnonzero(self.answered(conditions))
        if rows.size:
            chosen = conditions if rows.size == len(conditions) else conditions.select(rows)
            eta[rows] = self.law.log_lift(self.theta, chosen)
            bound[rows] = eta[rows] - self.margin(chosen)
        return eta, bound

    def margin(self, conditions: Conditions) -> FloatArray:
        """Return by how much the bound lies below the mean in ln F_A, shape (n,)."""
        if self.reach == 0.0:
            return np.zeros(len(conditions))
        std = linear_std(LiftModel(law=self.law), self.theta, self.covariance, conditions)
        return self.reach * np.hypot(std, self.scatter)

    def answered(self, conditions: Conditions) -> BoolArray:
        """Return where the law has an answer, shape (n,)."""
        return self.law.answers(self.theta, conditions)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DesignSearch:
    """n designs to find; use `checked`."""

    bound: LiftBound
    solve_for: SolveFor
    limits: tuple[float, float]
    given: Mapping[str, FloatArray]
    log_load: FloatArray

    @classmethod
    def checked(
        cls,
        fit: FitResult,
        solve_for: SolveFor,
        probability: float | None,
        limits: tuple[float, float] | None,
        **quantities: npt.ArrayLike | None,
    ) -> "DesignSearch":
        """Return the search for quantities as `ropefric.fitting.design.design` takes them."""
        if solve_for not in QUANTITIES:
            raise InputError(
                f"cannot solve for {solve_for!r}", key="solve_for", fix=f"use one of {', '.join(QUANTITIES)}"
            )
        target, unit = QUANTITIES[solve_for]
        if quantities.pop(target) is not None:
            raise InputError(f"{target} is given and looked for", key=target, fix="leave it out")
        for name, value in quantities.items():
            if value is None:
                raise InputError(
                    f"{name} is missing", key=name, fix="give every quantity but the one looked for"
                )
        law = ALL_LAWS[fit.law]
        if solve_for == "radius" and "size" not in law.effects:
            raise InputError(
                f"the lift of law {law.name} does not depend on the wheel radius, so no radius can be found",
                key="solve_for",
                fix="solve for the wrap or the end tension, or fit a law with a size effect",
            )
        low, high = LIMITS[solve_for] if limits is None else limits
        if not (math.isfinite(high) and high > low and (low > 0.0 or (low == 0.0 and solve_for == "wrap"))):
            raise InputError(
                f"limits {low:g} to {high:g} {unit} are none", key="limits", fix="give 0 < low < high in SI"
            )
        arrays = _spread({name: value for name, value in quantities.items() if value is not None})
        load = arrays.pop("lift_N")
        # Every quantity is looked at here, so that no search meets a bad one.
        Conditions(**arrays, **{target: np.array(high)})
        if load.size and not (np.isfinite(load) & (load > 0.0)).all():
            worst = int(np.argmin(np.where(np.isfinite(load), load, -np.inf)))
            raise InputError(
                f"lift_N[{worst}] is {load[worst]:g} N; it must be finite and positive", key="lift_N"
            )
        return cls(
            bound=LiftBound.of(fit, probability),
            solve_for=solve_for,
            limits=(float(low), float(high)),
            given=arrays,
            log_load=np.log(load),
        )

    def solve(self, part: slice) -> tuple[npt.NDArray[Any], ...]:
        """Return value, status, ln F_A, ln bound, and both at the upper limit, for some of the designs."""
        load = self.log_load[part]
        n, (low, high) = load.size, (self._inside(limit) for limit in self.limits)
        everything = np.arange(n)
        eta, bound = np.full((2, n), np.nan)
        x, status = np.full(n, np.nan), np.full(n, DesignStatus.OK, dtype=np.int8)

        def mean(at: FloatArray, rows: npt.NDArray[np.intp]) -> tuple[FloatArray, FloatArray]:
            return self._rise(part, at, rows, load, bounded=False)

        def bounded(at: FloatArray, rows: npt.NDArray[np.intp]) -> tuple[FloatArray, FloatArray]:
            return self._rise(part, at, rows, load, bounded=True)

        lows, highs = np.full(n, low), np.full(n, high)
        enough = bounded(lows, everything)[0] >= 0.0
        x[enough], status[enough] = low, DesignStatus.LOWER_LIMIT
        top_value = mean(highs, everything)[0]
        status[~enough & (top_value < 0.0)] = DesignStatus.OUT_OF_REACH
        rows = np.flatnonzero(status == DesignStatus.OK)
        if rows.size:
            below = mean(lows[rows], rows)[0] < 0.0
            root = lows[rows]
            some = rows[below]
            root[below] = rising_root(lambda at, i: mean(at, some[i]), lows[some], highs[some])
            if self.bound.reach > 0.0:
                left, right = first_crossing(lambda at, i: bounded(at, rows[i]), root, highs[rows])
                status[rows[np.isnan(right)]] = DesignStatus.TOO_UNCERTAIN
                held = ~np.isnan(right)
                rows, left, right = rows[held], left[held], right[held]
                root = rising_root(lambda at, i: bounded(at, rows[i]), left, right, start=left)
            x[rows] = root
        lost = status > DesignStatus.LOWER_LIMIT
        at_limit, bound_at_limit = np.full((2, n), np.nan)
        if lost.any():
            at_limit[lost], bound_at_limit[lost] = self.bound.evaluate(self._conditions(part, highs, lost))
        if not lost.all():
            eta[~lost], bound[~lost] = self.bound.evaluate(self._conditions(part, x, ~lost))
        return self._outside(x), status, eta, bound, at_limit, bound_at_limit

    def _inside(self, value: float) -> float:
        if self.solve_for == "wrap":
            return max(value, _LEAST_WRAP_RAD)
        return math.log(value)

    def _outside(self, x: FloatArray) -> FloatArray:
        if self.solve_for == "wrap":
            return np.where(x <= _LEAST_WRAP_RAD, self.limits[0], x)
        return np.exp(x)

    def _conditions(self, part: slice, x: FloatArray, rows: npt.NDArray[np.generic]) -> Conditions:
        named = {name: values[part][rows] for name, values in self.given.items()}
        named[QUANTITIES[self.solve_for][0]] = self._outside(
            x[rows] if x.size == self.log_load[part].size else x
        )
        return Conditions(**named)

    def _rise(
        self, part: slice, at: FloatArray, rows: npt.NDArray[np.intp], load: FloatArray, *, bounded: bool
    ) -> tuple[FloatArray, FloatArray]:
        """Return how far above the load ln F_A is and its slope; −inf where the law has no answer."""
        named = {name: values[part][rows] for name, values in self.given.items()}
        named[QUANTITIES[self.solve_for][0]] = at if self.solve_for == "wrap" else np.exp(at)
        conditions = Conditions(**named)
        value, slope = np.full(rows.size, -np.inf), np.full(rows.size, np.nan)
        good = np.flatnonzero(self.bound.answered(conditions))
        if good.size:
            chosen = conditions if good.size == rows.size else conditions.select(good)
            value[good] = self.bound.law.log_lift(self.bound.theta, chosen) - load[rows[good]]
            if bounded:
                value[good] -= self.bound.margin(chosen)
            gradient = self.bound.law.log_lift_gradient_conditions(self.bound.theta, chosen)
            column = gradient[:, _COLUMN[self.solve_for]]
            slope[good] = column * chosen.wheel_radius_m if self.solve_for == "radius" else column
        return value, slope


def _spread(quantities: Mapping[str, npt.ArrayLike]) -> dict[str, FloatArray]:
    arrays = {}
    for name, value in quantities.items():
        try:
            arrays[name] = np.atleast_1d(np.asarray(value, dtype=np.float64))
        except (TypeError, ValueError):
            raise InputError(
                f"{name} is not a number or a list of numbers", key=name, fix="give SI numbers"
            ) from None
    try:
        shape = np.broadcast_shapes(*(array.shape for array in arrays.values()))
    except ValueError:
        lengths = ", ".join(f"{name} has {array.size}" for name, array in arrays.items())
        raise InputError(
            f"the designs disagree in length: {lengths}", fix="give one value each, or one for all"
        ) from None
    return {name: np.broadcast_to(array, shape) for name, array in arrays.items()}
