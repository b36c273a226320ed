"""What least squares needs of the data: one weighted mean per distinct condition and the scatter about it.

Repeats of a condition share the model's answer f, so Σ w (y − f)² = W (ȳ − f)² + Σ w (y − ȳ)² exactly. A law
is therefore evaluated once per condition and not once per trial, however many repeats there are.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.fitting.problem import FitProblem
from ropefric.friction.condition import Conditions
from ropefric.friction.law import FrictionLaw

MANY = 2000
"""From so many trials on, the repeats of a condition are put together before a law is fitted or resampled."""

# Sets times conditions evaluated in one go: the temporaries of a law then stay in the processor's cache.
_BLOCK = 16384
# Numbers per array while repeats are summed: bounds the memory of thousands of resamples of thousands of trials.
_WIDE_BLOCK = 2_000_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Reduced:
    """Data sets of one plan of conditions, seen through a law."""

    law: FrictionLaw
    conditions: Conditions
    weight: FloatArray
    mean: FloatArray
    rest: FloatArray

    @property
    def signal(self) -> FloatArray:
        """Return the weighted sum of squares of the means, shape (1,) or (m,): rounding errors scale with it."""
        return np.asarray((self.weight * self.mean**2).sum(axis=-1))

    def chi2(self, theta: FloatArray, rows: npt.NDArray[np.intp] | None = None) -> FloatArray:
        """Return the weighted sums of squares, infinite where the law has no answer."""
        chosen = np.zeros(len(theta), dtype=np.intp) if rows is None else rows
        chi2 = np.empty(len(theta))
        for part in self._blocks(len(theta)):
            (values,), has_answer = _each(
                self._log_lift, theta[part], self.conditions, (len(self.conditions),)
            )
            chi2[part] = self._misfit(values, has_answer, chosen[part])[0]
        return chi2

    def evaluate(
        self, theta: FloatArray, rows: npt.NDArray[np.intp], limit: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return χ², JᵀWJ and JᵀW(y − f) of parameter sets."""
        (r, p), k = theta.shape, len(self.conditions)
        chi2, normal, downhill = np.empty(r), np.zeros((r, p, p)), np.zeros((r, p))
        (plain,), (sloped,) = (limit < 0.0).nonzero(), (limit >= 0.0).nonzero()
        if plain.size:
            chi2[plain] = self.chi2(theta[plain], rows[plain])
        for part in self._blocks(sloped.size):
            at = sloped[part]
            (values, J), has_answer = _each(
                self.law.log_lift_and_jacobian, theta[at], self.conditions, (k,), (k, p)
            )
            chi2[at], residual = self._misfit(values, has_answer, rows[at])
            (good,) = (np.isfinite(chi2[at]) & (chi2[at] <= limit[at])).nonzero()
            if good.size < at.size:
                at, J, residual = at[good], J[good], residual[good]
            weighted = J.swapaxes(1, 2) * _row(self.weight, rows[at])[:, np.newaxis, :]
            normal[at] = weighted @ J
            downhill[at] = (weighted @ residual[:, :, np.newaxis])[..., 0]
        return chi2, normal, downhill

    def evaluate_shared(self, theta: FloatArray, m: int) -> tuple[FloatArray, FloatArray, FloatArray] | None:
        """Return the same as `evaluate` for all m data sets at one parameter set of shape (p,).

        The law is evaluated once, so this costs next to nothing. None where it has no answer.
        """
        p = theta.size
        try:
            values, J = self.law.log_lift_and_jacobian(theta, self.conditions)
        except InputError:
            return None
        residual = self.mean - values
        chi2 = (self.weight * residual**2).sum(axis=-1) + self.rest
        products = (J[:, :, np.newaxis] * J[:, np.newaxis, :]).reshape(len(J), p * p)
        normal = (self.weight @ products).reshape(-1, p, p)
        downhill = (self.weight * residual) @ J
        return (
            np.broadcast_to(chi2, (m,)).copy(),
            np.broadcast_to(normal, (m, p, p)).copy(),
            np.broadcast_to(downhill, (m, p)).copy(),
        )

    def _log_lift(self, theta: FloatArray, conditions: Conditions) -> tuple[FloatArray]:
        return (self.law.log_lift(theta, conditions),)

    def _misfit(
        self, values: FloatArray, has_answer: BoolArray, rows: npt.NDArray[np.intp]
    ) -> tuple[FloatArray, FloatArray]:
        residual = _row(self.mean, rows) - values
        # A law may answer with 1e300, which no square can hold: such a set is no candidate.
        with np.errstate(over="ignore"):
            chi2 = np.einsum("rk,rk->r", _row(self.weight, rows) * residual, residual) + _row(self.rest, rows)
        return np.where(has_answer, chi2, np.inf), residual

    def _blocks(self, r: int) -> Iterator[slice]:
        size = max(1, _BLOCK // max(1, len(self.conditions)))
        return (slice(first, min(first + size, r)) for first in range(0, r, size))


def reduced(
    problem: FitProblem,
    log_lift: FloatArray | None = None,
    std: FloatArray | None = None,
    multiplicity: FloatArray | None = None,
) -> Reduced:
    """Return the data of a problem, or m data sets at its conditions, by distinct condition."""
    y = _table("log_lift", problem.log_lift if log_lift is None else log_lift, problem)
    s = _table("std", problem.std if std is None else std, problem)
    count = _table("multiplicity", np.ones(1) if multiplicity is None else multiplicity, problem)
    _check("log_lift", np.isfinite(y), "finite")
    _check("std", s > 0.0, "positive")
    _check("multiplicity", (count >= 0.0) & np.isfinite(count), "finite and zero or more")
    order, starts = _distinct(problem.conditions)
    repeated = starts.size < order.size
    if not repeated:
        # Nothing to put together, so the points stay as they are.
        order = starts
    rows = max(len(y), len(s), len(count))
    size = max(1, _WIDE_BLOCK // problem.n_points)
    parts = [
        _sums(y[_part(y, at, size)], s[_part(s, at, size)], count[_part(count, at, size)], order, starts)
        for at in range(0, rows, size)
    ]
    weight, mean, rest = (np.concatenate(column) for column in zip(*parts, strict=True))
    shared_weight = len(s) == 1 and len(count) == 1
    return Reduced(
        law=problem.law,
        conditions=problem.conditions.select(order[starts]) if repeated else problem.conditions,
        weight=weight[:1] if shared_weight else weight,
        mean=mean,
        rest=rest,
    )


def pooled(problem: FitProblem) -> tuple[FitProblem, FloatArray]:
    """Return a problem with one point per distinct condition, and how much less each scatters than a trial.

    Its χ² is that of the whole problem but for a constant.
    """
    order, starts = _distinct(problem.conditions)
    if starts.size == order.size:
        return problem, np.ones(order.size)
    means, weight = reduced(problem), problem.std[order] ** -2.0
    share = np.sqrt(np.add.reduceat(weight**2, starts)) / np.add.reduceat(weight, starts)
    whole = replace(
        problem,
        conditions=means.conditions,
        log_lift=means.mean[0],
        std=means.weight[0] ** -0.5,
        group=problem.group[order[starts]],
    )
    return whole, share


def _distinct(conditions: Conditions) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Return an order that puts repeats side by side, and where in it each distinct condition begins."""
    columns = [getattr(conditions, field.name) for field in fields(Conditions)]
    order = np.lexsort(columns)
    new = np.ones(order.size, dtype=np.bool_)
    new[1:] = np.any([column[order[1:]] != column[order[:-1]] for column in columns], axis=0)
    return order, np.flatnonzero(new)


def _sums(
    y: FloatArray, s: FloatArray, count: FloatArray, order: npt.NDArray[np.intp], starts: npt.NDArray[np.intp]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return weight, mean and rest; the rows of the last two are as many as there are data sets."""
    w = np.broadcast_to(count / s**2, (max(len(count), len(s)), y.shape[1]))[:, order]
    y = y[:, order]
    weight = np.add.reduceat(w, starts, axis=1)
    safe = np.where(weight > 0.0, weight, 1.0)
    # Sums about a point near the data keep the digits that sums of the data themselves would cancel.
    reference = y[:, starts]
    sizes = np.diff(np.append(starts, y.shape[1]))
    mean = reference + np.add.reduceat(w * (y - np.repeat(reference, sizes, axis=1)), starts, axis=1) / safe
    rest = (w * (y - np.repeat(mean, sizes, axis=1)) ** 2).sum(axis=1)
    return weight, mean, rest


def _table(name: str, values: npt.ArrayLike, problem: FitProblem) -> FloatArray:
    array = np.atleast_2d(np.asarray(values, dtype=np.float64))
    if array.ndim != 2 or array.shape[1] not in {1, problem.n_points}:
        raise InputError(
            f"{name} has shape {np.shape(values)}; the problem has {problem.n_points} points",
            code="RF400",
            key=name,
            fix=f"give ({problem.n_points},) or (m, {problem.n_points})",
        )
    return np.broadcast_to(array, (len(array), problem.n_points))


def _check(name: str, good: BoolArray, rule: str) -> None:
    if not good.all():
        row, point = (int(i) for i in np.argwhere(~good)[0])
        raise InputError(f"{name} of point {point} in data set {row} must be {rule}", code="RF400", key=name)


def _part(array: FloatArray, at: int, size: int) -> slice:
    return slice(None) if len(array) == 1 else slice(at, at + size)


def _row(array: FloatArray, rows: npt.NDArray[np.intp]) -> FloatArray:
    """Return the rows of an array that may stand for all data sets with its only one."""
    return array if len(array) == 1 else array[rows]


def _each(
    question: Callable[[FloatArray, Conditions], tuple[FloatArray, ...]],
    theta: FloatArray,
    conditions: Conditions,
    *shapes: tuple[int, ...],
) -> tuple[tuple[FloatArray, ...], BoolArray]:
    """Return the answers of a law, of these shapes a set, and which sets have them; the others' are zero."""
    has_answer = np.ones(len(theta), dtype=np.bool_)
    try:
        # Nearly always all sets have an answer, so it is asked for before it is asked about.
        return question(theta, conditions), has_answer
    except InputError:
        tables = tuple(np.zeros((len(theta), *shape)) for shape in shapes)
    for i, one in enumerate(theta):
        try:
            answers = question(one, conditions)
        except InputError:
            has_answer[i] = False
            continue
        for table, answer in zip(tables, answers, strict=True):
            table[i] = answer
    return tables, has_answer
