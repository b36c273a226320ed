"""How a fit is to be made, its least-squares problem in ln F_A, and the engine that solves thousands of these at once.

Repeats of a condition share the model's answer f, so Σ w (y − f)² = W (ȳ − f)² + Σ w (y − ȳ)² exactly. A law
is therefore evaluated once per condition and not once per trial, however many repeats there are. Points that share
errors have a matrix `root` with rootᵀ root = V⁻¹ in the place of their standard deviations.

`batched_fit`, Levenberg-Marquardt inside bounds with the analytic Jacobian of the law, is the one engine of every fit:
of a law from several starts, of profiles, of laws on condition means.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Integral
from typing import NamedTuple

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
        Fixed values, limits and start of the search.
    groups : tuple of str, optional
        Columns of the table whose levels may differ in μ: ropes, mountings, operators. All such by default.
    shared : mapping of str to str
        By what a stated error is shared: "wrap" by the "rig", the "wheel", equal "setting"s or a column of the table.
        Only the part that is the cell's by its name is, unless it is said; all else shows in the scatter.
    n_starts, seed : int
        Starts of the search, and of the random numbers that spread them.
    of : {"peak", "kinetic"}
        The force that is fitted.
    """

    fixed: Mapping[str, float] = field(default_factory=dict)
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    start: Mapping[str, float] = field(default_factory=dict)
    groups: tuple[str, ...] | None = None
    shared: Mapping[str, str] = field(default_factory=lambda: {"cell": "cell"})
    n_starts: int = 4
    seed: int = 0
    of: str = "peak"


def law_named(law: object) -> FrictionLaw:
    """Return a law by its name, or the law itself; refuse anything else."""
    if isinstance(law, FrictionLaw):
        return law
    if not isinstance(law, str):
        text = f"law is {law!r:.60}, a {type(law).__name__}, and neither the name of a friction law nor a law"
        raise InputError(text, key="law", fix=f"give a name such as {', '.join([*ALL_LAWS][:3])}")
    return ALL_LAWS[law]


def check_settings(settings: FitSettings, law: FrictionLaw) -> None:
    """Refuse settings that no fit of this law can follow; return quietly otherwise."""
    for key in ("fixed", "start", "bounds"):
        for name, value in getattr(settings, key).items():
            if name not in law.parameter_names:
                fix = did_you_mean(str(name), law.parameter_names)
                raise UnknownNameError(f"{law.name} has no parameter {name!r}", key=key, fix=fix)
            if key == "bounds" and np.shape(value) != (2,):
                text = f"{name} is given as {value!r:.40}, not as (lower, upper)"
                raise InputError(text, key=key, fix="give (lower, upper)")
            if key == "bounds" and not value[0] < value[1]:
                text = f"the bounds of {name}, {value[0]:g} … {value[1]:g}, leave nothing between them"
                fix = "give (lower, upper), or fix the parameter"
                raise InputError(text, code="RF402", key="bounds", fix=fix)
    for key, least, most, why in (
        ("n_starts", 1, _MOST_STARTS, "a search needs at least one start"),
        ("seed", 0, 2**63, "a seed is a whole number of at least 0"),
    ):
        value = getattr(settings, key)
        if isinstance(value, bool) or not isinstance(value, Integral) or not least <= int(value) <= most:
            raise InputError(f"{key} is {value!r:.40}; {why} and at most {most}", key=key)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FitProblem:
    """Measured ln F_A, the law to fit, and the settings and uncertainties of both.

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
    root: FloatArray | None = None

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
        return self.whitened(self.law.log_lift(theta, self.conditions) - self.log_lift)

    def jacobian(self, theta: FloatArray) -> FloatArray:
        """Return the derivatives of the residuals by all p parameters, shape (n, p) or (m, n, p)."""
        return self._whitened_slopes(self.law.jacobian(theta, self.conditions))

    def residuals_and_jacobian(self, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return `residuals` and `jacobian`, the law evaluated once for both."""
        log_lift, slopes = self.law.log_lift_and_jacobian(theta, self.conditions)
        return self.whitened(log_lift - self.log_lift), self._whitened_slopes(slopes)

    def _whitened_slopes(self, slopes: FloatArray) -> FloatArray:
        return self.whitened(slopes.swapaxes(-1, -2)).swapaxes(-1, -2)

    def whitened(self, values: FloatArray) -> FloatArray:
        """Return values (…, n) in standard deviations, or as combinations of them that share no error."""
        return values / self.std if self.root is None else values @ self.root.T

    def unwhitened(self, values: FloatArray) -> FloatArray:
        """Return the values (n,) that `whitened` turns into these."""
        return np.asarray(values * self.std if self.root is None else np.linalg.solve(self.root, values))


