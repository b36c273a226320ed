"""Intervals along profiles of the likelihood, of parameters and of predictions.

A profile asks how far a parameter, or a lift force, can go while the parameters make up for it; all ends are walked to
at once: along a grid, further where needed, then to the root.
"""

from collections.abc import Callable
from dataclasses import replace
from math import inf
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize.elementwise import find_root
from scipy.special import gammaincinv, ndtri

from ropefric.arrays import FloatArray
from ropefric.errors import InputError, UnknownNameError
from ropefric.files.plain_text import to_share
from ropefric.fitting.problem import FitProblem, Rows, batched_fit
from ropefric.fitting.result import FitResult, FitStatus
from ropefric.fitting.statistics import plain_covariance
from ropefric.friction.condition import Conditions
from ropefric.registry import did_you_mean

EndKind = Literal["crossing", "bound", "open"]

_RIDGE = 1e-12
_LOWER_MINIMUM = 1e-3
_ROUNDING = 1e-26
# The inner minimum is flat: this error of its place, in residuals, is an error of its square in Δχ².
_TOLERANCE = 1e-7
_DOUBLINGS = 40
# A parameter without a bound that can grow this far has no limit.
_ENDLESS = 1e8
# Far below what is kept of an end, 1e-5 of a standard error, so that no path to it shows.
_ROOT = 1e-10
# All digits that a float can settle.
_FULL = 4.0 * float(np.finfo(np.float64).eps)
# Stands for a value where a law has no answer.
_NO_ANSWER = 1e3
_END_NOTES: dict[EndKind, str] = {
    "bound": "the data set no {} limit before its bound {:.6g}; the interval is one-sided",
    "open": "the data set no {} limit at all",
}

Rising = Callable[[FloatArray, Rows], FloatArray]
"""`f(x, rows)`: the values of the functions numbered `rows` at one x each; infinite where there is no answer."""

INTERVALS = ("auto", "covariance", "profile")
"""Ways to the 95 % intervals of the parameters; "auto" is the covariance where χ² bears it out, else the profile."""

_BESIDE_A_BOUND = (
    "a parameter lies on its bound: 95 % intervals beside it are on the safe side, they held the truth in 97 to 100 % "
    "of simulated campaigns"
)
# √Δχ² at the ends of an interval from the covariance, over what a parabola has there: χ² bears the interval out.
_STRAIGHT = (0.8, 1.25)
# How strongly a fit is pulled to a lift force, in its standard errors; how near its end is searched for.
_PULL, _FOUND, _STEPS = 0.1, 1e-5, 40
# By how much parameters are moved to see whether a law is straight in them.
_MOVED = 0.3


class ProfileResult(NamedTuple):
    """Profile-likelihood intervals of a fit, shape (p, 2), and how many fits it took to find them."""

    ci: FloatArray
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
    notes = [] if fit.converged[0] else ["the fit had not converged, so the intervals cannot be trusted"]
    target = 2.0 * gammaincinv(0.5, level)  # the quantile of χ² of one; scipy.stats takes 0.4 s to import
    threshold = np.broadcast_to(np.asarray(scale) * target, best.shape)
    # Exact data leave nothing but rounding, and rounding has no interval.
    threshold = np.where(
        threshold > _ROUNDING * float((problem.whitened(problem.log_lift) ** 2).sum()), threshold, 0.0
    )
    walk = _Walk(problem, best, chi2_min, threshold)
    walk.bracket()
    walk.refine()
    ci = np.stack([best, best], axis=-1)
    for j, sign, (end, kind) in zip(walk.parameter, walk.sign, walk.ends(), strict=True):
        side = int(sign > 0.0)
        ci[j, side] = end
        if kind != "crossing":
            text = _END_NOTES[kind].format(("lower", "upper")[side], end)
            notes.append(f"{problem.law.parameter_names[j]}: {text}")
    if walk.lowest < -_LOWER_MINIMUM * max(chi2_min, 1e-300):
        text = f"a lower minimum was met on the way (χ² {chi2_min + walk.lowest:.6g} < {chi2_min:.6g})"
        notes.append(f"{text}: fit again from more starts")
    return ProfileResult(ci, walk.n_fits, tuple(notes))


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

    def bracket(self) -> None:
        """Walk to where a parabola would end on both sides of every parameter, and further where nothing was crossed."""
        distance = self.reach.copy()
        for _ in range(_DOUBLINGS):
            sides = np.flatnonzero(np.isinf(self.far) & (self.near < self.room))
            if not sides.size:
                return
            over = self.gaps(sides, distance[sides]) >= 0.0
            self.far[sides[over]] = distance[sides[over]]
            self.near[sides[~over]] = distance[sides[~over]]
            distance = np.minimum(2.0 * distance, self.room)

    def refine(self) -> None:
        """Close the brackets on the roots, or on where the law ends before one."""
        sides = np.flatnonzero(np.isfinite(self.far) & (self.far > self.near))
        if sides.size:
            self.near[sides] = rising_root(
                lambda distance, rows: self.gaps(sides[rows], distance),
                self.near[sides],
                self.far[sides],
                _ROOT,
            )

    def ends(self) -> list[tuple[float, EndKind]]:
        """Return the end of every side, and what stops the interval there."""
        ends = self.best[self.parameter] + self.sign * self.near
        endless = np.isinf(self.far)
        kinds: list[EndKind] = np.select(
            [endless & np.isfinite(self.bound), endless], ["bound", "open"], "crossing"
        ).tolist()
        return list(zip(np.where(endless, self.bound, ends).tolist(), kinds, strict=True))


