"""The search for a best plan: exchange of conditions against candidates until no exchange helps (Fedorov 1972)."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ropefric.arrays import FloatArray, IntArray

Criterion = Literal["v", "d"]

BALANCE = 0.3
"""Weight of the parameters' ellipsoid in a plan for a prediction [-]; it costs that prediction a few per cent."""

# Keeps the inverse finite while a plan of few conditions has one taken out; a whitened plan has eigenvalues near 1.
_RIDGE = 1e-13
_TINY = float(np.finfo(np.float64).tiny)
_WORTHWHILE = 1e-9
_MAX_PASSES = 100
# Half a per cent of a standard error.
_AS_GOOD = 0.01


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Whitened:
    """A choice of rows, in coordinates in which all candidates and what is known are of even size."""

    rows: FloatArray
    known: FloatArray
    targets: FloatArray

    @classmethod
    def of(cls, rows: FloatArray, known: FloatArray, targets: FloatArray) -> "Whitened":
        """Return candidates, known rows and targets in such coordinates; both criteria keep their order in them."""
        length = np.linalg.norm(np.vstack([rows, known]), axis=0)
        triangle = np.linalg.qr(np.vstack([rows, known]) / length, mode="r") / np.sqrt(len(rows))
        turn = np.linalg.inv(triangle) / length[:, None]
        old = known @ turn
        return cls(rows=rows @ turn, known=old.T @ old, targets=targets @ turn)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Exchange:
    """A criterion on a whitened choice: values of plans, and of all exchanges of one condition."""

    choice: Whitened
    criterion: Criterion
    balance: float = BALANCE

    def information(self, plan: IntArray) -> FloatArray:
        """Return the information matrix of a plan with what is known, shape (q, q)."""
        rows = self.choice.rows[plan]
        return np.asarray(rows.T @ rows + self.choice.known + _RIDGE * np.eye(rows.shape[1]))

    def value(self, plan: IntArray) -> float:
        """Return the criterion of a plan."""
        information = self.information(plan)
        log_det = float(np.linalg.slogdet(information)[1])
        if self.criterion == "d":
            return -log_det
        targets = self.choice.targets
        variance = np.einsum("ti,it->", targets, np.linalg.solve(information, targets.T)) / len(targets)
        return float(np.log(max(variance, _TINY))) - self.balance * log_det / len(information)

    def with_each(self, rest: IntArray) -> FloatArray:
        """Return the criterion of a plan with each candidate added in turn, shape (N,)."""
        information = self.information(rest)
        inverse, rows = np.linalg.inv(information), self.choice.rows
        leverage = np.maximum(np.einsum("ni,ij,nj->n", rows, inverse, rows), 0.0)
        log_det = float(np.linalg.slogdet(information)[1]) + np.log1p(leverage)
        if self.criterion == "d":
            return np.asarray(-log_det)
        targets = self.choice.targets
        gained = ((rows @ inverse @ targets.T) ** 2).sum(axis=1) / (1.0 + leverage)
        left = np.einsum("ti,ij,tj->", targets, inverse, targets) - gained
        variance = np.log(np.maximum(left, _TINY) / len(targets))
        return np.asarray(variance - self.balance * log_det / len(information))

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


def best_plan(
    choice: Whitened, n: int, *, criterion: Criterion, starts: int = 10, seed: int = 0
) -> tuple[IntArray, int]:
    """Return the best plan of n different candidates from several starts, and how many starts found it.

    The first start takes the best candidate one by one; the others are drawn at random. The same arguments give the
    same plan.
    """
    exchange, rng = Exchange(choice=choice, criterion=criterion), np.random.default_rng(seed)
    first = [exchange.greedy(n)]
    first += [rng.choice(len(choice.rows), size=n, replace=False) for _ in range(max(starts - 1, 0))]
    found = [exchange.improved(plan) for plan in first]
    values = np.array([exchange.value(plan) for plan in found])
    best = int(np.argmin(values))
    return found[best], int(np.count_nonzero(values <= values[best] + _AS_GOOD))
