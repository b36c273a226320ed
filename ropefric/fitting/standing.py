"""How a law stands on condition means: its likelihood, each mean left out, and against a simpler law.

Residuals are those of the force that was measured: the lift force or, where a known weight is lifted, the end tension.
Where the load is set and the slack side is measured, ln F_A has no scatter at all, and a law that answers the same F_A
whatever the end tension would seem perfect. Such a law says nothing of the force that was measured, and dividing by
∂ ln F_A/∂ ln F_B shows it.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.special import stdtr

from ropefric.arrays import BoolArray, FloatArray, IntArray
from ropefric.errors import InputError
from ropefric.fitting.problem import FitProblem, batched_fit, typical_mu
from ropefric.fitting.result import RIVAL
from ropefric.fitting.statistics import ConditionMeans, ScatterFit, aicc, bic, decomposed, f_test, scatter_fit
from ropefric.friction.condition import SETTINGS, Conditions
from ropefric.friction.law import Columns, Refusal

CHANCE = 0.03
"""Share of simulated campaigns above which a lead is put down to chance.

At 0.05 a fuller law was preferred in 4 to 6 % of 1000 campaigns of the constant law, for 199 draws know the share to
1.5 %; so the limit is lower, for at most 5 % in every design.
"""

STRONG = 6.0
"""Difference of AICc from which on an effect is supported: it makes the data e^3 = 20 times likelier after its price."""

# Weights and parameters depend on each other only where conditions have unequal numbers of repeats.
_ROUNDS = 4
# Of ln F_B, for how the slope by it changes with the parameters; the error is a millionth of a small correction.
_STEP = 1e-6
# In standard errors, and steps: enough to know a deviance by which laws are told apart.
_NEAR, _STEPS, _SEARCHES = 0.1, 60, 4
# Of AICc: in 2 of 10 000 simulated data sets another start gained more.
_WITHIN_REACH = 6.0
# Simulated data sets after which so many that lead are enough: the share is then known to a third of itself.
_FIRST, _ENOUGH = 49, 10
# Another start may lead to a better place if it is no worse than this many times what was found.
_HOPEFUL = 2.0
# A wild trial: so many standard deviations off the others, and once in so many tables by chance.
_FAR, _WILD = 8.0, 1e-4
# From so many conditions on, leaving one out is one step of the fit.
_MANY = 400
_TURN_RAD = 2.0 * math.pi
_LEAST_DOF, _UNJUDGED, _EXACT = 5, 1e-3, 1e-6


class FTest(NamedTuple):
    """Whether a law's extra parameters explain more than chance."""

    simpler: str
    fuller: str
    f: float
    dof: tuple[int, int]
    p_value: float


Preferred = Literal["simpler", "fuller", "undecided"]


class Contest(NamedTuple):
    """Whether conditions prefer a fuller law to a simpler one, by three criteria that need not agree.

    Attributes
    ----------
    simpler, fuller : str
        The laws.
    lead : float
        By how much the AICc of the fuller law is lower.
    p_value : float
        Share of data simulated from the simpler law in which some law fuller than it leads by as much (bootstrap); of
        the F-test where that is below 1e-5.
    loco_ratio : float
        Error of the fuller law at conditions left out over that of the simpler one; NaN where one is not known.
    """

    simpler: str
    fuller: str
    lead: float
    p_value: float
    loco_ratio: float

    @property
    def preferred(self) -> Preferred:
        """Return the law to use: the fuller where all say so, the simpler where chance alone gives such a lead."""
        by_chance = self.p_value > CHANCE
        if self.lead > 0.0 and not by_chance and not self.loco_ratio > 1.0:
            return "fuller"
        return "simpler" if by_chance and self.lead <= RIVAL else "undecided"

    @property
    def text(self) -> str:
        """Return the three findings in words."""
        low, side = self.simpler, "below" if self.lead > 0.0 else "above"
        text = f"the AICc of {self.fuller} is {abs(self.lead):.1f} {side} that of {low}; so large a lead comes from "
        text += f"{low} alone in {self.p_value:.2g} of simulated campaigns"
        if not math.isnan(self.loco_ratio):
            text += f", and its error at unseen conditions is {self.loco_ratio:.2f} times that of {low}"
        return text


class Standing(NamedTuple):
    """A law fitted to condition means, in the lift force or in the end tension."""

    problem: FitProblem
    theta: FloatArray
    scatter: ScatterFit
    chi2: float
    k: int
    aicc: float
    bic: float


