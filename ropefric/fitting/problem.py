"""How a fit is to be made, its least-squares problem in ln F_A, and the engine that solves thousands of these at once.

Points that share errors have a matrix `root` with rootᵀ root = V⁻¹ in the place of their standard deviations.

`batched_fit`, Levenberg-Marquardt inside bounds with the analytic Jacobian of the law, is the one engine of every fit:
of a law from several starts, of profiles, of laws on condition means.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from numbers import Integral
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray, IntArray
from ropefric.errors import InputError, UnknownNameError
from ropefric.friction.condition import Conditions
from ropefric.friction.law import FrictionLaw
from ropefric.friction.laws import ALL_LAWS
from ropefric.registry import did_you_mean

Rows = npt.NDArray[np.intp]
# Starts of a search; beyond some hundreds nothing new is found.
_MOST_STARTS = 10_000


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
    kinds = {"fixed": ("a number", ()), "start": ("a number", ()), "bounds": ("(lower, upper)", (2,))}
    for key, (wanted, shape) in kinds.items():
        for name, value in getattr(settings, key).items():
            if name not in law.parameter_names:
                fix = did_you_mean(str(name), law.parameter_names)
                raise UnknownNameError(f"{law.name} has no parameter {name!r}", key=key, fix=fix)
            given = np.array(value)
            if given.shape != shape or given.dtype.kind not in "fiu" or np.isnan(given).any():
                text = f"{name} is given as {value!r:.40}, not as {wanted}"
                raise InputError(text, key=key, fix=f"give {wanted}")
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
        return self.whitened_slopes(self.law.jacobian(theta, self.conditions))

    def residuals_and_jacobian(self, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return `residuals` and `jacobian`, the law evaluated once for both."""
        log_lift, slopes = self.law.log_lift_and_jacobian(theta, self.conditions)
        return self.whitened(log_lift - self.log_lift), self.whitened_slopes(slopes)

    def whitened_slopes(self, slopes: FloatArray) -> FloatArray:
        """Return slopes (…, n, p) as `whitened` does values."""
        return self.whitened(slopes.swapaxes(-1, -2)).swapaxes(-1, -2)

    def whitened(self, values: FloatArray) -> FloatArray:
        """Return values (…, n) in standard deviations, or as combinations of them that share no error."""
        return values / self.std if self.root is None else values @ self.root.T

    def unwhitened(self, values: FloatArray) -> FloatArray:
        """Return the values (n,) that `whitened` turns into these."""
        return np.asarray(values * self.std if self.root is None else np.linalg.solve(self.root, values))


def typical_mu(conditions: Conditions, log_lift: FloatArray) -> float:
    """Return the median of the average coefficients ln(F_A/F_B)/φ, which one bad condition cannot move far."""
    rise = log_lift - conditions.log_end_tension
    return float(np.median(rise / np.maximum(conditions.wrap_angle_rad, 1e-9)))


# ---- the engine ----

_EPS = float(np.finfo(np.float64).eps)
_FIRST_DAMPING = 1e-4
_NO_DAMPING = 1e-9
_RAISE = 6.0
_LOWER = 0.2
_HOPELESS_DAMPING = 1e14
# ln F_A from a closed form carries an error of this relative size, so a step that moves it less is rounding.
_MODEL_ROUNDING = 1e-14
# Keeps the scaled normal equations invertible where the data do not see a direction at all.
_RIDGE = 1e-13
# Near the smallest floats a square is held only in part.
_NOTHING = 1e-280


class BatchFit(NamedTuple):
    """Least-squares fits of m data sets: parameters (m, p), χ² and whether it is a minimum (m,)."""

    theta: FloatArray
    chi2: FloatArray
    converged: BoolArray


