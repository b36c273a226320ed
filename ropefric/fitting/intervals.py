"""Intervals found in another way than from the covariance: along profiles of the likelihood, and by bootstrap.

A profile asks how far a parameter can go while the others make up for it; all ends of all parameters are walked to at
once: along a grid, further where needed, then to the root. A bootstrap refits thousands of resamples in one batch.
"""

from dataclasses import replace
from functools import partial
from math import inf, isfinite
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.special import gammaincinv

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import FitError, InputError, UnknownNameError
from ropefric.executors import spread
from ropefric.files.plain_text import to_share
from ropefric.fitting.problem import MANY, FitProblem, Rows, batched_fit, pooled, reduced
from ropefric.fitting.result import FitResult, FitStatus
from ropefric.fitting.statistics import decomposed, plain_covariance, two_level_scatter
from ropefric.friction.condition import Conditions
from ropefric.registry import did_you_mean
from ropefric.uncertainty.budget import quantile

EndKind = Literal["crossing", "bound", "open", "edge"]

_RIDGE = 1e-12
_LOWER_MINIMUM = 1e-3
_ROUNDING = 1e-26
# The inner minimum is flat: this error of its place, in residuals, is an error of its square in Δχ².
_TOLERANCE = 1e-7
# Fractions of the end a parabola would have.
_GRID = np.array([0.25, 0.5, 0.75, 0.95, 1.05, 1.3])
_DOUBLINGS = 40
# A parameter without a bound that can grow this far has no limit.
_ENDLESS = 1e8
_ROUNDS = 60
# Far below what is kept of an end, 1e-5 of a standard error, so that no path to it shows.
_ROOT = 1e-10
# Nearer to where a law ends, its answers are rounding.
_EDGE = 1e-6
_END_NOTES: dict[EndKind, str] = {
    "bound": "the data set no {} limit before its bound {:.6g}; the interval is one-sided",
    "open": "the data set no {} limit at all",
    "edge": "the {} end {:.6g} is where the law stops having an answer",
}
BootstrapKind = Literal["parametric", "clustered"]

INTERVALS = ("auto", "covariance", "profile", "bootstrap", "bootstrap-t")
"""Ways to the 95 % intervals of the parameters; "auto" is the covariance where χ² bears it out, else the profile."""

_BESIDE_A_BOUND = (
    "a parameter lies on its bound: 95 % intervals beside it are on the safe side, they held the truth in 97 to 100 % "
    "of simulated campaigns"
)
_WORTH_A_NOTE = 0.025
# √Δχ² at the ends of an interval from the covariance, over what a parabola has there: χ² bears the interval out.
_STRAIGHT = (0.8, 1.25)
_MOST_RESAMPLES = 1_000_000
_BLOCK = 500
# With fewer conditions than this, drawing whole conditions gives intervals that are too narrow.
_ENOUGH_TO_DRAW = 20


class ProfileResult(NamedTuple):
    """Profile-likelihood intervals of a fit, the Δχ² at their ends, and how many fits it took to find them."""

    theta: FloatArray
    ci: FloatArray
    at_bound: BoolArray
    threshold: FloatArray
    n_fits: int
    notes: tuple[str, ...]


