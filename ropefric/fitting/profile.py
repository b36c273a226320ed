"""Profile-likelihood intervals: how far a parameter can go while the others make up for it.

All ends of all parameters are walked to at once: along a grid, further where needed, then to the root.
"""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy.stats import chi2 as chi2_distribution
from scipy.stats import f as f_distribution

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import FitError, InputError
from ropefric.fitting.levenberg import batched_fit
from ropefric.fitting.problem import FitProblem, reduced

EndKind = Literal["crossing", "bound", "open", "edge"]
Rows = npt.NDArray[np.intp]

_RIDGE = 1e-12
_LOWER_MINIMUM = 1e-3
_ROUNDING = 1e-26
# The inner minimum is flat: this error of its place, in residuals, is an error of its square in Δχ².
_TOLERANCE = 1e-7
# Fractions of the end a parabola would have.
_GRID = np.array([0.25, 0.5, 0.75, 0.95, 1.05, 1.3])
_DOUBLINGS = 40
# A parameter without a bound that can grow this far has no limit.
_ENDLESS = 1e8
_ROUNDS = 60
# Far below what is kept of an end, 1e-5 of a standard error, so that no path to it shows.
_ROOT = 1e-10
# Nearer to where a law ends, its answers are rounding.
_EDGE = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ProfileCurve:
    """The profile of one parameter, for plotting."""

    name: str
    value: FloatArray
    delta_chi2: FloatArray
    threshold: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ProfileResult:
    """Profile-likelihood intervals of a fit."""

    level: float
    theta: FloatArray
    ci: FloatArray
    at_bound: BoolArray
    curves: tuple[ProfileCurve, ...]
    notes: tuple[str, ...]


def profile_intervals(
    problem: FitProblem,
    theta: npt.ArrayLike,
    *,
    level: float = 0.95,
    scale: npt.ArrayLike = 1.0,
    absolute_std: bool = False,
    dof: float | None = None,
) -> ProfileResult:
    """Return the profile-likelihood interval of every fitted parameter.

    A value belongs to the interval while Δχ² = χ²(value, others refitted) − χ²_min stays below scale · s² · F, with
    s² = χ²_min/(n − q) and F the quantile of F(1, dof); with absolute_std, below scale · the quantile of χ²(1).
    Correlated points make Δχ² too large by the ratio of the true variance to the one it believes in, parameter by
    parameter; dividing by that ratio (Chandler & Bate 2007, Biometrika 94:167, for one parameter at a time) gives
    back the size of the interval and keeps its shape.

    Each interval is connected: it ends at the first crossing on either side. Near a bound it is one-sided and ends
    at the bound; with the truth on the bound it then covers more than the level (97.5 % at 95 %). The intervals of
    parameters strongly correlated with one whose truth is exactly on its bound cover less (90 % at 95 % for the
    exponent of `wrap-power` without a plateau), because the bound pulls half of all fits to one side; from half a
    standard error off the bound they are right again.
    """
    if not 0.0 < level < 1.0:
        raise InputError(f"the level is {level:g}; it must lie between 0 and 1", key="level", fix="0.95")
    start = np.asarray(theta, dtype=np.float64)
    inflation = np.broadcast_to(np.asarray(scale, dtype=np.float64), start.shape)
    if not (np.isfinite(inflation) & (inflation > 0.0)).all():
        raise InputError("scale must be finite and positive", key="scale", fix="1 for independent points")
    fit = batched_fit(problem, starts=start)
    best, chi2_min = fit.theta[0], float(fit.chi2[0])
    if not np.isfinite(chi2_min):
        raise InputError(
            f"{problem.law.name} has no answer at theta = {start.tolist()}", code="RF420", key="theta"
        )
    notes = [] if fit.converged[0] else ["the fit had not converged, so the intervals are not to be trusted"]
    threshold = inflation * _unit_threshold(problem, chi2_min, level, absolute_std=absolute_std, dof=dof)
    # Exact data leave nothing but rounding, and rounding has no interval.
    threshold = np.where(threshold > _ROUNDING * float(reduced(problem).signal[0]), threshold, 0.0)
    direction, reach = _quadratic_guess(problem, best, threshold)
    search = _Search(problem=problem, best=best, chi2_min=chi2_min, direction=direction)
    ends, kinds = search_ends(search, threshold, reach)
    ci = np.stack([best, best], axis=-1)
    at_bound = np.zeros(ci.shape, dtype=np.bool_)
    for (parameter, side), end, kind in zip(search.sides(), ends, kinds, strict=True):
        ci[parameter, side] = end
        at_bound[parameter, side] = kind == "bound"
        notes += _end_note(problem.law.parameter_names[parameter], side, end, kind)
    if search.lowest < -_LOWER_MINIMUM * max(chi2_min, 1e-300):
        notes.append(
            f"a lower minimum was met on the way (χ² {chi2_min + search.lowest:.6g} < {chi2_min:.6g}): "
            "fit again from more starts"
        )
    return ProfileResult(
        level=level,
        theta=best,
        ci=ci,
        at_bound=at_bound,
        curves=tuple(
            ProfileCurve(
                name=problem.law.parameter_names[j],
                value=value,
                delta_chi2=delta,
                threshold=float(threshold[j]),
            )
            for j, (value, delta) in search.curves().items()
        ),
        notes=tuple(notes),
    )


