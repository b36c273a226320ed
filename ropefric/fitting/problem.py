"""How a fit is to be made, its least-squares problem in ln F_A, and its data as a search needs them.

Repeats of a condition share the model's answer f, so Σ w (y − f)² = W (ȳ − f)² + Σ w (y − ȳ)² exactly. A law
is therefore evaluated once per condition and not once per trial, however many repeats there are. A robust loss
weighs each trial by its own residual, so there the trials stay as they are.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from numbers import Integral
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray, IntArray
from ropefric.errors import InputError, UnknownNameError
from ropefric.friction.condition import SETTINGS, Conditions
from ropefric.friction.law import FrictionLaw
from ropefric.friction.laws import ALL_LAWS
from ropefric.registry import did_you_mean

Rows = npt.NDArray[np.intp]
_Three = tuple[FloatArray, FloatArray, FloatArray]
Loss = Literal["linear", "soft_l1", "huber", "cauchy", "arctan"]

LOSSES: dict[Loss, Callable[[FloatArray], tuple[FloatArray, FloatArray]]] = {
    "linear": lambda z: (z, np.ones_like(z)),
    "soft_l1": lambda z: (2.0 * (np.sqrt(1.0 + z) - 1.0), 1.0 / np.sqrt(1.0 + z)),
    "huber": lambda z: (np.where(z <= 1.0, z, 2.0 * np.sqrt(z) - 1.0), 1.0 / np.sqrt(np.maximum(z, 1.0))),
    "cauchy": lambda z: (np.log1p(z), 1.0 / (1.0 + z)),
    "arctan": lambda z: (np.arctan(z), 1.0 / (1.0 + z**2)),
}
"""Losses of squared residuals in standard deviations: cost, and the weight left to each; the first is χ²."""

MANY = 2000
"""From so many trials on, the repeats of a condition are put together before a law is resampled."""

# Starts of a search; beyond some hundreds nothing new is found.
_MOST_STARTS = 10_000
# Sets times conditions evaluated in one go: the temporaries of a law then stay in the processor's cache.
_BLOCK = 16384


@dataclass(frozen=True, slots=True, kw_only=True)
class FitSettings:
    """How a fit is made.

    Attributes
    ----------
    fixed, bounds, start : mapping of parameter name to a value, or to (lower, upper)
        What is held, where the search may go, and where it begins.
    scale_covar : "auto" or bool
        Whether the covariance is multiplied by χ²/dof, because the scatter is not known beforehand.
    loss : str
        How much an outlier may pull, see `LOSSES`.
    clustered : bool
        Whether the errors hold what the repeats of a condition share.
    n_starts, seed : int
        Starts of the search, and of the random numbers that spread them.
    of : {"peak", "kinetic"}
        The force that is fitted.
    """

    fixed: Mapping[str, float] = field(default_factory=dict)
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    start: Mapping[str, float] = field(default_factory=dict)
    scale_covar: Literal["auto"] | bool = "auto"
    loss: Loss = "linear"
    clustered: bool = True
    n_starts: int = 4
    seed: int = 0
    of: str = "peak"


def law_named(law: object) -> FrictionLaw:
    """Return a law by its name, or the law itself; refuse what is neither."""
    if isinstance(law, FrictionLaw):
        return law
    if not isinstance(law, str):
        text = f"law is {law!r:.60}, a {type(law).__name__}, and neither the name of a friction law nor a law"
        raise InputError(text, key="law", fix=f"give a name such as {', '.join([*ALL_LAWS][:3])}")
    return ALL_LAWS[law]


def check_settings(settings: FitSettings, law: FrictionLaw) -> None:
    """Refuse settings that no fit of this law can follow; return quietly otherwise."""
    for key in ("fixed", "start", "bounds"):
        _check_values(key, getattr(settings, key), law)
    for name, (low, high) in settings.bounds.items():
        if not low < high:
            text = f"the bounds of {name}, {low:g} … {high:g}, leave nothing between them"
            fix = "give (lower, upper), or fix the parameter"
            raise InputError(text, code="RF402", key="bounds", fix=fix)
    if settings.loss not in tuple(LOSSES):
        fix = did_you_mean(str(settings.loss), LOSSES)
        raise UnknownNameError(f"unknown loss {settings.loss!r}", key="loss", fix=fix)
    if settings.scale_covar not in ("auto", True, False):
        text = f"{settings.scale_covar!r} is no setting"
        raise InputError(text, key="scale_covar", fix="use 'auto', True or False")
    for key, least, most, why in (
        ("n_starts", 1, _MOST_STARTS, "a search needs at least one start"),
        ("seed", 0, 2**63, "a seed is a whole number of at least 0"),
    ):
        value = getattr(settings, key)
        if isinstance(value, bool) or not isinstance(value, Integral) or not least <= int(value) <= most:
            raise InputError(f"{key} is {value!r:.40}; {why} and at most {most}", key=key)


def _check_values(key: str, given: Mapping[str, Any], law: FrictionLaw) -> None:
    for name, value in given.items():
        if name not in law.parameter_names:
            fix = did_you_mean(str(name), law.parameter_names)
            raise UnknownNameError(f"{law.name} has no parameter {name!r}", key=key, fix=fix)
        if key == "bounds" and np.shape(value) != (2,):
            what = "(lower, upper)"
            raise InputError(f"{name} is given as {value!r:.40}, not as {what}", key=key, fix=f"give {what}")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FitProblem:
    """Measured ln F_A, the law to fit, and what is known about both.

    The scatter of break-away forces is multiplicative, so ln F_A is fitted by weighted least squares through the
    wrap integral (rope_wheel §5); nothing is ever differentiated numerically from data.
    """

    law: FrictionLaw
    conditions: Conditions
    log_lift: FloatArray
    std: FloatArray
    group: IntArray
    start: FloatArray
    lower: FloatArray
    upper: FloatArray
    vary: BoolArray

    @classmethod
    def plain(
        cls,
        law: FrictionLaw,
        conditions: Conditions,
        log_lift: FloatArray,
        std: float | FloatArray = 1.0,
        start: npt.ArrayLike | None = None,
    ) -> "FitProblem":
        """Return data at conditions of their own as the problem to fit a law with what it declares itself."""
        declared = [item.start for item in law.parameters]
        return cls(
            law=law, conditions=conditions, log_lift=log_lift, std=np.full(log_lift.size, std),
            group=np.arange(log_lift.size), start=np.array(declared if start is None else start, np.float64),
            lower=law.lower, upper=law.upper, vary=np.array([not item.fixed for item in law.parameters]),
        )  # fmt: skip

    @property
    def n_points(self) -> int:
        """Return the number of points n."""
        return int(self.log_lift.size)

    @property
    def n_conditions(self) -> int:
        """Return the number of conditions, however often each was repeated."""
        return int(self.group.max(initial=-1)) + 1

    @property
    def n_varying(self) -> int:
        """Return the number of fitted parameters."""
        return int(np.count_nonzero(self.vary))

    def residuals(self, theta: FloatArray) -> FloatArray:
        """Return (model − measured)/std: shape (n,) for theta of shape (p,), (m, n) for (m, p)."""
        return (self.law.log_lift(theta, self.conditions) - self.log_lift) / self.std

    def jacobian(self, theta: FloatArray) -> FloatArray:
        """Return the derivatives of the residuals by all p parameters, shape (n, p) or (m, n, p)."""
        return self.law.jacobian(theta, self.conditions) / self.std[:, None]

    def residuals_and_jacobian(self, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return `residuals` and `jacobian`, the law evaluated once for both."""
        log_lift, slopes = self.law.log_lift_and_jacobian(theta, self.conditions)
        return (log_lift - self.log_lift) / self.std, slopes / self.std[:, None]