def profile_intervals(
    problem: FitProblem, theta: npt.ArrayLike, *, level: float = 0.95, scale: npt.ArrayLike = 1.0
) -> ProfileResult:
    """Return the profile-likelihood interval of every fitted parameter.

    A value belongs to the interval while Δχ² = χ²(value, others refitted) − χ²_min stays below scale · the quantile of
    χ²(1): with a scatter taken from the residuals the scale holds χ²_min/(n − q) and Student's quantile.
    Correlated points make Δχ² too large by the ratio of the true variance to the one it believes in, parameter by
    parameter; dividing by that ratio (Chandler & Bate 2007, Biometrika 94:167, for one parameter at a time) gives
    back the size of the interval and keeps its shape.

    Each interval is connected: it ends at the first crossing on either side. Near a bound it is one-sided and ends
    at the bound; with the truth on the bound it then covers more than the level (97.5 % at 95 %). The intervals of
    parameters strongly correlated with one whose truth is exactly on its bound cover less (90 % at 95 % for the
    exponent of `wrap-power` without a plateau), because the bound pulls half of all fits to one side; from half a
    standard error off the bound they are right again.
    """
    fit = batched_fit(problem, starts=theta)
    best, chi2_min = fit.theta[0], float(fit.chi2[0])
    notes = [] if fit.converged[0] else ["the fit had not converged, so the intervals are not to be trusted"]
    target = 2.0 * gammaincinv(0.5, level)  # the quantile of χ² of one; scipy.stats takes 0.4 s to import
    threshold = np.broadcast_to(np.asarray(scale) * target, best.shape)
    # Exact data leave nothing but rounding, and rounding has no interval.
    threshold = np.where(threshold > _ROUNDING * float(reduced(problem).signal[0]), threshold, 0.0)
    walk = _Walk(problem, best, chi2_min, threshold)
    walk.bracket()
    walk.refine()
    ci = np.stack([best, best], axis=-1)
    at_bound = np.zeros(ci.shape, dtype=np.bool_)
    for j, sign, (end, kind) in zip(walk.parameter, walk.sign, walk.ends(), strict=True):
        side = int(sign > 0.0)
        ci[j, side], at_bound[j, side] = end, kind == "bound"
        if kind != "crossing":
            text = _END_NOTES[kind].format(("lower", "upper")[side], end)
            notes.append(f"{problem.law.parameter_names[j]}: {text}")
    if walk.lowest < -_LOWER_MINIMUM * max(chi2_min, 1e-300):
        notes.append(
            f"a lower minimum was met on the way (χ² {chi2_min + walk.lowest:.6g} < {chi2_min:.6g}): "
            "fit again from more starts"
        )
    return ProfileResult(
        theta=best, ci=ci, at_bound=at_bound, threshold=threshold, n_fits=walk.n_fits, notes=tuple(notes)
    )