def _unit_threshold(
    problem: FitProblem, chi2_min: float, level: float, *, absolute_std: bool, dof: float | None
) -> float:
    if absolute_std:
        return float(chi2_distribution.ppf(level, 1))
    own = problem.n_points - problem.n_varying
    used = float(own) if dof is None else float(dof)
    if own <= 0 or not used > 0.0:
        raise FitError(
            f"{problem.n_points} points and {problem.n_varying} fitted parameters leave no degree of freedom to "
            "estimate the scatter from",
            fix="measure more, or fix a parameter; in Python, standard deviations may count as known (absolute_std)",
        )
    return float(f_distribution.ppf(level, 1, used)) * chi2_min / own


def _quadratic_guess(
    problem: FitProblem, best: FloatArray, threshold: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return how the others follow each parameter, column by column, and how far each would go on a parabola."""
    data, row = reduced(problem), np.zeros(1, dtype=np.intp)
    normal = data.evaluate(best[np.newaxis], row, np.full(1, np.inf))[1][0]
    size = np.sqrt(np.diag(normal))
    units = np.where(size > 0.0, size, 1.0)
    blocked = ~(problem.vary[:, np.newaxis] & problem.vary)
    scaled = np.where(blocked, 0.0, normal / np.outer(units, units))
    scaled += np.diag(np.where(np.diag(scaled) > 0.0, _RIDGE, 1.0))
    covariance = np.linalg.inv(scaled) / np.outer(units, units)
    variance = np.abs(np.diag(covariance))
    return covariance / variance, np.sqrt(variance * threshold)


def _end_note(name: str, side: int, end: float, kind: str) -> list[str]:
    which = ("lower", "upper")[side]
    if kind == "bound":
        return [
            f"{name}: the data set no {which} limit before its bound {end:.6g}; the interval is one-sided"
        ]
    if kind == "open":
        return [f"{name}: the data set no {which} limit at all"]
    if kind == "edge":
        return [f"{name}: the {which} end {end:.6g} is where the law stops having an answer"]
    return []


@dataclass(slots=True, kw_only=True, eq=False)
class _Search:
    """Profiles of one fit, evaluated in batches and remembered."""

    problem: FitProblem
    best: FloatArray
    chi2_min: float
    direction: FloatArray
    lowest: float = 0.0
    seen: list[tuple[Rows, FloatArray, FloatArray]] = field(default_factory=list)

    def sides(self) -> list[tuple[int, int]]:
        """Return (parameter, side) of every end that is looked for; side 0 is the lower one."""
        return [(int(j), side) for j in np.flatnonzero(self.problem.vary) for side in (0, 1)]

    def increase(self, parameter: Rows, value: FloatArray) -> FloatArray:
        """Return Δχ² with each named parameter held at a value and the others refitted; infinite for no answer."""
        if not value.size:
            return np.empty(0)
        rows = np.arange(value.size)
        starts = self.best + self.direction[:, parameter].T * (value - self.best[parameter])[:, np.newaxis]
        starts = np.clip(starts, self.problem.lower, self.problem.upper)
        starts = np.where(self.problem.vary, starts, self.best)
        starts[rows, parameter] = value
        plain = np.tile(self.best, (value.size, 1))
        plain[rows, parameter] = value
        usable = self.problem.law.admissible(starts, self.problem.conditions)
        vary = np.tile(self.problem.vary, (value.size, 1))
        vary[rows, parameter] = False
        fit = batched_fit(
            self.problem,
            starts=np.where(usable[:, np.newaxis], starts, plain),
            vary=vary,
            tolerance=_TOLERANCE,
        )
        delta = fit.chi2 - self.chi2_min
        self.lowest = min(self.lowest, float(delta.min()))
        delta = np.maximum(delta, 0.0)
        self.seen.append((parameter, value, delta))
        return delta

    def curves(self) -> dict[int, tuple[FloatArray, FloatArray]]:
        """Return value and Δχ² of every parameter that was walked, the minimum among them, in rising order."""
        found = {}
        for j in (int(j) for j in np.flatnonzero(self.problem.vary)):
            value = np.concatenate([self.best[j : j + 1], *(v[p == j] for p, v, _ in self.seen)])
            delta = np.concatenate([np.zeros(1), *(d[p == j] for p, _, d in self.seen)])
            value, first = np.unique(value, return_index=True)
            found[j] = (value, delta[first])
        return found


def search_ends(
    search: _Search, threshold: FloatArray, reach: FloatArray
) -> tuple[list[float], list[EndKind]]:
    """Return the end of the interval of every side of a search, and what stops it there."""
    sides = search.sides()
    if not sides:
        return [], []
    parameter, side = np.array(sides, dtype=np.intp).T
    sign = np.where(side == 0, -1.0, 1.0)
    bound = np.where(side == 0, search.problem.lower[parameter], search.problem.upper[parameter])
    room = np.maximum(sign * (bound - search.best[parameter]), 0.0)
    room = np.where(np.isfinite(room), room, _ENDLESS * np.maximum(np.abs(search.best[parameter]), 1.0))
    walk = _Walk(
        search=search, parameter=parameter, sign=sign, bound=bound, room=room, target=threshold[parameter]
    )
    walk.bracket(np.minimum(reach[parameter], room))
    walk.refine()
    ends = search.best[parameter] + sign * walk.inside
    kinds: list[EndKind] = []
    for i in range(len(sides)):
        if not walk.closed[i]:
            kinds.append("bound" if np.isfinite(bound[i]) else "open")
            ends[i] = bound[i]
        else:
            kinds.append("crossing" if np.isfinite(walk.outside_delta[i]) else "edge")
    return ends.tolist(), kinds


@dataclass(slots=True, kw_only=True, eq=False)
class _Walk:
    """Brackets of all ends, as distances from the minimum: Δχ² is below the target inside and not outside."""

    search: _Search
    parameter: Rows
    sign: FloatArray
    bound: FloatArray
    room: FloatArray
    target: FloatArray
    inside: FloatArray = field(init=False)
    inside_delta: FloatArray = field(init=False)
    outside: FloatArray = field(init=False)
    outside_delta: FloatArray = field(init=False)
    closed: BoolArray = field(init=False)

    def __post_init__(self) -> None:
        count = self.parameter.size
        self.inside, self.inside_delta = np.zeros(count), np.zeros(count)
        self.outside, self.outside_delta = np.full(count, np.inf), np.full(count, np.inf)
        self.closed = self.target <= 0.0
        self.outside[self.closed] = self.outside_delta[self.closed] = 0.0

    def ask(self, which: Rows, distance: FloatArray) -> FloatArray:
        best = self.search.best[self.parameter[which]]
        value = best + self.sign[which] * distance
        # Exactly the bound, and not what rounding makes of best + (bound − best).
        at_bound = (distance >= self.room[which]) & np.isfinite(self.bound[which])
        return self.search.increase(self.parameter[which], np.where(at_bound, self.bound[which], value))

    def place(self, which: Rows, distance: FloatArray, delta: FloatArray) -> None:
        """Move one end of each bracket to a distance that was asked about, unless the bracket excludes it."""
        over = delta >= self.target[which]
        outward = ~over & (distance > self.inside[which]) & (distance < self.outside[which])
        inward = over & (distance < self.outside[which])
        self.inside[which[outward]], self.inside_delta[which[outward]] = distance[outward], delta[outward]
        self.outside[which[inward]], self.outside_delta[which[inward]] = distance[inward], delta[inward]
        self.closed[which[inward]] = True

    def bracket(self, reach: FloatArray) -> None:
        """Walk a grid on both sides of every parameter, then further where nothing was crossed."""
        which = np.flatnonzero((self.room > 0.0) & (self.target > 0.0))
        grid = np.minimum(np.outer(reach[which], _GRID), self.room[which, np.newaxis])
        delta = self.ask(np.repeat(which, _GRID.size), grid.ravel()).reshape(grid.shape)
        # From outside inwards, so that the innermost crossing is what remains.
        for column in range(_GRID.size)[::-1]:
            over = delta[:, column] >= self.target[which]
            self.place(which[over], grid[over, column], delta[over, column])
        for column in range(_GRID.size):
            under = delta[:, column] < self.target[which]
            self.place(which[under], grid[under, column], delta[under, column])
        distance = np.minimum(reach * _GRID[-1], self.room)
        for _ in range(_DOUBLINGS):
            which = np.flatnonzero(~self.closed & (distance < self.room))
            if not which.size:
                return
            distance[which] = np.minimum(2.0 * distance[which], self.room[which])
            self.place(which, distance[which], self.ask(which, distance[which]))

    def refine(self) -> None:
        """Close the brackets on the roots of √Δχ² − √target, which is nearly straight."""
        last = np.zeros(self.parameter.size)
        low_weight, high_weight = np.ones(last.size), np.ones(last.size)
        for _ in range(_ROUNDS):
            width = self.outside - self.inside
            narrow = np.where(np.isinf(self.outside_delta), _EDGE, _ROOT)
            which = np.flatnonzero(self.closed & (width > narrow * self.outside))
            if not which.size:
                return
            below = (np.sqrt(self.inside_delta[which]) - np.sqrt(self.target[which])) * low_weight[which]
            above = (np.sqrt(self.outside_delta[which]) - np.sqrt(self.target[which])) * high_weight[which]
            with np.errstate(invalid="ignore"):
                share = np.where(np.isfinite(above), -below / (above - below), 0.5)
            distance = self.inside[which] + np.clip(share, 1e-3, 1.0 - 1e-3) * width[which]
            delta = self.ask(which, distance)
            self.place(which, distance, delta)
            over = delta >= self.target[which]
            # Illinois: an end that stays twice counts half, or the bracket would close from one side only.
            low_weight[which] = np.where(over & (last[which] > 0), 0.5 * low_weight[which], 1.0)
            high_weight[which] = np.where(~over & (last[which] < 0), 0.5 * high_weight[which], 1.0)
            last[which] = np.where(over, 1.0, -1.0)
            near = np.abs(np.sqrt(delta) - np.sqrt(self.target[which])) < _ROOT * np.sqrt(self.target[which])
            self.inside[which[near]] = self.outside[which[near]] = distance[near]