class Reduced(NamedTuple):
    """Data sets of one plan of conditions, seen through a law."""

    law: FrictionLaw
    conditions: Conditions
    weight: FloatArray
    mean: FloatArray
    rest: FloatArray
    root: FloatArray | None = None

    @property
    def signal(self) -> FloatArray:
        """Return the weighted sum of squares of the means, shape (1,) or (m,): rounding errors scale with it."""
        return np.asarray((self.weight * self._turned(self.mean) ** 2).sum(axis=-1))

    def _turned(self, values: FloatArray) -> FloatArray:
        """Return values (…, k) as combinations that share no error."""
        return values if self.root is None else values @ self.root.T

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
            J = J if self.root is None else self.root @ J
            chi2[at], residual, weight = self._misfit(values, has_answer, rows[at])
            (good,) = (np.isfinite(chi2[at]) & (chi2[at] <= limit[at])).nonzero()
            if good.size < at.size:
                at, J, residual, weight = at[good], J[good], residual[good], _row(weight, good)
            weighted = J.swapaxes(1, 2) * weight[:, np.newaxis, :]
            normal[at] = weighted @ J
            downhill[at] = (weighted @ residual[:, :, np.newaxis])[..., 0]
        return chi2, normal, downhill

    def _misfit(self, values: FloatArray, has_answer: BoolArray, rows: Rows) -> _Three:
        """Return the cost, the residuals and the weights of their squares."""
        residual, weight = self._turned(_row(self.mean, rows) - values), _row(self.weight, rows)
        # A law may answer with 1e300, which no square can hold: such a set is no candidate.
        with np.errstate(over="ignore", invalid="ignore"):
            chi2 = np.einsum("rk,rk->r", weight * residual, residual) + _row(self.rest, rows)
        return np.where(has_answer & ~np.isnan(chi2), chi2, np.inf), residual, weight

    def _blocks(self, r: int) -> Iterator[slice]:
        size = max(1, _BLOCK // max(1, len(self.conditions)))
        return (slice(first, min(first + size, r)) for first in range(0, r, size))


def reduced(
    problem: FitProblem,
    log_lift: npt.ArrayLike | None = None,
    multiplicity: npt.ArrayLike | None = None,
) -> Reduced:
    """Return the data of a problem, or m data sets at its conditions, by distinct condition.

    Shapes (n,) or (m, n): measured ln F_A, and how often each point counts in each data set.
    """
    y = np.atleast_2d(np.asarray(problem.log_lift if log_lift is None else log_lift, np.float64))
    count = np.atleast_2d(np.asarray(1.0 if multiplicity is None else multiplicity, np.float64))
    if problem.root is not None:
        weight = count * np.ones(problem.n_points)
        return Reduced(problem.law, problem.conditions, weight, y, np.zeros(1), problem.root)
    order, starts = distinct_conditions(problem.conditions)
    repeated = starts.size < order.size
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
    return Reduced(problem.law, conditions, weight, mean, rest)


def distinct_conditions(conditions: Conditions) -> tuple[Rows, Rows]:
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


# ---- the engine ----

_EPS = float(np.finfo(np.float64).eps)
_FIRST_DAMPING = 1e-4
_NO_DAMPING = 1e-9
_RAISE = 6.0
_LOWER = 0.2
# A step no shorter than this part (of its square) of the one before: Gauss-Newton creeps or swings.
_SLOW = 0.1
_CAUTION = 20.0
_HOPELESS_DAMPING = 1e14
# ln F_A from a closed form carries an error of this relative size, so a step that moves it less is rounding.
_MODEL_ROUNDING = 1e-14
# Keeps the scaled normal equations invertible where the data do not see a direction at all.
_RIDGE = 1e-13
# Near the smallest floats a square is held only in part.
_NOTHING = 1e-280
# A scaled gradient below this is rounding.
_PUSH = 1e-12
# A secant update divides by vᵀs; where that nearly vanishes it says nothing.
_SKIP = 1e-8
# The least part of JᵀJ that must remain in every direction.
_REMAINS = 0.05
_POSITIVE = 1e-11


def batched_fit(
    problem: FitProblem,
    log_lift: npt.ArrayLike | None = None,
    starts: npt.ArrayLike | None = None,
    *,
    multiplicity: npt.ArrayLike | None = None,
    vary: npt.ArrayLike | None = None,
    tolerance: float = 1e-9,
    max_iterations: int = 300,
) -> "BatchFit":
    """Return the bounded least-squares fits of m data sets, all iterated together.

    Marquardt's damping, relative to the diagonal of JᵀWJ, belongs to each data set by itself and starts at zero:
    the first steps are plain Gauss-Newton, and only a step that fails is damped. Bounds are held by an active set
    (`bounded_steps`). Data sets that are done leave the batch. Repeats of a condition are summed first, so the law
    is evaluated once per distinct condition.
    """
    data = reduced(problem, log_lift, multiplicity)
    theta = np.atleast_2d(np.asarray(problem.start if starts is None else starts, dtype=np.float64))
    free = np.atleast_2d(np.asarray(problem.vary if vary is None else vary, dtype=np.bool_))
    shape = np.broadcast_shapes(data.rest[:, np.newaxis].shape, theta.shape, free.shape)
    free = np.broadcast_to(free, shape)
    theta = np.where(free, np.clip(theta, problem.lower, problem.upper), theta)
    fits = BatchFit(data, problem, theta, free)
    fits.n_iterations = fits.run(tolerance, max_iterations)
    return fits


class BatchFit:
    """Least-squares fits of m data sets, on their way and found: `theta`, `chi2`, `converged`; one row a data set."""

    n_iterations = 0

    def __init__(self, data: Reduced, problem: FitProblem, theta: FloatArray, vary: BoolArray) -> None:
        """Evaluate the starts; where the law has no answer, try the problem's own start."""
        self.data, self.problem, self.theta, self.vary = data, problem, theta, vary
        m, nowhere = len(theta), np.full(len(theta), np.inf)
        found = data.evaluate(theta, np.arange(m), nowhere)
        if (lost := np.flatnonzero(~np.isfinite(found[0]))).size:
            theta[lost] = np.where(vary[lost], problem.start, theta[lost])
            for whole, again in zip(found, data.evaluate(theta[lost], lost, nowhere[lost]), strict=True):
                whole[lost] = again
        self.chi2, self.normal, self.downhill = found
        self.curvature, self.curved = np.zeros_like(self.normal), False
        self.damping, self.last_length2 = np.zeros(m), nowhere
        self.slow = np.zeros(m, dtype=np.bool_)
        self.converged = np.zeros(m, dtype=np.bool_)
        self.alive = np.isfinite(self.chi2)

    def run(self, tolerance: float, max_iterations: int) -> int:
        """Step until no data set is left; return the number of steps."""
        signal = np.broadcast_to(self.data.signal, self.chi2.shape)
        for count in range(max_iterations):
            # Cheaper calls than the plain ones throughout: in a single fit they weigh as much as the law.
            rows = self.alive.nonzero()[0]
            if not rows.size:
                return count
            n, damping = rows.size, self.damping[rows]
            damped = damping.nonzero()[0]
            # The plain steps, which tell whether a search is done, and in the same call those that are damped.
            steps, lengths2 = self._propose(
                np.append(rows, rows[damped]), np.append(np.zeros(n), damping[damped])
            )
            step, length2 = steps[:n], lengths2[:n]
            chi2, loudness, last2 = self.chi2[rows], signal[rows], self.last_length2[rows]
            slow = self.slow[rows]
            enough2 = tolerance**2 * chi2 / self.problem.n_points + _MODEL_ROUNDING**2 * loudness
            # χ² cannot resolve steps shorter than its own rounding: they are taken as they come, until they no
            # longer shrink.
            blur = _EPS * (64.0 * chi2 + 4.0 * np.sqrt(chi2 * loudness))
            blind = length2 <= blur
            done = (length2 <= enough2) | (blind & (length2 > 0.25 * last2))
            rate = length2 / last2
            # At this rate the step after this one would be too short to take: no slope is needed any more.
            final = ~slow & (rate > 0.0) & (rate < _SLOW) & (_CAUTION * rate * length2 <= enough2)
            self.slow[rows] = slow | (rate > _SLOW)
            self.last_length2[rows] = length2
            use = (~blind & ~done)[damped]
            step[damped[use]], length2[damped[use]] = steps[n:][use], lengths2[n:][use]
            final[damped[use]] = False
            slack = np.where(blind, 4.0 * blur, 0.0)
            if np.count_nonzero(done):
                self.converged[rows[done]] = True
                self.alive[rows[done]] = False
                left = ~done
                rows, step, length2 = rows[left], step[left], length2[left]
                slack, final = slack[left], final[left]
            if rows.size:
                self._try(rows, step, length2, slack, final)
        return max_iterations

    def _propose(self, rows: Rows, damping: FloatArray) -> tuple[FloatArray, FloatArray]:
        theta = self.theta[rows]
        return bounded_steps(
            self.normal[rows],
            self.downhill[rows],
            curvature=self.curvature[rows],
            low=np.minimum(self.problem.lower - theta, 0.0),
            high=np.maximum(self.problem.upper - theta, 0.0),
            vary=self.vary[rows],
            damping=damping,
        )

    def _try(
        self, rows: Rows, step: FloatArray, length2: FloatArray, slack: FloatArray, final: BoolArray
    ) -> None:
        """Take the steps that lower χ² (or keep it within a slack), and learn from how well that was foretold."""
        theta, old, damping = self.theta[rows], self.chi2[rows], self.damping[rows]
        inside = np.minimum(np.maximum(theta + step, self.problem.lower), self.problem.upper)
        trial = np.where(self.vary[rows], inside, theta)
        limit = np.where(slack > 0.0, old + slack, np.nextafter(old, 0.0))
        chi2, normal, downhill = self.data.evaluate(trial, rows, np.where(final, -1.0, limit))
        better = chi2 <= limit
        all_better = np.count_nonzero(better) == better.size
        # Undamped steps that succeed stay undamped, whatever they gained.
        if np.count_nonzero(damping) or not all_better:
            bend = np.einsum("mi,mi->m", np.einsum("mij,mj->mi", self.curvature[rows], step), step)
            foretold = 2.0 * np.einsum("mi,mi->m", step, self.downhill[rows]) - length2 - bend
            gain = (old - np.where(better, chi2, old)) / np.where(foretold > 0.0, foretold, np.inf)
            gain = np.where(slack > 0.0, 1.0, gain)
            # Damp more after a step that failed or gained little of what was foretold, less after a good one.
            raised = np.where(damping > 0.0, _RAISE * damping, _FIRST_DAMPING)
            lowered = np.where(damping > _NO_DAMPING, damping * _LOWER, 0.0)
            new = np.where(gain > 0.75, lowered, np.where(gain < 0.25, 2.0 * damping, damping))
            self.damping[rows] = np.where(better, new, raised)
            self.alive[rows[raised > _HOPELESS_DAMPING]] = False
        # Learn the model's curvature where Gauss-Newton alone is slow; forget it where a step failed.
        if self.curved:
            self.curvature[rows[~better]] = 0.0
        use = better & ~final & self.slow[rows]
        if np.count_nonzero(use):
            self.curved, taken = True, rows[use]
            change = self.downhill[taken] - downhill[use]
            self.curvature[taken] = _learnt(self.curvature[taken], normal[use], step[use], change)
        arrived = rows[better & final]
        if not all_better:
            rows, trial, chi2 = rows[better], trial[better], chi2[better]
            normal, downhill = normal[better], downhill[better]
        self.theta[rows], self.chi2[rows] = trial, chi2
        self.normal[rows], self.downhill[rows] = normal, downhill
        self.converged[arrived] = True
        self.alive[arrived] = False


def bounded_steps(
    normal: FloatArray,
    downhill: FloatArray,
    *,
    curvature: FloatArray,
    low: FloatArray,
    high: FloatArray,
    vary: BoolArray,
    damping: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the steps that lower ‖r + J s‖² + sᵀS s most among those inside the bounds, and their squared length.

    The columns are scaled to unit length first, so parameters of any units are solved alike. A parameter that
    presses against its bound is held there, one that would pass it stops at it, and the others are solved again
    with that known, until no parameter wants to change sides (or 2 p rounds are over).
    """
    whole = normal + curvature
    scale = _column_scale(whole)
    A = whole / (scale[:, :, np.newaxis] * scale[:, np.newaxis, :])
    b = downhill / scale
    floor, roof = low * scale, high * scale
    held = ~vary | ((low >= 0.0) & (b < 0.0)) | ((high <= 0.0) & (b > 0.0))
    stop = np.zeros(b.shape)
    step = _solve(A, b, damping, held, stop)
    for _ in range(2 * b.shape[1]):
        beyond = ~held & ((step < floor) | (step > roof))
        inward = held & vary
        if not (np.count_nonzero(beyond) or np.count_nonzero(inward)):
            break
        if np.count_nonzero(inward):
            push = b - np.einsum("mij,mj->mi", A, step)
            inward &= np.where(step <= floor, push > _PUSH, push < -_PUSH)
            # Letting go waits until nothing is beyond a bound, or two parameters could swap for ever.
            inward &= ~beyond.any(axis=1, keepdims=True)
        again = np.flatnonzero((beyond | inward).any(axis=1))
        if not again.size:
            break
        stop = np.where(beyond, np.clip(step, floor, roof), np.where(inward, 0.0, stop))
        held = (held | beyond) & ~inward
        step[again] = _solve(A[again], b[again], damping[again], held[again], stop[again])
    step = np.minimum(np.maximum(step / scale, low), high)
    # Two products of two: einsum is slow with three.
    length2 = ((normal @ step[:, :, np.newaxis])[:, :, 0] * step).sum(axis=1)
    return step, np.maximum(length2, 0.0)


def _column_scale(normal: FloatArray) -> FloatArray:
    """Return the lengths of the columns of J from JᵀJ, shape (m, p), and 1 where there is none."""
    square = normal.diagonal(axis1=1, axis2=2)
    return np.sqrt(np.where(square > _NOTHING, square, 1.0))


def _solve(
    A: FloatArray, b: FloatArray, damping: FloatArray, held: BoolArray, stop: FloatArray
) -> FloatArray:
    """Return the minimum over the parameters that are not held, the others standing at their fixed steps."""
    system, right = A, b
    if np.count_nonzero(held):
        system = np.where(held[:, :, np.newaxis] | held[:, np.newaxis, :], 0.0, A)
        right = np.where(held, stop, b - np.einsum("mij,mj->mi", A, stop))
    system = np.array(system, order="C")
    # The diagonal is a view: what is added to it is added to the system.
    diagonal = system.reshape(len(b), -1)[:, :: b.shape[1] + 1]
    diagonal += np.where(diagonal > 0.0, damping[:, np.newaxis] + _RIDGE, 1.0)
    return np.asarray(np.linalg.solve(system, right[..., np.newaxis])[..., 0])


def _learnt(curvature: FloatArray, normal: FloatArray, step: FloatArray, change: FloatArray) -> FloatArray:
    """Return what Gauss-Newton leaves out, the second derivatives of the model, learnt from the steps themselves.

    JᵀJ + S explains how the gradient changed over the last step. S is zero where that is not safely positive definite:
    there a step might lead uphill.
    """
    v = change - np.einsum("mij,mj->mi", normal + curvature, step)
    along = np.einsum("mi,mi->m", v, step)
    size = np.sqrt((v**2).sum(axis=1) * (step**2).sum(axis=1))
    good = np.abs(along) > _SKIP * size
    update = v[:, :, np.newaxis] * v[:, np.newaxis, :] / np.where(good, along, 1.0)[:, np.newaxis, np.newaxis]
    S = np.where(good[:, np.newaxis, np.newaxis], curvature + update, curvature)
    scale = _column_scale(normal + S)
    remains = ((1.0 - _REMAINS) * normal + S) / (scale[:, :, np.newaxis] * scale[:, np.newaxis, :])
    safe = np.linalg.eigvalsh(remains)[:, 0] > _POSITIVE
    return np.where(safe[:, np.newaxis, np.newaxis], S, 0.0)