class _Walk:
    """The way to the ends of all intervals at once, two sides a parameter, and the profiles met on it.

    An end lies between two distances from the minimum: Δχ² is below the target at `near`, and not at `far`.
    """

    def __init__(self, problem: FitProblem, best: FloatArray, chi2_min: float, threshold: FloatArray) -> None:
        self.problem, self.best, self.chi2_min = problem, best, chi2_min
        self.lowest, self.n_fits = 0.0, 1
        varying = np.flatnonzero(problem.vary)
        self.parameter = np.repeat(varying, 2)
        self.sign = np.tile([-1.0, 1.0], varying.size)
        self.bound = np.where(self.sign < 0.0, problem.lower[self.parameter], problem.upper[self.parameter])
        at = best[self.parameter]
        room = np.maximum(self.sign * (self.bound - at), 0.0)
        self.room = np.where(np.isfinite(room), room, _ENDLESS * np.maximum(np.abs(at), 1.0))
        self.root = np.sqrt(threshold[self.parameter])
        self.near, self.far = np.zeros(at.size), np.where(self.root > 0.0, np.inf, 0.0)
        # √Δχ² less √target, which is nearly straight; an infinite one where the law has no answer.
        self.near_gap, self.far_gap = -self.root, np.where(self.root > 0.0, np.inf, 0.0)
        # How the others follow each parameter, column by column, and how far each would go on a parabola.
        J = problem.jacobian(best) * problem.vary
        length = np.linalg.norm(J, axis=0)
        length = np.where(length > 0.0, length, 1.0)
        normal = (J / length).T @ (J / length)
        normal += np.diag(np.where(np.diag(normal) > 0.0, _RIDGE, 1.0))
        covariance = np.linalg.inv(normal) / np.outer(length, length)
        variance = np.abs(np.diag(covariance))
        self.direction = covariance / variance
        self.reach = np.minimum(np.sqrt(variance * threshold)[self.parameter], self.room)

    def gaps(self, sides: Rows, distance: FloatArray) -> FloatArray:
        """Return √Δχ² − √target with each parameter held at a distance and the others refitted."""
        problem, parameter, rows = self.problem, self.parameter[sides], np.arange(sides.size)
        value = self.best[parameter] + self.sign[sides] * distance
        # Exactly the bound, and not what rounding makes of best + (bound − best).
        at_bound = (distance >= self.room[sides]) & np.isfinite(self.bound[sides])
        value = np.where(at_bound, self.bound[sides], value)
        plain = np.tile(self.best, (sides.size, 1))
        starts = plain + self.direction[:, parameter].T * (value - self.best[parameter])[:, np.newaxis]
        starts = np.where(problem.vary, np.clip(starts, problem.lower, problem.upper), plain)
        starts[rows, parameter] = plain[rows, parameter] = value
        usable = problem.law.admissible(starts, problem.conditions)
        vary = np.tile(problem.vary, (sides.size, 1))
        vary[rows, parameter] = False
        starts = np.where(usable[:, np.newaxis], starts, plain)
        delta = batched_fit(problem, starts=starts, vary=vary, tolerance=_TOLERANCE).chi2 - self.chi2_min
        self.lowest = min(self.lowest, float(delta.min(initial=0.0)))
        self.n_fits += delta.size
        return np.asarray(np.sqrt(np.maximum(delta, 0.0)) - self.root[sides])

    def place(self, sides: Rows, distance: FloatArray, gap: FloatArray) -> None:
        """Move one end of each bracket to a distance in it."""
        over = gap >= 0.0
        self.far[sides[over]], self.far_gap[sides[over]] = distance[over], gap[over]
        self.near[sides[~over]], self.near_gap[sides[~over]] = distance[~over], gap[~over]

    def bracket(self) -> None:
        """Walk a grid on both sides of every parameter, then further where nothing was crossed."""
        sides = np.flatnonzero((self.room > 0.0) & (self.root > 0.0))
        if not sides.size:
            return
        grid = np.minimum(np.outer(self.reach[sides], _GRID), self.room[sides, np.newaxis])
        gap = self.gaps(np.repeat(sides, _GRID.size), grid.ravel()).reshape(grid.shape)
        crossed = np.maximum.accumulate(gap >= 0.0, axis=1)
        for column in range(_GRID.size):
            # The first crossing and what lies before it.
            use = ~crossed[:, column] | (crossed[:, : column + 1].sum(axis=1) == 1)
            self.place(sides[use], grid[use, column], gap[use, column])
        distance = np.minimum(self.reach * _GRID[-1], self.room)
        for _ in range(_DOUBLINGS):
            sides = np.flatnonzero(np.isinf(self.far) & (distance < self.room))
            if not sides.size:
                return
            distance[sides] = np.minimum(2.0 * distance[sides], self.room[sides])
            self.place(sides, distance[sides], self.gaps(sides, distance[sides]))

    def refine(self) -> None:
        """Close the brackets on the roots, by regula falsi."""
        last = np.zeros(self.near.size)
        for _ in range(_ROUNDS):
            narrow = np.where(np.isinf(self.far_gap), _EDGE, _ROOT) * self.far
            sides = np.flatnonzero(np.isfinite(self.far) & (self.far - self.near > narrow))
            if not sides.size:
                return
            below, above = self.near_gap[sides], self.far_gap[sides]
            with np.errstate(invalid="ignore"):
                share = np.where(np.isfinite(above), -below / (above - below), 0.5)
            near, width = self.near[sides], self.far[sides] - self.near[sides]
            distance = near + np.clip(share, 1e-3, 1.0 - 1e-3) * width
            gap = self.gaps(sides, distance)
            self.place(sides, distance, gap)
            # Illinois: an end that stays twice counts half, or the bracket would close from one side only.
            side = np.where(gap >= 0.0, 1.0, -1.0)
            twice = side == last[sides]
            self.near_gap[sides[twice & (side > 0.0)]] *= 0.5
            self.far_gap[sides[twice & (side < 0.0)]] *= 0.5
            last[sides] = side
            there = np.abs(gap) < _ROOT * self.root[sides]
            self.near[sides[there]] = self.far[sides[there]] = distance[there]

    def ends(self) -> list[tuple[float, EndKind]]:
        """Return the end of every side, and what stops the interval there."""
        ends = self.best[self.parameter] + self.sign * self.near
        endless, limited = np.isinf(self.far), np.isfinite(self.bound)
        reasons = [endless & limited, endless, np.isfinite(self.far_gap)]
        kinds: list[EndKind] = np.select(reasons, ["bound", "open", "crossing"], "edge").tolist()
        return list(zip(np.where(endless, self.bound, ends).tolist(), kinds, strict=True))


