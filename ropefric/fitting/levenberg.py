"""Levenberg-Marquardt on thousands of data sets at once, inside bounds, with the analytic Jacobian of the law."""

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.fitting.bounded_step import bounded_steps
from ropefric.fitting.curvature import learnt_curvature, usable
from ropefric.fitting.problem import FitProblem
from ropefric.fitting.reduced import Reduced, reduced

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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BatchFit:
    """Least-squares parameters of m data sets."""

    theta: FloatArray
    chi2: FloatArray
    converged: BoolArray
    n_iterations: int


def batched_fit(
    problem: FitProblem,
    log_lift: npt.ArrayLike | None = None,
    starts: npt.ArrayLike | None = None,
    *,
    std: npt.ArrayLike | None = None,
    multiplicity: npt.ArrayLike | None = None,
    vary: npt.ArrayLike | None = None,
    tolerance: float = 1e-9,
    max_iterations: int = 300,
) -> BatchFit:
    """Return the bounded least-squares fits of m data sets, all iterated together.

    Marquardt's damping, relative to the diagonal of JᵀWJ, belongs to each data set by itself and starts at zero:
    the first steps are plain Gauss-Newton, and only a step that fails is damped. Bounds are held by an active set
    (`bounded_steps`). Data sets that are done leave the batch. Repeats of a condition are summed first, so the law
    is evaluated once per distinct condition.
    """
    data = reduced(
        problem, *(None if x is None else np.asarray(x, np.float64) for x in (log_lift, std, multiplicity))
    )
    p = problem.start.size
    theta = np.atleast_2d(np.asarray(problem.start if starts is None else starts, dtype=np.float64))
    free = np.atleast_2d(np.asarray(problem.vary if vary is None else vary, dtype=np.bool_))
    if theta.shape[1:] != (p,) or free.shape[1:] != (p,) or not np.isfinite(theta).all():
        raise InputError(
            f"starts of shape {theta.shape} and vary of shape {free.shape}; law {problem.law.name} needs (m, {p}), "
            "finite",
            code="RF400",
        )
    lengths = {len(rows) for rows in (data.weight, data.mean, data.rest, theta, free)} - {1}
    if len(lengths) > 1:
        raise InputError(
            f"the data sets are {' or '.join(map(str, sorted(lengths)))} in number", code="RF400"
        )
    m = lengths.pop() if lengths else 1
    free = np.broadcast_to(free, (m, p))
    theta = np.where(free, np.clip(theta, problem.lower, problem.upper), theta)
    search = _Search(data=data, problem=problem, theta=np.broadcast_to(theta, (m, p)).copy(), vary=free)
    search.begin(same_start=bool((theta == theta[0]).all()))
    steps = search.run(tolerance, max_iterations)
    return BatchFit(theta=search.theta, chi2=search.chi2, converged=search.converged, n_iterations=steps)


