"""Which conditions to test next: the plan that makes a wanted prediction most certain.

In: the knowledge of a law (`planned_fit`, or `planned_guess` before the first test) and what the rig can set. Out: a
`LabPlan` with how certain the wanted lift forces are expected to be before and after. The plan is found by `exchange`.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.files.plain_text import csv_text, rounded_tree
from ropefric.fitting.exchange import Evidence, Exchange, best_plan
from ropefric.fitting.fit import at_level, error_name, error_slopes
from ropefric.fitting.predict import REGRESSORS, outside_words
from ropefric.fitting.reml import CONDITION
from ropefric.fitting.resolution import FACTORS, MOST, MeanScatter, RigLimits
from ropefric.fitting.result import CommonError, FitResult
from ropefric.fitting.statistics import combined_dof, decomposed
from ropefric.friction.condition import SETTINGS, Conditions, condition_groups
from ropefric.friction.law import FrictionLaw
from ropefric.shown import Shown
from ropefric.uncertainty.budget import quantile

SCHEMA = "ropefric.test-plan/1"

# Share of the variance above which more pulls do not narrow an interval much.
_MOSTLY = 0.5
_UNTESTED = Conditions(**dict.fromkeys(SETTINGS, np.zeros(0)))


# ---- what is known of a law ----


class LevelScatter(NamedTuple):
    """Scatter between the levels of a group, such as ropes with a μ of their own, that several tested means share.

    Its standard deviation, of μ relative to itself, of ln F_A for conditions; its degrees of freedom; and by the name of
    each level what one standard deviation does to ln F_A of the tested means (k,).
    """

    name: str
    std: float
    dof: float
    effects: dict[str, FloatArray]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlannedLaw:
    """A law at the parameters of a plan, with prior knowledge of them."""

    law: FrictionLaw
    theta: FloatArray
    free: BoolArray
    scatter: MeanScatter
    tested: Conditions = _UNTESTED
    tested_repeats: npt.ArrayLike = 1.0
    common: tuple[CommonError, ...] = ()
    chain: str = ""
    levels: tuple[LevelScatter, ...] = ()
    own_mu_std: float = 0.0  # of μ relative to itself, where each condition has a rope of its own
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.free.any():
            text = f"every parameter of {self.law.name} is held, so tests have nothing to determine"
            raise InputError(text, key="fixed")

    @property
    def n_free(self) -> int:
        """Return the number q of parameters to determine."""
        return int(np.count_nonzero(self.free))

    @property
    def free_names(self) -> tuple[str, ...]:
        """Return their names."""
        return tuple(np.array(self.law.parameter_names)[self.free].tolist())

    @property
    def known(self) -> Evidence:
        """Return what was tested before; of common errors, by what they did to the fit."""
        named = {item.name: np.array(item.effect) for item in self.common if item.effect}
        for group in self.levels:
            named |= group.effects
        own2 = self._own_variance(self.tested, self.tested_repeats)
        if any(group.name == CONDITION for group in self.levels):
            own2 = own2 - self.scatter.between**2
        return self._evidence(self.tested, own2, named)

    def gradients(self, conditions: Conditions) -> FloatArray:
        """Return ∂ ln F_A/∂θ by the free parameters, shape (n, q)."""
        return np.asarray(self.law.jacobian(self.theta, conditions)[:, self.free])

    def evidence(self, conditions: Conditions, repeats: npt.ArrayLike) -> Evidence:
        """Return the information of condition means, each weighted by its scatter and its shared errors."""
        log_lift, effects = self.law.log_lift(self.theta, conditions), dict[str, FloatArray]()
        for group in self.levels:
            if group.name != CONDITION:  # pulled with all ropes in turn
                each = group.std * (log_lift - conditions.log_end_tension) / len(group.effects)
                effects |= dict.fromkeys(group.effects, each)
        effects |= self._effects(conditions)
        return self._evidence(conditions, self._own_variance(conditions, repeats), effects)

    def _own_variance(self, at: Conditions, repeats: npt.ArrayLike) -> FloatArray:
        """Return what no other mean shares of the variance of each, shape (n,)."""
        rise = self.law.log_lift(self.theta, at) - at.log_end_tension
        return self.scatter.variance(repeats) + (self.own_mu_std * rise) ** 2

    def _evidence(
        self, conditions: Conditions, own2: FloatArray, effects: Mapping[str, FloatArray]
    ) -> Evidence:
        slopes, own2 = self.law.jacobian(self.theta, conditions), own2 + np.zeros(len(conditions))
        std = np.sqrt(sum((effect**2 for effect in effects.values()), own2))
        rows = slopes[:, self.free] / std[:, None]
        return Evidence(rows, np.sqrt(own2) / std, {name: effect / std for name, effect in effects.items()})

    def _effects(self, at: Conditions) -> dict[str, FloatArray]:
        """Return how one standard uncertainty of each error that conditions share moves their ln F_A, shape (n,).

        New tests have one cell; a load, a wheel, a wrap or a rope that was not there before has an error of its own,
        as large as those of the others.
        """
        found = dict[str, FloatArray]()
        for kind, by in dict.fromkeys((item.kind, item.by) for item in self.common if item.kind):
            stds = {item.name: item.std for item in self.common if item.kind == kind}
            usual = float(np.median([*stds.values()]))
            slope = error_slopes(kind, self.law, self.theta, at)
            if kind == "cell":
                found[self.chain] = stds.get(self.chain, usual) * np.ones(len(at))
                continue
            level = at_level(kind, by, at)
            for value in np.unique(level).tolist():
                size = stds.get(name := error_name(kind, by, value), usual)
                found[name] = found.get(name, np.zeros(len(at))) + np.where(level == value, size * slope, 0.0)
        return {name: effect for name, effect in found.items() if effect.any()}


def planned_guess(law: FrictionLaw, guess: Mapping[str, float], scatter: MeanScatter) -> PlannedLaw:
    """Return a law at guessed parameters, nothing of them known yet."""
    free = np.array([not item.fixed for item in law.parameters])
    return PlannedLaw(law=law, theta=law.theta_from(guess), free=free, scatter=scatter)


def planned_fit(fit: FitResult, *, within: float | None = None, between: float | None = None) -> PlannedLaw:
    """Return a fitted law with the conditions it was fitted to, which the new tests add to."""
    scatter, notes = _scatter_of(fit, within, between)
    if not fit.trials.get("n"):
        raise InputError("the fit does not list its conditions", key="fit", fix="fit the trials again")
    columns = {name: np.array(values, dtype=np.float64) for name, values in fit.trials.items()}
    held = [item.name for item in fit.parameters if item.vary and item.at_bound]
    if held:
        notes.append(f"{', '.join(held)} lies on a bound in the fit and is held there")
    tested = Conditions(**{name: columns[name] for name in SETTINGS})
    levels = _levels_of(fit, tested, scatter.between)
    notes += [
        f"new tests are taken to be pulled with the {len(one.effects)} {one.name}s of the trials in turn"
        for one in levels
        if one.name != CONDITION
    ]
    return PlannedLaw(
        law=fit.friction_law,
        theta=fit.theta,
        free=fit.shown,
        scatter=scatter,
        tested=tested,
        tested_repeats=columns["n"],
        common=fit.common_errors,
        chain=_chain_of(fit),
        levels=levels,
        own_mu_std=math.sqrt(fit.scatter.own_mu_variance(len(tested))),
        notes=tuple(notes),
    )


def _levels_of(fit: FitResult, tested: Conditions, between: float) -> tuple[LevelScatter, ...]:
    """Return the groups that a fit knows a scatter of, and the conditions where these have several means each."""
    model, rise = fit.scatter, fit.friction_law.log_lift(fit.theta, tested) - tested.log_end_tension
    columns = {name: np.array(values) for name, values in fit.trials.items()}
    n = np.unique(columns.get("condition", np.zeros(0))).size

    def levels(name: str, std: float, dof: float, labels: Iterable[object], size: FloatArray) -> LevelScatter:
        named = {f"{name} {word}": std * size * (columns[name] == i) for i, word in enumerate(labels)}
        return LevelScatter(name, std, max(dof, 1.0), named)

    found = [
        levels(name, math.sqrt(variance), float(2.0 * variance**2 / spread), model.labels[name], rise)
        for name, n_levels, variance, spread in zip(
            model.names, model.levels, model.variance, np.diag(model.covariance), strict=True
        )
        if name in model.groups and variance > 0.0 and n_levels < len(tested)
    ]
    if between and 0 < n < rise.size:
        dof = float(n - fit.shown.sum())
        found.append(levels(CONDITION, between, dof, range(n), np.ones_like(rise)))
    return tuple(found)


def _scatter_of(fit: FitResult, within: float | None, between: float | None) -> tuple[MeanScatter, list[str]]:
    """Return the scatter of means to plan with, by the fit where it is not given, and what was assumed."""
    within = fit.statistics.scatter_within if within is None else within
    between = fit.statistics.scatter_between if between is None else between
    if not math.isfinite(within):
        text = "the fit has no repeats, so it does not know the scatter of one trial"
        raise InputError(text, key="scatter_within", fix='give it, such as --scatter-within "1.7 %"')
    notes = []
    if not math.isfinite(between):
        between = 0.0
        notes.append("the fit does not know the scatter between conditions: none is assumed")
    return MeanScatter(within=within, between=between), notes


def _chain_of(fit: FitResult) -> str:
    """Return the cell whose error moves the fit most: new tests are pulled with it."""
    size = np.where(fit.shown, np.sqrt(np.diag(fit.covariance)), np.inf)
    cells = [item for item in fit.common_errors if item.name.startswith("calibration")]
    moves = {item.name: float(np.linalg.norm(item.change / size)) for item in cells}
    return max(moves, key=moves.__getitem__, default="")


def allowed_conditions(
    planned: PlannedLaw, limits: RigLimits, grid: Conditions
) -> tuple[BoolArray, list[str]]:
    """Return which combinations can be tested, shape (N,), and the reasons for the others."""
    law, most_N = planned.law, limits.largest_force_N
    log_lift = law.log_lift_of_pairs(np.tile(planned.theta, (len(grid), 1)), grid)
    reasons = {
        f"{law.name} has no answer there": np.isnan(log_lift),
        f"F_A would exceed the {most_N:.4g} N of the cell": log_lift > math.log(most_N),
    }
    text = f"of {len(grid)} settings are left out"
    notes = [f"{out.sum()} {text}: {why}" for why, out in reasons.items() if out.any()]
    return log_lift <= math.log(most_N), notes


# ---- what comes out ----


class Outlook(NamedTuple):
    """How certain predictions are expected to be.

    Standard deviations of ln F_A (t,), the parts of them by errors that tests share, the degrees of freedom of the
    intervals (t,), 0 where no mean is left beyond the parameters, and the level of the intervals.
    """

    std_log: FloatArray
    shared_log: FloatArray
    dof: FloatArray
    level: float

    @property
    def half_width_log(self) -> FloatArray:
        """Return half the width of the interval of each ln F_A, t · std; infinite without degrees of freedom."""
        reach = [quantile(0.5 + 0.5 * self.level, nu) if nu else math.inf for nu in self.dof.tolist()]
        return self.std_log * reach

    def to_dict(self, lift_N: FloatArray) -> list[dict[str, Any]]:
        """Return standard error and interval [N] about lift forces."""
        half = self.half_width_log
        ends_N = lift_N * np.exp(np.minimum([-half, half], 700.0))
        ends_N[:, np.isinf(half)] = np.inf
        columns = self.std_log, self.std_log * lift_N, ends_N.T, self.dof
        names = ("std_log", "std_N", "interval_N", "dof")
        return [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LabPlan(Shown):
    """Conditions to test, and what they are expected to give.

    Attributes
    ----------
    planned : PlannedLaw
        What the plan was made for.
    conditions : Conditions
        n conditions, wheel by wheel.
    repeats : int
        Pulls of each.
    log_lift : ndarray, shape (n,)
        Expected ln F_A.
    wanted : Conditions
        The t predictions wanted.
    wanted_log_lift : ndarray, shape (t,)
        Their ln F_A by the parameters the plan was made for.
    level : float
        Level of the intervals.
    parameter_std : ndarray, shape (q,)
        Standard errors of the free parameters expected with the plan.
    before, after : Outlook
        Without and with the plan.
    largest_force_N : float
        Of the cell [N].
    notes : tuple of str
        What to know about it.
    """

    _said = ("conditions.wrap_angle_rad", "conditions.end_tension_N", "repeats", "improvement", "notes")
    _framed = "rows"

    planned: PlannedLaw
    conditions: Conditions
    repeats: int
    log_lift: FloatArray
    wanted: Conditions
    wanted_log_lift: FloatArray
    level: float
    parameter_std: FloatArray
    before: Outlook
    after: Outlook
    largest_force_N: float
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.conditions)

    @property
    def improvement(self) -> float:
        """Return how much wider the intervals of ln F_A are without the plan [-]; infinite where nothing is known."""
        wide, narrow = (math.sqrt(float(np.mean(one.half_width_log**2))) for one in (self.before, self.after))
        return math.nan if math.isinf(narrow) else wide / narrow

    def expected_parameter_std(self) -> dict[str, float]:
        """Return the expected standard error of each parameter that is to be determined."""
        return dict(zip(self.planned.free_names, self.parameter_std.tolist(), strict=True))

    def rows(self) -> list[dict[str, Any]]:
        """Return the conditions as rows in SI, with the expected force and its part of what the cell takes."""
        at, lift_N = self.conditions, np.exp(self.log_lift)
        return [
            {
                "condition": i + 1,
                **at.row(i),
                "repeats": self.repeats,
                "expected_lift_force_N": float(lift_N[i]),
                "cell_use": float(lift_N[i] / self.largest_force_N),
            }
            for i in range(len(self))
        ]

    def to_csv(self) -> str:
        r"""Return the plan as CSV for the lab: a row a condition, in millimetres, degrees and newtons."""
        heads = ("wheel_radius_mm", "rope_diameter_mm", "wrap_angle_deg", "end_tension_N")
        factors = np.array([1e3, 2e3, math.degrees(1.0), 1.0])
        rows: list[tuple[object, ...]] = [("condition", *heads, "repeats", "expected_lift_force_N")]
        for row in self.rows():
            settings = (f"{x:.10g}" for x in factors * [row[name] for name in SETTINGS])
            rows.append((row["condition"], *settings, row["repeats"], f"{row['expected_lift_force_N']:.4g}"))
        return csv_text(rows)

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON tree of schema `ropefric.test-plan/1`; infinite values are None."""
        law, lift_N, at = self.planned.law, np.exp(self.wanted_log_lift), self.wanted
        tree: dict[str, Any] = {
            "schema": SCHEMA,
            "before": self.before.to_dict(lift_N),
            "after": self.after.to_dict(lift_N),
            "level": self.level,
            "improvement": self.improvement,
            "notes": self.notes,
            "law": law.name,
            "parameters": law.as_mapping(self.planned.theta),
            "expected_std": self.expected_parameter_std(),
            "scatter": asdict(self.planned.scatter),
            "conditions": self.rows(),
            "n_tests": len(self) * self.repeats,
            "shared_log": self.after.shared_log,
            "wanted": [at.row(i) | {"lift_force_N": lift_N[i]} for i in range(len(at))],
        }
        return dict(rounded_tree(tree, None))


