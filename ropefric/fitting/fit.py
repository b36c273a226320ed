"""A friction law fitted to a trial table: ln F_A by weighted least squares through the integral.

The search goes from several starts, with weights that follow the parameters; `result` makes of it what a fit hands on.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import inf
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError, UnknownNameError
from ropefric.files.plain_text import significant, to_share
from ropefric.fitting.assembled import Found, assemble
from ropefric.fitting.predict import REGRESSORS
from ropefric.fitting.problem import (
    FitProblem,
    FitSettings,
    batched_fit,
    check_settings,
    law_named,
    typical_mu,
)
from ropefric.fitting.result import CommonError, FitResult
from ropefric.fitting.scatter import estimated, laid_out
from ropefric.fitting.statistics import RANK_RATIO, decomposed
from ropefric.friction.condition import Conditions
from ropefric.friction.law import FrictionLaw
from ropefric.registry import did_you_mean
from ropefric.trials.table import TrialTable

# Beyond this the squares of residuals and slopes, and their sums, are no floats.
_LARGEST = 1e100
# Weights depend on the parameters through what is left over; they settle in a few rounds.
_ROUNDS = 12
_SETTLED = 1e-5
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
# Parameters that start smaller than this are moved as if they were as large.
_LEAST_SIZE = 1e-3
GROUPS = {"rope_id": "rope", "wheel": "wheel", "mounting": "mounting", "operator": "operator", "day": "day"}
"""Columns of a table whose levels may differ in μ, and the name of what differs."""


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
            what = "fixed" if name in settings.fixed else "start"
            text = f"the {what} value {name} = {value:g} lies outside its bounds {low:g} … {high:g}"
            raise InputError(text, code="RF402", key=name, fix="give one inside the bounds, or widen them")
    if not law.admissible(start, conditions):
        law.log_lift(start, conditions)  # raises, and says why and what to do
    plain = FitProblem.plain(law, conditions, log_lift, start=start)
    return replace(plain, group=table.group(), lower=lower, upper=upper, vary=np.array(vary))


# ---- stated errors, and who shares them ----


class Stated(NamedTuple):
    """An uncertainty that can be stated: its column and unit, what it is in words, and the setting that it is of."""

    column: str
    unit: str
    words: str
    setting: str = ""


STATED = {
    "cell": Stated("cell_std_N", "-", "calibration of the force cell"),
    "end_tension": Stated("end_tension_std_N", "-", "end tension", "end_tension_N"),
    "wheel_radius": Stated("wheel_radius_std_m", "m", "radius of the wheel", "wheel_radius_m"),
    "wrap": Stated("wrap_std_rad", "rad", "setting of the wrap", "wrap_angle_rad"),
    "rope_radius": Stated("rope_radius_std_m", "m", "radius of the rope", "rope_radius_m"),
}
"""Quantities of which a table may state the uncertainty, see `FitSettings.shared`."""


SHARERS = ("cell", "rig", "wheel", "rope", "setting")
"""Sharers of an error, beside the columns of a table: one rig, wheels and ropes by their size, equal settings."""


def stated_errors(
    problem: FitProblem, theta: FloatArray, table: TrialTable, shared: Mapping[str, str], *, slack: bool
) -> tuple[tuple[CommonError, ...], FloatArray]:
    """Return the errors that trials share as stated, and the change of ln F_A by one of each, shape (n, b).

    What nobody says is shared belongs to single pulls or conditions, and shows in their scatter.
    """
    used, at, found, effects = table.used, problem.conditions, list[CommonError](), list[FloatArray]()
    for kind, by in shared.items():
        one = STATED[kind]
        std = np.nan_to_num(np.asarray(getattr(table, one.column), np.float64)[used])
        if not std.any():
            continue
        slope = error_slopes(kind, problem.law, theta, at, slack=slack)
        if kind == "cell":
            std = std / (at.end_tension_N if slack else np.exp(problem.log_lift))
        words = [*table.labels.get(by, ())]
        if not words:
            names = [error_name(kind, by, value) for value in at_level(kind, by, at).tolist()]
        else:
            how = "calibration of cell" if kind == "cell" else f"{one.words}, {by.removesuffix('_id')}"
            names = [f"{how} {word}" for word in np.array(words)[used].tolist()]
        for name in dict.fromkeys(names):
            here = (np.array(names) == name) & (std > 0.0)
            if here.any():
                found.append(CommonError(name, one.unit, float(std[here].max()), (), kind, by))
                effects.append(np.where(here, std * slope, 0.0))
    return tuple(found), np.stack(effects, axis=-1) if effects else np.zeros((len(at), 0))


_SETTING_OF = {"rig": "", "cell": "", "wheel": "wheel_radius_m"}
_SETTING_OF |= dict.fromkeys(("rope", "rope_id"), "rope_radius_m")


def at_level(kind: str, by: str, at: Conditions) -> FloatArray:
    """Return the setting whose values have errors of their own: one rig, or wheels, ropes, settings."""
    setting = _SETTING_OF.get(by, STATED[kind].setting)
    return np.asarray(getattr(at, setting)) if setting else np.zeros(len(at))


def error_name(kind: str, by: str, value: float) -> str:
    """Return the name of an error of a kind, by what shares it."""
    words, setting = STATED[kind].words, _SETTING_OF.get(by, STATED[kind].setting)
    if not setting:
        return words
    _, unit, factor = REGRESSORS[setting]
    sharer = "" if by == "setting" else f", {by.removesuffix('_id')}"
    return f"{words}{sharer} of {factor * value:.4g} {unit}"


def error_slopes(
    kind: str, law: FrictionLaw, theta: FloatArray, at: Conditions, *, slack: bool = False
) -> FloatArray:
    """Return how ln F_A moves by one unit of a stated error; of forces by ln F, shape (n,)."""
    if kind == "rope_radius":
        return rope_slopes(law, theta, at)
    if kind == "cell" and not slack:
        return np.ones(len(at))
    slopes = law.log_lift_gradient_conditions(theta, at)
    found = {"wheel_radius": slopes[:, 0], "wrap": slopes[:, 1], "cell": slopes[:, 2]}
    return np.asarray(found.get(kind, slopes[:, 2] / at.end_tension_N))


def rope_slopes(law: FrictionLaw, theta: FloatArray, at: Conditions) -> FloatArray:
    """Return ∂ ln F_A/∂R_r [1/m] by central differences, shape (n,): no law has it in closed form."""
    radius_m = at.rope_radius_m
    ends = [law.log_lift(theta, replace(at, rope_radius_m=radius_m * s)) for s in (1 + _STEP, 1 - _STEP)]
    return np.asarray((ends[0] - ends[1]) / (2.0 * _STEP * radius_m))


# ---- the search ----


def _search(problem: FitProblem, table: TrialTable, settings: FitSettings) -> Found:
    """Return the best minimum, with weights taken at it."""
    _check_names(table, settings)
    chosen = GROUPS if settings.groups is None else {name: GROUPS.get(name, name) for name in settings.groups}
    named = {
        word: np.array(table.labels[name])[table.used].tolist()
        for name, word in chosen.items()
        if name in table.labels
    }
    layout, slack = laid_out(problem, named), table.measures_slack

    def errors(theta: FloatArray) -> tuple[tuple[CommonError, ...], FloatArray]:
        """Return the stated errors, and how one of each moves the mean of each cell."""
        found, effects = stated_errors(problem, theta, table, settings.shared, slack=slack)
        of_cells = np.array([np.bincount(layout.cell, z) / layout.size for z in effects.T])
        return found, of_cells.reshape(-1, layout.size.size).T

    weighted = replace(layout.problem, std=layout.size**-0.5)
    theta, converged, notes = _minimum(weighted, _starts(weighted, settings))
    for _ in range(_ROUNDS):
        found = estimated(layout, theta, problem.vary, errors(theta)[1], mixed=False)
        if found is None:
            break
        settled = _as_before(weighted, found.weighted)
        weighted = found.weighted
        if settled:
            break
        theta, converged, _same = _minimum(weighted, theta)
    at_bound = problem.vary & ((theta <= problem.lower) | (theta >= problem.upper))
    theta = _rounded(weighted, _nearest_start(weighted, theta, problem.vary & ~at_bound), at_bound)
    common, effects = errors(theta)
    return Found(
        problem=problem, layout=layout, theta=theta, at_bound=at_bound, converged=converged,
        notes=(*layout.notes, *notes), common=common, effects=effects, slack=slack,
    )  # fmt: skip


def _check_names(table: TrialTable, settings: FitSettings) -> None:
    """Refuse groups and sharers that the table does not know."""
    kinds, sharers, columns = [*STATED], [*SHARERS, *table.labels], [*table.labels]
    asked = [(name, columns, "groups", "the table has no column {!r}") for name in settings.groups or ()]
    asked += [(kind, kinds, "shared", "no error is called {!r}") for kind in settings.shared]
    asked += [
        (by, sharers, "shared", "nothing called {!r} shares an error") for by in settings.shared.values()
    ]
    for name, known, key, text in asked:
        if str(name) not in known:
            raise UnknownNameError(text.format(name), key=key, fix=did_you_mean(str(name), known))


def _as_before(one: FitProblem, other: FitProblem) -> bool:
    """Return whether two sets of weights are the same but for a factor, which moves no minimum."""
    if (one.root is None) != (other.root is None):
        return False
    weights = [x.std if x.root is None else x.root for x in (one, other)]
    scale = float(np.linalg.norm(weights[1]) / np.linalg.norm(weights[0]))
    return bool(np.abs(weights[1] - scale * weights[0]).max() <= _SETTLED * np.abs(weights[1]).max())


def _starts(problem: FitProblem, settings: FitSettings) -> FloatArray:
    """Return the start and others spread about it, shape (m, p); a law of one parameter has one minimum."""
    if problem.n_varying < 2:
        return problem.start[np.newaxis]
    rng = np.random.default_rng(settings.seed)
    others = problem.start * np.exp(rng.normal(0.0, _SPREAD, (settings.n_starts - 1, problem.start.size)))
    others = np.clip(np.where(problem.vary, others, problem.start), problem.lower, problem.upper)
    return np.vstack([problem.start, others[problem.law.admissible(others, problem.conditions)]])


def _minimum(problem: FitProblem, starts: FloatArray) -> tuple[FloatArray, bool, tuple[str, ...]]:
    """Return the best end of the searches from some starts, whether it is a minimum, and others as good in words."""
    ends = batched_fit(problem, starts=starts, tolerance=_TIGHT)
    least = np.nanmin(ends.chi2)
    # Several starts end in one valley, and the last bits may not say at which of its places, nor which of them creeps
    # on: the first one that has arrived stands, or else the first.
    low = np.flatnonzero(ends.chi2 <= least + _SAME_COST * (1.0 + least))
    best = low[np.argmax(ends.converged[low])]
    theta, cost = ends.theta[best], float(ends.chi2[best])
    if not ends.converged[best]:
        theta, cost = _end_of_the_valley(problem, theta, cost)
    size = np.maximum(np.maximum(np.abs(ends.theta), np.abs(theta)), 1e-6)
    apart = (np.abs(ends.theta - theta) > _APART * size)[:, problem.vary].any(axis=1)
    # Of the same cost are the places of one valley, along which parameters are traded; which of them is found is luck.
    more = ends.chi2 - cost
    other = (more > _SAME_COST * (1.0 + cost)) & (more < _AS_GOOD)
    rivals = np.flatnonzero(ends.converged & other & apart)
    notes: tuple[str, ...] = ()
    if rivals.size:
        rival = rivals[np.argmin(ends.chi2[rivals])]
        mapping = problem.law.as_mapping(ends.theta[rival])
        values = ", ".join(f"{name} = {value:.4g}" for name, value in mapping.items())
        larger = significant(float(more[rival]), 2)
        notes = (f"another minimum is as good (χ² larger by {larger:.2g}): {values}",)
    theta = _onto_bounds(problem, theta)
    return theta, bool(ends.converged[best]) or _is_flat(problem, theta), notes


def _nearest_start(problem: FitProblem, theta: FloatArray, free: BoolArray) -> FloatArray:
    """Return the place nearest to the start of those that fit as well, where parameters can be traded without any trace.

    Where in such a valley a search ends hangs on the last bits. A curved valley stays as it is found.
    """
    size = np.maximum(np.abs(problem.start), _LEAST_SIZE)[free]
    _, values, rows = np.linalg.svd(problem.jacobian(theta)[:, free] * size)
    lost = rows[int((values > values.max(initial=0.0) / RANK_RATIO).sum()) :]
    if not lost.size:
        return theta
    moved, before = theta.copy(), _cost(problem, theta)
    moved[free] -= size * (lost.T @ (lost @ ((theta - problem.start)[free] / size)))
    moved = np.clip(moved, problem.lower, problem.upper)
    return moved if _cost(problem, moved) <= before + _SAME_COST * (1.0 + before) else theta


def _cost(problem: FitProblem, theta: FloatArray) -> float:
    """Return χ², infinite where the law has no answer."""
    if not problem.law.admissible(theta, problem.conditions):
        return inf
    return float((problem.residuals(theta) ** 2).sum())


def _is_flat(problem: FitProblem, theta: FloatArray) -> bool:
    """Return whether the next step would gain nothing that counts, though the search may creep on for ever.

    Along a valley, where parameters can be traded for each other, the steps never get small.
    """
    residuals, jacobian = problem.residuals_and_jacobian(theta)
    inside = problem.vary & (theta > problem.lower) & (theta < problem.upper)
    svd = decomposed(jacobian[:, inside])
    seen = svd.values > _FLAT_RANK * svd.values.max(initial=0.0)
    along = svd.left[:, seen].T @ residuals
    return bool(along @ along <= _FLAT * float(residuals @ residuals) / residuals.size)


def _end_of_the_valley(problem: FitProblem, theta: FloatArray, cost: float) -> tuple[FloatArray, float]:
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
    ends = batched_fit(problem, starts=starts[good], vary=vary[good], tolerance=_TIGHT)
    best = int(np.argmin(ends.chi2))
    return (ends.theta[best], float(ends.chi2[best])) if ends.chi2[best] < cost else (theta, cost)


def _onto_bounds(problem: FitProblem, theta: FloatArray) -> FloatArray:
    """Return theta with every parameter on its bound that is close to it for no gain, the others fitted anew."""
    moved, cost = theta, _cost(problem, theta)
    for i in np.flatnonzero(problem.vary & (theta > problem.lower) & (theta < problem.upper)):
        for bound in (problem.lower[i], problem.upper[i]):
            close = abs(moved[i] - bound) <= _NEAR_BOUND * max(abs(bound), abs(moved[i]), 1.0)
            if np.isfinite(bound) and close:
                on_it = moved.copy()
                on_it[i] = bound
                if _cost(problem, on_it) <= cost * (1.0 + _FREE) + _FREE:
                    moved = on_it
    if moved is theta:
        return theta
    inside = problem.vary & (moved > problem.lower) & (moved < problem.upper)
    return np.asarray(batched_fit(problem, starts=moved, vary=inside, tolerance=_TIGHT).theta[0])


def _rounded(problem: FitProblem, best: FloatArray, at_bound: BoolArray) -> FloatArray:
    """Return the minimum to the digits that mean something, so that all that follows starts alike on every machine.

    Each parameter is rounded by its error with the others held, which raises χ² by 1e-8 at most. Where parameters
    can be traded for each other that error is far below what the search knows of each, so they are rounded one
    after the other, the least known first and by its whole error, and those that are left are fitted anew.
    """
    theta = best.copy()
    free = problem.vary & ~at_bound & (problem.jacobian(theta) != 0.0).any(axis=0)
    # Of one without any effect, as an exponent of nothing, the search leaves what it will.
    for i in np.flatnonzero(problem.vary & ~at_bound & ~free):
        theta[i] = significant(float(theta[i]), 4)
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
            mu = max(typical_mu(conditions.select(wrapped), data[wrapped]), 1e-3) if wrapped.any() else 0.2
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