def wild_trial(problem: FitProblem, *, slack: bool) -> int | None:
    """Return which trial alone lies far off straight trends of μ with every setting; None if none does.

    By its deleted residual, in the scatter of all the others: what one trial does to the whole cannot hide it.
    """
    at, rise = problem.conditions, problem.log_lift - problem.conditions.log_end_tension
    wrap = at.wrap_angle_rad
    load = problem.log_lift if slack else at.log_end_tension
    levels = (np.exp(load - load.min()), at.size_ratio, np.maximum(wrap, 1e-9))
    trends = (np.log(level) * wrap for level in levels)
    svd = decomposed(np.stack([wrap, np.ones_like(wrap), *trends], axis=-1))
    left = svd.left[:, ~svd.lost]
    residual, own = rise - left @ (left.T @ rise), 1.0 - (left**2).sum(axis=1)
    dof = rise.size - left.shape[1] - 1
    if dof < _LEAST_DOF or np.abs(residual).max() < _EXACT:
        return None
    judged = own > _UNJUDGED
    square = np.where(judged, residual**2 / np.maximum(own, _UNJUDGED), 0.0)
    rest = np.maximum(float(residual @ residual) - square, 1e-300) / dof
    t = np.sqrt(square / rest)
    worst = int(np.argmax(t))
    p_value = 2.0 * rise.size * float(stdtr(dof, -t[worst]))
    return worst if t[worst] > _FAR and p_value < _WILD else None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _SetLoads(Conditions):
    """Conditions at which the lift force was set, and the end tension measured."""

    log_lift: FloatArray


class _EndTension(NamedTuple):
    """The physics of a law seen from the end tension, to first order.

    Its ln F_A is as far off the one that was set as the law's ln F_B is off the measured one, the other way:
    (ln F_A − set)/(∂ ln F_A/∂ ln F_B). A slope of zero leaves the end tension open, however small the rest.
    """

    physics: Any

    def rise_and_slopes(self, columns: Columns, conditions: _SetLoads) -> tuple[FloatArray, Columns]:
        """Return the rise as seen, and its slopes by the parameters."""
        known = conditions.log_lift - conditions.log_end_tension
        rise, slopes = self.physics.rise_and_slopes(columns, conditions)
        slope = np.maximum(self.physics.condition_slopes(columns, conditions)[2], 1e-12)
        more = replace(conditions, end_tension_N=conditions.end_tension_N * (1.0 + _STEP))
        after = self.physics.rise_and_slopes(columns, more)[1]
        off = (rise - known) / slope
        # The slope by ln F_B changes with a parameter as the slope by the parameter changes with ln F_B.
        seen = ((by - off * (later - by) / _STEP) / slope for by, later in zip(slopes, after, strict=True))
        return known + off, tuple(seen)

    def rise(self, columns: Columns, conditions: _SetLoads) -> FloatArray:
        """Return the rise as seen."""
        return self.rise_and_slopes(columns, conditions)[0]

    def refusals(self, columns: Columns, conditions: _SetLoads) -> Iterable[Refusal]:
        """Return where the law itself has no answer."""
        return tuple(self.physics.refusals(columns, conditions))


def standing(
    problem: FitProblem, means: ConditionMeans, theta: npt.ArrayLike, *, slack: bool = False
) -> Standing:
    """Return how the law of a problem stands on condition means, in the force that was measured."""
    starts, K = np.atleast_2d(np.asarray(theta, dtype=np.float64)), len(means)
    law, conditions = problem.law, means.conditions
    if slack and "end-tension" in law.effects:
        seen: Any = _EndTension(law.physics)
        law = replace(law, physics=seen)
        settings = {name: getattr(conditions, name) for name in SETTINGS}
        conditions = _SetLoads(log_lift=means.log_lift, **settings)
        # A fit of ln F_A may have gone to where F_A does not depend on F_B, from which no gradient leads back.
        declared = [parameter.start for parameter in law.parameters]
        starts = np.vstack([starts, np.where(problem.vary, declared, starts)])
    on_means = replace(
        problem, law=law, conditions=conditions, log_lift=means.log_lift, std=means.std, group=np.arange(K)
    )
    for _ in range(_ROUNDS):
        at = refit(on_means, starts)
        residual = law.log_lift(at, conditions) - means.log_lift
        scatter = scatter_fit(residual, means)
        on_means = replace(on_means, std=np.sqrt(scatter.variance))
        starts = np.vstack([at, starts[1:]])
        if not means.repeated or float(np.ptp(means.std)) <= 1e-9 * float(means.std[0]):
            break
    k, deviance = problem.n_varying + 1, float(scatter.deviance)
    chi2 = float((residual**2 / scatter.variance).sum())
    return Standing(on_means, at, scatter, chi2, k, aicc(deviance, K, k), bic(deviance, K, k))


