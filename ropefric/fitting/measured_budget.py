"""The uncertainty of what was measured at a condition: of its force, or of the coefficient that two forces give.

In: the conditions of an extraction, the measuring chain taken apart, or of a trial table. Out: a `Statement` each. A
force is the mean of its trials with what they share; the other side hangs from dead weights.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.traces.budget import chain_quantities
from ropefric.trials.conditions import trimming_bias
from ropefric.trials.result import ConditionSummary, Extraction, TrialResult
from ropefric.trials.table import TrialTable
from ropefric.uncertainty.budget import MeasurementModel
from ropefric.uncertainty.quantity import RECTANGULAR, Quantity, limit_of_error, normal, repeats
from ropefric.uncertainty.statement import BudgetStatus, Statement, state_uncertainty

MeasuredQuantity = Literal["force", "mu"]
"""The force that was measured, or μ̄ = ln(F_A/F_B)/φ."""

GRAVITY_LIMIT = 0.0027
"""Half the range of the acceleration of gravity at sea level, 9.780 to 9.832 m/s², over its mean [-]."""

_STANDARD_GRAVITY_M_S2 = 9.80665


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceSide:
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
    if not (math.isfinite(force_N) and force_N > 0.0):
        raise InputError(f"{symbol} = {force_N:g} N is not positive", key=symbol)
    mass_kg = force_N / _STANDARD_GRAVITY_M_S2
    mass = limit_of_error(
        f"mass of the weights of {symbol}", "m", "kg", tolerance * mass_kg, estimate=mass_kg
    )
    g, assumed = _STANDARD_GRAVITY_M_S2, "how well the local g is known (--gravity, gravity_limit)"
    gravity = limit_of_error(
        "acceleration of gravity", "g", "m/s2", gravity_limit * g, estimate=g,
        assumed=assumed if gravity_limit == GRAVITY_LIMIT else "",
    )  # fmt: skip
    return ForceSide(symbol=symbol, quantities=(mass, gravity), is_product=True)


def force_model(side: ForceSide) -> MeasurementModel:
    """Return the measurement equation of a force."""
    return MeasurementModel(
        name="force",
        symbol=side.symbol,
        unit="N",
        quantities=side.quantities,
        evaluate=side.of,
        sensitivities=side.slopes(),
    )


def coefficient_model(
    lift: ForceSide, end: ForceSide, wrap: Quantity, *, gain_limit: float = 0.0
) -> MeasurementModel:
    """Return the measurement equation of the average coefficient, μ̄ = ln(F_A/F_B)/φ, eq. (2).

    ∂μ̄/∂F_A = 1/(φ F_A), ∂μ̄/∂F_B = −1/(φ F_B), ∂μ̄/∂φ = −μ̄/φ; by the gain (a factor 1 + ε) 1/φ for a measured
    F_A, −1/φ for a measured F_B, and so 0 for both.
    """
    phi, F_A, F_B = wrap.estimate, lift.force_N, end.force_N
    if not phi > 0.0:
        raise InputError(f"over a wrap of {phi:g} rad there is no average coefficient", key="wrap_angle_rad")
    if not F_A > F_B > 0.0:
        raise InputError(
            f"F_A = {F_A:.6g} N does not exceed F_B = {F_B:.6g} N: friction holds nothing",
            key="lift_force_N",
            fix="check which side is which",
        )
    mu = math.log(F_A / F_B) / phi
    n_A, n_B = len(lift.quantities), len(end.quantities)
    gain = limit_of_error("gain of the measuring chain", "ε", "-", gain_limit)
    with_gain = (*lift.quantities, *end.quantities, wrap, *((gain,) if gain_limit > 0.0 else ()))

    def evaluate(inputs: FloatArray) -> FloatArray:
        factor = 1.0 + inputs[:, -1] if gain_limit > 0.0 else 1.0
        A = lift.of(inputs[:, :n_A]) * (1.0 if lift.is_product else factor)
        B = end.of(inputs[:, n_A : n_A + n_B]) * (1.0 if end.is_product else factor)
        angle = inputs[:, n_A + n_B]
        answered = (A > 0.0) & (B > 0.0) & (angle > 0.0)
        ratio = np.divide(A, B, out=np.ones_like(A), where=answered)
        return np.divide(np.log(ratio), angle, out=np.full_like(angle, np.nan), where=answered)

    by_gain = (0.0 if lift.is_product else 1.0) - (0.0 if end.is_product else 1.0)
    parts = [lift.slopes() / (phi * F_A), -end.slopes() / (phi * F_B), np.array([-mu / phi])]
    parts += [np.array([by_gain / phi])] if gain_limit > 0.0 else []
    return MeasurementModel(
        name="average coefficient of friction",
        symbol="μ̄",
        unit="-",
        quantities=with_gain,
        evaluate=evaluate,
        sensitivities=np.concatenate(parts),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredCondition:
    """One condition with both its forces and what is known of them."""

    number: int
    wheel_radius_m: float
    rope_radius_m: float
    wrap_angle_rad: float
    wrap_std_rad: float
    measured: ForceSide
    known: ForceSide
    measures_slack: bool
    n: int
    notes: tuple[str, ...] = ()

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
    raise InputError(
        f"there is no condition {number} with a force",
        key="condition",
        fix=f"there are {len(numbers)}, numbered {min(numbers, default=0)} to {max(numbers, default=0)}",
    )


def with_measured_end(condition: MeasuredCondition, std_N: float | None = None) -> MeasuredCondition:
    """Return a condition whose F_B is the reading of a second channel and does not hang from weights."""
    if condition.measures_slack:
        raise InputError(
            "here F_B was measured against a known F_A: it is a reading already", key="end_tension_measured"
        )
    known_N, mass = condition.end.force_N, condition.end.quantities[0]
    std_N = known_N * mass.std / mass.estimate if std_N is None else std_N
    if not std_N > 0.0:
        raise InputError(
            "nothing is known of how well the slack side is measured",
            key="u_end_tension",
            fix='give it, such as --u-end-tension "0.3 N"',
        )
    reading = normal("reading of the slack side", "F̂_B", "N", std_N, estimate=known_N)
    return replace(condition, known=ForceSide(symbol="F_B", quantities=(reading,)))


def conditions_of_extraction(
    extraction: Extraction, *, weights_tolerance: float = 0.0, gravity_limit: float = GRAVITY_LIMIT
) -> tuple[MeasuredCondition, ...]:
    """Return the conditions of an extraction that have a force, with the measuring chain taken apart.

    The repeatability is s/√n of the trials kept, s divided by what the rejection rule leaves of it on average. What
    differs from trial to trial (the cell's repeatability, a tare and a picked peak of each trial's own) is part of it
    and not counted again; what all trials share (linearity, hysteresis, transmitter, calibration line, resolution,
    bias of the smoothing) does not average out and is.
    """
    by_name = {trial.trial: trial for trial in extraction.trials}
    scatters = [
        (one.std_kept_N / one.mean_kept_N / _left_of_scatter(one), one.n_kept - 1)
        for one in extraction.conditions
        if one.n_kept > 1
    ]
    pooled = _pooled_scatter(scatters)
    found = []
    for number, summary in enumerate(extraction.conditions, start=1):
        kept = [by_name[name] for name in summary.trials if by_name[name].kept]
        if not kept:
            continue
        slack = kept[0].measures_slack
        symbol, other = ("F_B", "F_A") if slack else ("F_A", "F_B")
        ratio = _left_of_scatter(summary) if len(kept) > 1 else 1.0
        mean, notes = _mean_force(symbol, np.array([trial.measured_N for trial in kept]), pooled, ratio)
        chain, more = _instrument(kept)
        if not weights_tolerance:
            notes += ("the mass of the weights is assumed to be exact: state weights.tolerance",)
        known_N = summary.lift_force_N if slack else summary.end_tension_N
        found.append(
            MeasuredCondition(
                number=number,
                wheel_radius_m=summary.wheel_radius_m,
                rope_radius_m=summary.rope_radius_m,
                wrap_angle_rad=summary.wrap_angle_rad,
                wrap_std_rad=0.0,
                measured=ForceSide(symbol=symbol, quantities=(mean, *chain)),
                known=weights(other, known_N, tolerance=weights_tolerance, gravity_limit=gravity_limit),
                measures_slack=slack,
                n=len(kept),
                notes=(*notes, *more),
            )
        )
    return tuple(found)


def conditions_of_table(
    table: TrialTable, *, gravity_limit: float = GRAVITY_LIMIT
) -> tuple[MeasuredCondition, ...]:
    """Return the conditions of a trial table; its measuring chain is one line, `peak_std_N`, shared by all trials."""
    used, group, slack = table.used, table.group(), table.measures_slack
    pulls, wrap_std_rad = table.conditions(), table.wrap_std_rad[used]
    sides = [
        (table.peak_N[used], np.nan_to_num(table.peak_std_N)[used]),
        (table.end_tension_N[used], table.end_tension_std_N[used]),
    ]
    (measured_N, chain_N), (other_N, other_std_N) = reversed(sides) if slack else sides
    symbol, other = ("F_B", "F_A") if slack else ("F_A", "F_B")
    rows = [np.flatnonzero(group == label) for label in range(int(group.max(initial=-1)) + 1)]
    several = [measured_N[row] for row in rows if row.size > 1]
    pooled = _pooled_scatter([(float(N.std(ddof=1) / N.mean()), N.size - 1) for N in several])
    found = []
    for number, row in enumerate(rows, start=1):
        u_N = float(np.sqrt((chain_N[row] ** 2).mean()))
        known_N, known_std_N = float(other_N[row].mean()), float(other_std_N[row].max())
        mean, notes = _mean_force(symbol, measured_N[row], pooled)
        chain = normal("measuring chain, tare and picking", "δ_chain", "N", u_N)
        if not u_N:
            notes += ("the table gives no uncertainty of the measuring chain: it is taken as exact",)
        elif row.size > 1:
            notes += (
                "tare and picking of each trial are counted with the chain as if shared: on the safe side",
            )
        if not known_std_N:
            notes += (f"the table gives no uncertainty of {other}: only gravity is counted",)
        tolerance = RECTANGULAR * known_std_N / known_N
        found.append(
            MeasuredCondition(
                number=number,
                wheel_radius_m=float(pulls.wheel_radius_m[row[0]]),
                rope_radius_m=float(pulls.rope_radius_m[row[0]]),
                wrap_angle_rad=float(pulls.wrap_angle_rad[row[0]]),
                wrap_std_rad=float(wrap_std_rad[row].max()),
                measured=ForceSide(symbol=symbol, quantities=(mean, chain)),
                known=weights(other, known_N, tolerance=tolerance, gravity_limit=gravity_limit),
                measures_slack=slack,
                n=row.size,
                notes=notes,
            )
        )
    return tuple(found)


def state_condition(
    condition: MeasuredCondition,
    quantity: MeasuredQuantity = "force",
    *,
    u_wrap_angle_rad: float | None = None,
    gain_limit: float = 0.0,
    level: float = 0.95,
    draws: int = 200_000,
    seed: int = 0,
) -> Statement:
    """Return the uncertainty of what was measured at one condition."""
    notes = condition.notes
    if quantity == "force":
        model = force_model(condition.measured)
    elif quantity == "mu":
        u_rad = condition.wrap_std_rad if u_wrap_angle_rad is None else u_wrap_angle_rad
        if not u_rad:
            notes += (
                'the wrap is taken as exact; --u-wrap "2 deg", or u_wrap_angle_rad in Python, says otherwise',
            )
        wrap = normal("wrap angle", "φ", "rad", u_rad, estimate=condition.wrap_angle_rad)
        model = coefficient_model(condition.lift, condition.end, wrap, gain_limit=gain_limit)
    else:
        raise InputError(
            f"{quantity!r} is neither 'force' nor 'mu'", key="quantity", fix="choose one of the two"
        )
    status = BudgetStatus.OK if condition.measured.quantities[0].stated else BudgetStatus.NO_REPEATS
    return state_uncertainty(model, level=level, draws=draws, seed=seed, status=status, notes=notes)


def _left_of_scatter(summary: ConditionSummary) -> float:
    """Return what the rejection rule leaves of the scatter on average [-]."""
    return 1.0 + trimming_bias(summary.n, summary.rule).bias


def _pooled_scatter(parts: Sequence[tuple[float, int]]) -> tuple[float, float]:
    """Return the pooled relative scatter of conditions and its degrees of freedom; 0, 0 if there is none."""
    dof = sum(count for _, count in parts)
    square = math.fsum(count * scatter**2 for scatter, count in parts)
    return (math.sqrt(square / dof), float(dof)) if dof and square else (0.0, 0.0)


def _mean_force(
    symbol: str, values_N: FloatArray, pooled: tuple[float, float], ratio: float = 1.0
) -> tuple[Quantity, tuple[str, ...]]:
    """Return a mean force with its s/√n, of a single trial the scatter of the other conditions, and what was assumed."""
    mean_N, n, (relative, dof) = float(values_N.mean()), int(values_N.size), pooled
    what = ("repeatability", f"mean {symbol}", "N")
    if n > 1:
        note = f"s is divided by {ratio:.3f}, which the rejection rule leaves of it on average"
        std_N = float(values_N.std(ddof=1)) / ratio
        return repeats(*what, mean=mean_N, std=std_N, n=n), (note,) if ratio < 1.0 else ()
    note = "one trial, and no condition is repeated: the repeatability is unknown"
    if dof:
        note = f"one trial: its scatter is that of the other conditions, {100 * relative:.2g} % of the force"
    return repeats(*what, mean=mean_N, std=relative * mean_N, n=1, dof=dof or math.inf), (note,)


def _instrument(trials: Sequence[TrialResult]) -> tuple[list[Quantity], list[str]]:
    """Return the corrections of a mean force that are not made, and what is left out because it is counted already."""
    chains = [trial.calibration for trial in trials if trial.calibration is not None]
    found: list[Quantity] = []
    notes: list[str] = []
    own = "each trial has its own {} ({:.2g} N): the repeatability holds it already"
    single = len(trials) == 1
    if chains:
        worst = max(chains, key=lambda chain: chain.cell.full_scale_N)
        if any(chain.cell != worst.cell for chain in chains):
            notes.append(
                f"several force cells were used: the chain is that of the largest, {worst.cell.name}"
            )
        shared = chain_quantities(_mean(trial.measured_N for trial in trials), worst)
        # What changes from one loading to the next shows in the scatter of the trials.
        found += [item for item in shared if single or item.name != "cell's repeatability"]
        tare_N = math.sqrt(_mean(chain.tare_std_N**2 for chain in chains))
        if single or len({chain.tare_N for chain in chains}) == 1:
            found.append(Quantity(name="tare", symbol="δ_0", unit="N", estimate=0.0, stated=tare_N))
        else:
            notes.append(own.format("tare", tare_N))
        if not single and worst.cell.repeatability:
            limit_N = worst.cell.repeatability * worst.cell.full_scale_N
            notes.append(
                f"the cell's own repeatability (limit {limit_N:.2g} N) is part of that of the trials"
            )
    else:
        notes.append(
            "the recordings come in newtons without their chain: calibration and resolution are unknown"
        )
    bias_N = _mean(trial.breakaway.bias_N for trial in trials)
    found.append(limit_of_error("bias of the smoothing", "δ_sm", "N", abs(bias_N)))
    picking_N = math.sqrt(_mean(trial.breakaway.peak_std_N**2 for trial in trials))
    if single:
        found.append(Quantity(name="picking", symbol="δ_pick", unit="N", estimate=0.0, stated=picking_N))
    else:
        notes.append(own.format("peak to pick", picking_N))
    return found, notes


def _mean(values: Iterable[float]) -> float:
    numbers = [value for value in values if math.isfinite(value)]
    return math.fsum(numbers) / len(numbers) if numbers else 0.0
