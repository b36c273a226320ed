"""The search for the best parameters: from several starts, with weights that follow the parameters."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.files.digits import significant, to_share
from ropefric.fitting.identifiability import RANK_RATIO
from ropefric.fitting.levenberg import batched_fit
from ropefric.fitting.nonlinear import Minimum, least_squares
from ropefric.fitting.problem import FitProblem
from ropefric.fitting.reduced import MANY, pooled
from ropefric.fitting.settings import FitSettings
from ropefric.fitting.weights import Scatter, pooled_scatter, shared_variance, trial_std
from ropefric.trials.table import TrialTable

# Weights depend on the parameters through the errors of the settings; they settle in two rounds.
_ROUNDS = 5
_SETTLED = 1e-4
# Scatter so small that it is rounding; weights need some number.
_SMALLEST_STD = 1e-12
_MAD_TO_STD = 1.4826
# How far other starts are spread, as a factor e^±this.
_SPREAD = 0.7
_OTHER_EVALUATIONS = 100
# Minima closer than this in χ² describe the data equally well (two standard deviations).
_AS_GOOD = 4.0
_APART = 0.01
# χ² that differs by this part of itself, or of one, is the same.
_SAME_COST = 1e-8
# From this ratio of the best to the worst known combination on, parameters are rounded one after the other.
_TRADED = 300.0
_TIGHT = 1e-13
_NOTHING = 1e-150


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Found:
    """What a search found."""

    problem: FitProblem
    minimum: Minimum
    scatter: Scatter
    shared: FloatArray
    notes: tuple[str, ...]


def search(problem: FitProblem, table: TrialTable, settings: FitSettings) -> Found:
    """Return the best minimum, with weights taken at it."""
    theta = problem.start
    weighed, scatter, shared = _weighed(problem, table, theta, settings)
    minimum, notes = _from_all_starts(_pooled(weighed, settings), settings)
    for _ in range(_ROUNDS):
        before = weighed.std
        weighed, scatter, shared = _weighed(problem, table, minimum.theta, settings)
        if np.allclose(weighed.std, before, rtol=_SETTLED, atol=0.0):
            break
        minimum = _minimum(_pooled(weighed, settings), minimum.theta, settings)
    if settings.loss == "linear":
        minimum = _rounded(weighed, minimum)
    # The weights of the very parameters that are handed on.
    weighed, scatter, shared = _weighed(problem, table, minimum.theta, settings)
    return Found(problem=weighed, minimum=minimum, scatter=scatter, shared=shared, notes=notes)


def _rounded(problem: FitProblem, minimum: Minimum) -> Minimum:
    """Return the minimum to the digits that mean something, so that all that follows starts alike on every machine.

    Each parameter is rounded by its error with the others held, which raises χ² by 1e-8 at most. Where parameters
    can be traded for each other that error is far below what the search knows of each, so they are rounded one
    after the other, the least known first and by its whole error, and those that are left are fitted anew.
    """
    theta = minimum.theta.copy()
    seen = (problem.jacobian(theta) != 0.0).any(axis=0)
    free = problem.vary & ~minimum.at_bound & seen
    while np.count_nonzero(free) > 1:
        index, std, ratio = _least_known(problem, theta, free)
        if ratio < _TRADED:
            break
        held = theta.copy()
        value = to_share(float(theta[index]), std)
        # However little is known of it, three digits keep it in the valley where the others can make up for it.
        held[index] = (
            value if abs(value - theta[index]) <= 1e-3 * abs(theta[index]) else significant(theta[index], 4)
        )
        free[index] = False
        again = batched_fit(problem, starts=held, vary=free, tolerance=_TIGHT)
        inside = (again.theta[0] > problem.lower) & (again.theta[0] < problem.upper)
        if not (again.converged[0] and inside[free].all()):
            break
        theta = again.theta[0]
    steepness = np.linalg.norm(problem.jacobian(theta), axis=0)
    for i in np.flatnonzero(free & (steepness > 0.0)):
        theta[i] = to_share(float(theta[i]), 1.0 / float(steepness[i]))
    same = (theta > problem.lower) & (theta < problem.upper) | minimum.at_bound | ~problem.vary
    good = bool(same.all()) and problem.law.admissible(theta, problem.conditions)
    return replace(minimum, theta=theta) if good else minimum


def _least_known(problem: FitProblem, theta: FloatArray, free: BoolArray) -> tuple[int, float, float]:
    """Return which free parameter takes most part in the weakest combination, its error, and how weak that is."""
    jacobian = problem.jacobian(theta)[:, free]
    length = np.linalg.norm(jacobian, axis=0)
    length = np.where(length > 0.0, length, 1.0)
    padding = np.zeros((max(jacobian.shape[1] - len(jacobian), 0), jacobian.shape[1]))
    _, values, rows = np.linalg.svd(np.vstack([jacobian / length, padding]), full_matrices=False)
    values = np.maximum(values, max(values[0] / RANK_RATIO, _NOTHING))
    place = int(np.argmax(np.abs(rows[-1]).round(6)))
    std = float(np.linalg.norm(rows[:, place] / values) / length[place])
    return int(np.flatnonzero(free)[place]), std, float(values[0] / values[-1])


def _weighed(
    problem: FitProblem, table: TrialTable, theta: FloatArray, settings: FitSettings
) -> tuple[FitProblem, Scatter, FloatArray]:
    residuals = problem.log_lift - problem.law.log_lift(theta, problem.conditions)
    scatter = pooled_scatter(residuals, problem.group)
    shared = shared_variance(problem.law, theta, table)
    dof = max(problem.n_points - problem.n_varying, 1)
    if settings.loss != "linear":
        # Outliers must not widen the yardstick that is to tell them.
        within = _MAD_TO_STD * float(np.median(np.abs(residuals - np.median(residuals))))
    elif scatter.known:
        within = scatter.within
    else:
        within = sqrt(max(float(residuals @ residuals) / dof - float(shared.mean()), 0.0))
    std = np.maximum(trial_std(within, shared, problem.group), _SMALLEST_STD)
    return replace(problem, std=std), scatter, shared


def _pooled(problem: FitProblem, settings: FitSettings) -> FitProblem:
    """Return a large problem with its repeats put together; a robust loss weighs each by its own residual."""
    return problem if problem.n_points < MANY or settings.loss != "linear" else pooled(problem)[0]


def _minimum(problem: FitProblem, start: FloatArray, settings: FitSettings, most: int = 400) -> Minimum:
    law, conditions = problem.law, problem.conditions
    return least_squares(
        problem.residuals,
        problem.jacobian,
        start,
        lower=problem.lower,
        upper=problem.upper,
        vary=problem.vary,
        names=law.parameter_names,
        loss=settings.loss,
        admissible=lambda theta: bool(law.admissible(theta, conditions)),
        max_evaluations=most,
    )


def _from_all_starts(problem: FitProblem, settings: FitSettings) -> tuple[Minimum, tuple[str, ...]]:
    best = _minimum(problem, problem.start, settings)
    others = [_minimum(problem, start, settings, _OTHER_EVALUATIONS) for start in _starts(problem, settings)]
    every = [best, *(other for other in others if other.converged)]
    # Several starts end in one valley, and the last bits may not say at which of its places: the first one stands.
    best = _lowest([one for one in every if one.converged] or every)
    rivals = [other for other in every if other.cost - best.cost < _AS_GOOD and _apart(other, best, problem)]
    if not rivals:
        return best, ()
    rival = _lowest(rivals)
    values = ", ".join(f"{name} = {value:.4g}" for name, value in problem.law.as_mapping(rival.theta).items())
    more = significant(rival.cost - best.cost, 2, smallest=_SAME_COST * (1.0 + best.cost))
    return best, (f"another minimum is as good (χ² larger by {more:.2g}): {values}",)


def _lowest(minima: Sequence[Minimum]) -> Minimum:
    """Return the first of those that no rounding tells from the lowest."""
    least = min(one.cost for one in minima)
    return next(one for one in minima if one.cost <= least + _SAME_COST * (1.0 + least))


def _starts(problem: FitProblem, settings: FitSettings) -> list[FloatArray]:
    """Return starts spread about the first one; a law of one parameter has one minimum."""
    if problem.n_varying < 2:
        return []
    rng = np.random.default_rng(settings.seed)
    p = problem.start.size
    spread = problem.start * np.exp(rng.normal(0.0, _SPREAD, (settings.n_starts - 1, p)))
    spread = np.clip(np.where(problem.vary, spread, problem.start), problem.lower, problem.upper)
    good = problem.law.admissible(spread, problem.conditions)
    return list(spread[good])


def _apart(one: Minimum, other: Minimum, problem: FitProblem) -> bool:
    """Return whether two ends of a search are different minima, not two points of one."""
    size = np.maximum(np.maximum(np.abs(one.theta), np.abs(other.theta)), 1e-6)
    return bool((np.abs(one.theta - other.theta) > _APART * size)[problem.vary].any())
