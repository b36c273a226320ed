"""The uncertainty of a lift force that a fitted law predicts for a wheel known only so well."""

import math
from dataclasses import dataclass, replace

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.fitting.predict import degrees_of_freedom, new_rope_std, outside_words
from ropefric.fitting.result import FitResult
from ropefric.friction.condition import Conditions
from ropefric.friction.law import FrictionLaw
from ropefric.uncertainty.budget import MeasurementModel, effective_dof
from ropefric.uncertainty.quantity import Block, Quantity, normal
from ropefric.uncertainty.statement import BudgetStatus, Statement, state_uncertainty

_STEP = 1e-5
_SETTINGS = {
    "wheel_radius_m": ("wheel radius", "R_w", "m"),
    "rope_radius_m": ("rope radius", "R_r", "m"),
    "wrap_angle_rad": ("wrap angle", "φ", "rad"),
    "end_tension_N": ("end tension", "F_B", "N"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelUncertainty:
    """Standard uncertainties of the wheel a lift force is asked for."""

    wheel_radius_m: float = 0.0
    rope_radius_m: float = 0.0
    wrap_angle_rad: float = 0.0
    end_tension_N: float = 0.0


def lift_model(
    fit: FitResult, wheel: Conditions, uncertainty: WheelUncertainty, *, one_pull: bool = False
) -> MeasurementModel:
    """Return the measurement equation of the lift force of one wheel, F_A = exp ln F_A(θ; R_w, R_r, φ, F_B) [N]."""
    if len(wheel) != 1:
        raise InputError(
            f"{len(wheel)} wheels; a budget is of one", key="conditions", fix="ask one at a time"
        )
    law, theta = fit.friction_law, np.asarray(fit.theta)
    F_A = math.exp(float(law.log_lift(theta, wheel)[0]))
    quantities = [
        normal(name, symbol, unit, getattr(uncertainty, key), estimate=float(getattr(wheel, key)[0]))
        for key, (name, symbol, unit) in _SETTINGS.items()
    ]
    quantities += [_rope(fit)] if one_pull else []
    free = np.array([item.vary and not item.at_bound for item in fit.parameters], dtype=bool)
    names = np.array(law.parameter_names)[free]
    block = Block(
        name=f"parameters of {law.name}",
        symbols=tuple(names.tolist()),
        estimates=theta[free],
        covariance=np.asarray(fit.covariance)[np.ix_(free, free)],
        dof=degrees_of_freedom(fit),
    )
    k = len(quantities)

    def evaluate(inputs: FloatArray) -> FloatArray:
        answered = (inputs[:, :4] > 0.0).all(axis=1)
        found = np.full(len(inputs), np.nan)
        if answered.any():
            rows = inputs[answered]
            sets = np.broadcast_to(theta, (len(rows), theta.size)).copy()
            sets[:, free] = rows[:, k:]
            # As in every prediction: a draw beyond a bound of the law counts as on it.
            sets = np.clip(sets, np.minimum(law.lower, theta), np.maximum(law.upper, theta))
            at = Conditions(**dict(zip(_SETTINGS, rows.T[:4], strict=True)))
            with np.errstate(over="ignore"):
                found[answered] = np.exp(law.log_lift_of_pairs(sets, at) + rows[:, 4:k].sum(axis=1))
        return found

    by_radius, by_wrap, by_log_tension = law.log_lift_gradient_conditions(theta, wheel)[0]
    slopes = [by_radius, _by_rope(law, theta, wheel), by_wrap, by_log_tension / wheel.end_tension_N[0]]
    slopes += [1.0] * (k - 4)
    return MeasurementModel(
        name="lift force of one pull" if one_pull else "lift force",
        symbol="F_A",
        unit="N",
        quantities=tuple(quantities),
        block=block if free.any() else None,
        evaluate=evaluate,
        sensitivities=F_A * np.concatenate([slopes, law.jacobian(theta, wheel)[0, free]]),
    )


def state_lift(
    fit: FitResult,
    at: Conditions,
    uncertainty: WheelUncertainty,
    *,
    one_pull: bool = False,
    level: float = 0.95,
    draws: int = 200_000,
    seed: int = 0,
) -> Statement:
    """Return the uncertainty of the lift force that a fit predicts for a wheel known only so well."""
    return state_uncertainty(
        lift_model(fit, at, uncertainty, one_pull=one_pull),
        level=level,
        draws=draws,
        seed=seed,
        status=BudgetStatus.OK if fit.trustworthy else BudgetStatus.FIT_NOT_TRUSTED,
        notes=outside_words(fit.validity, at),
    )


def _rope(fit: FitResult) -> Quantity:
    std, found = new_rope_std(fit), fit.statistics
    if not math.isfinite(std):
        raise InputError(
            f"the fit of {fit.law} knows no scatter, so nothing can be said of one pull",
            key="one_pull",
            fix="repeat conditions, or ask for the mean law",
        )
    parts = np.nan_to_num([found.scatter_within, found.scatter_between])
    dof = effective_dof(
        parts.tolist(), [float(max(found.n - found.n_conditions, 1)), degrees_of_freedom(fit)]
    )
    return replace(normal("scatter of one new rope", "δ_rope", "-", std, dof=dof), type="A")


def _by_rope(law: FrictionLaw, theta: FloatArray, wheel: Conditions) -> float:
    """Return ∂ ln F_A/∂R_r [1/m] by central differences: no law has it in closed form."""
    R_r = wheel.rope_radius_m
    ends = [law.log_lift(theta, replace(wheel, rope_radius_m=R_r * (1.0 + s)))[0] for s in (_STEP, -_STEP)]
    return float((ends[0] - ends[1]) / (2.0 * _STEP * R_r[0]))