def refit(problem: FitProblem, starts: FloatArray) -> FloatArray:
    """Return the parameters of the best of some searches, or of the starts."""
    found = batched_fit(problem, starts=starts)
    best = int(np.argmin(found.chi2))
    return np.asarray((found.theta if np.isfinite(found.chi2[best]) else starts)[best])


def leave_one_out(law: Standing) -> float:
    """Return the leave-one-condition-out error: RMS of the ln F predicted by a fit to all other means, less measured.

    This is the relative error of the force at conditions the law has not seen. NaN where the other means cannot fix
    the parameters or a refit fails. K refits of K means grow as K²; of many, each is one
    step from the common fit, residual/(1 − leverage), which errs by the square of a leverage.
    """
    problem, K = law.problem, law.problem.n_points
    if K > _MANY:
        inside = problem.vary & (law.theta > problem.lower) & (law.theta < problem.upper)
        left = decomposed(problem.jacobian(law.theta)[:, inside]).root()[1]
        own = problem.law.log_lift(law.theta, problem.conditions) - problem.log_lift
        return float(np.sqrt(np.mean((own / (1.0 - (left**2).sum(axis=1))) ** 2)))
    found = batched_fit(problem, starts=law.theta, multiplicity=1.0 - np.eye(K))
    if not (found.converged & problem.law.admissible(found.theta, problem.conditions)).all():
        return math.nan
    missed = np.diagonal(problem.law.log_lift(found.theta, problem.conditions) - problem.log_lift)
    return float(np.sqrt(np.mean(missed**2)))


def searched(
    problem: FitProblem,
    log_lift: FloatArray,
    theta: FloatArray,
    worth: Callable[[FloatArray], BoolArray] = lambda theta: np.ones(len(theta), dtype=np.bool_),
) -> FloatArray:
    """Return the parameters that fit m data sets at the conditions of a problem, each the best of many starts.

    The solution of one data set is a start for the others too, so that all are searched as well as the first was; but
    only those that are worth it as they stand.
    """
    law, at = problem.law, problem.conditions
    how: dict[str, Any] = {"tolerance": _NEAR, "max_iterations": _STEPS * max(problem.n_varying - 2, 1)}
    mu = max(typical_mu(at, log_lift[0]), 1e-3)
    starts = [problem.start, *np.asarray(law.candidates(mu, at, log_lift[0]), np.float64)]
    pool = np.clip(np.stack(starts), problem.lower, problem.upper)
    pool = np.where(problem.vary, pool, problem.start)
    fits = batched_fit(problem, log_lift, theta, **how)
    for _ in range(_SEARCHES):
        pool, rows = pool[law.admissible(pool, at)], np.flatnonzero(worth(fits.theta))
        if not len(pool) or not rows.size:
            break
        lifts, chi2 = law.log_lift(pool, at), fits.chi2[rows]
        costs = ((log_lift[rows, np.newaxis] - lifts) ** 2 / problem.std**2).sum(axis=-1)
        nearest = np.argmin(np.where(np.isclose(costs, chi2[:, np.newaxis]), np.inf, costs), axis=1)
        hopeful = costs[np.arange(rows.size), nearest] <= _HOPEFUL * chi2
        rows, nearest = rows[hopeful], nearest[hopeful]
        if not rows.size:
            break
        again = batched_fit(problem, log_lift[rows], pool[nearest], **how)
        better = again.chi2 < fits.chi2[rows]
        fits.theta[rows[better]], fits.chi2[rows[better]] = again.theta[better], again.chi2[better]
        pool = fits.theta
    return fits.theta


