"""Uncertainty budgets after the GUM: of the measured forces of an extraction, of a predicted lift force.

A measured force is the mean of its trials with what they share of the measuring chain. Of a wheel known only so well:
what its settings, and the parameters of a fitted law with their covariance, leave open of the lift force.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.fitting.fit import rope_slopes
from ropefric.fitting.predict import has_interval, outside_words
from ropefric.fitting.problem import law_named
from ropefric.fitting.result import FitResult
from ropefric.friction.condition import SETTINGS, Conditions
from ropefric.glossary import GLOSSARY
from ropefric.traces.calibration import chain_quantities
from ropefric.trials.outliers import trimming_bias
from ropefric.trials.result import Extraction, TrialResult
from ropefric.uncertainty.budget import (
    BudgetStatus,
    MeasurementModel,
    Quantity,
    Statement,
    limit_of_error,
    repeats,
    state_uncertainty,
)

_NO_CHAIN = "the recordings come in newtons without their chain: calibration and resolution are unknown"
_SETTINGS = {
    term.name: (term.meaning.partition(";")[0].lower(), term.symbol, term.unit)
    for term in map(GLOSSARY.__getitem__, SETTINGS)
}


# ---- of a measured force ----


class MeasuredForce(NamedTuple):
    """The mean force of a condition, by its number, with what is missing in its budget."""

    number: int
    model: MeasurementModel
    notes: tuple[str, ...]


def measured_forces(extraction: Extraction) -> tuple[MeasuredForce, ...]:
    """Return the mean forces of the conditions with two trials or more, with the measuring chain taken apart.

    The repeatability is s/√n of the trials kept, s divided by what the rejection rule leaves of it on average. What
    differs from trial to trial (the cell's repeatability, a tare and a picked peak of each trial's own) is part of it
    and not counted again; what all trials share (linearity, hysteresis, transmitter, calibration line, resolution,
    bias of the smoothing) does not average out and is.
    """
    by_name = {trial.trial: trial for trial in extraction.trials if trial.kept}
    found = []
    for number, one in enumerate(extraction.conditions, start=1):
        kept = [by_name[name] for name in one.trials if name in by_name]
        if len(kept) < 2:
            continue
        values_N, (shared, notes) = np.array([trial.measured_N for trial in kept]), _shared(kept)
        if (ratio := 1.0 + trimming_bias(one.n, one.rule)) < 1.0:
            notes.insert(0, f"s is divided by {ratio:.3f}, which the rejection rule leaves of it on average")
        symbol = "F_B" if kept[0].measures_slack else "F_A"
        mean = repeats(
            "repeatability", f"mean {symbol}", "N",
            mean=float(values_N.mean()), std=float(values_N.std(ddof=1)) / ratio, n=values_N.size,
        )  # fmt: skip
        quantities = (mean, *shared)
        model = MeasurementModel("force", symbol, "N", quantities, _sum, np.ones(len(quantities)))
        found.append(MeasuredForce(number, model, tuple(notes)))
    return tuple(found)


def _sum(inputs: FloatArray) -> FloatArray:
    return np.asarray(inputs.sum(axis=1))


def _shared(trials: Sequence[TrialResult]) -> tuple[list[Quantity], list[str]]:
    """Return the corrections of a mean force that are not made, of what its trials share, and notes."""
    bias_N = _mean(trial.breakaway.bias_N for trial in trials)
    smoothing = limit_of_error("bias of the smoothing", "δ_sm", "N", abs(bias_N))
    chains = [trial.calibration for trial in trials if trial.calibration is not None]
    if not chains:
        return [smoothing], [_NO_CHAIN]
    worst = max(chains, key=lambda chain: chain.cell.full_scale_N)
    notes = []
    if any(chain.cell != worst.cell for chain in chains):
        notes.append(f"several force cells were used: the chain is that of the largest, {worst.cell.name}")
    found = [
        item
        for item in chain_quantities(_mean(trial.measured_N for trial in trials), worst)
        if item.name != "cell's repeatability"
    ]
    if len({chain.tare_N for chain in chains}) == 1:
        tare_N = math.sqrt(_mean(chain.tare_std_N**2 for chain in chains))
        found.append(Quantity("tare", "δ_0", "N", tare_N))
    return [*found, smoothing], notes


def _mean(values: Iterable[float]) -> float:
    numbers = [value for value in values if math.isfinite(value)]
    return math.fsum(numbers) / len(numbers) if numbers else 0.0


# ---- of a predicted lift force ----


@dataclass(frozen=True, slots=True, eq=False)
class _LiftForce:
    """F_A of draws of all quantities, a class because figures of a budget are drawn in other processes.

    Columns: the four settings, then what changes ln F_A by `slopes`. The law is one of these. Its parameters are not
    drawn: in the curved valley of a law that the data hardly determine their covariance is none of the forces, while
    ln F_A is as straight as its interval takes it to be.
    """

    law: str
    theta: FloatArray
    slopes: FloatArray

    def __call__(self, inputs: FloatArray) -> FloatArray:
        """Return F_A [N], shape (n,); NaN where a setting is no setting."""
        answered = (inputs[:, :4] > 0.0).all(axis=1)
        found = np.full(len(inputs), np.nan)
        if answered.any():
            rows = inputs[answered]
            at = Conditions(**dict(zip(_SETTINGS, rows.T[:4], strict=True)))
            with np.errstate(over="ignore"):
                found[answered] = np.exp(
                    law_named(self.law).log_lift(self.theta, at) + rows[:, 4:] @ self.slopes
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
    law, theta = fit.friction_law, fit.theta
    F_A = math.exp(float(law.log_lift(theta, wheel)[0]))
    quantities = [
        Quantity(*words, wheel_std.get(key, 0.0), estimate=float(getattr(wheel, key)[0]))
        for key, words in _SETTINGS.items()
    ]
    if one_pull:
        if not fit.scatter.of_pulls:
            text = f"the fit of {fit.law} knows no scatter, so one pull has no interval"
            raise InputError(text, key="one_pull", fix="repeat conditions, or request the mean law")
        # What one pull brings beside the law: a new rope by its rise, a condition, a repeat.
        of_pull = fit.scatter.one_pull(np.log([F_A]), np.log(F_A / wheel.end_tension_N))
        ((variance,), (dof,)) = fit.scatter.integrated(np.zeros((1, theta.size)), of_pull)
        new = math.sqrt(variance)
        quantities.append(Quantity("scatter of one new rope", "δ_rope", "-", new, dof=float(dof), type="A"))
    slopes = [1.0] * (len(quantities) - 4)
    # Known by their own uncertainty, and a line each: what many conditions have in common.
    of_law, free = law.jacobian(theta, wheel), fit.shown
    quantities += [Quantity(item.name, "δ", item.unit, item.std) for item in fit.common_errors]
    common = fit.common_changes / [item.std for item in fit.common_errors]
    slopes += (of_law @ common)[0].tolist()
    if free.any():
        own = fit.covariance - fit.common_changes @ fit.common_changes.T
        averaged = fit.scatter.integrated(of_law)[0] if fit.scatter.mixtures else (of_law @ own @ of_law.T)[0]
        if not math.isfinite(variance := float(averaged[0])):
            text = f"the covariance of {law.name} is not finite, so the data do not show all parameters"
            fix = "measure the conditions that would show them, or fit a simpler law"
            raise InputError(text, key=law.name, fix=fix)
        dof = float(fit.scatter.dof(of_law)[0]) if has_interval(fit) else 1.0
        known: dict[str, Any] = {"dof": dof, "type": "A", "parameters": int(free.sum())}
        quantities.append(
            Quantity(f"parameters of {law.name}", "δ_law", "-", math.sqrt(max(variance, 0.0)), **known)
        )
        slopes.append(1.0)
    by_radius, by_wrap, by_log_tension = law.log_lift_gradient_conditions(theta, wheel)[0]
    by_rope = float(rope_slopes(law, theta, wheel)[0])
    by_all = F_A * np.array([by_radius, by_rope, by_wrap, by_log_tension / wheel.end_tension_N[0], *slopes])
    evaluate = _LiftForce(fit.law, theta, np.array(slopes))
    name = "lift force of one pull" if one_pull else "lift force"
    return MeasurementModel(name, "F_A", "N", tuple(quantities), evaluate, by_all)


def state_lift(
    fit: FitResult, at: Conditions, wheel_std: Mapping[str, float], *, one_pull: bool = False, **check: Any
) -> Statement:
    """Return the uncertainty of the lift force that a fit predicts for a wheel known only so well."""
    status = BudgetStatus.OK if fit.verdict_on(at).supported else BudgetStatus.FIT_NOT_TRUSTED
    model, notes = lift_model(fit, at, wheel_std, one_pull=one_pull), outside_words(fit.validity, at)
    if not has_interval(fit):
        notes += (
            "the fit gives no interval: of its parameters only the scatter of repeats is counted, as of 1 dof",
        )
    if one_pull and math.isfinite(fit.scatter.tail_dof):
        notes += ("repeats have heavier tails than this budget assumes: use the interval of `predict`",)
    return state_uncertainty(model, status=status, notes=notes, **check)