class BootstrapResult(NamedTuple):
    """Parameters of the resamples that could be refitted, shape (m, p), and what they say of the fit."""

    theta: FloatArray
    notes: tuple[str, ...]

    def interval(self, level: float = 0.95) -> FloatArray:
        """Return the percentile interval of every parameter at a level between 0 and 1, shape (p, 2)."""
        return np.quantile(self.theta, [(1.0 - level) / 2.0, (1.0 + level) / 2.0], axis=0).T


def bootstrap(
    problem: FitProblem,
    theta: npt.ArrayLike,
    *,
    kind: BootstrapKind = "parametric",
    n: int = 2000,
    seed: int | np.random.Generator = 0,
    scatter: tuple[float, float] | None = None,
    executor: Any = None,
) -> BootstrapResult:
    """Return the spread of a fit over resampled data sets, refitted here or by an executor.

    "parametric" draws scatter about the law, at two levels; "clustered" draws whole conditions.
    """
    law, best = problem.law, np.asarray(theta, dtype=np.float64)
    if not 2 <= n <= _MOST_RESAMPLES:
        what = "has no spread" if n < 2 else f"is too large: {_MOST_RESAMPLES} is the limit"
        raise InputError(f"a bootstrap of {n} resamples {what}", key="n", fix="take 2000")
    rng = np.random.default_rng(seed)
    within, between = two_level_scatter(problem, best) if scatter is None else scatter
    share: float | FloatArray = 1.0
    if problem.n_points >= MANY:
        problem, share = pooled(problem)
    group, k = problem.group, problem.n_conditions
    if kind == "parametric":
        lift = law.log_lift(best, problem.conditions)
        shared = rng.standard_normal((n, k))[:, group]
        own = rng.standard_normal((n, lift.size))
        drawn = lift + between * shared + within * share * own
        fitted, _, good = _refits(problem, best, executor, log_lift=drawn)
    else:
        counts = rng.multinomial(k, np.full(k, 1.0 / k), size=n)
        fitted, _, good = _refits(problem, best, executor, multiplicity=counts[:, group])
        good &= (counts > 0).sum(axis=1) >= problem.n_varying
    refits = fitted[good]
    failed = n - len(refits)
    if len(refits) < 2:
        text = f"{law.name}: only {len(refits)} of {n} resamples could be refitted"
        raise FitError(text, fix="take a law with fewer parameters, or measure more conditions")
    notes = []
    if failed > _WORTH_A_NOTE * n:
        text = "resamples could not be refitted; the intervals speak for the others only"
        notes.append(f"{failed} of {n} {text}")
    at_bound = ((refits <= problem.lower) | (refits >= problem.upper)).mean(axis=0) * problem.vary
    notes += [
        f"{name} is at a bound in {100 * part:.0f} % of the refits, so its interval is one-sided there"
        for name, part in zip(law.parameter_names, at_bound, strict=True)
        if part > _WORTH_A_NOTE
    ]
    return BootstrapResult(theta=refits, notes=tuple(notes))


