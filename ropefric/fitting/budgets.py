"""Uncertainty budgets after the GUM: of a measured force, a coefficient, a predicted lift force.

Of a condition: of an extraction, the measuring chain taken apart, or of a trial table. A force is the mean of its
trials with what they share; the other side hangs from dead weights. Of a wheel known only so well: what its settings,
and the parameters of a fitted law with their covariance, leave open of the lift force. Out: a `Statement` each.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.fitting.fit import rope_slopes
from ropefric.fitting.predict import has_interval, new_rope_std, outside_words
from ropefric.fitting.problem import law_named
from ropefric.fitting.result import FitResult
from ropefric.friction.condition import SETTINGS, Conditions
from ropefric.glossary import GLOSSARY
from ropefric.traces.calibration import Calibration, chain_quantities
from ropefric.trials.outliers import trimming_bias
from ropefric.trials.result import Extraction, TrialResult
from ropefric.trials.table import TrialTable
from ropefric.uncertainty.budget import (
    RECTANGULAR,
    Block,
    BudgetStatus,
    MeasurementModel,
    Quantity,
    Statement,
    limit_of_error,
    repeats,
    state_uncertainty,
)

MeasuredQuantity = Literal["force", "mu"]
"""The force that was measured, or μ̄ = ln(F_A/F_B)/φ."""

GRAVITY_LIMIT = 0.0027
"""Half the range of the acceleration of gravity at sea level, 9.780 to 9.832 m/s², over its mean [-]."""

_STANDARD_GRAVITY_M_S2 = 9.80665
_NO_CHAIN = "the recordings come in newtons without their chain: calibration and resolution are unknown"
_OWN = "each trial has its own {} ({:.2g} N): the repeatability holds it already"
_PLACE = ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad")
_SETTINGS = {
    term.name: (term.meaning.partition(";")[0].lower(), term.symbol, term.unit)
    for term in map(GLOSSARY.__getitem__, SETTINGS)
}


# ---- of a measured condition ----


class ForceSide(NamedTuple):
    """One of the two forces on a rope, and what it is made up of."""

    symbol: str
    quantities: tuple[Quantity, ...]
    is_product: bool = False

    @property
    def force_N(self) -> float:
        """Return the force [N]."""
        return float(self.of(np.array([[item.estimate for item in self.quantities]]))[0])

    def of(self, inputs: FloatArray) -> FloatArray:
        """Return the force [N] of inputs of shape (m, k), shape (m,)."""
        return np.asarray(inputs.prod(axis=1) if self.is_product else inputs.sum(axis=1))

    def slopes(self) -> FloatArray:
        """Return the derivative of the force by each quantity at the estimates, shape (k,)."""
        estimates = np.array([item.estimate for item in self.quantities])
        return self.force_N / estimates if self.is_product else np.ones_like(estimates)


def weights(
    symbol: str, force_N: float, *, tolerance: float = 0.0005, gravity_limit: float = GRAVITY_LIMIT
) -> ForceSide:
    """Return the force of dead weights, m g: its uncertainty is that of mass and gravity, not of a converter."""
    g, mass_kg = _STANDARD_GRAVITY_M_S2, force_N / _STANDARD_GRAVITY_M_S2
    why = "" if gravity_limit != GRAVITY_LIMIT else "how well the local g is known (--gravity, gravity_limit)"
    factors = (
        limit_of_error(f"mass of the weights of {symbol}", "m", "kg", tolerance * mass_kg, estimate=mass_kg),
        limit_of_error("acceleration of gravity", "g", "m/s2", gravity_limit * g, estimate=g, assumed=why),
    )
    return ForceSide(symbol=symbol, quantities=factors, is_product=True)


def force_model(side: ForceSide) -> MeasurementModel:
    """Return the measurement equation of a force."""
    return MeasurementModel("force", side.symbol, "N", side.quantities, side.of, side.slopes())


def coefficient_model(
    lift: ForceSide, end: ForceSide, wrap: Quantity, *, gain_limit: float = 0
) -> MeasurementModel:
    """Return the measurement equation of the average coefficient, μ̄ = ln(F_A/F_B)/φ, eq. (2).

    ∂μ̄/∂F_A = 1/(φ F_A), ∂μ̄/∂F_B = −1/(φ F_B), ∂μ̄/∂φ = −μ̄/φ; by the gain (a factor 1 + ε) 1/φ for a measured
    F_A, −1/φ for a measured F_B, and so 0 for both.
    """
    phi, F_A, F_B = wrap.estimate, lift.force_N, end.force_N
    if not phi > 0.0:
        raise InputError(f"over a wrap of {phi:g} rad there is no average coefficient", key="wrap_angle_rad")
    if not F_A > F_B > 0.0:
        text = f"F_A = {F_A:.6g} N does not exceed F_B = {F_B:.6g} N: friction holds nothing"
        raise InputError(text, key="lift_force_N", fix="check which side is which")
    n_A, n_B = len(lift.quantities), len(end.quantities)
    gain = (limit_of_error("gain of the measuring chain", "ε", "-", gain_limit),) if gain_limit > 0.0 else ()

    def evaluate(inputs: FloatArray) -> FloatArray:
        factor = 1.0 + inputs[:, n_A + n_B + 1 :].sum(axis=1)
        A = lift.of(inputs[:, :n_A]) * (1.0 if lift.is_product else factor)
        B = end.of(inputs[:, n_A : n_A + n_B]) * (1.0 if end.is_product else factor)
        angle = inputs[:, n_A + n_B]
        answered = (A > 0.0) & (B > 0.0) & (angle > 0.0)
        ratio = np.divide(A, B, out=np.ones_like(A), where=answered)
        return np.divide(np.log(ratio), angle, out=np.full_like(angle, np.nan), where=answered)

    by_gain = [(end.is_product - lift.is_product) / phi] * len(gain)
    by_wrap = -math.log(F_A / F_B) / phi**2
    slopes = np.array([*lift.slopes() / (phi * F_A), *-end.slopes() / (phi * F_B), by_wrap, *by_gain])
    quantities = (*lift.quantities, *end.quantities, wrap, *gain)
    return MeasurementModel("average coefficient of friction", "μ̄", "-", quantities, evaluate, slopes)


class MeasuredCondition(NamedTuple):
    """One condition with both its forces and their uncertainties."""

    number: int
    measured: ForceSide
    known: ForceSide
    measures_slack: bool
    n: int
    notes: tuple[str, ...]
    wheel_radius_m: float
    rope_radius_m: float
    wrap_angle_rad: float
    wrap_std_rad: float = 0.0

    @property
    def lift(self) -> ForceSide:
        """Return the tight side."""
        return self.known if self.measures_slack else self.measured

    @property
    def end(self) -> ForceSide:
        """Return the slack side."""
        return self.measured if self.measures_slack else self.known

    def describe(self) -> str:
        """Return the condition in words."""
        return (
            f"condition {self.number}: R_w = {1e3 * self.wheel_radius_m:.4g} mm, wrap "
            f"{math.degrees(self.wrap_angle_rad):.4g} deg, F_A = {self.lift.force_N:.4g} N, F_B = "
            f"{self.end.force_N:.4g} N"
        )


def condition_numbered(conditions: Sequence[MeasuredCondition], number: int) -> MeasuredCondition:
    """Return the condition of that number."""
    numbers = [condition.number for condition in conditions]
    if number in numbers:
        return conditions[numbers.index(number)]
    fix = f"there are {len(numbers)}, numbered {min(numbers, default=0)} to {max(numbers, default=0)}"
    raise InputError(f"there is no condition {number} with a force", key="condition", fix=fix)


def with_measured_end(condition: MeasuredCondition, std_N: float | None = None) -> MeasuredCondition:
    """Return a condition whose F_B is the reading of a second channel and does not hang from weights."""
    if condition.measures_slack:
        text = "here F_B was measured against a known F_A: it is a reading already"
        raise InputError(text, key="end_tension_measured")
    known_N, mass = condition.end.force_N, condition.end.quantities[0]
    std_N = known_N * mass.std / mass.estimate if std_N is None else std_N
    if not std_N > 0.0:
        text = "nothing is known of how well the slack side is measured"
        raise InputError(text, key="u_end_tension", fix='give it, such as --u-end-tension "0.3 N"')
    reading = Quantity("reading of the slack side", "F̂_B", "N", std_N, estimate=known_N)
    return condition._replace(known=ForceSide(symbol="F_B", quantities=(reading,)))


def conditions_of_extraction(
    extraction: Extraction, *, weights_tolerance: float = 0.0, gravity_limit: float = GRAVITY_LIMIT
) -> tuple[MeasuredCondition, ...]:
    """Return the conditions of an extraction that have a force, with the measuring chain taken apart.

    The repeatability is s/√n of the trials kept, s divided by what the rejection rule leaves of it on average. What
    differs from trial to trial (the cell's repeatability, a tare and a picked peak of each trial's own) is part of it
    and not counted again; what all trials share (linearity, hysteresis, transmitter, calibration line, resolution,
    bias of the smoothing) does not average out and is.
    """
    by_name = {trial.trial: trial for trial in extraction.trials if trial.kept}
    found = []
    for number, one in enumerate(extraction.conditions, start=1):
        kept = [by_name[name] for name in one.trials if name in by_name]
        if not kept:
            continue
        slack, (chain, notes), ratio = kept[0].measures_slack, _instrument(kept), 1.0
        if not weights_tolerance:
            notes.insert(0, "the mass of the weights is assumed to be exact: state weights.tolerance")
        if len(kept) > 1 and (ratio := 1.0 + trimming_bias(one.n, one.rule).bias) < 1.0:
            notes.insert(0, f"s is divided by {ratio:.3f}, which the rejection rule leaves of it on average")
        sides = ("F_B", "F_A", one.lift_force_N) if slack else ("F_A", "F_B", one.end_tension_N)
        measured = _mean_force(sides[0], np.array([trial.measured_N for trial in kept]), chain, ratio)
        known = weights(*sides[1:], tolerance=weights_tolerance, gravity_limit=gravity_limit)
        place = {name: getattr(one, name) for name in _PLACE}
        found.append(MeasuredCondition(number, measured, known, slack, len(kept), tuple(notes), **place))
    return _with_scatter_of_others(found)


def conditions_of_table(
    table: TrialTable, *, gravity_limit: float = GRAVITY_LIMIT
) -> tuple[MeasuredCondition, ...]:
    """Return the conditions of a trial table; its measuring chain is one line, `peak_std_N`, shared by all trials."""
    used, group, slack = table.used, table.group(), table.measures_slack
    pulls, wrap_std_rad = table.conditions(), table.wrap_std_rad[used]
    sides = [
        ("F_A", table.peak_N[used], np.nan_to_num(table.peak_std_N)[used]),
        ("F_B", table.end_tension_N[used], table.end_tension_std_N[used]),
    ]
    (symbol, measured_N, chain_N), (other, other_N, other_std_N) = reversed(sides) if slack else sides
    found = []
    for label in range(int(group.max(initial=-1)) + 1):
        row, notes = np.flatnonzero(group == label), []
        u_N = float(np.sqrt((chain_N[row] ** 2).mean()))
        known_N, known_std_N = float(other_N[row].mean()), float(other_std_N[row].max())
        if not u_N:
            notes.append("the table gives no uncertainty of the measuring chain: it is taken as exact")
        elif row.size > 1:
            text = "tare and picking of each trial are counted with the chain as if shared: on the safe side"
            notes.append(text)
        if not known_std_N:
            notes.append(f"the table gives no uncertainty of {other}: only gravity is counted")
        chain = Quantity("measuring chain, tare and picking", "δ_chain", "N", u_N)
        measured = _mean_force(symbol, measured_N[row], [chain])
        tolerance = RECTANGULAR * known_std_N / known_N
        known = weights(other, known_N, tolerance=tolerance, gravity_limit=gravity_limit)
        place = {name: float(getattr(pulls, name)[row[0]]) for name in _PLACE}
        place["wrap_std_rad"] = float(wrap_std_rad[row].max())
        found.append(MeasuredCondition(label + 1, measured, known, slack, row.size, tuple(notes), **place))
    return _with_scatter_of_others(found)


def _mean_force(symbol: str, values_N: FloatArray, chain: list[Quantity], ratio: float = 1.0) -> ForceSide:
    """Return a mean force with its s/√n and what its trials share; the scatter of a single trial is not known yet."""
    n, std_N = values_N.size, float(values_N.std(ddof=1)) / ratio if values_N.size > 1 else 0.0
    what, dof = ("repeatability", f"mean {symbol}", "N"), None if n > 1 else math.inf
    mean = repeats(*what, mean=float(values_N.mean()), std=std_N, n=n, dof=dof)
    return ForceSide(symbol=symbol, quantities=(mean, *chain))


def _with_scatter_of_others(conditions: Sequence[MeasuredCondition]) -> tuple[MeasuredCondition, ...]:
    """Return conditions of which those with a single trial have the pooled relative scatter of the others."""
    means = (item.measured.quantities[0] for item in conditions)
    several = [mean for mean in means if mean.repeats > 1]
    dof = math.fsum(mean.dof for mean in several)
    square = math.fsum(mean.dof * (mean.stated / mean.estimate) ** 2 for mean in several)
    note, scatter = "one trial, and no condition is repeated: the repeatability is unknown", 0.0
    if square:
        scatter = math.sqrt(square / dof)
        note = f"one trial: its scatter is that of the other conditions, {100 * scatter:.2g} % of the force"

    def with_scatter(item: MeasuredCondition) -> MeasuredCondition:
        mean, *others = item.measured.quantities
        if mean.repeats > 1:
            return item
        known = replace(mean, stated=scatter * mean.estimate, dof=dof if square else math.inf)
        side = item.measured._replace(quantities=(known, *others))
        return item._replace(measured=side, notes=(note, *item.notes))

    return tuple(map(with_scatter, conditions))


def state_condition(
    condition: MeasuredCondition,
    quantity: MeasuredQuantity = "force",
    *,
    u_wrap_angle_rad: float | None = None,
    gain_limit: float = 0.0,
    **check: Any,
) -> Statement:
    """Return the uncertainty of what was measured at one condition; `state_uncertainty` says how it can be checked."""
    notes = condition.notes
    if quantity not in ("force", "mu"):
        text = f"{quantity!r} is neither 'force' nor 'mu'"
        raise InputError(text, key="quantity", fix="choose one of the two")
    model = force_model(condition.measured)
    if quantity == "mu":
        u_rad = condition.wrap_std_rad if u_wrap_angle_rad is None else u_wrap_angle_rad
        if not u_rad:
            how = '--u-wrap "2 deg", or u_wrap_angle_rad in Python, says otherwise'
            notes += (f"the wrap is taken as exact; {how}",)
        wrap = Quantity("wrap angle", "φ", "rad", u_rad, estimate=condition.wrap_angle_rad)
        model = coefficient_model(condition.lift, condition.end, wrap, gain_limit=gain_limit)
    status = BudgetStatus.OK if condition.measured.quantities[0].stated else BudgetStatus.NO_REPEATS
    return state_uncertainty(model, status=status, notes=notes, **check)


def _instrument(trials: Sequence[TrialResult]) -> tuple[list[Quantity], list[str]]:
    """Return the corrections of a mean force that are not made, and the sources that are counted already.

    What each trial has of its own shows in the scatter of several, and is a correction of a single one only.
    """
    chains = [trial.calibration for trial in trials if trial.calibration is not None]
    found, notes = _of_chains(chains, trials) if chains else ([], [_NO_CHAIN])
    bias_N = _mean(trial.breakaway.bias_N for trial in trials)
    picking_N = math.sqrt(_mean(trial.breakaway.peak_std_N**2 for trial in trials))
    found.append((limit_of_error("bias of the smoothing", "δ_sm", "N", abs(bias_N)), ""))
    found.append((Quantity("picking", "δ_pick", "N", picking_N), _OWN.format("peak to pick", picking_N)))
    several = len(trials) > 1
    notes += [own for item, own in found if own and item.std and several]
    return [item for item, own in found if not (own and several)], notes


def _of_chains(
    chains: Sequence[Calibration], trials: Sequence[TrialResult]
) -> tuple[list[tuple[Quantity, str]], list[str]]:
    """Return the corrections of measuring chains, each with a remark if it is a trial's own, and notes."""
    worst = max(chains, key=lambda chain: chain.cell.full_scale_N)
    largest, notes = worst.cell, []
    if any(chain.cell != largest for chain in chains):
        notes.append(f"several force cells were used: the chain is that of the largest, {largest.name}")
    limit_N = largest.repeatability * largest.full_scale_N
    own = f"the cell's own repeatability (limit {limit_N:.2g} N) is part of that of the trials"
    shared = chain_quantities(_mean(trial.measured_N for trial in trials), worst)
    tare = Quantity("tare", "δ_0", "N", math.sqrt(_mean(chain.tare_std_N**2 for chain in chains)))
    one_tare = len({chain.tare_N for chain in chains}) == 1
    found = [(item, own if item.name == "cell's repeatability" else "") for item in shared]
    return [*found, (tare, "" if one_tare else _OWN.format("tare", tare.std))], notes


