"""Whole statements for the two questions asked: of a measured condition, and of a lift force that a fit predicts."""

from typing import Literal

from ropefric.errors import InputError
from ropefric.fitting.gum.forces import coefficient_model, force_model
from ropefric.fitting.gum.lift import WheelUncertainty, lift_model
from ropefric.fitting.gum.measured import MeasuredCondition
from ropefric.fitting.gum.quantity import normal
from ropefric.fitting.gum.statement import BudgetStatus, Statement, state_uncertainty
from ropefric.fitting.predict import outside_words
from ropefric.fitting.result import FitResult
from ropefric.friction.condition import Conditions

MeasuredQuantity = Literal["force", "mu"]
"""The force that was measured, or μ̄ = ln(F_A/F_B)/φ."""


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
    status = BudgetStatus.OK if condition.has_scatter else BudgetStatus.NO_REPEATS
    return state_uncertainty(model, level=level, draws=draws, seed=seed, status=status, notes=notes)


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