def lead_by_chance(
    simpler: Standing, fuller: Standing, family: Iterable[Standing], means: ConditionMeans, *, n: int = 199
) -> float:
    """Return in which share of data from the simpler law the best of a family leads it by as much as the fuller does.

    A parametric bootstrap of the means, with the scatter of repeats drawn anew as well: it knows what AICc, made for
    many conditions, does not, the bounds of the parameters and how many laws were tried. It ends early where the lead is
    common (Besag and Clifford 1991), and searches further only where that may bring a data set to the lead.
    """
    K, spare, rng = len(means), int(means.size.sum()) - len(means), np.random.default_rng(0)
    variance, p = simpler.scatter.variance, simpler.problem.n_varying
    # The likeliest scatter of K residuals is too small by what the p parameters took.
    drawn = variance * (K / (K - p)) if simpler.scatter.between > 0.0 else variance
    centre = simpler.problem.law.log_lift(simpler.theta, simpler.problem.conditions)
    others = centre + np.sqrt(drawn) * rng.standard_normal((n, K))
    # The first is the data.
    log_lift = np.vstack([simpler.problem.log_lift, others])
    factor = np.append(1.0, rng.chisquare(spare, n) / spare) if means.repeated else np.ones(n + 1)
    laws = sorted(family, key=lambda stands: stands.k)

    def criteria(stands: Standing, rows: IntArray, least: FloatArray) -> FloatArray:
        """Return the AICc of a law on some data sets, surely the lowest only where it may be below the least."""
        law, at = stands.problem.law, stands.problem.conditions

        def of(theta: FloatArray) -> FloatArray:
            missed = law.log_lift(theta, at) - log_lift[rows]
            value = np.full(rows.size, np.inf)
            solved = np.isfinite(missed).all(axis=1)
            value[solved] = scatter_fit(missed[solved], means, factor[rows[solved]]).deviance
            return value + aicc(0.0, K, stands.k)

        def worth(theta: FloatArray) -> BoolArray:
            value = of(theta)
            return (value > least) & (value < least + _WITHIN_REACH)

        return of(
            searched(replace(stands.problem, std=np.sqrt(variance)), log_lift[rows], stands.theta, worth)
        )

    first, surely = np.zeros(1, dtype=np.int64), np.full(1, -np.inf)
    own = float((criteria(simpler, first, surely) - criteria(fuller, first, surely))[0]) - 1e-9
    leading = tried = 0
    for block in np.split(np.arange(1, n + 1), [_FIRST]):
        behind, tried = block, tried + block.size
        least = criteria(simpler, block, np.full(block.size, -np.inf)) - own
        for stands in laws:
            if behind.size:
                still = criteria(stands, behind, least) > least
                behind, least = behind[still], least[still]
        leading += block.size - behind.size
        if leading >= _ENOUGH:
            break
    return (1.0 + leading) / (1.0 + tried)


def beyond_first_turn(conditions: Conditions, touching_turns: float | None = None) -> FloatArray:
    """Return the wrap of turns that touch the one beside them [rad]: all beyond the first, or at most so many."""
    turns = math.inf if touching_turns is None else touching_turns
    if not turns >= 0.0:
        message = f"touching_turns is {turns:g}"
        raise InputError(message, fix="say how many turns touch the one beside them, 0 or more")
    return np.clip(conditions.wrap_angle_rad - _TURN_RAD, 0.0, _TURN_RAD * turns)


def straight_fit(X: FloatArray, rise: FloatArray, means: ConditionMeans) -> tuple[FloatArray, ScatterFit]:
    """Return the coefficients of columns, and the scatter of the means about them that makes them likeliest."""
    root = means.std
    for _ in range(_ROUNDS):
        theta = np.asarray(np.linalg.lstsq(X / root[:, None], rise / root, rcond=None)[0])
        scatter = scatter_fit(X @ theta - rise, means)
        before, root = root, np.sqrt(scatter.variance)
        if (root == before).all():
            break
    return theta, scatter


def contact_trend(means: ConditionMeans, touching_turns: float | None, best: float) -> dict[str, float]:
    """Return how much larger μ is where coils touch, the AICc of that beside a constant μ, and its lead on the best.

    Nothing where no turn touches another, or μ is not larger there.
    """
    at = means.conditions
    X = np.stack([at.wrap_angle_rad, beyond_first_turn(at, touching_turns)], axis=-1)
    if np.linalg.matrix_rank(X, tol=1e-6 * float(np.linalg.norm(X))) < 2:
        return {}
    theta, scatter = straight_fit(X, means.log_lift - at.log_end_tension, means)
    slope, value = float(theta[1]), aicc(float(scatter.deviance), len(means), 3)
    told = slope > 0.0 and math.isfinite(value) and math.isfinite(best)
    return {"slope": slope, "aicc": value, "lead": best - value} if told else {}


def nested_test(simpler: Standing, fuller: Standing) -> FTest | None:
    """Return the test of two laws, both weighted as the fuller; None without degrees of freedom.

    Where the simpler law lies on a bound of the fuller (a = 0), the p-value is too large rather than too small.
    """
    n, p_simpler, p_fuller = fuller.problem.n_points, simpler.problem.n_varying, fuller.problem.n_varying
    if n <= p_fuller or p_fuller <= p_simpler:
        return None
    weighted = replace(simpler.problem, std=fuller.problem.std)
    chi2 = float((weighted.residuals(refit(weighted, simpler.theta[np.newaxis])) ** 2).sum())
    found = f_test(chi2, fuller.chi2, n=n, p_simpler=p_simpler, p_fuller=p_fuller)
    return FTest(simpler.problem.law.name, fuller.problem.law.name, *found)