def plan_tests(
    planned: PlannedLaw,
    limits: RigLimits,
    wanted: Conditions,
    *,
    n_conditions: int = 12,
    repeats: int = 12,
    level: float = 0.95,
    starts: int = 10,
) -> LabPlan:
    """Return the conditions to test next.

    A mean of m repeats is weighed by 1/(s_b² + s_w²/m + Σ e²): the scatter between conditions is not averaged out by
    repeats, nor by any number of tests the errors e that they share, and the search knows both as the fit does. A law
    that bends makes the plan depend on the parameters it is made for; it is the best for those given.
    """
    if n_conditions < 1 or repeats < 1 or not 0.0 < level < 1.0:
        text = f"{n_conditions} conditions of {repeats} repeats at level {level:g}"
        fix = "plan one or more of each, at a level such as 0.95"
        raise InputError(text, key="n_conditions", fix=fix)
    for name, asked in (("n_conditions", n_conditions), ("repeats", repeats), ("starts", starts)):
        if asked > MOST:
            raise InputError(f"{name} is {asked}; the limit is {MOST}", key=name, fix="request fewer")
    law, theta, grid = planned.law, planned.theta, limits.conditions()
    allowed, notes = allowed_conditions(planned, limits, grid)
    # A condition set up again is no new one.
    both_at, n_tested = planned.tested.joined(grid), len(planned.tested)
    group = condition_groups(*(getattr(both_at, name) for name in SETTINGS))
    free = allowed & ~np.isin(group[n_tested:], group[:n_tested])
    places, known = np.flatnonzero(free), planned.known
    if places.size < n_conditions:
        text = f"the rig's settings leave {places.size} conditions to choose from, and {n_conditions} are to be planned"
        fix = "give more wheels, wraps or end tensions, a larger cell, or plan fewer conditions"
        raise InputError(text, key="settings", fix=fix)
    candidates, along = planned.evidence(grid.select(places), repeats), planned.gradients(wanted)
    least = planned.n_free + 1 - len(known.rows)
    _check_determined(planned, np.vstack([candidates.rows, known.rows]), least, n_conditions)
    chosen = best_plan(Exchange(candidates, known, along), n_conditions, starts=starts)
    plan = grid.select(places[chosen])
    both = known.joined(planned.evidence(plan, repeats))

    remarks = [*_on_trust(planned, limits, wanted, plan), *_of_shared(planned, both, along)]
    return LabPlan(
        planned=planned,
        conditions=plan,
        repeats=repeats,
        log_lift=law.log_lift(theta, plan),
        wanted=wanted,
        wanted_log_lift=law.log_lift(theta, wanted),
        level=level,
        parameter_std=both.errors(np.eye(planned.n_free))[0],
        before=_outlook(planned, known, along, level),
        after=_outlook(planned, both, along, level),
        largest_force_N=limits.largest_force_N,
        notes=(*planned.notes, *notes, *remarks),
    )