def rising_root(function: Rising, low: FloatArray, high: FloatArray, tolerance: float = _FULL) -> FloatArray:
    """Return the zeros of n functions that rise from below zero at `low` to zero or more at `high`."""

    def finite(x: FloatArray, rows: Rows) -> FloatArray:
        return np.clip(function(x, rows), -_NO_ANSWER, _NO_ANSWER)

    found = find_root(finite, (low, high), args=(np.arange(low.size),), tolerances={"xrtol": tolerance})
    # Where rounding leaves no change of sign, `low` is the zero already.
    return np.where(np.isnan(found.x), low, found.x)


def with_intervals(fit: FitResult, method: str) -> FitResult:
    """Return a fit with `ci95` of its parameters found in another way; all else stays, standard errors too."""
    if method not in INTERVALS:
        text = f"unknown way to intervals {method!r}"
        raise UnknownNameError(text, key="intervals", fix=did_you_mean(str(method), INTERVALS))
    on_bound = any(item.at_bound for item in fit.parameters)
    if method == "covariance" or (method == "auto" and not _needs_profile(fit, on_bound=on_bound)):
        return fit
    found = profile_of(fit)
    parameters = tuple(
        replace(item, ci95=(to_share(low, item.std), to_share(high, item.std))) if item.vary else item
        for item, (low, high) in zip(fit.parameters, found.ci.tolist(), strict=True)
    )
    notes = (*found.notes, *((_BESIDE_A_BOUND,) if on_bound else ()))
    return replace(
        fit,
        parameters=parameters,
        notes=(*fit.notes, "95 % intervals by profile", *notes),
        provenance=dict(fit.provenance) | {"intervals": {"method": method}},
    )


def _needs_profile(fit: FitResult, *, on_bound: bool) -> bool:
    """Return whether a fit that has errors lies on a bound, or in a valley that its covariance does not describe."""
    known = fit.has_errors and fit.weighted() is not None and fit.status is not FitStatus.NOT_CONVERGED
    return known and (on_bound or not is_straight(fit))


def is_straight(fit: FitResult) -> bool:
    """Return whether χ² grows to the ends of the covariance's intervals as a parabola does, within a quarter."""
    problem, best = _weighted(fit), fit.theta
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


def _weighted(fit: FitResult) -> FitProblem:
    """Return the weighed means of a fit; refuse one that has none."""
    if (problem := fit.weighted()) is None:
        text = f"the fit of {fit.law} has no scatter that profiles could rest on"
        raise InputError(text, key="intervals", fix="measure more conditions, or fit the trials again")
    return problem


