"""The best choice of conditions to test: what the means of conditions know, and the search for those that know most.

The plan is found by exchange of conditions against candidates until no exchange helps (Fedorov 1972).
"""

from functools import partial
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray, IntArray
from ropefric.fitting.statistics import decomposed

BALANCE = 0.3
"""Weight of the parameters' ellipsoid in a plan for a prediction [-]; it costs that prediction a few per cent."""

# Keeps the inverse finite while a plan of few conditions has one taken out; a whitened plan has eigenvalues near 1.
_RIDGE = 1e-13
_TINY = float(np.finfo(np.float64).tiny)
_WORTHWHILE = 1e-9
# Part of a mean's error that is its own, at least: of none, two means would show their shared error without any.
_LEAST_OWN = 1e-4
_MAX_PASSES = 100


class Evidence(NamedTuple):
    """Information of the means of conditions about the free parameters.

    Gradients over the standard deviation that a mean is weighed by (n, q), and of that standard deviation the part that
    is a mean's own scatter (n,) and those of errors that conditions share, by name (n,).
    """

    rows: FloatArray
    own: FloatArray
    shares: dict[str, FloatArray]

    def joined(self, other: "Evidence") -> "Evidence":
        """Return both together: an error of the same name is the same one."""
        none, no_other = np.zeros(len(self.rows)), np.zeros(len(other.rows))
        names = self.shares | other.shares
        shares = {
            name: np.append(self.shares.get(name, none), other.shares.get(name, no_other)) for name in names
        }
        return Evidence(np.vstack([self.rows, other.rows]), np.append(self.own, other.own), shares)

    @property
    def table(self) -> FloatArray:
        """Return the parts of shared errors as columns, shape (n, b)."""
        return np.array([*self.shares.values()]).reshape(len(self.shares), len(self.rows)).T

    def errors(self, gradients: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the standard errors of generalised least squares along gradients (t, q), and their shared parts.

        Shapes (t,) and (t, b), a column an error. Infinite where the rows do not determine the requested value.
        """
        table = self.table
        root = np.linalg.inv(
            np.linalg.cholesky(np.diag(np.maximum(self.own, _LEAST_OWN) ** 2) + table @ table.T)
        )
        svd = decomposed(root @ self.rows)
        half, left = svd.root()
        turned = (gradients / svd.length) @ svd.rows.T
        needed = np.abs(turned[:, svd.lost]) > 1e-6 * np.linalg.norm(turned, axis=1)[:, None]
        along = gradients @ half
        shared, total = along @ (left.T @ root @ table), np.linalg.norm(along, axis=1)
        return np.where(needed.any(axis=1), np.inf, total), shared


class Exchange:
    """A criterion on a choice of candidates: values of plans, and of all exchanges of one condition.

    It is made of the covariance of generalised least squares, as a fit has it: errors that means share stand beside
    the parameters, each with a prior variance of one, and a mean is one row (g, shares)/own of both.
    """

    def __init__(
        self,
        candidates: Evidence,
        known: Evidence,
        targets: FloatArray,
        *,
        balance: float = BALANCE,
    ) -> None:
        """Turn to coordinates in which candidates and prior knowledge have unit size; the order of plans stays."""
        both = known.joined(candidates)
        n_known, length = len(known.rows), np.linalg.norm(both.rows, axis=0)
        triangle = np.linalg.qr(both.rows / length, mode="r") / np.sqrt(len(candidates.rows))
        turn = np.linalg.inv(triangle) / length[:, None]
        self.q, errors = len(turn), both.table
        whole = np.hstack([both.rows @ turn, errors]) / np.maximum(both.own, _LEAST_OWN)[:, None]
        self.known, self.rows = whole[:n_known], whole[n_known:]
        self.targets = np.hstack([targets @ turn, np.zeros((len(targets), errors.shape[1]))])
        self.prior = np.diag(np.append(np.zeros(self.q), np.ones(errors.shape[1])))
        self.balance = balance

    def _information(self, plan: IntArray) -> FloatArray:
        """Return the information of a plan and of prior knowledge, on parameters and errors together."""
        rows = np.concatenate([self.known, self.rows[plan]])
        M = rows.T @ rows
        return np.asarray(M + self.prior + max(1.0, float(np.trace(M))) * _RIDGE * np.eye(len(M)))

    def _criterion(self, log_det: npt.ArrayLike, variance: npt.ArrayLike) -> FloatArray:
        """Return the criterion to minimise, from ln det V and the sum of the targets' variances."""
        mean = np.maximum(variance, _TINY) / len(self.targets)
        return np.asarray(np.log(mean) + self.balance * np.asarray(log_det) / self.q)

    def value(self, plan: IntArray) -> float:
        """Return the criterion of a plan."""
        M, q = self._information(plan), self.q
        log_det = np.linalg.slogdet(M[q:, q:])[1] - np.linalg.slogdet(M)[1]
        variance = float((self.targets * np.linalg.solve(M, self.targets.T).T).sum())
        return float(self._criterion(log_det, variance))

    def with_each(self, rest: IntArray) -> FloatArray:
        """Return the criterion of a plan with each candidate added in turn, shape (N,): an update of rank one each."""
        M, q, rows, dots = self._information(rest), self.q, self.rows, partial(np.einsum, "ni,ni->n")
        inverse, errors = np.linalg.inv(M), rows[:, q:]
        more = 1.0 + np.maximum(dots(rows @ inverse, rows), 0.0)
        by_error = 1.0 + np.maximum(dots(errors @ np.linalg.inv(M[q:, q:]), errors), 0.0)
        log_det = np.linalg.slogdet(M[q:, q:])[1] - np.linalg.slogdet(M)[1] + np.log(by_error) - np.log(more)
        less = rows @ inverse @ self.targets.T
        before = float(np.einsum("ti,ij,tj->", self.targets, inverse, self.targets))
        return self._criterion(log_det, before - (less**2).sum(axis=1) / more)

    def improved(self, plan: IntArray) -> IntArray:
        """Return a plan that no exchange of a single condition improves, sorted."""
        current = self.value(plan)
        for _ in range(_MAX_PASSES):
            before = current
            for place in range(plan.size):
                rest = np.delete(plan, place)
                values = self.with_each(rest)
                values[rest] = np.inf  # a condition set up twice is one condition with more repeats
                best = int(np.argmin(values))
                # The values of exchanges carry the rounding of an inverse; only the plan's own value decides.
                changed = np.append(rest, best)
                value = self.value(changed)
                if value < current - _WORTHWHILE:
                    plan, current = changed, value
            if before - current < _WORTHWHILE:
                break
        return np.sort(plan)

    def greedy(self, n: int) -> IntArray:
        """Return n candidates taken one by one, each the best of its turn."""
        plan = np.zeros(0, dtype=np.int64)
        for _ in range(n):
            values = self.with_each(plan)
            values[plan] = np.inf
            plan = np.append(plan, int(np.argmin(values)))
        return plan


def best_plan(exchange: Exchange, n: int, *, starts: int = 10) -> IntArray:
    """Return the best plan of n different candidates from several starts.

    The first start takes the best candidate one by one; the others are drawn at random, always the same.
    """
    rng = np.random.default_rng(0)
    drawn = (rng.choice(len(exchange.rows), size=n, replace=False) for _ in range(starts - 1))
    return min((exchange.improved(plan) for plan in (exchange.greedy(n), *drawn)), key=exchange.value)