def batched_fit(
    problem: FitProblem,
    log_lift: npt.ArrayLike | None = None,
    starts: npt.ArrayLike | None = None,
    *,
    multiplicity: npt.ArrayLike | None = None,
    vary: npt.ArrayLike | None = None,
    tolerance: float = 1e-9,
    max_iterations: int = 300,
) -> BatchFit:
    """Return the bounded least-squares fits of m data sets, all iterated together.

    Shapes (n,) or (m, n): measured ln F_A, and how often each point counts in each data set. Marquardt's damping,
    relative to the diagonal of JᵀWJ, belongs to each data set by itself and starts at zero: the first steps are plain
    Gauss-Newton, and only a step that fails is damped. Bounds are held by an active set (`bounded_steps`). Data sets
    that are done leave the batch.
    """
    y = np.atleast_2d(np.asarray(problem.log_lift if log_lift is None else log_lift, np.float64))
    count = np.atleast_2d(np.asarray(1.0 if multiplicity is None else multiplicity, np.float64))
    theta = np.atleast_2d(np.asarray(problem.start if starts is None else starts, np.float64))
    free = np.atleast_2d(np.asarray(problem.vary if vary is None else vary, np.bool_))
    m = max(map(len, (y, count, theta, free)))
    data = _DataSets(problem, *(np.broadcast_to(x, (m, problem.n_points)) for x in (y, count)))
    free = np.broadcast_to(free, (m, problem.start.size))
    theta = np.where(free, np.clip(theta, problem.lower, problem.upper), theta)
    found = data.evaluate(theta, np.arange(m))
    # Where the law has no answer at a start, the problem's own is tried.
    if (lost := np.flatnonzero(~np.isfinite(found[0]))).size:
        theta[lost] = np.where(free[lost], problem.start, theta[lost])
        for whole, again in zip(found, data.evaluate(theta[lost], lost), strict=True):
            whole[lost] = again
    chi2, normal, downhill = found
    signal, alive = data.signal, np.isfinite(chi2)
    damping, last2, converged = np.zeros(m), np.full(m, np.inf), np.zeros(m, np.bool_)

    def proposed(rows: Rows, damping: FloatArray) -> tuple[FloatArray, FloatArray]:
        low, high = (bound - theta[rows] for bound in (problem.lower, problem.upper))
        return bounded_steps(
            normal[rows], downhill[rows], low=np.minimum(low, 0.0), high=np.maximum(high, 0.0),
            vary=free[rows], damping=damping,
        )  # fmt: skip

    for _ in range(max_iterations):
        rows = np.flatnonzero(alive)
        if not rows.size:
            break
        # The plain steps tell whether a search is done.
        step, length2 = proposed(rows, np.zeros(rows.size))
        enough2 = tolerance**2 * chi2[rows] / problem.n_points + _MODEL_ROUNDING**2 * signal[rows]
        # χ² cannot resolve steps shorter than its own rounding: they are taken as they come, until they no longer
        # shrink.
        blur = _EPS * (64.0 * chi2[rows] + 4.0 * np.sqrt(chi2[rows] * signal[rows]))
        blind = length2 <= blur
        done = (length2 <= enough2) | (blind & (length2 > 0.8 * last2[rows]))
        last2[rows] = length2
        converged[rows[done]], alive[rows[done]] = True, False
        left = ~done
        rows, step, length2, blind, blur = rows[left], step[left], length2[left], blind[left], blur[left]
        if not rows.size:
            continue
        damped = np.flatnonzero((damping[rows] > 0.0) & ~blind)
        if damped.size:
            step[damped], length2[damped] = proposed(rows[damped], damping[rows[damped]])
        inside = np.clip(theta[rows] + step, problem.lower, problem.upper)
        trial = np.where(free[rows], inside, theta[rows])
        there = data.evaluate(trial, rows)
        better = there[0] <= np.where(blind, chi2[rows] + 4.0 * blur, np.nextafter(chi2[rows], 0.0))
        # Damp more after a step that failed or gained little of what was foretold, less after a good one.
        foretold = 2.0 * (step * downhill[rows]).sum(axis=1) - length2
        gain = (chi2[rows] - np.where(better, there[0], chi2[rows])) / np.where(
            foretold > 0.0, foretold, np.inf
        )
        gain, old = np.where(blind, 1.0, gain), damping[rows]
        raised = np.where(old > 0.0, _RAISE * old, _FIRST_DAMPING)
        lowered = np.where(old > _NO_DAMPING, old * _LOWER, 0.0)
        new = np.where(gain > 0.75, lowered, np.where(gain < 0.25, 2.0 * old, old))
        damping[rows] = np.where(better, new, raised)
        alive[rows[~better & (raised > _HOPELESS_DAMPING)]] = False
        rows = rows[better]
        theta[rows] = trial[better]
        for whole, part in zip(found, there, strict=True):
            whole[rows] = part[better]
    return BatchFit(theta, chi2, converged)