def profile_of(fit: FitResult) -> ProfileResult:
    """Return the profile intervals of a fit, as wide as its own covariance and degrees of freedom make them."""
    problem = _weighted(fit)
    # χ² believes in variances that are known; the fit's own covariance and Student's t know better.
    variance = np.diag(fit.covariance)
    shown = variance > 0.0
    plain = np.ones_like(variance)
    plain[shown] = np.diag(plain_covariance(problem.jacobian(fit.theta)[:, shown]))
    ratio = np.where(shown & np.isfinite(variance) & (plain > 0.0), variance / plain, 0.0)
    # Of a parameter on its bound no variance is known, but the scatter is the same for all.
    ratio = np.where(ratio > 0.0, ratio, ratio.max(initial=0.0) or 1.0)
    reach = fit.scatter.reach(0.975, variance, np.eye(variance.size)) / float(ndtri(0.975))
    reach = np.where(shown, reach, reach[shown].max(initial=1.0))
    return profile_intervals(problem, fit.theta, scale=ratio * reach**2)


def is_curved(fit: FitResult, conditions: Conditions) -> bool:
    """Return whether ln F_A at conditions, or where it was measured, is no straight function of the parameters."""
    law, moved = fit.friction_law, np.array([1.0 + _MOVED if item.vary else 1.0 for item in fit.parameters])
    ends = np.clip(fit.theta * moved, law.lower, law.upper)
    if not law.admissible(ends, conditions):
        return True
    here, there = (law.jacobian(theta, conditions) for theta in (fit.theta, ends))
    return not np.allclose(here, there, rtol=1e-9, atol=0.0)


def profile_lift(fit: FitResult, conditions: Conditions, half: FloatArray) -> FloatArray:
    """Return how far ln F_A of c conditions may go, shape (c, 2), where the linear interval goes half a width each way.

    A fit that is pulled to a lift force, as by one measurement more, ends on its profile: at the force it reaches it
    follows the data as well as any parameters can. It is pulled until Δχ² is that of a parabola at the linear end.
    """
    base, c, law = _weighted(fit), len(conditions), fit.friction_law
    centre, slopes = law.log_lift(fit.theta, conditions), law.jacobian(fit.theta, conditions)
    shown = fit.shown
    plain = plain_covariance(base.jacobian(fit.theta)[:, shown])
    std = np.sqrt(np.maximum(((slopes[:, shown] @ plain) * slopes[:, shown]).sum(axis=1), 1e-300))
    k, root = base.n_points, None
    pull = _PULL * std
    if base.root is not None:
        root = np.zeros((k + c, k + c))
        root[:k, :k], root[range(k, k + c), range(k, k + c)] = base.root, 1.0 / pull
    problem = replace(
        base, conditions=base.conditions.joined(conditions), log_lift=np.append(base.log_lift, centre),
        std=np.append(base.std, pull), group=np.arange(k + c), root=root,
    )  # fmt: skip
    best = batched_fit(base, starts=fit.theta)
    least, origin = float(best.chi2[0]), law.log_lift(best.theta[0], conditions)
    row, sign = np.repeat(np.arange(c), 2), np.tile([-1.0, 1.0], c)
    wanted, reach = (half / std)[row], np.full(2 * c, 0.0)
    own = np.zeros((2 * c, k + c))
    own[:, :k] = 1.0
    own[range(2 * c), k + row] = 1.0
    data = np.tile(problem.log_lift, (2 * c, 1))
    starts = np.tile(best.theta[0], (2 * c, 1))
    # The pull's own place: further than the force that it reaches, since the data hold against it.
    target, low, high = wanted * std[row] * (1.0 + _PULL**2), np.zeros(2 * c), np.full(2 * c, inf)
    for _ in range(_STEPS):
        data[range(2 * c), k + row] = origin[row] + sign * target
        fits = batched_fit(problem, data, starts, multiplicity=own, tolerance=_TOLERANCE)
        values = law.log_lift(fits.theta, conditions)[range(2 * c), row] if c else np.zeros(0)
        pulled = ((values - data[range(2 * c), k + row]) / pull[row]) ** 2
        gone = np.sqrt(np.maximum(fits.chi2 - pulled - least, 0.0))
        reach, starts = sign * (values - origin[row]), fits.theta
        if (np.abs(gone - wanted) <= _FOUND * wanted).all():
            break
        low, high = np.where(gone < wanted, target, low), np.where(gone < wanted, high, target)
        step = target * np.clip(wanted / np.maximum(gone, 1e-300), 0.2, 4.0)
        inside = (step > low) & (step < high)
        target = np.where(inside, step, np.where(np.isinf(high), 2.0 * target, 0.5 * (low + high)))
    reach = np.maximum(reach, 0.0).reshape(c, 2)
    return np.stack([origin - reach[:, 0], origin + reach[:, 1]], axis=1)