def _outlook(planned: PlannedLaw, found: Evidence, along: FloatArray, level: float) -> Outlook:
    """Return how certain predictions with slopes `along` (t, q) are by some evidence."""
    total, parts = _variances(planned, found, along)
    spare, dof = len(found.rows) - planned.n_free, np.zeros_like(total)
    if spare > 0:
        own = total - sum(parts.values(), np.zeros_like(total))
        groups = [(parts[one.name], one.dof) for one in planned.levels]
        dof = combined_dof(total, [(own, float(spare)), *groups])
    shared = sum((part for name, part in parts.items() if name != CONDITION), np.zeros_like(total))
    return Outlook(np.sqrt(total), np.sqrt(shared), dof, level)


def _variances(
    planned: PlannedLaw, found: Evidence, along: FloatArray
) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Return the variances of predictions (t,), and the parts by errors in common and by all levels of a group."""
    std, shared = found.errors(along)
    group_of = {name: one.name for one in planned.levels for name in one.effects}
    parts = {one.name: np.zeros_like(std) for one in planned.levels}
    for name, column in zip(found.shares, shared.T, strict=True):
        key = group_of.get(name, name)
        parts[key] = parts.get(key, 0.0) + column**2
    return std**2, parts


def _of_shared(planned: PlannedLaw, found: Evidence, along: FloatArray) -> list[str]:
    """Return that more pulls do not help any more, where what all of them share is most of the expected variance."""
    total, parts = _variances(planned, found, along)
    parts.pop(CONDITION, None)
    part = sum(parts.values(), np.zeros_like(total)) / total
    worst = int(np.argmax(part))
    if not part[worst] > _MOSTLY:
        return []
    name = max(parts, key=lambda name: float(parts[name][worst]))
    what, remedy = f"the {name}", "reduce that error, more pulls"
    if counts := [len(group.effects) for group in planned.levels if group.name == name]:
        what, remedy = (
            f"the differences between {counts[0]} {name}s",
            f"test more {name}s, more pulls with these",
        )
    text = f"{part[worst]:.0%} of the expected variance comes from errors that tests share, mainly {what}"
    return [f"{text}: {remedy} would not narrow the interval much"]


def _check_determined(planned: PlannedLaw, rows: FloatArray, least: int, n: int) -> None:
    """Refuse to plan n conditions, of those that can be had, where they cannot determine the parameters."""
    law = planned.law
    if n < least:
        text = f"{n} conditions cannot determine the {planned.n_free} parameters of {law.name} with an error"
        fix = f"plan {least} conditions or more, or for a simpler law"
        raise InputError(text, code="RF410", key="n_conditions", fix=fix)
    names = [name for name, gone in zip(planned.free_names, decomposed(rows).unseen, strict=True) if gone]
    if names:
        varied = {"size": "wheels", "wrap-dependence": "wraps", "end-tension": "end tensions"}
        shown_by = ", ".join(words for effect, words in varied.items() if effect in law.effects) or "wraps"
        text = f"every plan within these settings is singular: none can determine {', '.join(names)} of {law.name}"
        fix = f"give more {shown_by}, or plan for a simpler law"
        raise InputError(text, code="RF410", key="settings", fix=fix)


def _on_trust(planned: PlannedLaw, limits: RigLimits, wanted: Conditions, plan: Conditions) -> list[str]:
    """Return what of the wanted conditions lies outside all that was and can be tested, and what stays untested."""
    spans: dict[str, tuple[float, float]] = {}
    few = []
    for name in SETTINGS:
        tested = getattr(planned.tested, name)
        settings = np.array(getattr(limits, name)).ravel()
        both = np.append(settings, tested)
        spans[name] = (float(both.min()), float(both.max()))
        values = np.append(getattr(plan, name), tested)
        if name in FACTORS and np.ptp(values) < 0.5 * np.ptp(settings):
            title, unit, factor = REGRESSORS[name]
            low, high = (f"{factor * float(end):.4g}" for end in (values.min(), values.max()))
            where = f"only {title} {low} {unit}" if low == high else f"only {title} {low}–{high} {unit}"
            few.append(f"{where} is tested; add a few conditions elsewhere if the law itself is in doubt")
    outside = (words for i in range(len(wanted)) for words in outside_words(spans, wanted, i))
    return [*(f"wanted {words}, whatever is planned" for words in outside), *few]
