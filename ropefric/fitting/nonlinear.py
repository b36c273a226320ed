"""Bounded nonlinear least squares of any model: the one place that calls lmfit."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import sqrt
from typing import Any

import lmfit
import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.fitting.losses import LOSSES, Loss, loss_cost, loss_weights

Model = Callable[[FloatArray], FloatArray]

# Closer to a bound than this, by the larger of its size and the value's, an estimate is tried on the bound.
_NEAR_BOUND = 1e-4
# What a step onto a bound may cost in χ².
_FREE = 1e-6
_POLISH_STEPS = 60
# By how much rounding may raise χ² at its minimum, and how small a step must be to be about the last digits.
_ROUNDED = 1e-12
_LAST_DIGITS = 1e-6
_SHRINKS = 0.9
# Steps of this part of a standard error change nothing any more.
_SETTLED = 1e-13
# A gain in χ² by this part of the mean squared residual is no gain.
_FLAT = 1e-3
_RANK = 1e-6
_TOLERANCE = 1e-13
# What a parameter set outside the law's domain costs: the search turns back from it.
_REFUSED = 1e8


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Minimum:
    """Where a search ended."""

    theta: FloatArray
    cost: float
    converged: bool
    at_bound: BoolArray
    n_evaluations: int
    message: str


def least_squares(
    residual: Model,
    jacobian: Model,
    start: npt.ArrayLike,
    *,
    lower: npt.ArrayLike = -np.inf,
    upper: npt.ArrayLike = np.inf,
    vary: npt.ArrayLike = True,
    names: Sequence[str] = (),
    loss: Loss = "linear",
    admissible: Callable[[FloatArray], bool] | None = None,
    max_evaluations: int = 400,
) -> Minimum:
    """Return the parameters that make the sum of squared residuals least."""
    theta0 = np.array(start, dtype=np.float64)
    p = theta0.size
    low, high = (np.broadcast_to(np.asarray(bound, np.float64), (p,)) for bound in (lower, upper))
    free = np.broadcast_to(np.asarray(vary, dtype=bool), (p,))
    if loss not in LOSSES:
        raise InputError(f"unknown loss {loss!r}", key="loss", fix=f"use one of {', '.join(LOSSES)}")
    check_start(theta0, low, high, tuple(names) or tuple(f"p{i}" for i in range(p)), admissible)
    task = _Task(residual, jacobian, theta0, low, high, free, loss, admissible or (lambda _theta: True))
    theta, converged, n_evaluations, message = theta0, True, 1, "nothing to fit"
    if free.any():
        theta, converged, n_evaluations, message = _search(task, max_evaluations)
        theta = _onto_bounds(task, theta)
        theta = _polish(task, theta)
    at_bound = free & ((theta <= low) | (theta >= high))
    converged = converged or _is_flat(residual(theta), jacobian(theta)[:, free & ~at_bound], loss)
    return Minimum(
        theta=theta,
        cost=loss_cost(residual(theta), loss),
        converged=converged,
        at_bound=at_bound,
        n_evaluations=n_evaluations,
        message=message,
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Task:
    residual: Model
    jacobian: Model
    start: FloatArray
    low: FloatArray
    high: FloatArray
    free: BoolArray
    loss: Loss
    admissible: Callable[[FloatArray], bool]

    def full(self, values: FloatArray) -> FloatArray:
        theta = self.start.copy()
        theta[self.free] = values
        return theta

    def cost(self, theta: FloatArray) -> float:
        return loss_cost(self.residual(theta), self.loss)


def _search(task: _Task, max_evaluations: int) -> tuple[FloatArray, bool, int, str]:
    varying = np.flatnonzero(task.free)
    n = task.residual(task.start).size
    # More rows than parameters, or the search refuses to start; rows of zeros change nothing.
    n_extra = max(varying.size - n, 0)
    parameters = lmfit.Parameters()
    for i in varying:
        # lmfit reads names as expressions, so they are numbered.
        low, high = float(task.low[i]), float(task.high[i])
        parameters.add(f"q{i}", value=_inside(task.start[i], low, high), min=low, max=high)

    def values_of(given: Any) -> FloatArray:
        return task.full(np.array([given[f"q{i}"].value for i in varying]))

    def residual_of(given: Any) -> FloatArray:
        theta = values_of(given)
        if not task.admissible(theta):
            return np.full(n + n_extra, _REFUSED)
        return np.concatenate([task.residual(theta), np.zeros(n_extra)])

    def jacobian_of(given: Any) -> FloatArray:
        table = task.jacobian(values_of(given))[:, task.free]
        return np.vstack([table, np.zeros((n_extra, table.shape[1]))])

    minimizer = lmfit.Minimizer(residual_of, parameters, calc_covar=False, max_nfev=max_evaluations)
    # lmfit divides by standard errors of its own, which are zero for parameters that are not seen; none is used.
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        done = minimizer.minimize(
            method="least_squares",
            jac=jacobian_of,
            loss=task.loss,
            x_scale="jac",
            ftol=_TOLERANCE,
            xtol=_TOLERANCE,
            gtol=_TOLERANCE,
        )
    return values_of(done.params), bool(done.success), int(done.nfev), str(done.message)


def check_start(
    start: FloatArray,
    low: FloatArray,
    high: FloatArray,
    names: Sequence[str],
    admissible: Callable[[FloatArray], bool] | None,
) -> None:
    """Refuse a start outside its bounds or without residuals; return quietly otherwise."""
    for name, value, lower, upper in zip(names, start, low, high, strict=True):
        if not lower <= value <= upper:
            raise InputError(
                f"the start value {name} = {value:g} lies outside its bounds {lower:g} … {upper:g}",
                code="RF402",
                key=name,
                fix="start inside the bounds, or widen them",
            )
    if admissible is not None and not admissible(start):
        shown = ", ".join(f"{name} = {value:g}" for name, value in zip(names, start, strict=True))
        raise InputError(f"the law has no answer at the start {shown}", code="RF402", fix="start elsewhere")


def _inside(value: float, low: float, high: float) -> float:
    """Return a value strictly between its bounds, where the search may start."""
    margin = 1e-6 * min(high - low, max(abs(value), 1e-3))
    return float(min(max(value, low + margin), high - margin))


def _is_flat(residuals: FloatArray, jacobian: FloatArray, loss: Loss) -> bool:
    """Return whether the next step would gain nothing that counts, though the search may creep on for ever.

    Along a valley, where parameters can be traded for each other, the steps never get small.
    """
    root = np.sqrt(loss_weights(residuals, loss))
    weighted = jacobian * root[:, None]
    length = np.linalg.norm(weighted, axis=0)
    basis, values, _ = np.linalg.svd(weighted / np.where(length > 0.0, length, 1.0), full_matrices=False)
    along = basis[:, values > _RANK * values.max(initial=0.0)].T @ (residuals * root)
    return bool(along @ along <= _FLAT * loss_cost(residuals, loss) / residuals.size)


def _onto_bounds(task: _Task, theta: FloatArray) -> FloatArray:
    """Return theta with every parameter on its bound that crept up to it without a gain.

    The search stays inside the bounds for ever, so a minimum on a bound would look like one close to it.
    """
    cost = task.cost(theta)
    for i in np.flatnonzero(task.free):
        for bound in (task.low[i], task.high[i]):
            reach = _NEAR_BOUND * max(abs(bound), abs(theta[i]), 1.0)
            if not (np.isfinite(bound) and abs(theta[i] - bound) <= reach):
                continue
            moved = theta.copy()
            moved[i] = bound
            if not task.admissible(moved):
                continue
            moved_cost = task.cost(moved)
            if moved_cost <= cost * (1.0 + _FREE) + _FREE:
                theta, cost = moved, moved_cost
    return theta


def _polish(task: _Task, theta: FloatArray) -> FloatArray:
    """Return theta after Gauss-Newton steps inside the bounds, until they are rounding: the last digits.

    χ² is flat at its minimum and stops falling when half the digits are right. From there on a small step counts as
    help as long as the next ones get shorter, which rounding does not do. A parameter that a step would carry beyond
    its bound stays on it.
    """
    best = task.cost(theta)
    shortest = np.inf
    for _ in range(_POLISH_STEPS):
        inside = task.free & (theta > task.low) & (theta < task.high)
        if not inside.any():
            break
        residuals = task.residual(theta)
        root = np.sqrt(loss_weights(residuals, task.loss))
        slopes = task.jacobian(theta)[:, inside] * root[:, None]
        step = np.linalg.lstsq(slopes, -residuals * root, rcond=1e-10)[0]
        moved = theta.copy()
        moved[inside] = np.clip(theta[inside] + step, task.low[inside], task.high[inside])
        length = float(np.linalg.norm(slopes @ step))
        if not task.admissible(moved):
            break
        cost = task.cost(moved)
        small = bool((np.abs(step) <= _LAST_DIGITS * np.abs(theta[inside])).all())
        settling = small and length < _SHRINKS * shortest and cost <= (1.0 + _ROUNDED) * best
        if not (cost < best or settling):
            break
        theta, best, shortest = moved, cost, min(length, shortest)
        if length <= _SETTLED * max(1.0, sqrt(cost)):
            break
    return theta
