"""A friction law fitted to a trial table: ln F_A by weighted least squares through the integral.

The search goes from several starts, with weights that follow the parameters; `result` makes of it what a fit hands on.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from math import sqrt
from typing import Any

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray, IntArray
from ropefric.errors import InputError
from ropefric.files.plain_text import significant, to_share
from ropefric.fitting.problem import (
    LOSSES,
    FitProblem,
    FitSettings,
    Loss,
    batched_fit,
    check_settings,
    law_named,
    reduced,
)
from ropefric.fitting.result import CommonError, FitResult, Found, assemble
from ropefric.fitting.statistics import RANK_RATIO, Scatter, decomposed, pooled_scatter
from ropefric.friction.condition import Conditions, levels
from ropefric.friction.law import FrictionLaw
from ropefric.trials.table import TrialTable

# Beyond this the squares of residuals and slopes, and their sums, are no floats.
_LARGEST = 1e100
# Weights depend on the parameters through the errors of the settings; they settle in two rounds.
_ROUNDS = 5
_SETTLED = 1e-4
# Scatter so small that it is rounding; weights need some number.
_SMALLEST_STD = 1e-12
_MAD_TO_STD = 1.4826
# How far other starts are spread, as a factor e^±this.
_SPREAD = 0.7
# Minima closer than this in χ² describe the data equally well (two standard deviations).
_AS_GOOD = 4.0
_APART = 0.01
# χ² that differs by this part of itself, or of one, is the same.
_SAME_COST = 1e-8
# From this ratio of the best to the worst known combination on, parameters are rounded one after the other.
_TRADED = 300.0
# In standard errors: what is written starts alike on every machine.
_TIGHT = 1e-13
_NOTHING = 1e-150
# Closer to a bound than this, by the larger of its size and the value's, an estimate is tried on the bound.
_NEAR_BOUND = 1e-4
# What a step onto a bound may cost in χ².
_FREE = 1e-6
# A gain in χ² by this part of the mean squared residual is no gain, among combinations of at least this size.
_FLAT = 1e-3
_FLAT_RANK = 1e-6
_STEP = 1e-5
_SETTINGS_STD = ("wheel_radius_std_m", "wrap_std_rad", "rope_radius_std_m")
COMMON: tuple[tuple[Callable[[Any], str], str], ...] = (
    (lambda cell: f"calibration of cell {cell}" if cell else "calibration of the force cell", "-"),
    (lambda force_N: f"weights of {force_N:.4g} N" if force_N else "the second force cell", "-"),
    (lambda radius_m: f"radius of the wheels of {1e3 * radius_m:.4g} mm", "m"),
    (lambda wrap_rad: f"setting of the wrap of {math.degrees(wrap_rad):.4g} deg", "rad"),
    (lambda rope: f"radius of the rope {rope if isinstance(rope, str) else f'of {1e3 * rope:.4g} mm'}", "m"),
)
"""What conditions can have in common, in words, and its unit: cell, load, wheel, wrap, rope."""


def fit_law(table: TrialTable, law: str | FrictionLaw, **settings: Any) -> FitResult:
    """Return a law fitted to the used trials of a table; `FitSettings` says how it can be made, None for its defaults.

    A doubtful result comes back with a status that says so; see `FitResult.status`.
    """
    chosen = law_named(law)
    how = FitSettings(**{name: value for name, value in settings.items() if value is not None})
    check_settings(how, chosen)
    table = table.of(how.of)
    how = replace(how, of=table.force)
    return assemble(_search(_problem_of(table, chosen, how), table, how), table, how)


def _problem_of(table: TrialTable, law: FrictionLaw, settings: FitSettings) -> FitProblem:
    """Return the data of a table as a least-squares problem with equal weights, start values and bounds."""
    if not table.used.any():
        fix = "check the columns kept and status"
        raise InputError("no trial of the table can be used", code="RF410", fix=fix)
    conditions, log_lift = table.conditions(), table.log_lift()
    for name in ("size_ratio", "wrap_angle_rad"):
        if (beyond := getattr(conditions, name) > _LARGEST).any():
            at = conditions.describe(int(np.argmax(beyond)))
            text = f"{name} is above {_LARGEST:g} at {at}: no sum of squares holds it"
            raise InputError(text, code="RF410", fix="correct the trial or its units, or leave it out")
    spans = [settings.bounds.get(item.name, (item.lower, item.upper)) for item in law.parameters]
    lower, upper = np.array(spans, dtype=np.float64).T
    given = {item.name: item.start for item in law.parameters if item.fixed}
    given |= {**settings.start, **settings.fixed}
    found = np.clip(guess(law, conditions, log_lift), lower, upper)
    start = np.array([given.get(n, g) for n, g in zip(law.parameter_names, found, strict=True)], np.float64)
    held = {item.name for item in law.parameters if item.fixed} - {*settings.start, *settings.bounds}
    vary = [name not in held | {*settings.fixed} for name in law.parameter_names]
    for name, value, low, high in zip(law.parameter_names, start, lower, upper, strict=True):
        if not low <= value <= high:
            text = f"the start value {name} = {value:g} lies outside its bounds {low:g} … {high:g}"
            raise InputError(text, code="RF402", key=name, fix="start inside the bounds, or widen them")
    if not law.admissible(start, conditions):
        law.log_lift(start, conditions)  # raises, and says why and what to do
    return FitProblem(
        law=law,
        conditions=conditions,
        log_lift=log_lift,
        std=np.ones_like(log_lift),
        group=table.group(),
        start=start,
        lower=lower,
        upper=upper,
        vary=np.array(vary),
    )


# ---- what each trial weighs ----


def shared_variance(law: FrictionLaw, theta: FloatArray, table: TrialTable) -> FloatArray:
    """Return the variance of ln F_A that all repeats of a condition share, shape (n,).

    The instrument's (u_F/F_A)² and those of the settings, (∂ ln F_A/∂φ u_φ)² + (∂ ln F_A/∂R_w u_R)² +
    (∂ ln F_A/∂ ln F_B · u_{F_B}/F_B)²: a wheel, a weight and a force cell are the same for every repeat, so these
    do not average out over them.
    """
    used = table.used
    # What overflows is refused right after.
    with np.errstate(over="ignore", invalid="ignore"):
        variance: FloatArray = np.nan_to_num(table.peak_std_N[used] / table.peak_N[used]) ** 2
        end_tension = table.end_tension_std_N[used] / table.end_tension_N[used]
        settings = np.stack([table.wheel_radius_std_m[used], table.wrap_std_rad[used], end_tension], axis=-1)
        if settings.any():
            slopes = law.log_lift_gradient_conditions(theta, table.conditions())
            variance = variance + ((slopes * settings) ** 2).sum(axis=-1)
    wrong = ~np.isfinite(variance)
    if wrong.any():
        trial = np.array(table.trial)[used][int(np.argmax(wrong))]
        text = f"the uncertainties given for trial '{trial}' amount to more than any number of ln F_A"
        raise InputError(text, code="RF410", fix="correct the columns that end in _std")
    return variance


def common_errors(
    problem: FitProblem, theta: FloatArray, table: TrialTable
) -> tuple[tuple[CommonError, ...], FloatArray]:
    """Return the errors that several conditions share, and by how much one standard uncertainty of each moves ln F_A.

    Shape (n, b). A force cell is the same in all its trials; a wheel, a rope, a weight and a wrap setting are in every
    condition that has them, each rope by its name where it has one. What belongs to one condition only is part of the
    scatter between conditions.
    """
    used, at, law = table.used, problem.conditions, problem.law
    is_slack = table.measures_slack

    def of(name: str) -> FloatArray:
        return np.asarray(getattr(table, name), np.float64)[used]

    tight, slack = (of("peak_N"), of("peak_std_N")), (of("end_tension_N"), of("end_tension_std_N"))
    (read_N, read_std_N), (set_N, set_std_N) = (slack, tight) if is_slack else (tight, slack)
    own = of("cell_std_N")
    shares = np.nan_to_num(np.where(np.isnan(own), read_std_N, own)) / read_N
    stated = (shares, np.nan_to_num(set_std_N) / set_N, *map(of, _SETTINGS_STD))
    if not any(values.any() for values in stated):
        return (), np.zeros((used.sum(), 0))
    slopes = law.log_lift_gradient_conditions(theta, at)
    by_force = (slopes[:, 2], np.ones(len(at))) if is_slack else (np.ones(len(at)), slopes[:, 2])
    if not np.isnan(of("end_tension_set_N")).all():  # a second cell, which all trials share
        set_N = np.zeros_like(set_N)
    by_rope = rope_slopes(law, theta, at) if stated[4].any() else np.zeros(len(at))
    names = {name: np.array(words)[used] for name, words in table.labels.items()}
    cells, ropes = names.get("cell", np.full(len(at), "")), names.get("rope_id", at.rope_radius_m)
    values = (cells, set_N, at.wheel_radius_m, at.wrap_angle_rad, ropes)
    kinds = zip(COMMON, stated, (*by_force, *slopes.T[:2], by_rope), values, strict=True)
    found, effects = list[CommonError](), list[FloatArray]()
    for (words, unit), std, slope, value in kinds:
        number = np.unique(value, return_inverse=True)[1] if value.dtype.kind == "U" else levels(value)
        for one in np.unique(number[std > 0.0]):
            here = (number == one) & (std > 0.0)
            if np.ptp(problem.group[here]):
                found.append(CommonError(words(value[here][0]), unit, float(std[here].max()), ()))
                effects.append(np.where(here, std * slope, 0.0))
    return tuple(found), np.stack(effects, axis=-1) if effects else np.zeros((used.sum(), 0))


def rope_slopes(law: FrictionLaw, theta: FloatArray, at: Conditions) -> FloatArray:
    """Return ∂ ln F_A/∂R_r [1/m] by central differences, shape (n,): no law has it in closed form."""
    radius_m = at.rope_radius_m
    ends = [law.log_lift(theta, replace(at, rope_radius_m=radius_m * s)) for s in (1 + _STEP, 1 - _STEP)]
    return np.asarray((ends[0] - ends[1]) / (2.0 * _STEP * radius_m))


def trial_std(within: float, shared: FloatArray, group: IntArray) -> FloatArray:
    """Return the standard deviation that a trial enters a least-squares fit with, shape (n,).

    σ² = s_w² + n_c u². Independent trials with this variance give the condition's mean the variance s_w²/n_c + u²,
    and so the same estimates and covariance as generalised least squares with the correlated covariance
    s_w² I + u² 1 1ᵀ, because a law is constant over the repeats of a condition.
    """
    return np.sqrt(within**2 + np.bincount(group)[group] * shared)


def _weighed(
    problem: FitProblem, table: TrialTable, theta: FloatArray, loss: Loss
) -> tuple[FitProblem, Scatter, FloatArray]:
    residuals = problem.log_lift - problem.law.log_lift(theta, problem.conditions)
    scatter = pooled_scatter(residuals, problem.group)
    shared = shared_variance(problem.law, theta, table)
    dof = max(problem.n_points - problem.n_varying, 1)
    if loss != "linear":
        # Outliers must not widen the yardstick that is to tell them.
        within = _MAD_TO_STD * float(np.median(np.abs(residuals - np.median(residuals))))
    elif scatter.known:
        within = scatter.within
    else:
        within = sqrt(max(float(residuals @ residuals) / dof - float(shared.mean()), 0.0))
    std = np.maximum(trial_std(within, shared, problem.group), _SMALLEST_STD)
    return replace(problem, std=std), scatter, shared


# ---- the search ----


def _search(problem: FitProblem, table: TrialTable, settings: FitSettings) -> Found:
    """Return the best minimum, with weights taken at it."""
    loss = settings.loss
    weighed, scatter, shared = _weighed(problem, table, problem.start, loss)
    theta, converged, notes = _minimum(weighed, _starts(weighed, settings), loss)
    for _ in range(_ROUNDS):
        before = weighed.std
        weighed, scatter, shared = _weighed(problem, table, theta, loss)
        if np.allclose(weighed.std, before, rtol=_SETTLED, atol=0.0):
            break
        theta, converged, _same = _minimum(weighed, theta, loss)
    at_bound = problem.vary & ((theta <= problem.lower) | (theta >= problem.upper))
    if loss == "linear":
        theta = _rounded(weighed, theta, at_bound)
    # The weights of the very parameters that are handed on.
    weighed, scatter, shared = _weighed(problem, table, theta, loss)
    common, effects = common_errors(problem, theta, table)
    return Found(
        problem=weighed, theta=theta, at_bound=at_bound, converged=converged, scatter=scatter, shared=shared,
        notes=notes, common=common, effects=effects,
    )  # fmt: skip


def _starts(problem: FitProblem, settings: FitSettings) -> FloatArray:
    """Return the start and others spread about it, shape (m, p); a law of one parameter has one minimum."""
    if problem.n_varying < 2:
        return problem.start[np.newaxis]
    rng = np.random.default_rng(settings.seed)
    others = problem.start * np.exp(rng.normal(0.0, _SPREAD, (settings.n_starts - 1, problem.start.size)))
    others = np.clip(np.where(problem.vary, others, problem.start), problem.lower, problem.upper)
    return np.vstack([problem.start, others[problem.law.admissible(others, problem.conditions)]])


def _minimum(problem: FitProblem, starts: FloatArray, loss: Loss) -> tuple[FloatArray, bool, tuple[str, ...]]:
    """Return the best end of the searches from some starts, whether it is a minimum, and others as good in words."""
    ends = batched_fit(problem, starts=starts, loss=loss, tolerance=_TIGHT)
    least = np.nanmin(ends.chi2)
    # Several starts end in one valley, and the last bits may not say at which of its places, nor which of them creeps
    # on: the first one that has arrived stands, or else the first.
    low = np.flatnonzero(ends.chi2 <= least + _SAME_COST * (1.0 + least))
    best = low[np.argmax(ends.converged[low])]
    theta, cost = ends.theta[best], float(ends.chi2[best])
    if not ends.converged[best]:
        theta, cost = _end_of_the_valley(problem, theta, cost, loss)
    size = np.maximum(np.maximum(np.abs(ends.theta), np.abs(theta)), 1e-6)
    apart = (np.abs(ends.theta - theta) > _APART * size)[:, problem.vary].any(axis=1)
    rivals = np.flatnonzero(ends.converged & (ends.chi2 - cost < _AS_GOOD) & apart)
    notes: tuple[str, ...] = ()
    if rivals.size:
        rival = rivals[np.argmin(ends.chi2[rivals])]
        mapping = problem.law.as_mapping(ends.theta[rival])
        values = ", ".join(f"{name} = {value:.4g}" for name, value in mapping.items())
        more = significant(float(ends.chi2[rival] - cost), 2, smallest=_SAME_COST * (1.0 + cost))
        notes = (f"another minimum is as good (χ² larger by {more:.2g}): {values}",)
    theta = _onto_bounds(problem, theta, loss)
    return theta, bool(ends.converged[best]) or _is_flat(problem, theta, loss), notes


def _is_flat(problem: FitProblem, theta: FloatArray, loss: Loss) -> bool:
    """Return whether the next step would gain nothing that counts, though the search may creep on for ever.

    Along a valley, where parameters can be traded for each other, the steps never get small.
    """
    residuals, jacobian = problem.residuals_and_jacobian(theta)
    inside = problem.vary & (theta > problem.lower) & (theta < problem.upper)
    cost, weights = LOSSES[loss](residuals**2)
    svd = decomposed(jacobian[:, inside], weights)
    seen = svd.values > _FLAT_RANK * svd.values.max(initial=0.0)
    along = svd.left[:, seen].T @ (residuals * np.sqrt(weights))
    return bool(along @ along <= _FLAT * float(cost.sum()) / residuals.size)


def _end_of_the_valley(
    problem: FitProblem, theta: FloatArray, cost: float, loss: Loss
) -> tuple[FloatArray, float]:
    """Return the bound that a search creeps towards, where it leads lower; how far it got hangs on the last bits."""
    index = np.repeat(np.flatnonzero(problem.vary), 2)
    bound = np.stack([problem.lower, problem.upper], axis=-1)[problem.vary].ravel()
    rows = np.arange(index.size)
    starts, vary = (np.tile(row, (index.size, 1)) for row in (theta, problem.vary))
    starts[rows, index], vary[rows, index] = bound, False
    good = np.flatnonzero(np.isfinite(bound) & vary.any(axis=1))
    good = good[problem.law.admissible(starts[good], problem.conditions)]
    if not good.size:
        return theta, cost
    ends = batched_fit(problem, starts=starts[good], vary=vary[good], loss=loss, tolerance=_TIGHT)
    best = int(np.argmin(ends.chi2))
    return (ends.theta[best], float(ends.chi2[best])) if ends.chi2[best] < cost else (theta, cost)


def _onto_bounds(problem: FitProblem, theta: FloatArray, loss: Loss) -> FloatArray:
    """Return theta with every parameter on its bound that is close to it for no gain, the others fitted anew."""
    data, moved = reduced(problem, loss=loss), theta
    cost = data.chi2(theta[np.newaxis])[0]
    for i in np.flatnonzero(problem.vary & (theta > problem.lower) & (theta < problem.upper)):
        for bound in (problem.lower[i], problem.upper[i]):
            close = abs(moved[i] - bound) <= _NEAR_BOUND * max(abs(bound), abs(moved[i]), 1.0)
            if np.isfinite(bound) and close:
                on_it = moved.copy()
                on_it[i] = bound
                if data.chi2(on_it[np.newaxis])[0] <= cost * (1.0 + _FREE) + _FREE:
                    moved = on_it
    if moved is theta:
        return theta
    inside = problem.vary & (moved > problem.lower) & (moved < problem.upper)
    return np.asarray(batched_fit(problem, starts=moved, vary=inside, loss=loss, tolerance=_TIGHT).theta[0])


def _rounded(problem: FitProblem, best: FloatArray, at_bound: BoolArray) -> FloatArray:
    """Return the minimum to the digits that mean something, so that all that follows starts alike on every machine.

    Each parameter is rounded by its error with the others held, which raises χ² by 1e-8 at most. Where parameters
    can be traded for each other that error is far below what the search knows of each, so they are rounded one
    after the other, the least known first and by its whole error, and those that are left are fitted anew.
    """
    theta = best.copy()
    free = problem.vary & ~at_bound & (problem.jacobian(theta) != 0.0).any(axis=0)
    while np.count_nonzero(free) > 1:
        index, std, ratio = _least_known(problem, theta, free)
        if ratio < _TRADED:
            break
        held = theta.copy()
        own, value = float(theta[index]), to_share(float(theta[index]), std)
        # However little is known of it, three digits keep it in the valley where the others can make up for it.
        held[index] = value if abs(value - own) <= 1e-3 * abs(own) else significant(own, 4)
        free[index] = False
        again = batched_fit(problem, starts=held, vary=free, tolerance=_TIGHT)
        inside = (again.theta[0] > problem.lower) & (again.theta[0] < problem.upper)
        if not (again.converged[0] and inside[free].all()):
            break
        theta = again.theta[0]
    steepness = np.linalg.norm(problem.jacobian(theta), axis=0)
    for i in np.flatnonzero(free & (steepness > 0.0)):
        theta[i] = to_share(float(theta[i]), 1.0 / float(steepness[i]))
    same = (theta > problem.lower) & (theta < problem.upper) | at_bound | ~problem.vary
    return theta if same.all() and problem.law.admissible(theta, problem.conditions) else best


def _least_known(problem: FitProblem, theta: FloatArray, free: BoolArray) -> tuple[int, float, float]:
    """Return which free parameter takes most part in the weakest combination, its error, and how weak that is."""
    svd = decomposed(problem.jacobian(theta)[:, free])
    values = np.maximum(svd.values, max(svd.values[0] / RANK_RATIO, _NOTHING))
    place = int(np.argmax(np.abs(svd.rows[-1]).round(6)))
    std = float(np.linalg.norm(svd.rows[:, place] / values) / svd.length[place])
    return int(np.flatnonzero(free)[place]), std, float(values[0] / values[-1])


# Enough to tell the candidates apart; a start needs no more.
_MAX_CONDITIONS = 400
_FINALISTS = 12
_STEPS = 40
# In standard errors: starts further off (0.01) lead some laws into another place of their valley.
_NEAR = 1e-4


def guess(law: FrictionLaw, conditions: Conditions, log_lift: npt.ArrayLike) -> FloatArray:
    """Return parameters to start a fit of any law from, shape (p,), inside its bounds.

    The best of a few candidates, brought near measured ln(F_A / 1 N) of shape (n,) by the engine of every fit; typical
    values where no number of the data leads to better ones.
    """
    data = np.asarray(log_lift, dtype=np.float64)
    if data.size > _MAX_CONDITIONS:
        rows = np.linspace(0, data.size - 1, _MAX_CONDITIONS).round().astype(np.int64)
        conditions, data = conditions.select(rows), data[rows]
    problem = FitProblem.plain(law, conditions, data)
    found = typical = problem.start
    wrapped = conditions.wrap_angle_rad > 0.0

    def misfit(theta: FloatArray) -> FloatArray:
        return np.asarray(np.abs(law.log_lift(theta, conditions) - data).sum(axis=-1))

    try:
        # Data at the ends of what a float holds overflow on the way.
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            # The median of the average coefficients, which one bad trial cannot move far.
            average = (data - conditions.log_end_tension)[wrapped] / conditions.wrap_angle_rad[wrapped]
            mu = max(float(np.median(average)), 1e-3) if wrapped.any() else 0.2
            candidates = np.asarray(law.candidates(mu, conditions, data), dtype=np.float64)
            theta = np.clip(candidates, law.lower, law.upper)
            theta = theta[law.admissible(theta, conditions)]
            if len(theta):
                best = theta[np.argsort(misfit(theta), kind="stable")[:_FINALISTS]]
                best = batched_fit(problem, starts=best, tolerance=_NEAR, max_iterations=_STEPS).theta
                found = best[np.argmin(misfit(best))]
    except (InputError, np.linalg.LinAlgError):
        found = typical
    return np.asarray(np.clip(found if np.isfinite(found).all() else typical, law.lower, law.upper))
