"""Levenberg-Marquardt on thousands of data sets at once, inside bounds, with the analytic Jacobian of the law.

The one engine of every fit: of a law from several starts, of resamples, of profiles, of laws on condition means.
"""

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.fitting.problem import FitProblem, Loss, Reduced, Rows, reduced

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
    loss: Loss = "linear",
    tolerance: float = 1e-9,
    max_iterations: int = 300,
) -> "BatchFit":
    """Return the bounded least-squares fits of m data sets, all iterated together.

    Marquardt's damping, relative to the diagonal of JᵀWJ, belongs to each data set by itself and starts at zero:
    the first steps are plain Gauss-Newton, and only a step that fails is damped. Bounds are held by an active set
    (`bounded_steps`). Data sets that are done leave the batch. Repeats of a condition are summed first, so the law
    is evaluated once per distinct condition.
    """
    data = reduced(problem, log_lift, multiplicity, loss=loss)
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
        shared = data.evaluate_shared(theta[0], m) if (theta == theta[0]).all() else None
        if shared is None:
            shared = data.evaluate(theta, np.arange(m), nowhere)
            lost = np.flatnonzero(~np.isfinite(shared[0]))
            theta[lost] = np.where(vary[lost], problem.start, theta[lost])
            for whole, again in zip(shared, data.evaluate(theta[lost], lost, nowhere[lost]), strict=True):
                whole[lost] = again
        self.chi2, self.normal, self.downhill = shared
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
