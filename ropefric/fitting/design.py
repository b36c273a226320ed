"""The inverse of a prediction: the smallest wrap, wheel or end tension that lifts a load with a given probability.

In: a fit and the load. Out: a `Design` with what was found, or why there is none; `design_chart` gives the lift forces
over wheels and wraps. The mean law is solved in brackets, then the first place is found where its lower bound
suffices.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from functools import partial
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.files.plain_text import rounded_tree
from ropefric.fitting.intervals import Rising, rising_root
from ropefric.fitting.predict import Method, lift_ends, outside_range
from ropefric.fitting.problem import Rows
from ropefric.fitting.result import FitResult
from ropefric.friction.condition import SETTINGS, Conditions, as_floats, same_length
from ropefric.friction.law import LiftModel
from ropefric.shown import Shown

SolveFor = Literal["wrap", "radius", "end_tension"]

QUANTITIES: dict[str, tuple[str, str, tuple[float, float]]] = {
    "radius": ("wheel_radius_m", "m", (1e-3, 10.0)),
    "wrap": ("wrap_angle_rad", "rad", (0.0, 40.0 * math.pi)),
    "end_tension": ("end_tension_N", "N", (1.0, 1e5)),
}
"""Name and unit of each quantity that a design can look for, and its range of search."""

_FORCES = ("required_N", "lift_force_N", "lower_bound_N")
# A wrap of zero has no slope in some laws; this much wrap lifts nothing.
_LEAST_WRAP_RAD = 1e-9
_SCAN = 24
# Searches until the distance of the profile from the linear bound stays the same, in ln F_A.
_ROUNDS, _SETTLED = 10, 1e-7
_MEAN_LAW = "the mean law (--on-average, None in Python)"


class DesignStatus(IntEnum):
    """Outcome of a design."""

    OK = 0
    LOWER_LIMIT = 1
    OUT_OF_REACH = 2
    TOO_UNCERTAIN = 3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Design(Shown):
    """Designs that lift a load; NaN where there is none.

    Attributes
    ----------
    solve_for : {"wrap", "radius", "end_tension"}
        What was looked for.
    value : ndarray, shape (n,)
        The smallest that does: φ [rad], R_w [m] or F_B [N].
    wheel_radius_m, rope_radius_m, wrap_angle_rad, end_tension_N : ndarray, shape (n,)
        The designs, `value` among them.
    required_N : ndarray, shape (n,)
        The load to lift [N].
    lift_force_N, lower_bound_N : ndarray, shape (n,)
        F_A of the mean law, and what one new rope exceeds with the probability [N].
    probability : float or None
        Probability that a new rope lifts the load; None: the mean law does.
    status : ndarray of int8, shape (n,)
        `DesignStatus`: OK; LOWER_LIMIT, the lower limit already does; OUT_OF_REACH, not even the upper limit does
        on average; TOO_UNCERTAIN, it does on average, but nowhere up to the limit with the probability.
    limits : tuple of float
        Where it was looked for.
    limit_lift_N, limit_bound_N : ndarray, shape (n,)
        F_A and lower bound at the upper limit, for those without a design [N].
    extrapolated : ndarray of bool, shape (n,)
        Whether the design lies outside what was tested.
    """

    _said = ("solve_for", "value", *_FORCES, "probability", "extrapolated")
    _framed = (*SETTINGS, *_FORCES, "reached", "extrapolated")

    solve_for: SolveFor
    value: FloatArray
    wheel_radius_m: FloatArray
    rope_radius_m: FloatArray
    wrap_angle_rad: FloatArray
    end_tension_N: FloatArray
    required_N: FloatArray
    lift_force_N: FloatArray
    lower_bound_N: FloatArray
    probability: float | None
    status: npt.NDArray[np.int8]
    limits: tuple[float, float]
    limit_lift_N: FloatArray
    limit_bound_N: FloatArray
    extrapolated: BoolArray

    def __len__(self) -> int:
        return self.value.size

    @property
    def reached(self) -> BoolArray:
        """Return which designs exist, shape (n,)."""
        return self.status <= DesignStatus.LOWER_LIMIT

    def explain(self, index: int = 0) -> str:
        """Return in words what became of one design."""
        name, unit, _limits = QUANTITIES[self.solve_for]
        need, high = f"{self.required_N[index]:.6g} N", f"{name} = {self.limits[1]:.6g} {unit}"
        code = DesignStatus(int(self.status[index]))
        if code is DesignStatus.OUT_OF_REACH:
            return (
                f"out of reach: even {high} lifts {self.limit_lift_N[index]:.6g} N on average, less than {need}; "
                "change another quantity"
            )
        if code is DesignStatus.TOO_UNCERTAIN:
            return (
                f"too uncertain: nothing up to {high} lifts {need} with a probability of {self.probability:g}; there "
                f"the mean is {self.limit_lift_N[index]:.6g} N and the bound {self.limit_bound_N[index]:.6g} N; "
                "measure nearer to the design, or accept a lower probability"
            )
        found = f"{name} = {self.value[index]:.6g} {unit}"
        if code is DesignStatus.LOWER_LIMIT:
            return f"the lower limit {found} already lifts {need}"
        surely = "" if self.probability is None else f" with probability {self.probability:g}"
        return f"{found} lifts {need}{surely}"

    def to_dict(self) -> dict[str, Any]:
        """Return a JSON tree: one object for one design, `{"designs": [...]}` for several."""
        rows = [self._row(i) for i in range(len(self))]
        return rows[0] if len(rows) == 1 else {"designs": rows}

    def _row(self, i: int) -> dict[str, Any]:
        names = (*SETTINGS, *_FORCES, "limit_lift_N", "limit_bound_N", "extrapolated")
        tree = {name: getattr(self, name)[i] for name in names} | {
            "solve_for": self.solve_for,
            "probability": self.probability,
            "status": DesignStatus(int(self.status[i])).name.lower().replace("_", "-"),
            "explanation": self.explain(i),
            "limits": self.limits,
        }
        return dict(rounded_tree(tree, None))


def _check_probability(fit: FitResult, probability: float | None) -> None:
    """Refuse a probability that is none, or that a fit cannot give."""
    if probability is None:
        return
    if not 0.5 <= probability < 1.0:
        text = f"the probability is {probability:g}"
        fix = f"give 0.5 or more and less than 1; or take {_MEAN_LAW}"
        raise InputError(text, key="probability", fix=fix)
    if not (fit.scatter.of_pulls and np.isfinite(fit.covariance).all()):
        text = f"the fit of {fit.law} knows no scatter, or no finite errors, so it gives no probability"
        fix = f"repeat some trials and fit again, or design for {_MEAN_LAW}"
        raise InputError(text, key="probability", fix=fix)


def _mean(fit: FitResult, conditions: Conditions) -> FloatArray:
    """Return ln F_A of the mean law, shape (n,); NaN where the law has no answer."""
    return fit.friction_law.log_lift_of_pairs(np.tile(fit.theta, (len(conditions), 1)), conditions)


def _bound(
    fit: FitResult, probability: float | None, conditions: Conditions, method: Method = "auto"
) -> FloatArray:
    """Return the ln F_A that one new rope exceeds, shape (n,), for None that of the mean law; NaN likewise."""
    found = _mean(fit, conditions)
    some = np.flatnonzero(~np.isnan(found))
    if probability is not None and some.size:
        model = LiftModel(law=fit.friction_law)
        found[some] = lift_ends(fit, model, conditions.select(some), probability, method).pull[:, 0]
    return found


def design(
    fit: FitResult,
    *,
    lift_N: npt.ArrayLike,
    rope_radius_m: npt.ArrayLike,
    wheel_radius_m: npt.ArrayLike | None = None,
    wrap_angle_rad: npt.ArrayLike | None = None,
    end_tension_N: npt.ArrayLike | None = None,
    solve_for: SolveFor = "wrap",
    probability: float | None = 0.95,
) -> Design:
    """Return the smallest wrap, wheel radius or end tension that lifts a load, for n designs at once.

    ln F_A rises with each of the three, so the mean law has one crossing, found in brackets by Chandrupatla's method.
    The bound may fall again where extrapolation widens it; the first crossing above that of the mean is taken. It is
    the lower end of `predict`'s interval of one pull, along the profile for curved laws and 100 designs at most: the
    linear bound is searched, and corrected by how far the profile lies from it at what was found.
    """
    given, load_N, (low, high) = _checked(
        fit, solve_for,
        lift_N=lift_N, rope_radius_m=rope_radius_m, wheel_radius_m=wheel_radius_m, wrap_angle_rad=wrap_angle_rad,
        end_tension_N=end_tension_N,
    )  # fmt: skip
    _check_probability(fit, probability)
    # The search moves in the wrap itself, and in the logarithm of a radius or an end tension.
    n, target, wrap = load_N.size, QUANTITIES[solve_for][0], solve_for == "wrap"
    lows, highs = (np.full(n, max(end, _LEAST_WRAP_RAD) if wrap else math.log(end)) for end in (low, high))

    def above(log_force: Callable[[Conditions], FloatArray], needed: FloatArray) -> Rising:
        """Return how far above what designs need ln F is; −inf where the law has no answer."""

        def function(x: FloatArray, rows: Rows) -> FloatArray:
            tried = {name: values[rows] for name, values in given.items()}
            tried[target] = x if wrap else np.exp(x)
            return np.asarray(np.nan_to_num(log_force(Conditions(**tried)) - needed[rows], nan=-np.inf))

        return function

    log_load, linear = np.log(load_N), partial(_bound, fit, probability, method="linear")
    by_mean, mean_root, everything = above(partial(_mean, fit), log_load), lows.copy(), np.arange(n)
    in_reach = by_mean(highs, everything) >= 0.0
    below = np.flatnonzero(in_reach & (by_mean(lows, everything) < 0.0))
    mean_root[below] = rising_root(_of(by_mean, below), lows[below], highs[below])
    beyond_linear = np.zeros(n)
    for _ in range(_ROUNDS):
        by_bound = above(linear, log_load - beyond_linear)
        found, status = _first_enough(by_bound, in_reach, lows, mean_root, highs)
        x = np.where(found <= _LEAST_WRAP_RAD, low, found) if wrap else np.exp(found)
        reached = status <= DesignStatus.LOWER_LIMIT
        # The designs, and the upper limit where there is none.
        at = Conditions(**given, **{target: np.where(reached, x, high)})
        bound, before = _bound(fit, probability, at), beyond_linear
        beyond_linear = np.nan_to_num(bound - linear(at))
        if np.abs(beyond_linear - before).max(initial=0.0) < _SETTLED:
            break
    with np.errstate(over="ignore"):
        forces_N = np.exp([_mean(fit, at), bound])
    lift_N, bound_N, limit_lift_N, limit_bound_N = (
        np.where(mask, row, np.nan) for mask in (reached, ~reached) for row in forces_N
    )
    return Design(
        solve_for=solve_for,
        value=x,
        required_N=np.exp(log_load),
        lift_force_N=lift_N,
        lower_bound_N=bound_N,
        probability=probability,
        status=status,
        limits=(low, high),
        limit_lift_N=limit_lift_N,
        limit_bound_N=limit_bound_N,
        extrapolated=outside_range(fit.validity, at).any(axis=1) & reached,
        **given,
        **{target: x},
    )


def _checked(
    fit: FitResult, solve_for: SolveFor, **quantities: npt.ArrayLike | None
) -> tuple[dict[str, FloatArray], FloatArray, tuple[float, float]]:
    """Return the given quantities of n designs, their loads [N], and the range to search; refuse all that is wrong."""
    if solve_for not in tuple(QUANTITIES):
        text = f"cannot solve for {solve_for!r}"
        raise InputError(text, key="solve_for", fix="use one of wrap, radius, end_tension")
    target = QUANTITIES[solve_for][0]
    if quantities.pop(target) is not None:
        raise InputError(f"{target} is given and looked for", key=target, fix="leave it out")
    for name, value in quantities.items():
        if value is None:
            raise InputError(f"{name} is missing", key=name, fix="give every quantity but the one looked for")
    if solve_for == "radius" and "size" not in fit.friction_law.effects:
        text = f"the lift of law {fit.law} does not depend on the wheel radius, so no radius can be found"
        fix = "solve for the wrap or the end tension, or fit a law with a size effect"
        raise InputError(text, key="solve_for", fix=fix)
    low, high = QUANTITIES[solve_for][2]
    lists = {name: as_floats(name, value) for name, value in quantities.items() if value is not None}
    given = same_length("designs", lists)
    load_N = given.pop("lift_N")
    # Every quantity is checked here, so that no search meets a bad one.
    Conditions(**given, **{target: np.array(high)})
    bad = np.flatnonzero(~(np.isfinite(load_N) & (load_N > 0.0)))
    if bad.size:
        text = f"lift_N[{bad[0]}] is {load_N[bad[0]]:g} N; it must be finite and positive"
        raise InputError(text, key="lift_N")
    return given, load_N, (low, high)


def _of(function: Rising, some: Rows) -> Rising:
    """Return those functions of many whose rows are given."""
    return lambda x, rows: function(x, some[rows])


def _first_enough(
    by_bound: Rising, in_reach: BoolArray, lows: FloatArray, mean_root: FloatArray, highs: FloatArray
) -> tuple[FloatArray, npt.NDArray[np.int8]]:
    """Return place and status of designs: where the bound first suffices from where the mean law does."""
    x = np.full(lows.size, np.nan)
    status = np.where(in_reach, DesignStatus.TOO_UNCERTAIN, DesignStatus.OUT_OF_REACH).astype(np.int8)
    enough = by_bound(lows, np.arange(lows.size)) >= 0.0
    x[enough], status[enough] = lows[enough], DesignStatus.LOWER_LIMIT
    rows = np.flatnonzero(in_reach & ~enough)
    left, right = first_crossing(_of(by_bound, rows), mean_root[rows], highs[rows])
    held = ~np.isnan(right)
    rows = rows[held]
    x[rows], status[rows] = rising_root(_of(by_bound, rows), left[held], right[held]), DesignStatus.OK
    return x, status


class DesignChart(NamedTuple):
    """Lift forces over wheel radius and wrap at one end tension."""

    wheel_radius_m: FloatArray
    wrap_angle_rad: FloatArray
    rope_radius_m: float
    end_tension_N: float
    lift_force_N: FloatArray
    lower_bound_N: FloatArray
    probability: float
    extrapolated: BoolArray


def design_chart(
    fit: FitResult,
    wheel_radius_m: npt.ArrayLike,
    wrap_angle_rad: npt.ArrayLike,
    end_tension_N: float,
    *,
    rope_radius_m: float,
    probability: float = 0.95,
) -> DesignChart:
    """Return lift force and lower bound over a grid of r wheel radii [m] and w wraps [rad]."""
    radii = np.atleast_1d(np.asarray(wheel_radius_m, dtype=np.float64))
    wraps = np.atleast_1d(np.asarray(wrap_angle_rad, dtype=np.float64))
    grid = np.meshgrid(radii, wraps, indexing="ij")
    given = {"rope_radius_m": np.array(rope_radius_m), "end_tension_N": np.array(end_tension_N)}
    conditions = Conditions(wheel_radius_m=grid[0].ravel(), wrap_angle_rad=grid[1].ravel(), **given)
    shape = grid[0].shape
    outside = outside_range(fit.validity, conditions).any(axis=1)
    _check_probability(fit, probability)
    with np.errstate(over="ignore"):
        lift_N, bound_N = np.exp([_mean(fit, conditions), _bound(fit, probability, conditions)])
    return DesignChart(
        wheel_radius_m=radii,
        wrap_angle_rad=wraps,
        rope_radius_m=float(rope_radius_m),
        end_tension_N=float(end_tension_N),
        lift_force_N=lift_N.reshape(shape),
        lower_bound_N=bound_N.reshape(shape),
        probability=probability,
        extrapolated=outside.reshape(shape),
    )


def first_crossing(function: Rising, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return brackets (low, high) of the first place where functions reach zero; high is NaN where none does.

    For functions that rise at first but may fall later, such as a bound that widens with extrapolation: they are
    looked at in 24 steps that grow from `low`, so a crossing and return within one step goes unseen.
    """
    left, right = low.astype(np.float64), np.full(low.size, np.nan)
    rows = np.arange(low.size)
    for step in range(1, _SCAN + 1):
        at = low[rows] + (high[rows] - low[rows]) * (step / _SCAN) ** 4
        found = function(at, rows) >= 0.0
        right[rows[found]] = at[found]
        left[rows[~found]] = at[~found]
        rows = rows[~found]
        if not rows.size:
            break
    return left, right