@dataclass(slots=True, kw_only=True, eq=False)
class _Search:
    """The state of m fits on their way; one row a data set."""

    data: Reduced
    problem: FitProblem
    theta: FloatArray
    vary: BoolArray
    chi2: FloatArray = field(init=False)
    normal: FloatArray = field(init=False)
    downhill: FloatArray = field(init=False)
    curvature: FloatArray = field(init=False)
    damping: FloatArray = field(init=False)
    last_length2: FloatArray = field(init=False)
    slow: BoolArray = field(init=False)
    converged: BoolArray = field(init=False)
    alive: BoolArray = field(init=False)
    curved: bool = False

    def begin(self, *, same_start: bool) -> None:
        """Evaluate the starts; where the law has no answer, try the problem's own start."""
        m = len(self.theta)
        rows = np.arange(m)
        shared = self.data.evaluate_shared(self.theta[0], m) if same_start else None
        if shared is not None:
            self.chi2, self.normal, self.downhill = shared
        else:
            nowhere = np.full(m, np.inf)
            self.chi2, self.normal, self.downhill = self.data.evaluate(self.theta, rows, nowhere)
            lost = np.flatnonzero(~np.isfinite(self.chi2))
            if lost.size:
                self.theta[lost] = np.where(self.vary[lost], self.problem.start, self.theta[lost])
                self.chi2[lost], self.normal[lost], self.downhill[lost] = self.data.evaluate(
                    self.theta[lost], lost, nowhere[lost]
                )
        self.curvature = np.zeros_like(self.normal)
        self.damping = np.zeros(m)
        self.last_length2 = np.full(m, np.inf)
        self.slow = np.zeros(m, dtype=np.bool_)
        self.converged = np.zeros(m, dtype=np.bool_)
        self.alive = np.isfinite(self.chi2)

    def run(self, tolerance: float, max_iterations: int) -> int:
        """Step until no data set is left; return the number of steps."""
        signal = np.broadcast_to(self.data.signal, self.chi2.shape)
        for steps in range(max_iterations):
            # Cheaper calls than the plain ones throughout: in a single fit they weigh as much as the law.
            rows = self.alive.nonzero()[0]
            if not rows.size:
                return steps
            step, length2 = self._propose(rows, np.zeros(rows.size))
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
            damped = ((self.damping[rows] > 0.0) & ~blind & ~done).nonzero()[0]
            if damped.size:
                step[damped], length2[damped] = self._propose(rows[damped], self.damping[rows[damped]])
                final[damped] = False
            slack = np.where(blind, 4.0 * blur, 0.0)
            if not np.count_nonzero(done):
                self._try(rows, step, length2, slack, final)
                continue
            self.converged[rows[done]] = True
            self.alive[rows[done]] = False
            left = (~done).nonzero()[0]
            if left.size:
                self._try(rows[left], step[left], length2[left], slack[left], final[left])
        return max_iterations

    def _propose(self, rows: npt.NDArray[np.intp], damping: FloatArray) -> tuple[FloatArray, FloatArray]:
        at = slice(None) if rows.size == len(self.theta) else rows
        theta = self.theta[at]
        return bounded_steps(
            self.normal[at],
            self.downhill[at],
            curvature=self.curvature[at],
            low=np.minimum(self.problem.lower - theta, 0.0),
            high=np.maximum(self.problem.upper - theta, 0.0),
            vary=self.vary[at],
            damping=damping,
        )

    def _try(
        self,
        rows: npt.NDArray[np.intp],
        step: FloatArray,
        length2: FloatArray,
        slack: FloatArray,
        final: BoolArray,
    ) -> None:
        """Take the steps that lower χ² (or keep it within a slack), and learn from how well that was foretold."""
        theta, old = self.theta[rows], self.chi2[rows]
        inside = np.minimum(np.maximum(theta + step, self.problem.lower), self.problem.upper)
        trial = np.where(self.vary[rows], inside, theta)
        limit = np.where(slack > 0.0, old + slack, np.nextafter(old, 0.0))
        chi2, normal, downhill = self.data.evaluate(trial, rows, np.where(final, -1.0, limit))
        better = chi2 <= limit
        # Undamped steps that succeed stay undamped, whatever they gained.
        if np.count_nonzero(self.damping[rows]) or np.count_nonzero(better) < better.size:
            gain = self._gain(rows, step, length2, old - np.where(better, chi2, old))
            self._adapt(rows, np.where(slack > 0.0, 1.0, gain), better)
        self._learn(rows, step, better & ~final, normal, downhill)
        arrived = rows[better & final]
        if np.count_nonzero(better) < better.size:
            rows, trial, chi2 = rows[better], trial[better], chi2[better]
            normal, downhill = normal[better], downhill[better]
        self.theta[rows], self.chi2[rows] = trial, chi2
        self.normal[rows], self.downhill[rows] = normal, downhill
        self.converged[arrived] = True
        self.alive[arrived] = False

    def _learn(
        self,
        rows: npt.NDArray[np.intp],
        step: FloatArray,
        better: BoolArray,
        normal: FloatArray,
        downhill: FloatArray,
    ) -> None:
        """Learn the model's curvature where Gauss-Newton alone is slow; forget it where a step failed."""
        if self.curved:
            self.curvature[rows[~better]] = 0.0
        use = better & self.slow[rows]
        if not np.count_nonzero(use):
            return
        self.curved = True
        taken = rows[use]
        change = self.downhill[taken] - downhill[use]
        S = learnt_curvature(self.curvature[taken], normal[use], step[use], change)
        self.curvature[taken] = np.where(usable(normal[use], S)[:, np.newaxis, np.newaxis], S, 0.0)

    def _gain(
        self, rows: npt.NDArray[np.intp], step: FloatArray, length2: FloatArray, fallen: FloatArray
    ) -> FloatArray:
        """Return how much χ² fell as a part of what the step foretold."""
        bend = np.einsum("mi,mi->m", np.einsum("mij,mj->mi", self.curvature[rows], step), step)
        foretold = 2.0 * np.einsum("mi,mi->m", step, self.downhill[rows]) - length2 - bend
        return np.asarray(fallen / np.where(foretold > 0.0, foretold, np.inf))

    def _adapt(self, rows: npt.NDArray[np.intp], gain: FloatArray, better: BoolArray) -> None:
        """Damp more after a step that failed or gained little of what was foretold, less after a good one."""
        old = self.damping[rows]
        raised = np.where(old > 0.0, _RAISE * old, _FIRST_DAMPING)
        lowered = np.where(old > _NO_DAMPING, old * _LOWER, 0.0)
        new = np.where(gain > 0.75, lowered, np.where(gain < 0.25, 2.0 * old, old))
        self.damping[rows] = np.where(better, new, raised)
        self.alive[rows[raised > _HOPELESS_DAMPING]] = False