def _mean(values: Iterable[float]) -> float:
    numbers = [value for value in values if math.isfinite(value)]
    return math.fsum(numbers) / len(numbers) if numbers else 0.0


# ---- of a predicted lift force ----


@dataclass(frozen=True, slots=True, eq=False)
class _LiftForce:
    """F_A of draws of all quantities, a class because figures of a budget are drawn in other processes.

    Columns: the four settings, scatter up to `first`, the c errors in common, which move all parameters by `common`
    (p, c), then the free parameters.
    """

    law: str
    theta: FloatArray
    free: BoolArray
    first: int
    common: FloatArray

    def __call__(self, inputs: FloatArray) -> FloatArray:
        """Return F_A [N], shape (n,); NaN where a setting is no setting."""
        law, k = law_named(self.law), self.first + self.common.shape[1]
        answered = (inputs[:, :4] > 0.0).all(axis=1)
        found = np.full(len(inputs), np.nan)
        if answered.any():
            rows = inputs[answered]
            sets = np.tile(self.theta, (len(rows), 1))
            sets[:, self.free] = rows[:, k:]
            sets += rows[:, self.first : k] @ self.common.T
            # As in every prediction: a draw beyond a bound of the law counts as on it.
            sets = np.clip(sets, np.minimum(law.lower, self.theta), np.maximum(law.upper, self.theta))
            at = Conditions(**dict(zip(_SETTINGS, rows.T[:4], strict=True)))
            with np.errstate(over="ignore"):
                found[answered] = np.exp(
                    law.log_lift_of_pairs(sets, at) + rows[:, 4 : self.first].sum(axis=1)
                )
        return found


