"""Which conditions to test next: the plan that makes a wanted prediction, or a law's parameters, most certain."""

from typing import Any

import numpy as np

from ropefric.arrays import BoolArray, FloatArray, IntArray
from ropefric.errors import InputError
from ropefric.fitting.planning.candidates import allowed_conditions, tested_before
from ropefric.fitting.planning.exchange import Criterion, Whitened, best_plan
from ropefric.fitting.planning.limits import FACTORS, RigLimits
from ropefric.fitting.planning.one_factor import middle_of, nearest_to, one_factor_plan
from ropefric.fitting.planning.precision import PlannedLaw, expected_std
from ropefric.fitting.planning.result import LabPlan, Outlook
from ropefric.fitting.predict import REGRESSORS, outside_words
from ropefric.fitting.statistics import decomposed, plain_covariance
from ropefric.friction.condition import Conditions

_MOST = 1000


def plan_tests(
    planned: PlannedLaw,
    limits: RigLimits,
    wanted: Conditions,
    *,
    n_conditions: int = 12,
    repeats: int = 12,
    criterion: Criterion = "v",
    level: float = 0.95,
    starts: int = 10,
    seed: int = 0,
) -> LabPlan:
    """Return the conditions to test next.

    A condition adds g gᵀ/(s_b² + s_w²/m + (u/F_A)²) to the information, g = ∂ ln F_A/∂θ: the scatter between
    conditions is not averaged out by its m repeats. A law that bends makes the plan depend on the parameters it is
    made for; it is the best for those given.
    """
    if n_conditions < 1 or repeats < 1 or not 0.0 < level < 1.0 or criterion not in {"v", "d"}:
        raise InputError(
            f"{n_conditions} conditions of {repeats} repeats by criterion {criterion!r} at level {level:g}",
            key="n_conditions",
            fix="plan one or more of each, by 'v' or 'd', at a level such as 0.95",
        )
    for name, asked in (("n_conditions", n_conditions), ("repeats", repeats), ("starts", starts)):
        if asked > _MOST:
            raise InputError(f"{name} is {asked}; the limit is {_MOST}", key=name, fix="ask for fewer")
    grid = limits.conditions()
    allowed, notes = allowed_conditions(planned, limits, grid)
    free = allowed & ~tested_before(planned, grid)
    _check_enough(planned, int(np.count_nonzero(free)), n_conditions)
    places = np.flatnonzero(free)
    rows = planned.rows(grid.select(places), repeats)
    targets = planned.gradients(wanted)
    _check_seen(planned, rows)
    chosen, agreeing = best_plan(
        Whitened.of(rows, planned.known, targets), n_conditions, criterion=criterion, starts=starts, seed=seed
    )
    plan = grid.select(places[chosen])

    def outlook(added: FloatArray) -> Outlook:
        return _outlook(planned, np.vstack([planned.known, added]), wanted, level)

    usual = {
        name: outlook(planned.rows(grid.select(one), repeats))
        for name, one in _one_factor_plans(limits, free, wanted, n_conditions).items()
    }
    return LabPlan(
        planned=planned,
        conditions=plan,
        repeats=repeats,
        log_lift=planned.law.log_lift(planned.theta, plan),
        wanted=wanted,
        wanted_log_lift=planned.law.log_lift(planned.theta, wanted),
        criterion=criterion,
        level=level,
        parameter_std=np.sqrt(np.diag(plain_covariance(np.vstack([planned.known, rows[chosen]])))),
        before=outlook(np.zeros((0, planned.n_free))),
        after=outlook(rows[chosen]),
        one_factor=usual["middle"],
        one_factor_at_target=usual["target"],
        largest_force_N=limits.largest_force_N,
        n_candidates=places.size,
        starts=starts,
        agreeing_starts=agreeing,
        seed=seed,
        notes=(*planned.notes, *notes, *_outside(planned, limits, wanted), *_untested(limits, planned, plan)),
    )


def _outlook(planned: PlannedLaw, rows: FloatArray, wanted: Conditions, level: float) -> Outlook:
    dof = len(rows) - planned.n_free
    return Outlook(std_log=expected_std(planned, rows, wanted), dof=max(dof, 0), level=level)


def _check_enough(planned: PlannedLaw, n_free: int, n: int) -> None:
    if n_free < n:
        raise InputError(
            f"the rig's settings leave {n_free} conditions to choose from, and {n} are to be planned",
            key="limits",
            fix="give more wheels, wraps or end tensions, a larger cell, or plan fewer conditions",
        )
    least = planned.n_free + 1 - len(planned.known)
    if n < least:
        raise InputError(
            f"{n} conditions cannot determine the {planned.n_free} parameters of {planned.law.name} with an error",
            code="RF410",
            key="n_conditions",
            fix=f"plan {least} conditions or more, or hold a parameter",
        )


def _check_seen(planned: PlannedLaw, rows: FloatArray) -> None:
    unseen = decomposed(np.vstack([rows, planned.known])).unseen
    if unseen.any():
        names = [name for name, gone in zip(planned.free_names, unseen, strict=True) if gone]
        varied = {"size": "wheels", "wrap-dependence": "wraps", "end-tension": "end tensions"}
        shown_by = [words for effect, words in varied.items() if effect in planned.law.effects]
        raise InputError(
            f"every plan within these settings is singular: none can tell {', '.join(names)} of "
            f"{planned.law.name} apart",
            code="RF410",
            key="limits",
            fix=f"give more {', '.join(shown_by) or 'wraps'}, hold a parameter, or plan for a simpler law",
        )


def _one_factor_plans(limits: RigLimits, free: BoolArray, wanted: Conditions, n: int) -> dict[str, IntArray]:
    """Return one-factor plans about the middle of the settings, and about the first wanted condition."""
    allowed = free.reshape(limits.shape)
    spots: list[float] = []
    for name in FACTORS:
        levels = np.array(getattr(limits, name))
        spots.append(float(np.interp(getattr(wanted, name)[0], levels, np.arange(levels.size))))
    centres = {"middle": middle_of(allowed), "target": nearest_to(allowed, tuple(spots))}
    return {name: one_factor_plan(allowed, centre, n) for name, centre in centres.items()}


def _outside(planned: PlannedLaw, limits: RigLimits, wanted: Conditions) -> list[str]:
    """Return what of the wanted conditions lies outside all that was and can be tested."""
    spans: dict[str, Any] = limits.ranges()
    if planned.tested is not None:
        for name, (low, high) in spans.items():
            old = getattr(planned.tested, name)
            spans[name] = (min(low, float(old.min())), max(high, float(old.max())))
    return [
        f"wanted {words}, whatever is planned"
        for i in range(len(wanted))
        for words in outside_words(spans, wanted, i)
    ]


def _untested(limits: RigLimits, planned: PlannedLaw, plan: Conditions) -> list[str]:
    """Return over which factors the plan takes the law on trust."""
    notes = []
    for name in FACTORS:
        levels = getattr(limits, name)
        tested = [plan] if planned.tested is None else [plan, planned.tested]
        values = np.concatenate([getattr(part, name) for part in tested])
        if np.ptp(values) < 0.5 * (levels[-1] - levels[0]):
            title, unit, factor = REGRESSORS[name]
            low, high = (f"{factor * float(end):.4g}" for end in (values.min(), values.max()))
            where = f"only {title} {low} {unit}" if low == high else f"only {title} {low}–{high} {unit}"
            notes.append(f"{where} is tested; add a few conditions elsewhere if the law itself is in doubt")
    return notes
