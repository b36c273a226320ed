"""The walk along the profiles of all parameters at once: a grid, further where needed, then the root."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.fitting.levenberg import batched_fit
from ropefric.fitting.problem import FitProblem

EndKind = Literal["crossing", "bound", "open", "edge"]
IntArray = npt.NDArray[np.intp]

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


@dataclass(slots=True, kw_only=True, eq=False)
class Search:
    """Profiles of one fit, evaluated in batches and remembered."""

    problem: FitProblem
    best: FloatArray
    chi2_min: float
    direction: FloatArray
    lowest: float = 0.0
    seen: list[tuple[IntArray, FloatArray, FloatArray]] = field(default_factory=list)

    def sides(self) -> list[tuple[int, int]]:
        """Return (parameter, side) of every end that is looked for; side 0 is the lower one."""
        return [(int(j), side) for j in np.flatnonzero(self.problem.vary) for side in (0, 1)]

    def increase(self, parameter: IntArray, value: FloatArray) -> FloatArray:
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
    search: Search, threshold: FloatArray, reach: FloatArray
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

    search: Search
    parameter: IntArray
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

    def ask(self, which: IntArray, distance: FloatArray) -> FloatArray:
        best = self.search.best[self.parameter[which]]
        value = best + self.sign[which] * distance
        # Exactly the bound, and not what rounding makes of best + (bound − best).
        at_bound = (distance >= self.room[which]) & np.isfinite(self.bound[which])
        return self.search.increase(self.parameter[which], np.where(at_bound, self.bound[which], value))

    def place(self, which: IntArray, distance: FloatArray, delta: FloatArray) -> None:
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