def lift_model(
    fit: FitResult, wheel: Conditions, wheel_std: Mapping[str, float], *, one_pull: bool = False
) -> MeasurementModel:
    """Return the measurement equation of the lift force of one wheel, F_A = exp ln F_A(θ; R_w, R_r, φ, F_B) [N].

    What `wheel_std` does not name of the wheel's settings is exact.
    """
    if len(wheel) != 1:
        text = f"{len(wheel)} wheels; a budget is of one"
        raise InputError(text, key="conditions", fix="ask one at a time")
    law, theta, free = fit.friction_law, fit.theta, fit.shown
    F_A = math.exp(float(law.log_lift(theta, wheel)[0]))
    quantities = [
        Quantity(*words, wheel_std.get(key, 0.0), estimate=float(getattr(wheel, key)[0]))
        for key, words in _SETTINGS.items()
    ]
    if one_pull:
        rise = math.log(F_A / float(wheel.end_tension_N[0]))
        if not math.isfinite(new := new_rope_std(fit, rise, math.log(F_A))):
            text = f"the fit of {fit.law} knows no scatter, so one pull has no interval"
            raise InputError(text, key="one_pull", fix="repeat conditions, or request the mean law")
        # What one pull brings beside the law: a new rope by its rise, a condition, a repeat.
        own = fit.scatter.one_pull(np.array([math.log(F_A)]), np.array([rise]))
        dof = float(fit.scatter.dof(np.zeros((1, theta.size)), own)[0])
        quantities.append(Quantity("scatter of one new rope", "δ_rope", "-", new, dof=dof, type="A"))
    first = len(quantities)
    # Known by their own uncertainty, and a line each: what many conditions have in common.
    quantities += [Quantity(item.name, "δ", item.unit, item.std) for item in fit.common_errors]
    common = fit.common_changes / [item.std for item in fit.common_errors]
    covariance = fit.covariance - fit.common_changes @ fit.common_changes.T
    of_law = law.jacobian(theta, wheel)
    if fit.scatter.mixtures:
        covariance = covariance * (fit.scatter.integrated(of_law)[0] / (of_law @ covariance @ of_law.T)[0])
    block = Block(
        name=f"parameters of {law.name}",
        symbols=tuple(np.array(law.parameter_names)[free].tolist()),
        estimates=theta[free],
        covariance=np.asarray(covariance)[np.ix_(free, free)],
        dof=float(fit.scatter.dof(of_law)[0]) if has_interval(fit) else 1.0,
    )

    evaluate = _LiftForce(fit.law, theta, free, first, common)
    by_radius, by_wrap, by_log_tension = law.log_lift_gradient_conditions(theta, wheel)[0]
    by_rope = float(rope_slopes(law, theta, wheel)[0])
    slopes = [by_radius, by_rope, by_wrap, by_log_tension / wheel.end_tension_N[0]]
    by_parameter = law.jacobian(theta, wheel)[0]
    slopes += [1.0] * (first - 4)
    by_all = F_A * np.concatenate([slopes, by_parameter @ common, by_parameter[free]])
    name, known = "lift force of one pull" if one_pull else "lift force", block if free.any() else None
    return MeasurementModel(name, "F_A", "N", tuple(quantities), evaluate, by_all, known)


def state_lift(
    fit: FitResult, at: Conditions, wheel_std: Mapping[str, float], *, one_pull: bool = False, **check: Any
) -> Statement:
    """Return the uncertainty of the lift force that a fit predicts for a wheel known only so well."""
    status = BudgetStatus.OK if fit.verdict_on(at).supported else BudgetStatus.FIT_NOT_TRUSTED
    model, notes = lift_model(fit, at, wheel_std, one_pull=one_pull), outside_words(fit.validity, at)
    if one_pull and math.isfinite(fit.scatter.tail_dof):
        notes += ("repeats have heavier tails than this budget assumes: use the interval of `predict`",)
    return state_uncertainty(model, status=status, notes=notes, **check)