def _refits(
    problem: FitProblem, best: FloatArray, executor: Any, **drawn: npt.NDArray[Any]
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return parameters, χ² and whether they were found for data sets drawn; by blocks, whoever fits them."""
    (draws,) = drawn.values()
    blocks = ({name: block} for name in drawn for block in np.split(draws, range(_BLOCK, len(draws), _BLOCK)))
    found = spread(partial(_refit, problem, best), blocks, executor)
    theta, chi2, converged = map(np.concatenate, zip(*found, strict=True))
    return theta, chi2, converged


def _refit(
    problem: FitProblem, best: FloatArray, drawn: dict[str, Any]
) -> tuple[FloatArray, FloatArray, BoolArray]:
    fits = batched_fit(problem, starts=best, **drawn)
    return fits.theta, fits.chi2, fits.converged


def bootstrap_t(
    problem: FitProblem,
    theta: npt.ArrayLike,
    *,
    at: Conditions | None = None,
    n: int = 2000,
    seed: int = 0,
    executor: Any = None,
) -> FloatArray:
    """Return the 95 % bootstrap-t interval of every parameter, and of ln F_A at c conditions, shape (p + c, 2).

    Residuals of the conditions' means, each over √(1 − h), are drawn anew about the law. Of each resample not the
    estimate itself but its distance in its own standard errors is kept (Efron & Tibshirani 1993, chapter 12): the
    quantiles of that take the place of Student's.
    """
    means, best, law = pooled(problem)[0], np.asarray(theta, dtype=np.float64), problem.law
    k, spare = means.n_points, means.n_points - problem.n_varying
    if spare < 1:
        text = f"{k} conditions leave nothing to draw residuals of {problem.n_varying} parameters from"
        raise FitError(text, fix="measure more conditions")

    def answers(sets: FloatArray, chi2: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return parameters and predictions of m sets, and their standard errors, shape (m, p + c) each."""
        J = law.jacobian(sets, means.conditions)[..., problem.vary] / means.std[:, None]
        scale = np.maximum(np.linalg.norm(J, axis=1, keepdims=True), np.finfo(np.float64).tiny)
        slopes = np.tile(np.eye(best.size)[:, problem.vary], (len(sets), 1, 1))
        found = sets
        if at is not None:
            slopes = np.concatenate([slopes, law.jacobian(sets, at)[..., problem.vary]], axis=1)
            found = np.hstack([sets, law.log_lift(sets, at)])
        root = slopes / scale @ np.linalg.pinv(J / scale)
        return found, np.sqrt((root**2).sum(axis=-1) * chi2[:, None] / spare)

    residual = means.residuals(best)
    own, std = answers(best[None], np.array([residual @ residual]))
    left = decomposed(means.jacobian(best)[:, problem.vary]).root()[1]
    residual = residual / np.sqrt(np.maximum(1.0 - (left**2).sum(axis=1), 1e-3))
    drawn = residual[np.random.default_rng(seed).integers(k, size=(n, k))]
    again = law.log_lift(best, means.conditions) - means.std * drawn
    theta_drawn, chi2, good = _refits(means, best, executor, log_lift=again)
    # A resample may leave a parameter unseen: its standard error is then no float, and its distance says nothing.
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        found, errors = answers(theta_drawn[good], chi2[good])
        away = (found - own) / errors
    away = np.where(np.isfinite(away), away, 0.0)
    reach = np.quantile(away, [0.975, 1.0 - 0.975], axis=0).T
    ends = own[0, :, None] - reach * std[0, :, None]
    p = best.size
    ends[:p] = np.clip(ends[:p], problem.lower[:, None], problem.upper[:, None])
    return np.asarray(ends)


def with_intervals(
    fit: FitResult, method: str, *, n: int = 2000, seed: int = 0, executor: Any = None
) -> FitResult:
    """Return a fit with `ci95` of its parameters found in another way; all else stays, standard errors too."""
    if method not in INTERVALS:
        text = f"unknown way to intervals {method!r}"
        raise UnknownNameError(text, key="intervals", fix=did_you_mean(str(method), INTERVALS))
    linear = fit.provenance.get("settings", {}).get("loss", "linear") == "linear"
    on_bound = any(item.at_bound for item in fit.parameters)
    if method == "auto":
        known = all(isfinite(item.std) or item.at_bound for item in fit.parameters)
        told = linear and known and fit.statistics.interval_dof > 0.0
        told = told and fit.status is not FitStatus.NOT_CONVERGED
        method = "profile" if told and (on_bound or not is_straight(fit)) else "covariance"
    if method == "covariance":
        return fit
    problem = fit.data
    if not linear:
        text = f"{method} intervals are those of least squares, not of a robust loss"
        raise InputError(text, key="intervals", fix="use loss = 'linear', or intervals = 'covariance'")
    how: dict[str, Any] = {"n": n, "seed": seed}
    notes: tuple[str, ...] = ()
    draws: FloatArray | None = None
    if method == "profile":
        found, how = profile_of(fit), {}
        ends, notes = found.ci, (*found.notes, *((_BESIDE_A_BOUND,) if on_bound else ()))
    elif method == "bootstrap-t":
        ends = bootstrap_t(problem, fit.theta, executor=executor, **how)
    else:
        enough = max(_ENOUGH_TO_DRAW, problem.n_varying + 1)
        whole = enough <= fit.statistics.n_conditions < fit.statistics.n
        kind: BootstrapKind = "clustered" if whole else "parametric"
        drawn = bootstrap(problem, fit.theta, kind=kind, executor=executor, **how)
        ends, notes, draws = drawn.interval(), drawn.notes, drawn.theta
    parameters = tuple(
        replace(item, ci95=(to_share(low, item.std), to_share(high, item.std))) if item.vary else item
        for item, (low, high) in zip(fit.parameters, ends.tolist(), strict=True)
    )
    return replace(
        fit,
        parameters=parameters,
        notes=(*fit.notes, f"95 % intervals by {method}", *notes),
        draws=draws,
        provenance=dict(fit.provenance) | {"intervals": {"method": method} | how},
    )


def is_straight(fit: FitResult) -> bool:
    """Return whether χ² grows to the ends of the covariance's intervals as a parabola does, within a quarter."""
    problem, best = fit.data, fit.theta
    scale = float((problem.residuals(best) ** 2).sum())
    walk = _Walk(problem, best, scale, np.full(best.size, max(scale, 1e-300)))
    reach = np.array([0.5 * (item.ci95[1] - item.ci95[0]) for item in fit.parameters])[walk.parameter]
    std = np.sqrt(np.diag(plain_covariance(problem.jacobian(best)[:, problem.vary])))
    sides = np.flatnonzero((walk.room > 0.0) & (reach > 0.0))
    if not sides.size:
        return True
    distance = np.minimum(reach, walk.room)[sides]
    found = walk.gaps(sides, distance) + walk.root[sides]
    straight = found * np.repeat(std, 2)[sides] / distance
    return bool(((straight > _STRAIGHT[0]) & (straight < _STRAIGHT[1])).all())


def profile_of(fit: FitResult) -> ProfileResult:
    """Return the profile intervals of a fit, as wide as its own covariance and degrees of freedom make them."""
    problem = fit.data
    # χ² believes in independent trials and a normal quantile; the fit's own covariance and Student's t know better.
    variance = np.diag(fit.covariance)
    shown = variance > 0.0
    plain = np.ones_like(variance)
    plain[shown] = np.diag(plain_covariance(problem.jacobian(fit.theta)[:, shown]))
    ratio = np.where(shown & np.isfinite(variance) & (plain > 0.0), variance / plain, 0.0)
    # Of a parameter on its bound no variance is known, but the scatter is the same for all.
    ratio = np.where(ratio > 0.0, ratio, ratio.max(initial=0.0) or 1.0)
    dof, normal = fit.statistics.interval_dof, quantile(0.975, inf)
    reach = quantile(0.975, dof) if dof > 0 else normal
    return profile_intervals(problem, fit.theta, scale=ratio * (reach / normal) ** 2)