@dataclass(frozen=True, slots=True, eq=False)
class Reduced:
    """Data sets of one plan of conditions, seen through a law."""

    law: FrictionLaw
    conditions: Conditions
    weight: FloatArray
    mean: FloatArray
    rest: FloatArray
    loss: Loss = "linear"

    @property
    def signal(self) -> FloatArray:
        """Return the weighted sum of squares of the means, shape (1,) or (m,): rounding errors scale with it."""
        return np.asarray((self.weight * self.mean**2).sum(axis=-1))

    def chi2(self, theta: FloatArray, rows: Rows | None = None) -> FloatArray:
        """Return the weighted sums of squares, infinite where the law has no answer."""
        chosen = np.zeros(len(theta), dtype=np.intp) if rows is None else rows
        chi2, shape = np.empty(len(theta)), self.weight.shape[1:]

        def lift(asked: FloatArray, conditions: Conditions) -> list[FloatArray]:
            return [self.law.log_lift(asked, conditions)]

        for part in self._blocks(len(theta)):
            (values,), has_answer = _each(lift, theta[part], self.conditions, shape)
            chi2[part] = self._misfit(values, has_answer, chosen[part])[0]
        return chi2

    def evaluate(self, theta: FloatArray, rows: Rows, limit: FloatArray) -> _Three:
        """Return χ², JᵀWJ and JᵀW(y − f) of parameter sets."""
        (r, p), k = theta.shape, len(self.conditions)
        chi2, normal, downhill = np.empty(r), np.zeros((r, p, p)), np.zeros((r, p))
        both = self.law.log_lift_and_jacobian
        (plain,), (sloped,) = (limit < 0.0).nonzero(), (limit >= 0.0).nonzero()
        if plain.size:
            chi2[plain] = self.chi2(theta[plain], rows[plain])
        for part in self._blocks(sloped.size):
            at = sloped[part]
            (values, J), has_answer = _each(both, theta[at], self.conditions, (k,), (k, p))
            chi2[at], residual, weight = self._misfit(values, has_answer, rows[at])
            (good,) = (np.isfinite(chi2[at]) & (chi2[at] <= limit[at])).nonzero()
            if good.size < at.size:
                at, J, residual, weight = at[good], J[good], residual[good], _row(weight, good)
            weighted = J.swapaxes(1, 2) * weight[:, np.newaxis, :]
            normal[at] = weighted @ J
            downhill[at] = (weighted @ residual[:, :, np.newaxis])[..., 0]
        return chi2, normal, downhill

    def evaluate_shared(self, theta: FloatArray, m: int) -> _Three | None:
        """Return the same as `evaluate` for all m data sets at one parameter set of shape (p,), or None.

        The law is evaluated once, so this costs next to nothing; None where it has no answer, or the loss is robust.
        """
        p = theta.size
        if self.loss != "linear":
            return None
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

    def _misfit(self, values: FloatArray, has_answer: BoolArray, rows: Rows) -> _Three:
        """Return the cost, the residuals and the weights of their squares."""
        residual, weight = _row(self.mean, rows) - values, _row(self.weight, rows)
        # A law may answer with 1e300, which no square can hold: such a set is no candidate.
        with np.errstate(over="ignore", invalid="ignore"):
            if self.loss == "linear":
                chi2 = np.einsum("rk,rk->r", weight * residual, residual) + _row(self.rest, rows)
            else:
                cost, left = LOSSES[self.loss](weight * residual**2)
                chi2, weight = cost.sum(axis=1), weight * left
        return np.where(has_answer & ~np.isnan(chi2), chi2, np.inf), residual, weight

    def _blocks(self, r: int) -> Iterator[slice]:
        size = max(1, _BLOCK // max(1, len(self.conditions)))
        return (slice(first, min(first + size, r)) for first in range(0, r, size))


def reduced(
    problem: FitProblem,
    log_lift: npt.ArrayLike | None = None,
    multiplicity: npt.ArrayLike | None = None,
    *,
    loss: Loss = "linear",
) -> Reduced:
    """Return the data of a problem, or m data sets at its conditions, by distinct condition.

    Shapes (n,) or (m, n): measured ln F_A, and how often each point counts in each data set.
    """
    y = np.atleast_2d(np.asarray(problem.log_lift if log_lift is None else log_lift, np.float64))
    count = np.atleast_2d(np.asarray(1.0 if multiplicity is None else multiplicity, np.float64))
    order, starts = _distinct(problem.conditions)
    repeated = starts.size < order.size and loss == "linear"
    if not repeated:
        # Nothing to put together, so the points stay as they are.
        order = starts = np.arange(order.size)
    w, y = (count / problem.std**2)[:, order], y[:, order]
    weight = np.add.reduceat(w, starts, axis=1)
    safe = np.where(weight > 0.0, weight, 1.0)
    # Sums about a point near the data keep the digits that sums of the data themselves would cancel.
    reference = y[:, starts]
    sizes = np.diff(np.append(starts, order.size))
    mean = reference + np.add.reduceat(w * (y - np.repeat(reference, sizes, axis=1)), starts, axis=1) / safe
    conditions = problem.conditions.select(order[starts]) if repeated else problem.conditions
    rest = (w * (y - np.repeat(mean, sizes, axis=1)) ** 2).sum(axis=1)
    return Reduced(problem.law, conditions, weight, mean, rest, loss)


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


def _distinct(conditions: Conditions) -> tuple[Rows, Rows]:
    """Return an order that puts repeats side by side, and where in it each distinct condition begins."""
    columns = [getattr(conditions, name) for name in SETTINGS]
    order = np.lexsort(columns)
    new = np.ones(order.size, dtype=np.bool_)
    new[1:] = np.any([column[order[1:]] != column[order[:-1]] for column in columns], axis=0)
    return order, np.flatnonzero(new)


def typical_mu(conditions: Conditions, log_lift: FloatArray) -> float:
    """Return the median of the average coefficients ln(F_A/F_B)/φ, which one bad condition cannot move far."""
    rise = log_lift - conditions.log_end_tension
    return float(np.median(rise / np.maximum(conditions.wrap_angle_rad, 1e-9)))


def _row(array: FloatArray, rows: Rows) -> FloatArray:
    """Return the rows of an array that may stand for all data sets with its only one."""
    return array if len(array) == 1 else array[rows]


def _each(
    question: Callable[[FloatArray, Conditions], Sequence[FloatArray]],
    theta: FloatArray,
    conditions: Conditions,
    *shapes: tuple[int, ...],
) -> tuple[Sequence[FloatArray], BoolArray]:
    """Return the answers of a law, of these shapes a set, and which sets have them; the others' are zero."""
    has_answer = np.ones(len(theta), dtype=np.bool_)
    try:
        # Nearly always all sets have an answer, so it is asked for before it is asked about.
        return question(theta, conditions), has_answer
    except InputError:
        tables = [np.zeros((len(theta), *shape)) for shape in shapes]
    for i, one in enumerate(theta):
        try:
            for table, answer in zip(tables, question(one, conditions), strict=True):
                table[i] = answer
        except InputError:
            has_answer[i] = False
    return tables, has_answer