class _DataSets(NamedTuple):
    """Measured ln F_A of m data sets, and how often each of the n points counts, shapes (m, n)."""

    problem: FitProblem
    log_lift: FloatArray
    times: FloatArray

    @property
    def signal(self) -> FloatArray:
        """Return the weighted sum of squares of the data, shape (m,): rounding errors scale with it."""
        return np.asarray((self.times * self.problem.whitened(self.log_lift) ** 2).sum(axis=1))

    def evaluate(self, theta: FloatArray, rows: Rows) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return χ², JᵀWJ and JᵀW(y − f) of a parameter set for each row; χ² is infinite where there is no answer."""
        values, slopes = self._answers(theta)
        # A law may answer with 1e300, which no square can hold: such a set is no candidate.
        with np.errstate(over="ignore", invalid="ignore"):
            residual = self.problem.whitened(self.log_lift[rows] - values)
            J, count = self.problem.whitened_slopes(slopes), self.times[rows]
            chi2 = (count * residual**2).sum(axis=1)
            weighted = J.swapaxes(1, 2) * count[:, np.newaxis, :]
            normal, downhill = weighted @ J, (weighted @ residual[:, :, np.newaxis])[..., 0]
        return np.where(np.isnan(chi2), np.inf, chi2), normal, downhill

    def _answers(self, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return ln F_A and its slopes; NaN for sets without an answer."""
        law, conditions = self.problem.law, self.problem.conditions
        try:
            return law.log_lift_and_jacobian(theta, conditions)
        except InputError:
            if len(theta) == 1:
                nothing = np.full((1, len(conditions), theta.shape[1] + 1), np.nan)
                return nothing[..., 0], nothing[..., 1:]
        parts = [self._answers(one) for one in np.split(theta, len(theta))]
        values, slopes = zip(*parts, strict=True)
        return np.concatenate(values), np.concatenate(slopes)


def bounded_steps(
    normal: FloatArray,
    downhill: FloatArray,
    *,
    low: FloatArray,
    high: FloatArray,
    vary: BoolArray,
    damping: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return steps inside the bounds that lower ‖r + J s‖², and their squared length.

    The columns are scaled to unit length first, so parameters of any units are solved alike. A parameter that
    presses against its bound is held there, one that would pass it stops at it, and the others are solved again with
    that known, until none wants to pass one.
    """
    square = normal.diagonal(axis1=1, axis2=2)
    scale = np.sqrt(np.where(square > _NOTHING, square, 1.0))
    A = normal / (scale[:, :, np.newaxis] * scale[:, np.newaxis, :])
    b = downhill / scale
    floor, roof = low * scale, high * scale
    held = ~vary | ((low >= 0.0) & (b < 0.0)) | ((high <= 0.0) & (b > 0.0))
    stop = np.zeros(b.shape)
    step = _solve(A, b, damping, held, stop)
    while (beyond := ~held & ((step < floor) | (step > roof))).any():
        stop, held = np.where(beyond, np.clip(step, floor, roof), stop), held | beyond
        step = _solve(A, b, damping, held, stop)
    step = np.minimum(np.maximum(step / scale, low), high)
    # Two products of two: einsum is slow with three.
    length2 = ((normal @ step[:, :, np.newaxis])[:, :, 0] * step).sum(axis=1)
    return step, np.maximum(length2, 0.0)


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
